"""The board in the last adjustment, against a room whose measures are known."""

from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.geometry.frames import fit_similarity
from limbgram.core.geometry.lens import LENS_SIZE, Camera
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.mapping.body import Body
from limbgram.reconstruction.mapping.bundle import Bundle
from limbgram.reconstruction.mapping.bundle_adjustment import adjust
from limbgram.reconstruction.mapping.scene import Explanation, Observations, Scene
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.scale.scaling import to_millimetres
from limbgram.reconstruction.targets.board import BoardDetections

TIE_PX, CORNER_PX = 0.3, 0.03
RAYS = 4
ALIKE = 9
"""Neighbours that err as one: what the adjustment takes residuals for (3 sigmas, squared)."""


def calibrated(lens: Camera, sigma_px: float = 0.1) -> Cameras:
    sigmas = np.zeros(10)
    sigmas[:4] = sigma_px
    covariance = np.diag(sigmas**2)
    return Cameras((Calibration(camera=lens, covariance=covariance, source="board"),))


def measured(capture, seed: int = 0, alike: int = 1) -> Scene:
    """The capture's scene with spots that four neighbouring photos show, adjusted without board.

    alike: spots in a bunch, which err as one.
    """
    draw = np.random.default_rng(seed)
    scene, photos = capture.scene, len(capture.room_views)
    kept = draw.permutation(len(scene.points_in_world))[:300]
    scene = replace(scene, points_in_world=scene.points_in_world[kept])
    point = np.repeat(np.arange(len(kept), dtype=np.int32), RAYS)
    photo = (point + np.tile(np.arange(RAYS), len(kept))).astype(np.int32) % photos
    xy = np.empty((len(photo), 2))
    for k in range(photos):
        xy[photo == k] = scene.view(k).project(scene.points_in_world[point[photo == k]])
    xy += draw.normal(scale=TIE_PX, size=xy.shape)
    scene = replace(
        scene,
        points_in_world=np.tile(scene.points_in_world, (alike, 1)),
        observations=Observations(
            np.tile(photo, alike),
            np.concatenate([point + len(kept) * k for k in range(alike)]).astype(np.int32),
            np.tile(xy, (alike, 1)),
        ),
    )
    return alone(scene, calibrated(scene.cameras[0]))


def alone(scene: Scene, cameras: Cameras) -> Scene:
    found = adjust(scene, cameras.calibrations, outlier_sigmas=np.inf)
    return replace(
        found.scene, lens_covariance=found.lens_covariance, camera_covariance=found.covariance
    )


def joined(scene: Scene, detections: BoardDetections) -> MetricScene:
    return to_millimetres(scene, detections, cameras=calibrated(scene.cameras[0]))


def against_room(scene: Scene, capture) -> tuple[float, float]:
    """Scale less one, and RMS of the centres after the best similarity (mm)."""
    centres = np.array([view.centre_in_world for view in scene.views])
    truth = np.array([view.centre_in_world for view in capture.room_views])
    room_from_scene = fit_similarity(centres, truth)
    off = np.linalg.norm(room_from_scene.apply(centres) - truth, axis=1)
    return 1 / room_from_scene.scale - 1, float(np.sqrt(np.mean(off**2)))


def test_scale_comes_back_within_its_sigma_and_photos_stand_better(capture) -> None:
    ratios, gains = [], []
    for seed in range(4):
        scene, detections = measured(capture, seed, ALIKE), capture.detections(CORNER_PX, seed)
        before, after = to_millimetres(scene, detections), joined(scene, detections)
        error, rms_mm = against_room(after.scene, capture)
        covariance, slopes = after.scene.camera_covariance, after.scale.by_cameras
        assert covariance is not None
        assert slopes is not None
        sigma = np.sqrt(after.scale.relative_sigma**2 + slopes @ covariance @ slopes)
        assert 5e-6 < sigma < 3e-4
        ratios.append(error / sigma)
        gains.append(rms_mm / against_room(before.scene, capture)[1])
        assert before.scene.camera_covariance is not None
        assert np.trace(covariance[:72, :72]) < np.trace(before.scene.camera_covariance[:72, :72])
    assert 0.2 < np.sqrt(np.mean(np.square(ratios))) < 1.8
    assert 0.2 < np.mean(gains) < 0.9
    assert max(gains) < 1.05


