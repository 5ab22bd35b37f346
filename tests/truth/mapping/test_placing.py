"""Placing photos: poses and points against those that made the matches."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from limbgram.core.errors import Cancelled, PlacementError
from limbgram.core.geometry.frames import Rigid, Similarity, angle_between_deg, fit_similarity
from limbgram.core.run import Run
from limbgram.findings import told
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.mapping.placement import MappingOptions, place
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.twoview.pairs import Pairs
from limbgram.reconstruction.twoview.verification import verify


def placed(
    capture: Any, options: MappingOptions | None = None, pairs: Pairs | None = None
) -> Scene:
    pairs = pairs or verify(capture.photos, capture.matches, capture.cameras)
    return place(
        capture.photos, capture.features, pairs, capture.cameras, options or MappingOptions()
    )


def mm_from_scene(scene: Scene, capture: Any) -> Similarity:
    centres = np.array([view.centre_in_world for view in scene.views])
    return fit_similarity(
        centres, np.array([capture.views[k].centre_in_world for k in scene.placed])
    )


def centre_rms_mm(scene: Scene, capture: Any) -> float:
    centres = np.array([view.centre_in_world for view in scene.views])
    truth = np.array([capture.views[k].centre_in_world for k in scene.placed])
    error = mm_from_scene(scene, capture).apply(centres) - truth
    return float(np.sqrt(np.mean(np.sum(error**2, axis=1))))


def mean_turn_deg(scene: Scene, capture: Any) -> float:
    moved = scene.moved(mm_from_scene(scene, capture))
    turns = [
        angle_between_deg(
            view.camera_from_world.rotation, capture.views[k].camera_from_world.rotation
        )
        for k, view in zip(moved.placed, moved.views)
    ]
    return float(np.mean(turns))


@pytest.fixture(scope="module")
def good_pairs(good_capture: Any) -> Pairs:
    return verify(good_capture.photos, good_capture.matches, good_capture.cameras)


@pytest.fixture(scope="module")
def good_scene(good_capture: Any, good_pairs: Pairs) -> Scene:
    return placed(good_capture, MappingOptions(board_lenses="hold"), good_pairs)


def test_all_photos_are_placed_where_they_were_taken(good_scene: Scene, good_capture: Any) -> None:
    assert len(good_scene.placed) == len(good_capture.views)
    # 0.83 +/- 0.13 mm is the statistical limit of these matches with noise of 0.3 px
    assert 0.3 < centre_rms_mm(good_scene, good_capture) < 1.2
    assert 0.005 < mean_turn_deg(good_scene, good_capture) < 0.06


def test_points_lie_where_they_were(good_scene: Scene, good_capture: Any) -> None:
    found = mm_from_scene(good_scene, good_capture).apply(good_scene.points_in_world)
    assert len(found) > 0.7 * len(good_capture.points_mm)
    distance = np.linalg.norm(found[:, None] - good_capture.points_mm[None], axis=2).min(1)
    assert 0.01 < np.median(distance) < 0.15
    assert np.quantile(distance, 0.99) < 0.6


def test_noise_is_measured(good_scene: Scene) -> None:
    assert good_scene.sigma_px == pytest.approx(0.3, rel=0.1)
    residuals = good_scene.residuals_px()
    assert not np.isnan(residuals).any()
    assert 0.2 < np.sqrt(np.mean(residuals**2)) < 0.32
    # no half pixel got lost on the way through the mapper
    assert np.abs(residuals.mean(0)).max() < 0.02


def test_every_photo_has_a_verdict_and_the_ring_closes(good_scene: Scene) -> None:
    assert [verdict.name for verdict in good_scene.verdicts] == list(good_scene.names)
    assert all(verdict.placed and not verdict.reason for verdict in good_scene.verdicts)
    assert all(verdict.points > 100 for verdict in good_scene.verdicts)
    assert all(0.2 < verdict.rms_px < 0.5 for verdict in good_scene.verdicts)
    assert good_scene.ring is not None
    assert good_scene.ring.closed
    assert 25.0 < good_scene.ring.largest_gap_deg < 40.0


def test_the_same_input_gives_the_same_bytes(make_capture: Callable[..., Any]) -> None:
    capture = make_capture(photos=8, points=600)
    first, second = placed(capture), placed(capture)
    np.testing.assert_array_equal(first.points_in_world, second.points_in_world)
    np.testing.assert_array_equal(first.observations.xy_px, second.observations.xy_px)
    assert [view.packed.tobytes() for view in first.views] == [
        view.packed.tobytes() for view in second.views
    ]


@pytest.mark.slow
def test_a_principal_point_off_by_its_sigma_comes_back(
    make_capture: Callable[..., Any], good_capture: Any
) -> None:
    truth = good_capture.cameras.calibrations[0].camera
    wrong = replace(truth, cx=truth.cx + 3.0, cy=truth.cy - 3.0)
    off = make_capture(calibrated_as=wrong, noise_px=0.05, wrong=0.05)
    refined = placed(off)
    # upright photos round an upright limb tell cx, while cy goes with the tilt of all cameras
    assert abs(refined.cameras[0].cx - truth.cx) < 1.5  # from 3 px
    assert abs(refined.cameras[0].cy - truth.cy) < 3.0
    assert refined.lens_covariance is not None
    sigmas = np.sqrt(np.diag(refined.lens_covariance[0]))
    prior = off.cameras.calibrations[0].sigmas
    assert (sigmas <= prior * 1.001).all()
    assert sigmas[2] < 0.7 * prior[2]
    moved = np.abs(refined.cameras[0].packed - truth.packed)[prior > 0]
    assert (moved < 4 * sigmas[prior > 0]).all()
    held = placed(off, MappingOptions(board_lenses="hold"))
    assert held.cameras[0] == off.cameras.calibrations[0].camera
    assert mean_turn_deg(refined, off) < mean_turn_deg(held, off)


def test_an_exif_focal_length_is_put_right(good_capture: Any) -> None:
    truth = good_capture.cameras.calibrations[0].camera
    guess = replace(
        truth,
        fx=1.03 * truth.fx,
        fy=1.03 * truth.fx,
        cx=1199.5,
        cy=799.5,
        k1=0.0,
        k2=0.0,
        p1=0.0,
        p2=0.0,
    )
    sigmas = np.array([200.0, 200.0, 15.0, 15.0, 0.0, 0.1, 0.2, 1e-3, 1e-3, 0.0])
    covariance = np.diag(sigmas**2)
    covariance[0, 1] = covariance[1, 0] = 200.0**2 * (1 - 1e-5)
    exif = Calibration(camera=guess, covariance=covariance, source="exif")
    scene = placed(replace(good_capture, cameras=Cameras((exif,))))
    assert len(scene.placed) == len(good_capture.views)
    assert scene.cameras[0].fx / truth.fx == pytest.approx(1.0, abs=0.01)  # from 0.03
    assert centre_rms_mm(scene, good_capture) < 1.5


def test_skew_passes_the_mapper(make_capture: Callable[..., Any], good_capture: Any) -> None:
    truth = good_capture.cameras.calibrations[0].camera
    skewed = replace(truth, skew=20.0)
    capture = make_capture(photos=8, points=800, noise_px=0.0, wrong=0.0)
    features = replace(
        capture.features,
        keypoints=tuple(
            replace(keypoints, xy_px=with_skew(truth, keypoints.xy_px, 20.0))
            for keypoints in capture.features.keypoints
        ),
    )
    pairs = tuple(
        replace(
            pair,
            xy_first_px=features.keypoints[pair.first].xy_px[pair.keypoint_idx[:, 0]].astype(float),
            xy_second_px=features.keypoints[pair.second]
            .xy_px[pair.keypoint_idx[:, 1]]
            .astype(float),
        )
        for pair in capture.matches.pairs
    )
    given = Cameras((replace(capture.cameras.calibrations[0], camera=skewed),))
    capture = replace(
        capture, features=features, matches=replace(capture.matches, pairs=pairs), cameras=given
    )
    scene = placed(capture, MappingOptions(board_lenses="hold"))
    assert len(scene.placed) == 8
    assert np.abs(scene.residuals_px()).max() < 0.01
    assert centre_rms_mm(scene, capture) < 0.01


def with_skew(lens: Any, xy_px: np.ndarray, skew: float) -> np.ndarray:
    moved = xy_px.astype(float)
    moved[:, 0] += skew * (moved[:, 1] - lens.cy) / lens.fy
    return moved.astype(np.float32)


def test_a_photo_without_links_is_named_with_advice(make_capture: Callable[..., Any]) -> None:
    scene = placed(make_capture(photos=10, points=800, unlinked=(4,)))
    assert len(scene.placed) == 9
    verdict = scene.verdicts[4]
    assert not verdict.placed
    assert verdict.points == 0
    assert "20 degrees" in told(verdict.reason)
    assert scene.ring is not None
    assert scene.ring.largest_gap_deg > 60.0
    assert not scene.ring.closed


def test_no_pairs_refuse_with_advice(good_capture: Any) -> None:
    with pytest.raises(PlacementError, match="No two photos"):
        place(good_capture.photos, good_capture.features, Pairs((), 10), good_capture.cameras)


def test_half_a_ring_is_refused_by_name(make_capture: Callable[..., Any]) -> None:
    lost = tuple(range(4, 10))
    with pytest.raises(PlacementError, match=r"Only \d of 10 .*IMG_0005"):
        placed(make_capture(photos=10, points=800, unlinked=lost))


def test_the_mapper_tells_its_progress_and_stops_when_asked(
    good_capture: Any, good_pairs: Pairs
) -> None:
    steps: list[int] = []

    def listen(_stage: str, done: int, _total: int) -> None:
        steps.append(done)
        if done == 5:
            run.cancel()

    run = Run(listen)
    with pytest.raises(Cancelled):
        run(place, good_capture.photos, good_capture.features, good_pairs, good_capture.cameras)
    assert steps[-1] == 5


def test_a_photo_that_contradicts_its_pairs_is_not_placed(
    make_capture: Callable[..., Any],
) -> None:
    """Pairs that claim another turn than the scene has: the guard against a folded scene."""
    capture = make_capture(photos=9, points=700)
    pairs = verify(capture.photos, capture.matches, capture.cameras)
    quarter = Rigid.from_rotation_vector(np.array([0.0, 1.5, 0.0]), np.zeros(3))
    lying = tuple(
        replace(pair, second_from_first=quarter @ pair.second_from_first)
        if 2 in (pair.matches.first, pair.matches.second) and pair.second_from_first
        else pair
        for pair in pairs.verified
    )
    scene = place(capture.photos, capture.features, Pairs(lying, 0), capture.cameras)
    assert [verdict.name for verdict in scene.verdicts if not verdict.placed] == ["IMG_0002.jpg"]
    assert "contradicts" in told(scene.verdicts[2].reason)
