"""Lens selection: per-photo lens deviations, free only where a score test supports them.

In      a scene, the calibrations, and the adjustment with one lens for all photos of a camera.
Out     that adjustment, or one with deviations of single photos (lens_deviations.py).
Method  A score test (Rao 1948) for each kind: how far one Gauss-Newton step would lower the sum of
        squares if every photo had its numbers of that kind, all else free too. In photos of one
        lens the fall follows chi-squared with as many degrees of freedom as there are numbers; it
        is counted in the adjustment's inflated sigmas, which stays below: sound captures reach 0.1
        to 0.4 a number. What is asked for is a chance of one in 100,000: 1.5 a number of 60
        photos with four each, 2.6 of 15 with two, 5.9 of 6 with one.
        A kind that asks must also explain more than halves of the points that move against each
        other would (two_bodies.py), by Akaike's criterion (1974): a body that moved asks for own
        lenses too, and with them would be hidden instead of told.
        Of the kinds that pass, the one with the lowest Bayesian information criterion (Schwarz
        1978) is set free, the scene adjusted with its numbers drawn to nought by the spread that
        the capture itself shows, and asked again. A spread that no camera has is another fault,
        such as the file of another camera: no own lens may hide it. Photos that were zoomed
        (zoom.py) are told by that very spread, and keep the focal lengths that were found.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from limbgram.core.interval import chi_square_tail
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.mapping.lens_deviations import (
    DEVIATIONS,
    FEWEST_PHOTOS,
    beyond_cameras,
    numbers_of,
    with_own,
    with_room_for,
    with_spread_of,
)
from limbgram.reconstruction.mapping.scene import Deviation, Scene
from limbgram.reconstruction.mapping.score_tests import SIGNIFICANCE_LEVEL
from limbgram.reconstruction.mapping.solution import Adjusted, adjust, predicted_falls
from limbgram.reconstruction.mapping.two_bodies import A_NUMBER, explained_by_two_bodies
from limbgram.reconstruction.mapping.zoom import zoomed_by_own

_OBSERVATIONS = 30_000
"""So many suffice for the test: limb_ring15 has 27,600."""


def with_supported_lenses(fixed: Adjusted, scene: Scene, priors: Sequence[Calibration]) -> Adjusted:
    """The adjustment with the kinds that its residuals support; itself where they support none.

    Args:
        fixed: The scene adjusted with one lens for all photos of a camera.
        scene: Before, with the observations that this one may have dropped.
    """
    best, start = fixed, scene
    while (kind := supported_kind(best, priors)) is not None:
        room = with_room_for(start, kind.deviation, kind.p_value)
        trial = adjust(room, priors, solve_own=True)
        if trial.sigma_px >= best.sigma_px:
            break
        if beyond := beyond_cameras(trial.scene):
            if beyond != ("focal length",) or not zoomed_by_own(trial.scene):
                break
            # the spread of a camera's faults held their focal lengths back
            room = with_spread_of(room, trial.scene)
            trial = adjust(room, priors, solve_own=True)
        best, start = trial, room
    return best


@dataclass(frozen=True)
class LensScore:
    """Score test of one kind of lens deviation."""

    deviation: Deviation
    statistic: float
    """Score statistic: predicted decrease of the sum of squares, in units of sigma."""
    dof: int
    """Number of parameters that would be solved for."""

    @property
    def p_value(self) -> float:
        """Chance that photos of one lens show as much, all kinds counted."""
        return min(1.0, len(DEVIATIONS) * chi_square_tail(self.statistic, self.dof))


def supported_kind(adjusted: Adjusted, priors: Sequence[Calibration]) -> LensScore | None:
    """The kind that explains most of what an adjusted scene leaves.

    None where chance, or bodies that move against each other, would explain as much.
    """
    scores = [one for one in scores_of(adjusted, priors) if one.p_value < SIGNIFICANCE_LEVEL]
    if not scores:
        return None
    bodies = explained_by_two_bodies(adjusted, priors, _OBSERVATIONS)
    true = [one for one in scores if one.statistic - A_NUMBER * one.dof > bodies]
    observations = 2 * min(len(adjusted.scene.observations.xy_px), _OBSERVATIONS)
    return min(true, key=lambda one: one.dof * np.log(observations) - one.statistic, default=None)


def scores_of(adjusted: Adjusted, priors: Sequence[Calibration]) -> tuple[LensScore, ...]:
    """How much each kind that is not free yet would explain."""
    base = with_own(adjusted.scene)
    placed = len(base.placed)
    assert base.own is not None
    left: list[Deviation] = [one for one in DEVIATIONS if one not in base.own.deviations]
    if placed < FEWEST_PHOTOS or not left:
        return ()
    scenes = [base, *(with_room_for(base, one) for one in left)]
    falls = predicted_falls(scenes, priors, adjusted.sigma_px, _OBSERVATIONS)
    return tuple(
        LensScore(kind, float(fall - falls[0]), numbers_of(kind) * placed)
        for kind, fall in zip(left, falls[1:], strict=True)
    )
