"""Printed boards: the sheet's own geometry, read back from its pixels by other programs."""

import cv2
import numpy as np
import pypdfium2
import pytest

from limbgram.core.errors import OptionsError
from limbgram.formats.sheets.boards import draw_board_sheet
from limbgram.formats.sheets.page import PageName, Sheet
from limbgram.reconstruction.targets.board import Board

DPI = 600
MM = 25.4 / DPI
SCALE = Board.charuco("7x5", 30, 22, "4X4_50")
LENS = Board.checkerboard("14x10", 10)
CORNER_MM = np.array([12.0, 21.0])
"""Where the pattern begins on the page."""


def raster(sheet: Sheet) -> np.ndarray:
    page = pypdfium2.PdfDocument(sheet.pdf)[0]
    assert page.get_width() * 25.4 / 72 == pytest.approx(sheet.width_mm, abs=0.01)
    assert page.get_height() * 25.4 / 72 == pytest.approx(sheet.height_mm, abs=0.01)
    return page.render(scale=DPI / 72, grayscale=True).to_numpy().squeeze()


def corners_mm(sheet: Sheet) -> np.ndarray:
    """The inner corners, found from 0.3 mm off, mm from the pattern's corner."""
    picture, board = raster(sheet), sheet.board
    assert board is not None
    mm = np.array([sheet.width_mm, sheet.height_mm]) / picture.shape[::-1]  # whole pixels a page
    start = (board.corners_mm[:, :2] + CORNER_MM + 0.3) / mm - 0.5
    enough = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 100, 1e-4)
    found = np.ascontiguousarray(start, np.float32).reshape(-1, 1, 2)
    found = cv2.cornerSubPix(picture, found, (47, 47), (-1, -1), enough)
    return (found.reshape(-1, 2) + 0.5) * mm - CORNER_MM


@pytest.mark.parametrize("page", ["a4", "letter"])
@pytest.mark.parametrize("board", [SCALE, LENS], ids=["scale", "lens"])
def test_every_corner_is_printed_where_the_board_has_it(board: Board, page: PageName) -> None:
    apart = corners_mm(draw_board_sheet(board, page)) - board.corners_mm[:, :2]
    assert np.abs(apart).max() < 0.02


def test_markers_are_those_that_opencv_looks_for() -> None:
    picture = raster(draw_board_sheet(SCALE))
    small = cv2.resize(picture, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    found, ids, _, _ = cv2.aruco.CharucoDetector(SCALE.opencv()).detectBoard(small)
    assert sorted(ids.ravel()) == list(range(24))
    expected = (SCALE.corners_mm[ids.ravel(), :2] + CORNER_MM) / (4 * MM) - 0.5
    np.testing.assert_allclose(found.reshape(-1, 2), expected, atol=1.0)


def test_the_rulers_have_their_length() -> None:
    sheet = draw_board_sheet(SCALE)
    assert (sheet.ruler_mm, sheet.ruler_down_mm) == (250, 150)
    dark = 255.0 - raster(sheet)
    across = dark[round((21 + 150 + 8 + 3.2) / MM)]  # only marks of ten millimetres reach here
    down = dark[:, round((12 + 210 + 8 + 3.2) / MM)]
    for line, length_mm in ((across, 250), (down, 150)):
        marked = np.flatnonzero(line > 60)
        groups = np.split(marked, np.flatnonzero(np.diff(marked) > 3) + 1)
        middles = [np.average(group, weights=line[group]) * MM for group in groups]
        steps = np.diff(middles[: length_mm // 10 + 1])
        assert len(steps) == length_mm // 10
        np.testing.assert_allclose(steps, 10.0, atol=0.03)
        assert middles[length_mm // 10] - middles[0] == pytest.approx(length_mm, abs=0.02)


def test_the_same_sheet_has_the_same_bytes_and_no_date() -> None:
    first, second = draw_board_sheet(LENS).pdf, draw_board_sheet(LENS).pdf
    assert first == second
    assert b"CreationDate" not in first


def test_a_board_that_does_not_fit_is_refused_with_what_it_needs() -> None:
    large = Board.charuco("9x7", 35, 25, "4X4_50")
    with pytest.raises(OptionsError, match="361 x 303 mm"):
        draw_board_sheet(large, "a4")
    assert draw_board_sheet(Board.charuco("7x5", 45, 33, "4X4_50"), "a3").width_mm == 420


def test_the_legacy_pattern_is_not_printed() -> None:
    with pytest.raises(OptionsError, match="legacy"):
        draw_board_sheet(Board.charuco("6x4", 20, 15, "4X4_50", legacy=True))
