"""Lens equations: what the observations say of each photo's lens deviation.

In      a scene, each camera's lens as it is calibrated.
Out     LensEquations: normal equations in units of sigma over each photo's lens deviation; and
        tests for terms such as a photo that was zoomed, or a camera file of another lens.
Method  Points, poses and cameras' lenses (calibration as prior) are eliminated. Neighbouring
        keypoints share errors: clusters of neighbouring points are taken as the independent
        observations, and the variance is scaled by that between clusters, corrected for the
        leverage of each (Bell and McCaffrey 2002). A term is tested beside lens deviations of the
        spread that the capture shows: zero-mean Gaussians, the spread estimated with the term free.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import LENS_SIZE, PARAMETERS, POSE_SIZE, Camera
from limbgram.core.interval import COVER
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.mapping.bundle import Bundle
from limbgram.reconstruction.mapping.bundle_adjustment import LensPrior, reduced_equations
from limbgram.reconstruction.mapping.lens_deviations import (
    DEVIATIONS,
    PRIOR_SPREAD,
    PhotoLenses,
    basis_of,
    parameter_count,
)
from limbgram.reconstruction.mapping.scene import Rule, Scene
from limbgram.reconstruction.mapping.score_tests import (
    MIN_WEIGHT,
    RELATIVE_DAMPING,
    SIGNIFICANCE_LEVEL,
    SPREAD_MARGIN,
    VERY_STRONG_EVIDENCE,
    NormalEquations,
    ScoreTest,
    estimate_spread,
    f_test_p_value,
    is_significant,
    solve_semidefinite,
)

DEVIATION_SIZE = sum(parameter_count(kind) for kind in DEVIATIONS) + 2
"""Parameters of a photo's lens deviation: those of `lens_deviations`, and k1 and k2, which change
with the distance that a lens is focused at."""
MAX_SPREAD = np.array(
    [*(PRIOR_SPREAD[kind] for kind in DEVIATIONS for _ in range(parameter_count(kind))), 0.02, 0.04]
)
"""Largest standard deviation of each parameter from photo to photo that is believed."""
_USUAL_SPREAD = {"principal point": 0.0025, "focal length": 0.0005, "rolling shutter": 0.001}
"""Of a phone in the hand (`synthetic.usual`): a stabiliser, focus at half a metre, 20 ms for all
rows."""
USUAL_SPREAD = np.array(
    [
        *(_USUAL_SPREAD[kind] for kind in DEVIATIONS for _ in range(parameter_count(kind))),
        1e-3,
        2e-3,
    ]
)
"""Of each parameter; k1 and k2 change by some hundredths of themselves with the focus."""
CLUSTERS = 8
"""Number of clusters of the points of a body; a power of two. With 32, clusters are so small that
half of the errors that neighbours share cross their borders (see tests)."""
_CAUCHY_VARIANCE_RATIO = 0.64
"""Variance of the score over the information where errors are independent and Gaussian: Cauchy
weights lessen the one more than the other."""
_GAUGE = 1e-7
"""Share of the largest eigenvalue below which a direction counts as gauge freedom."""


@dataclass(frozen=True)
class LensEquations:
    """Normal equations in units of sigma over the lens deviations of all placed photos."""

    photos: tuple[int, ...]
    """The placed photos, in their order."""
    camera: Int64[np.ndarray, " n"]
    """Index of each photo's camera."""
    of_deviations: NormalEquations
    """Over 9 parameters a photo, relative to its camera's lens as that is calibrated."""
    sample_size: int
    """Number of independent observations: clusters of points times photos."""

    @classmethod
    def of(cls, scene: Scene, priors: Sequence[Calibration]) -> "LensEquations":
        """The equations of a scene about its adjusted state."""
        photos = scene.placed
        body = SceneEquations.of(scene, photos, priors)
        prior = LensPrior.of(priors, hold_board_lenses=False)
        normal, right = body.normal.copy(), body.right.copy()
        first = POSE_SIZE * len(photos)
        lens = slice(first, first + len(prior.packed))
        prior.add_to(normal, right, packed_lenses(scene), first)
        free = np.ones(len(right), bool)
        free[lens] = prior.free
        own = np.arange(lens.stop, len(right))
        reduced, reduced_right = eliminate(normal, right, np.flatnonzero(free[: lens.stop]), own)
        reduced_right = reduced_right + known_deviations_rhs(scene, photos, reduced)
        camera = np.array(scene.camera_idx, np.int64)[list(photos)]
        sample_size = len(photos) * body.clusters
        return cls(photos, camera, NormalEquations(reduced, reduced_right), sample_size)

    def columns_of_cameras(self) -> Float64[np.ndarray, "u k"]:
        """Design columns of deviations that are the same in all photos of a camera."""
        cameras = (self.camera[:, None] == np.unique(self.camera)).astype(float)
        return np.kron(cameras, np.eye(DEVIATION_SIZE))

    def columns_of_photo(
        self, rank: int, numbers: slice = slice(0, DEVIATION_SIZE)
    ) -> Float64[np.ndarray, "u k"]:
        """Design columns of the deviations of one placed photo."""
        return np.kron(np.eye(len(self.photos))[:, [rank]], np.eye(DEVIATION_SIZE)[:, numbers])

    def beside_random(self, spread: Float64[np.ndarray, "9"]) -> NormalEquations:
        """Equations over fixed deviations beside random ones of this spread, marginalised."""
        normal = self.of_deviations.normal.copy()
        normal[np.diag_indices_from(normal)] += 1.0 / np.tile(spread, len(self.photos)) ** 2
        both = np.column_stack([self.of_deviations.right, self.of_deviations.normal])
        solved = self.of_deviations.normal @ solve_semidefinite(normal, both)
        return NormalEquations(
            self.of_deviations.normal - solved[:, 1:], self.of_deviations.right - solved[:, 0]
        )


