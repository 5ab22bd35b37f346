"""Drawing of a limb's levels: where they lie on it, and all sections over each other.

All heights count from the reference. The sections are seen from above, as the trade draws them: the
front upwards, the patient's right to the right. In the front view, as when facing the patient, it
lies to the left; letters in the corners say so.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import UInt8

from limbgram.core.mesh.mesh import Mesh
from limbgram.report.drawings.drawing import (
    BLUE,
    FAINT,
    INK,
    ORANGE,
    Drawing,
    as_it_is,
    axes_at,
    bare,
    plain,
)
from limbgram.report.drawings.shading import Frame, looking_along, shade_all
from limbgram.report.drawings.views import BESIDE, FROM_ABOVE, letter_corners
from limbgram.workbench.measures.measuring import Measures, Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_HEIGHT_PX = 560
_HEIGHT_IN, _MOST_IN = 5.8, 14.0
"""Of the views, and what the figure may be wide."""
_TITLE_IN, _SCALE_IN = 0.28, 0.45
"""What stands over a view, and under it."""
_LEFT_IN, _BETWEEN_IN, _GIRTHS_IN, _BAR_IN, _RIGHT_IN = 0.55, 0.42, 1.2, 0.18, 0.6
"""Left of the views, between them, right of them, width of the bar of colours, right of that."""
_LEAST_IN = 2.5
"""Of the sections, however slender the limb is."""
_MOST_LABELS = 24
_MARGIN = 1.06
_COLOURS = "viridis"
_TITLE: Any = {"fontsize": 9, "color": FAINT, "y": 1.0}
"""At a given height: else it is looked for among the ticks."""
_TOWARDS = {90: "to the patient's left, mm", 0: "forwards, mm", 180: "backwards, mm"}
"""What lies to the right in a view, by its azimuth."""


def sections_drawing(measures: Measures) -> Drawing:
    """The limb from the front and from its outer side with its levels, and the sections."""
    mesh = measures.limb.mesh_in_limb
    outer_deg = 180 if measures.limb.side == "left" else 0
    rows = [row for row in measures.rows if row.level is not None]
    frames = [_frame(mesh, azimuth_deg) for azimuth_deg in (90, outer_deg)]
    figure = _panels(frames)
    front, beside, above, bar = figure.axes
    of_front, of_side = shade_all(mesh, frames)
    zero = measures.reference_mm
    _side(front, frames[0], of_front, rows, zero)
    front.set_xlabel(_TOWARDS[90], fontsize=8, color=INK)
    below = as_it_is(measures.reference_name)
    front.set_ylabel(f"height from the {below}, mm", fontsize=8, color=INK)
    front.set_title("front", **_TITLE)
    letter_corners(front, BESIDE[90])
    _side(beside, frames[1], of_side, rows, zero)
    beside.set_xlabel(_TOWARDS[outer_deg], fontsize=8, color=INK)
    side = "patient's left" if outer_deg else "patient's right"
    beside.set_title(f"from the {side}; girth by tape, mm", **_TITLE)
    letter_corners(beside, BESIDE[outer_deg])
    _label(beside, rows)
    _sections(above, bar, rows)
    return Drawing(
        figure,
        f"{len(rows)} levels. Heights count from {measures.reference_phrase}; "
        "the sections are seen from above, front upwards, the patient's right to the right; "
        "the front view has it left.",
    )


def _panels(frames: Sequence[Frame]) -> "Figure":
    """A figure with axes for both views, the sections, and the colours of their heights."""
    widths_px = [frame.width_px for frame in frames]
    room_px = [*widths_px, 1.2 * max(widths_px)]
    beside_in = _LEFT_IN + _BETWEEN_IN + _GIRTHS_IN + 2 * _BAR_IN + _RIGHT_IN
    inch = min(_HEIGHT_IN / _HEIGHT_PX, (_MOST_IN - beside_in) / sum(room_px))
    front_in, side_in, above_in = (inch * px for px in room_px)
    above_in, along_in = max(above_in, _LEAST_IN), inch * _HEIGHT_PX
    figure = bare(front_in + side_in + above_in + beside_in, _TITLE_IN + along_in + _SCALE_IN)
    left_in = _LEFT_IN
    for width_in, after_in in ((front_in, _BETWEEN_IN), (side_in, _GIRTHS_IN), (above_in, _BAR_IN)):
        axes_at(figure, left_in, _TITLE_IN, width_in, along_in)
        left_in += width_in + after_in
    axes_at(figure, left_in, _TITLE_IN + 0.2 * along_in, _BAR_IN, 0.6 * along_in)
    return figure


def _frame(mesh: Mesh, azimuth_deg: int) -> Frame:
    low, high = mesh.vertices_mm.min(0), mesh.vertices_mm.max(0)
    picture_from_limb = looking_along(azimuth_deg)
    span = _MARGIN * (high - low)
    pixel_mm = float(span[2]) / _HEIGHT_PX
    return Frame(
        picture_from_world=picture_from_limb,
        middle_mm=(low + high) / 2,
        pixel_mm=pixel_mm,
        width_px=max(1, int(float(np.abs(picture_from_limb[0] @ span)) / pixel_mm)),
        height_px=_HEIGHT_PX,
    )


def _side(
    axes: "Axes", frame: Frame, picture: UInt8[np.ndarray, "h w 4"], rows: list[Row], zero: float
) -> None:
    """The shaded limb from one side, in millimetres, its sections drawn as seen edge on."""
    from matplotlib.collections import LineCollection

    right = frame.picture_from_world[0]
    middle, height = right @ frame.middle_mm, frame.middle_mm[2] - zero
    half, tall = (frame.pixel_mm * size / 2 for size in (frame.width_px, frame.height_px))
    axes.imshow(picture, extent=(middle - half, middle + half, height - tall, height + tall))
    lines: list[np.ndarray] = []
    for row in rows:
        if row.level is not None:
            across = row.level.points_mm @ right[:2]
            ends = [float(across.min()), float(across.max())]
            lines.append(np.column_stack([ends, [row.from_reference_mm] * 2]))
    axes.add_collection(LineCollection(lines, colors=BLUE, linewidths=0.7))
    plain(axes)


def _label(axes: "Axes", rows: list[Row]) -> None:
    """Girths beside the levels, as many as can be read."""
    right = axes.get_xlim()[1]
    for row in rows[:: max(1, -(-len(rows) // _MOST_LABELS))]:
        girth = row.figures["tape_mm"]
        if girth is not None:
            text = f"{row.from_reference_mm:.0f}: {girth.value:.1f}"
            axes.text(right, row.from_reference_mm, text, fontsize=6.5, color=INK, va="center")


def _sections(axes: "Axes", beside: "Axes", rows: list[Row]) -> None:
    """All outlines over each other, coloured by height, as they lie seen from above."""
    from matplotlib.collections import LineCollection

    lines: list[np.ndarray] = []
    heights: list[float] = []
    for row in rows:
        if row.level is None:
            continue
        points = row.level.points_mm
        for loop in range(len(row.level.depth)):
            ring = points[row.level.loop == loop]
            lines.append(np.concatenate([ring, ring[:1]]))
            heights.append(row.from_reference_mm)
    drawn = LineCollection(lines, array=np.array(heights), cmap=_COLOURS, linewidths=0.9)
    axes.add_collection(drawn)
    axes.plot([0], [0], "+", color=ORANGE, ms=9)
    axes.set_aspect("equal")
    axes.autoscale()
    letter_corners(axes, FROM_ABOVE)
    plain(axes).set_title("sections from above, front upwards", **_TITLE)
    axes.set_xlabel("to the patient's right, mm", fontsize=8, color=INK)
    axes.set_ylabel(_TOWARDS[0], fontsize=8, color=INK)
    bar = axes.figure.colorbar(drawn, cax=beside)
    bar.set_label("height, mm", fontsize=8, color=INK)
    bar.ax.tick_params(labelsize=7, colors=INK)
