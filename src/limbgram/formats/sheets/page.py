"""A printed page in true millimetres: black cells, lines, text, and rulers that prove its size.

In      drawings, in mm from the page's top left corner, y down.
Out     the bytes of a vector PDF; the same drawings give the same bytes.
Method  all black cells of a pattern are one path, so that no seams show. Every page has a ruler
        across, one down, and a square: printers scale, and seldom equally in both directions.
"""

import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.units import MM_PER_INCH
from limbgram.reconstruction.targets.board import Board
from limbgram.reconstruction.targets.plates import MarkPlate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PageName = Literal["a4", "letter", "a3", "tabloid", "a2", "a1", "a0"]
PAGES_MM: dict[PageName, tuple[float, float]] = {
    "a4": (210.0, 297.0),
    "letter": (215.9, 279.4),
    "a3": (297.0, 420.0),
    "tabloid": (279.4, 431.8),
    "a2": (420.0, 594.0),
    "a1": (594.0, 841.0),
    "a0": (841.0, 1189.0),
}
"""Shorter and longer side."""
EDGE_MM = 12.0
"""White margin: most printers cannot print nearer than 4 to 6 mm to the edge."""
HEAD_MM = 9.0
"""The name of the sheet and its parameters, above the pattern."""
FOOT_MM = 25.0
"""The ruler across the page and what to do, below the pattern."""
BESIDE_MM = 22.0
"""The ruler down the page, on the right of the pattern."""
_LONG_STEP_MM = 50
_STEP_MM = 10
_LARGEST_SQUARE_MM = 50
_LINE_MM = 0.1
_INK = "black"
_GREY = "0.6"


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """A sheet as PDF, with the lengths on it that prove its size."""

    title: str
    """Name and parameters, as they are printed on it."""
    page: PageName
    width_mm: float
    height_mm: float
    ruler_mm: float
    """Length of the ruler across the page: the one that `--measured-mm` is read on."""
    ruler_down_mm: float
    square_mm: float
    """Side of the printed square; 0 if there is no room for it."""
    pdf: bytes
    board: Board | None = None
    """The board that is drawn."""
    plates: tuple[MarkPlate, ...] = ()
    """The plates with marks that are drawn."""