@dataclass(frozen=True)
class LensTerm:
    """One parameter of a lens that differs, and the rules that the term fails."""

    value: float
    sigma: float
    p_value: float
    score: float
    variance_before: float
    variance_after: float
    failed: tuple[Rule, ...]

    @property
    def low(self) -> float:
        return max(abs(self.value) - COVER * self.sigma, 0.0)

    @property
    def high(self) -> float:
        return abs(self.value) + COVER * self.sigma


TIGHT_SPREAD = 0.1
"""Fraction of the usual spread that the other lenses are given when outliers are searched."""
MAX_OUTLIER_SHARE = 0.2
"""Largest share of single photos that may differ; more are a spread, or a sway."""
FOCAL_FLOOR = 0.001
"""Smallest relative change of a focal length that matters."""


def zoomed_photos(equations: LensEquations) -> dict[int, LensTerm]:
    """Single photos that may have another focal length than the others of their camera.

    Zoomed photos look like lenses that differ much, and hide each other. So they are looked for one
    by one with lenses that hardly differ, and judged with the spread that is found beside all.
    """
    photos = len(equations.photos)
    columns = [equations.columns_of_photo(rank, _FOCAL) for rank in range(photos)]
    tight = equations.beside_random(TIGHT_SPREAD * USUAL_SPREAD).eliminating(
        equations.columns_of_cameras()
    )
    ranks: list[int] = []
    while len(ranks) < MAX_OUTLIER_SHARE * photos:
        remaining = tight.eliminating(
            np.hstack([np.zeros((len(tight.right), 0)), *(columns[k] for k in ranks)])
        )
        tests = {
            k: ScoreTest.of(remaining.restricted_to(columns[k]))
            for k in range(photos)
            if k not in ranks
        }
        best = max(tests, key=lambda k: tests[k].statistic)
        if f_test_p_value(ScoreTest.of(remaining), tests[best], photos) > SIGNIFICANCE_LEVEL:
            break
        ranks.append(best)
    return {
        equations.photos[k]: _zoomed(equations, k, [one for one in ranks if one != k])
        for k in ranks
    }


def _zoomed(equations: LensEquations, rank: int, others: Sequence[int]) -> LensTerm:
    """The term of one zoomed photo; its rivals are the other deviations of its lens."""
    column = equations.columns_of_photo(rank, _FOCAL)
    rivals = [equations.columns_of_photo(rank, kind) for kind in _others(_FOCAL)]
    beside = np.hstack(
        [equations.columns_of_cameras(), *(equations.columns_of_photo(k, _FOCAL) for k in others)]
    )
    usual = [k for k in range(len(equations.photos)) if k not in (rank, *others)]
    return _lens_term(equations, column, beside, rivals, usual, candidates=len(equations.photos))


def other_focal(equations: LensEquations, camera: int) -> LensTerm:
    """The term that all photos of a camera have another focal length than its file.

    What else they may have in common, principal point and distortion, is free.
    """
    own = np.tile(np.arange(DEVIATION_SIZE) == _FOCAL.start, len(equations.photos))
    column = (own & np.repeat(equations.camera == camera, DEVIATION_SIZE)).astype(float)[:, None]
    common = equations.columns_of_cameras()
    beside = common[:, (common.T @ column == 0.0)[:, 0]]
    return _lens_term(equations, column, beside, [], range(len(equations.photos)), candidates=1)


