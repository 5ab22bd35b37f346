"""Spread: how much the lens differs from photo to photo, by the capture itself.

In      an Evidence, and columns of motions that are taken for granted.
Out     the spread of each number of a photo's lens deviation, and what is left of the evidence
        once these deviations are expected to be of that spread.
Method  Restricted maximum likelihood (Patterson and Thompson 1971): poses, lenses and motions are
        flat, deviations are normal about nought, and the variance of each number maximises the
        likelihood of what is left. It is bounded by what single photos of real cameras do
        (`mapping.own.WIDE`), and where the photos tell nothing of it, it is that of a usual phone.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from scipy.optimize import minimize

from limbgram.reconstruction.hypotheses.evidence import MOVE, OWN, Evidence, solved_for
from limbgram.reconstruction.mapping.own import DEVIATIONS, WIDE, numbers_of

MOST = np.array([*(WIDE[kind] for kind in DEVIATIONS for _ in range(numbers_of(kind))), 0.02, 0.04])
_USUAL = {"principal point": 0.0025, "focal length": 0.0005, "rolling shutter": 0.001}
"""Of a phone in the hand (`synthetic.usual`): a stabiliser, focus at half a metre, 20 ms for all
rows."""
USUAL = np.array(
    [*(_USUAL[kind] for kind in DEVIATIONS for _ in range(numbers_of(kind))), 1e-3, 2e-3]
)
"""Of each number; k1 and k2 change by some hundredths of themselves with the focus."""
_DECADES = 1.0
"""Standard deviation of what is known of a spread beforehand, in powers of ten: a tripod has a
hundredth of a phone's, and two photos out of many are told by it."""
_LEAST = 1e-3
"""In parts of the usual spread: less is nought."""


_NOTHING = 1e-8


@dataclass(frozen=True)
class Left:
    """Equations over what the second body alone sees of each lens, and over its motion."""

    photos: int
    spread: Float64[np.ndarray, "9"]
    normal: Float64[np.ndarray, "u u"]
    right: Float64[np.ndarray, " u"]

    @property
    def lens(self) -> slice:
        return slice(0, OWN * self.photos)

    @property
    def motion(self) -> slice:
        return slice(OWN * self.photos, (OWN + MOVE) * self.photos)

    def only(self, part: slice) -> "Quadratic":
        return Quadratic(self.normal[part, part], self.right[part])


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
    size = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    inverse = np.linalg.pinv(normal / np.outer(size, size), rcond=least, hermitian=True)
    return inverse / np.outer(size, size)


def left_of(evidence: Evidence, spread: Float64[np.ndarray, "9"]) -> Left:
    """What is left where deviations of every photo's lens are expected to be of this spread."""
    own, rest = evidence.own, slice(evidence.own.stop, len(evidence.right))
    normal = evidence.normal[own, own].copy()
    normal[np.diag_indices_from(normal)] += 1.0 / np.tile(spread, len(evidence.photos)) ** 2
    cross = evidence.normal[rest, own]
    solved = solved_for(normal, np.column_stack([evidence.right[own], cross.T]))
    return Left(
        photos=len(evidence.photos),
        spread=spread,
        normal=evidence.normal[rest, rest] - cross @ solved[:, 1:],
        right=evidence.right[rest] - cross @ solved[:, 0],
    )


def spread_of(
    evidence: Evidence, granted: Float64[np.ndarray, "m k"] | None = None
) -> Float64[np.ndarray, "9"]:
    """The spread that the capture shows.

    Args:
        granted: Columns of motions, 6 a photo, that are free.
    """
    own, motion = evidence.own, evidence.motion
    seen = Quadratic(evidence.normal[own, own], evidence.right[own])
    if granted is not None and granted.shape[1]:
        columns = np.zeros((len(evidence.right), granted.shape[1]))
        columns[motion] = granted
        free = Quadratic(evidence.normal, evidence.right).without(columns)
        seen = Quadratic(free.normal[own, own], free.right[own])
    return likeliest(seen, USUAL, MOST).spread


def unlikeliness(seen: Quadratic, spread: Float64[np.ndarray, "9"]) -> float:
    """Minus twice the logarithm of likelihood of deviations of this spread, up to a constant."""
    every = np.tile(spread, len(seen.right) // len(spread))
    scaled = seen.normal * np.outer(every, every)
    scaled[np.diag_indices_from(scaled)] += 1.0
    pull = every * seen.right
    known = np.log10(spread / USUAL) / _DECADES
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
) -> Likeliest:
    """Spreads of numbers that every photo has, by what is seen of all of them.

    Args:
        alike: So many numbers that follow each other have one spread.
    """
    photos, count = len(seen.right) // len(usual), len(usual) // alike
    usual, most = usual[::alike], most[::alike]

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

    bounds = [(np.log10(_LEAST), float(np.log10(high))) for high in most / usual]
    found = minimize(
        cost, np.zeros(count), jac=True, bounds=bounds, method="L-BFGS-B", options={"maxiter": 40}
    )
    known = found.x / _DECADES
    return Likeliest(usual * 10.0**found.x, float(known @ known - found.fun))
