"""The search: which terms explain what two bodies show, and which of them are told as facts.

In      an Evidence, and the size from which a motion matters.
Out     an Explained: the ranked list, and the verdict that movement, bending and words come from.
Method  Score tests (Rao 1948) against everything that the null has: poses, one lens for each
        camera, a deviation of each photo's lens of the spread that the capture shows, and another
        lens for the second body. The best term joins, the spread is found anew, and so on while
        chance does not explain the best. Kinds are told from each other by likelihood, less the
        logarithm of the number of clusters for each number and that of the candidates.
        The noise is that of the adjustments as their clusters show it, or what the model in which
        every photo shows the second body elsewhere leaves unexplained, whichever is larger. What is
        left beyond chance may be a sway: motions drawn anew for each photo, against lenses that
        are drawn anew for each photo.
        Where no board calibrated the lens, or single photos have lenses of their own, what a real
        lens does beyond its model, and a rolling shutter at other depths, differs with the bodies'
        places in the picture, which differ from photo to photo: a sway is no fact there, unless
        it explains clearly more than those lenses; and such a lens is none unless it explains
        clearly more than a sway. Photos that were framed or focused otherwise look like a step or
        a drift: one is no fact there if chance explains it beside lenses that do all they may along
        the courses of all terms.
        A term is told as a fact where it stands all rules of `mapping.scene.Rule`.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from limbgram.core.interval import COVER
from limbgram.reconstruction.hypotheses.accepted_terms import Effect, Found, columns_of, motion_size
from limbgram.reconstruction.hypotheses.evidence import MOVE, Evidence
from limbgram.reconstruction.hypotheses.explanation import Explained
from limbgram.reconstruction.hypotheses.random_motion import (
    Instead,
    Sway,
    explains_as_well,
    sway_instead,
    sway_of,
    swaying,
)
from limbgram.reconstruction.hypotheses.spread import Left, left_of, seen_of_lenses, spread_of
from limbgram.reconstruction.hypotheses.terms import Term, drifts, single_photos, steps
from limbgram.reconstruction.mapping.lens_evidence import MOST, MOST_ALONE, OWN, TIGHT, USUAL
from limbgram.reconstruction.mapping.scene import Bodies, Deviation, Explanation, Rule
from limbgram.reconstruction.mapping.score_tests import (
    SIGNIFICANCE_LEVEL,
    SPREAD_MARGIN,
    VERY_STRONG_EVIDENCE,
    NormalEquations,
    ScoreTest,
    deviance,
    f_test_p_value,
    is_significant,
    pseudo_inverse,
)

_MOST_TERMS = 8


def explained(evidence: Evidence, bodies: Bodies, floor: float) -> Explained:
    """What happened between two bodies.

    Args:
        floor: Motion of a point of the first body from which it matters, in the scene's unit.
    """
    found = _best(evidence)
    parts = [_described(evidence, found, term, bodies, floor) for term in found.terms]

    @cache
    def instead(*kinds: Deviation) -> Instead:
        return sway_instead(evidence, found, kinds, floor)

    sway = swaying(evidence, found, bodies, floor, instead)
    rest = _rest(evidence, found, bodies, floor, sway)
    every = [*parts, *([sway.explanation] if sway else []), *([rest] if rest else [])]
    ranked = tuple(sorted(every, key=lambda one: -one.score))
    motions = found.motions([one.told for one in parts])
    if sway is not None and sway.explanation.told:
        motions = motions + sway.motions
    return Explained(
        explanations=ranked,
        photos=evidence.photos,
        motions=motions,
        instead_of_lenses=tuple(
            kind for kind in evidence.deviations if explains_as_well(instead(kind))
        ),
    )


def _best(evidence: Evidence) -> Found:
    """Terms one by one, each the one that explains most, while chance does not explain it.

    A motion that is not explained yet looks like lenses that differ much from photo to photo. So
    candidates are looked at with the spread that is found without them, with a usual one and with a
    tenth of that, and those that chance does not explain are compared with the spread found anew
    beside them.
    """
    found = Found((), left_of(evidence, spread_of(evidence)), (), ())
    while len(found.terms) < _MOST_TERMS:
        trials = [_with(evidence, found, *one) for one in _likely(evidence, found)]
        trials = [one for one in trials if one.chances[-1] <= SIGNIFICANCE_LEVEL]
        if not trials:
            break
        found = min(trials, key=lambda one: _criterion(evidence, one))
    return found


class _Candidate(NamedTuple):
    """A term, and how many of its kind were tried."""

    term: Term
    among: int


def _likely(evidence: Evidence, found: Found) -> list[_Candidate]:
    """The best of each kind, by one spread of lenses or another, unless chance explains it."""
    spreads = [np.minimum(found.left.spread, most) for most in (USUAL, TIGHT * USUAL)]
    lefts = [found.left, *(left_of(evidence, one) for one in spreads)]
    likely: list[_Candidate] = []
    for left in lefts:
        seen = left.only(left.motion).eliminating(found.columns)
        every = ScoreTest.of(seen)
        for group in _candidates(evidence, found.terms):
            sums = [ScoreTest.of(seen.restricted_to(one.columns)) for one in group]
            best = int(np.argmax([one.statistic for one in sums]))
            known = any(one.term.same_as(group[best]) for one in likely)
            if not known and f_test_p_value(every, sums[best], len(group)) <= SIGNIFICANCE_LEVEL:
                likely.append(_Candidate(group[best], len(group)))
    return likely


def _candidates(evidence: Evidence, terms: Sequence[Term]) -> list[list[Term]]:
    """What may join these, by kind: a body steps or drifts; a few photos lie by themselves."""
    count = len(evidence.photos)
    groups: list[list[Term]] = []
    if all(one.kind != "drift" for one in terms):
        borders = tuple(one.at for one in terms if one.kind == "step")
        groups.append(list(steps(count, borders)))
    if all(one.kind == "photo" for one in terms):
        groups.append(list(drifts(np.array(evidence.photos, float))))
    used = {one.at for one in terms if one.kind == "photo"}
    if len(used) < MOST_ALONE * count:
        groups.append([one for one in single_photos(count) if one.at not in used])
    return groups


def _with(evidence: Evidence, found: Found, term: Term, among: int) -> Found:
    """With one term more, and the spread found anew."""
    terms = (*found.terms, term)
    columns = columns_of(terms, len(evidence.photos))
    left = left_of(evidence, spread_of(evidence, columns))
    seen = left.only(left.motion).eliminating(found.columns)
    one = ScoreTest.of(seen.restricted_to(term.columns))
    chance = f_test_p_value(ScoreTest.of(seen), one, among)
    return Found(terms, left, (*found.chances, chance), (*found.candidates, among))


def _criterion(evidence: Evidence, found: Found) -> float:
    """Minus twice the logarithm of likelihood, with what the numbers and candidates cost."""
    seen = seen_of_lenses(evidence)
    columns = found.columns
    moved = ScoreTest.of(found.left.only(found.left.motion).restricted_to(columns))
    cost = columns.shape[1] * np.log(evidence.facts) + 2.0 * np.log(found.candidates).sum()
    return float(deviance(seen, found.left.spread, USUAL) - moved.statistic + cost)


def _described(
    evidence: Evidence, found: Found, term: Term, bodies: Bodies, floor: float
) -> Explanation:
    """One term of those that were found, held against the rules."""
    number = next(k for k, one in enumerate(found.terms) if one is term)
    others = found.others(term)
    seen = found.left.only(found.left.motion).eliminating(others)
    every, one = ScoreTest.of(seen), ScoreTest.of(seen.restricted_to(term.columns))
    noise = max(1.0, found.rest.variance_factor)
    effect = _effect(evidence, seen, term, noise)
    failed: list[Rule] = []
    if not _beats_lens(evidence, found, term):
        failed.append("lens")
    if not evidence.calibrated and not _stands_beside_lenses(evidence, found, term):
        failed.append("model")
    if effect.low < floor:
        failed.append("size")
    if not _stands_without_any(found, term):
        failed.append("one photo")
    wide = left_of(evidence, np.minimum(SPREAD_MARGIN * found.left.spread, MOST))
    again = wide.only(wide.motion).eliminating(others)
    if not is_significant(again, term.columns):
        failed.append("lenses of photos")
    cost = one.dof * np.log(evidence.facts) + 2.0 * np.log(found.candidates[number])
    return Explanation(
        bodies=bodies,
        kind=term.kind,
        photos=_elsewhere(evidence, term),
        numbers=one.dof,
        score=float(one.statistic / noise - cost),
        chance=found.chances[number],
        effect=effect.size,
        low=effect.low,
        high=effect.high,
        variance_before=every.variance_factor,
        variance_after=found.rest.variance_factor,
        failed=tuple(failed),
        floor=floor,
    )


def _elsewhere(evidence: Evidence, term: Term) -> tuple[int, ...]:
    """Photos of the smaller side of a step; all of a drift; the single one."""
    match term.kind:
        case "step":
            after = term.course > 0
            fewer = after if after.sum() * 2 <= len(after) else ~after
            return tuple(np.array(evidence.photos)[fewer].tolist())
        case "photo":
            return (evidence.photos[term.at],)
        case _:
            return evidence.photos


def _effect(evidence: Evidence, seen: NormalEquations, term: Term, noise: float) -> Effect:
    """Largest motion of a point at the first body's radius, with its interval of 95 %."""
    along = seen.restricted_to(term.columns)
    covariance = noise * pseudo_inverse(along.normal)
    values = pseudo_inverse(along.normal) @ along.right * float(np.ptp(term.course) or 1.0)
    covariance = covariance * float(np.ptp(term.course) or 1.0) ** 2
    size = len(values)
    to_move = np.eye(MOVE)[:, MOVE - size :]
    return motion_size(to_move @ values, to_move @ covariance @ to_move.T, evidence.radius)


