"""A drawing: a figure and the sentence that explains it; colours that all drawings share."""

from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

INK, FAINT = "#22303a", "#8a97a0"
BLUE, ORANGE, GREEN, RED = "#2b6ca3", "#d9822b", "#3c8d5a", "#b8403a"


@dataclass(frozen=True)
class Drawing:
    """What a figure shows, in words for the page."""

    figure: Figure
    caption: str


def blank(width_in: float, height_in: float) -> Figure:
    """An empty figure."""
    return Figure(figsize=(width_in, height_in), layout="constrained", facecolor="white")


def plain(axes: Axes) -> Axes:
    """Axes without a box, in quiet ink."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(FAINT)
    axes.tick_params(colors=INK, labelsize=8)
    return axes
