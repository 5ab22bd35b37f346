"""Score tests and variance components on normal equations.

In      normal equations over unknowns of any units, some of which may not be observed at all.
Out     score statistics and p-values of directions, and the spread of random effects per photo.
Method  Rao's score test (1948); restricted maximum likelihood (Patterson and Thompson 1971).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from limbgram.core.interval import chi_square_tail, f_tail

MIN_SPREAD = 1e-3
"""Smallest spread, as a fraction of the usual one: less counts as zero."""
SIGNIFICANCE_LEVEL = 1e-5
"""p-value below which a term is significant, all candidates of its kind counted."""
VERY_STRONG_EVIDENCE = 10.0
"""Difference of twice the log-likelihood that is very strong (Kass and Raftery 1995)."""
SPREAD_MARGIN = 2.0
"""Factor on the spread of lenses at which a term must still be significant: 4 on the variance."""
RELATIVE_DAMPING = 1e-9
"""Damping relative to each diagonal entry: keeps equations with a free world frame solvable."""
MIN_WEIGHT = 1e-30
"""Diagonal entry below which an unknown counts as unobserved."""
_MIN_REMAINING_SHARE = 1e-8
"""Share of a diagonal entry that must survive an elimination: less is rounding."""
_PRIOR_DECADES = 1.0
"""Standard deviation of the log-normal prior of a spread, in powers of ten: a tripod has a
hundredth of the spread of a hand-held phone."""


@dataclass(frozen=True)
class NormalEquations:
    """Normal matrix and right-hand side of a log-likelihood.

    Twice the log-likelihood is 2 right x - x normal x, up to a constant.
    """

    normal: Float64[np.ndarray, "u u"]
    right: Float64[np.ndarray, " u"]

    def restricted_to(self, columns: Float64[np.ndarray, "u k"]) -> "NormalEquations":
        """The equations for x = columns y, over y."""
        return NormalEquations(columns.T @ self.normal @ columns, columns.T @ self.right)

    def eliminating(self, columns: Float64[np.ndarray, "u k"]) -> "NormalEquations":
        """The equations that remain once these directions are solved for (Schur complement)."""
        if not columns.shape[1]:
            return self
        cross = self.normal @ columns
        inverse = pseudo_inverse(columns.T @ cross)
        normal = self.normal - cross @ inverse @ cross.T
        right = self.right - cross @ (inverse @ (columns.T @ self.right))
        observed = np.diag(normal) > _MIN_REMAINING_SHARE * np.diag(self.normal)
        return NormalEquations(normal * np.outer(observed, observed), right * observed)


def pseudo_inverse(normal: Float64[np.ndarray, "k k"], least: float = 1e-7) -> np.ndarray:
    """Pseudo-inverse of a normal matrix over unknowns of any units, equilibrated first."""
    scale = _scales(normal)
    inverse = np.linalg.pinv(normal / np.outer(scale, scale), rcond=least, hermitian=True)
    return inverse / np.outer(scale, scale)


def _scales(normal: Float64[np.ndarray, "k k"]) -> Float64[np.ndarray, " k"]:
    """Square roots of the diagonal; infinite for unobserved unknowns."""
    weight = np.diag(normal)
    return np.sqrt(np.where(weight > MIN_WEIGHT, weight, np.inf))


def solve_semidefinite(
    normal: Float64[np.ndarray, "u u"], right: Float64[np.ndarray, "u k"]
) -> Float64[np.ndarray, "u k"]:
    """Solutions of positive semidefinite equations, by tiny damping of unobserved directions."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), MIN_WEIGHT))
    scaled = normal * np.outer(scale, scale)
    scaled[np.diag_indices_from(scaled)] += RELATIVE_DAMPING
    return scale[:, None] * cho_solve(cho_factor(scaled), scale[:, None] * right)


@dataclass(frozen=True)
class ScoreTest:
    """Score statistic, the predicted decrease of the sum of squares, and its degrees of freedom."""

    statistic: float
    dof: int

    @classmethod
    def of(cls, equations: NormalEquations) -> "ScoreTest":
        """The test of all directions of these equations together."""
        scale = _scales(equations.normal)
        values, vectors = np.linalg.eigh(equations.normal / np.outer(scale, scale))
        observed = values > 1e-7 * values.max(initial=1e-300)
        score = vectors[:, observed].T @ (equations.right / scale)
        return cls(float((score**2 / values[observed]).sum()), int(observed.sum()))

    @property
    def variance_factor(self) -> float:
        """Variance of the score over the one that the equations assume (reduced chi-squared)."""
        return self.statistic / max(self.dof, 1)

    @property
    def p_value(self) -> float:
        return chi_square_tail(self.statistic, max(self.dof, 1))


