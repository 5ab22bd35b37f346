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
from limbgram.reconstruction.mapping.quadratic import (
    CLEARLY,
    FALSE_ALARM,
    MANY_TIMES,
    Fall,
    Likeliest,
    Quadratic,
    likeliest,
    unlikeliness,
)
from limbgram.reconstruction.mapping.scene import Bodies, Deviation, Explanation, Rule

_MOST_MOVED = (0.2, 0.1)
"""Of a sway: rad, and of the distance. What moves farther is no patient who shifts."""


class Instead(NamedTuple):
    """A sway where lenses of single photos are usual ones."""

    gain: float
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
    chance = chi_square_tail(by_motion.gain, 2)
    rest = found.rest
    if max(chance, rest.chance) > FALSE_ALARM:
        return None
    seen = found.left.only(found.left.motion).without(found.columns)
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
        score=float(by_motion.gain - 2 * np.log(evidence.facts)),
        chance=chance,
        effect=largest.size,
        low=largest.low,
        high=largest.high,
        variance_before=rest.variance,
        variance_after=1.0,
        failed=failed,
        floor=floor,
    )
    return Sway(told, motions)


def _likeliest_motions(
    seen: Quadratic, sway: Likeliest
) -> tuple[Float64[np.ndarray, "n 6"], Float64[np.ndarray, "k k"]]:
    """Of each photo where they are of this spread, and the covariance of all."""
    drawn = np.tile(np.repeat(sway.spread, MOVE // 2), len(seen.right) // MOVE)
    covariance = np.linalg.inv(seen.normal + np.diag(1.0 / drawn**2))
    return (covariance @ seen.right).reshape(-1, MOVE), covariance


def _failed(
    evidence: Evidence,
    found: Found,
    sway: Likeliest,
    seen: Quadratic,
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
    free = Quadratic(found.left.normal, found.left.right).without(moved)
    by_lens = likeliest(Quadratic(free.normal[lens, lens], free.right[lens]), USUAL, MOST)
    if sway.gain - by_lens.gain < CLEARLY:
        yield "lens"
    own = evidence.deviations
    if not evidence.by_boards or (own and instead(*own).over_lenses < CLEARLY):
        yield "model"
    if small:
        yield "size"
    firm = seen.without(_motions_of(~evidence.firm))
    if chi_square_tail(_sway_in(evidence, firm, floor).gain, 2) > FALSE_ALARM:
        yield "few points"
    if not _sways_without_any(evidence, firm, floor):
        yield "one photo"
    wide = left_of(evidence, np.minimum(MANY_TIMES * found.left.spread, MOST))
    if chi_square_tail(sway_of(evidence, found, wide, floor).gain, 2) > FALSE_ALARM:
        yield "lenses of photos"


def sway_of(evidence: Evidence, found: Found, left: Left, floor: float) -> Likeliest:
    return _sway_in(evidence, left.only(left.motion).without(found.columns), floor)


def _sway_in(evidence: Evidence, seen: Quadratic, floor: float) -> Likeliest:
    """Of turns and of shifts, each alike in all directions."""
    usual = np.array([floor / evidence.radius] * 3 + [floor] * 3)
    most = np.array([_MOST_MOVED[0]] * 3 + [_MOST_MOVED[1] * evidence.distance] * 3)
    return likeliest(seen, usual, most, alike=3)


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
    usual = likeliest(seen, USUAL, most).spread
    sway = sway_of(evidence, found, left_of(evidence, usual), floor)
    by_lenses = unlikeliness(seen, found.left.spread, USUAL)
    return Instead(sway.gain, by_lenses - unlikeliness(seen, usual, USUAL) + sway.gain)


def explains_as_well(sway: Instead) -> bool:
    """Whether the lenses do not explain clearly more than a sway does."""
    return chi_square_tail(sway.gain, 2) <= FALSE_ALARM and sway.over_lenses > -CLEARLY


def _motions_of(photos: Bool[np.ndarray, " n"]) -> Float64[np.ndarray, "m k"]:
    """Columns of the motions of these photos."""
    return np.kron(np.eye(len(photos))[:, photos], np.eye(MOVE))


def _sways_without_any(evidence: Evidence, firm: Quadratic, floor: float) -> bool:
    """Whether they sway without the photo that moves farthest, too.

    Args:
        firm: Of photos that many points hold: wrong matches draw the others each its own way, and
            nothing outvotes them.
    """
    every = np.eye(len(evidence.photos), dtype=bool)
    falls = [Fall.of(firm.along(_motions_of(one))).fall for one in every]
    without = firm.without(_motions_of(every[int(np.argmax(falls))]))
    return chi_square_tail(_sway_in(evidence, without, floor).gain, 2) <= FALSE_ALARM
