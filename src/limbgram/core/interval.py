"""Intervals: how far a true value may lie from a stated one, and how a ± is written.

What a person reads first, on the terminal, a page, a record or a PDF, is one thing everywhere: ± is
the interval that holds in 95 of 100, "± b" where both sides are alike and "+a / -b" where they are
not. One standard deviation (sigma) is written by its name alone, in JSON, in the library and under
headings for experts. A text with a ± says `HOLDS` once.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from scipy.special import chdtrc, fdtrc, stdtrit

COVER = 1.96
"""Standard deviations to either side that hold 95 of 100 Gaussian errors."""
MAD_TO_SIGMA = 1.4826
"""Standard deviation of a Gaussian over the median of its absolute deviations."""
_COVERAGE = 0.95
HOLDS = "± holds in 95 of 100"
"""What a page or print with a ± says once."""


@dataclass(frozen=True)
class Interval:
    """How far the true value may lie below and above the stated one, in 95 of 100 cases."""

    below: float
    above: float

    @classmethod
    def of_sigma(cls, sigma: float) -> "Interval":
        """Both sides alike, from one standard deviation."""
        return cls(COVER * sigma, COVER * sigma)

    @classmethod
    def of_half_width(cls, half_width: float) -> "Interval":
        """Both sides alike, from a half width that holds in 95 of 100 already."""
        return cls(half_width, half_width)

    def over(self, unit: float) -> "Interval":
        """The same in a unit that is so many times as large."""
        return Interval(self.below / unit, self.above / unit)


def length_within(
    vector: Float64[np.ndarray, " k"], covariance: Float64[np.ndarray, "k k"]
) -> tuple[float, float, float]:
    """Length of a vector, and between which lengths it lies in 95 of 100 cases.

    Below by its spread along itself; above by its spread where that is largest, as another
    direction may be the true one.
    """
    length = float(np.linalg.norm(vector))
    along = vector / max(length, 1e-300)
    sigma = float(np.sqrt(max(along @ covariance @ along, 0.0)))
    most = float(np.sqrt(max(np.linalg.eigvalsh(covariance)[-1], 0.0)))
    return length, max(length - COVER * sigma, 0.0), length + COVER * most


def widening(freedom: float) -> float:
    """What a standard deviation that was told by few residuals is multiplied by (Student 1908).

    `COVER` of the widened one hold 95 of 100, as of one that is known. Whoever makes a sigma from
    residuals widens it there, so that all who read it may take it for known.

    >>> round(COVER * widening(1), 1), round(COVER * widening(5), 2), round(widening(1e6), 3)
    (12.7, 2.57, 1.0)
    """
    return float(stdtrit(max(freedom, 1.0), 0.5 + _COVERAGE / 2)) / COVER


def weighted_quantile(
    values: Float64[np.ndarray, " n"], weights: Float64[np.ndarray, " n"], share: float
) -> float:
    """The first value, from the least up, with which this share of the weight is reached."""
    order = np.argsort(values, kind="stable")
    reached = np.cumsum(weights[order])
    at = min(int(np.searchsorted(reached, share * reached[-1])), len(order) - 1)
    return float(values[order][at])


def plus_minus(interval: Interval | None, decimals: int) -> str:
    """Write "± 0.25", or "+0.40 / -0.12"; nothing where the interval is not known.

    A side keeps one digit at least: what is smaller than the decimals is not written as nothing.

    >>> plus_minus(Interval.of_sigma(0.5), 2)
    '± 0.98'
    >>> plus_minus(Interval(0.12, 0.4), 2)
    '+0.40 / -0.12'
    """
    if interval is None:
        return ""
    above, below = _side(interval.above, decimals), _side(interval.below, decimals)
    return f"± {above}" if above == below else f"+{above} / -{below}"


def what_it_means(shown: Iterable[Interval | None]) -> tuple[str, ...]:
    """The line that says what ± means, below figures of which one has it."""
    return () if all(one is None for one in shown) else (f"{HOLDS}.",)


def _side(width: float, decimals: int) -> str:
    if 0 < width < 0.5 * 10.0**-decimals:
        decimals = min(-math.floor(math.log10(width)), 9)
    return f"{width:.{decimals}f}"


def chi_square_tail(value: float, freedom: int) -> float:
    """Probability that a chi-square is larger; all of scipy.stats takes a second to import."""
    return float(chdtrc(freedom, max(value, 0.0)))


def f_tail(ratio: float, over: int, under: int) -> float:
    """Probability that an F of `over` and `under` degrees of freedom is larger."""
    return float(fdtrc(over, under, max(ratio, 0.0)))
