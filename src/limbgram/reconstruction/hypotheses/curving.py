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
import scipy.sparse as sp
from jaxtyping import Bool, Float64, Int64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE, project_and_differentiate
from limbgram.core.interval import length_within
from limbgram.core.kernels import njit
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.hypotheses.bodies import (
    BEYOND_CHANCE,
    FEWEST_PHOTOS,
    FLOOR,
    FLOOR_MM,
    MOST_PHOTOS,
)
from limbgram.reconstruction.hypotheses.terms import Term, drifts, steps
from limbgram.reconstruction.mapping.bundle import CAUCHY_SIGMAS, Bundle
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
from limbgram.reconstruction.mapping.quadratic import (
    CLEARLY,
    FALSE_ALARM,
    MANY_TIMES,
    Fall,
    Quadratic,
    chance_of,
    likeliest,
    pseudo_inverse,
    solved_for,
)
from limbgram.reconstruction.mapping.scene import Explanation, Movement, Rule, Scene
from limbgram.reconstruction.mapping.solution import LensPrior

FIELD = 4
"""Numbers of a curving: across the length in two directions, by square and cube of the place."""
_ENDS = 0.98
"""Share of the points that the two ends of the length hold between them."""
_LEAST_WEIGHT = 1e-12


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
    spread = likeliest(evidence.lenses_beside_curves(), USUAL, MOST).spread
    seen = evidence.curves(spread)
    terms = [*steps(photos), next(drifts(np.array(scene.placed, np.int64)))]
    every = Fall.of(seen)
    falls = [Fall.of(seen.along(_columns(one))) for one in terms]
    best = int(np.argmax([one.fall for one in falls]))
    term, one = terms[best], falls[best]
    chance = chance_of(every, one, len(terms))
    if chance > FALSE_ALARM:
        return None
    rest = (every.fall - one.fall) / max(every.freedom - one.freedom, 1)
    noise = max(1.0, rest)
    effect = field.effect(seen, term, noise)
    floor = FLOOR * _distance(scene) if mm is None else FLOOR_MM * mm
    failed = _failed(evidence, spread, seen, term, one.fall, noise)
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
            score=float(one.fall / noise - cost),
            chance=chance,
            effect=effect.size,
            low=effect.low,
            high=effect.high,
            variance_before=every.variance,
            variance_after=rest,
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

    def effect(self, seen: Quadratic, term: Term, noise: float) -> "_Effect":
        """Of the end that surely moves farthest across the length, once a turn is taken off."""
        along, range_ = seen.along(_columns(term)), float(np.ptp(term.course))
        covariance = pseudo_inverse(along.normal)
        numbers = range_ * covariance @ along.right
        covariance = noise * range_**2 * covariance
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


@dataclass(frozen=True)
class _Evidence:
    """Normal equations in units of sigma over lens deviations (9 a photo), then curvings (4)."""

    photos: int
    normal: Float64[np.ndarray, "u u"]
    right: Float64[np.ndarray, " u"]
    facts: int

    @property
    def _lenses(self) -> Int64[np.ndarray, " l"]:
        return np.arange(OWN * self.photos)

    @property
    def _curves(self) -> Int64[np.ndarray, " c"]:
        return np.arange(OWN * self.photos, len(self.right))

    def lenses_beside_curves(self) -> Quadratic:
        """What is seen of lens deviations where every photo may have a curvature of its own."""
        return Quadratic(*eliminated(self.normal, self.right, self._curves, self._lenses))

    def curves(
        self,
        spread: Float64[np.ndarray, "9"],
        free: Float64[np.ndarray, "l k"] | None = None,
    ) -> Quadratic:
        """What is left of curvings among deviations of this spread, and of some that are free."""
        normal, right = self.normal, self.right
        if free is not None:
            whole = np.zeros((len(right), free.shape[1]))
            whole[: len(free)] = free
            beside = Quadratic(normal, right).without(whole)
            normal, right = beside.normal, beside.right
        normal = normal.copy()
        diagonal = self._lenses
        normal[diagonal, diagonal] += 1.0 / np.tile(spread, self.photos) ** 2
        return Quadratic(*eliminated(normal, right, self._lenses, self._curves))

    def fall_of_lens(
        self, spread: Float64[np.ndarray, "9"], columns: Float64[np.ndarray, "l k"]
    ) -> float:
        """How far lenses that change so let the sum of squares fall, without any curving."""
        lenses = self._lenses
        normal = self.normal[np.ix_(lenses, lenses)].copy()
        drawn = normal.copy()
        drawn[lenses, lenses] += 1.0 / np.tile(spread, self.photos) ** 2
        both = np.column_stack([self.right[lenses], normal])
        solved = normal @ solved_for(drawn, both)
        left = Quadratic(normal - solved[:, 1:], self.right[lenses] - solved[:, 0])
        return Fall.of(left.along(columns)).fall


