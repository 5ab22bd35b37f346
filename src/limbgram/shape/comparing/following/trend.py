"""Trend: a straight line through values over time, with what is known of its slope."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from scipy.special import ndtri

_COVERAGE = 0.95


@dataclass(frozen=True, kw_only=True)
class Trend:
    """Weighted least squares. Uncertainties hold with 95 %."""

    per_week: float
    """Slope, in the values' unit."""
    per_week_95: float
    """Half the width of its interval."""
    at_start: float
    """The line's value on the first day."""
    scatter: float | None
    """Root mean square of residuals over their sigmas; None for two values."""

    @property
    def told(self) -> bool:
        """Whether a change can be told from none."""
        return abs(self.per_week) > self.per_week_95


def fit_trend(
    days: Float64[np.ndarray, " n"],
    values: Float64[np.ndarray, " n"],
    sigmas: Float64[np.ndarray, " n"],
) -> Trend:
    """The line through two values or more on two days or more.

    Where the values scatter more than their sigmas say, the slope's sigma grows in proportion
    (Birge 1932).
    """
    weeks = (days - days.min()) / 7.0
    columns = np.column_stack([np.ones_like(weeks), weeks]) / sigmas[:, None]
    covariance = np.linalg.inv(columns.T @ columns)
    line = covariance @ columns.T @ (values / sigmas)
    sigma = float(np.sqrt(covariance[1, 1]))
    scatter = None
    if len(values) > 2:
        residuals = (values - line[0] - line[1] * weeks) / sigmas
        scatter = float(np.sqrt(residuals @ residuals / (len(values) - 2)))
    reach = float(ndtri(0.5 + _COVERAGE / 2)) * max(1.0, scatter or 0.0)
    return Trend(
        per_week=float(line[1]),
        per_week_95=reach * sigma,
        at_start=float(line[0]),
        scatter=scatter,
    )
