"""Random motion (sway) of a body from photo to photo, tested against lenses that vary likewise.

In      TwoBodyEquations, and the terms that the search accepted.
Out     a Sway with the rules that it fails, or none where what the terms leave is not significant;
        how well a sway explains what lens deviations of single photos would.
Method  Random effects: rotations and shifts, each isotropic, of a spread estimated by restricted
        maximum likelihood. Where no board calibrated the lens, or photos have lens deviations of
        their own, a sway is no fact unless it explains clearly more than those lenses; and such a
        lens is none unless it explains clearly more than a sway.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.interval import chi_square_tail
from limbgram.reconstruction.hypotheses.accepted_terms import AcceptedTerms, largest_displacement
from limbgram.reconstruction.hypotheses.lens_spread import (
    SecondBodyEquations,
    deviation_equations,
    second_body_equations,
)
from limbgram.reconstruction.hypotheses.two_body_equations import TwoBodyEquations
from limbgram.reconstruction.mapping.body_motion import MOTION_SIZE
from limbgram.reconstruction.mapping.lens_equations import MAX_SPREAD, USUAL_SPREAD, deviation_slice
from limbgram.reconstruction.mapping.scene import Bodies, Deviation, Explanation, Rule
from limbgram.reconstruction.mapping.score_tests import (
    SIGNIFICANCE_LEVEL,
    SPREAD_MARGIN,
    VERY_STRONG_EVIDENCE,
    NormalEquations,
    ScoreTest,
    SpreadEstimate,
    deviance,
    estimate_spread,
)

_MAX_SWAY = (0.2, 0.1)
"""Largest spread of a sway: of rotations in rad, and of shifts over the distance."""
SWAY_SIZE = 2
"""Parameters of a sway: spread of the rotations, and of the shifts."""


class SwayVersusLenses(NamedTuple):
    """How much better or worse a sway explains the residuals than lens deviations of photos."""

    likelihood_ratio: float
    """Twice the log-likelihood of sway and usual lenses over that of usual lenses alone."""
    over_lenses: float
    """The same over that of the lenses that the capture shows, without a sway."""


@dataclass(frozen=True)
class Sway:
    """A sway as an explanation, and the motion of each photo."""

    explanation: Explanation
    motions: Float64[np.ndarray, "n 6"]


def find_sway(
    equations: TwoBodyEquations,
    accepted: AcceptedTerms,
    bodies: Bodies,
    floor: float,
    versus_lenses: Callable[..., SwayVersusLenses],
) -> Sway | None:
    """An independent motion in each photo, where what the accepted terms leave is significant.

    Args:
        versus_lenses: `sway_versus_lenses` of some kinds of deviation.
    """
    sway = estimate_sway(equations, accepted, accepted.second_body, floor)
    p_value = sway.p_value(SWAY_SIZE)
    lack_of_fit = accepted.lack_of_fit
    if max(p_value, lack_of_fit.p_value) > SIGNIFICANCE_LEVEL:
        return None
    remaining = accepted.second_body.of_motion.eliminating(accepted.columns)
    motions, covariance = _posterior_motions(remaining, sway)
    asked = np.flatnonzero(equations.well_observed)
    effects = [
        largest_displacement(motions[k], covariance[rows, rows], equations.radius)
        for k in (asked if len(asked) else range(len(motions)))
        for rows in [slice(MOTION_SIZE * k, MOTION_SIZE * (k + 1))]
    ]
    largest = max(effects, key=lambda one: one.low)
    small = largest.low < floor
    failed = _failed_rules(equations, accepted, sway, remaining, floor, small, versus_lenses)
    explanation = Explanation(
        bodies=bodies,
        kind="sway",
        photos=equations.photos,
        numbers=SWAY_SIZE,
        score=float(sway.likelihood_ratio - SWAY_SIZE * np.log(equations.sample_size)),
        chance=p_value,
        effect=largest.size,
        low=largest.low,
        high=largest.high,
        variance_before=lack_of_fit.variance_factor,
        variance_after=1.0,
        failed=tuple(failed),
        floor=floor,
    )
    return Sway(explanation, motions)


def _posterior_motions(
    equations: NormalEquations, sway: SpreadEstimate
) -> tuple[Float64[np.ndarray, "n 6"], Float64[np.ndarray, "k k"]]:
    """Motion of each photo with a zero-mean prior of this spread, and the covariance of all."""
    sigmas = np.tile(np.repeat(sway.spread, MOTION_SIZE // 2), len(equations.right) // MOTION_SIZE)
    covariance = np.linalg.inv(equations.normal + np.diag(1.0 / sigmas**2))
    return (covariance @ equations.right).reshape(-1, MOTION_SIZE), covariance


def _failed_rules(
    equations: TwoBodyEquations,
    accepted: AcceptedTerms,
    sway: SpreadEstimate,
    remaining: NormalEquations,
    floor: float,
    small: bool,
    versus_lenses: Callable[..., SwayVersusLenses],
) -> Iterator[Rule]:
    """The rules that a sway fails.

    Args:
        remaining: Equations of the motions, with the accepted terms eliminated.
        small: Whether even its largest motion may be below what matters.
    """
    second_body = accepted.second_body
    joint = NormalEquations(second_body.normal, second_body.right)
    free, lens = joint.eliminating(second_body.embedded(accepted.columns)), second_body.lens
    of_lens = NormalEquations(free.normal[lens, lens], free.right[lens])
    by_lens = estimate_spread(of_lens, USUAL_SPREAD, MAX_SPREAD)
    if sway.likelihood_ratio - by_lens.likelihood_ratio < VERY_STRONG_EVIDENCE:
        yield "lens"
    freed = equations.deviations
    beaten = bool(freed) and versus_lenses(*freed).over_lenses < VERY_STRONG_EVIDENCE
    if not equations.board_calibrated or beaten:
        yield "model"
    if small:
        yield "size"
    well_observed = remaining.eliminating(_motion_columns(~equations.well_observed))
    if _sway_spread(equations, well_observed, floor).p_value(SWAY_SIZE) > SIGNIFICANCE_LEVEL:
        yield "few points"
    if not _is_significant_without_largest(equations, well_observed, floor):
        yield "one photo"
    spread = np.minimum(SPREAD_MARGIN * second_body.spread, MAX_SPREAD)
    wider = estimate_sway(equations, accepted, second_body_equations(equations, spread), floor)
    if wider.p_value(SWAY_SIZE) > SIGNIFICANCE_LEVEL:
        yield "lenses of photos"


def estimate_sway(
    equations: TwoBodyEquations,
    accepted: AcceptedTerms,
    second_body: SecondBodyEquations,
    floor: float,
) -> SpreadEstimate:
    """Spread of the motions that the accepted terms leave, of rotations and of shifts."""
    remaining = second_body.of_motion.eliminating(accepted.columns)
    return _sway_spread(equations, remaining, floor)


def _sway_spread(
    equations: TwoBodyEquations, motions: NormalEquations, floor: float
) -> SpreadEstimate:
    """Spread of rotations and of shifts, each isotropic."""
    usual = np.array([floor / equations.radius] * 3 + [floor] * 3)
    most = np.array([_MAX_SWAY[0]] * 3 + [_MAX_SWAY[1] * equations.distance] * 3)
    return estimate_spread(motions, usual, most, group_size=3)


def sway_versus_lenses(
    equations: TwoBodyEquations, accepted: AcceptedTerms, kinds: Sequence[Deviation], floor: float
) -> SwayVersusLenses:
    """How well a sway explains what these kinds of lens deviation would.

    Args:
        kinds: Deviations that are at most usual ones where the limb sways.
    """
    of_lenses = deviation_equations(equations, accepted.columns)
    most = MAX_SPREAD.copy()
    for kind in kinds:
        most[deviation_slice(kind)] = USUAL_SPREAD[deviation_slice(kind)]
    usual = estimate_spread(of_lenses, USUAL_SPREAD, most).spread
    ratio = estimate_sway(
        equations, accepted, second_body_equations(equations, usual), floor
    ).likelihood_ratio
    shown = deviance(of_lenses, accepted.second_body.spread, USUAL_SPREAD)
    return SwayVersusLenses(ratio, shown - deviance(of_lenses, usual, USUAL_SPREAD) + ratio)


def explains_as_well(sway: SwayVersusLenses) -> bool:
    """Whether the lenses do not explain clearly more than a sway does."""
    significant = chi_square_tail(sway.likelihood_ratio, SWAY_SIZE) <= SIGNIFICANCE_LEVEL
    return significant and sway.over_lenses > -VERY_STRONG_EVIDENCE


def _motion_columns(photos: Bool[np.ndarray, " n"]) -> Float64[np.ndarray, "m k"]:
    """Columns of the motions of these photos."""
    return np.kron(np.eye(len(photos))[:, photos], np.eye(MOTION_SIZE))


def _is_significant_without_largest(
    equations: TwoBodyEquations, well_observed: NormalEquations, floor: float
) -> bool:
    """Whether the sway is significant without the photo that moves farthest.

    Args:
        well_observed: Of photos that many points hold: wrong matches draw the others each its own
            way, and nothing outvotes them.
    """
    each = np.eye(len(equations.photos), dtype=bool)
    statistics = [
        ScoreTest.of(well_observed.restricted_to(_motion_columns(one))).statistic for one in each
    ]
    without = well_observed.eliminating(_motion_columns(each[int(np.argmax(statistics))]))
    return _sway_spread(equations, without, floor).p_value(SWAY_SIZE) <= SIGNIFICANCE_LEVEL