def _beats_lens(evidence: Evidence, found: Found, term: Term) -> bool:
    """Whether it explains clearly more than what a lens may do along the same course.

    Rivals are a lens that changes so, seen by the second body alone; and a motion of the second
    body that is the same in each photo's own frame, not in the world: whatever a lens does beyond
    its model, it does in the photo's frame. Where all of the photo sees a lens that changes so,
    chance must still not explain the term.
    """
    left = found.left
    others = np.zeros((len(left.right), found.others(term).shape[1]))
    others[left.motion] = found.others(term)
    seen = NormalEquations(left.normal, left.right).eliminating(others)
    motion = np.zeros((len(left.right), term.columns.shape[1]))
    motion[left.motion] = term.columns
    noise = max(1.0, found.rest.variance_factor)
    by_motion = ScoreTest.of(seen.restricted_to(motion)).statistic
    for course in term.rivals:
        lens, in_photos = np.zeros((len(left.right), OWN)), np.zeros((len(left.right), MOVE))
        lens[left.lens] = np.kron(course[:, None], np.eye(OWN))
        in_photos[left.motion] = _in_photos(evidence, course)
        for rival in (lens, in_photos):
            if (
                by_motion - ScoreTest.of(seen.restricted_to(rival)).statistic
            ) / noise < VERY_STRONG_EVIDENCE:
                return False
    whole = np.zeros((len(evidence.right), OWN))
    whole[evidence.own] = np.kron(term.course[:, None], np.eye(OWN))
    free = _with_free(evidence, whole, left.spread)
    again = free.only(free.motion).eliminating(found.others(term))
    return is_significant(again, term.columns)


