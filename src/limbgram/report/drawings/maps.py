"""Maps: the surface in the colours of a figure that every vertex has, from four sides."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64

from limbgram.core.mesh.mesh import Mesh
from limbgram.report.drawings.drawing import INK, axes_at
from limbgram.report.drawings.sides import sides_figure

if TYPE_CHECKING:
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

_UNKNOWN = np.array([205.0, 205.0, 205.0])
"""Colour of vertices that have no figure."""
_SHOWN_QUANTILE = 0.98
_LEAST_RANGE_MM = 0.5
_BAR_IN = 0.7
"""Room of the bar of colours below the views."""


def size_map(mesh: Mesh, values: Float64[np.ndarray, " n"], label: str, *, in_mm: bool) -> "Figure":
    """Figures from 0 up, light to dark; the largest 2 % share one colour."""
    from matplotlib.colors import Normalize

    reach = _reach(values)
    return _map(mesh, values, Normalize(0.0, reach), "YlOrRd", label, in_mm)


def signed_map(mesh: Mesh, values: Float64[np.ndarray, " n"], label: str) -> "Figure":
    """Millimetres about 0: blue below, white at it, red above."""
    from matplotlib.colors import Normalize

    reach = _reach(np.abs(values))
    return _map(mesh, values, Normalize(-reach, reach), "RdBu_r", label, in_mm=True)


def least_map(mesh: Mesh, values: Float64[np.ndarray, " n"], label: str) -> "Figure":
    """Figures in millimetres from the least, dark, to the middle one and beyond, light."""
    from matplotlib.colors import Normalize

    known = values[np.isfinite(values)]
    low, middle = (float(known.min()), float(np.median(known))) if len(known) else (0.0, 1.0)
    ends = Normalize(low, max(middle, low + 0.1))
    return _map(mesh, values, ends, "YlOrRd_r", label, in_mm=True)


def range_map(
    mesh: Mesh, values: Float64[np.ndarray, " n"], label: str, *, sides: bool = False
) -> "Figure":
    """Figures in millimetres from the least, dark, to the largest, light; half a millimetre apart
    at least, so that what is one thickness looks like one.

    sides: of the mesh in the limb frame, so that its views are the patient's sides.
    """
    from matplotlib.colors import Normalize

    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)
    middle, half = (low + high) / 2, max((high - low) / 2, _LEAST_RANGE_MM / 2)
    return _map(
        mesh,
        values,
        Normalize(middle - half, middle + half),
        "YlOrRd_r",
        label,
        in_mm=True,
        sides=sides,
    )


def _reach(sizes: Float64[np.ndarray, " n"]) -> float:
    known = sizes[np.isfinite(sizes)]
    return max(float(np.quantile(known, _SHOWN_QUANTILE)), 1e-9) if len(known) else 1.0


def _map(
    mesh: Mesh,
    values: Float64[np.ndarray, " n"],
    norm: "Normalize",
    colours: str,
    label: str,
    in_mm: bool,
    sides: bool = False,
) -> "Figure":
    import matplotlib as mpl
    from matplotlib.cm import ScalarMappable

    known = np.isfinite(values)
    shades = ScalarMappable(norm, mpl.colormaps[colours])
    paint = 255.0 * np.asarray(shades.to_rgba(np.where(known, values, 0.0)))[:, :3]
    paint[~known] = _UNKNOWN
    figure = sides_figure(mesh, paint, in_mm=in_mm, room_in=_BAR_IN, sides=sides)
    width_in, height_in = figure.get_size_inches()
    place = axes_at(figure, 0.2, height_in - _BAR_IN + 0.1, width_in - 0.4, 0.16)
    bar = figure.colorbar(shades, cax=place, orientation="horizontal")
    bar.set_label(label, fontsize=8, color=INK)
    bar.ax.tick_params(labelsize=8)
    return figure
