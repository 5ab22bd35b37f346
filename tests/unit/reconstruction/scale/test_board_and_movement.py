"""The board where limb and surroundings moved against each other: with which of them it lies."""

from dataclasses import replace

import numpy as np
import pytest

import limbgram.reconstruction.movement as looking
from limbgram.reconstruction.calibration.cameras import Cameras
from limbgram.reconstruction.mapping.body_motion import BodyMotion
from limbgram.reconstruction.mapping.placement import MappingOptions
from limbgram.reconstruction.mapping.scene import Movement, Observations
from limbgram.reconstruction.movement import corners_agree_better, still_board
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.targets.board import BoardDetections

MM = 0.0371
"""In units of the scene."""


def restless(capture, seed: int, shift_mm: float) -> BodyMotion:
    """Surroundings that are elsewhere in every photo."""
    photos = len(capture.scene.names)
    draw = np.random.default_rng(seed)
    motions = np.hstack(
        [draw.normal(0, 0.004, (photos, 3)), draw.normal(0, shift_mm * MM, (photos, 3))]
    )
    movement = replace(Movement.unknown(photos), kind="restless", shift=np.ones(photos))
    middle = capture.scene.points_in_world.mean(0)
    return BodyMotion(movement=movement, middle=middle, motions=motions)


def pixels(detections: BoardDetections) -> np.ndarray:
    return np.array([photo.xy_px for photo in detections.photos])


def shown_with_surroundings(
    capture, detections: BoardDetections, found: BodyMotion
) -> BoardDetections:
    """The same noise, the corners where the moved surroundings have them."""
    exact = capture.detections()
    photos = []
    for noisy, true in zip(detections.photos, exact.photos, strict=True):
        view = capture.scene.view(true.photo_idx)
        moved = replace(
            view, camera_from_world=view.camera_from_world @ found.in_photo(true.photo_idx)
        )
        places = capture.corners_in_scene()
        xy = moved.project(places) + noisy.xy_px - true.xy_px
        photos.append(replace(noisy, xy_px=xy))
    return replace(detections, photos=tuple(photos))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_board_that_kept_still_with_the_limb_is_taken_as_it_is(capture, seed: int) -> None:
    shown = capture.detections(noise_px=0.1, seed=seed)
    assert still_board(shown, capture.scene, restless(capture, seed, 8.0)) is shown


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_board_that_moved_with_the_room_is_put_where_the_limb_kept_still(
    capture, seed: int
) -> None:
    still = capture.detections(noise_px=0.1, seed=seed)
    found = restless(capture, seed, 8.0)
    shown = shown_with_surroundings(capture, still, found)
    put = still_board(shown, capture.scene, found)
    before = np.linalg.norm(pixels(shown) - pixels(still), axis=2)
    after = np.linalg.norm(pixels(put) - pixels(still), axis=2)
    assert np.median(before) > 5.0
    assert np.median(after) < 1.0


def test_corners_agree_better_where_the_photos_were_placed_better(capture) -> None:
    shown = capture.detections(noise_px=0.1, seed=4)
    found = restless(capture, 4, 2.0)
    worse = replace(
        capture.scene,
        camera_from_world=tuple(
            None if pose is None else pose @ found.in_photo(k)
            for k, pose in enumerate(capture.scene.camera_from_world)
        ),
    )
    assert corners_agree_better(shown, capture.scene, worse)
    assert not corners_agree_better(shown, worse, capture.scene)
    assert not corners_agree_better(replace(shown, photos=()), capture.scene, worse)


class LeftHalf:
    """A limb that lies in the left half of every photo."""

    def __init__(self, width_px: int) -> None:
        self.width_px = width_px

    def shows(self, xy_px: np.ndarray) -> np.ndarray:
        return xy_px[:, 0] < self.width_px / 2


def test_points_beside_the_limb_need_a_third_photo(
    capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Points on the limb stay however few photos show them."""
    scene = capture.scene
    points = scene.points_in_world[::50]
    shown_in = [range(2) if k % 2 else range(6) for k in range(len(points))]
    pairs = np.array([(photo, k) for k, photos in enumerate(shown_in) for photo in photos])
    photo_idx, point_idx = pairs.astype(np.int32).T
    pixels_px = np.array([scene.view(photo).project(points[[k]])[0] for photo, k in pairs])
    thinned = Observations(photo_idx, point_idx, pixels_px)
    scene = replace(scene, points_in_world=points, observations=thinned)
    width_px = scene.cameras[0].width_px
    monkeypatch.setattr(looking, "find_region", lambda *_: None)
    monkeypatch.setattr(looking, "footprint", lambda *_: LeftHalf(width_px))
    monkeypatch.setattr(looking, "readjusted", lambda one, *_: one)
    left = looking.without_what_moved_beside(PhotoSet((), ()), scene, Cameras(()), MappingOptions())
    times = np.bincount(thinned.point_idx, minlength=len(scene.points_in_world))
    on_limb = np.zeros(len(times), bool)
    on_limb[thinned.point_idx[thinned.xy_px[:, 0] < width_px / 2]] = True
    dropped = ~on_limb & (times <= 2)
    assert 0 < dropped.sum() < len(times) / 2
    np.testing.assert_array_equal(left.points_in_world, scene.points_in_world[~dropped])
    kept = ~dropped[thinned.point_idx]
    np.testing.assert_array_equal(left.observations.xy_px, thinned.xy_px[kept])
    np.testing.assert_array_equal(
        left.points_in_world[left.observations.point_idx],
        scene.points_in_world[thinned.point_idx[kept]],
    )
