"""A board on paper: a PDF sheet in true size, with rulers that prove the size of the print.

In      a Board and a page.
Out     the bytes of a PDF of vector drawings; the same board and page give the same bytes.
Method  all black of the pattern is one path, so that no seam shows between its cells. A ruler along
        the page and one across it, and a square, are printed with it: printers scale, and seldom
        alike in both directions.
Fails   OptionsError: the board does not fit on the page, or is of OpenCV's legacy pattern.
"""

import io
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np
from jaxtyping import Float64
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import FigureCanvasPdf, PdfPages
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline

from limbgram.core.errors import OptionsError
from limbgram.reconstruction.targets.board import Board

PageName = Literal["a4", "letter", "a3", "tabloid"]
_PAGES_MM: dict[PageName, tuple[float, float]] = {
    "a4": (210.0, 297.0),
    "letter": (215.9, 279.4),
    "a3": (297.0, 420.0),
    "tabloid": (279.4, 431.8),
}
_MM_PER_INCH = 25.4
_EDGE_MM = 12.0
"""Kept white all round: most printers cannot print nearer than 4 to 6 mm to the edge."""
_HEAD_MM = 9.0
"""The name of the board, above the pattern."""
_FOOT_MM = 25.0
"""The ruler across the page and what to do, below the pattern."""
_BESIDE_MM = 22.0
"""The ruler down the page, on the right of the pattern."""
_LONG_STEP_MM = 50
_STEP_MM = 10
_LARGEST_SQUARE_MM = 50.0
_LINE_MM = 0.1
_INK = "black"


@dataclass(frozen=True, kw_only=True)
class BoardSheet:
    """A page with a board, and what is measured on it to prove its size."""

    board: Board
    page: PageName
    width_mm: float
    height_mm: float
    ruler_mm: float
    """Length of the ruler across the page: the one that `--measured-mm` is read on."""
    ruler_down_mm: float
    square_mm: float
    """Side of the square beside the board."""
    pdf: bytes


def draw_board_sheet(board: Board, page: PageName = "a4") -> BoardSheet:
    """A PDF sheet of a board in true size, upright or lengthwise as it fits.

    Raises:
        OptionsError: it fits neither way, or the pattern is OpenCV's legacy one.
    """
    if board.legacy:
        raise OptionsError("Boards of OpenCV's legacy pattern are read, but not printed any more.")
    wide_mm, high_mm = (board.square_mm * count for count in board.squares)
    needed = (2 * _EDGE_MM + wide_mm + _BESIDE_MM, 2 * _EDGE_MM + _HEAD_MM + high_mm + _FOOT_MM)
    short, long = _PAGES_MM[page]
    fits = [(w, h) for w, h in ((long, short), (short, long)) if w >= needed[0] and h >= needed[1]]
    if not fits:
        raise OptionsError(
            f"A {board} needs {needed[0]:.0f} x {needed[1]:.0f} mm with its rulers and margins; "
            f"{page} has {long:g} x {short:g} mm. Choose a larger page by --page "
            f"({', '.join(_PAGES_MM)}) or smaller squares."
        )
    width, height = fits[0]
    ruler_mm = _LONG_STEP_MM * int((width - 2 * _EDGE_MM) // _LONG_STEP_MM)
    ruler_down_mm = _STEP_MM * int(high_mm // _STEP_MM)
    beside_mm = width - 2 * _EDGE_MM - wide_mm - _BESIDE_MM
    square_mm = min(_LARGEST_SQUARE_MM, max(_STEP_MM, _STEP_MM * (beside_mm // _STEP_MM)))
    axes = _page(width, height)
    top = _EDGE_MM + _HEAD_MM
    axes.add_patch(_filled(_black_cells_mm(board) + np.array([_EDGE_MM, top])))
    _write(axes, _EDGE_MM, top - 4, f"limbgram board: {board}", 9)
    foot = top + high_mm + 8
    _ruler(axes, (_EDGE_MM, foot), ruler_mm, down=False)
    _ruler(axes, (_EDGE_MM + wide_mm + 8, top), ruler_down_mm, down=True)
    at = (width - _EDGE_MM - square_mm, top + high_mm - square_mm)
    if beside_mm >= square_mm:
        _square(axes, at, square_mm)
    for row, words in enumerate(
        (
            "Print at 100 % (actual size), on matt paper, and fix it flat on a stiff plate.",
            f"Measure the ruler above, {ruler_mm} mm, with a steel rule to a tenth of a "
            f"millimetre, and give what you read: --measured-mm {ruler_mm}.0",
        )
    ):
        _write(axes, _EDGE_MM, foot + 11 + 4.2 * row, words, 7.5)
    return BoardSheet(
        board=board,
        page=page,
        width_mm=width,
        height_mm=height,
        ruler_mm=float(ruler_mm),
        ruler_down_mm=float(ruler_down_mm),
        square_mm=square_mm if beside_mm >= square_mm else 0.0,
        pdf=_pdf_of(axes, str(board)),
    )


def _black_cells_mm(board: Board) -> Float64[np.ndarray, "n 4 2"]:
    """Corners of the rectangles that are black, from the pattern's top left corner, y down."""
    cells = board.cells()
    black = ~cells.any(axis=(2, 3))
    found: list[np.ndarray] = []
    for row, column in np.argwhere(black).tolist():
        found.append(_rectangle(column, row, 1, 1) * board.square_mm)
    if board.kind == "checkerboard":
        return np.array(found)
    margin = 0.5 * (board.square_mm - board.marker_mm)
    cell_mm = board.marker_mm / cells.shape[-1]
    for row, column in np.argwhere(~black).tolist():
        corner = np.array([column, row]) * board.square_mm + margin
        for down, start, end in _runs(cells[row, column] == 0):
            found.append(_rectangle(start, down, end - start, 1) * cell_mm + corner)
    return np.array(found)


def _runs(black: np.ndarray) -> Iterable[tuple[int, int, int]]:
    """Row, start and end of what is black in a row without a gap."""
    for row, line in enumerate(black):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], line.astype(np.int8), [0]])))
        for start, end in edges.reshape(-1, 2).tolist():
            yield row, start, end


