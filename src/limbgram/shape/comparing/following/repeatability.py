"""Repeatability: how far scans of one unchanged thing lie apart.

The figures of the literature: repeatability coefficient 1.96 sqrt(2) s_w (Bland and Altman 1999),
ICC(2,1) for absolute agreement (Shrout and Fleiss 1979), Bland-Altman bias and limits (1986).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.errors import MeasureError
from limbgram.geometry.interval import COVER


@dataclass(frozen=True, kw_only=True)
class Repeatability:
    """Of a table of subjects by captures."""

    within_sd: float
    """Standard deviation of one capture about its subject's mean."""
    coefficient: float
    """Two captures of one thing differ by less than this 95 times of 100."""
    icc_2_1: float | None
    """Share of the variance that is the subjects' own; None for one subject."""


@dataclass(frozen=True, kw_only=True)
class BlandAltman:
    """Of pairs of captures: second less first."""

    bias: float
    low: float
    high: float
    """Limits of agreement: 95 of 100 differences lie between them."""


def repeatability(table: Float64[np.ndarray, "s c"]) -> Repeatability:
    """Subjects in rows, captures in columns.

    Raises:
        MeasureError: fewer than two captures.
    """
    subjects, captures = table.shape
    if captures < 2 or subjects < 1 or not np.isfinite(table).all():
        raise MeasureError(
            f"Repeatability needs two whole captures of a thing or more; there are {captures} of "
            f"{subjects}. Scan the same unchanged limb again."
        )
    within = float(((table - table.mean(1, keepdims=True)) ** 2).sum() / subjects / (captures - 1))
    return Repeatability(
        within_sd=float(np.sqrt(within)),
        coefficient=float(COVER * np.sqrt(2 * within)),
        icc_2_1=None if subjects < 2 else _icc_2_1(table),
    )


def bland_altman(
    first: Float64[np.ndarray, " n"], second: Float64[np.ndarray, " n"]
) -> BlandAltman:
    """Bias and limits of agreement of two captures of the same subjects.

    Raises:
        MeasureError: fewer than two subjects.
    """
    if len(first) < 2:
        raise MeasureError(
            f"Limits of agreement need two values or more; there are {len(first)}. Compare at "
            "more levels."
        )
    off = second - first
    bias, spread = float(off.mean()), COVER * float(off.std(ddof=1))
    return BlandAltman(bias=bias, low=bias - spread, high=bias + spread)


def _icc_2_1(table: Float64[np.ndarray, "s c"]) -> float:
    """Two-way random effects, absolute agreement, single capture."""
    n, k = table.shape
    mean, rows, columns = table.mean(), table.mean(1), table.mean(0)
    between = k * float(((rows - mean) ** 2).sum()) / (n - 1)
    judges = n * float(((columns - mean) ** 2).sum()) / (k - 1)
    rest = table - rows[:, None] - columns + mean
    error = float((rest**2).sum()) / ((n - 1) * (k - 1))
    below = between + (k - 1) * error + k * (judges - error) / n
    return (between - error) / below if below > 0 else 1.0
