"""A board that stands still while the object turns tells nothing of its size."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.errors import ScaleError
from limbgram.reconstruction.matching.static_background import StaticBackground
from limbgram.reconstruction.scale.background_board import without_background_board
from limbgram.reconstruction.scale.scaling import to_millimetres
from limbgram.reconstruction.targets.board import BoardDetections

STILL = StaticBackground(groups=(tuple(range(12)),))


def shown_at(detections: BoardDetections, shifts_px: Sequence[float]) -> BoardDetections:
    """Every photo shows the board as the first one does, shifted by so much."""
    first = detections.photos[0].xy_px
    photos = tuple(
        replace(one, xy_px=first + shift)
        for one, shift in zip(detections.photos, shifts_px, strict=True)
    )
    return replace(detections, photos=photos)


def test_a_board_of_the_room_is_left_out_and_the_refusal_says_why(capture) -> None:
    shaking = np.random.default_rng(1).uniform(-0.3, 0.3, 12)
    found = without_background_board(shown_at(capture.detections(), shaking), STILL)
    assert found.photos == ()
    assert [one.name for one in found.set_aside] == [f"photo{k:02d}.jpg" for k in range(12)]
    with pytest.raises(ScaleError, match="stands still while the object turns"):
        to_millimetres(capture.scene, found)


def test_a_board_that_turns_with_the_object_stays(capture) -> None:
    turning = capture.detections()
    assert without_background_board(turning, STILL) is turning


def test_where_the_camera_walks_round_a_board_is_never_doubted(capture) -> None:
    shown = shown_at(capture.detections(), [0.0] * 12)
    assert without_background_board(shown, StaticBackground()) is shown


def test_a_board_that_pauses_for_two_photos_stays(capture) -> None:
    pausing = shown_at(capture.detections(), [40.0 * max(k, 1) for k in range(12)])
    assert without_background_board(pausing, STILL) is pausing
