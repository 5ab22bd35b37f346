"""Two bodies: how well two independently moving groups of points would explain the residuals.

In      an adjusted scene, and the calibrations.
Out     the score statistic of a model in which some of the points move against the others between
        photos, as two bodies do, less a penalty for its parameters: the largest over all splits of
        the points and all courses of the motion.
Method  One Gauss-Newton step with separate poses and lenses for both parts, less the same for all
        points together: six parameters a photo, and its lens. A body that stepped once, or drifts
        uniformly, has six in all: one motion of the one part, in all photos after the step or in
        proportion to each photo's rank; the place of a step counts as three more (Ninomiya 2015).
        The points are split across each of their three axes and both diagonals of the longest two,
        and into those near the centre and those round them, as a limb and its surroundings lie:
        each at the median and at both quartiles, since few bodies are half of a scene; the number
        of splits is penalised as well.
        A lens bends all of its photo alike. Cloth that creeps, a sheet that slides below an object
        or a limb that sways move some of the points, and make lens deviations significant too. Each
        model is penalised by two for each parameter (Akaike 1974): where the lens explains more,
        it is the lens. Points held out at random do not tell: they lie between the others and share
        what moved these.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import POSE_SIZE
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.mapping.bundle_adjustment import Adjusted, split_statistics
from limbgram.reconstruction.mapping.lens_deviations import with_photo_lenses

_NEAR = 3.0
"""Distance from the centre, over the median distance, of points that determine the axes."""
AIC_PER_PARAMETER = 2.0
"""Penalty of each parameter on the score statistic where a lens is compared with two bodies
(Akaike 1974)."""
_SHARES = (0.25, 0.5, 0.75)
"""Shares of the points on one side of a split."""
_PARAMETERS_OF_STEP = 3
"""Parameters that the place of a step counts for (Ninomiya 2015)."""


def explained_by_two_bodies(
    adjusted: Adjusted, priors: Sequence[Calibration], observations: int
) -> float:
    """Largest penalised score statistic over all splits and courses, in units of sigma.

    Args:
        observations: At most about so many are used.
    """
    base = with_photo_lenses(adjusted.scene)
    photos = len(base.placed)
    steps = np.arange(photos)[:, None] >= np.arange(1, photos)
    courses = np.column_stack([steps, np.linspace(0.0, 1.0, photos)])
    parameters = np.full(1 + courses.shape[1], POSE_SIZE)
    parameters[0] = POSE_SIZE * photos + sum(int((one.sigmas > 0.0).sum()) for one in priors)
    parameters[1:photos] += _PARAMETERS_OF_STEP
    splits = _splits(base.points_in_world)
    statistics = split_statistics(base, priors, adjusted.sigma_px, observations, splits, courses)
    return float((statistics - AIC_PER_PARAMETER * parameters).max() - 2.0 * np.log(len(splits)))


def _splits(points: Points3) -> list[Bool[np.ndarray, " n"]]:
    """By split, which points are in the one part."""
    off = points - np.median(points, axis=0)
    distances = np.linalg.norm(off, axis=1)
    near = off[distances < _NEAR * np.median(distances)]
    long, short, thin = (off @ np.linalg.svd(near, full_matrices=False)[2].T).T
    axes = (long, short, thin, long + short, long - short, distances)
    return [one < np.quantile(one, share) for one in axes for share in _SHARES]
