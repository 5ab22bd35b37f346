"""Lens selection: per-photo lens deviations, free only where a score test supports them.

In      a scene, the calibrations, and the adjustment with one lens for all photos of a camera.
Out     that adjustment, or one with deviations of single photos (lens_deviations.py).
Method  A score test (Rao 1948) for each kind: the predicted decrease of the sum of squares by one
        Gauss-Newton step if every photo had a deviation of that kind, all else free too. In photos
        of one lens the statistic follows chi-squared with as many degrees of freedom as there are
        parameters; it is counted in the adjustment's inflated sigmas, which stays below: sound
        captures reach 0.1 to 0.4 a parameter. The significance level is one in 100,000: 1.5 a
        parameter of 60 photos with four each, 2.6 of 15 with two, 5.9 of 6 with one.
        A significant kind must also explain more than a split of the points into two bodies that
        move against each other (two_bodies.py), by Akaike's criterion (1974): a body that moved
        makes lens deviations significant too, which would hide its motion.
        Of the kinds that pass, the one with the lowest Bayesian information criterion (Schwarz
        1978) is set free, the scene adjusted with its deviations as random effects of the spread
        that the capture itself shows, and tested again. A spread that no camera has is another
        fault, such as the file of another camera: no lens deviation may hide it. Photos that were
        zoomed (zoom.py) have such a spread, and keep the focal lengths that were found.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from limbgram.core.interval import chi_square_tail
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.mapping.bundle_adjustment import Adjusted, adjust, score_statistics
from limbgram.reconstruction.mapping.lens_deviations import (
    DEVIATIONS,
    FEWEST_PHOTOS,
    implausible_deviations,
    parameter_count,
    with_deviation,
    with_photo_lenses,
    with_spread_of,
)
from limbgram.reconstruction.mapping.scene import Deviation, Scene
from limbgram.reconstruction.mapping.score_tests import SIGNIFICANCE_LEVEL
from limbgram.reconstruction.mapping.two_bodies import AIC_PER_PARAMETER, explained_by_two_bodies
from limbgram.reconstruction.mapping.zoom import zoomed_by_solved_focals

_OBSERVATIONS = 30_000
"""Observations that suffice for the tests: limb_ring15 has 27,600."""


def with_supported_lenses(fixed: Adjusted, scene: Scene, priors: Sequence[Calibration]) -> Adjusted:
    """The adjustment with the kinds of lens deviation that its residuals support, if any.

    Args:
        fixed: The scene adjusted with one lens for all photos of a camera.
        scene: The same before, with the observations that the adjustment may have dropped.
    """
    best, start = fixed, scene
    while (kind := supported_kind(best, priors)) is not None:
        freed = with_deviation(start, kind.deviation, kind.p_value)
        trial = adjust(freed, priors, solve_own=True)
        if trial.sigma_px >= best.sigma_px:
            break
        if beyond := implausible_deviations(trial.scene):
            if beyond != ("focal length",) or not zoomed_by_solved_focals(trial.scene):
                break
                # a prior with the spread of usual cameras biased their focal lengths
            freed = with_spread_of(freed, trial.scene)
            trial = adjust(freed, priors, solve_own=True)
        best, start = trial, freed
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
    """The kind of lens deviation with the best information criterion.

    None where none is significant, or bodies that move against each other explain as much.
    """
    scores = [one for one in lens_scores(adjusted, priors) if one.p_value < SIGNIFICANCE_LEVEL]
    if not scores:
        return None
    bodies = explained_by_two_bodies(adjusted, priors, _OBSERVATIONS)
    beyond = [one for one in scores if one.statistic - AIC_PER_PARAMETER * one.dof > bodies]
    observations = 2 * min(len(adjusted.scene.observations.xy_px), _OBSERVATIONS)
    return min(beyond, key=lambda one: one.dof * np.log(observations) - one.statistic, default=None)


def lens_scores(adjusted: Adjusted, priors: Sequence[Calibration]) -> tuple[LensScore, ...]:
    """Score test of each kind of lens deviation that is not free yet."""
    base = with_photo_lenses(adjusted.scene)
    placed = len(base.placed)
    assert base.own is not None
    fixed: list[Deviation] = [one for one in DEVIATIONS if one not in base.own.deviations]
    if placed < FEWEST_PHOTOS or not fixed:
        return ()
    scenes = [base, *(with_deviation(base, one) for one in fixed)]
    statistics = score_statistics(scenes, priors, adjusted.sigma_px, _OBSERVATIONS)
    return tuple(
        LensScore(kind, float(statistic - statistics[0]), parameter_count(kind) * placed)
        for kind, statistic in zip(fixed, statistics[1:], strict=True)
    )
