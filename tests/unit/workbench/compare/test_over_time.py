"""Trends and repeatability with truth: exact lines, textbook tables, limbs that shrink."""

from dataclasses import replace
from datetime import date, timedelta

import numpy as np
import pytest

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.findings import told
from limbgram.workbench.compare.comparison import CompareOptions
from limbgram.workbench.compare.over_time import (
    FollowOptions,
    Visit,
    bland_altman,
    fit_trend,
    follow,
    independent_levels,
    repeatability,
)
from limbgram.workbench.compare.registration import RegistrationOptions

AS_IS = FollowOptions(compare=CompareOptions(registration=RegistrationOptions(way="as-is")))
START = date(2026, 1, 5)


def test_two_values_have_the_textbook_sigma() -> None:
    found = fit_trend(np.array([0.0, 28]), np.array([500.0, 484]), np.full(2, 3.0))
    assert found.per_week == pytest.approx(-4)
    assert found.at_start == pytest.approx(500)
    assert found.per_week_95 == pytest.approx(1.96 * 3.0 * np.sqrt(2) / 4)
    assert found.scatter is None


def test_an_exact_line_comes_back_and_has_no_scatter() -> None:
    days = np.array([0.0, 7, 14, 28])
    found = fit_trend(days, 500 - 4 * days / 7, np.full(4, 3.0))
    assert found.per_week == pytest.approx(-4)
    assert found.at_start == pytest.approx(500)
    spread = np.sqrt(np.sum((days / 7 - 1.75) ** 2))
    assert found.per_week_95 == pytest.approx(1.96 * 3.0 / spread)
    assert found.scatter == pytest.approx(0, abs=1e-9)


def test_a_value_with_a_large_sigma_counts_little() -> None:
    days, values = np.array([0.0, 7, 14]), np.array([100.0, 110, 300])
    assert fit_trend(days, values, np.array([1.0, 1, 1e4])).per_week == pytest.approx(10, abs=0.01)


@pytest.mark.parametrize(
    "count",
    [3, *(pytest.param(count, marks=pytest.mark.slow) for count in (4, 6)), 10],
)
@pytest.mark.parametrize("understated", [1.0, 3.0])
def test_intervals_hold_the_true_slope_as_often_as_they_say(count: int, understated: float) -> None:
    rng = np.random.default_rng(count)
    days, stated = 7.0 * np.arange(count) ** 1.2, 0.5 + np.arange(count) % 3
    held = clear = 0
    for _ in range(2000):
        noise = understated * stated * rng.normal(size=count)
        found = fit_trend(days, 2 * days / 7 + noise, stated, known=False)
        held += abs(found.per_week - 2) < found.per_week_95
        clear += fit_trend(days, noise, stated, known=False).is_clear
    assert 0.93 < held / 2000 < 0.97
    assert 0.03 < clear / 2000 < 0.07


@pytest.mark.parametrize("count", [3, 4, 6, 10])
def test_three_scans_on_a_line_by_chance_are_no_surer_than_each_is(count: int) -> None:
    days = np.array([0.0, 7, 14])
    found = fit_trend(days, np.array([1000.0, 990, 980]), np.full(3, 10.0))
    assert found.per_week == pytest.approx(-10)
    assert found.per_week_95 == pytest.approx(1.96 * 10 / np.sqrt(2))
    assert not found.is_clear
    rng = np.random.default_rng(count)
    days, sigmas = 7.0 * np.arange(count), 0.5 + np.arange(count) % 3
    held = [
        abs(fit_trend(days, sigmas * noise, sigmas).per_week)
        < fit_trend(days, sigmas * noise, sigmas).per_week_95
        for noise in rng.normal(size=(2000, count))
    ]
    assert 0.94 < np.mean(held) < 0.995


