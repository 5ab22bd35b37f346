"""Search for relative motion of two bodies: which terms explain it, and which of them are facts.

In      TwoBodyEquations, and the size from which a motion matters.
Out     a SearchResult: the ranked list, and the verdict.
Method  Forward selection by score tests (Rao 1948). The null model has poses, one lens for each
        camera, a deviation of each photo's lens of the spread that the capture shows, and another
        lens for the second body. The best term is accepted, the spread estimated anew, and so on
        while the best one is significant. Kinds are compared by likelihood less the logarithm of
        the sample size for each parameter (BIC) and that of the number of candidates.
        The noise is that between clusters of points, or what the model in which every photo shows
        the second body elsewhere leaves unexplained, whichever is larger. What remains significant
        may be a sway: an independent motion in each photo, against an independent lens in each.
        Where no board calibrated the lens, or photos have lens deviations of their own, what a real
        lens does beyond its model, and a rolling shutter at other depths, depends on the bodies'
        places in the picture, which differ from photo to photo: a sway is no fact there, unless
        it explains clearly more than those lenses; and such a lens is none unless it explains
        clearly more than a sway. Photos that were framed or focused otherwise look like a step or
        a drift: these are no facts there unless they are significant beside lenses that do all they
        may along the courses of all terms.
        A term is a fact if it passes all rules of `mapping.scene.Rule`. That a body moved is one
        thing, its course another: a slight drift looks like one step. The course is told only
        where no other one (a step, a drift, a sway) explains nearly as much.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from limbgram.core.interval import COVER
from limbgram.reconstruction.hypotheses.accepted_terms import (
    AcceptedTerms,
    Effect,
    design_matrix,
    largest_displacement,
)
from limbgram.reconstruction.hypotheses.lens_spread import (
    SecondBodyEquations,
    deviation_equations,
    lens_spread,
    second_body_equations,
)
from limbgram.reconstruction.hypotheses.random_motion import (
    SWAY_SIZE,
    Sway,
    SwayVersusLenses,
    estimate_sway,
    explains_as_well,
    find_sway,
    sway_versus_lenses,
)
from limbgram.reconstruction.hypotheses.search_result import SearchResult
from limbgram.reconstruction.hypotheses.terms import Term, drifts, single_photos, steps
from limbgram.reconstruction.hypotheses.two_body_equations import TwoBodyEquations
from limbgram.reconstruction.mapping.body_motion import MOTION_SIZE
from limbgram.reconstruction.mapping.lens_equations import (
    DEVIATION_SIZE,
    MAX_OUTLIER_SHARE,
    MAX_SPREAD,
    TIGHT_SPREAD,
    USUAL_SPREAD,
)
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


def explain(equations: TwoBodyEquations, bodies: Bodies, floor: float) -> SearchResult:
    """How the second body moved against the first, as far as the photos tell.

    Args:
        floor: Motion of a point of the first body from which it matters, in the scene's unit.
    """
    accepted = _forward_selection(equations)
    explained = [_explanation(equations, accepted, term, bodies, floor) for term in accepted.terms]

    @cache
    def versus_lenses(*kinds: Deviation) -> SwayVersusLenses:
        return sway_versus_lenses(equations, accepted, kinds, floor)

    sway = find_sway(equations, accepted, bodies, floor, versus_lenses)
    unexplained = _unexplained(equations, accepted, bodies, floor, sway)
    every = [
        *explained,
        *([sway.explanation] if sway else []),
        *([unexplained] if unexplained else []),
    ]
    ranked = tuple(sorted(every, key=lambda one: -one.score))
    motions = accepted.motions([one.is_fact for one in explained])
    certain_sway = sway if sway is not None and sway.explanation.is_fact else None
    if certain_sway is not None:
        motions = motions + certain_sway.motions
    facts = [term for term, one in zip(accepted.terms, explained, strict=True) if one.is_fact]
    return SearchResult(
        explanations=ranked,
        photos=equations.photos,
        motions=motions,
        course_known=certain_sway is not None
        or _course_is_known(equations, accepted, facts, floor),
        instead_of_lenses=tuple(
            kind for kind in equations.deviations if explains_as_well(versus_lenses(kind))
        ),
    )


def _forward_selection(equations: TwoBodyEquations) -> AcceptedTerms:
    """Terms accepted one by one, each the one that explains most, while it is significant.

    A motion that is not explained yet looks like lenses that differ much from photo to photo. So
    candidates are tried at the spread estimated without them, at a usual one and at a tenth of
    that, and the significant ones are compared at the spread estimated anew beside each.
    """
    accepted = AcceptedTerms((), second_body_equations(equations, lens_spread(equations)), (), ())
    while len(accepted.terms) < _MOST_TERMS:
        trials = [
            _with_term(equations, accepted, *one)
            for one in _significant_candidates(equations, accepted)
        ]
        trials = [one for one in trials if one.p_values[-1] <= SIGNIFICANCE_LEVEL]
        if not trials:
            break
        accepted = min(trials, key=lambda one: _information_criterion(equations, one))
    return accepted


class _Candidate(NamedTuple):
    """A term, and the number of candidates of its kind."""

    term: Term
    candidates: int


def _significant_candidates(
    equations: TwoBodyEquations, accepted: AcceptedTerms
) -> list[_Candidate]:
    """The best candidate of each kind, at one lens spread or another, if it is significant."""
    spreads = [
        np.minimum(accepted.second_body.spread, most)
        for most in (USUAL_SPREAD, TIGHT_SPREAD * USUAL_SPREAD)
    ]
    second_bodies = [
        accepted.second_body,
        *(second_body_equations(equations, one) for one in spreads),
    ]
    significant: list[_Candidate] = []
    for second_body in second_bodies:
        remaining = second_body.of_motion.eliminating(accepted.columns)
        every = ScoreTest.of(remaining)
        for group in _candidates(equations, accepted.terms):
            best, test = _best_of(group, remaining)
            known = any(one.term.same_as(best) for one in significant)
            if not known and f_test_p_value(every, test, len(group)) <= SIGNIFICANCE_LEVEL:
                significant.append(_Candidate(best, len(group)))
    return significant


def _best_of(group: Sequence[Term], remaining: NormalEquations) -> tuple[Term, ScoreTest]:
    """The term of a group that explains most of what remains, and its test."""
    tests = [ScoreTest.of(remaining.restricted_to(one.columns)) for one in group]
    best = int(np.argmax([one.statistic for one in tests]))
    return group[best], tests[best]


def _candidates(equations: TwoBodyEquations, terms: Sequence[Term]) -> list[list[Term]]:
    """Terms that may be added, by kind: a body steps or drifts; single photos lie elsewhere."""
    count = len(equations.photos)
    groups: list[list[Term]] = []
    if all(one.kind != "drift" for one in terms):
        taken = tuple(one.at for one in terms if one.kind == "step")
        groups.append(list(steps(count, taken)))
    if all(one.kind == "photo" for one in terms):
        groups.append(list(drifts(np.array(equations.photos, float))))
    used = {one.at for one in terms if one.kind == "photo"}
    if len(used) < MAX_OUTLIER_SHARE * count:
        groups.append([one for one in single_photos(count) if one.at not in used])
    return groups


def _with_term(
    equations: TwoBodyEquations, accepted: AcceptedTerms, term: Term, candidates: int
) -> AcceptedTerms:
    """The accepted terms with one more, at the lens spread estimated anew beside it."""
    terms = (*accepted.terms, term)
    columns = design_matrix(terms, len(equations.photos))
    second_body = second_body_equations(equations, lens_spread(equations, columns))
    remaining = second_body.of_motion.eliminating(accepted.columns)
    test = ScoreTest.of(remaining.restricted_to(term.columns))
    p_value = f_test_p_value(ScoreTest.of(remaining), test, candidates)
    return AcceptedTerms(
        terms, second_body, (*accepted.p_values, p_value), (*accepted.candidates, candidates)
    )


def _information_criterion(equations: TwoBodyEquations, accepted: AcceptedTerms) -> float:
    """BIC of the accepted terms, with a penalty for the number of candidates."""
    of_lenses = deviation_equations(equations)
    columns = accepted.columns
    terms_test = ScoreTest.of(accepted.second_body.of_motion.restricted_to(columns))
    cost = columns.shape[1] * np.log(equations.sample_size)
    cost += 2.0 * np.log(accepted.candidates).sum()
    of_spread = deviance(of_lenses, accepted.second_body.spread, USUAL_SPREAD)
    return float(of_spread - terms_test.statistic + cost)


def _course_is_known(
    equations: TwoBodyEquations, accepted: AcceptedTerms, facts: Sequence[Term], floor: float
) -> bool:
    """Whether no other course explains nearly as much as the steps or the drift that are facts."""
    kinds = {one.kind for one in facts} & {"step", "drift"}
    if not kinds:
        return True
    still = _without_courses(equations, accepted)
    remaining = still.second_body.of_motion.eliminating(still.columns)
    rivals = [_sway_criterion(equations, still, floor)]
    for group in _candidates(equations, still.terms):
        if group[0].kind in {"step", "drift"} - kinds:
            best, _ = _best_of(group, remaining)
            rival = _with_term(equations, still, best, len(group))
            rivals.append(_information_criterion(equations, rival))
    noise = max(1.0, accepted.lack_of_fit.variance_factor)
    lead = min(rivals) - _information_criterion(equations, accepted)
    return lead / noise >= VERY_STRONG_EVIDENCE


def _without_courses(equations: TwoBodyEquations, accepted: AcceptedTerms) -> AcceptedTerms:
    """The accepted terms without steps and drift, at the lens spread estimated anew."""
    kept = [k for k, one in enumerate(accepted.terms) if one.kind == "photo"]
    terms = tuple(accepted.terms[k] for k in kept)
    columns = design_matrix(terms, len(equations.photos))
    return AcceptedTerms(
        terms,
        second_body_equations(equations, lens_spread(equations, columns)),
        tuple(accepted.p_values[k] for k in kept),
        tuple(accepted.candidates[k] for k in kept),
    )


def _sway_criterion(equations: TwoBodyEquations, accepted: AcceptedTerms, floor: float) -> float:
    """BIC of a sway beside the accepted terms, at their lens spread or at most a usual one."""
    found: list[float] = []
    for most in (MAX_SPREAD, USUAL_SPREAD):
        spread = np.minimum(accepted.second_body.spread, most)
        second_body = second_body_equations(equations, spread)
        sway = estimate_sway(equations, accepted, second_body, floor)
        beside = _information_criterion(equations, replace(accepted, second_body=second_body))
        cost = SWAY_SIZE * np.log(equations.sample_size)
        found.append(beside - sway.likelihood_ratio + float(cost))
    return min(found)


def _explanation(
    equations: TwoBodyEquations, accepted: AcceptedTerms, term: Term, bodies: Bodies, floor: float
) -> Explanation:
    """One of the accepted terms, with the rules that it fails."""
    number = next(k for k, one in enumerate(accepted.terms) if one is term)
    others = accepted.columns_without(term)
    remaining = accepted.second_body.of_motion.eliminating(others)
    every, test = ScoreTest.of(remaining), ScoreTest.of(remaining.restricted_to(term.columns))
    noise = max(1.0, accepted.lack_of_fit.variance_factor)
    effect = _effect(equations, remaining, term, noise)
    failed: list[Rule] = []
    if not _beats_lens_rivals(equations, accepted, term):
        failed.append("lens")
    known = equations.has_known_lenses
    if not known and not _is_significant_beside_lenses(equations, accepted, term):
        failed.append("model")
    if effect.low < floor:
        failed.append("size")
    if not _is_significant_without_any_photo(accepted, term):
        failed.append("one photo")
    wider = second_body_equations(
        equations, np.minimum(SPREAD_MARGIN * accepted.second_body.spread, MAX_SPREAD)
    )
    wider_remaining = wider.of_motion.eliminating(others)
    if not is_significant(wider_remaining, term.columns):
        failed.append("lenses of photos")
    cost = test.dof * np.log(equations.sample_size) + 2.0 * np.log(accepted.candidates[number])
    return Explanation(
        bodies=bodies,
        kind=term.kind,
        photos=_moved_photos(equations, term),
        numbers=test.dof,
        score=float(test.statistic / noise - cost),
        chance=accepted.p_values[number],
        effect=effect.size,
        low=effect.low,
        high=effect.high,
        variance_before=every.variance_factor,
        variance_after=accepted.lack_of_fit.variance_factor,
        failed=tuple(failed),
        floor=floor,
    )


def _moved_photos(equations: TwoBodyEquations, term: Term) -> tuple[int, ...]:
    """Photos on the smaller side of a step; all photos of a drift; the single photo."""
    match term.kind:
        case "step":
            after = term.course > 0
            fewer = after if after.sum() * 2 <= len(after) else ~after
            return tuple(np.array(equations.photos)[fewer].tolist())
        case "photo":
            return (equations.photos[term.at],)
        case _:
            return equations.photos


def _effect(
    equations: TwoBodyEquations, remaining: NormalEquations, term: Term, noise: float
) -> Effect:
    """Largest displacement of a point at the first body's radius, with its interval of 95 %."""
    of_term = remaining.restricted_to(term.columns)
    covariance = noise * pseudo_inverse(of_term.normal)
    values = pseudo_inverse(of_term.normal) @ of_term.right * float(np.ptp(term.course) or 1.0)
    covariance = covariance * float(np.ptp(term.course) or 1.0) ** 2
    size = len(values)
    to_move = np.eye(MOTION_SIZE)[:, MOTION_SIZE - size :]
    return largest_displacement(
        to_move @ values, to_move @ covariance @ to_move.T, equations.radius
    )


