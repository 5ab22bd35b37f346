"""Lens spread: how much the lens differs from photo to photo, estimated from the capture itself.

In      TwoBodyEquations, and design columns of motions that are free.
Out     the spread of each number of a photo's lens deviation, and the equations of the second body
        with deviations of that spread marginalised.
Method  Restricted maximum likelihood (Patterson and Thompson 1971): poses, lenses and free motions
        have flat priors, deviations are zero-mean Gaussian, and the variance of each number
        maximises the restricted likelihood. It is bounded by what single photos of real cameras do
        (`lens_deviations.PRIOR_SPREAD`); where the photos do not determine it, it is that of a
        usual phone.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.reconstruction.hypotheses.two_body_equations import TwoBodyEquations
from limbgram.reconstruction.mapping.body_motion import MOTION_SIZE
from limbgram.reconstruction.mapping.lens_equations import (
    DEVIATION_SIZE,
    MAX_SPREAD,
    USUAL_SPREAD,
)
from limbgram.reconstruction.mapping.score_tests import (
    NormalEquations,
    estimate_spread,
    solve_semidefinite,
)


@dataclass(frozen=True)
class SecondBodyEquations:
    """Equations over the lens as the second body alone sees it, and over that body's motion.

    Lens deviations that both bodies see are marginalised.
    """

    photos: int
    spread: Float64[np.ndarray, "9"]
    """Of the marginalised deviations."""
    normal: Float64[np.ndarray, "u u"]
    right: Float64[np.ndarray, " u"]

    @property
    def lens(self) -> slice:
        """Rows of the lens deviations that the second body alone sees."""
        return slice(0, DEVIATION_SIZE * self.photos)

    @property
    def motion(self) -> slice:
        """Rows of the second body's motions."""
        return slice(DEVIATION_SIZE * self.photos, (DEVIATION_SIZE + MOTION_SIZE) * self.photos)

    @property
    def of_motion(self) -> NormalEquations:
        """The block of the motions, with the second body's lens held at that of the first."""
        return NormalEquations(self.normal[self.motion, self.motion], self.right[self.motion])

    def embedded(self, motions: Float64[np.ndarray, "m k"]) -> Float64[np.ndarray, "u k"]:
        """Columns over motions as columns over all unknowns."""
        columns = np.zeros((len(self.right), motions.shape[1]))
        columns[self.motion] = motions
        return columns


def second_body_equations(
    equations: TwoBodyEquations, spread: Float64[np.ndarray, "9"]
) -> SecondBodyEquations:
    """The equations with zero-mean lens deviations of this spread marginalised."""
    lens, rest = equations.lens, slice(equations.lens.stop, len(equations.right))
    normal = equations.normal[lens, lens].copy()
    normal[np.diag_indices_from(normal)] += 1.0 / np.tile(spread, len(equations.photos)) ** 2
    cross = equations.normal[rest, lens]
    solved = solve_semidefinite(normal, np.column_stack([equations.right[lens], cross.T]))
    return SecondBodyEquations(
        photos=len(equations.photos),
        spread=spread,
        normal=equations.normal[rest, rest] - cross @ solved[:, 1:],
        right=equations.right[rest] - cross @ solved[:, 0],
    )


def lens_spread(
    equations: TwoBodyEquations, free_motions: Float64[np.ndarray, "m k"] | None = None
) -> Float64[np.ndarray, "9"]:
    """The spread of lens deviations that the capture shows.

    Args:
        free_motions: Design columns of motions, 6 rows a photo, that are solved for beside it.
    """
    return estimate_spread(
        deviation_equations(equations, free_motions), USUAL_SPREAD, MAX_SPREAD
    ).spread


def deviation_equations(
    equations: TwoBodyEquations, free_motions: Float64[np.ndarray, "m k"] | None = None
) -> NormalEquations:
    """The equations over the lens deviations of all photos, with `free_motions` eliminated."""
    lens = equations.lens
    remaining = NormalEquations(equations.normal, equations.right)
    if free_motions is not None and free_motions.shape[1]:
        columns = np.zeros((len(equations.right), free_motions.shape[1]))
        columns[equations.motion] = free_motions
        remaining = remaining.eliminating(columns)
    return NormalEquations(remaining.normal[lens, lens], remaining.right[lens])
