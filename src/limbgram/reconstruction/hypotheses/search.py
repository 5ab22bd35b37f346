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
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.interval import COVER, chi_square_tail, length_within
from limbgram.reconstruction.hypotheses.evidence import MOVE, Evidence
from limbgram.reconstruction.hypotheses.explanation import Explained
from limbgram.reconstruction.hypotheses.spread import Left, left_of, seen_of_lenses, spread_of
from limbgram.reconstruction.hypotheses.terms import Term, drifts, single_photos, steps
from limbgram.reconstruction.mapping.lens_evidence import MOST, OWN, USUAL, place_of
from limbgram.reconstruction.mapping.quadratic import (
    CLEARLY,
    FALSE_ALARM,
    MANY_TIMES,
    Fall,
    Likeliest,
    Quadratic,
    chance_of,
    likeliest,
    pseudo_inverse,
    unlikeliness,
)
from limbgram.reconstruction.mapping.scene import Bodies, Deviation, Explanation, Rule

_MOST_ALONE = 0.2
"""Share of the photos that may lie elsewhere one by one; more of them are a sway."""
_MOST_TERMS = 8
_TENTH = 0.1
_SWAY_MOST = (0.2, 0.1)
"""Of a sway: rad, and of the distance. What moves farther is no patient who shifts."""


def explained(evidence: Evidence, bodies: Bodies, floor: float) -> Explained:
    """What happened between two bodies.

    Args:
        floor: Motion of a point of the first body from which it matters, in the scene's unit.
    """
    found = _best(evidence)
    parts = [_described(evidence, found, term, bodies, floor) for term in found.terms]
    sway = _swaying(evidence, found, bodies, floor)
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
            kind for kind in evidence.deviations if _sways_as_well(evidence, found, kind, floor)
        ),
    )


@dataclass(frozen=True)
class _Found:
    """Terms that chance does not explain, and what is left."""

    terms: tuple[Term, ...]
    left: Left
    chances: tuple[float, ...]
    candidates: tuple[int, ...]

    @property
    def columns(self) -> Float64[np.ndarray, "m k"]:
        return _columns(self.terms, self.left.photos)

    def others(self, term: Term) -> Float64[np.ndarray, "m k"]:
        return _columns([one for one in self.terms if one is not term], self.left.photos)

    @property
    def rest(self) -> Fall:
        return Fall.of(self.left.only(self.left.motion).without(self.columns))

    def motions(self, told: Sequence[bool]) -> Float64[np.ndarray, "n 6"]:
        """By photo, of the terms that are facts."""
        columns = self.columns
        if not columns.shape[1]:
            return np.zeros((self.left.photos, MOVE))
        seen = self.left.only(self.left.motion).along(columns)
        values = pseudo_inverse(seen.normal) @ seen.right
        kept = np.repeat(told, [one.columns.shape[1] for one in self.terms])
        return (columns[:, kept] @ values[kept]).reshape(-1, MOVE)


def _columns(terms: Sequence[Term], photos: int) -> Float64[np.ndarray, "m k"]:
    return np.hstack([np.zeros((MOVE * photos, 0)), *(one.columns for one in terms)])


def _best(evidence: Evidence) -> _Found:
    """Terms one by one, each the one that explains most, while chance does not explain it.

    A motion that is not explained yet looks like lenses that differ much from photo to photo. So
    candidates are looked at with the spread that is found without them, with a usual one and with a
    tenth of that, and those that chance does not explain are compared with the spread found anew
    beside them.
    """
    found = _Found((), left_of(evidence, spread_of(evidence)), (), ())
    while len(found.terms) < _MOST_TERMS:
        trials = [_with(evidence, found, *one) for one in _likely(evidence, found)]
        trials = [one for one in trials if one.chances[-1] <= FALSE_ALARM]
        if not trials:
            break
        found = min(trials, key=lambda one: _criterion(evidence, one))
    return found


class _Candidate(NamedTuple):
    """A term, and how many of its kind were tried."""

    term: Term
    among: int


