"""Sheets over time: each figure of a measuring sheet at several visits, and whether it changed.

In      visits: a day and the sheet of that day, all of one kind and side.
Out     a course for every figure that two days or more have, with its trend and the probability
        that the change is real: that it goes the way it seems to, by the sigmas of the figures and,
        from three visits on, by their scatter (over_time.py).
Fails   OptionsError: fewer than two days. MeasureError: sheets of several kinds or sides.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from typing import Any

import numpy as np

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.interval import Interval
from limbgram.core.notebook import brief, data_frame, html_of
from limbgram.core.spreadsheet import Table
from limbgram.findings import Finding, note, told
from limbgram.workbench.compare.over_time import Trend, fit_trend
from limbgram.workbench.measures.levels import Figure
from limbgram.workbench.measures.sheet import MeasuringSheet

_BY_CHANCE = 0.05
"""Share of unchanged figures whose change seems clear."""
_COLUMNS = (
    "name",
    "measure",
    "unit",
    "first",
    "last",
    "change",
    "change_95",
    "per_week",
    "per_week_95",
    "probability",
    "visits",
)


@dataclass(frozen=True, kw_only=True)
class SheetVisit:
    """A filled measuring sheet and its day."""

    day: date
    sheet: MeasuringSheet


@dataclass(frozen=True, kw_only=True)
class FigureCourse:
    """One figure over time."""

    name: str
    words: Mapping[str, str]
    unit: str
    days: tuple[date, ...]
    figures: tuple[Figure, ...]
    trend: Trend
    """In the figure's unit per week."""

    @property
    def change(self) -> float:
        """The change from the first day to the last along the trend, so that all visits count."""
        return self.trend.per_week * self._weeks

    @property
    def change_within(self) -> Interval:
        """Where the true change lies in 95 of 100 cases."""
        return Interval.of_half_width(self.trend.per_week_95 * self._weeks)

    @property
    def _weeks(self) -> float:
        return (self.days[-1] - self.days[0]).days / 7


@dataclass(frozen=True, kw_only=True)
class SheetTrend:
    """The measuring sheets of a limb's visits, followed figure by figure."""

    visits: tuple[SheetVisit, ...]
    """In the order of their days."""
    courses: tuple[FigureCourse, ...]
    """Of every figure that two days have."""
    left_out: tuple[str, ...]
    """Names of the other figures."""
    notes: tuple[Finding, ...]

    __repr__ = brief

    @property
    def finding(self) -> Finding:
        """How many figures changed, and how many would seem to if none had."""
        days = [one.day for one in self.visits]
        return note(
            "trend.sheets",
            clear=sum(one.trend.is_clear for one in self.courses),
            measures=len(self.courses),
            days=(days[-1] - days[0]).days,
            visits=len(days),
            by_chance=_BY_CHANCE * len(self.courses),
        )

    def table(self, language: str = "en") -> Table:
        """A row for each figure: its change, and how sure that is."""
        return Table(
            title="trend",
            columns=_COLUMNS,
            rows=tuple(
                (
                    one.name,
                    one.words[language],
                    one.unit,
                    one.figures[0].value,
                    one.figures[-1].value,
                    one.change,
                    one.change_within.above,
                    one.trend.per_week,
                    one.trend.per_week_95,
                    one.trend.probability,
                    len(one.days),
                )
                for one in self.courses
            ),
        )

    def visits_table(self) -> Table:
        """A row for each figure of each visit."""
        return Table(
            title="visits",
            columns=("day", "name", "value", "unit", "sigma"),
            rows=tuple(
                (day, one.name, figure.value, one.unit, figure.sigma)
                for one in self.courses
                for day, figure in zip(one.days, one.figures, strict=True)
            ),
        )

    def to_frame(self) -> Any:
        """A pandas.DataFrame with a row for each figure.

        Raises:
            MissingError: pandas is not installed.
        """
        return data_frame(self.table())

    def _repr_html_(self) -> str:
        """The same table, for notebooks."""
        return html_of(self.table(), told(self.finding))


def follow_sheets(visits: Sequence[SheetVisit], notes: Sequence[Finding] = ()) -> SheetTrend:
    """Follow the measuring sheets of one limb.

    Args:
        notes: What is to be said of the shapes.

    Raises:
        OptionsError: fewer than two days.
        MeasureError: sheets of several kinds or sides, or without any figure on two days.
    """
    found = courses(visits)
    if not found:
        raise MeasureError("trend.no_figure")
    ordered = tuple(sorted(visits, key=lambda one: one.day))
    named = {one.name for one in found}
    asked = (row.name for one in ordered for row in one.sheet.rows)
    return SheetTrend(
        visits=ordered,
        courses=found,
        left_out=tuple(name for name in dict.fromkeys(asked) if name not in named),
        notes=tuple(notes),
    )


def courses(visits: Sequence[SheetVisit]) -> tuple[FigureCourse, ...]:
    """Follow every figure that has a sigma on two days or more.

    Of a figure that was measured by other landmarks on some days, those like the last one count.

    Raises:
        OptionsError: fewer than two days.
        MeasureError: sheets of several kinds or sides.
    """
    ordered = sorted(visits, key=lambda one: one.day)
    if len({one.day for one in ordered}) < 2:
        raise OptionsError("trend.one_day")
    if len({(one.sheet.kind, one.sheet.side) for one in ordered}) > 1:
        raise MeasureError("trend.sheets_differ")
    found: list[FigureCourse] = []
    for row in ordered[0].sheet.rows:
        rows = [
            (one.day, other.among_alike, other.stand_ins)
            for one in ordered
            for other in one.sheet.rows
            if other.name == row.name and other.among_alike is not None and other.among_alike.sigma
        ]
        known = [(day, figure) for day, figure, by in rows if by == rows[-1][2]]
        if len({day for day, _ in known}) >= 2:
            found.append(_course(row.name, row.words, row.unit, known))
    return tuple(found)


def _course(
    name: str, words: Mapping[str, str], unit: str, known: Sequence[tuple[date, Figure]]
) -> FigureCourse:
    trend = fit_trend(
        np.array([day.toordinal() for day, _ in known], np.float64),
        np.array([figure.value for _, figure in known]),
        np.array([figure.sigma for _, figure in known], np.float64),
    )
    return FigureCourse(
        name=name,
        words=words,
        unit=unit,
        days=tuple(day for day, _ in known),
        figures=tuple(figure for _, figure in known),
        trend=trend,
    )
