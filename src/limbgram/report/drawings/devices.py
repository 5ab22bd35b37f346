"""Devices: a finished device from four sides in the colours of its wall, and its measures."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from limbgram.findings import told
from limbgram.report.drawings.drawing import INK, PALE_INK, Drawing, as_it_is, axes_at
from limbgram.report.drawings.maps import range_map
from limbgram.report.intended_use import NOT_TESTED
from limbgram.workbench.devices.making import FinishedDevice
from limbgram.workbench.limb import Side

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLUMNS = 2
_LINE_IN, _HEAD_IN, _FOOT_IN = 0.2, 0.45, 0.75


def device_drawing(made: FinishedDevice, side: Side) -> Drawing:
    """The drawing that goes with a device."""
    device, values = made.preview.device, made.preview.values
    measures = device.measures(made.preview.made)
    lines = [
        f"{one.en}: {values[one.name]:g} {one.name.rpartition('_')[2]} "
        f"({one.within.least:g} to {one.within.most:g})"
        for one in measures
    ]
    figure = range_map(made.solid, made.thickness_mm, "thickness of the wall, mm", sides=True)
    title = device.en if side == "none" else f"{device.en}, {side}"
    _with_lines(figure, title, lines, [told(one) for one in made.findings])
    return Drawing(figure, f"{title}. {NOT_TESTED}")


def _with_lines(figure: "Figure", title: str, lines: Sequence[str], below: Sequence[str]) -> None:
    """Title and measures under the views, which keep their size."""
    width_in, height_in = figure.get_size_inches()
    rows = -(-len(lines) // _COLUMNS)
    more_in = _HEAD_IN + rows * _LINE_IN + _FOOT_IN
    whole_in = height_in + more_in
    places = [axes.get_position() for axes in figure.axes]
    figure.set_size_inches(width_in, whole_in)
    for axes, place in zip(figure.axes, places, strict=True):
        bottom = (place.y0 * height_in + more_in) / whole_in
        axes.set_position((place.x0, bottom, place.width, place.height * height_in / whole_in))
    room = axes_at(figure, 0.2, height_in, width_in - 0.4, more_in)
    room.set_axis_off()
    room.set_xlim(0, 1)
    room.set_ylim(more_in, 0)
    room.text(0, 0.25, title, fontsize=11, color=INK, weight="bold", va="center")
    for number, line in enumerate(lines):
        column, row = divmod(number, rows)
        at = _HEAD_IN + (row + 0.5) * _LINE_IN
        room.text(column / _COLUMNS, at, line, fontsize=7.5, color=INK, va="center")
    foot = as_it_is(" ".join(f"{one[:1].upper()}{one[1:]}" for one in below))
    room.text(0, more_in - 0.1, foot, fontsize=7, color=PALE_INK, va="bottom", wrap=True)
