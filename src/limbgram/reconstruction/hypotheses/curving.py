"""Curving: whether the limb's length is bent otherwise in some photos than in the others.

In      the scene of the limb's points alone, what contradicts a rigid limb still in it, and
        calibrations.
Out     the likeliest change of its curvature, held against the rules of every other term.
Method  Two rigid halves have six numbers in each photo and see too little of a lean that grows
        along the limb: one of 8 mm was a chance of 0.03. Here the limb has one pose in each photo,
        and a term moves its points across its length by the square and the cube of their place
        along it: four numbers for all photos behind a step, or in proportion to a drift. Score
        test (Rao 1948) with poses, points, the lens (as calibrated) and each photo's lens deviation
        (of the spread that the capture shows beside any curving) projected out; the noise is that
        of clusters of points, or what curvatures of single photos leave, whichever is larger.
Limits  Photos of a lens that no board calibrated are not asked: what it does beyond its model bends
        limbs. Fewer than ten photos tell nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE
from limbgram.core.interval import length_within
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.hypotheses.bodies import (
    BEYOND_CHANCE,
    FEWEST_PHOTOS,
    FLOOR,
    FLOOR_MM,
    MOST_PHOTOS,
)
from limbgram.reconstruction.hypotheses.deformation_fields import Along, FieldEvidence
from limbgram.reconstruction.hypotheses.terms import drifts, steps
from limbgram.reconstruction.mapping.bundle import Bundle
from limbgram.reconstruction.mapping.lens_evidence import (
    MOST,
    OWN,
    USUAL,
    clusters_of,
    eliminated,
    inflation_of,
    lens_basis,
    packed,
)
from limbgram.reconstruction.mapping.scene import Explanation, Movement, Scene
from limbgram.reconstruction.mapping.score_tests import (
    SIGNIFICANCE_LEVEL,
    ScoreTest,
    estimate_spread,
    pseudo_inverse,
)
from limbgram.reconstruction.mapping.solution import LensPrior, reduced_equations

FIELD = 4
"""Numbers of a curving: across the length in two directions, by square and cube of the place."""
_ENDS = 0.98
"""Share of the points that the two ends of the length hold between them."""
_LEAST_WEIGHT = 1e-12
"""By which points are damped, of their own weight."""


@dataclass(frozen=True)
class Curving:
    """A change of curvature, and how much of it each photo of the scene shows."""

    explanation: Explanation
    course: Float64[np.ndarray, " p"]
    """By photo; NaN of those without a place."""
    turn_deg: float
    """By which the end of the limb that moves most tilts."""

    def beside(self, halves: Movement) -> Movement:
        """What both halves show against each other, and this beside it."""
        one = self.explanation
        ranked = tuple(sorted((one, *halves.explanations), key=lambda each: -each.score))
        if halves.moved or not (one.told or one.open_):
            return replace(halves, explanations=ranked)
        if not one.told:
            unknown = Movement.unknown(len(self.course), chance=min(one.chance, BEYOND_CHANCE))
            return replace(unknown, explanations=ranked)
        known = np.isfinite(self.course)
        group = np.full(len(known), -1, np.int64)
        if one.kind == "step":
            group[known] = self.course[known]
            most = np.bincount(group[known]).argmax()
        else:
            group[known], most = np.arange(known.sum()), 0.0
        share = np.abs(self.course - most)
        return Movement(
            kind="step" if one.kind == "step" else "drift",
            group=group,
            shift=one.effect * share,
            turn_deg=self.turn_deg * share,
            chance=one.chance,
            largest=one.effect,
            explanations=ranked,
        )


def curving(scene: Scene, priors: Sequence[Calibration], mm: float | None = None) -> Curving | None:
    """The likeliest change of curvature unless chance explains it.

    Args:
        scene: Of the limb's points alone, adjusted.
        mm: A millimetre in the scene's unit; None where no board tells it.
    """
    photos = len(scene.placed)
    calibrated = all(one.source == "board" for one in priors)
    if not calibrated or not FEWEST_PHOTOS <= photos <= MOST_PHOTOS:
        return None
    field = _Field.of(scene.points_in_world)
    if field.half_length <= 0.0:
        return None
    evidence = _evidence(scene, priors, field)
    spread = estimate_spread(evidence.lenses_beside_fields(), USUAL, MOST).spread
    seen = evidence.fields(spread)
    terms = [*steps(photos), next(drifts(np.array(scene.placed, np.int64)))]
    every = ScoreTest.of(seen)
    tried = [Along.of(evidence, spread, one.course, seen, every) for one in terms]
    best = int(np.argmax([one.one.statistic for one in tried]))
    term, along = terms[best], tried[best]
    chance = along.chance(len(terms))
    if chance > SIGNIFICANCE_LEVEL:
        return None
    effect = field.effect(along)
    floor = FLOOR * _distance(scene) if mm is None else FLOOR_MM * mm
    failed = along.failed()
    if scene.own is not None:
        failed.append("model")
    if effect.low < floor:
        failed.append("size")
    after = term.course > 0.0 if term.kind == "step" else np.ones(photos, bool)
    fewer = after if after.sum() * 2 <= photos or term.kind == "drift" else ~after
    cost = FIELD * np.log(evidence.facts) + 2.0 * np.log(len(terms))
    course = np.full(len(scene.names), np.nan)
    course[list(scene.placed)] = term.course
    return Curving(
        explanation=Explanation(
            bodies="halves",
            kind="step" if term.kind == "step" else "drift",
            photos=tuple(np.array(scene.placed)[fewer].tolist()),
            numbers=FIELD,
            score=float(along.one.statistic / along.noise - cost),
            chance=chance,
            effect=effect.size,
            low=effect.low,
            high=effect.high,
            variance_before=every.variance_factor,
            variance_after=along.rest,
            failed=tuple(failed),
            floor=floor,
        ),
        course=course,
        turn_deg=effect.turn_deg,
    )


def _distance(scene: Scene) -> float:
    """Of the cameras, to the middle of the points."""
    middle = np.median(scene.points_in_world, axis=0)
    return float(np.median([np.linalg.norm(one.centre_in_world - middle) for one in scene.views]))


@dataclass(frozen=True)
class _Field:
    """Motions across the limb's length by the square and the cube of the place along it."""

    columns: Float64[np.ndarray, "n 3 4"]
    """By point, for numbers that are motions of an end."""
    half_length: float

    @classmethod
    def of(cls, points: Points3) -> "_Field":
        arms = points - np.median(points, axis=0)
        axes = np.linalg.svd(arms, full_matrices=False)[2]
        along, across = arms @ axes[0], axes[1:]
        half = float(np.quantile(np.abs(along), _ENDS))
        place = np.clip(along / half, -1.0, 1.0) if half > 0.0 else along
        powers = np.column_stack([place**2, place**3])
        columns = powers[:, None, :, None] * across.T[None, :, None, :]
        return cls(columns.reshape(len(points), 3, FIELD), half)

    def effect(self, along: Along) -> "_Effect":
        """Of the end that surely moves farthest across the length, once a turn is taken off."""
        numbers, covariance = along.solved
        found: list[_Effect] = []
        for side in (-1.0, 1.0):
            end = np.hstack([np.eye(2), side * np.eye(2)])
            tilt = np.hstack([2.0 * side * np.eye(2), 3.0 * np.eye(2)]) / self.half_length
            turn_deg = float(np.degrees(np.linalg.norm(tilt @ numbers)))
            found.append(_Effect(*length_within(end @ numbers, end @ covariance @ end.T), turn_deg))
        return max(found, key=lambda one: one.low)