def test_what_is_known_in_the_scenes_unit_stays_so(capture) -> None:
    """Nothing but the first guess holds the size of a scene that is adjusted."""
    scene, detections = measured(capture), capture.detections(CORNER_PX)
    centres = np.array([view.centre_in_world for view in scene.views])
    truth = np.array([view.centre_in_world for view in capture.room_views])
    mm = 1.0 / fit_similarity(centres, truth).scale
    moved = Explanation(
        bodies="limb and room", kind="step", photos=(0,), numbers=6, score=90.0, chance=1e-9,
        effect=3.0 * mm, low=2.0 * mm, high=4.0 * mm, variance_before=9.0, variance_after=1.0,
    )  # fmt: skip
    metric = joined(replace(scene, lens_explanations=(moved,)), detections)
    (told,) = metric.scene.lens_explanations
    assert told.effect == pytest.approx(3.0, rel=1e-3)


def test_wrong_corners_do_not_move_the_photos(capture) -> None:
    scene, detections = measured(capture), capture.detections(CORNER_PX)
    photos = list(detections.photos)
    for k, off_px in ((1, 8.0), (4, 1.5), (7, 0.25)):  # the last is too small to be found out
        xy = photos[k].xy_px.copy()
        xy[0] += off_px
        photos[k] = replace(photos[k], xy_px=xy)
    clean = against_room(joined(scene, detections).scene, capture)
    wrong = against_room(joined(scene, replace(detections, photos=tuple(photos))).scene, capture)
    assert abs(wrong[0] - clean[0]) < 2e-5
    assert abs(wrong[1] - clean[1]) < 0.1 * clean[1]


