"""Curvature: whether the limb's length is bent otherwise in some photos than in the others.

In      the scene of the limb's points alone, with observations that contradict a rigid limb still
        in it, and calibrations.
Out     the most significant change of its curvature, with the rules that it fails.
Method  Two rigid halves have six numbers in each photo and see too little of a lean that grows
        along the limb: one of 8 mm had a p-value of 0.03. Here the limb has one pose in each photo,
        and a term moves its points across its length by the square and the cube of their place
        along it: four numbers for all photos after a step, or in proportion to a drift. Score test
        (Rao 1948) with poses, points, the lens (calibration as prior) and each photo's lens
        deviation (of the spread that the capture shows beside any change of curvature) eliminated;
        the noise is that between clusters of points, or what curvatures of single photos leave,
        whichever is larger.
Limits  Photos of a lens that no board calibrated are not asked: what it does beyond its model bends
        limbs. Fewer than ten photos tell nothing; more than 60 are not asked, as the time grows
        with the third power of their number.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE
from limbgram.core.interval import length_within
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.hypotheses.deformation_fields import FieldEquations, FieldTest
from limbgram.reconstruction.hypotheses.relative_motion import (
    FEWEST_PHOTOS,
    FLOOR_MM,
    MAX_MISFIT_P_VALUE,
    MOST_PHOTOS,
    RELATIVE_FLOOR,
)
from limbgram.reconstruction.hypotheses.terms import drifts, steps
from limbgram.reconstruction.mapping.bundle import Bundle
from limbgram.reconstruction.mapping.bundle_adjustment import LensPrior, reduced_equations
from limbgram.reconstruction.mapping.lens_equations import (
    DEVIATION_SIZE,
    MAX_SPREAD,
    USUAL_SPREAD,
    eliminate,
    known_deviations_rhs,
    lens_basis,
    packed_lenses,
    point_clusters,
    variance_inflation,
)
from limbgram.reconstruction.mapping.scene import Explanation, Movement, Scene
from limbgram.reconstruction.mapping.score_tests import (
    SIGNIFICANCE_LEVEL,
    ScoreTest,
    estimate_spread,
    pseudo_inverse,
)

_NUMBERS = 4
"""Parameters of a field: two directions across the length, by square and by cube of the place."""
_LENGTH_SHARE = 0.98
"""Share of the points between the two ends of the length."""
_POINT_DAMPING = 1e-12
"""Damping of the points, relative to each diagonal entry."""


@dataclass(frozen=True)
class CurvatureChange:
    """A change of curvature, and how much of it each photo of the scene shows."""

    explanation: Explanation
    course: Float64[np.ndarray, " p"]
    """By photo; NaN for photos that are not placed."""
    turn_deg: float
    """Tilt of the end of the limb that moves most."""

    def merged_with(self, halves: Movement) -> Movement:
        """The movement of the halves, with this explanation ranked among theirs."""
        one = self.explanation
        ranked = tuple(sorted((one, *halves.explanations), key=lambda each: -each.score))
        if halves.moved or not (one.is_fact or one.is_undecided):
            return replace(halves, explanations=ranked)
        if not one.is_fact:
            unknown = Movement.unknown(len(self.course), chance=min(one.chance, MAX_MISFIT_P_VALUE))
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


def find_curvature_change(
    scene: Scene, priors: Sequence[Calibration], mm: float | None = None
) -> CurvatureChange | None:
    """The most significant change of curvature; None where none is significant.

    Args:
        scene: Of the limb's points alone, adjusted.
        mm: A millimetre in the scene's unit; None where no board tells it.
    """
    photos = len(scene.placed)
    calibrated = all(one.source == "board" for one in priors)
    if not calibrated or not FEWEST_PHOTOS <= photos <= MOST_PHOTOS:
        return None
    field = _BendingField.of(scene.points_in_world)
    if field.half_length <= 0.0:
        return None
    equations = _field_equations(scene, priors, field)
    spread = estimate_spread(equations.of_lenses(), USUAL_SPREAD, MAX_SPREAD).spread
    of_fields = equations.of_fields(spread)
    terms = [*steps(photos), next(drifts(np.array(scene.placed, np.int64)))]
    each_photo = ScoreTest.of(of_fields)
    tests = [FieldTest.of(equations, spread, one.course, of_fields, each_photo) for one in terms]
    best = int(np.argmax([one.along_course.statistic for one in tests]))
    term, test = terms[best], tests[best]
    p_value = test.p_value(len(terms))
    if p_value > SIGNIFICANCE_LEVEL:
        return None
    effect = field.effect(test)
    floor = RELATIVE_FLOOR * _distance(scene) if mm is None else FLOOR_MM * mm
    failed = test.failed_rules()
    if scene.own is not None:
        failed.append("model")
    if effect.low < floor:
        failed.append("size")
    after = term.course > 0.0 if term.kind == "step" else np.ones(photos, bool)
    fewer = after if after.sum() * 2 <= photos or term.kind == "drift" else ~after
    cost = _NUMBERS * np.log(equations.sample_size) + 2.0 * np.log(len(terms))
    course = np.full(len(scene.names), np.nan)
    course[list(scene.placed)] = term.course
    return CurvatureChange(
        explanation=Explanation(
            bodies="halves",
            kind="step" if term.kind == "step" else "drift",
            photos=tuple(np.array(scene.placed)[fewer].tolist()),
            numbers=_NUMBERS,
            score=float(test.along_course.statistic / test.noise - cost),
            chance=p_value,
            effect=effect.size,
            low=effect.low,
            high=effect.high,
            variance_before=each_photo.variance_factor,
            variance_after=test.residual_variance,
            failed=tuple(failed),
            floor=floor,
        ),
        course=course,
        turn_deg=effect.turn_deg,
    )


def _distance(scene: Scene) -> float:
    """Median distance of the cameras from the centre of the points."""
    centre = np.median(scene.points_in_world, axis=0)
    return float(np.median([np.linalg.norm(one.centre_in_world - centre) for one in scene.views]))


@dataclass(frozen=True)
class _BendingField:
    """Displacements across the limb's length, by square and cube of the place along it."""

    columns: Float64[np.ndarray, "n 3 4"]
    """By point: displacement by each number, which is a displacement of an end."""
    half_length: float

    @classmethod
    def of(cls, points: Points3) -> "_BendingField":
        arms = points - np.median(points, axis=0)
        axes = np.linalg.svd(arms, full_matrices=False)[2]
        along, across = arms @ axes[0], axes[1:]
        half = float(np.quantile(np.abs(along), _LENGTH_SHARE))
        place = np.clip(along / half, -1.0, 1.0) if half > 0.0 else along
        powers = np.column_stack([place**2, place**3])
        columns = powers[:, None, :, None] * across.T[None, :, None, :]
        return cls(columns.reshape(len(points), 3, _NUMBERS), half)

    def effect(self, test: FieldTest) -> "_Effect":
        """Displacement and tilt of the end that surely moves farthest across the length."""
        numbers, covariance = test.estimate
        found: list[_Effect] = []
        for side in (-1.0, 1.0):
            end = np.hstack([np.eye(2), side * np.eye(2)])
            tilt = np.hstack([2.0 * side * np.eye(2), 3.0 * np.eye(2)]) / self.half_length
            turn_deg = float(np.degrees(np.linalg.norm(tilt @ numbers)))
            found.append(_Effect(*length_within(end @ numbers, end @ covariance @ end.T), turn_deg))
        return max(found, key=lambda one: one.low)


