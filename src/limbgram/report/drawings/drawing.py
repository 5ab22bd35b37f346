"""A drawing: a figure and the sentence that explains it; colours that all drawings share.

Drawings import matplotlib where they draw: with what it needs it takes half a second, which a job
that is refused, and a server that starts, do without.
"""

import io
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import UInt8
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from limbgram.report.drawings.shading import Frame

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

INK, FAINT = "#22303a", "#8a97a0"
PALE_INK = "#55636c"
"""Of small print: dark enough for a printer."""
BLUE, ORANGE, GREEN, RED = "#2b6ca3", "#d9822b", "#3c8d5a", "#b8403a"
_DOTS_PER_INCH = 110
_COMPRESSION = 4
"""Of PNG files: a third of the usual level's time, for 7 % more bytes."""


BELOW_PX = 20
"""Room below a view, for its scale bar."""


@dataclass(frozen=True)
class Drawing:
    """What a figure shows, in words for the page."""

    figure: "Figure"
    caption: str


@dataclass(frozen=True)
class Picture:
    """One PNG and what it shows."""

    name: str
    """Of its file, without suffix."""
    title: str
    caption: str
    png: UInt8[np.ndarray, " n"]


@dataclass(frozen=True, kw_only=True)
class Chart:
    """A diagram in one pair of axes, drawn as vectors wherever it is put."""

    draw: "Callable[[Axes], None]"
    title: str
    """Read out to those who cannot see it."""
    width_in: float = 3.45
    height_in: float = 1.9
    left_in: float = 0.5
    right_in: float = 0.12
    top_in: float = 0.1
    bottom_in: float = 0.42
    """Room beside the axes for ticks and labels."""

    def draw_on(self, figure: "Figure", width_in: float, height_in: float) -> None:
        """Draw it on a figure of this size."""
        self.draw(
            axes_at(
                figure,
                self.left_in,
                self.top_in,
                width_in - self.left_in - self.right_in,
                height_in - self.top_in - self.bottom_in,
            )
        )

    def svg(self, name: str, width_in: float, height_in: float) -> str:
        """The chart alone, as SVG with words as text; `name` keeps its inner names apart."""
        import matplotlib as mpl
        from matplotlib.backends.backend_svg import FigureCanvasSVG
        from matplotlib.figure import Figure

        with mpl.rc_context(
            {"svg.fonttype": "none", "svg.hashsalt": name, "text.parse_math": False}
        ):
            figure = Figure(figsize=(width_in, height_in), facecolor="none")
            self.draw_on(figure, width_in, height_in)
            file = io.StringIO()
            FigureCanvasSVG(figure).print_svg(file, metadata={"Date": None})
        return file.getvalue()


def blank(width_in: float, height_in: float) -> "Figure":
    """An empty figure."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width_in, height_in), layout="constrained", facecolor="white")


def bare(width_in: float, height_in: float) -> "Figure":
    """An empty figure for axes at known places: to search for places costs as much as drawing."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width_in, height_in), facecolor="white")


def axes_at(
    figure: "Figure | SubFigure", left_in: float, top_in: float, width_in: float, height_in: float
) -> "Axes":
    """Axes whose upper left corner is so far from that of the figure."""
    across_in, along_in = figure.bbox.width / figure.dpi, figure.bbox.height / figure.dpi
    bottom = 1 - (top_in + height_in) / along_in
    return figure.add_axes(
        (left_in / across_in, bottom, width_in / across_in, height_in / along_in)
    )


def plain(axes: "Axes") -> "Axes":
    """Axes without a box, in quiet ink."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(FAINT)
    axes.tick_params(colors=INK, labelsize=8)
    return axes


def as_it_is(words: str) -> str:
    """Words for axes, which would read what stands between two dollar signs as a formula."""
    return words.replace("$", r"\$")


def scale_bar(axes: "Axes", frame: Frame) -> None:
    """A bar of a round length below a view."""
    length_mm = next(mm for mm in (100, 50, 20, 10, 5, 1) if mm < frame.width_px * frame.pixel_mm)
    length_px = length_mm / frame.pixel_mm
    y_px = frame.height_px + 12
    axes.plot([0, length_px], [y_px, y_px], color=INK, lw=1.5, clip_on=False)
    axes.text(length_px + 6, y_px, f"{length_mm} mm", fontsize=7, color=INK, va="center")
    axes.set_xlim(-0.5, frame.width_px - 0.5)
    axes.set_ylim(frame.height_px + BELOW_PX, -0.5)


def png(figure: "Figure") -> UInt8[np.ndarray, " n"]:
    """A figure as the bytes of a PNG; the ground of all figures is opaque."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure.set_dpi(_DOTS_PER_INCH)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    about = PngInfo()
    about.add_text("Software", "limbgram")
    file = io.BytesIO()
    colours = np.ascontiguousarray(np.asarray(canvas.buffer_rgba())[:, :, :3])
    dots_per_inch = (_DOTS_PER_INCH, _DOTS_PER_INCH)
    Image.fromarray(colours).save(
        file, "png", compress_level=_COMPRESSION, pnginfo=about, dpi=dots_per_inch
    )
    return np.frombuffer(file.getvalue(), np.uint8)