def _columns(term: Term) -> Float64[np.ndarray, "c 4"]:
    return np.kron(term.course[:, None], np.eye(FIELD))


def _stands_among(seen: Quadratic, term: Term) -> bool:
    """Whether chance alone does not explain it."""
    return chance_of(Fall.of(seen), Fall.of(seen.along(_columns(term))), 1) <= FALSE_ALARM


def _failed(
    evidence: _Evidence,
    spread: Float64[np.ndarray, "9"],
    seen: Quadratic,
    term: Term,
    fall: float,
    noise: float,
) -> list[Rule]:
    """The rules of lenses and of single photos that a term does not stand; seen: of that spread."""
    wider = evidence.curves(np.minimum(MANY_TIMES * spread, MOST))
    held: dict[Rule, bool] = {
        "lens": _beats_lens(evidence, spread, term, fall, noise),
        "one photo": _stands_without_any(seen, term, evidence.photos),
        "lenses of photos": _stands_among(wider, term),
    }
    return [rule for rule, holds in held.items() if not holds]


def _beats_lens(
    evidence: _Evidence, spread: Float64[np.ndarray, "9"], term: Term, fall: float, noise: float
) -> bool:
    """Whether it explains clearly more than lenses that change along its course, and stands beside
    them."""
    changing = np.kron(term.course[:, None], np.eye(OWN))
    if (fall - evidence.fall_of_lens(spread, changing)) / noise < CLEARLY:
        return False
    return _stands_among(evidence.curves(spread, changing), term)


def _stands_without_any(seen: Quadratic, term: Term, photos: int) -> bool:
    """Whether chance does not explain it either where any one photo may be bent by itself."""
    return all(
        _stands_among(seen.without(np.kron(own[:, None], np.eye(FIELD))), term)
        for own in np.eye(photos)
    )


def _evidence(scene: Scene, priors: Sequence[Calibration], field: _Field) -> _Evidence:
    """Poses, points and lenses eliminated."""
    bundle = Bundle.of(scene)
    photos, lenses = len(bundle.views), LENS_SIZE * len(priors)
    first = POSE_SIZE * photos
    design = _design(bundle, scene, priors, field)
    clusters = clusters_of(bundle.points)
    parts = [_reduced(*design, part[bundle.point_idx]) for part in clusters]
    curves = np.arange(first + lenses + OWN * photos, len(parts[0][1]))
    inflation = _inflation(parts, np.concatenate([np.arange(first), curves]))
    normal = np.sum([one for one, _ in parts], axis=0) / inflation
    right = np.sum([one for _, one in parts], axis=0) / inflation
    prior = LensPrior.of(priors, hold_board_lenses=False)
    lens = slice(first, first + lenses)
    normal[lens, lens] += np.where(np.outer(prior.free, prior.free), prior.information, 0.0)
    right[lens] += prior.information @ np.where(prior.free, prior.packed - packed(scene), 0.0)
    known = np.ones(first + lenses, bool)
    known[lens] = prior.free
    kept = np.arange(first + lenses, len(right))
    left, pull = eliminated(normal, right, np.flatnonzero(known), kept)
    return _Evidence(photos, left, pull, photos * len(clusters))


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


