"""Sheets over time: a change is as probable as its sigmas say."""

from datetime import date, timedelta

import numpy as np
import pytest
from scipy.stats import norm

from limbgram.core.errors import MeasureError, OptionsError
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
    assert course.probability == pytest.approx(asked, abs=1e-9)


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