def _lens_term(
    equations: LensEquations,
    column: Float64[np.ndarray, "u 1"],
    beside: Float64[np.ndarray, "u k"],
    rivals: Sequence[Float64[np.ndarray, "u r"]],
    single: Sequence[int],
    candidates: int,
) -> LensTerm:
    """A term of one parameter, with the rules that it fails.

    Args:
        beside: Columns that are free beside it.
        single: Ranks of the photos that are left out one at a time.
        candidates: How many terms of its kind were tried.
    """
    free = equations.of_deviations.eliminating(np.hstack([beside, column]))
    spread = estimate_spread(free, USUAL_SPREAD, MAX_SPREAD).spread
    remaining = equations.beside_random(spread).eliminating(beside)
    every, one = ScoreTest.of(remaining), ScoreTest.of(remaining.restricted_to(column))
    noise_dof = max(every.dof - one.dof, 1)
    noise = max(1.0, (every.statistic - one.statistic) / noise_dof)
    of_term = remaining.restricted_to(column)
    weight = float(max(of_term.normal[0, 0], MIN_WEIGHT))
    value, sigma = float(of_term.right[0]) / weight, float(np.sqrt(noise / weight))
    failed: list[Rule] = []
    if f_test_p_value(every, one, candidates) > SIGNIFICANCE_LEVEL:
        failed.append("chance")
    by_rivals = [ScoreTest.of(remaining.restricted_to(rival)).statistic for rival in rivals]
    if any((one.statistic - rival) / noise < VERY_STRONG_EVIDENCE for rival in by_rivals):
        failed.append("lens")
    if abs(value) - COVER * sigma < FOCAL_FLOOR:
        failed.append("size")
    for rank in single:
        without = remaining.eliminating(equations.columns_of_photo(rank))
        if not is_significant(without, column):
            failed.append("one photo")
            break
    wider = equations.beside_random(np.minimum(SPREAD_MARGIN * spread, MAX_SPREAD)).eliminating(
        beside
    )
    if not is_significant(wider, column):
        failed.append("lenses of photos")
    cost = np.log(equations.sample_size) + 2.0 * np.log(candidates)
    return LensTerm(
        value=value,
        sigma=sigma,
        p_value=f_test_p_value(every, one, candidates),
        score=float(one.statistic / noise - cost),
        variance_before=every.variance_factor,
        variance_after=(every.statistic - one.statistic) / noise_dof,
        failed=tuple(failed),
    )


def lens_basis(camera: Camera) -> Float64[np.ndarray, "lens 9"]:
    """Change of the lens parameters by one unit of each parameter of a deviation."""
    bends = np.zeros((LENS_SIZE, 2))
    bends[[PARAMETERS.index("k1"), PARAMETERS.index("k2")], [0, 1]] = 1.0
    return np.hstack([basis_of(DEVIATIONS, camera), bends])


def deviation_slice(kind: str) -> slice:
    """Where a kind stands among the parameters of a photo's deviation."""
    first = 0
    for one in DEVIATIONS:
        if one == kind:
            return slice(first, first + parameter_count(one))
        first += parameter_count(one)
    raise KeyError(kind)


_FOCAL = deviation_slice("focal length")


def _others(kind: slice) -> list[slice]:
    """Slices of the other kinds."""
    starts = [deviation_slice(one) for one in DEVIATIONS] + [
        slice(DEVIATION_SIZE - 2, DEVIATION_SIZE)
    ]
    return [one for one in starts if one != kind]


def packed_lenses(scene: Scene) -> Float64[np.ndarray, " l"]:
    """Parameters of all cameras\' lenses in one vector."""
    return np.concatenate([one.packed for one in scene.cameras])


def known_deviations_rhs(
    scene: Scene, photos: tuple[int, ...], normal: Float64[np.ndarray, "u u"]
) -> Float64[np.ndarray, " u"]:
    """What moves the linearisation point from the photos' lenses to their cameras' lenses."""
    found = np.zeros((len(photos), DEVIATION_SIZE))
    if scene.own is not None:
        first = 0
        for kind in scene.own.deviations:
            own = slice(first, first + parameter_count(kind))
            first = own.stop
            found[:, deviation_slice(kind)] = scene.own.values[list(photos), own]
    return normal[:, : found.size] @ found.ravel()


def eliminate(
    normal: Float64[np.ndarray, "u u"],
    right: Float64[np.ndarray, " u"],
    out: Int64[np.ndarray, " o"],
    kept: Int64[np.ndarray, " k"],
) -> tuple[Float64[np.ndarray, "k k"], Float64[np.ndarray, " k"]]:
    """The equations that remain once some unknowns are solved for (Schur complement).

    Args:
        out: Rows of those unknowns.
        kept: Rows of the others.
    """
    solved = solve_semidefinite(
        normal[np.ix_(out, out)], np.column_stack([right[out], normal[np.ix_(out, kept)]])
    )
    cross = normal[np.ix_(kept, out)]
    return normal[np.ix_(kept, kept)] - cross @ solved[:, 1:], right[kept] - cross @ solved[:, 0]


