"""Squares of markers, and layouts that markers agree with."""

import numpy as np
import pytest

from limbgram.reconstruction.targets.board import Board
from limbgram.reconstruction.targets.layout import DetectedMarkers, _squares_of, best_layout


def read_on(printed: Board, numbers: np.ndarray) -> DetectedMarkers:
    """Markers as a board shows them that is seen at a slant, 8 px a mm at its origin."""
    corners_mm = np.array(printed.opencv().getObjPoints())[numbers, :, :2]
    depth = 1.0 + corners_mm @ np.array([0.002, -0.001])
    return DetectedMarkers(numbers, 8.0 * corners_mm / depth[..., None])


@pytest.mark.parametrize("legacy", [True, False])
@pytest.mark.parametrize("size", ["3x3", "4x6", "5x7", "7x5", "7x4", "8x5", "8x6"])
def test_squares_are_those_of_opencv(size: str, legacy: bool) -> None:
    printed = Board.charuco(size, 30.0, 22.0, "4X4_50", legacy=legacy)
    middles_mm = np.array(printed.opencv().getObjPoints()).mean(axis=1)[:, :2]
    first = legacy and printed.rows % 2 == 0
    squares = _squares_of(np.arange(len(middles_mm)), printed.columns, first)
    np.testing.assert_allclose((squares + 0.5) * 30.0, middles_mm, atol=1e-4)


@pytest.mark.parametrize("legacy", [True, False])
@pytest.mark.parametrize("size", ["3x3", "4x6", "5x7", "7x5", "8x6", "12x6"])
@pytest.mark.parametrize("given", ["5x7", "7x5", "6x4"])
def test_the_layout_of_markers_does_not_hang_on_the_board_that_was_given(
    size: str, legacy: bool, given: str
) -> None:
    printed = Board.charuco(size, 30.0, 22.0, "4X4_50", legacy=legacy)
    numbers = np.arange(len(printed.opencv().getIds()))
    found = best_layout([read_on(printed, numbers)], Board.charuco(given, 30.0, 22.0, "4X4_50"))
    assert (found.columns, found.rows) == printed.squares
    assert found.marker_first == (legacy and printed.rows % 2 == 0)
    assert (found.photos, found.markers) == (1, len(numbers))
    assert found.is_of(printed)


def test_markers_that_were_misread_agree_with_no_layout() -> None:
    printed = Board.charuco("7x5", 30.0, 22.0, "4X4_50")
    random = np.random.default_rng(5)
    anywhere = [
        DetectedMarkers(one.ids, one.corners_px + random.uniform(-900, 900, (4, 1, 2)))
        for one in [read_on(printed, random.choice(17, 4, replace=False)) for _ in range(8)]
    ]
    assert best_layout(anywhere, printed).markers == 0
    good = [read_on(printed, np.arange(17))]
    assert best_layout([*good, *anywhere], printed).markers == 17