class Paper:
    """A page that is being drawn on; coordinates are mm from its top left corner, y down."""

    def __init__(self, page: PageName, *, upright: bool) -> None:
        short, long = PAGES_MM[page]
        self.page: PageName = page
        self.width_mm, self.height_mm = (short, long) if upright else (long, short)
        self.figure = _figure(self.width_mm, self.height_mm)
        self.axes = _axes(self.figure, self.width_mm, self.height_mm)
        self.square_mm = 0

    @classmethod
    def of_size(cls, page: PageName, width_mm: float, height_mm: float) -> "Paper":
        """A page of another size, such as a tile of fabric."""
        paper = cls(page, upright=True)
        paper.width_mm, paper.height_mm = width_mm, height_mm
        paper.figure = _figure(width_mm, height_mm)
        paper.axes = _axes(paper.figure, width_mm, height_mm)
        return paper

    @property
    def ruler_mm(self) -> int:
        """Length of the ruler across the page, a multiple of 50 mm."""
        return _LONG_STEP_MM * int((self.width_mm - 2 * EDGE_MM) // _LONG_STEP_MM)

    @property
    def room_mm(self) -> Float64[np.ndarray, "2"]:
        """Width and height that rulers and text leave for a pattern."""
        return np.array(
            [
                self.width_mm - 2 * EDGE_MM - BESIDE_MM,
                self.height_mm - 2 * EDGE_MM - HEAD_MM - FOOT_MM,
            ]
        )

    @property
    def origin_mm(self) -> Float64[np.ndarray, "2"]:
        """Top left corner of the pattern's room."""
        return np.array([EDGE_MM, EDGE_MM + HEAD_MM])

    def frame(self, title: str, size_mm: Sequence[float], advice: Sequence[str]) -> int:
        """Draw title, rulers, square and instructions round a pattern of this size.

        Returns the length of the ruler down the page, mm.
        """
        left, top = self.origin_mm.tolist()
        width, height = size_mm
        self.write(left, top - 4, f"limbgram {title}", 9)
        foot = top + height + 8
        self.ruler((left, foot), self.ruler_mm, down=False)
        down_mm = _STEP_MM * int(height // _STEP_MM)
        self.ruler((left + width + 8, top), down_mm, down=True)
        beside_mm = self.width_mm - 2 * EDGE_MM - width - BESIDE_MM
        if beside_mm >= _STEP_MM:
            self.square_mm = min(_LARGEST_SQUARE_MM, _STEP_MM * int(beside_mm // _STEP_MM))
            self.square(
                (self.width_mm - EDGE_MM - self.square_mm, top + height - self.square_mm),
                self.square_mm,
            )
        else:
            self.square_mm = _STEP_MM
            self.square((self.width_mm - EDGE_MM - _STEP_MM, foot + 9), _STEP_MM)
        words = (
            *advice,
            f"Measure the ruler above, {self.ruler_mm} mm, with a steel rule to a tenth of a "
            f"millimetre, and give what you read: --measured-mm {self.ruler_mm}.0",
        )
        for row, line in enumerate(words):
            self.write(left, foot + 11 + 4.2 * row, line, 7.5)
        return down_mm

    def fill(self, quads_mm: Float64[np.ndarray, "n 4 2"], colour: str = _INK) -> None:
        """Fill quadrangles as one path, without a stroke, which would enlarge them."""
        from matplotlib.patches import PathPatch
        from matplotlib.path import Path as Outline

        closed = np.concatenate([quads_mm, quads_mm[:, :1]], axis=1)
        step = [Outline.MOVETO, Outline.LINETO, Outline.LINETO, Outline.LINETO, Outline.CLOSEPOLY]
        codes = np.tile(np.array(step, np.uint8), len(closed))
        self.axes.add_artist(
            PathPatch(Outline(closed.reshape(-1, 2), codes), facecolor=colour, linewidth=0)
        )

    def fill_outlines(
        self, points_mm: Float64[np.ndarray, "n 2"], codes: np.ndarray, colour: str
    ) -> None:
        """Fill outlines with holes as one path; they must not overlap."""
        from matplotlib.patches import PathPatch
        from matplotlib.path import Path as Outline

        self.axes.add_artist(PathPatch(Outline(points_mm, codes), facecolor=colour, linewidth=0))

    def write(
        self,
        x: float,
        y: float,
        words: str,
        points: float,
        *,
        align: Literal["left", "center"] = "left",
        turned_deg: float = 0.0,
    ) -> None:
        self.axes.text(
            x,
            y,
            words,
            fontsize=points,
            ha=align,
            va="baseline",
            color=_INK,
            rotation=turned_deg,
            rotation_mode="anchor",
        )

    def cut_line(self, corner_mm: Sequence[float], size_mm: Sequence[float]) -> None:
        """A grey rectangle along which a piece is cut out."""
        x, y = corner_mm
        width, height = size_mm
        self.axes.plot(
            [x, x + width, x + width, x, x],
            [y, y, y + height, y + height, y],
            color=_GREY,
            linewidth=0.3,
        )

    def circle(self, middle_mm: Sequence[float], radius_mm: float) -> None:
        """A grey circle along which a piece is cut out, or in which something stands."""
        from matplotlib.patches import Circle

        x, y = middle_mm
        self.axes.add_artist(
            Circle((float(x), float(y)), radius_mm, fill=False, edgecolor=_GREY, linewidth=0.3)
        )

    def ruler(self, start_mm: tuple[float, float], length_mm: int, *, down: bool) -> None:
        """A tick every millimetre; its length is that between the centres of the end ticks."""
        x, y = start_mm
        marks: list[np.ndarray] = []
        for mark in range(length_mm + 1):
            long = 4.0 if mark % 10 == 0 else 2.6 if mark % 5 == 0 else 1.6
            box = rectangle(mark - _LINE_MM / 2, 0, _LINE_MM, long)
            marks.append((box[:, ::-1] if down else box) + (x, y))
        self.fill(np.array(marks))
        for mark in sorted({*range(0, length_mm, _LONG_STEP_MM), length_mm}):
            words = f"{mark} mm" if mark == length_mm else f"{mark}"
            if down:
                self.write(x + 5, y + mark + 0.9, words, 6)
            else:
                self.write(x + mark, y + 6.4, words, 6, align="center")

    def square(self, corner_mm: tuple[float, float], side_mm: float) -> None:
        """A square whose sides, between the centres of its lines, have the length written in it."""
        half = _LINE_MM / 2
        lines = [
            rectangle(-half, -half, side_mm + _LINE_MM, _LINE_MM),
            rectangle(-half, side_mm - half, side_mm + _LINE_MM, _LINE_MM),
            rectangle(-half, half, _LINE_MM, side_mm - _LINE_MM),
            rectangle(side_mm - half, half, _LINE_MM, side_mm - _LINE_MM),
        ]
        self.fill(np.array(lines) + corner_mm)
        middle = np.array(corner_mm) + side_mm / 2
        words = f"{side_mm:g} x {side_mm:g} mm" if side_mm > _STEP_MM else f"{side_mm:g} mm"
        self.write(middle[0], middle[1], words, 6, align="center")


def pdf_of(papers: Sequence[Paper], title: str) -> bytes:
    """The pages as one PDF, without a date, with TrueType fonts."""
    import matplotlib as mpl
    from matplotlib.backends.backend_pdf import FigureCanvasPdf, PdfPages

    file = io.BytesIO()
    about = {"CreationDate": None, "Creator": "limbgram", "Title": title}
    with mpl.rc_context({"pdf.fonttype": 42}), PdfPages(file, metadata=about) as pages:
        for paper in papers:
            FigureCanvasPdf(paper.figure)
            pages.savefig(paper.figure)
    return file.getvalue()


def rectangle(x: float, y: float, width: float, height: float) -> Float64[np.ndarray, "4 2"]:
    """Corners of a rectangle from its top left corner."""
    return np.array([(x, y), (x + width, y), (x + width, y + height), (x, y + height)], float)


def runs(black: np.ndarray) -> Iterable[tuple[int, int, int]]:
    """Row, start and end of each run of black cells."""
    for row, line in enumerate(black):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], line.astype(np.int8), [0]])))
        for start, end in edges.reshape(-1, 2).tolist():
            yield row, start, end


def _figure(width_mm: float, height_mm: float) -> "Figure":
    from matplotlib.figure import Figure

    return Figure(figsize=(width_mm / MM_PER_INCH, height_mm / MM_PER_INCH))


def _axes(figure: "Figure", width_mm: float, height_mm: float) -> "Axes":
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0, width_mm)
    axes.set_ylim(height_mm, 0)
    axes.axis("off")
    return axes
