"""Relative motion: how one body moved against another between the photos, and what is said of it.

In      two scenes of the same photos, each placed by the points of one body alone, calibrations.
Out     a BodyMotion: by photo, how far the second body moved against the first, whether that is a
        fact, and all explanations, ranked.
Method  The search over hypotheses (search.py). Its facts amount to a step, a drift, a sway or an
        unclear course; what it cannot decide is unknown, with what it may be and what would decide.
        A photo that one body holds by few points and that lies elsewhere by itself is left out: it
        is an outlier that wrong matches displace (Baarda 1968).
Limits  Fewer than ten photos tell nothing: half a ring of 7 photos of 0.24 MP seemed to move, and
        did not.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.findings import note
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.hypotheses.lens_spread import lens_spread, second_body_equations
from limbgram.reconstruction.hypotheses.search import explain
from limbgram.reconstruction.hypotheses.search_result import SearchResult
from limbgram.reconstruction.hypotheses.two_body_equations import (
    MIN_FIRM_POINTS,
    TwoBodyEquations,
    two_body_equations,
)
from limbgram.reconstruction.mapping.body_motion import (
    MOTION_SIZE,
    BodyMotion,
    points_in_three_photos,
)
from limbgram.reconstruction.mapping.scene import Bodies, Explanation, Movement, Scene
from limbgram.reconstruction.mapping.score_tests import SIGNIFICANCE_LEVEL

RELATIVE_FLOOR = 0.00025
"""Smallest motion of a point that matters, over the distance of the cameras, where no board tells
millimetres: 0.25 mm from 1 m."""
FLOOR_MM = 0.25
"""The same in millimetres."""
FEWEST_PHOTOS = 10
MOST_PHOTOS = 60
"""Photos that are searched: the time grows with their third power, and is 5 s for 50."""
MAX_MISFIT_P_VALUE = 0.5
"""p-value below which an unknown motion counts as a misfit (`Movement.misfit`)."""


def movement_between(
    first: Scene,
    second: Scene,
    priors: Sequence[Calibration],
    bodies: Bodies,
    mm: float | None = None,
) -> BodyMotion:
    """How the second body moved against the first, at the centre of the first one's points.

    Args:
        mm: A millimetre in the first scene's unit; None where no board tells it.
    """
    both = tuple(sorted({*first.placed} & {*second.placed}))
    photos = _evenly_sampled(both)
    shared_points = np.minimum(points_in_three_photos(first), points_in_three_photos(second))
    while True:
        if len(photos) < FEWEST_PHOTOS:
            few = note("movement.unknown.few_shown", photos=len(photos))
            return BodyMotion.unknown(len(first.names), few)
        equations = two_body_equations(first, second, photos, priors)
        floor = RELATIVE_FLOOR * equations.distance if mm is None else FLOOR_MM * mm
        found = explain(equations, bodies, floor)
        displaced = [
            one.photos[0]
            for one in found.explanations
            if one.kind == "photo" and shared_points[one.photos[0]] < MIN_FIRM_POINTS
        ]
        if not displaced:
            return _with_interpolated(
                _body_motion(found, equations, floor, len(first.names)),
                {*both} - {*_evenly_sampled(both)},
            )
        photos = tuple(photo for photo in photos if photo not in displaced)


def _evenly_sampled(photos: tuple[int, ...]) -> tuple[int, ...]:
    """At most `MOST_PHOTOS`, spread evenly."""
    if len(photos) <= MOST_PHOTOS:
        return photos
    chosen = np.linspace(0, len(photos) - 1, MOST_PHOTOS).round().astype(int)
    return tuple(photos[k] for k in chosen.tolist())


def _with_interpolated(motion: BodyMotion, photos: set[int]) -> BodyMotion:
    """The motion, with photos that were not searched interpolated between their neighbours.

    Only in a drift, or where both neighbours belong to one group.
    """
    movement = motion.movement
    group, shift, turn = movement.group.copy(), movement.shift.copy(), movement.turn_deg.copy()
    motions = motion.motions.copy()
    known = np.flatnonzero(movement.group >= 0)
    for photo in sorted(photos):
        before, after = known[known < photo][-1:], known[known > photo][:1]
        ends = np.concatenate([before, after])
        evenly = movement.kind in ("drift", "unclear")
        if len(ends) < 2 or not (evenly or group[ends[0]] == group[ends[1]]):
            continue
        share = (photo - ends[0]) / (ends[1] - ends[0])
        weights = np.array([1.0 - share, share])
        group[photo] = group[ends[0]]
        shift[photo], turn[photo] = weights @ shift[ends], weights @ turn[ends]
        motions[photo] = weights @ motions[ends]
    whole = replace(movement, group=group, shift=shift, turn_deg=turn)
    return replace(motion, movement=whole, motions=motions)


def is_rigid_with_first(
    first: Scene, third: Scene, second: BodyMotion, priors: Sequence[Calibration]
) -> bool:
    """Whether a third body kept still with the first where the second moved against it.

    It did if no motion between the two is found, and if the motion of the second body is less
    likely for the third one by the significance level.
    """
    known = second.movement.group >= 0
    photos = _evenly_sampled(
        tuple(k for k in sorted({*first.placed} & {*third.placed}) if known[k])
    )
    if len(photos) < FEWEST_PHOTOS:
        return False
    equations = two_body_equations(first, third, photos, priors)
    found = explain(equations, "limb and board", RELATIVE_FLOOR * equations.distance)
    if found.verdict != "still":
        return False
    of_motion = second_body_equations(equations, lens_spread(equations)).of_motion
    motions = second.motions[list(photos)].ravel()
    deviance = float(motions @ of_motion.normal @ motions - 2.0 * of_motion.right @ motions)
    return deviance > -2.0 * float(np.log(SIGNIFICANCE_LEVEL))


def _body_motion(
    found: SearchResult, equations: TwoBodyEquations, floor: float, photos: int
) -> BodyMotion:
    """The motion by photo that a search result amounts to."""
    known = np.array(found.photos)
    facts = tuple(one for one in found.facts if one.kind != "photo")
    motions = np.zeros((photos, MOTION_SIZE))
    if found.undecided and not facts:
        chance = min(found.undecided[0].chance, MAX_MISFIT_P_VALUE)
        undecided = BodyMotion.unknown(photos, None, chance)
        listed = replace(
            undecided.movement,
            explanations=found.explanations,
            instead_of_lenses=found.instead_of_lenses,
        )
        return replace(undecided, movement=listed)
    unknown = Movement.unknown(photos)
    group, shift, turn = unknown.group.copy(), unknown.shift.copy(), unknown.turn_deg.copy()
    group[known], shift[known], turn[known], largest = 0, 0.0, 0.0, 0.0
    kind: Literal["still", "step", "drift", "restless", "unclear"] = "still"
    if facts:
        kind = _kind(facts) if found.course_known else "unclear"
        own = shown = np.arange(len(known))
        if kind == "step":
            shown = _same_place(found.motions, equations.radius, floor)
            own = np.unique(shown, return_inverse=True)[1]
        group[known] = own
        reference, places = _reference(kind, own), found.motions[shown]
        off = places - (places[reference] if reference >= 0 else 0.0)
        motions[known] = off
        shift[known] = np.linalg.norm(off[:, 3:], axis=1)
        turn[known] = np.degrees(np.linalg.norm(off[:, :3], axis=1))
        apart = off[:, None, 3:] - off[None, :, 3:]
        largest = float(np.linalg.norm(apart, axis=2).max())
    movement = Movement(
        kind=kind,
        group=group,
        shift=shift,
        turn_deg=turn,
        chance=min((one.chance for one in facts), default=1.0),
        largest=largest,
        explanations=found.explanations,
        instead_of_lenses=found.instead_of_lenses,
    )
    return BodyMotion(movement=movement, middle=equations.centre, motions=motions)


def _kind(facts: tuple[Explanation, ...]) -> Literal["step", "drift", "restless"]:
    """The kind of movement that some facts amount to."""
    kinds = {one.kind for one in facts}
    return "restless" if "sway" in kinds else "drift" if "drift" in kinds else "step"


def _same_place(
    motions: Float64[np.ndarray, "n 6"], radius: float, floor: float
) -> Int64[np.ndarray, " n"]:
    """By photo, the first one that shows the body where it does: no point is off by what matters.

    After steps away and back it lies where it lay before.
    """
    weights = np.repeat([radius, 1.0], MOTION_SIZE // 2)
    shown: list[int] = []
    for photo, motion in enumerate(motions):
        alike = (
            one
            for one in dict.fromkeys(shown)
            if np.linalg.norm(weights * (motion - motions[one])) < floor
        )
        shown.append(next(alike, photo))
    return np.array(shown, np.int64)


def _reference(kind: str, group: Int64[np.ndarray, " n"]) -> int:
    """The photo that motions count from: of the largest group, or the middle one."""
    match kind:
        case "step":
            return int(np.flatnonzero(group == int(np.bincount(group).argmax()))[0])
        case "drift" | "unclear":
            return len(group) // 2
        case _:
            return -1