def _stands_beside_lenses(evidence: Evidence, found: Found, term: Term) -> bool:
    """Whether chance does not explain it where lenses change along the courses of all terms."""
    changing = [_lens_along(evidence, course) for one in found.terms for course in one.rivals]
    free = _with_free(evidence, np.hstack(changing), found.left.spread)
    seen = free.only(free.motion).eliminating(found.others(term))
    return is_significant(seen, term.columns)


def _lens_along(
    evidence: Evidence, course: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, "u k"]:
    """Columns of all that lenses may do along a course, seen by both bodies or by the second."""
    columns = np.zeros((len(evidence.right), 2 * OWN + MOVE))
    every = np.kron(course[:, None], np.eye(OWN))
    columns[evidence.own, :OWN] = columns[evidence.seen_by_second, OWN : 2 * OWN] = every
    columns[evidence.motion, 2 * OWN :] = _in_photos(evidence, course)
    return columns


def _in_photos(evidence: Evidence, course: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, "m 6"]:
    """Columns of a motion along a course that is the same in each photo's own frame."""
    columns = np.zeros((len(course), MOVE, MOVE))
    columns[:, :3, :3] = evidence.camera_from_world.transpose(0, 2, 1)
    columns[:, 3:, 3:] = columns[:, :3, :3]
    return (course[:, None, None] * columns).reshape(-1, MOVE)


def _with_free(
    evidence: Evidence, columns: Float64[np.ndarray, "u k"], spread: Float64[np.ndarray, "9"]
) -> Left:
    """What is left where these directions of the evidence are free."""
    free = NormalEquations(evidence.normal, evidence.right).eliminating(columns)
    lessened = replace(evidence, normal=free.normal, right=free.right)
    return left_of(lessened, spread)


def _stands_without_any(found: Found, term: Term) -> bool:
    """Whether chance does not explain it either where any one photo is left out."""
    seen = found.left.only(found.left.motion).eliminating(found.others(term))
    every = ScoreTest.of(seen)
    for photo in range(found.left.photos):
        own = np.zeros((MOVE * found.left.photos, MOVE))
        own[MOVE * photo : MOVE * (photo + 1)] = np.eye(MOVE)
        without = seen.eliminating(own)
        one = ScoreTest.of(without.restricted_to(term.columns))
        own_fall = ScoreTest.of(seen.restricted_to(own)).statistic
        rest = ScoreTest(every.statistic - own_fall, every.dof - MOVE)
        if f_test_p_value(rest, one, 1) > SIGNIFICANCE_LEVEL:
            return False
    return True


def _rest(
    evidence: Evidence, found: Found, bodies: Bodies, floor: float, sway: Sway | None
) -> Explanation | None:
    """What no term explains, where chance does not either."""
    rest = found.rest
    if rest.p_value > SIGNIFICANCE_LEVEL or sway is not None:
        return None
    by_motion = sway_of(evidence, found, found.left, floor)
    turn, shift = by_motion.spread
    size = float(np.hypot(evidence.radius * turn, shift))
    return Explanation(
        bodies=bodies,
        kind="rest",
        photos=evidence.photos,
        numbers=rest.dof,
        score=float(rest.statistic - rest.dof * np.log(evidence.facts)),
        chance=rest.p_value,
        effect=size,
        low=0.0,
        high=COVER * size,
        variance_before=rest.variance_factor,
        variance_after=1.0,
        failed=("chance",),
        floor=floor,
    )