def _beats_lens_rivals(equations: TwoBodyEquations, accepted: AcceptedTerms, term: Term) -> bool:
    """Whether it explains clearly more than what a lens may do along the same course.

    The rivals are a lens that changes along it, as the second body alone sees it; and a motion of
    the second body that is the same in each camera's frame, not in the world's: whatever a lens
    does beyond its model, it does in the camera's frame. The term must also be significant beside
    a lens that changes so for all of the photo.
    """
    second_body = accepted.second_body
    others = second_body.embedded(accepted.columns_without(term))
    remaining = NormalEquations(second_body.normal, second_body.right).eliminating(others)
    noise = max(1.0, accepted.lack_of_fit.variance_factor)
    by_term = ScoreTest.of(remaining.restricted_to(second_body.embedded(term.columns))).statistic
    for course in term.lens_courses:
        lens = np.zeros((len(second_body.right), DEVIATION_SIZE))
        lens[second_body.lens] = np.kron(course[:, None], np.eye(DEVIATION_SIZE))
        in_camera_frame = second_body.embedded(_camera_frame_columns(equations, course))
        for rival in (lens, in_camera_frame):
            by_rival = ScoreTest.of(remaining.restricted_to(rival)).statistic
            if (by_term - by_rival) / noise < VERY_STRONG_EVIDENCE:
                return False
    changing_lens = np.zeros((len(equations.right), DEVIATION_SIZE))
    changing_lens[equations.lens] = np.kron(term.course[:, None], np.eye(DEVIATION_SIZE))
    free = _with_eliminated(equations, changing_lens, second_body.spread)
    beside_lens = free.of_motion.eliminating(accepted.columns_without(term))
    return is_significant(beside_lens, term.columns)


