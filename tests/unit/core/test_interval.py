"""How a ± is written: the interval that holds in 95 of 100, never one standard deviation."""

import re
from pathlib import Path

import numpy as np
import pytest

import limbgram
from limbgram.core.interval import (
    COVER,
    HOLDS,
    Interval,
    chi_square_tail,
    f_tail,
    plus_minus,
    rms,
    weighted_quantile,
    what_it_means,
    widening,
)


def test_a_plus_minus_holds_in_95_of_100_gaussian_errors() -> None:
    stated = Interval.of_sigma(0.3)
    errors = np.random.default_rng(8).normal(scale=0.3, size=200_000)
    held = float(np.mean((errors > -stated.below) & (errors < stated.above)))
    assert abs(held - 0.95) < 0.002
    assert "95 of 100" in HOLDS


@pytest.mark.parametrize("freedom", [1, 2, 3, 5, 10, 40])
def test_a_sigma_told_by_few_residuals_is_widened_until_it_holds_95_of_100(freedom: int) -> None:
    draw = np.random.default_rng(freedom)
    told = np.sqrt((draw.normal(size=(100_000, freedom)) ** 2).mean(axis=1))
    errors = np.abs(draw.normal(size=100_000))
    assert abs(np.mean(errors < COVER * widening(freedom) * told) - 0.95) < 0.003
    assert np.mean(errors < COVER * told) < 0.95


def test_sides_that_differ_are_both_written() -> None:
    assert plus_minus(Interval(0.12, 0.4), 2) == "+0.40 / -0.12"
    assert plus_minus(Interval(0.12, 0.4).over(0.1), 1) == "+4.0 / -1.2"
    assert plus_minus(Interval(0.401, 0.404), 2) == "± 0.40"


def test_a_small_width_is_not_written_as_nothing() -> None:
    assert plus_minus(Interval.of_sigma(0.01 / 1.96), 1) == "± 0.01"
    assert plus_minus(Interval(0.0, 0.0), 1) == "± 0.0"
    assert plus_minus(None, 2) == ""


def test_what_it_means_is_said_once_and_only_where_it_stands() -> None:
    for shown in (Interval.of_sigma(0.2), Interval(0.1, 0.4)):
        assert what_it_means([None, shown, shown]) == (f"{HOLDS}.",)
    assert what_it_means([None, None]) == what_it_means([]) == ()


def test_a_figure_gets_its_plus_minus_here_alone() -> None:
    """Written by hand a ± would be one standard deviation again: no other source writes one but
    what words an interval in a finding, and what types a reading as it was typed."""
    written = re.compile(r"(±|\+/-|\+-) ?\{")
    sources = Path(limbgram.__file__).parent.rglob("*.py")
    found = {path.name for path in sources if written.search(path.read_text("utf-8"))}
    assert found == {"interval.py", "tell.py", "parse_text.py"}


def test_a_weighted_quantile_is_that_of_values_repeated_so_often() -> None:
    rng = np.random.default_rng(4)
    values, times = rng.normal(size=60), rng.integers(1, 9, 60)
    repeated = np.sort(np.repeat(values, times))
    for share in (0.01, 0.25, 0.5, 0.95):
        expected = repeated[int(np.ceil(share * len(repeated))) - 1]
        assert weighted_quantile(values, times.astype(float), share) == expected


def test_tails_of_chi_square_and_f_are_those_of_the_tables() -> None:
    assert chi_square_tail(3.841459, 1) == pytest.approx(0.05, abs=1e-8)
    assert chi_square_tail(18.307038, 10) == pytest.approx(0.05, abs=1e-8)
    assert f_tail(4.102821, 2, 10) == pytest.approx(0.05, abs=1e-7)
    assert chi_square_tail(-1e-9, 2) == f_tail(-1.0, 2, 3) == 1.0  # rounding, not a doubt


def test_the_root_mean_square_is_that_of_numbers_or_of_lengths() -> None:
    vectors = np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 12.0]])
    assert rms(vectors) == rms(np.array([-5.0, 12.0])) == np.sqrt(84.5)
    assert np.isnan(rms(vectors[:0]))