@dataclass(frozen=True)
class SceneEquations:
    """Reduced equations of one body, in units of sigma as its clusters of points show it.

    Over poses of the common photos, poses of others, cameras' lenses and lens deviations.
    """

    normal: Float64[np.ndarray, "b b"]
    right: Float64[np.ndarray, " b"]
    others: int
    """Number of photos that this body alone places."""
    clusters: int
    inflation: float

    @classmethod
    def of(
        cls, scene: Scene, photos: tuple[int, ...], priors: Sequence[Calibration]
    ) -> "SceneEquations":
        bundle = Bundle.of(scene)
        if scene.own is not None:
            cameras = [one.camera for one in priors]
            bundle = replace(bundle, photo_lenses=PhotoLenses.of(scene, cameras, solve=False))
        sigma_px = bundle.sigma_px(scene)
        lens_idx = np.array(scene.camera_idx, np.int64)[list(scene.placed)]
        basis = np.array([lens_basis(one.camera) for one in priors])
        common = [scene.placed.index(k) for k in photos]
        others = [k for k in range(len(bundle.views)) if k not in set(common)]
        poses = [POSE_SIZE * k + j for k in (*common, *others) for j in range(POSE_SIZE)]
        lenses = POSE_SIZE * len(bundle.views) + np.arange(LENS_SIZE * len(priors))
        after = POSE_SIZE * len(bundle.views) + LENS_SIZE * len(priors)
        own = [after + DEVIATION_SIZE * k + j for k in common for j in range(DEVIATION_SIZE)]
        rows = np.array([*poses, *lenses.tolist(), *own])
        parts = [
            _equations(bundle.with_points(part), lens_idx, basis, sigma_px)
            for part in point_clusters(bundle.points)
        ]
        poses_of_all = np.arange(POSE_SIZE * len(bundle.views))
        inflation = variance_inflation(
            [normal[np.ix_(poses_of_all, poses_of_all)] for normal, _ in parts],
            [g[poses_of_all] for _, g in parts],
        )
        normal = np.sum([one for one, _ in parts], axis=0) / inflation
        right = np.sum([one for _, one in parts], axis=0) / inflation
        return cls(normal[np.ix_(rows, rows)], right[rows], len(others), len(parts), inflation)


def _equations(
    bundle: Bundle,
    lens_idx: Int64[np.ndarray, " p"],
    basis: Float64[np.ndarray, "c lens 9"],
    sigma_px: float,
) -> tuple[Float64[np.ndarray, "u u"], Float64[np.ndarray, " u"]]:
    """Equations over poses, lenses and deviations, points eliminated, in units of sigma."""
    normal, right, _ = reduced_equations(bundle, lens_idx, basis, sigma_px, RELATIVE_DAMPING)
    return normal / sigma_px**2, right / sigma_px**2


def point_clusters(points: Points3) -> list[np.ndarray]:
    """Masks of neighbouring points: halved again and again at the median of the longest side."""
    parts = [np.arange(len(points))]
    while len(parts) < CLUSTERS:
        if min(len(part) for part in parts) < 2:
            break
        halved: list[np.ndarray] = []
        for part in parts:
            longest = int(np.argmax(np.ptp(points[part], axis=0)))
            order = part[np.argsort(points[part, longest], kind="stable")]
            halved += [order[: len(order) // 2], order[len(order) // 2 :]]
        parts = halved
    masks = np.zeros((len(parts), len(points)), bool)
    for mask, part in zip(masks, parts, strict=True):
        mask[part] = True
    return list(masks)


def variance_inflation(
    normals: Sequence[Float64[np.ndarray, "p p"]], rights: Sequence[Float64[np.ndarray, " p"]]
) -> float:
    """Variance of the clusters' scores over that of independent observations; 1 at least.

    A cluster's score is lessened by its own leverage. Scores are those of one lens for all photos:
    what lenses do that no deviation describes counts as noise. With deviations solved for, a pot
    in the hand of a real phone seemed to bend.
    """
    normal = np.sum(normals, axis=0)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), MIN_WEIGHT))
    values, vectors = np.linalg.eigh(normal * np.outer(scale, scale))
    known = values > _GAUGE * values[-1]
    white = scale[:, None] * vectors[:, known] / np.sqrt(values[known])
    observed, expected = 0.0, float(known.sum())
    for one, score in zip(normals, rights, strict=True):
        share = white.T @ one @ white
        expected -= float((share**2).sum())
        observed += float(((white.T @ score) ** 2).sum())
    return max(1.0, observed / (_CAUCHY_VARIANCE_RATIO * expected)) if expected > 0.0 else 1.0
