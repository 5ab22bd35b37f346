"""Two bodies: how well two independently moving groups of points would explain the residuals.

In      an adjusted scene, and the calibrations.
Out     by how much the sum of squares would fall if some of the points moved against the others
        between photos, as two bodies do, less what chance would explain with as many numbers: the
        most of all cuts and of all courses.
Method  One Gauss-Newton step with poses and lens of their own for both parts, less the same for
        all points together: six numbers a photo, and its lens. A body that stepped once, or
        drifts evenly, has six in all: one motion of the one part, in all photos after the step or
        by each photo's place among them; where it stepped counts as three numbers more (Ninomiya
        2015).
        The points are cut across each of their three axes and both diagonals of the longest two,
        and into those near the middle and those round them, as a limb and its surroundings lie:
        each through their middle and through both quarters, since few bodies are half of a scene;
        the best of so many cuts pays for their number.
        A lens bends all of its photo alike. Cloth that creeps, a sheet that slides below an object
        or a limb that sways move some of the points, and ask for own lenses too. Each is taken less
        two a number (Akaike 1974): where the lens explains more, it is the lens.
        Points held out at random do not tell: they lie between the others and share what moved
        these.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import POSE_SIZE
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.mapping.lens_deviations import with_own
from limbgram.reconstruction.mapping.solution import Adjusted, falls_apart

_NEAR = 3.0
"""Points farther from the middle than this many times the middle distance set no axis."""
A_NUMBER = 2.0
"""What each number must explain where a lens is held against two bodies (Akaike 1974): so much
would the sum of squares fall by chance, and rise again in other measurements."""
_SHARES = (0.25, 0.5, 0.75)
"""Of the points that lie on the one side of a cut."""
_WHERE = 3
"""Numbers that count for the place of a step (Ninomiya 2015)."""


def explained_by_two_bodies(
    adjusted: Adjusted, priors: Sequence[Calibration], observations: int
) -> float:
    """The most that any cut explains, in units of sigma, less `A_NUMBER` for each number.

    Args:
        observations: At most about so many are asked.
    """
    base = with_own(adjusted.scene)
    photos = len(base.placed)
    steps = np.arange(photos)[:, None] >= np.arange(1, photos)
    courses = np.column_stack([steps, np.linspace(0.0, 1.0, photos)])
    numbers = np.full(1 + courses.shape[1], POSE_SIZE)
    numbers[0] = POSE_SIZE * photos + sum(int((one.sigmas > 0.0).sum()) for one in priors)
    numbers[1:photos] += _WHERE
    cuts = _cuts(base.points_in_world)
    falls = falls_apart(base, priors, adjusted.sigma_px, observations, cuts, courses)
    return float((falls - A_NUMBER * numbers).max() - 2.0 * np.log(len(cuts)))


def _cuts(points: Points3) -> list[Bool[np.ndarray, " n"]]:
    """Which points are of the one part, each time."""
    off = points - np.median(points, axis=0)
    distances = np.linalg.norm(off, axis=1)
    near = off[distances < _NEAR * np.median(distances)]
    long, short, thin = (off @ np.linalg.svd(near, full_matrices=False)[2].T).T
    along = (long, short, thin, long + short, long - short, distances)
    return [one < np.quantile(one, share) for one in along for share in _SHARES]
