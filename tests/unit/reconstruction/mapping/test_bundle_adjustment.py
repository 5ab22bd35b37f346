"""Adjustment: known scenes come back, priors hold what they know, and errors are as told."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid, fit_similarity
from limbgram.core.geometry.lens import PARAMETERS, Camera, with_pose_step
from limbgram.reconstruction.calibration.cameras import Calibration, from_exif
from limbgram.reconstruction.mapping.bundle import Bundle
from limbgram.reconstruction.mapping.bundle_adjustment import UnconstrainedPhotos, adjust
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.photos.photo import CameraGroup, Exif

MakeScene = Callable[..., Scene]
LENS = Camera(width_px=900, height_px=900, fx=1500.0, fy=1500.0, cx=450.0, cy=450.0)


def calibrated(camera: Camera, **sigmas: float) -> Calibration:
    """Known to the sigmas given, the rest exactly."""
    variance = np.array([sigmas.get(name, 0.0) ** 2 for name in PARAMETERS])
    return Calibration(
        label="", source="board", camera=camera, covariance=np.diag(variance), rms_px=0.1
    )


def shaken(scene: Scene, seed: int) -> Scene:
    """Poses and points beside the truth: turns of 0.3 degrees, shifts of 2, points 1 off."""
    random, bundle = np.random.default_rng(seed), Bundle.of(scene)
    views = [
        with_pose_step(view, np.concatenate([random.normal(0, 5e-3, 3), random.normal(0, 2, 3)]))
        for view in bundle.views
    ]
    points = bundle.points + random.normal(0, 1, bundle.points.shape)
    return replace(bundle, views=np.array(views), points=points).scene(scene)


def centre_errors(found: Scene, true: Scene) -> np.ndarray:
    """After the similarity that fits the centres best."""
    ours, theirs = (np.array([v.centre_in_world for v in s.views]) for s in (found, true))
    return fit_similarity(ours, theirs).apply(ours) - theirs


def test_exact_measurements_give_the_exact_scene(make_scene: MakeScene) -> None:
    true = make_scene(photos=7, points=40)
    known = [calibrated(camera) for camera in true.cameras]
    adjusted = adjust(shaken(true, 1), known, rounds=4)
    assert np.abs(centre_errors(shaken(true, 1), true)).max() > 1
    assert np.abs(centre_errors(adjusted.scene, true)).max() < 1e-5
    assert np.abs(adjusted.scene.residuals_px()).max() < 1e-5
    assert len(adjusted.scene.observations.xy_px) == len(true.observations.xy_px)
    assert adjusted.scene.cameras == true.cameras, "lenses known exactly are held"


def test_a_wrong_focal_length_is_put_right_where_it_may_move(make_scene: MakeScene) -> None:
    true = make_scene(photos=7, points=60, lenses=(LENS,))
    wrong = replace(LENS, fx=1520.0, fy=1520.0)
    start = shaken(replace(true, cameras=(wrong,)), 2)
    free = adjust(start, [calibrated(wrong, fx=50.0, fy=50.0)], rounds=4).scene.cameras[0]
    np.testing.assert_allclose([free.fx, free.fy], 1500.0, atol=0.05)
    assert free.cx == LENS.cx
    held = adjust(start, [calibrated(wrong, fx=50.0, fy=50.0)], hold_board_lenses=True)
    assert held.scene.cameras[0] == wrong
    assert not held.lens_covariance.any()


def test_a_photo_without_observations_is_not_solved_for(make_scene: MakeScene) -> None:
    true = make_scene(points=40)
    seen = true.observations
    others = seen.photo_idx != 2
    bare = Observations(seen.photo_idx[others], seen.point_idx[others], seen.xy_px[others])
    with pytest.raises(UnconstrainedPhotos) as lost:
        adjust(replace(true, observations=bare), tuple(calibrated(one) for one in true.cameras))
    assert lost.value.photos == (2,)


def test_wrong_measurements_are_dropped_and_do_no_harm(make_scene: MakeScene) -> None:
    true = make_scene(photos=8, points=80, noise_px=0.2, share=0.9, lenses=(LENS,))
    random, seen = np.random.default_rng(4), true.observations
    wrong = random.random(len(seen.xy_px)) < 0.05
    aside = random.uniform(5, 50, seen.xy_px.shape) * random.choice([-1, 1], seen.xy_px.shape)
    xy = seen.xy_px + np.where(wrong[:, None], aside, 0)
    start = replace(true, observations=Observations(seen.photo_idx, seen.point_idx, xy))
    adjusted = adjust(shaken(start, 4), [calibrated(LENS)])
    left = {tuple(row) for row in adjusted.scene.observations.xy_px.tolist()}
    assert not left & {tuple(row) for row in xy[wrong].tolist()}
    assert len(left) > 0.9 * (~wrong).sum()
    assert 0.17 < adjusted.sigma_px < 0.23
    clean = adjust(shaken(true, 4), [calibrated(LENS)])
    with_wrong, without = (centre_errors(one.scene, true).std() for one in (adjusted, clean))
    assert 0.05 < with_wrong < 1.7 * without


def test_points_that_a_burst_alone_shows_do_no_harm(make_scene: MakeScene) -> None:
    """Photos of one place share hundreds of points, and nothing tells how far away these are."""
    true = make_scene(photos=7, points=40, lenses=(LENS,))
    random = np.random.default_rng(4)
    turn = np.concatenate([np.radians([0.1, -0.2, 0.1]), np.zeros(3)])
    again = with_pose_step(Bundle.of(true).views[0], turn)
    poses = (*true.camera_from_world, Rigid(again[:9].reshape(3, 3), again[9:12]))
    burst = replace(
        true,
        names=(*true.names, "7.jpg"),
        camera_idx=(*true.camera_idx, 0),
        camera_from_world=poses,
    )
    depths = 600.0 * 10.0 ** random.uniform(-0.5, 3, 400)  # anything fits
    flat = random.uniform(-0.25, 0.25, (400, 2))
    beside = burst.view(0).camera_from_world.inverse.apply(
        depths[:, None] * np.column_stack([flat, np.ones(400)])
    )
    points = np.concatenate([true.points_in_world, beside])
    rows = [(true.observations.photo_idx, true.observations.point_idx, true.observations.xy_px)]
    for photo, shown in ((0, np.arange(40, 440)), (7, np.arange(440))):
        xy = burst.view(photo).project(points[shown])
        xy += random.normal(0.0, 0.02, xy.shape)
        rows.append((np.full(len(shown), photo, np.int32), shown.astype(np.int32), xy))
    seen = Observations(*(np.concatenate(column) for column in zip(*rows, strict=True)))
    start = shaken(replace(burst, points_in_world=points, observations=seen), 5)
    adjusted = adjust(start, [calibrated(LENS)], rounds=4)
    assert np.abs(centre_errors(adjusted.scene, burst)).max() < 0.05
    assert 35 < len(adjusted.scene.points_in_world) <= 40


def test_a_prior_weighs_as_its_covariance_says(make_scene: MakeScene) -> None:
    """A focal length that photos hardly show goes to its calibration, and is known as well."""
    true = make_scene(photos=4, points=12, noise_px=1.0, lenses=(LENS,))
    beside = replace(true, cameras=(replace(LENS, fx=LENS.fx + 1),))
    tight = adjust(shaken(beside, 5), [calibrated(LENS, fx=0.01)])
    assert abs(tight.scene.cameras[0].fx - LENS.fx) < 0.02
    sigma = float(np.sqrt(tight.lens_covariance[0, 0, 0]))
    assert 0.009 < sigma <= 0.01 * (1 + 1e-9)
    assert np.count_nonzero(tight.lens_covariance) == 1


def test_focal_lengths_scatter_as_their_covariance_says(make_scene: MakeScene) -> None:
    """Nine neighbours err as one, which the adjustment takes for granted."""
    alike, errors, told = 9, [], []
    for seed in range(14):
        scene = make_scene(photos=6, points=40, noise_px=0.3, share=1.0, seed=seed, lenses=(LENS,))
        seen, count = scene.observations, len(scene.points_in_world)
        many = replace(
            scene,
            points_in_world=np.tile(scene.points_in_world, (alike, 1)),
            observations=Observations(
                np.tile(seen.photo_idx, alike),
                np.concatenate([seen.point_idx + np.int32(k * count) for k in range(alike)]),
                np.tile(seen.xy_px, (alike, 1)),
            ),
        )
        adjusted = adjust(many, [calibrated(LENS, fx=100.0, fy=100.0)], outlier_sigmas=6.0)
        errors.append(adjusted.scene.cameras[0].fx - LENS.fx)
        told.append(np.sqrt(adjusted.lens_covariance[0, 0, 0]))
    assert max(told) < 10, "the photos told more than the prior"
    assert 0.5 < np.sqrt(np.mean(np.square(errors))) / np.mean(told) < 1.6


PRIOR_SPREAD = Camera(width_px=900, height_px=900, fx=800.0, fy=800.0, cx=449.5, cy=449.5)
"""As a phone's: its corners are 0.79 from the axis. The made-up points reach 0.45."""
CORNERS = np.array([[0.0, 0.0], [899.0, 0.0], [0.0, 899.0], [899.0, 899.0]])


