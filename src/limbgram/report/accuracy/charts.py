"""Charts and pictures of an assessment, each drawn once for the page and for the PDF.

Residuals by place: the mean residual of every cell of the picture as an arrow, on its RMS as a
shade; arrows nearer to none than SURE_SIGMAS of their standard errors are faint.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64

from limbgram.report.accuracy.assessment import Assessment
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.accuracy.figures import ResidualGrid
from limbgram.report.alignment import COMPARED_MM
from limbgram.report.drawings.drawing import (
    BLUE,
    INK,
    ORANGE,
    PALE_INK,
    Chart,
    Picture,
    plain,
    png,
)
from limbgram.report.drawings.maps import signed_map, size_map
from limbgram.report.drawings.surfaces import four_sides

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import LinearSegmentedColormap

SURE_SIGMAS = 2.5
_LETTERS = 7.0
_WIDTH_OF_LETTER = 0.66
"""Over its size: of digits and lower case of the usual sans serif, on average, and some air."""
_ROW_IN = 0.135
"""Height of a row of names."""
_SIGNED = (ORANGE, "#ffffff", BLUE)
_COUNTS = ("#ffffff", BLUE)
_CELL = "#dde4e8"


@dataclass(frozen=True)
class Series:
    """One series of a histogram, drawn as an outline."""

    label: str
    values: Sequence[float]
    colour: str


def histogram(edges: Sequence[float], series: Sequence[Series], unit: str, title: str) -> Chart:
    """A histogram chart of several series over each other."""

    def draw(axes: "Axes") -> None:
        _style_axes(axes, unit)
        for one in series:
            axes.stairs(
                one.values,
                edges,
                fill=True,
                facecolor=(one.colour, 0.7 if len(series) == 1 else 0.25),
                edgecolor=one.colour,
                linewidth=0.9,
                label=one.label,
            )
        axes.set_xlim(edges[0], edges[-1])
        axes.grid(axis="y", color=_CELL, lw=0.5)
        axes.set_axisbelow(True)
        if len(series) > 1:
            axes.legend(fontsize=_LETTERS, frameon=False)

    return Chart(draw=draw, title=title)


def curve(x: Sequence[float], y: Sequence[float], units: tuple[str, str], title: str) -> Chart:
    """A chart of points joined by a line, with the diagonal of equality."""

    def draw(axes: "Axes") -> None:
        _style_axes(axes, units[0])
        reach = 1.08 * max((*x, *y), default=1.0) or 1.0
        axes.plot([0, reach], [0, reach], color=PALE_INK, lw=0.8, ls="--")
        axes.plot(x, y, "o-", color=BLUE, lw=1.2, ms=3.5)
        axes.set_xlim(0, reach)
        axes.set_ylim(0, reach)
        axes.text(0.03, 0.97, units[1], transform=axes.transAxes, va="top", color=PALE_INK,
                  fontsize=_LETTERS)  # fmt: skip

    return Chart(draw=draw, title=title)


def bars(names: Sequence[str], values: Sequence[float], unit: str, title: str) -> Chart:
    """A chart of horizontal bars, each with a name and a figure."""

    def draw(axes: "Axes") -> None:
        letters = _letter_size_pt(axes, len(names))
        known = [value if math.isfinite(value) else 0.0 for value in values]
        top = max(known, default=0.0) or 1.0
        axes.barh(range(len(names)), known, 0.75, color=BLUE)
        letter = _WIDTH_OF_LETTER * letters / (72.0 * axes.bbox.width / axes.figure.dpi)
        reach = top
        for row, value in enumerate(values):
            words = f"{value:.3g} {unit}" if math.isfinite(value) else "not known"
            first = known[row] + 0.015 * top
            axes.text(first, row, words, va="center", color=PALE_INK, fontsize=letters)
            reach = max(reach, first / max(1 - letter * len(words), 0.1))
        axes.set_xlim(0, reach)
        axes.set_ylim(len(names) - 0.5, -0.5)
        _name_rows(axes, names)

    longest = max((len(name) for name in names), default=0)
    return Chart(
        draw=draw,
        title=title,
        height_in=max(0.3 + _ROW_IN * len(names), 0.8),
        left_in=min(0.1 + 0.056 * longest, 1.5),
        bottom_in=0.1,
    )


def vectors(grid: ResidualGrid, title: str) -> Chart:
    """A chart of the mean residual of every cell of the picture, as arrows."""
    tall = grid.height_px / grid.width_px
    across_in = 3.45
    return Chart(
        draw=partial(_draw_vectors, grid=grid),
        title=title,
        width_in=across_in,
        height_in=min(max(across_in * tall + 0.4, 1.5), 5.0),
        left_in=0.05,
        right_in=0.05,
        top_in=0.05,
        bottom_in=0.35,
    )


def correlations(names: Sequence[str], rows: Sequence[Sequence[float]], title: str) -> Chart:
    """A chart of the lower half of a correlation matrix, with figures."""

    def draw(axes: "Axes") -> None:
        matrix = np.array(rows, float)
        matrix[np.triu_indices(len(matrix), 1)] = np.nan
        axes.imshow(matrix, cmap=_colour_gradient(_SIGNED), vmin=-1, vmax=1, interpolation="none")
        letters = min(0.34 * _row_pt(axes, len(names)), 5.5)  # of the width of a cell
        for (row, column), value in np.ndenumerate(matrix):
            if column <= row:
                axes.text(
                    column, row, f"{value:.2f}", ha="center", va="center", fontsize=letters,
                    color="white" if abs(value) > 0.6 else INK,
                )  # fmt: skip
        _name_rows(axes, names)
        for column, name in enumerate(names):
            axes.text(column, -0.02, name, transform=axes.get_xaxis_transform(), ha="center",
                      va="top", fontsize=_letter_size_pt(axes, len(names)), color=INK)  # fmt: skip

    return Chart(draw=draw, title=title, height_in=2.6, left_in=0.5, bottom_in=0.3)


def counts(names: Sequence[str], rows: Sequence[Sequence[int]], title: str) -> Chart:
    """A chart of a matrix of counts as shades; its diagonal is left empty."""

    def draw(axes: "Axes") -> None:
        matrix = np.array(rows, float)
        np.fill_diagonal(matrix, 0.0)
        axes.imshow(
            matrix,
            cmap=_colour_gradient(_COUNTS),
            vmin=0,
            vmax=matrix.max() or 1.0,
            interpolation="none",
        )
        _name_rows(axes, names)

    longest = max((len(name) for name in names), default=0)
    return Chart(
        draw=draw,
        title=title,
        height_in=min(max(1.9, 0.2 + 0.1 * len(names)), 7.0),
        left_in=min(0.1 + 0.056 * longest, 1.5),
        bottom_in=0.1,
    )


def accuracy_pictures(evidence: Evidence, assessment: Assessment) -> tuple[Picture, ...]:
    """Error map where the truth is known; sigma map, or what was measured and what filled."""
    pictures: list[Picture] = []
    if assessment.off_mm is not None:
        pictures.append(_error_map(evidence, assessment.off_mm))
    if evidence.mesh.sigma_mm is not None:
        pictures.append(_sigma_map(evidence, evidence.mesh.sigma_mm.astype(np.float64)))
    else:
        drawing = four_sides(evidence.mesh, evidence.metric)
        title = "What was measured, and what was filled in"
        pictures.append(Picture("measured", title, drawing.caption, png(drawing.figure)))
    return tuple(pictures)


def _error_map(evidence: Evidence, off_mm: Float64[np.ndarray, " n"]) -> Picture:
    figure = signed_map(evidence.mesh, off_mm, "distance from the truth, mm (red: outside)")
    caption = (
        "Signed distance of every measured vertex from the truth. Grey: not compared, because "
        f"fewer than three photos see the truth there, or it lies {COMPARED_MM:g} mm or more from "
        "it; orange: filled in, not measured."
    )
    return Picture("error", "Where it is off", caption, png(figure))


def _sigma_map(evidence: Evidence, sigma_mm: Float64[np.ndarray, " n"]) -> Picture:
    label = f"sigma along the normal, {evidence.unit}"
    figure = size_map(evidence.mesh, sigma_mm, label, in_mm=evidence.unit == "mm")
    caption = (
        "How sure each place is: one standard deviation along the normal, cameras and scale "
        "included. Orange is filled in: no photo measured it."
    )
    return Picture("sigma", "How sure the surface is", caption, png(figure))


def _draw_vectors(axes: "Axes", grid: ResidualGrid) -> None:
    shape = grid.rows, grid.columns
    mean_x, mean_y, rms, seen = (
        np.array(values, float).reshape(shape)
        for values in (grid.mean_x_px, grid.mean_y_px, grid.rms_px, grid.observations)
    )
    size = np.hypot(mean_x, mean_y)
    longest = float(np.nanmax(size)) if np.isfinite(size).any() else 1e-9
    roughest = float(np.nanmax(rms)) if np.isfinite(rms).any() else 1e-9
    ends = (-0.5, grid.columns - 0.5, grid.rows - 0.5, -0.5)
    cell_px = grid.width_px / grid.columns, grid.height_px / grid.rows
    shades = _colour_gradient(("#ffffff", ORANGE))
    axes.imshow(np.where(np.isfinite(rms), rms, 0.0), cmap=shades, vmin=0, vmax=3 * roughest,
                extent=ends, interpolation="none")  # fmt: skip
    stretch = 0.8 / max(longest, 1e-9)  # in cells
    sure = size > SURE_SIGMAS * rms / np.sqrt(np.maximum(seen, 1))
    for chosen, strength in ((sure, 1.0), (~sure, 0.3)):
        rows, columns = np.nonzero(chosen & np.isfinite(size))
        axes.quiver(
            columns, rows, stretch * mean_x[rows, columns], stretch * mean_y[rows, columns],
            angles="xy", scale_units="xy", scale=1.0, color=BLUE, width=0.004, alpha=strength,
        )  # fmt: skip
    axes.vlines(np.arange(grid.columns + 1) - 0.5, ends[2], ends[3], color=_CELL, lw=0.5)
    axes.hlines(np.arange(grid.rows + 1) - 0.5, ends[0], ends[1], color=_CELL, lw=0.5)
    axes.set_xlim(*ends[:2])
    axes.set_ylim(*ends[2:])
    axes.set_aspect(cell_px[1] / cell_px[0])
    axes.set_axis_off()
    axes.text(
        0.5,
        -0.03,
        f"longest arrow {longest:.4f} px; faint: within {SURE_SIGMAS:g} sigmas of none;\n"
        f"darkest cell {roughest:.3f} px RMS",
        transform=axes.transAxes,
        ha="center",
        va="top",
        fontsize=6.0,
        color=INK,
    )


def _colour_gradient(colours: Sequence[str]) -> "LinearSegmentedColormap":
    """A colour map that blends between colours."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("shades", colours)


def _style_axes(axes: "Axes", unit: str) -> None:
    plain(axes).tick_params(labelsize=_LETTERS, labelcolor=INK)
    axes.set_xlabel(unit, fontsize=_LETTERS, color=INK)


def _letter_size_pt(axes: "Axes", rows: int) -> float:
    """Size of letters with which so many rows fit into axes, in points."""
    return max(min(_LETTERS, 0.85 * _row_pt(axes, rows)), 1.0)


def _row_pt(axes: "Axes", rows: int) -> float:
    return 72.0 * axes.bbox.height / axes.figure.dpi / max(rows, 1)


def _name_rows(axes: "Axes", names: Sequence[str]) -> None:
    """Names beside the rows: as letters, since the ticks of an axis take three times as long."""
    axes.set_axis_off()
    letters = _letter_size_pt(axes, len(names))
    for row, name in enumerate(names):
        axes.text(-0.015, row, name, transform=axes.get_yaxis_transform(), ha="right",
                  va="center", fontsize=letters, color=INK)  # fmt: skip