@dataclass(frozen=True)
class _Effect:
    size: float
    low: float
    high: float
    turn_deg: float


def _evidence(scene: Scene, priors: Sequence[Calibration], field: _Field) -> FieldEvidence:
    """Poses, points and lenses eliminated."""
    bundle = Bundle.of(scene)
    photos, lenses = len(bundle.views), LENS_SIZE * len(priors)
    first = POSE_SIZE * photos
    clusters = clusters_of(bundle.points)
    parts = [_reduced(bundle, scene, priors, field, part) for part in clusters]
    curves = np.arange(first + lenses + OWN * photos, len(parts[0][1]))
    inflation = _inflation(parts, np.concatenate([np.arange(first), curves]))
    normal = np.sum([one for one, _ in parts], axis=0) / inflation
    right = np.sum([one for _, one in parts], axis=0) / inflation
    prior = LensPrior.of(priors, hold_board_lenses=False)
    lens = slice(first, first + lenses)
    prior.join(normal, right, packed(scene), first)
    known = np.ones(first + lenses, bool)
    known[lens] = prior.free
    kept = np.arange(first + lenses, len(right))
    left, pull = eliminated(normal, right, np.flatnonzero(known), kept)
    return FieldEvidence(photos, FIELD, left, pull, photos * len(clusters))


def _inflation(
    parts: Sequence[tuple[Float64[np.ndarray, "u u"], Float64[np.ndarray, " u"]]],
    firm: Int64[np.ndarray, " f"],
) -> float:
    """Variance of the clusters' pulls, each photo's pose and curvature solved for.

    At the rigid solution a limb that bends pulls its clusters apart, and would be noise to itself.
    """
    normals = [normal[np.ix_(firm, firm)] for normal, _ in parts]
    rights = [right[firm] for _, right in parts]
    solved = pseudo_inverse(np.sum(normals, axis=0)) @ np.sum(rights, axis=0)
    left = [pull - one @ solved for one, pull in zip(normals, rights, strict=True)]
    return inflation_of(normals, left)


def _reduced(
    bundle: Bundle,
    scene: Scene,
    priors: Sequence[Calibration],
    field: _Field,
    chosen: Bool[np.ndarray, " n"],
) -> tuple[Float64[np.ndarray, "u u"], Float64[np.ndarray, " u"]]:
    """Over poses, lenses, deviations and curvings in units of sigma, by some of the points, which
    are eliminated."""
    photos, sigma_px = len(bundle.views), bundle.sigma_px(scene)
    camera = np.array(scene.camera_idx, np.int64)[list(scene.placed)]
    basis = np.array([lens_basis(one.camera) for one in priors])
    normal, right, _ = reduced_equations(
        bundle.with_points(chosen), camera, basis, sigma_px, _LEAST_WEIGHT, field.columns[chosen]
    )
    first = POSE_SIZE * photos + LENS_SIZE * len(priors)
    own = first + np.arange((OWN + FIELD) * photos).reshape(photos, -1)
    rows = np.concatenate([np.arange(first), own[:, :OWN].ravel(), own[:, OWN:].ravel()])
    return normal[np.ix_(rows, rows)] / sigma_px**2, right[rows] / sigma_px**2
