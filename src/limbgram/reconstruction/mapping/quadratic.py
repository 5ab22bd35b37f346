"""Quadratic forms: normal equations of some unknowns, the others eliminated, and score tests.

In      normal equations over unknowns of any units, of which some may not be seen at all.
Out     how far the sum of squares falls along some directions, the chance of that, and the spread
        of numbers that every photo has.
Method  Rao's score test (1948); restricted maximum likelihood (Patterson and Thompson 1971).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from limbgram.core.interval import chi_square_tail, f_tail

LEAST = 1e-3
"""In parts of the usual spread: less is nought."""
FALSE_ALARM = 1e-5
"""Chance that photos without a term show it, by each kind with all its candidates."""
CLEARLY = 10.0
"""Difference of twice logarithms of likelihood that is very strong (Kass and Raftery 1995)."""
MANY_TIMES = 2.0
"""Spread of single lenses with which a term must still stand: four times the variance."""
ALMOST_NONE = 1e-9
"""Of each unknown's own weight: what keeps equations solvable whose world frame is free."""
FLAT = 1e-30
_NOTHING = 1e-8
_DECADES = 1.0
"""Standard deviation of what is known of a spread beforehand, in powers of ten: a tripod has a
hundredth of a phone's, and two photos out of many are told by it."""


@dataclass(frozen=True)
class Quadratic:
    """Twice a logarithm of likelihood, up to a constant: 2 right x - x normal x."""

    normal: Float64[np.ndarray, "u u"]
    right: Float64[np.ndarray, " u"]

    def along(self, columns: Float64[np.ndarray, "u k"]) -> "Quadratic":
        """Of these directions alone."""
        return Quadratic(columns.T @ self.normal @ columns, columns.T @ self.right)

    def without(self, columns: Float64[np.ndarray, "u k"]) -> "Quadratic":
        """Once these directions are free."""
        if not columns.shape[1]:
            return self
        cross = self.normal @ columns
        inverse = pseudo_inverse(columns.T @ cross)
        normal = self.normal - cross @ inverse @ cross.T
        right = self.right - cross @ (inverse @ (columns.T @ self.right))
        seen = np.diag(normal) > _NOTHING * np.diag(self.normal)  # the others are but rounding
        return Quadratic(normal * np.outer(seen, seen), right * seen)


def pseudo_inverse(normal: Float64[np.ndarray, "k k"], least: float = 1e-7) -> np.ndarray:
    """The inverse where something is seen, of unknowns of any units."""
    size = _sizes(normal)
    inverse = np.linalg.pinv(normal / np.outer(size, size), rcond=least, hermitian=True)
    return inverse / np.outer(size, size)


def _sizes(normal: Float64[np.ndarray, "k k"]) -> Float64[np.ndarray, " k"]:
    """Of each unknown, the root of its weight; infinite of what rounding leaves none."""
    weight = np.diag(normal)
    return np.sqrt(np.where(weight > FLAT, weight, np.inf))


def solved_for(
    normal: Float64[np.ndarray, "u u"], right: Float64[np.ndarray, "u k"]
) -> Float64[np.ndarray, "u k"]:
    """Solutions of equations some directions of which carry nothing."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), FLAT))
    scaled = normal * np.outer(scale, scale)
    scaled[np.diag_indices_from(scaled)] += ALMOST_NONE
    return scale[:, None] * cho_solve(cho_factor(scaled), scale[:, None] * right)


@dataclass(frozen=True)
class Fall:
    """How far the sum of squares falls where all directions are free, and their number."""

    fall: float
    freedom: int

    @classmethod
    def of(cls, seen: Quadratic) -> "Fall":
        size = _sizes(seen.normal)
        values, vectors = np.linalg.eigh(seen.normal / np.outer(size, size))
        known = values > 1e-7 * max(values[-1], 1e-300)
        pulls = vectors[:, known].T @ (seen.right / size)
        return cls(float((pulls**2 / values[known]).sum()), int(known.sum()))

    @property
    def variance(self) -> float:
        """Over that of the adjustments."""
        return self.fall / max(self.freedom, 1)

    @property
    def chance(self) -> float:
        return chi_square_tail(self.fall, max(self.freedom, 1))


def chance_of(every: Fall, one: Fall, tried: int) -> float:
    """That noise alone lets the best of what was tried fall so far."""
    if one.freedom < 1:
        return 1.0
    after = every.freedom - one.freedom
    noise = max(1.0, (every.fall - one.fall) / after) if after > 0 else 1.0
    ratio = one.fall / one.freedom / noise
    return min(1.0, tried * f_tail(ratio, one.freedom, max(after, 1)))


def unlikeliness(
    seen: Quadratic, spread: Float64[np.ndarray, " k"], usual: Float64[np.ndarray, " k"]
) -> float:
    """Minus twice the logarithm of likelihood of deviations of this spread, up to a constant."""
    every = np.tile(spread, len(seen.right) // len(spread))
    scaled = seen.normal * np.outer(every, every)
    scaled[np.diag_indices_from(scaled)] += 1.0
    pull = every * seen.right
    known = np.log10(spread / usual) / _DECADES
    lost = np.linalg.slogdet(scaled)[1] - pull @ np.linalg.solve(scaled, pull)
    return float(lost + known @ known)


@dataclass(frozen=True)
class Likeliest:
    """The spread of greatest likelihood, and twice the logarithm of that over one of nought."""

    spread: Float64[np.ndarray, " k"]
    gain: float


def likeliest(
    seen: Quadratic,
    usual: Float64[np.ndarray, " k"],
    most: Float64[np.ndarray, " k"],
    alike: int = 1,
    least: Float64[np.ndarray, " k"] | None = None,
) -> Likeliest:
    """Spreads of numbers that every photo has, by what is seen of all of them.

    Args:
        alike: So many numbers that follow each other have one spread.
        least: Bounds of the spreads from below.
    """
    least = LEAST * usual if least is None else least
    photos, count = len(seen.right) // len(usual), len(usual) // alike
    usual, most, least = usual[::alike], most[::alike], least[::alike]

    def cost(decades: Float64[np.ndarray, " k"]) -> tuple[float, Float64[np.ndarray, " k"]]:
        spread = np.tile(np.repeat(usual * 10.0**decades, alike), photos)
        scaled = seen.normal * np.outer(spread, spread)
        scaled[np.diag_indices_from(scaled)] += 1.0
        inverse = np.linalg.inv(scaled)
        pull = spread * seen.right
        found = inverse @ pull
        lost = np.linalg.slogdet(scaled)[1] - pull @ found
        # by the logarithm of each variance: the photos' number less what is found and left open
        open_ = (np.diag(inverse) + found**2).reshape(photos, count, alike).sum(axis=(0, 2))
        slopes = 2.0 * np.log(10.0) * (alike * photos - open_)
        known = decades / _DECADES
        return float(lost + known @ known), slopes + 2.0 * known / _DECADES

    bounds = np.log10(np.column_stack([least, most]) / usual[:, None])
    start = np.clip(np.zeros(count), *bounds.T)
    found = minimize(
        cost, start, jac=True, bounds=bounds, method="L-BFGS-B", options={"maxiter": 40}
    )
    known = found.x / _DECADES
    return Likeliest(usual * 10.0**found.x, float(known @ known - found.fun))