def _rectangle(x: float, y: float, width: float, height: float) -> Float64[np.ndarray, "4 2"]:
    return np.array([(x, y), (x + width, y), (x + width, y + height), (x, y + height)], float)


def _page(width_mm: float, height_mm: float) -> Axes:
    """A page whose coordinates are millimetres from its top left corner."""
    figure = Figure(figsize=(width_mm / _MM_PER_INCH, height_mm / _MM_PER_INCH))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0, width_mm)
    axes.set_ylim(height_mm, 0)
    axes.axis("off")
    return axes


def _filled(rectangles_mm: Float64[np.ndarray, "n 4 2"]) -> PathPatch:
    """Rectangles as one black path without an outline, which would make them larger."""
    closed = np.concatenate([rectangles_mm, rectangles_mm[:, :1]], axis=1)
    codes = np.tile(
        np.array(
            [Outline.MOVETO, Outline.LINETO, Outline.LINETO, Outline.LINETO, Outline.CLOSEPOLY],
            np.uint8,
        ),
        len(closed),
    )
    return PathPatch(Outline(closed.reshape(-1, 2), codes), facecolor=_INK, linewidth=0)


def _ruler(axes: Axes, start_mm: tuple[float, float], length_mm: int, *, down: bool) -> None:
    """A ruler with a mark every millimetre; it is read from the first mark's middle to the last."""
    x, y = start_mm
    marks: list[np.ndarray] = []
    for mark in range(length_mm + 1):
        long = 4.0 if mark % 10 == 0 else 2.6 if mark % 5 == 0 else 1.6
        box = _rectangle(mark - _LINE_MM / 2, 0, _LINE_MM, long)
        marks.append((box[:, ::-1] if down else box) + (x, y))
    axes.add_patch(_filled(np.array(marks)))
    for mark in sorted({*range(0, length_mm, _LONG_STEP_MM), length_mm}):
        words = f"{mark} mm" if mark == length_mm else f"{mark}"
        if down:
            _write(axes, x + 5, y + mark + 0.9, words, 6)
        else:
            _write(axes, x + mark, y + 6.4, words, 6, align="center")


def _square(axes: Axes, corner_mm: tuple[float, float], side_mm: float) -> None:
    """A square between whose lines' middles both sides have the length that stands in it."""
    half = _LINE_MM / 2
    lines = [
        _rectangle(-half, -half, side_mm + _LINE_MM, _LINE_MM),
        _rectangle(-half, side_mm - half, side_mm + _LINE_MM, _LINE_MM),
        _rectangle(-half, half, _LINE_MM, side_mm - _LINE_MM),
        _rectangle(side_mm - half, half, _LINE_MM, side_mm - _LINE_MM),
    ]
    axes.add_patch(_filled(np.array(lines) + corner_mm))
    middle = np.array(corner_mm) + side_mm / 2
    _write(axes, middle[0], middle[1], f"{side_mm:g} x {side_mm:g} mm", 6, align="center")


def _write(
    axes: Axes,
    x: float,
    y: float,
    words: str,
    points: float,
    *,
    align: Literal["left", "center"] = "left",
) -> None:
    axes.text(x, y, words, fontsize=points, ha=align, va="baseline", color=_INK)


def _pdf_of(axes: Axes, title: str) -> bytes:
    file = io.BytesIO()
    figure = cast(Figure, axes.figure)  # get_figure(root=True) needs matplotlib 3.10
    FigureCanvasPdf(figure)
    about = {"CreationDate": None, "Creator": "limbgram", "Title": title}
    with PdfPages(file, metadata=about) as pages:
        pages.savefig(figure)
    return file.getvalue()
