"""Sheets over time: each figure of a measuring sheet at several visits, and whether it changed.

In      visits: a day and the sheet of that day, all of one kind and side.
Out     a course for every figure that two days or more have, with its trend and the probability
        that the change is real: that it goes the way it seems to, by the sigmas of the figures.
Fails   OptionsError: fewer than two days. MeasureError: sheets of several kinds or sides.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date

import numpy as np
from scipy.special import ndtr

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.interval import COVER
from limbgram.workbench.compare.following import Trend, fit_trend
from limbgram.workbench.measures.levels import Figure
from limbgram.workbench.measures.sheet import MeasuringSheet


@dataclass(frozen=True, kw_only=True)
class SheetVisit:
    """A filled form and its day."""

    day: date
    sheet: MeasuringSheet


@dataclass(frozen=True, kw_only=True)
class Course:
    """One figure over time."""

    name: str
    words: Mapping[str, str]
    unit: str
    days: tuple[date, ...]
    figures: tuple[Figure, ...]
    trend: Trend
    """In the figure's unit per week."""
    probability: float
    """That the change has the sign that it seems to have: 0.5 where nothing is known of it."""


def courses(visits: Sequence[SheetVisit]) -> tuple[Course, ...]:
    """Follow every figure that has a sigma on two days or more.

    Raises:
        OptionsError: fewer than two days.
        MeasureError: sheets of several kinds or sides.
    """
    ordered = sorted(visits, key=lambda one: one.day)
    if len({one.day for one in ordered}) < 2:
        raise OptionsError("trend.one_day")
    if len({(one.sheet.kind, one.sheet.side) for one in ordered}) > 1:
        raise MeasureError("trend.sheets_differ")
    found: list[Course] = []
    for row in ordered[0].sheet.rows:
        known = [
            (one.day, other.figure)
            for one in ordered
            for other in one.sheet.rows
            if other.name == row.name and other.figure is not None and other.figure.sigma
        ]
        if len({day for day, _ in known}) >= 2:
            found.append(_course(row.name, row.words, row.unit, known))
    return tuple(found)


def _course(
    name: str, words: Mapping[str, str], unit: str, known: Sequence[tuple[date, Figure]]
) -> Course:
    trend = fit_trend(
        np.array([day.toordinal() for day, _ in known], np.float64),
        np.array([figure.value for _, figure in known]),
        np.array([figure.sigma for _, figure in known], np.float64),
    )
    sigma = trend.per_week_95 / COVER
    return Course(
        name=name,
        words=words,
        unit=unit,
        days=tuple(day for day, _ in known),
        figures=tuple(figure for _, figure in known),
        trend=trend,
        probability=float(ndtr(abs(trend.per_week) / max(sigma, 1e-300))),
    )
