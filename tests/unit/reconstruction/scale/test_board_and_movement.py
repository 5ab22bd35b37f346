"""The board where limb and surroundings moved against each other: with which of them it lies."""

from dataclasses import replace

import numpy as np
import pytest

from limbgram.reconstruction.mapping.movement import BodyMotion
from limbgram.reconstruction.mapping.scene import Movement
from limbgram.reconstruction.movement import still_board
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
            view, camera_from_world=view.camera_from_world @ found.moved(true.photo_idx)
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
