"""Differences: a comparison of two shapes in pictures, from four sides, on one fixed scale.

The colours change at the clinical limits, 0.25 and 0.40 mm, and then double, so that pictures of
different visits can be laid side by side.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float64, UInt8

from limbgram.core.interval import COVER
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import told
from limbgram.report.drawings.drawing import FAINT, INK, Drawing, axes_at, bare
from limbgram.report.drawings.shading import Frame, looking_along, shade_each
from limbgram.report.drawings.views import BESIDE, letter_corners
from limbgram.workbench.compare.comparison import Comparison
from limbgram.workbench.compare.messages import IQR_LIMIT_MM, MRE_LIMIT_MM

if TYPE_CHECKING:
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import SubFigure

EDGES_MM = (MRE_LIMIT_MM, IQR_LIMIT_MM, 0.8, 1.6, 3.2, 6.4)
_OUTSIDE = ("#fbe3d2", "#f6bd98", "#e88a63", "#cf5246", "#a51f33", "#67001f")
_INSIDE = ("#dbe9f3", "#aed0e6", "#77aed3", "#3f86bd", "#22609d", "#0b2f5f")
_ALIKE = "#f3f2ee"
_OPEN = np.array([203.0, 190.0, 222.0])
"""Places whose difference how the shapes were laid could make: it means nothing there."""
_ANGLES_DEG = (0.0, 1.0, 2.0, 4.0, 8.0, 16.0)
_TURNED = ("#f3f2ee", "#fdf0c4", "#f7d275", "#e8a33d", "#c2691d", "#7d3a0b")
_UNKNOWN = np.array([150.0, 150.0, 150.0])
_SIDES = ((90, "front"), (0, "patient's right"), (270, "back"), (180, "patient's left"))
_HEIGHT_PX = 430
_WIDTH_IN = 10.5
_GAP_IN = 0.2
_TITLE_IN, _BELOW_IN = 0.4, 0.85
"""What stands over the views, and the room of the bar of colours under them."""
_BAR_IN = 0.17
_ACROSS_IN = (_WIDTH_IN - _GAP_IN) / len(_SIDES) - _GAP_IN
"""Width of a view."""
_LETTERS = 14
"""Points; on a sheet of paper the picture has less than half of its width."""


def difference_pictures(comparison: Comparison) -> Drawing:
    """The first shape in the colours of the signed difference, and of the turn of its normals."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import BoundaryNorm, ListedColormap

    mesh, on_first = comparison.first_in_limb, comparison.deviation.on_first
    low, high = mesh.vertices_mm.min(0), mesh.vertices_mm.max(0)
    tall = float(np.clip((high[2] - low[2]) / np.hypot(*(high - low)[:2]), 0.4, 3.0))
    figure = bare(_WIDTH_IN, 2 * (_TITLE_IN + _ACROSS_IN * tall + _BELOW_IN))
    upper, lower = np.asarray(figure.subfigures(2, 1))
    bands = ListedColormap((*reversed(_INSIDE[:-1]), _ALIKE, *_OUTSIDE[:-1]))
    bands = bands.with_extremes(under=_INSIDE[-1], over=_OUTSIDE[-1])
    edges = (*(-edge for edge in reversed(EDGES_MM)), *EDGES_MM)
    away = ScalarMappable(BoundaryNorm(edges, bands.N), bands)
    turned = ListedColormap(_TURNED[:-1]).with_extremes(over=_TURNED[-1])
    angles = ScalarMappable(BoundaryNorm(_ANGLES_DEG, turned.N), turned)
    in_open = ambiguous_vertices(comparison)
    of_difference = paint_of(on_first.difference_mm, away)
    of_difference[in_open] = _OPEN
    shaded = shade_each(
        mesh,
        [_frame(mesh, azimuth_deg) for azimuth_deg, _ in _SIDES],
        [of_difference, paint_of(on_first.normal_angle_deg, angles)],
    )
    of_away, of_angles = zip(*shaded, strict=True)
    anatomical = comparison.axes.anatomical
    _row(upper, of_away, anatomical)
    _bar(
        upper,
        away,
        edges,
        "mm: red, the second lies outside (of positives: room); blue, inside (pressure)",
    )
    _row(lower, of_angles, anatomical)
    _bar(lower, angles, _ANGLES_DEG, "surface-normal-angle error, degrees")
    return Drawing(figure, _caption(comparison, in_open))