def _is_significant_beside_lenses(
    equations: TwoBodyEquations, accepted: AcceptedTerms, term: Term
) -> bool:
    """Whether it is significant beside lenses that change along the courses of all terms."""
    changing = [
        _lens_columns(equations, course) for one in accepted.terms for course in one.lens_courses
    ]
    free = _with_eliminated(equations, np.hstack(changing), accepted.second_body.spread)
    remaining = free.of_motion.eliminating(accepted.columns_without(term))
    return is_significant(remaining, term.columns)


def _lens_columns(
    equations: TwoBodyEquations, course: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, "u k"]:
    """Columns of all that lenses may do along a course, for both bodies or the second alone."""
    columns = np.zeros((len(equations.right), 2 * DEVIATION_SIZE + MOTION_SIZE))
    every = np.kron(course[:, None], np.eye(DEVIATION_SIZE))
    columns[equations.lens, :DEVIATION_SIZE] = every
    columns[equations.second_lens, DEVIATION_SIZE : 2 * DEVIATION_SIZE] = every
    columns[equations.motion, 2 * DEVIATION_SIZE :] = _camera_frame_columns(equations, course)
    return columns


def _camera_frame_columns(
    equations: TwoBodyEquations, course: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, "m 6"]:
    """Columns of a motion along a course that is the same in each camera's own frame."""
    columns = np.zeros((len(course), MOTION_SIZE, MOTION_SIZE))
    columns[:, :3, :3] = equations.camera_from_world.transpose(0, 2, 1)
    columns[:, 3:, 3:] = columns[:, :3, :3]
    return (course[:, None, None] * columns).reshape(-1, MOTION_SIZE)


