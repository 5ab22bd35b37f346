"""Halves: how much of the residuals would be explained by points that move against each other.

In      an adjusted scene, and the calibrations.
Out     by how much the sum of squares would fall if one half of the points moved against the
        other from photo to photo, as two bodies do: the most of six ways to cut.
Method  One Gauss-Newton step with poses and lens of their own for both halves, less the same for
        all points together. The points are cut through their middle across each of their three
        axes and both diagonals of the longest two, and into those near the middle and those round
        them, as a limb and its surroundings lie.
        A lens bends all of its photo alike. Cloth that creeps, a sheet that slides below an object
        or a limb that sways move some of the points, and ask for own lenses too. Two bodies have
        six numbers a photo, a lens one to three: where the lens explains more, it is the lens.
        Points held out at random do not tell: they lie between the others and share what moved
        these.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool

from limbgram.core.geometry.arrays import Points3
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.mapping.own import with_own
from limbgram.reconstruction.mapping.solution import Adjusted, falls_apart

_NEAR = 3.0
"""Points farther from the middle than this many times the middle distance set no axis."""


def fall_of_two_bodies(
    adjusted: Adjusted, priors: Sequence[Calibration], observations: int
) -> float:
    """The most that any cut explains, in units of sigma.

    Args:
        observations: At most about so many are asked.
    """
    base = with_own(adjusted.scene)
    cuts = _cuts(base.points_in_world)
    return float(falls_apart(base, priors, adjusted.sigma_px, observations, cuts).max())


def _cuts(points: Points3) -> list[Bool[np.ndarray, " n"]]:
    """One half of the points each time."""
    off = points - np.median(points, axis=0)
    distances = np.linalg.norm(off, axis=1)
    near = off[distances < _NEAR * np.median(distances)]
    long, short, thin = (off @ np.linalg.svd(near, full_matrices=False)[2].T).T
    along = (long, short, thin, long + short, long - short, distances)
    return [one < np.median(one) for one in along]