@dataclass(frozen=True)
class _Effect:
    """Displacement of an end with its interval of 95 %, and its tilt."""

    size: float
    low: float
    high: float
    turn_deg: float


def _field_equations(
    scene: Scene, priors: Sequence[Calibration], field: _BendingField
) -> FieldEquations:
    """Equations over deviations and fields, with poses, points and lenses eliminated."""
    bundle = Bundle.of(scene)
    photos, lenses = len(bundle.views), LENS_SIZE * len(priors)
    first = POSE_SIZE * photos
    clusters = point_clusters(bundle.points)
    parts = [_reduced(bundle, scene, priors, field, part) for part in clusters]
    fields = np.arange(first + lenses + DEVIATION_SIZE * photos, len(parts[0][1]))
    inflation = _variance_inflation(parts, np.concatenate([np.arange(first), fields]))
    normal = np.sum([one for one, _ in parts], axis=0) / inflation
    right = np.sum([one for _, one in parts], axis=0) / inflation
    prior = LensPrior.of(priors, hold_board_lenses=False)
    lens = slice(first, first + lenses)
    prior.add_to(normal, right, packed_lenses(scene), first)
    free = np.ones(first + lenses, bool)
    free[lens] = prior.free
    kept = np.arange(first + lenses, len(right))
    reduced, reduced_right = eliminate(normal, right, np.flatnonzero(free), kept)
    reduced_right = reduced_right + known_deviations_rhs(scene, scene.placed, reduced)
    return FieldEquations(photos, _NUMBERS, reduced, reduced_right, photos * len(clusters))


def _variance_inflation(
    parts: Sequence[tuple[Float64[np.ndarray, "u u"], Float64[np.ndarray, " u"]]],
    rows: Int64[np.ndarray, " f"],
) -> float:
    """Variance of the clusters' scores, with each photo's pose and curvature solved for.

    At the rigid solution a limb that bends would make its clusters disagree, and be its own noise.
    """
    normals = [normal[np.ix_(rows, rows)] for normal, _ in parts]
    rights = [right[rows] for _, right in parts]
    solved = pseudo_inverse(np.sum(normals, axis=0)) @ np.sum(rights, axis=0)
    residual_scores = [score - one @ solved for one, score in zip(normals, rights, strict=True)]
    return variance_inflation(normals, residual_scores)


def _reduced(
    bundle: Bundle,
    scene: Scene,
    priors: Sequence[Calibration],
    field: _BendingField,
    chosen: Bool[np.ndarray, " n"],
) -> tuple[Float64[np.ndarray, "u u"], Float64[np.ndarray, " u"]]:
    """Equations in units of sigma over poses, lenses, deviations and fields, by some of the points,
    which are eliminated."""
    photos, sigma_px = len(bundle.views), bundle.sigma_px(scene)
    camera = np.array(scene.camera_idx, np.int64)[list(scene.placed)]
    basis = np.array([lens_basis(one.camera) for one in priors])
    normal, right, _ = reduced_equations(
        bundle.with_points(chosen), camera, basis, sigma_px, _POINT_DAMPING, field.columns[chosen]
    )
    first = POSE_SIZE * photos + LENS_SIZE * len(priors)
    own = first + np.arange((DEVIATION_SIZE + _NUMBERS) * photos).reshape(photos, -1)
    rows = np.concatenate(
        [np.arange(first), own[:, :DEVIATION_SIZE].ravel(), own[:, DEVIATION_SIZE:].ravel()]
    )
    return normal[np.ix_(rows, rows)] / sigma_px**2, right[rows] / sigma_px**2
