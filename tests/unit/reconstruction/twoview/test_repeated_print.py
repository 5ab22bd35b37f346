"""Pairs that a board joins by its print: by the same places of it, or by places that look alike."""

import numpy as np
import pytest

from limbgram.core.geometry.arrays import Points2
from limbgram.core.geometry.frames import Rigid
from limbgram.reconstruction.matching.matching import PairMatches
from limbgram.reconstruction.targets.board import Board, BoardDetections, PhotoCorners
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair
from limbgram.reconstruction.twoview.repeated_print import without_repeated_print

BOARD = Board.charuco("7x5", 30.0, 22.0, "4X4_50")
SQUARE_MM = BOARD.square_mm
SEEN = (
    np.array([[2.0, 0.3, 90.0], [-0.2, 1.6, 60.0], [1e-4, -2e-4, 1.0]]),
    np.array([[-0.4, 1.9, 300.0], [-1.7, 0.3, 500.0], [-3e-4, 1e-4, 1.0]]),
)
"""Two photos' pixels from millimetres of the board."""
LIMB = np.random.default_rng(3).uniform(600.0, 900.0, (12, 2))
"""Pixels of places that do not lie on the board."""


def shown(photo: int, on_board_mm: Points2) -> Points2:
    places = np.column_stack([on_board_mm, np.ones(len(on_board_mm))]) @ SEEN[photo].T
    return places[:, :2] / places[:, 2:]


def read(photo: int, ids: np.ndarray) -> PhotoCorners:
    return PhotoCorners(
        name=f"{photo}.jpg",
        photo_idx=photo,
        ids=ids.astype(np.int32),
        xy_px=shown(photo, BOARD.corners_mm[ids, :2]),
        sigmas_px=np.full(len(ids), 0.05),
        blur_px=0.7,
        step_px=50.0,
        doubtful_ids=np.zeros(0, np.int32),
        doubtful_xy_px=np.zeros((0, 2)),
        doubts=(),
    )


def detections(*ids: np.ndarray) -> BoardDetections:
    photos = tuple(read(photo, own) for photo, own in enumerate(ids))
    return BoardDetections(board=BOARD, corners_mm=BOARD.corners_mm, photos=photos, set_aside=())


def pair(first_px: Points2, second_px: Points2) -> VerifiedPair:
    count = len(first_px)
    matches = PairMatches(
        first=0,
        second=1,
        keypoint_idx=np.zeros((count, 2), np.int32),
        xy_first_px=first_px,
        xy_second_px=second_px,
        correlation=np.ones(count, np.float32),
    )
    return VerifiedPair(
        matches=matches,
        fundamental=np.eye(3),
        second_from_first=Rigid.identity(),
        kind="general",
        residual_px=np.zeros(count),
        median_angle_deg=20.0,
    )


def on_print() -> tuple[Points2, Points2]:
    """Places of the print in millimetres, and those that look like them a quarter turn on."""
    random = np.random.default_rng(2)
    places = random.uniform(0.0, 4.0, (30, 2)) * SQUARE_MM
    middle = BOARD.corners_mm[:, :2].mean(axis=0)
    return places, (places - middle) @ np.array([[0.0, 1.0], [-1.0, 0.0]]) + middle


ALL = np.arange(len(BOARD.corners_mm))


def kept(found: VerifiedPair, seen: BoardDetections | None) -> bool:
    left = without_repeated_print(Pairs((found,), 4), seen)
    assert left.rejected == 4 + 1 - len(left.verified)
    return len(left.verified) == 1


@pytest.mark.parametrize("turned", [False, True])
def test_a_pair_that_joins_other_places_of_the_print_is_dropped(turned: bool) -> None:
    places, alike = on_print()
    found = pair(shown(0, places), shown(1, alike if turned else places))
    assert kept(found, detections(ALL, ALL)) is not turned


def test_by_other_places_two_squares_on_it_is_dropped_too() -> None:
    places, _ = on_print()
    places = places / 2.0
    found = pair(shown(0, places), shown(1, places + np.array([2 * SQUARE_MM, 0.0])))
    assert not kept(found, detections(ALL, ALL))


def test_without_corners_in_both_photos_nothing_is_said() -> None:
    places, alike = on_print()
    found = pair(shown(0, places), shown(1, alike))
    row = np.flatnonzero(BOARD.corners_mm[:, 1] == BOARD.corners_mm[0, 1])
    for seen in (None, detections(ALL), detections(ALL, ALL[:5]), detections(ALL, row)):
        assert kept(found, seen)


def test_what_stands_before_the_board_is_not_its_print() -> None:
    """A limb hides most corners; its own points lie at other places of the board in each photo."""
    places, alike = on_print()
    far = np.linalg.norm(places[:, None] - BOARD.corners_mm[None, :8, :2], axis=2).min(axis=1)
    before = far > SQUARE_MM
    assert before.sum() > 8
    found = pair(shown(0, places[before]), shown(1, alike[before]))
    assert kept(found, detections(ALL[:8], ALL[:8]))


def test_a_pair_that_the_limb_joins_keeps_its_few_wrong_matches_on_the_print() -> None:
    places, alike = on_print()
    few = slice(0, 8)
    found = pair(
        np.concatenate([LIMB, shown(0, places[few])]),
        np.concatenate([LIMB, shown(1, alike[few])]),
    )
    assert kept(found, detections(ALL, ALL))
