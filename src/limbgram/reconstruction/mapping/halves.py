"""Halves: whether what photos have for themselves in their lenses is true of all that they show.

In      an adjusted scene, and the kinds of deviation that its residuals ask for.
Out     of each kind, how surely one half of the points foretells the other.
Method  A lens bends all of its photo alike. Something else that own lenses could take up, such as
        cloth that creeps, a sheet that slides below the limb or a body that sways, moves some of
        the points. So the points are cut in two in six ways: through their middle across each of
        their three axes and both diagonals of the longest two, and into those near the middle and
        those round them, as a limb and its surroundings lie. Each half alone tells the numbers of
        all photos, drawn to nought by the spread that this half shows; and the other half, with
        its own poses, must fit better with these numbers held than with none. Of two models that
        were not fitted to the data at hand, the likelihood ratio exceeds 1/a with a chance of at
        most a if the poorer one is true (split likelihood ratio: Wasserman, Ramdas, Balakrishnan
        2020); its mean over both directions has the same bound. The worst cut counts. Points held
        out at random would not tell: they lie between the others and share what moved these.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.geometry.arrays import Points3
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.mapping.own import LEAST_SPREAD, numbers_of, with_own, with_room_for
from limbgram.reconstruction.mapping.scene import Deviation
from limbgram.reconstruction.mapping.solution import Adjusted, OwnEquations, own_equations

_OBSERVATIONS = 15_000
"""So many of each half: both together are those of the score test."""
_STEPS = 30
"""Of expectation and maximisation; the spread settles within 10."""
_NEAR = 3.0
"""Points farther from the middle than this many times the middle distance set no axis."""


def log_ratios(
    adjusted: Adjusted, priors: Sequence[Calibration], kinds: Sequence[Deviation]
) -> tuple[float, ...]:
    """Of each kind, the logarithm of its split likelihood ratio in the worst cut."""
    if not kinds:
        return ()
    base = with_own(adjusted.scene)
    rooms = [with_room_for(base, kind) for kind in kinds]
    sizes = [numbers_of(kind) for kind in kinds]
    worst = np.full(len(kinds), np.inf)
    for first in _cuts(base.points_in_world):
        halves = [
            own_equations(rooms, priors, adjusted.sigma_px, half, sizes, _OBSERVATIONS)
            for half in (first, ~first)
        ]
        for k, (size, one, other) in enumerate(zip(sizes, *halves, strict=True)):
            worst[k] = min(worst[k], foretold(one, other, size))
    return tuple(float(one) for one in worst)


def foretold(one: OwnEquations, other: OwnEquations, size: int) -> float:
    """Logarithm of the split likelihood ratio: each half by the numbers of the other.

    Args:
        size: Numbers of a photo.
    """
    both = 0.5 * np.array([other.fall(_told(one, size)), one.fall(_told(other, size))])
    return float(np.logaddexp(*both) - np.log(2.0))


def _told(equations: OwnEquations, size: int) -> Float64[np.ndarray, " n"]:
    """Numbers as these points tell them, drawn to nought by the spread that they show."""
    photos = len(equations.right) // size
    spread = np.full(size, 1.0)
    values = np.zeros_like(equations.right)
    for _ in range(_STEPS):
        drawn = equations.normal + np.diag(np.tile(spread**-2.0, photos))
        covariance = np.linalg.inv(drawn)
        values = covariance @ equations.right
        variance = (values**2 + np.diag(covariance)).reshape(photos, size).mean(0)
        spread = np.maximum(np.sqrt(variance), LEAST_SPREAD)
    return values


def _cuts(points: Points3) -> list[Bool[np.ndarray, " n"]]:
    """One half of the points each time: across their axes and the diagonals of the longest two, and
    those nearest to their middle."""
    off = points - np.median(points, axis=0)
    distances = np.linalg.norm(off, axis=1)
    near = off[distances < _NEAR * np.median(distances)]
    long, short, thin = (off @ np.linalg.svd(near, full_matrices=False)[2].T).T
    along = (long, short, thin, long + short, long - short, distances)
    return [one < np.median(one) for one in along]
