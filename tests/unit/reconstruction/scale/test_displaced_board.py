"""A board that was pushed while limb and room kept still: told, and scaled by what agrees."""

from dataclasses import replace

import numpy as np
import pytest
from tests.unit.reconstruction.scale.conftest import (
    SCENE_FROM_ROOM,
    WORLD_FROM_BOARD,
    Capture,
)

from limbgram.core.errors import ScaleError
from limbgram.core.geometry.frames import Rigid
from limbgram.findings import told
from limbgram.reconstruction.scale.displaced_board import without_displaced_board
from limbgram.reconstruction.scale.scaling import to_millimetres
from limbgram.reconstruction.targets.board import BoardDetections

NOISE_PX = 0.08


def pushed(capture: Capture, shifts_mm: dict[int, float], turn_deg: float = 0.5) -> BoardDetections:
    """The board slid along the table from these photos on."""
    found = capture.detections(noise_px=NOISE_PX)
    photos = list(found.photos)
    for first, shift_mm in shifts_mm.items():
        push = Rigid.from_rotation_vector(
            np.array([0.0, 0.0, np.radians(turn_deg)]),
            np.array([0.6 * shift_mm, 0.8 * shift_mm, 0]),
        )
        for k in range(first, len(photos)):
            view, seen = capture.room_views[k], photos[k]
            still = WORLD_FROM_BOARD.apply(found.corners_mm)
            moved = view.project(push.apply(still)) - view.project(still)
            photos[k] = replace(seen, xy_px=found.photos[k].xy_px + moved[seen.ids])
    return replace(found, photos=tuple(photos))


def scale_error(capture: Capture, detections: BoardDetections) -> float:
    mm_per_unit = to_millimetres(capture.scene, detections).scene
    first, last = (mm_per_unit.view(k).centre_in_world for k in (0, 5))
    true = [capture.room_views[k].centre_in_world for k in (0, 5)]
    return float(np.linalg.norm(first - last) / np.linalg.norm(true[0] - true[1]) - 1)


@pytest.mark.parametrize(
    "shift_mm", [2.0, *(pytest.param(one, marks=pytest.mark.slow) for one in (8.0, 30.0))]
)
def test_the_larger_part_sets_the_scale_and_the_push_is_named(
    capture: Capture, shift_mm: float
) -> None:
    detections = pushed(capture, {7: shift_mm})
    agreeing = without_displaced_board(capture.scene, detections)
    assert [one.photo_idx for one in agreeing.photos] == list(range(7))
    metric = to_millimetres(capture.scene, detections)
    assert [one.name for one in metric.scale.set_aside] == [
        f"photo{k:02d}.jpg" for k in range(7, 12)
    ]
    assert "pushed between photo06.jpg and photo07.jpg" in told(metric.scale.set_aside[0].reason)
    assert abs(scale_error(capture, detections)) < 5e-4


@pytest.mark.parametrize(("tip_deg", "code"), [(10.0, "pushed"), (40.0, "tipped")])
def test_a_board_in_another_plane_was_not_pushed(
    capture: Capture, tip_deg: float, code: str
) -> None:
    """To a limb that is turned over beside it, it is the board that tips."""
    found = capture.detections(noise_px=NOISE_PX)
    still = WORLD_FROM_BOARD.apply(found.corners_mm)
    turn = Rigid.from_rotation_vector(np.array([np.radians(tip_deg), 0.0, 0.0]), np.zeros(3))
    middle = still.mean(axis=0)
    tipped = middle + turn.apply(still - middle)
    photos = list(found.photos)
    for k in range(7, len(photos)):
        view, seen = capture.room_views[k], photos[k]
        moved = view.project(tipped) - view.project(still)
        photos[k] = replace(seen, xy_px=seen.xy_px + moved[seen.ids])
    agreeing = without_displaced_board(capture.scene, replace(found, photos=tuple(photos)))
    assert [one.photo_idx for one in agreeing.photos] == list(range(7))
    assert {one.reason.code for one in agreeing.set_aside} == {f"board.photo.{code}"}


def test_two_pushes_leave_the_largest_part(capture: Capture) -> None:
    agreeing = without_displaced_board(capture.scene, pushed(capture, {3: 8.0, 9: -9.0}))
    assert [one.photo_idx for one in agreeing.photos] == list(range(3, 9))
    assert told(agreeing.set_aside[0].reason).endswith(
        "pushed between photo02.jpg and photo03.jpg and between photo08.jpg and photo09.jpg"
    )


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, 6))]
)
def test_a_board_that_kept_still_is_left_as_it_is(capture: Capture, seed: int) -> None:
    for noise_px in (0.0, 0.1, 0.5):
        found = capture.detections(noise_px=noise_px, seed=seed)
        assert without_displaced_board(capture.scene, found) is found