def _design(
    bundle: Bundle, scene: Scene, priors: Sequence[Calibration], field: _Field
) -> tuple[sp.csr_array, sp.csr_array, Float64[np.ndarray, " r"]]:
    """Weighted rows over poses, lenses, deviations and curvings; over points; and residuals."""
    count, photos = len(bundle.photo_idx), len(bundle.views)
    residuals, by_point = np.empty((count, 2)), np.empty((count, 2, 3))
    by_pose, by_lens = np.empty((count, 2, POSE_SIZE)), np.empty((count, 2, LENS_SIZE))
    _differentiate(
        bundle.views, bundle.points, bundle.photo_idx, bundle.point_idx, bundle.xy_px,
        residuals, by_point, by_pose, by_lens,
    )  # fmt: skip
    sigma_px = bundle.sigma_px(scene)
    off = (residuals**2).sum(axis=1) / (CAUCHY_SIGMAS * sigma_px) ** 2
    weights = 1.0 / (np.sqrt(1.0 + off) * sigma_px)
    camera = np.array(scene.camera_idx, np.int64)[list(scene.placed)][bundle.photo_idx]
    basis = np.array([lens_basis(one.camera) for one in priors])
    own = np.einsum("mrl,mlq->mrq", by_lens, basis[camera])
    curved = np.einsum("mri,mic->mrc", by_point, field.columns[bundle.point_idx])
    photo, first = bundle.photo_idx, POSE_SIZE * photos
    at_own = first + LENS_SIZE * len(priors)
    at_curve = at_own + OWN * photos
    blocks = [
        (by_pose, POSE_SIZE * photo),
        (by_lens, first + LENS_SIZE * camera),
        (own, at_own + OWN * photo),
        (curved, at_curve + FIELD * photo),
    ]
    size = at_curve + FIELD * photos
    unknowns = sum(
        (_rows(block, start, weights, size) for block, start in blocks),
        sp.csr_array((2 * count, size)),
    )
    points = _rows(by_point, 3 * bundle.point_idx, weights, 3 * len(bundle.points))
    return unknowns, points, (weights[:, None] * residuals).ravel()


def _rows(
    block: Float64[np.ndarray, "m 2 k"],
    start: Int64[np.ndarray, " m"],
    weights: Float64[np.ndarray, " m"],
    size: int,
) -> sp.csr_array:
    """Rows of these derivatives, those of each observation from its own column on."""
    count, _, width = block.shape
    columns = np.repeat(start[:, None] + np.arange(width), 2, axis=0).ravel()
    values = (weights[:, None, None] * block).ravel()
    ends = width * np.arange(2 * count + 1)
    return sp.csr_array((values, columns, ends), shape=(2 * count, size))


def _reduced(
    unknowns: sp.csr_array,
    points: sp.csr_array,
    residuals: Float64[np.ndarray, " r"],
    chosen: Bool[np.ndarray, " m"],
) -> tuple[Float64[np.ndarray, "u u"], Float64[np.ndarray, " u"]]:
    """Equations of the observations chosen, their points eliminated."""
    rows = np.flatnonzero(np.repeat(chosen, 2))
    by_unknowns, by_points, pulls = unknowns[rows], points[rows], residuals[rows]
    own = np.flatnonzero(np.diff(by_points.tocsc().indptr) > 0)[::3] // 3
    by_points = by_points[:, (3 * own[:, None] + np.arange(3)).ravel()]
    of_points = (by_points.T @ by_points).tobsr((3, 3))
    weights = of_points.data
    weights = weights + _LEAST_WEIGHT * np.einsum("nii->n", weights)[:, None, None] * np.eye(3)
    inverse = sp.bsr_array(
        (np.linalg.inv(weights), np.arange(len(own)), np.arange(len(own) + 1)),
        shape=of_points.shape,
    )
    cross = by_unknowns.T @ by_points
    solved = cross @ inverse
    normal = (by_unknowns.T @ by_unknowns - solved @ cross.T).toarray()
    return normal, by_unknowns.T @ pulls - solved @ (by_points.T @ pulls)


@njit(cache=True, nogil=True)
def _differentiate(
    views: np.ndarray,
    points: np.ndarray,
    photo_idx: np.ndarray,
    point_idx: np.ndarray,
    xy_px: np.ndarray,
    residuals: np.ndarray,
    by_point: np.ndarray,
    by_pose: np.ndarray,
    by_lens: np.ndarray,
):
    """Fill residuals (measured minus projected) and their pixels' derivatives."""
    xy = np.empty(2)
    for row in range(len(photo_idx)):
        by_point[row], by_pose[row], by_lens[row] = 0.0, 0.0, 0.0
        depth = project_and_differentiate(
            views[photo_idx[row]],
            points[point_idx[row]],
            xy,
            by_point[row],
            by_pose[row],
            by_lens[row],
        )
        residuals[row] = 0.0
        if depth > 0.0:
            residuals[row] = xy_px[row] - xy
