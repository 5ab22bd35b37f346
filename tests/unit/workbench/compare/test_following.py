"""Trends and repeatability with truth: exact lines, textbook tables, limbs that shrink."""

from dataclasses import replace
from datetime import date, timedelta

import numpy as np
import pytest

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.workbench.compare.comparison import CompareOptions
from limbgram.workbench.compare.following import (
    FollowOptions,
    Visit,
    bland_altman,
    fit_trend,
    follow,
    repeatability,
)
from limbgram.workbench.compare.registration import RegistrationOptions

AS_IS = FollowOptions(compare=CompareOptions(registration=RegistrationOptions(way="as-is")))
START = date(2026, 1, 5)


def test_an_exact_line_comes_back_with_the_textbook_sigma() -> None:
    days, sigma = np.array([0.0, 7, 14, 28]), 3.0
    found = fit_trend(days, 500 - 4 * days / 7, np.full(4, sigma))
    assert found.per_week == pytest.approx(-4)
    assert found.at_start == pytest.approx(500)
    weeks = days / 7
    textbook = sigma / np.sqrt(((weeks - weeks.mean()) ** 2).sum())
    assert found.per_week_95 == pytest.approx(1.96 * textbook, rel=1e-3)
    assert found.scatter == pytest.approx(0, abs=1e-9)


def test_a_value_with_a_large_sigma_counts_little() -> None:
    days, values = np.array([0.0, 7, 14]), np.array([100.0, 110, 300])
    assert fit_trend(days, values, np.array([1.0, 1, 1e4])).per_week == pytest.approx(10, abs=0.01)


def test_intervals_hold_the_true_slope_as_often_as_they_say() -> None:
    rng = np.random.default_rng(3)
    days = np.array([0.0, 7, 14, 21, 35, 49])
    held = clear = 0
    for _ in range(600):
        found = fit_trend(days, 2 * days / 7 + rng.normal(0, 1.5, 6), np.full(6, 1.5))
        held += abs(found.per_week - 2) < found.per_week_95
        clear += fit_trend(days, rng.normal(0, 1.5, 6), np.full(6, 1.5)).is_clear
    assert 0.94 < held / 600 < 0.995
    assert 0.005 < clear / 600 < 0.06


def test_scatter_beyond_the_sigmas_widens_the_interval() -> None:
    days, values = np.array([0.0, 7, 14, 21]), np.array([0.0, 9, -8, 2])
    wide, calm = fit_trend(days, values, np.ones(4)), fit_trend(days, values / 50, np.ones(4))
    assert wide.per_week_95 == pytest.approx(wide.scatter * calm.per_week_95)
    assert wide.scatter > 5


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
    assert found.coefficient == pytest.approx(1.96 * np.sqrt(2) * found.within_sd)
    assert found.icc_2_1 == pytest.approx(1 - 0.25 / 100.25, abs=1e-3)
    assert repeatability(np.array([[5.0, 6, 7]])).icc_2_1 is None
    with pytest.raises(MeasureError, match="two whole captures"):
        repeatability(np.array([[5.0]]))


def test_bias_and_limits_of_agreement() -> None:
    first = np.array([10.0, 20, 30, 40])
    found = bland_altman(first, first + np.array([1.0, 2, 3, 2]))
    assert found.bias == pytest.approx(2)
    assert found.high - found.low == pytest.approx(2 * 1.96 * np.std([1, 2, 3, 2], ddof=1))
    with pytest.raises(MeasureError, match="two values"):
        bland_altman(first[:1], first[:1])


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
    assert found.sentence.startswith("The limb shrinks")
    wall = [trend.per_week for trend in found.girths[4:]]
    expected = found.stack.tapes_mm[0, 4:] * (np.sqrt(0.94) - 1) / 3
    np.testing.assert_allclose(wall, expected, rtol=0.02)


def test_a_change_within_the_uncertainty_is_called_that(limb) -> None:
    found = follow(visits_of(limb, [0, 0.004, -0.003], [0, 7, 14]), AS_IS)
    assert not found.volume.is_clear
    assert found.sentence.startswith("No trend can be told")
    assert abs(found.change_mm3) < found.change_95_mm3


def test_repeats_of_a_day_tell_the_sigma(limb) -> None:
    spread = [0.001, -0.001, 0.001, -0.001, 0.031, 0.029]
    found = follow(visits_of(limb, spread, [0, 0, 7, 7, 14, 14]), AS_IS)
    assert found.sigma_source == "repeats"
    expected = 0.001 * np.sqrt(2) * found.stack.volumes_mm3[0]
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