def _likely(evidence: Evidence, found: _Found) -> list[_Candidate]:
    """The best of each kind, by one spread of lenses or another, unless chance explains it."""
    spreads = [np.minimum(found.left.spread, most) for most in (USUAL, _TENTH * USUAL)]
    lefts = [found.left, *(left_of(evidence, one) for one in spreads)]
    likely: list[_Candidate] = []
    for left in lefts:
        seen = left.only(left.motion).without(found.columns)
        every = Fall.of(seen)
        for group in _candidates(evidence, found.terms):
            sums = [Fall.of(seen.along(one.columns)) for one in group]
            best = int(np.argmax([one.fall for one in sums]))
            known = any(one.term.same_as(group[best]) for one in likely)
            if not known and chance_of(every, sums[best], len(group)) <= FALSE_ALARM:
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
    if len(used) < _MOST_ALONE * count:
        groups.append([one for one in single_photos(count) if one.at not in used])
    return groups


def _with(evidence: Evidence, found: _Found, term: Term, among: int) -> _Found:
    """With one term more, and the spread found anew."""
    terms = (*found.terms, term)
    columns = _columns(terms, len(evidence.photos))
    left = left_of(evidence, spread_of(evidence, columns))
    seen = left.only(left.motion).without(found.columns)
    one = Fall.of(seen.along(term.columns))
    chance = chance_of(Fall.of(seen), one, among)
    return _Found(terms, left, (*found.chances, chance), (*found.candidates, among))


def _criterion(evidence: Evidence, found: _Found) -> float:
    """Minus twice the logarithm of likelihood, with what the numbers and candidates cost."""
    seen = seen_of_lenses(evidence)
    columns = found.columns
    moved = Fall.of(found.left.only(found.left.motion).along(columns))
    cost = columns.shape[1] * np.log(evidence.facts) + 2.0 * np.log(found.candidates).sum()
    return float(unlikeliness(seen, found.left.spread, USUAL) - moved.fall + cost)


