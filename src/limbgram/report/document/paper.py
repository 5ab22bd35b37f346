"""Paper: sheets of A4 that fill from top to bottom, and a PDF of them."""

import io
import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.backends.backend_pdf import FigureCanvasPdf, PdfPages
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from PIL import Image

from limbgram.report.drawings.drawing import FAINT, INK, Picture

PAGE_IN = (8.27, 11.69)
RULE = "#dde4e8"
_MARGIN_IN = 0.58
_BOTTOM_IN = 0.62
_LINE = 1.32
"""Height of a line, in heights of its letters."""
_CHARACTERS_PER_IN = 130.0
"""Letters of one point that fit on an inch, on average."""
_POINTS_PER_IN = 72.0
_PICTURE_DPI = 200
"""Of pictures on the sheets: their small print is still read."""


def pdf_of(figures: Sequence[Figure]) -> bytes:
    """Pages as a PDF; the same figures give the same bytes."""
    file = io.BytesIO()
    with PdfPages(file, metadata={"CreationDate": None, "Creator": "limbgram"}) as pages:
        for figure in figures:
            FigureCanvasPdf(figure)
            pages.savefig(figure, dpi=_PICTURE_DPI)
    return file.getvalue()


class Sheet:
    """One page and how far it is filled. Lengths in inches, letters in points."""

    def __init__(self) -> None:
        self.figure = Figure(figsize=PAGE_IN, facecolor="white")
        self.left_in = _MARGIN_IN
        self.width_in = PAGE_IN[0] - 2 * _MARGIN_IN
        self.down_in = _MARGIN_IN

    @property
    def room_in(self) -> float:
        """What is left above the foot."""
        return PAGE_IN[1] - _BOTTOM_IN - self.down_in

    def text(
        self, words: str, *, points: float = 8.0, colour: str = INK, weight: str = "normal"
    ) -> None:
        """A paragraph over the whole width."""
        letters = int(self.width_in * _CHARACTERS_PER_IN / points)
        self._lines(textwrap.wrap(words, letters), points, colour, weight)

    def heading(self, words: str) -> None:
        self.down_in += 0.12
        self._lines([words], 9.5, INK, "bold")
        self.down_in += 0.03

    def gap(self, height_in: float) -> None:
        self.down_in += height_in

    def foot(self, words: str) -> None:
        """A paragraph at the very bottom."""
        letters = int(self.width_in * _CHARACTERS_PER_IN / 6.5)
        self.figure.text(
            self._x(self.left_in),
            0.3 / PAGE_IN[1],
            textwrap.fill(words, letters),
            fontsize=6.5,
            color=FAINT,
        )

    def banner(self, badge: str, words: str, colour: str) -> None:
        """A coloured strip with a badge that nobody can overlook."""
        height_in = 0.5
        top = self._y(self.down_in + height_in)
        size = self.width_in / PAGE_IN[0], height_in / PAGE_IN[1]
        x = self._x(self.left_in)
        self.figure.add_artist(Rectangle((x, top), *size, color=colour, alpha=0.10, lw=0))
        self.figure.add_artist(Rectangle((x, top), 0.008, size[1], color=colour, lw=0))
        middle = self._y(self.down_in + height_in / 2)
        self.figure.text(
            self._x(self.left_in + 0.2), middle, badge, fontsize=15, weight="bold", color=colour,
            va="center",
        )  # fmt: skip
        lines = textwrap.wrap(words, 80)
        self.figure.text(
            self._x(self.left_in + 2.15), middle, "\n".join(lines[:3]), fontsize=8, color=INK,
            va="center",
        )  # fmt: skip
        self.down_in += height_in + 0.1

    def cards(self, cards: Sequence[tuple[str, str, str]]) -> None:
        """Question, answer and note side by side."""
        step_in = self.width_in / max(len(cards), 1)
        letters = int((step_in - 0.1) * _CHARACTERS_PER_IN / 6.5)
        for idx, (question, answer, note) in enumerate(cards):
            x = self._x(self.left_in + idx * step_in)
            for down_in, words, points, colour in (
                (0.0, question, 7.0, FAINT),
                (0.15, answer, 12.0, INK),
                (0.40, textwrap.fill(note, letters), 6.5, FAINT),
            ):
                y = self._y(self.down_in + down_in)
                self.figure.text(x, y, words, fontsize=points, color=colour, va="top")
        self.down_in += 0.7

    def picture(self, picture: Picture, most_in: float) -> None:
        """A picture over the whole width, or less if that would be too high."""
        image = np.asarray(Image.open(io.BytesIO(picture.png.tobytes())))
        tall = image.shape[0] / image.shape[1]
        height_in = min(self.width_in * tall, most_in)
        width_in = height_in / tall
        axes = self.figure.add_axes(
            (
                self._x(self.left_in + (self.width_in - width_in) / 2),
                self._y(self.down_in + height_in),
                width_in / PAGE_IN[0],
                height_in / PAGE_IN[1],
            )
        )
        axes.imshow(image, interpolation="none")  # as it is: no pixel is made twice
        axes.set_axis_off()
        self.down_in += height_in + 0.05

    def table(
        self,
        heads: Sequence[str],
        rows: Sequence[Sequence[str]],
        shares: Sequence[float],
        *,
        points: float = 7.0,
    ) -> None:
        """A table; heads that begin with # stand over columns of numbers, to the right.

        The last cell of a row that has fewer cells than there are heads is a sentence that is
        wrapped over the rest.
        """
        step_in = 1.55 * points / _POINTS_PER_IN
        columns_in = [self.width_in * share / sum(shares) for share in shares]
        for k, row in enumerate((heads, *rows)):
            y = self._y(self.down_in + step_in * 0.72)
            x_in, cells, lines = self.left_in, list(row), 1
            sentence = cells.pop() if len(cells) < len(heads) else None
            for head, cell, width_in in zip(heads, cells, columns_in):
                right = head.startswith("#")
                letters = max(4, int(width_in * _CHARACTERS_PER_IN / points))
                self.figure.text(
                    self._x(x_in + width_in - 0.08 if right else x_in),
                    y,
                    textwrap.shorten(cell.lstrip("#"), letters, placeholder=" …"),
                    fontsize=points,
                    color=INK,
                    weight="bold" if k == 0 else "normal",
                    ha="right" if right else "left",
                )
                x_in += width_in
            if sentence is not None:
                lines = self._sentence(x_in + 0.08, y, sentence, points)
            self.down_in += step_in + (lines - 1) * _LINE * points / _POINTS_PER_IN
            self._rule()
        self.down_in += 0.04

    def _sentence(self, x_in: float, y: float, words: str, points: float) -> int:
        """Words from a place to the right edge, first line at `y`; how many lines they took."""
        room_in = self.left_in + self.width_in - x_in
        lines = textwrap.wrap(words, max(4, int(room_in * _CHARACTERS_PER_IN / points)))
        down = _LINE * points / _POINTS_PER_IN / PAGE_IN[1]
        for number, line in enumerate(lines):
            self.figure.text(self._x(x_in), y - number * down, line, fontsize=points, color=FAINT)
        return max(1, len(lines))

    def rows_that_fit(self, reserve_in: float, points: float = 7.0) -> int:
        """Rows of a table below its head, with so much kept free below."""
        return max(0, int((self.room_in - reserve_in) / (1.55 * points / _POINTS_PER_IN)) - 1)

    def _lines(self, lines: Sequence[str], points: float, colour: str, weight: str) -> None:
        for line in lines:
            self.down_in += _LINE * points / _POINTS_PER_IN
            y = self._y(self.down_in - 0.3 * points / _POINTS_PER_IN)
            self.figure.text(
                self._x(self.left_in), y, line, fontsize=points, color=colour, weight=weight
            )

    def _rule(self) -> None:
        y = self._y(self.down_in)
        ends = self._x(self.left_in), self._x(self.left_in + self.width_in)
        self.figure.add_artist(Line2D(ends, (y, y), color=RULE, lw=0.6))

    def _x(self, from_left_in: float) -> float:
        return from_left_in / PAGE_IN[0]

    def _y(self, from_top_in: float) -> float:
        return 1 - from_top_in / PAGE_IN[1]