SHROUT_FLEISS = np.array(
    [[9.0, 2, 5, 8], [6, 1, 3, 2], [8, 4, 6, 8], [7, 1, 2, 6], [10, 5, 6, 9], [6, 2, 4, 7]]
)
"""Table 2 of Shrout and Fleiss (1979): ICC(2,1) = .29."""


def test_icc_of_the_paper_that_defines_it() -> None:
    assert repeatability(SHROUT_FLEISS).icc_2_1 == pytest.approx(0.29, abs=0.005)


def test_repeatability_of_known_noise() -> None:
    rng = np.random.default_rng(5)
    table = rng.normal(100, 10, 400)[:, None] + rng.normal(0, 0.5, (400, 3))
    found = repeatability(table)
    assert found.within_sd == pytest.approx(0.5, rel=0.06)
    assert found.coefficient == pytest.approx(1.96 * np.sqrt(2) * found.within_sd, rel=0.01)
    assert found.icc_2_1 == pytest.approx(1 - 0.25 / 100.25, abs=1e-3)
    assert repeatability(np.array([[5.0, 6, 7]])).icc_2_1 is None
    with pytest.raises(MeasureError, match="two whole captures"):
        repeatability(np.array([[5.0]]))


@pytest.mark.parametrize("captures", [2, 3, 4, 6])
def test_two_captures_more_differ_by_less_than_the_coefficient_95_times_of_100(
    captures: int,
) -> None:
    rng = np.random.default_rng(captures)
    tables = rng.normal(500, 3.0, (4000, 1, captures + 2))
    held = [
        abs(table[0, -1] - table[0, -2]) < repeatability(table[:, :captures]).coefficient
        for table in tables
    ]
    assert 0.93 < np.mean(held) < 0.97


@pytest.mark.parametrize(
    ("captures", "alike"),
    [
        *((captures, 0.8) for captures in (2, 3, 4, 6)),
        *((captures, alike) for captures in (2, 6) for alike in (0.0, 1.0)),
        *(
            pytest.param(captures, alike, marks=pytest.mark.slow)
            for captures in (2, 3, 4, 6)
            for alike in (0.0, 0.5, 0.95, 1.0)
            if alike not in (0.0, 1.0) or captures not in (2, 6)
        ),
    ],
)
def test_girths_whose_errors_are_alike_along_the_limb_hold_as_often(
    captures: int, alike: float
) -> None:
    """`alike` is the correlation of neighbours: 1 where a capture errs by one size all over."""
    rng = np.random.default_rng(captures)
    errors = rng.normal(size=(25, 1000, captures + 2))
    for level in range(1, 25):
        errors[level] = alike * errors[level - 1] + np.sqrt(1 - alike**2) * errors[level]
    held = []
    for trial in range(1000):
        table = 300 + errors[:, trial, :captures]
        reach = repeatability(table, independent_levels(table)).coefficient
        held.append(np.mean(np.abs(errors[:, trial, -1] - errors[:, trial, -2]) < reach))
    assert 0.93 < np.mean(held) < 0.97


def test_bias_and_limits_of_agreement() -> None:
    first = np.array([10.0, 20, 30, 40])
    found = bland_altman(first, first + np.array([1.0, 2, 3, 2]))
    assert found.bias == pytest.approx(2)
    student = 3.182446  # of 3 degrees of freedom
    off = np.std([1, 2, 3, 2], ddof=1) * np.sqrt(1 + 1 / 4)
    assert found.high - found.low == pytest.approx(2 * student * off, rel=1e-6)
    with pytest.raises(MeasureError, match="two values"):
        bland_altman(first[:1], first[:1])


@pytest.mark.parametrize("count", [2, 3, 5, 20])
def test_one_difference_more_lies_within_the_limits_95_times_of_100(count: int) -> None:
    off = np.random.default_rng(count).normal(0.5, 1.0, (4000, count + 1))
    found = [bland_altman(np.zeros(count), one[:-1]) for one in off]
    held = [one.low < last < one.high for one, last in zip(found, off[:, -1], strict=True)]
    assert 0.93 < np.mean(held) < 0.97