def _described(
    evidence: Evidence, found: _Found, term: Term, bodies: Bodies, floor: float
) -> Explanation:
    """One term of those that were found, held against the rules."""
    number = next(k for k, one in enumerate(found.terms) if one is term)
    others = found.others(term)
    seen = found.left.only(found.left.motion).without(others)
    every, one = Fall.of(seen), Fall.of(seen.along(term.columns))
    noise = max(1.0, found.rest.variance)
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
    wide = left_of(evidence, np.minimum(MANY_TIMES * found.left.spread, MOST))
    again = wide.only(wide.motion).without(others)
    if chance_of(Fall.of(again), Fall.of(again.along(term.columns)), 1) > FALSE_ALARM:
        failed.append("lenses of photos")
    cost = one.freedom * np.log(evidence.facts) + 2.0 * np.log(found.candidates[number])
    return Explanation(
        bodies=bodies,
        kind=term.kind,
        photos=_elsewhere(evidence, term),
        numbers=one.freedom,
        score=float(one.fall / noise - cost),
        chance=found.chances[number],
        effect=effect.size,
        low=effect.low,
        high=effect.high,
        variance_before=every.variance,
        variance_after=found.rest.variance,
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


@dataclass(frozen=True)
class _Effect:
    size: float
    low: float
    high: float


def _effect(evidence: Evidence, seen: Quadratic, term: Term, noise: float) -> _Effect:
    """Largest motion of a point at the first body's radius, with its interval of 95 %."""
    along = seen.along(term.columns)
    covariance = noise * pseudo_inverse(along.normal)
    values = pseudo_inverse(along.normal) @ along.right * float(np.ptp(term.course) or 1.0)
    covariance = covariance * float(np.ptp(term.course) or 1.0) ** 2
    size = len(values)
    to_move = np.eye(MOVE)[:, MOVE - size :]
    return _motion_size(to_move @ values, to_move @ covariance @ to_move.T, evidence.radius)


def _motion_size(
    motion: Float64[np.ndarray, "6"], covariance: Float64[np.ndarray, "6 6"], radius: float
) -> _Effect:
    weight = np.array([radius] * 3 + [1.0] * 3)
    moved = weight * motion
    spread = covariance * np.outer(weight, weight)
    return _Effect(*length_within(moved, spread))


def _beats_lens(evidence: Evidence, found: _Found, term: Term) -> bool:
    """Whether it explains clearly more than what a lens may do along the same course.

    Rivals are a lens that changes so, seen by the second body alone; and a motion of the second
    body that is the same in each photo's own frame, not in the world: whatever a lens does beyond
    its model, it does in the photo's frame. Where all of the photo sees a lens that changes so,
    chance must still not explain the term.
    """
    left = found.left
    others = np.zeros((len(left.right), found.others(term).shape[1]))
    others[left.motion] = found.others(term)
    seen = Quadratic(left.normal, left.right).without(others)
    motion = np.zeros((len(left.right), term.columns.shape[1]))
    motion[left.motion] = term.columns
    noise = max(1.0, found.rest.variance)
    by_motion = Fall.of(seen.along(motion)).fall
    for course in term.rivals:
        lens, in_photos = np.zeros((len(left.right), OWN)), np.zeros((len(left.right), MOVE))
        lens[left.lens] = np.kron(course[:, None], np.eye(OWN))
        in_photos[left.motion] = _in_photos(evidence, course)
        for rival in (lens, in_photos):
            if (by_motion - Fall.of(seen.along(rival)).fall) / noise < CLEARLY:
                return False
    whole = np.zeros((len(evidence.right), OWN))
    whole[evidence.own] = np.kron(term.course[:, None], np.eye(OWN))
    free = _with_free(evidence, whole, left.spread)
    again = free.only(free.motion).without(found.others(term))
    return chance_of(Fall.of(again), Fall.of(again.along(term.columns)), 1) <= FALSE_ALARM


def _stands_beside_lenses(evidence: Evidence, found: _Found, term: Term) -> bool:
    """Whether chance does not explain it where lenses change along the courses of all terms."""
    changing = [_lens_along(evidence, course) for one in found.terms for course in one.rivals]
    free = _with_free(evidence, np.hstack(changing), found.left.spread)
    seen = free.only(free.motion).without(found.others(term))
    return chance_of(Fall.of(seen), Fall.of(seen.along(term.columns)), 1) <= FALSE_ALARM


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
    free = Quadratic(evidence.normal, evidence.right).without(columns)
    lessened = replace(evidence, normal=free.normal, right=free.right)
    return left_of(lessened, spread)


def _stands_without_any(found: _Found, term: Term) -> bool:
    """Whether chance does not explain it either where any one photo is left out."""
    seen = found.left.only(found.left.motion).without(found.others(term))
    every = Fall.of(seen)
    for photo in range(found.left.photos):
        own = np.zeros((MOVE * found.left.photos, MOVE))
        own[MOVE * photo : MOVE * (photo + 1)] = np.eye(MOVE)
        without = seen.without(own)
        one = Fall.of(without.along(term.columns))
        own_fall = Fall.of(seen.along(own)).fall
        rest = Fall(every.fall - own_fall, every.freedom - MOVE)
        if chance_of(rest, one, 1) > FALSE_ALARM:
            return False
    return True


@dataclass(frozen=True)
class _Sway:
    explanation: Explanation
    motions: Float64[np.ndarray, "n 6"]


def _swaying(evidence: Evidence, found: _Found, bodies: Bodies, floor: float) -> _Sway | None:
    """Motions drawn anew for each photo, where they explain what chance does not."""
    by_motion = _sway_of(evidence, found, found.left, floor)
    chance = chi_square_tail(by_motion.gain, 2)
    rest = found.rest
    if max(chance, rest.chance) > FALSE_ALARM:
        return None
    lens = found.left.lens
    moved = np.zeros((len(found.left.right), found.columns.shape[1]))
    moved[found.left.motion] = found.columns
    free = Quadratic(found.left.normal, found.left.right).without(moved)
    by_lens = likeliest(Quadratic(free.normal[lens, lens], free.right[lens]), USUAL, MOST)
    wide = left_of(evidence, np.minimum(MANY_TIMES * found.left.spread, MOST))
    again = _sway_of(evidence, found, wide, floor)
    seen = found.left.only(found.left.motion).without(found.columns)
    firm = seen.without(_motions_of(~evidence.firm))
    drawn = np.tile(np.repeat(by_motion.spread, MOVE // 2), found.left.photos)
    covariance = np.linalg.inv(seen.normal + np.diag(1.0 / drawn**2))
    motions = (covariance @ seen.right).reshape(-1, MOVE)
    sizes = [
        _motion_size(motions[k], covariance[rows, rows], evidence.radius)
        for k in (np.flatnonzero(evidence.firm) if evidence.firm.any() else range(len(motions)))
        for rows in [slice(MOVE * k, MOVE * (k + 1))]
    ]
    largest = max(sizes, key=lambda one: one.low)
    failed: list[Rule] = []
    if by_motion.gain - by_lens.gain < CLEARLY:
        failed.append("lens")
    own = evidence.deviations
    if not evidence.by_boards or (
        own and _sway_instead(evidence, found, own, floor).over_lenses < CLEARLY
    ):
        failed.append("model")
    if largest.low < floor:
        failed.append("size")
    if chi_square_tail(_sway_in(evidence, firm, floor).gain, 2) > FALSE_ALARM:
        failed.append("few points")
    if not _sways_without_any(evidence, firm, floor):
        failed.append("one photo")
    if chi_square_tail(again.gain, 2) > FALSE_ALARM:
        failed.append("lenses of photos")
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
        failed=tuple(failed),
        floor=floor,
    )
    return _Sway(told, motions)


def _sway_of(evidence: Evidence, found: _Found, left: Left, floor: float) -> Likeliest:
    return _sway_in(evidence, left.only(left.motion).without(found.columns), floor)


def _sway_in(evidence: Evidence, seen: Quadratic, floor: float) -> Likeliest:
    """Of turns and of shifts, each alike in all directions."""
    usual = np.array([floor / evidence.radius] * 3 + [floor] * 3)
    most = np.array([_SWAY_MOST[0]] * 3 + [_SWAY_MOST[1] * evidence.distance] * 3)
    return likeliest(seen, usual, most, alike=3)


class _Instead(NamedTuple):
    """A sway where lenses of single photos are usual ones."""

    gain: float
    """By it, over usual lenses alone."""
    over_lenses: float
    """By both, over the lenses that the capture shows, without it."""


def _sway_instead(
    evidence: Evidence, found: _Found, kinds: Sequence[Deviation], floor: float
) -> _Instead:
    """What a sway explains instead of these kinds: twice logarithms of likelihood.

    Args:
        kinds: Deviations that are usual ones at most where the limb sways.
    """
    seen = seen_of_lenses(evidence, found.columns)
    most = MOST.copy()
    for kind in kinds:
        most[place_of(kind)] = USUAL[place_of(kind)]
    usual = likeliest(seen, USUAL, most).spread
    sway = _sway_of(evidence, found, left_of(evidence, usual), floor)
    by_lenses = unlikeliness(seen, found.left.spread, USUAL)
    return _Instead(sway.gain, by_lenses - unlikeliness(seen, usual, USUAL) + sway.gain)


def _sways_as_well(evidence: Evidence, found: _Found, kind: Deviation, floor: float) -> bool:
    """Whether a deviation does not explain clearly more than a sway does."""
    sway = _sway_instead(evidence, found, (kind,), floor)
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


def _rest(
    evidence: Evidence, found: _Found, bodies: Bodies, floor: float, sway: _Sway | None
) -> Explanation | None:
    """What no term explains, where chance does not either."""
    rest = found.rest
    if rest.chance > FALSE_ALARM or sway is not None:
        return None
    by_motion = _sway_of(evidence, found, found.left, floor)
    turn, shift = by_motion.spread
    size = float(np.hypot(evidence.radius * turn, shift))
    return Explanation(
        bodies=bodies,
        kind="rest",
        photos=evidence.photos,
        numbers=rest.freedom,
        score=float(rest.fall - rest.freedom * np.log(evidence.facts)),
        chance=rest.chance,
        effect=size,
        low=0.0,
        high=COVER * size,
        variance_before=rest.variance,
        variance_after=1.0,
        failed=("chance",),
        floor=floor,
    )
