"""Course: a limb's volume and girths over time, with trend and uncertainty."""

from datetime import timedelta
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes

from limbgram.geometry.interval import COVER
from limbgram.report.drawings.drawing import BLUE, FAINT, INK, ORANGE, Drawing, blank, plain
from limbgram.shape.comparing.following import Series

_MOST_TICKS = 12


def course(series: Series) -> Drawing:
    """Left the volume with its line, right the girth at every level less the first visit's."""
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
        f"{series.sentence} Bars: 95 %, {series.sigma_source}.",
    )


def _volume(axes: Axes, series: Series) -> None:
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
    axes.plot(ends, line, color=ORANGE, lw=1.5, ls="-" if series.volume.told else ":")
    axes.set_ylabel("volume, mL", fontsize=8, color=INK)


def _girths(axes: Axes, series: Series) -> None:
    days: Any = list(series.days)
    change_mm = series.stack.tapes_mm - series.stack.tapes_mm[0]
    shades = mpl.colormaps["viridis"](np.linspace(0.1, 0.9, len(series.stack.heights_mm)))
    axes.axhline(0.0, color=FAINT, lw=0.8)
    for k, height in enumerate(series.stack.heights_mm):
        axes.plot(days, change_mm[:, k], "o-", ms=3, lw=1, color=shades[k], label=f"{height:g} mm")
    axes.set_ylabel("tape girth less the first, mm", fontsize=8, color=INK)
    axes.legend(fontsize=6, frameon=False, ncols=2, title="height", title_fontsize=6)