def test_check_lengths_stay_out(capture) -> None:
    """Checking corners printed 0.05 % too far apart are found too long and change nothing else."""
    scene, detections = measured(capture), capture.detections(CORNER_PX)
    ids = np.arange(len(detections.corners_mm))
    across = detections.board.inner[0]
    checking = (ids // across + ids % across) % 2 == 1
    centre = detections.corners_mm.mean(0)
    described = detections.corners_mm.copy()
    described[checking] += (centre - described[checking]) * 5e-4
    told = joined(scene, replace(detections, corners_mm=described))
    true = joined(scene, detections)
    assert abs(against_room(told.scene, capture)[0] - against_room(true.scene, capture)[0]) < 5e-6
    for one, other in zip(told.scale.lengths, true.scale.lengths, strict=True):
        longer = 5e-4 if one.role == "check" else 0.0
        assert one.error - other.error == pytest.approx(longer, abs=2e-5)


def test_a_bent_board_does_not_bend_the_ring(capture) -> None:
    scene, detections = measured(capture), capture.detections()
    bow_mm = 0.4 * np.sin(detections.corners_mm[:, :1] / 40.0) * np.array([0.0, 0.0, 1.0])
    described = replace(detections, corners_mm=detections.corners_mm + bow_mm)
    flat = against_room(joined(scene, detections).scene, capture)[1]
    bent = against_room(joined(scene, described).scene, capture)[1]
    without = against_room(to_millimetres(scene, detections).scene, capture)[1]
    assert flat < bent < without


@pytest.mark.parametrize(("sigma_px", "least", "most"), [(0.01, 9.9, 10.1), (40.0, -4.0, 4.0)])
def test_the_calibration_s_covariance_says_how_far_a_lens_may_move(
    capture, sigma_px: float, least: float, most: float
) -> None:
    """Calibrated 10 px too long: a sure calibration keeps that, an unsure one gives way."""
    lens = capture.scene.cameras[0]
    long = replace(lens, fx=lens.fx + 10.0, fy=lens.fy + 10.0)
    scene = replace(measured(capture), cameras=(long,))
    found = joined_with(scene, capture.detections(CORNER_PX), calibrated(long, sigma_px))
    assert least < found.scene.cameras[0].fx - lens.fx < most
    assert found.scene.lens_covariance is not None
    assert 0.0 < np.sqrt(found.scene.lens_covariance[0, 0, 0]) <= 1.001 * sigma_px


def joined_with(scene: Scene, detections: BoardDetections, cameras: Cameras) -> MetricScene:
    return to_millimetres(alone(scene, cameras), detections, cameras=cameras)


@pytest.mark.parametrize("with_board", [True, False])
def test_a_typed_length_is_as_sure_as_a_lens_that_no_board_calibrated(
    capture, with_board: bool
) -> None:
    """Upright beside a board, or a typed length, that lies flat: they tell little of each other."""
    lens = capture.scene.cameras[0]
    sigmas = np.array([275.0, 275.0, 40.0, 40.0, 0.0, 0.05, 0.1, 2e-3, 2e-3, 0.0])
    ends = [(-150.0, 0.0, 100.0), (150.0, 0.0, 100.0)], [(0.0, 0.0, 20.0), (0.0, 0.0, 300.0)]
    flat, tall = (
        replace(capture.distance(label, *map(np.array, two), photos=(0, 3, 6, 9)), sigma_px=0.05)
        for label, two in zip(("flat", "tall"), ends, strict=True)
    )
    ratios, errors = [], []
    for seed in range(6):
        off = np.random.default_rng(seed).normal(size=10) * sigmas
        off[1] = off[0]
        found = lens.with_parameters(lens.packed + off)
        given = Calibration(camera=found, covariance=np.diag(sigmas**2), source="exif")
        cameras = Cameras((given,))
        scene = alone(replace(measured(capture, seed), cameras=(found,)), cameras)
        board = capture.detections(2 * CORNER_PX, seed) if with_board else None
        scale = to_millimetres(scene, board, (flat, tall), cameras=cameras).scale
        (one,) = [length for length in scale.lengths if length.label == "tall"]
        errors.append(one.error)
        ratios.append(one.error * one.known_mm / one.sigma_mm)
    assert 5e-4 < np.sqrt(np.mean(np.square(errors))) < 2.5e-3
    assert 0.2 < np.sqrt(np.mean(np.square(ratios))) < 1.8


def test_held_lenses_stay_held(capture) -> None:
    scene = measured(capture)
    held = replace(scene, lens_covariance=np.zeros((1, LENS_SIZE, LENS_SIZE)))
    assert joined(held, capture.detections(CORNER_PX)).scene.cameras == scene.cameras


@pytest.mark.parametrize("folds_at", [np.inf, 0.15])
def test_equations_of_a_body_are_the_slopes_of_its_cost(capture, folds_at: float) -> None:
    """Also of corners that a very wide lens shows where its model has turned back."""
    draw = np.random.default_rng(0)
    scene, board = capture.scene, capture.detections(0.2)
    corners = np.array([0, 5, 9, 20])
    by_board = to_millimetres(scene, board).scene
    scene_from_metric = fit_similarity(by_board.points_in_world, scene.points_in_world)
    folded = replace(scene.cameras[0], k3=-1.0 / (7.0 * folds_at**6))
    bundle = Bundle.of(replace(scene, cameras=(folded,)))
    shape = board.corners_mm[corners] - board.corners_mm.mean(0)
    body = Body(
        shape=shape,
        world_from_body=replace(
            scene_from_metric,
            rotation=scene_from_metric.rotation @ np.diag([1.0, -1.0, -1.0]),
        ),
        offsets=draw.normal(scale=1e-3, size=(4, 3)),
        shape_sigma=2e-3,
        photo_idx=np.tile(np.arange(3), 4),
        corner_idx=np.repeat(np.arange(4), 3),
        xy_px=np.concatenate([[board.photos[k].xy_px[c] for k in range(3)] for c in corners]),
        sigma_px=0.3,
    )
    equations = body.equations(bundle, 3.0)

    def slope(direction: np.ndarray) -> float:
        """Of the cost along cameras, whole and corners."""
        cameras, whole = direction[: bundle.unknowns], direction[bundle.unknowns :][:7]
        own = direction[bundle.unknowns + 7 :].reshape(4, 3)
        still = np.zeros_like(bundle.points)
        ends = [
            body.moved(s * whole, s * own).cost(bundle.moved(s * cameras, still), 3.0)
            for s in (1.0, -1.0)
        ]
        return (ends[0] - ends[1]) / 2

    right = np.concatenate([equations.shared_right, equations.block_right.ravel()])
    for k in (0, 4, 8, bundle.unknowns - 10, *range(bundle.unknowns, len(right))):
        step = np.zeros(len(right))
        step[k] = 1e-6
        assert slope(step) == pytest.approx(-2e-6 * right[k], rel=1e-3, abs=1e-9)
