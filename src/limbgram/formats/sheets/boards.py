"""A board on paper in true size: the scale board, or the checkerboard of the calibration.

In      a Board and a page.
Out     a Sheet, upright or lengthwise as it fits.
Fails   OptionsError: the board does not fit on the page, or is of OpenCV's legacy pattern.
"""

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import OptionsError
from limbgram.formats.sheets.page import (
    BESIDE_MM,
    EDGE_MM,
    FOOT_MM,
    HEAD_MM,
    PAGES_MM,
    PageName,
    Paper,
    Sheet,
    pdf_of,
    rectangle,
    runs,
)
from limbgram.reconstruction.targets.board import Board


def draw_board_sheet(board: Board, page: PageName = "a4", name: str = "board") -> Sheet:
    """A PDF sheet of a board in true size.

    Args:
        name: What the sheet is called on itself, before what the board is.

    Raises:
        OptionsError: it fits neither way, or the pattern is OpenCV's legacy one.
    """
    if board.legacy:
        raise OptionsError("export.sheet.legacy")
    wide_mm, high_mm = (board.square_mm * count for count in board.squares)
    needed = (2 * EDGE_MM + wide_mm + BESIDE_MM, 2 * EDGE_MM + HEAD_MM + high_mm + FOOT_MM)
    short, long = PAGES_MM[page]
    fits = [(w, h) for w, h in ((long, short), (short, long)) if w >= needed[0] and h >= needed[1]]
    if not fits:
        raise OptionsError(
            "export.sheet.large_board",
            board=str(board),
            wide_mm=needed[0],
            high_mm=needed[1],
            page=page,
            page_long_mm=long,
            page_short_mm=short,
            pages=tuple(PAGES_MM),
        )
    paper = Paper(page, upright=fits[0] == (short, long))
    paper.fill(_black_cells_mm(board) + paper.origin_mm)
    advice = ("Print at 100 % (actual size), on matt paper, and fix it flat on a stiff plate.",)
    title = f"{name}: {board}"
    down_mm = paper.frame(title, (wide_mm, high_mm), advice)
    return Sheet(
        title=title,
        page=page,
        width_mm=paper.width_mm,
        height_mm=paper.height_mm,
        ruler_mm=float(paper.ruler_mm),
        ruler_down_mm=float(down_mm),
        square_mm=float(paper.square_mm),
        pdf=pdf_of([paper], str(board)),
        board=board,
    )


def _black_cells_mm(board: Board) -> Float64[np.ndarray, "n 4 2"]:
    """Corners of the rectangles that are black, from the pattern's top left corner, y down."""
    cells = board.cells()
    black = ~cells.any(axis=(2, 3))
    found: list[np.ndarray] = []
    for row, column in np.argwhere(black).tolist():
        found.append(rectangle(column, row, 1, 1) * board.square_mm)
    if board.kind == "checkerboard":
        return np.array(found)
    margin = 0.5 * (board.square_mm - board.marker_mm)
    cell_mm = board.marker_mm / cells.shape[-1]
    for row, column in np.argwhere(~black).tolist():
        corner = np.array([column, row]) * board.square_mm + margin
        for down, start, end in runs(cells[row, column] == 0):
            found.append(rectangle(start, down, end - start, 1) * cell_mm + corner)
    return np.array(found)
