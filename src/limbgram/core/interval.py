"""Intervals: 95 % intervals of figures, and how a ± is written.

Everywhere that people read, ± is the 95 % interval: "± b" if it is symmetric, "+a / -b" if not. A
standard deviation is always called sigma, in JSON, in the library and under headings for experts.
A text with a ± says `HOLDS` once.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from scipy.special import chdtrc, fdtrc, stdtrit

from limbgram.findings.tell import half_width_text

COVER = 1.96
"""Half width of the 95 % interval of a normal distribution, in standard deviations."""
MAD_TO_SIGMA = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""
RAYLEIGH_MEDIAN = 1.1774
"""Median distance of points that scatter with sigma 1 in both coordinates."""
_COVERAGE = 0.95
HOLDS = "± holds in 95 of 100"
"""Said once on a page or print with a ±."""


@dataclass(frozen=True)
class Interval:
    """How far the true value may lie below and above the stated one: the 95 % interval."""

    below: float
    above: float

    @classmethod
    def of_sigma(cls, sigma: float) -> "Interval":
        """Symmetric, from a standard deviation."""
        return cls(COVER * sigma, COVER * sigma)

    @classmethod
    def of_half_width(cls, half_width: float) -> "Interval":
        """Symmetric, from the half width of a 95 % interval."""
        return cls(half_width, half_width)

    def over(self, unit: float) -> "Interval":
        """The interval of the figure divided by `unit`, as when its unit changes."""
        return Interval(self.below / unit, self.above / unit)


def length_within(
    vector: Float64[np.ndarray, " k"], covariance: Float64[np.ndarray, "k k"]
) -> tuple[float, float, float]:
    """Length of a vector, and the ends of its 95 % interval.

    The lower end takes the sigma along the vector; the upper one the largest sigma of any
    direction, as the true direction may be another one.
    """
    length = float(np.linalg.norm(vector))
    along = vector / max(length, 1e-300)
    sigma = float(np.sqrt(max(along @ covariance @ along, 0.0)))
    largest_sigma = float(np.sqrt(max(np.linalg.eigvalsh(covariance)[-1], 0.0)))
    return length, max(length - COVER * sigma, 0.0), length + COVER * largest_sigma


def widening(degrees_of_freedom: float) -> float:
    """Factor for a standard deviation estimated from few residuals (Student 1908).

    `COVER` times the widened sigma is then the 95 % interval. A sigma is widened where it is
    estimated; all other code treats it as known.

    >>> round(COVER * widening(1), 1), round(COVER * widening(5), 2), round(widening(1e6), 3)
    (12.7, 2.57, 1.0)
    """
    return float(stdtrit(max(degrees_of_freedom, 1.0), 0.5 + _COVERAGE / 2)) / COVER


def rms(values: Float64[np.ndarray, "n ..."]) -> float:
    """Root mean square of numbers, or of the lengths of vectors; NaN of none.

    >>> rms(np.array([[3.0, 4.0], [0.0, 0.0]])) == rms(np.array([5.0, 0.0]))
    True
    """
    if not len(values):
        return float("nan")
    return float(np.sqrt((values.reshape(len(values), -1) ** 2).sum(axis=1).mean()))


def weighted_quantile(
    values: Float64[np.ndarray, " n"], weights: Float64[np.ndarray, " n"], share: float
) -> float:
    """The least value such that the values up to it have this share of the weight."""
    order = np.argsort(values, kind="stable")
    cumulated = np.cumsum(weights[order])
    at = min(int(np.searchsorted(cumulated, share * cumulated[-1])), len(order) - 1)
    return float(values[order][at])


def plus_minus(interval: Interval | None, decimals: int) -> str:
    """Write "± 0.25", or "+0.40 / -0.12"; empty if the interval is not known.

    A side that would round to zero keeps one significant digit.

    >>> plus_minus(Interval.of_sigma(0.5), 2)
    '± 0.98'
    >>> plus_minus(Interval(0.12, 0.4), 2)
    '+0.40 / -0.12'
    """
    if interval is None:
        return ""
    above = half_width_text(interval.above, decimals)
    below = half_width_text(interval.below, decimals)
    return f"± {above}" if above == below else f"+{above} / -{below}"


def what_it_means(shown: Iterable[Interval | None]) -> tuple[str, ...]:
    """The line that explains ±, if one of the figures shown has an interval."""
    return () if all(one is None for one in shown) else (f"{HOLDS}.",)


def chi_square_tail(value: float, degrees_of_freedom: int) -> float:
    """Survival function of chi-square; scipy.stats, which has it, takes a second to import."""
    return float(chdtrc(degrees_of_freedom, max(value, 0.0)))


def f_tail(ratio: float, numerator_dof: int, denominator_dof: int) -> float:
    """Survival function of the F distribution."""
    return float(fdtrc(numerator_dof, denominator_dof, max(ratio, 0.0)))
