"""Time course: a limb's volume and girths over time, with trend and uncertainty.

Rectification: a template unrolled, and what it did to a limb from four sides.
"""

from datetime import timedelta
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float64

from limbgram.core.interval import COVER
from limbgram.findings import told
from limbgram.report.drawings.drawing import (
    BLUE,
    FAINT,
    INK,
    ORANGE,
    Drawing,
    as_it_is,
    blank,
    plain,
)
from limbgram.workbench.compare.over_time import Series
from limbgram.workbench.templates.template import Template

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize

_MOST_TICKS = 12


def course_drawing(series: Series) -> Drawing:
    """A drawing of the volume with its trend, and of girths less the first visit's."""
    figure = blank(10.5, 3.8)
    left, right = (plain(axes) for axes in figure.subplots(1, 2))
    _volume(left, series)
    _girths(right, series)
    ticks: Any = sorted(set(series.days))
    for axes in (left, right):
        axes.set_xticks(ticks[:: -(-len(ticks) // _MOST_TICKS)])
        axes.tick_params(axis="x", rotation=30)
    return Drawing(
        figure,
        f"{told(series.finding)} Bars: 95 %, {series.sigma_source}.",
    )


def _volume(axes: "Axes", series: Series) -> None:
    days: Any = list(series.days)
    volumes_ml = series.stack.volumes_mm3 / 1000
    axes.errorbar(
        days,
        volumes_ml,
        COVER * series.volume_sigmas_mm3 / 1000,
        fmt="o",
        color=BLUE,
        ecolor=FAINT,
        capsize=3,
        ms=5,
    )
    weeks = (series.days[-1] - series.days[0]).days / 7
    line = (series.volume.at_start + np.array([0, weeks]) * series.volume.per_week) / 1000
    ends: Any = [series.days[0], series.days[0] + timedelta(weeks=weeks)]
    axes.plot(ends, line, color=ORANGE, lw=1.5, ls="-" if series.volume.is_clear else ":")
    axes.set_ylabel("volume, mL", fontsize=8, color=INK)


def _girths(axes: "Axes", series: Series) -> None:
    import matplotlib as mpl

    days: Any = list(series.days)
    change_mm = series.stack.tapes_mm - series.stack.tapes_mm[0]
    shades = mpl.colormaps["viridis"](np.linspace(0.1, 0.9, len(series.stack.heights_mm)))
    axes.axhline(0.0, color=FAINT, lw=0.8)
    for k, height in enumerate(series.stack.heights_mm):
        axes.plot(days, change_mm[:, k], "o-", ms=3, lw=1, color=shades[k], label=f"{height:g} mm")
    axes.set_ylabel("tape girth less the first, mm", fontsize=8, color=INK)
    axes.legend(fontsize=6, frameon=False, ncols=2, title="height", title_fontsize=6)


_LEAST_MM = 1.0


def unrolled_template(template: Template) -> Drawing:
    """Left the displacements over height and angle with the landmarks, right their spread."""
    from matplotlib.colors import Normalize

    figure = blank(10.5, 4.4)
    left, right = (plain(axes) for axes in figure.subplots(1, 2))
    moved, spread = template.displacement_mm, template.spread_mm
    reach = max(float(np.abs(moved).max(initial=0.0)), _LEAST_MM)
    _map(
        left,
        template,
        moved,
        Normalize(-reach, reach),
        "RdBu_r",
        "mm: + outward (room), - inward (pressure)",
    )
    if np.isfinite(spread).any():
        most = max(float(np.nanmax(spread)), 1e-3)
        _map(right, template, spread, Normalize(0.0, most), "YlOrRd", "spread between pairs, mm")
    else:
        right.set_axis_off()
        right.text(0.5, 0.5, "one pair: no spread", color=FAINT, ha="center", fontsize=9)
    share = float((moved != 0).mean())
    return Drawing(
        figure,
        f"{template.name}: pairs {template.pairs}, {moved.min():+z.1f} to {moved.max():+z.1f} "
        f"mm along the normal, red outward (room), blue inward (pressure); {share:.0%} of the "
        "surface is changed.",
    )


def _map(
    axes: "Axes",
    template: Template,
    field: Float64[np.ndarray, "h a"],
    norm: "Normalize",
    colours: str,
    label: str,
) -> None:
    """The front in the middle, lateral to the right."""
    half = field.shape[1] // 2
    turned = np.roll(field, half, axis=1)
    turned = np.concatenate([turned, turned[:, :1]], axis=1)
    angles = np.linspace(-180, 180, turned.shape[1])
    mesh = axes.pcolormesh(
        angles, template.heights, turned, norm=norm, cmap=colours, shading="gouraud"
    )
    for mark in template.marks:
        axes.plot(mark.angle_deg, mark.height, "+", color=INK, ms=8)
        axes.annotate(
            as_it_is(mark.name),
            (mark.angle_deg, mark.height),
            (4, 4),
            textcoords="offset points",
            fontsize=7,
            color=INK,
        )
    axes.set_xticks([-180, -90, 0, 90, 180], ["back", "medial", "front", "lateral", "back"])
    axes.set_ylabel(f"height: 1 at {as_it_is(template.reference)}", fontsize=8, color=INK)
    bar = axes.figure.colorbar(mesh, ax=axes, fraction=0.05, aspect=30)
    bar.set_label(label, fontsize=8, color=INK)
    bar.ax.tick_params(labelsize=8)