def _with_eliminated(
    equations: TwoBodyEquations,
    columns: Float64[np.ndarray, "u k"],
    spread: Float64[np.ndarray, "9"],
) -> SecondBodyEquations:
    """The second body's equations once these directions of the joint ones are eliminated."""
    free = NormalEquations(equations.normal, equations.right).eliminating(columns)
    remaining = replace(equations, normal=free.normal, right=free.right)
    return second_body_equations(remaining, spread)


def _is_significant_without_any_photo(accepted: AcceptedTerms, term: Term) -> bool:
    """Whether it is significant whichever photo is left out."""
    remaining = accepted.second_body.of_motion.eliminating(accepted.columns_without(term))
    every = ScoreTest.of(remaining)
    for photo in range(accepted.second_body.photos):
        own = np.zeros((MOTION_SIZE * accepted.second_body.photos, MOTION_SIZE))
        own[MOTION_SIZE * photo : MOTION_SIZE * (photo + 1)] = np.eye(MOTION_SIZE)
        without = remaining.eliminating(own)
        test = ScoreTest.of(without.restricted_to(term.columns))
        own_statistic = ScoreTest.of(remaining.restricted_to(own)).statistic
        others = ScoreTest(every.statistic - own_statistic, every.dof - MOTION_SIZE)
        if f_test_p_value(others, test, 1) > SIGNIFICANCE_LEVEL:
            return False
    return True


def _unexplained(
    equations: TwoBodyEquations,
    accepted: AcceptedTerms,
    bodies: Bodies,
    floor: float,
    sway: Sway | None,
) -> Explanation | None:
    """The motions that no term explains, if they are significant."""
    lack_of_fit = accepted.lack_of_fit
    if lack_of_fit.p_value > SIGNIFICANCE_LEVEL or sway is not None:
        return None
    sway_spread = estimate_sway(equations, accepted, accepted.second_body, floor)
    turn, shift = sway_spread.spread
    size = float(np.hypot(equations.radius * turn, shift))
    return Explanation(
        bodies=bodies,
        kind="rest",
        photos=equations.photos,
        numbers=lack_of_fit.dof,
        score=float(lack_of_fit.statistic - lack_of_fit.dof * np.log(equations.sample_size)),
        chance=lack_of_fit.p_value,
        effect=size,
        low=0.0,
        high=COVER * size,
        variance_before=lack_of_fit.variance_factor,
        variance_after=1.0,
        failed=("chance",),
        floor=floor,
    )
