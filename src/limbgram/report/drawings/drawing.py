"""A drawing: a figure and the sentence that explains it; colours that all drawings share."""

import io
from dataclasses import dataclass

import numpy as np
from jaxtyping import UInt8
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

INK, FAINT = "#22303a", "#8a97a0"
BLUE, ORANGE, GREEN, RED = "#2b6ca3", "#d9822b", "#3c8d5a", "#b8403a"
_DOTS_PER_INCH = 110


@dataclass(frozen=True)
class Drawing:
    """What a figure shows, in words for the page."""

    figure: Figure
    caption: str


@dataclass(frozen=True)
class Picture:
    """One PNG and what it shows."""

    name: str
    """Of its file, without suffix."""
    title: str
    caption: str
    png: UInt8[np.ndarray, " n"]


def blank(width_in: float, height_in: float) -> Figure:
    """An empty figure."""
    return Figure(figsize=(width_in, height_in), layout="constrained", facecolor="white")


def plain(axes: Axes) -> Axes:
    """Axes without a box, in quiet ink."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(FAINT)
    axes.tick_params(colors=INK, labelsize=8)
    return axes


def png(figure: Figure) -> UInt8[np.ndarray, " n"]:
    """A figure as the bytes of a PNG."""
    file = io.BytesIO()
    FigureCanvasAgg(figure)
    figure.savefig(file, format="png", dpi=_DOTS_PER_INCH, metadata={"Software": "limbgram"})
    return np.frombuffer(file.getvalue(), np.uint8)