@pytest.mark.parametrize("levels", [0.0, 2.0, 5.0, 10.0, np.inf])
def test_a_girth_of_another_pair_lies_within_the_limits_however_levels_err_together(
    levels: float,
) -> None:
    """Errors of 25 levels that are alike over so many of them, all of them in the end."""
    rng = np.random.default_rng(7)
    apart = np.abs(np.subtract.outer(np.arange(25.0), np.arange(25.0)))
    alike = np.exp(-apart / levels) if levels > 0 else np.eye(25)
    errors = np.linalg.cholesky(alike + 1e-9 * np.eye(25)) @ rng.normal(size=(25, 1000))
    others = rng.normal(size=(1000, 50))
    held = []
    for off, other in zip(errors.T, others, strict=True):
        table = 300 + np.column_stack([np.zeros(25), off])
        found = bland_altman(*table.T, independent_levels(table))
        held.append(np.mean((found.low < other) & (other < found.high)))
    assert 0.94 < np.mean(held) < 0.985


def shrunk(limb, share: float):
    scale = np.array([np.sqrt(1 + share), np.sqrt(1 + share), 1])
    return limb.with_mesh(limb.mesh.with_vertices(limb.mesh.vertices_mm * scale))


def visits_of(limb, shares: list[float], days: list[int]) -> list[Visit]:
    return [
        Visit(limb=shrunk(limb, share), day=START + timedelta(days=day))
        for share, day in zip(shares, days)
    ]


def test_a_limb_that_shrinks_by_two_per_cent_a_week(limb) -> None:
    found = follow(visits_of(limb, [0, -0.02, -0.04, -0.06], [0, 7, 14, 21])[::-1], AS_IS)
    start = found.stack.volumes_mm3[0]
    assert found.volume.per_week / start == pytest.approx(-0.02, abs=1e-6)
    assert found.volume.is_clear
    assert found.sigma_source == "assumed"
    assert found.change_mm3 / start == pytest.approx(-0.06, abs=1e-6)
    assert told(found.finding).startswith("The limb shrinks")
    wall = [trend.per_week for trend in found.girths[4:]]
    expected = found.stack.tapes_mm[0, 4:] * (np.sqrt(0.94) - 1) / 3
    np.testing.assert_allclose(wall, expected, rtol=0.02)


def test_a_change_within_the_uncertainty_is_called_that(limb) -> None:
    found = follow(visits_of(limb, [0, 0.004, -0.003], [0, 7, 14]), AS_IS)
    assert not found.volume.is_clear
    assert found.finding.code == "trend.none"
    assert abs(found.change_mm3) < found.change_95_mm3


def test_repeats_of_a_day_tell_the_sigma(limb) -> None:
    spread = [0.001, -0.001, 0.001, -0.001, 0.031, 0.029]
    found = follow(visits_of(limb, spread, [0, 0, 7, 7, 14, 14]), AS_IS)
    assert found.sigma_source == "repeats"
    student = 3.182446 / 1.96  # three days, each with one repeat
    expected = student * 0.001 * np.sqrt(2) * found.stack.volumes_mm3[0]
    assert found.volume_sigmas_mm3[0] == pytest.approx(expected, rel=0.01)


def test_scans_that_carry_sigmas_use_their_own(limb) -> None:
    known = replace(limb.mesh, sigma_mm=np.full(len(limb.mesh), 0.05, np.float32))
    scan = limb.with_mesh(known)
    found = follow(visits_of(scan, [0, -0.02], [0, 7]), AS_IS)
    assert found.sigma_source == "scans"
    assert 0 < found.volume_sigmas_mm3[0] < 0.01 * found.stack.volumes_mm3[0]


def test_scans_of_one_day_are_no_series(limb) -> None:
    with pytest.raises(OptionsError, match="one day"):
        follow(visits_of(limb, [0, 0.01], [3, 3]), AS_IS)