@pytest.mark.parametrize(
    ("radial", "folds"),
    [
        ({"k2": -0.58}, True),
        ({"k1": 0.2, "k2": -1.2}, True),
        ({"k1": -0.4}, True),
        ({"k1": -0.15, "k2": 0.03}, False),
        ({"k1": 0.1}, False),
    ],
)
def test_a_lens_found_without_a_board_shows_its_whole_picture(
    radial: dict[str, float], folds: bool, make_scene: MakeScene
) -> None:
    """Points in mid-frame ask for one whose corners have no ray; sound lenses come back."""
    size = CameraGroup(label="", width_px=900, height_px=900, exif=Exif(focal_35mm=36.0))
    guess = from_exif(size)
    true = make_scene(photos=8, points=80, lenses=(replace(PRIOR_SPREAD, **radial),), spread=60.0)
    start = shaken(replace(true, cameras=(guess.camera,)), 3)
    adjusted = adjust(start, [guess], rounds=4)
    lens = adjusted.scene.cameras[0]
    rays = lens.normalize(CORNERS)
    back_px = lens.project(np.column_stack([rays, np.ones(4)]))
    np.testing.assert_allclose(back_px, CORNERS, atol=0.5)
    if not folds:
        assert lens.k1 == pytest.approx(radial.get("k1", 0.0), abs=0.01)
    off = np.linalg.norm(centre_errors(adjusted.scene, true), axis=1)
    assert off.max() < (0.3 if folds else 0.02), "of 600"


