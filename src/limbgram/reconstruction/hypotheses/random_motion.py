"""Random motion (sway) of a body from photo to photo, tested against lenses that vary likewise.

In      an Evidence, and what a search found in it.
Out     a Sway with the rules that it fails, or none where chance explains what is left; what a sway
        explains instead of lenses of single photos.
Method  Turns and shifts, each alike in all directions, of the likeliest spread. Where no board
        calibrated the lens, or single photos have lenses of their own, a sway is no fact unless it
        explains clearly more than those lenses; and such a lens is none unless it explains clearly
        more than a sway.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.interval import chi_square_tail
from limbgram.reconstruction.hypotheses.accepted_terms import Found, motion_size
from limbgram.reconstruction.hypotheses.evidence import MOVE, Evidence
from limbgram.reconstruction.hypotheses.spread import Left, left_of, seen_of_lenses
from limbgram.reconstruction.mapping.lens_evidence import MOST, USUAL, place_of
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

_MOST_MOVED = (0.2, 0.1)
"""Of a sway: rad, and of the distance. What moves farther is no patient who shifts."""


class Instead(NamedTuple):
    """A sway where lenses of single photos are usual ones."""

    likelihood_ratio: float
    """By it, over usual lenses alone."""
    over_lenses: float
    """By both, over the lenses that the capture shows, without it."""


@dataclass(frozen=True)
class Sway:
    explanation: Explanation
    motions: Float64[np.ndarray, "n 6"]


def swaying(
    evidence: Evidence,
    found: Found,
    bodies: Bodies,
    floor: float,
    instead: Callable[..., Instead],
) -> Sway | None:
    """Motions drawn anew for each photo, where they explain what chance does not.

    Args:
        instead: What a sway explains instead of some kinds of deviation (`sway_instead`).
    """
    by_motion = sway_of(evidence, found, found.left, floor)
    chance = chi_square_tail(by_motion.likelihood_ratio, 2)
    rest = found.rest
    if max(chance, rest.p_value) > SIGNIFICANCE_LEVEL:
        return None
    seen = found.left.only(found.left.motion).eliminating(found.columns)
    motions, covariance = _likeliest_motions(seen, by_motion)
    sizes = [
        motion_size(motions[k], covariance[rows, rows], evidence.radius)
        for k in (np.flatnonzero(evidence.firm) if evidence.firm.any() else range(len(motions)))
        for rows in [slice(MOVE * k, MOVE * (k + 1))]
    ]
    largest = max(sizes, key=lambda one: one.low)
    small = largest.low < floor
    failed = tuple(_failed(evidence, found, by_motion, seen, floor, small, instead))
    told = Explanation(
        bodies=bodies,
        kind="sway",
        photos=evidence.photos,
        numbers=2,
        score=float(by_motion.likelihood_ratio - 2 * np.log(evidence.facts)),
        chance=chance,
        effect=largest.size,
        low=largest.low,
        high=largest.high,
        variance_before=rest.variance_factor,
        variance_after=1.0,
        failed=failed,
        floor=floor,
    )
    return Sway(told, motions)


def _likeliest_motions(
    seen: NormalEquations, sway: SpreadEstimate
) -> tuple[Float64[np.ndarray, "n 6"], Float64[np.ndarray, "k k"]]:
    """Of each photo where they are of this spread, and the covariance of all."""
    drawn = np.tile(np.repeat(sway.spread, MOVE // 2), len(seen.right) // MOVE)
    covariance = np.linalg.inv(seen.normal + np.diag(1.0 / drawn**2))
    return (covariance @ seen.right).reshape(-1, MOVE), covariance


def _failed(
    evidence: Evidence,
    found: Found,
    sway: SpreadEstimate,
    seen: NormalEquations,
    floor: float,
    small: bool,
    instead: Callable[..., Instead],
) -> Iterator[Rule]:
    """What a sway fails of.

    Args:
        seen: Of the motions, without those that were found.
        small: Whether even its largest motion may be below what matters.
    """
    lens = found.left.lens
    moved = np.zeros((len(found.left.right), found.columns.shape[1]))
    moved[found.left.motion] = found.columns
    free = NormalEquations(found.left.normal, found.left.right).eliminating(moved)
    by_lens = estimate_spread(
        NormalEquations(free.normal[lens, lens], free.right[lens]), USUAL, MOST
    )
    if sway.likelihood_ratio - by_lens.likelihood_ratio < VERY_STRONG_EVIDENCE:
        yield "lens"
    own = evidence.deviations
    if not evidence.by_boards or (own and instead(*own).over_lenses < VERY_STRONG_EVIDENCE):
        yield "model"
    if small:
        yield "size"
    firm = seen.eliminating(_motions_of(~evidence.firm))
    if chi_square_tail(_sway_in(evidence, firm, floor).likelihood_ratio, 2) > SIGNIFICANCE_LEVEL:
        yield "few points"
    if not _sways_without_any(evidence, firm, floor):
        yield "one photo"
    wide = left_of(evidence, np.minimum(SPREAD_MARGIN * found.left.spread, MOST))
    if (
        chi_square_tail(sway_of(evidence, found, wide, floor).likelihood_ratio, 2)
        > SIGNIFICANCE_LEVEL
    ):
        yield "lenses of photos"


def sway_of(evidence: Evidence, found: Found, left: Left, floor: float) -> SpreadEstimate:
    return _sway_in(evidence, left.only(left.motion).eliminating(found.columns), floor)


def _sway_in(evidence: Evidence, seen: NormalEquations, floor: float) -> SpreadEstimate:
    """Of turns and of shifts, each alike in all directions."""
    usual = np.array([floor / evidence.radius] * 3 + [floor] * 3)
    most = np.array([_MOST_MOVED[0]] * 3 + [_MOST_MOVED[1] * evidence.distance] * 3)
    return estimate_spread(seen, usual, most, group_size=3)


def sway_instead(
    evidence: Evidence, found: Found, kinds: Sequence[Deviation], floor: float
) -> Instead:
    """What a sway explains instead of these kinds: twice logarithms of likelihood.

    Args:
        kinds: Deviations that are usual ones at most where the limb sways.
    """
    seen = seen_of_lenses(evidence, found.columns)
    most = MOST.copy()
    for kind in kinds:
        most[place_of(kind)] = USUAL[place_of(kind)]
    usual = estimate_spread(seen, USUAL, most).spread
    sway = sway_of(evidence, found, left_of(evidence, usual), floor)
    by_lenses = deviance(seen, found.left.spread, USUAL)
    return Instead(
        sway.likelihood_ratio, by_lenses - deviance(seen, usual, USUAL) + sway.likelihood_ratio
    )


def explains_as_well(sway: Instead) -> bool:
    """Whether the lenses do not explain clearly more than a sway does."""
    return (
        chi_square_tail(sway.likelihood_ratio, 2) <= SIGNIFICANCE_LEVEL
        and sway.over_lenses > -VERY_STRONG_EVIDENCE
    )


def _motions_of(photos: Bool[np.ndarray, " n"]) -> Float64[np.ndarray, "m k"]:
    """Columns of the motions of these photos."""
    return np.kron(np.eye(len(photos))[:, photos], np.eye(MOVE))


def _sways_without_any(evidence: Evidence, firm: NormalEquations, floor: float) -> bool:
    """Whether they sway without the photo that moves farthest, too.

    Args:
        firm: Of photos that many points hold: wrong matches draw the others each its own way, and
            nothing outvotes them.
    """
    every = np.eye(len(evidence.photos), dtype=bool)
    falls = [ScoreTest.of(firm.restricted_to(_motions_of(one))).statistic for one in every]
    without = firm.eliminating(_motions_of(every[int(np.argmax(falls))]))
    return (
        chi_square_tail(_sway_in(evidence, without, floor).likelihood_ratio, 2)
        <= SIGNIFICANCE_LEVEL
    )