def f_test_p_value(every: ScoreTest, one: ScoreTest, candidates: int) -> float:
    """p-value of a term by an F test against the noise, Bonferroni-corrected.

    Args:
        every: The test of all directions; what `one` leaves of it is the noise.
        one: The test of the term, the best of so many candidates.
    """
    if one.dof < 1:
        return 1.0
    noise_dof = every.dof - one.dof
    noise = max(1.0, (every.statistic - one.statistic) / noise_dof) if noise_dof > 0 else 1.0
    ratio = one.statistic / one.dof / noise
    return min(1.0, candidates * f_tail(ratio, one.dof, max(noise_dof, 1)))


def is_significant(equations: NormalEquations, columns: Float64[np.ndarray, "u k"]) -> bool:
    """Whether these directions, chosen beforehand, are significant by an F test."""
    term = ScoreTest.of(equations.restricted_to(columns))
    return f_test_p_value(ScoreTest.of(equations), term, 1) <= SIGNIFICANCE_LEVEL


def deviance(
    equations: NormalEquations,
    spread: Float64[np.ndarray, " k"],
    usual: Float64[np.ndarray, " k"],
) -> float:
    """Minus twice the log-likelihood of zero-mean deviations of this spread, up to a constant."""
    sigmas = np.tile(spread, len(equations.right) // len(spread))
    scaled = equations.normal * np.outer(sigmas, sigmas)
    scaled[np.diag_indices_from(scaled)] += 1.0
    score = sigmas * equations.right
    prior = np.log10(spread / usual) / _PRIOR_DECADES
    value = np.linalg.slogdet(scaled)[1] - score @ np.linalg.solve(scaled, score)
    return float(value + prior @ prior)


@dataclass(frozen=True)
class SpreadEstimate:
    """Standard deviations of random effects by restricted maximum likelihood."""

    spread: Float64[np.ndarray, " k"]
    likelihood_ratio: float
    """Twice the log-likelihood ratio over a spread of zero."""

    def p_value(self, dof: int) -> float:
        """p-value of the likelihood ratio, if so many spreads were estimated (Wilks)."""
        return chi_square_tail(self.likelihood_ratio, dof)


def estimate_spread(
    equations: NormalEquations,
    usual: Float64[np.ndarray, " k"],
    most: Float64[np.ndarray, " k"],
    group_size: int = 1,
    least: Float64[np.ndarray, " k"] | None = None,
) -> SpreadEstimate:
    """The spread over the photos of the numbers that every photo has, from all photos' equations.

    Args:
        usual: Centre of the log-normal prior.
        most: Upper bounds of the spreads.
        group_size: So many consecutive numbers share one spread.
        least: Lower bounds of the spreads.
    """
    least = MIN_SPREAD * usual if least is None else least
    photos, count = len(equations.right) // len(usual), len(usual) // group_size
    usual, most, least = usual[::group_size], most[::group_size], least[::group_size]

    def cost(decades: Float64[np.ndarray, " k"]) -> tuple[float, Float64[np.ndarray, " k"]]:
        sigmas = np.tile(np.repeat(usual * 10.0**decades, group_size), photos)
        scaled = equations.normal * np.outer(sigmas, sigmas)
        scaled[np.diag_indices_from(scaled)] += 1.0
        inverse = np.linalg.inv(scaled)
        score = sigmas * equations.right
        effects = inverse @ score
        value = np.linalg.slogdet(scaled)[1] - score @ effects
        # by log variance: number of effects less their expected squares, mean and covariance
        squares = (np.diag(inverse) + effects**2).reshape(photos, count, group_size)
        gradient = 2.0 * np.log(10.0) * (group_size * photos - squares.sum(axis=(0, 2)))
        prior = decades / _PRIOR_DECADES
        return float(value + prior @ prior), gradient + 2.0 * prior / _PRIOR_DECADES

    bounds = np.log10(np.column_stack([least, most]) / usual[:, None])
    start = np.clip(np.zeros(count), *bounds.T)
    found = minimize(
        cost, start, jac=True, bounds=bounds, method="L-BFGS-B", options={"maxiter": 40}
    )
    prior = found.x / _PRIOR_DECADES
    return SpreadEstimate(usual * 10.0**found.x, float(prior @ prior - found.fun))