def test_a_board_that_came_back_was_not_pushed(capture: Capture) -> None:
    """Two photos among others that agree, and two at the end that a push moved."""
    still = capture.detections(noise_px=NOISE_PX)
    photos = list(still.photos)
    for k, shift_mm in ((5, 8.0), (7, 7.0), (10, 8.0), (11, 8.0)):
        photos[k] = pushed(capture, {k: shift_mm}).photos[k]
    agreeing = without_displaced_board(capture.scene, replace(still, photos=tuple(photos)))
    codes = {one.name: one.reason.code for one in agreeing.set_aside}
    back = {f"photo{k:02d}.jpg": "board.photo.came_back" for k in (5, 7)}
    assert codes == back | {f"photo{k:02d}.jpg": "board.photo.pushed" for k in (10, 11)}
    (reason,) = {told(one.reason) for one in agreeing.set_aside if one.name == "photo11.jpg"}
    assert reason.endswith("it was pushed between photo09.jpg and photo10.jpg")


def test_a_board_that_moves_in_every_photo_is_refused_as_before(capture: Capture) -> None:
    restless = pushed(capture, {k: 7.0 * (-1) ** k * (1 + k % 5) for k in range(12)})
    assert without_displaced_board(capture.scene, restless) is restless
    with pytest.raises(ScaleError):
        to_millimetres(capture.scene, restless)


def test_what_the_scene_is_measured_in_does_not_matter(capture: Capture) -> None:
    detections = pushed(capture, {6: 8.0})
    elsewhere = capture.scene.moved(SCENE_FROM_ROOM.inverse)
    here = without_displaced_board(capture.scene, detections)
    there = without_displaced_board(elsewhere, detections)
    assert [one.name for one in here.photos] == [one.name for one in there.photos]


def showing(detections: BoardDetections, columns: dict[int, range]) -> BoardDetections:
    """Each photo from these on shows these columns of the board's corners alone."""
    across, photos = detections.board.inner[0], list(detections.photos)
    for first, shown in columns.items():
        for k in range(first, len(photos)):
            whole = detections.photos[k]
            rows = np.isin(whole.ids % across, list(shown))
            photos[k] = replace(
                whole,
                ids=whole.ids[rows],
                xy_px=whole.xy_px[rows],
                sigmas_px=whole.sigmas_px[rows],
            )
    return replace(detections, photos=tuple(photos))


LEFT_THEN_RIGHT = {0: range(3), 7: range(3, 6)}


@pytest.mark.parametrize(
    "shift_mm", [0.5, *(pytest.param(one, marks=pytest.mark.slow) for one in (2.0, 8.0))]
)
@pytest.mark.parametrize("columns", [LEFT_THEN_RIGHT, {0: range(4), 7: range(3, 6)}])
def test_a_push_between_photos_of_other_corners_is_told_by_the_shape(
    capture: Capture, shift_mm: float, columns: dict[int, range]
) -> None:
    """Corners that only one run shows contradict nothing, wherever the board lay."""
    detections = showing(pushed(capture, {7: shift_mm}, turn_deg=0.1), columns)
    agreeing = without_displaced_board(capture.scene, detections)
    assert [one.photo_idx for one in agreeing.photos] == list(range(7))
    assert "was pushed between photo06.jpg and photo07.jpg" in told(agreeing.set_aside[0].reason)
    assert abs(scale_error(capture, detections)) < 1e-3


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, 6))]
)
def test_photos_of_other_corners_of_a_still_board_are_kept(capture: Capture, seed: int) -> None:
    for columns in (
        LEFT_THEN_RIGHT,
        {0: range(2), 5: range(2, 6)},
        {0: range(4), 9: range(4, 6)},
        {0: range(1), 7: range(1, 6)},
    ):
        found = showing(capture.detections(noise_px=0.1, seed=seed), columns)
        assert without_displaced_board(capture.scene, found) is found


def test_where_nothing_foretells_the_other_corners_they_are_not_taken(capture: Capture) -> None:
    """One column of corners lies on a line: the board may be turned about it."""
    found = showing(capture.detections(noise_px=0.1), {0: range(1), 7: range(4, 5)})
    agreeing = without_displaced_board(capture.scene, found)
    assert [one.photo_idx for one in agreeing.photos] == list(range(7))
    assert "too few to tell whether the board was pushed" in told(agreeing.set_aside[0].reason)


def test_photos_that_share_no_corner_do_not_agree(capture: Capture) -> None:
    """Four photos in a row of one column of corners each, and a board that never lies still."""
    found = capture.detections(noise_px=NOISE_PX)
    photos = list(showing(found, {4 + k: range(k, k + 1) for k in range(4)}).photos)
    photos[8:] = found.photos[8:]
    turns = np.random.default_rng(2).uniform(0, 2 * np.pi, len(photos))
    moves_px = 20 * np.column_stack([np.cos(turns), np.sin(turns)])
    moved = (replace(one, xy_px=one.xy_px + px) for one, px in zip(photos, moves_px, strict=True))
    restless = replace(found, photos=tuple(moved))
    assert without_displaced_board(capture.scene, restless) is restless
