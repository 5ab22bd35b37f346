"""Bodies: how one body moved against another between the photos, and what is said of it.

In      two scenes of the same photos, each placed by the points of one body alone, calibrations.
Out     a BodyMotion: by photo, how far the second body moved against the first, whether that is a
        fact, and all explanations, ranked.
Method  The search over hypotheses (search.py). What it tells as facts is a step, a drift or a sway;
        what it cannot decide is said to be unknown, with what it may be and what would decide.
        A photo that one body holds by few points and that lies elsewhere by itself is left out: it
        slips to where wrong matches draw it (Baarda 1968).
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
from limbgram.reconstruction.hypotheses.evidence import FIRMLY, MOVE, evidence_of
from limbgram.reconstruction.hypotheses.explanation import Explained
from limbgram.reconstruction.hypotheses.search import explained
from limbgram.reconstruction.hypotheses.spread import left_of, spread_of
from limbgram.reconstruction.mapping.movement import BodyMotion, tied_points
from limbgram.reconstruction.mapping.scene import Bodies, Explanation, Movement, Scene
from limbgram.reconstruction.mapping.score_tests import SIGNIFICANCE_LEVEL

FLOOR = 0.00025
"""Motion of a point from which it matters, of the cameras' distance, where no board tells
millimetres: 0.25 mm from 1 m."""
FLOOR_MM = 0.25
FEWEST_PHOTOS = 10
MOST_PHOTOS = 60
"""Searched: the time goes with their third power, and is 5 s for 50."""
BEYOND_CHANCE = 0.5
"""Chance below which something that is not known is said not to fit (`Movement.misfit`)."""


def movement_between(
    first: Scene,
    second: Scene,
    priors: Sequence[Calibration],
    bodies: Bodies,
    mm: float | None = None,
) -> BodyMotion:
    """How the second body moved against the first, at the middle of the first one's points.

    Args:
        mm: A millimetre in the first scene's unit; None where no board tells it.
    """
    both = tuple(sorted({*first.placed} & {*second.placed}))
    photos = _evenly(both)
    tied = np.minimum(tied_points(first), tied_points(second))
    while True:
        if len(photos) < FEWEST_PHOTOS:
            few = note("movement.unknown.few_shown", photos=len(photos))
            return BodyMotion.unknown(len(first.names), few)
        evidence = evidence_of(first, second, photos, priors)
        floor = FLOOR * evidence.distance if mm is None else FLOOR_MM * mm
        found = explained(evidence, bodies, floor)
        loose = [
            one.photos[0]
            for one in found.explanations
            if one.kind == "photo" and tied[one.photos[0]] < FIRMLY
        ]
        if not loose:
            return _filled(
                _told(found, evidence.middle, len(first.names)), {*both} - {*_evenly(both)}
            )
        photos = tuple(photo for photo in photos if photo not in loose)


def _evenly(photos: tuple[int, ...]) -> tuple[int, ...]:
    """At most as many as can be searched in seconds."""
    if len(photos) <= MOST_PHOTOS:
        return photos
    chosen = np.linspace(0, len(photos) - 1, MOST_PHOTOS).round().astype(int)
    return tuple(photos[k] for k in chosen.tolist())


def _filled(motion: BodyMotion, photos: set[int]) -> BodyMotion:
    """With photos that were not searched: as those before and after them where these agree, and
    between them in a drift."""
    movement = motion.movement
    group, shift, turn = movement.group.copy(), movement.shift.copy(), movement.turn_deg.copy()
    motions = motion.motions.copy()
    told = np.flatnonzero(movement.group >= 0)
    for photo in sorted(photos):
        before, after = told[told < photo][-1:], told[told > photo][:1]
        ends = np.concatenate([before, after])
        drifts = movement.kind == "drift"
        if len(ends) < 2 or not (drifts or group[ends[0]] == group[ends[1]]):
            continue
        share = (photo - ends[0]) / (ends[1] - ends[0])
        weights = np.array([1.0 - share, share])
        group[photo] = group[ends[0]]
        shift[photo], turn[photo] = weights @ shift[ends], weights @ turn[ends]
        motions[photo] = weights @ motions[ends]
    whole = replace(movement, group=group, shift=shift, turn_deg=turn)
    return replace(motion, movement=whole, motions=motions)


def stood_with_first(
    first: Scene, third: Scene, second: BodyMotion, priors: Sequence[Calibration]
) -> bool:
    """Whether a third body kept still with the first where the second moved against it.

    It did where nothing is found to move between both, and where what the photos show of it is less
    likely by the chance of a false alarm if it had moved as the second did.
    """
    told = second.movement.group >= 0
    photos = tuple(k for k in sorted({*first.placed} & {*third.placed}) if told[k])
    if len(photos) < FEWEST_PHOTOS:
        return False
    evidence = evidence_of(first, third, photos, priors)
    found = explained(evidence, "limb and board", FLOOR * evidence.distance)
    if found.verdict != "still":
        return False
    left = left_of(evidence, spread_of(evidence))
    seen = left.only(left.motion)
    motions = second.motions[list(photos)].ravel()
    unlikely = float(motions @ seen.normal @ motions - 2.0 * seen.right @ motions)
    return unlikely > -2.0 * float(np.log(SIGNIFICANCE_LEVEL))


def _told(found: Explained, middle: Float64[np.ndarray, "3"], photos: int) -> BodyMotion:
    """By photo."""
    told = np.array(found.photos)
    facts = tuple(one for one in found.told if one.kind != "photo")
    motions = np.zeros((photos, MOVE))
    if found.undecided and not facts:
        chance = min(found.undecided[0].chance, BEYOND_CHANCE)
        unknown = BodyMotion.unknown(photos, None, chance)
        listed = replace(
            unknown.movement,
            explanations=found.explanations,
            instead_of_lenses=found.instead_of_lenses,
        )
        return replace(unknown, movement=listed)
    nothing = Movement.unknown(photos)
    group, shift, turn = nothing.group.copy(), nothing.shift.copy(), nothing.turn_deg.copy()
    group[told], shift[told], turn[told], largest = 0, 0.0, 0.0, 0.0
    kind: Literal["still", "step", "drift", "restless"] = "still"
    if facts:
        kind = _kind(facts)
        group[told] = _groups(found.motions) if kind == "step" else np.arange(len(told))
        reference = _reference(kind, group[told])
        off = found.motions - (found.motions[reference] if reference >= 0 else 0.0)
        motions[told] = off
        shift[told] = np.linalg.norm(off[:, 3:], axis=1)
        turn[told] = np.degrees(np.linalg.norm(off[:, :3], axis=1))
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
    return BodyMotion(movement=movement, middle=middle, motions=motions)


def _kind(facts: tuple[Explanation, ...]) -> Literal["step", "drift", "restless"]:
    """What they amount to."""
    kinds = {one.kind for one in facts}
    return "restless" if "sway" in kinds else "drift" if "drift" in kinds else "step"


def _groups(motions: Float64[np.ndarray, "n 6"]) -> Int64[np.ndarray, " n"]:
    """Numbers of the runs of photos between steps."""
    changes = np.abs(np.diff(motions, axis=0)).max(axis=1) > 0.0
    return np.concatenate([[0], np.cumsum(changes)]).astype(np.int64)


def _reference(kind: str, group: Int64[np.ndarray, " n"]) -> int:
    """The photo that motions count from: of the largest group, or the middle one of a drift."""
    match kind:
        case "step":
            return int(np.flatnonzero(group == int(np.bincount(group).argmax()))[0])
        case "drift":
            return len(group) // 2
        case _:
            return -1