@pytest.mark.parametrize(
    "radial",
    [
        {"k1": 0.2, "k2": -1.2},
        *(pytest.param(one, marks=pytest.mark.slow) for one in ({"k2": -0.58}, {"k1": -0.4})),
    ],
)
def test_a_check_on_small_copies_finds_the_lens_that_a_reconstruction_finds(
    radial: dict[str, float], make_scene: MakeScene
) -> None:
    """Whoever checks asks the adjustment of copies of half the size; each lens wants to fold."""
    size = CameraGroup(label="", width_px=900, height_px=900, exif=Exif(focal_35mm=36.0))
    copies = replace(size, width_px=450, height_px=450, file_px=(900, 900))
    true = make_scene(photos=8, points=80, lenses=(replace(PRIOR_SPREAD, **radial),), spread=60.0)
    seen = true.observations
    halved = replace(seen, xy_px=(seen.xy_px + 0.5) / 2 - 0.5)
    found: list[Scene] = []
    for group, observed in ((size, seen), (copies, halved)):
        guess = from_exif(group)
        start = replace(true, cameras=(guess.camera,), observations=observed)
        found.append(adjust(shaken(start, 3), [guess], rounds=8).scene)
    (large,), (small,) = (one.cameras for one in found)
    assert small.fx == pytest.approx(large.fx / 2, rel=1e-3)
    assert (small.k1, small.k2) == pytest.approx((large.k1, large.k2), abs=2e-3)
    rays = np.column_stack([large.normalize(CORNERS), np.ones(4)])
    np.testing.assert_allclose(large.project(rays), CORNERS, atol=0.5)
    np.testing.assert_allclose(small.project(rays), (CORNERS + 0.5) / 2 - 0.5, atol=0.5)
    assert np.abs(centre_errors(found[1], found[0])).max() < 0.02, "of 600"