def ambiguous_vertices(comparison: Comparison) -> Bool[np.ndarray, " n"]:
    """Vertices of the first that would be coloured, though how the shapes were laid could do it."""
    off_mm = np.abs(comparison.deviation.on_first.difference_mm)
    if comparison.laid_sigma_mm is None:
        return np.zeros(len(off_mm), bool)
    return (off_mm > MRE_LIMIT_MM) & (off_mm < COVER * comparison.laid_sigma_mm)


def paint_of(values: Float64[np.ndarray, " n"], colours: "ScalarMappable") -> np.ndarray:
    """Colour of each vertex, 0 to 255; grey where there is no figure."""
    known = np.isfinite(values)
    paint = 255.0 * np.asarray(colours.to_rgba(np.where(known, values, 0.0)))[:, :3]
    paint[~known] = _UNKNOWN
    return paint


def _row(
    figure: "SubFigure", pictures: Sequence[UInt8[np.ndarray, "h w 4"]], anatomical: bool
) -> None:
    along_in = _view_height_in(figure)
    lefts_in = _GAP_IN + (_ACROSS_IN + _GAP_IN) * np.arange(len(_SIDES))
    for left_in, (azimuth_deg, side), picture in zip(lefts_in, _SIDES, pictures, strict=True):
        axes = axes_at(figure, left_in, _TITLE_IN, _ACROSS_IN, along_in)
        axes.imshow(picture)
        axes.set_axis_off()
        title = side if anatomical else f"{azimuth_deg}°"
        axes.set_title(title, fontsize=12, color=FAINT, y=1.0)
        if anatomical:
            letter_corners(axes, BESIDE[azimuth_deg])


def _bar(
    figure: "SubFigure", colours: "ScalarMappable", edges: Sequence[float], label: str
) -> None:
    top_in = _TITLE_IN + _view_height_in(figure) + 0.1
    bar = figure.colorbar(
        colours,
        cax=axes_at(figure, _GAP_IN, top_in, _WIDTH_IN - 2 * _GAP_IN, _BAR_IN),
        orientation="horizontal",
        spacing="uniform",
        extend="both" if edges[0] < 0 else "max",
    )
    bar.set_ticks(edges)
    bar.minorticks_off()
    bar.ax.xaxis.set_major_formatter("{x:g}")
    bar.set_label(label, fontsize=_LETTERS, color=INK)
    bar.ax.tick_params(labelsize=_LETTERS)


def _view_height_in(figure: "SubFigure") -> float:
    """Height of the views in their half of the figure."""
    return figure.bbox.height / figure.dpi - _TITLE_IN - _BELOW_IN


def _frame(mesh: Mesh, azimuth_deg: int) -> Frame:
    low, high = mesh.vertices_mm.min(0), mesh.vertices_mm.max(0)
    width_mm = 1.04 * float(np.hypot(*(high - low)[:2]))
    height_mm = 1.02 * float(high[2] - low[2])
    pixel_mm = max(width_mm, height_mm) / _HEIGHT_PX
    return Frame(
        picture_from_world=looking_along(azimuth_deg),
        middle_mm=(low + high) / 2,
        pixel_mm=pixel_mm,
        width_px=int(width_mm / pixel_mm),
        height_px=int(height_mm / pixel_mm),
    )


def _caption(comparison: Comparison, in_open: Bool[np.ndarray, " n"]) -> str:
    figures = comparison.deviation.on_first.figures
    lilac = (
        " Lilac: how the shapes were laid on each other could make the difference (95 of 100)."
        if in_open.any()
        else ""
    )
    return (
        f"{comparison.names[1]} against {comparison.names[0]}, drawn on the latter; mean "
        f"{figures.mean_mm:+z.2f} mm, {figures.rms_mm:.2f} mm RMS, 95 % within "
        f"{figures.p95_mm:.2f} mm. Grey: no counterpart (brim, or filled in).{lilac} Alignment: "
        f"{told(comparison.alignment.how)}"
    )
