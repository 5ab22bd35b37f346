"""Sides: views of a mesh from four sides round the world's z axis, in clay or in paint."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64

from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import is_inside_out
from limbgram.report.drawings.drawing import BELOW_PX, FAINT, axes_at, bare, scale_bar
from limbgram.report.drawings.shading import Frame, looking_along, shade
from limbgram.report.drawings.views import BESIDE, letter_corners

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_AZIMUTHS_DEG = (0, 90, 180, 270)
_SIDES = ("patient's right", "front", "patient's left", "back")
"""From where a mesh in the limb frame is looked at."""
_HEIGHT_PX = 520
_WIDTH_IN, _GAP_IN, _TITLE_IN = 10.5, 0.1, 0.3


def sides_figure(
    mesh: Mesh,
    paint: Float64[np.ndarray, "n 3"] | None,
    *,
    in_mm: bool,
    room_in: float = 0.05,
    sides: bool = False,
) -> "Figure":
    """Four sides of a mesh in clay or in the paint of its vertices; `room_in` is kept below.

    sides: it lies in the limb frame, so that its views are the patient's sides.

    The inside of a thing is drawn as a cast of it would look: all else would be its back.
    """
    if is_inside_out(mesh):
        mesh = replace(mesh, faces=np.ascontiguousarray(mesh.faces[:, ::-1]))
    low, high = mesh.vertices_mm.min(0), mesh.vertices_mm.max(0)
    width_mm = 1.08 * float(np.hypot(*(high - low)[:2]))
    height_mm = 1.04 * float(high[2] - low[2])
    pixel_mm = max(width_mm, height_mm) / _HEIGHT_PX
    width_px, height_px = int(width_mm / pixel_mm), int(height_mm / pixel_mm)
    across_in = (_WIDTH_IN - _GAP_IN) / 4 - _GAP_IN
    along_in = across_in * (height_px + BELOW_PX) / width_px
    figure = bare(_WIDTH_IN, _TITLE_IN + along_in + room_in)
    for number, (azimuth_deg, side) in enumerate(zip(_AZIMUTHS_DEG, _SIDES, strict=True)):
        left_in = _GAP_IN + number * (across_in + _GAP_IN)
        axes = axes_at(figure, left_in, _TITLE_IN, across_in, along_in)
        frame = Frame(
            picture_from_world=looking_along(azimuth_deg),
            middle_mm=(low + high) / 2,
            pixel_mm=pixel_mm,
            width_px=width_px,
            height_px=height_px,
        )
        axes.imshow(shade(mesh, frame, paint))
        axes.set_axis_off()
        axes.set_title(side if sides else f"{azimuth_deg}°", fontsize=9, color=FAINT, y=1.0)
        if sides:
            letter_corners(axes, BESIDE[azimuth_deg])
        if in_mm:
            scale_bar(axes, frame)
    return figure
