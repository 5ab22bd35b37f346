"""Sheets over time: a change is as probable as its sigmas say."""

from dataclasses import replace
from datetime import date, timedelta

import numpy as np
import pytest
from scipy.stats import linregress, norm

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.workbench.compare.over_time import fit_trend
from limbgram.workbench.compare.sheets import SheetVisit, courses
from limbgram.workbench.limb import Side
from limbgram.workbench.measures.levels import Figure
from limbgram.workbench.measures.sheet import MeasuringSheet, SheetRow

FIRST = date(2026, 3, 2)


def visit(weeks: int, value: float | None, sigma: float = 0.5, side: Side = "none") -> SheetVisit:
    row = SheetRow(
        name="cva_mm",
        words={"en": "Asymmetry", "de": "Asymmetrie"},
        formula="",
        figure=None if value is None else Figure(value, sigma),
        placing_sigma=None,
        reason=None,
    )
    sheet = MeasuringSheet(kind="head", side=side, shape="", rows=(row,))
    return SheetVisit(day=FIRST + timedelta(weeks=weeks), sheet=sheet)


@pytest.mark.parametrize("change", [0.0, 0.4, -1.5])
def test_a_change_is_as_probable_as_its_sigmas_say(change: float) -> None:
    (course,) = courses([visit(4, 9.0 + change), visit(0, 9.0)])
    assert course.trend.per_week == pytest.approx(change / 4)
    asked = norm.cdf(abs(change) / (0.5 * np.sqrt(2)))
    assert course.trend.probability == pytest.approx(asked, abs=1e-9)


def test_what_a_visit_lacks_is_left_out_and_others_are_refused() -> None:
    (course,) = courses([visit(0, 9.0), visit(2, None), visit(4, 7.0)])
    assert len(course.figures) == 2
    assert courses([visit(0, 9.0), visit(2, None)]) == ()
    with pytest.raises(OptionsError) as one_day:
        courses([visit(0, 9.0), visit(0, 8.0)])
    assert one_day.value.finding.code == "trend.one_day"
    with pytest.raises(MeasureError) as mixed:
        courses([visit(0, 9.0), visit(1, 8.0, side="left")])
    assert mixed.value.finding.code == "trend.sheets_differ"


def test_a_figure_by_other_landmarks_is_no_change() -> None:
    """An ankle's angle differs by 10 degrees where the tubercle stands in for the condyle."""
    instead = visit(4, 82.0)
    (row,) = instead.sheet.rows
    rows = (replace(row, stand_ins=("tibial tubercle",)),)
    instead = replace(instead, sheet=replace(instead.sheet, rows=rows))
    assert courses([visit(0, 92.0), instead]) == ()
    (course,) = courses([visit(0, 92.0), instead, visit(8, 91.0)])
    assert [figure.value for figure in course.figures] == [92.0, 91.0]


def test_figures_by_the_same_stand_ins_are_followed_by_their_sigma_among_each_other() -> None:
    """They are off by the same, and so have no interval beside the true figure."""

    def by_stand_ins(weeks: int, value: float) -> SheetVisit:
        one = visit(weeks, value)
        (row,) = one.sheet.rows
        bare = replace(
            row, figure=Figure(value, None), sigma_alike=0.5, stand_ins=("tibial tubercle",)
        )
        return replace(one, sheet=replace(one.sheet, rows=(bare,)))

    (alike,) = courses([by_stand_ins(0, 82.0), by_stand_ins(4, 80.0)])
    (usual,) = courses([visit(0, 92.0), visit(4, 90.0)])
    assert (alike.change, alike.change_within) == (usual.change, usual.change_within)
    assert alike.trend.probability == usual.trend.probability
    assert courses([visit(0, 92.0), by_stand_ins(4, 80.0)]) == ()


def test_scatter_makes_the_probability_students_and_sigmas_bound_it() -> None:
    days, values = np.array([0.0, 7, 21, 28]), np.array([9.0, 8.1, 8.4, 7.2])
    line = linregress(days, values)
    by_scatter = fit_trend(days, values, np.full(4, 0.01), known=False)
    assert by_scatter.probability == pytest.approx(1 - line.pvalue / 2, abs=1e-9)
    for sigma in (0.01, 1.0):
        known = fit_trend(days, values, np.full(4, sigma))
        by_sigma = norm.cdf(abs(line.slope) * np.sqrt(((days - days.mean()) ** 2).sum()) / sigma)
        assert known.probability == pytest.approx(min(by_sigma, 1 - line.pvalue / 2), abs=1e-9)
        assert known.is_clear == (known.probability > 0.975)
