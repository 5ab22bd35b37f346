"""Lens evidence: what photos say of their own lenses, and of their camera's.

In      a scene, each camera's lens as it is calibrated.
Out     a LensEvidence: normal equations in units of sigma over each photo's lens deviation; and
        whether they show a term, such as a photo that was zoomed, or a file of another lens.
Method  Points, poses and cameras' lenses (as calibrated) are eliminated. Neighbouring keypoints
        share errors: clusters of neighbouring points are taken as the independent facts, and the
        variance is scaled by what they show, with the leverage of each cluster taken out (Bell and
        McCaffrey 2002). A term is held against photos whose lenses differ as much as the capture
        shows: deviations are normal, of a spread that is found with the term free.
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
from limbgram.reconstruction.mapping.lens_deviations import (
    DEVIATIONS,
    WIDE,
    Ties,
    basis_of,
    numbers_of,
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
from limbgram.reconstruction.mapping.solution import LensPrior, reduced_equations

OWN = sum(numbers_of(kind) for kind in DEVIATIONS) + 2
"""Numbers of a photo's lens deviation: those of `lens_deviations`, and k1 and k2, which change with
the distance that a lens is focused at."""
MOST = np.array([*(WIDE[kind] for kind in DEVIATIONS for _ in range(numbers_of(kind))), 0.02, 0.04])
_USUAL = {"principal point": 0.0025, "focal length": 0.0005, "rolling shutter": 0.001}
"""Of a phone in the hand (`synthetic.usual`): a stabiliser, focus at half a metre, 20 ms for all
rows."""
USUAL = np.array(
    [*(_USUAL[kind] for kind in DEVIATIONS for _ in range(numbers_of(kind))), 1e-3, 2e-3]
)
"""Of each number; k1 and k2 change by some hundredths of themselves with the focus."""
CLUSTERS = 8
"""Of the points of a body; a power of two. With 32, clusters are so small that half of the errors
that neighbours share cross their borders (see tests)."""
_GAUSSIAN = 0.64
"""Variance of pulls over the equations' own weight where errors are independent and normal: Cauchy
weights lessen pulls more than they lessen the equations."""
_GAUGE = 1e-7


@dataclass(frozen=True)
class LensEvidence:
    """Normal equations in units of sigma over what lenses of single photos have for themselves."""

    photos: tuple[int, ...]
    """Placed ones, in their order."""
    camera: Int64[np.ndarray, " n"]
    """Of each photo."""
    seen: NormalEquations
    """Over 9 numbers a photo, counted from its camera's lens as that is calibrated."""
    facts: int
    """Clusters of points in photos."""

    @classmethod
    def of(cls, scene: Scene, priors: Sequence[Calibration]) -> "LensEvidence":
        photos = scene.placed
        body = SceneEquations.of(scene, photos, priors)
        prior = LensPrior.of(priors, hold_board_lenses=False)
        normal, right = body.normal.copy(), body.right.copy()
        first = POSE_SIZE * len(photos)
        lens = slice(first, first + len(prior.packed))
        prior.join(normal, right, packed(scene), first)
        free = np.ones(len(right), bool)
        free[lens] = prior.free
        own = np.arange(lens.stop, len(right))
        left, pull = eliminated(normal, right, np.flatnonzero(free[: lens.stop]), own)
        pull = pull + deviations_found(scene, photos, left)
        camera = np.array(scene.camera_idx, np.int64)[list(photos)]
        facts = len(photos) * body.clusters
        return cls(photos, camera, NormalEquations(left, pull), facts)

    def common(self, numbers: slice = slice(0, OWN)) -> Float64[np.ndarray, "u k"]:
        """Columns of deviations that all photos of a camera have alike."""
        cameras = (self.camera[:, None] == np.unique(self.camera)).astype(float)
        return np.kron(cameras, np.eye(OWN)[:, numbers])

    def of_photo(self, rank: int, numbers: slice = slice(0, OWN)) -> Float64[np.ndarray, "u k"]:
        """Columns of the deviations of one placed photo."""
        return np.kron(np.eye(len(self.photos))[:, [rank]], np.eye(OWN)[:, numbers])

    def left(self, spread: Float64[np.ndarray, "9"]) -> NormalEquations:
        """What is left of a deviation where others of this spread are expected beside it."""
        normal = self.seen.normal.copy()
        normal[np.diag_indices_from(normal)] += 1.0 / np.tile(spread, len(self.photos)) ** 2
        both = np.column_stack([self.seen.right, self.seen.normal])
        solved = self.seen.normal @ solve_semidefinite(normal, both)
        return NormalEquations(self.seen.normal - solved[:, 1:], self.seen.right - solved[:, 0])


@dataclass(frozen=True)
class LensTerm:
    """One number of a lens that photos show, and the rules that it does not stand."""

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


TIGHT = 0.1
"""Of the usual spread: what single photos stand out of is searched among lenses so alike."""
MOST_ALONE = 0.2
"""Share of the photos that may be an exception one by one; more are a spread, or a sway."""
FOCAL_FLOOR = 0.001
"""Change of a focal length, in parts of itself, from which it matters."""


def zoomed_photos(evidence: LensEvidence) -> dict[int, LensTerm]:
    """Single photos that may have another focal length than the others of their camera.

    Zoomed photos look like lenses that differ much, and hide each other. So they are looked for one
    by one with lenses that hardly differ, and judged with the spread that is found beside all.
    """
    photos = len(evidence.photos)
    columns = [evidence.of_photo(rank, _FOCAL) for rank in range(photos)]
    tight = evidence.left(TIGHT * USUAL).eliminating(evidence.common())
    ranks: list[int] = []
    while len(ranks) < MOST_ALONE * photos:
        left = tight.eliminating(
            np.hstack([np.zeros((len(tight.right), 0)), *(columns[k] for k in ranks)])
        )
        tests = {
            k: ScoreTest.of(left.restricted_to(columns[k])) for k in range(photos) if k not in ranks
        }
        best = max(tests, key=lambda k: tests[k].statistic)
        if f_test_p_value(ScoreTest.of(left), tests[best], photos) > SIGNIFICANCE_LEVEL:
            break
        ranks.append(best)
    return {
        evidence.photos[k]: _zoomed(evidence, k, [one for one in ranks if one != k]) for k in ranks
    }


def _zoomed(evidence: LensEvidence, rank: int, others: Sequence[int]) -> LensTerm:
    """One of them; its rivals are whatever else its lens may have for itself."""
    column = evidence.of_photo(rank, _FOCAL)
    rivals = [evidence.of_photo(rank, kind) for kind in _others(_FOCAL)]
    beside = np.hstack([evidence.common(), *(evidence.of_photo(k, _FOCAL) for k in others)])
    usual = [k for k in range(len(evidence.photos)) if k not in (rank, *others)]
    return _held(evidence, column, beside, rivals, usual, tried=len(evidence.photos))


def other_focal(evidence: LensEvidence, camera: int) -> LensTerm:
    """That all photos of a camera have another focal length than its file.

    What else may be common to them, the middle of the picture and distortion, is free.
    """
    own = np.tile(np.arange(OWN) == _FOCAL.start, len(evidence.photos))
    column = (own & np.repeat(evidence.camera == camera, OWN)).astype(float)[:, None]
    common = evidence.common()
    beside = common[:, (common.T @ column == 0.0)[:, 0]]
    return _held(evidence, column, beside, [], range(len(evidence.photos)), tried=1)


def _held(
    evidence: LensEvidence,
    column: Float64[np.ndarray, "u 1"],
    beside: Float64[np.ndarray, "u k"],
    rivals: Sequence[Float64[np.ndarray, "u r"]],
    single: Sequence[int],
    tried: int,
) -> LensTerm:
    """A term of one number against the rules.

    Args:
        beside: What is free beside it.
        single: Ranks of photos each of which may be left out.
        tried: Candidates of its kind.
    """
    free = evidence.seen.eliminating(np.hstack([beside, column]))
    spread = estimate_spread(free, USUAL, MOST).spread
    left = evidence.left(spread).eliminating(beside)
    every, one = ScoreTest.of(left), ScoreTest.of(left.restricted_to(column))
    after = max(every.dof - one.dof, 1)
    noise = max(1.0, (every.statistic - one.statistic) / after)
    along = left.restricted_to(column)
    weight = float(max(along.normal[0, 0], MIN_WEIGHT))
    value, sigma = float(along.right[0]) / weight, float(np.sqrt(noise / weight))
    failed: list[Rule] = []
    if f_test_p_value(every, one, tried) > SIGNIFICANCE_LEVEL:
        failed.append("chance")
    if any(
        (one.statistic - ScoreTest.of(left.restricted_to(k)).statistic) / noise
        < VERY_STRONG_EVIDENCE
        for k in rivals
    ):
        failed.append("lens")
    if abs(value) - COVER * sigma < FOCAL_FLOOR:
        failed.append("size")
    for rank in single:
        less = left.eliminating(evidence.of_photo(rank))
        if not is_significant(less, column):
            failed.append("one photo")
            break
    wide = evidence.left(np.minimum(SPREAD_MARGIN * spread, MOST)).eliminating(beside)
    if not is_significant(wide, column):
        failed.append("lenses of photos")
    cost = np.log(evidence.facts) + 2.0 * np.log(tried)
    return LensTerm(
        value=value,
        sigma=sigma,
        p_value=f_test_p_value(every, one, tried),
        score=float(one.statistic / noise - cost),
        variance_before=every.variance_factor,
        variance_after=(every.statistic - one.statistic) / after,
        failed=tuple(failed),
    )


def lens_basis(camera: Camera) -> Float64[np.ndarray, "lens 9"]:
    """What one unit of each number of a deviation adds to a lens."""
    bends = np.zeros((LENS_SIZE, 2))
    bends[[PARAMETERS.index("k1"), PARAMETERS.index("k2")], [0, 1]] = 1.0
    return np.hstack([basis_of(DEVIATIONS, camera), bends])


def place_of(kind: str) -> slice:
    """Among the numbers of a photo's deviation."""
    first = 0
    for one in DEVIATIONS:
        if one == kind:
            return slice(first, first + numbers_of(one))
        first += numbers_of(one)
    raise KeyError(kind)


_FOCAL = place_of("focal length")


def _others(kind: slice) -> list[slice]:
    """Where the other kinds of numbers stand."""
    starts = [place_of(one) for one in DEVIATIONS] + [slice(OWN - 2, OWN)]
    return [one for one in starts if one != kind]


def packed(scene: Scene) -> Float64[np.ndarray, " l"]:
    return np.concatenate([one.packed for one in scene.cameras])


def deviations_found(
    scene: Scene, photos: tuple[int, ...], normal: Float64[np.ndarray, "u u"]
) -> Float64[np.ndarray, " u"]:
    """What makes lens deviations count from the camera's lens, where the scene has some already."""
    found = np.zeros((len(photos), OWN))
    if scene.own is not None:
        first = 0
        for kind in scene.own.deviations:
            own = slice(first, first + numbers_of(kind))
            first = own.stop
            found[:, place_of(kind)] = scene.own.values[list(photos), own]
    return normal[:, : found.size] @ found.ravel()


def eliminated(
    normal: Float64[np.ndarray, "u u"],
    right: Float64[np.ndarray, " u"],
    out: Int64[np.ndarray, " o"],
    kept: Int64[np.ndarray, " k"],
) -> tuple[Float64[np.ndarray, "k k"], Float64[np.ndarray, " k"]]:
    """The equations that remain once some unknowns are solved for."""
    solved = solve_semidefinite(
        normal[np.ix_(out, out)], np.column_stack([right[out], normal[np.ix_(out, kept)]])
    )
    cross = normal[np.ix_(kept, out)]
    return normal[np.ix_(kept, kept)] - cross @ solved[:, 1:], right[kept] - cross @ solved[:, 0]


@dataclass(frozen=True)
class SceneEquations:
    """Equations of one body over poses of the common photos, of others, lenses and deviations,
    points eliminated, in units of sigma as its clusters show it."""

    normal: Float64[np.ndarray, "b b"]
    right: Float64[np.ndarray, " b"]
    others: int
    """Photos that this body alone places."""
    clusters: int
    inflation: float

    @classmethod
    def of(
        cls, scene: Scene, photos: tuple[int, ...], priors: Sequence[Calibration]
    ) -> "SceneEquations":
        bundle = Bundle.of(scene)
        if scene.own is not None:
            cameras = [one.camera for one in priors]
            bundle = replace(bundle, ties=Ties.of(scene, cameras, solve=False))
        sigma_px = bundle.sigma_px(scene)
        lens_idx = np.array(scene.camera_idx, np.int64)[list(scene.placed)]
        basis = np.array([lens_basis(one.camera) for one in priors])
        common = [scene.placed.index(k) for k in photos]
        others = [k for k in range(len(bundle.views)) if k not in set(common)]
        poses = [POSE_SIZE * k + j for k in (*common, *others) for j in range(POSE_SIZE)]
        lenses = POSE_SIZE * len(bundle.views) + np.arange(LENS_SIZE * len(priors))
        after = POSE_SIZE * len(bundle.views) + LENS_SIZE * len(priors)
        own = [after + OWN * k + j for k in common for j in range(OWN)]
        rows = np.array([*poses, *lenses.tolist(), *own])
        parts = [
            _equations(bundle.with_points(part), lens_idx, basis, sigma_px)
            for part in clusters_of(bundle.points)
        ]
        firm = np.arange(POSE_SIZE * len(bundle.views))
        inflation = inflation_of(
            [normal[np.ix_(firm, firm)] for normal, _ in parts], [g[firm] for _, g in parts]
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
    """Of poses, lenses and deviations, points eliminated, in units of sigma."""
    normal, right, _ = reduced_equations(bundle, lens_idx, basis, sigma_px, RELATIVE_DAMPING)
    return normal / sigma_px**2, right / sigma_px**2


def clusters_of(points: Points3) -> list[np.ndarray]:
    """Neighbouring points together: halved at the median of the longest side, again and again."""
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


def inflation_of(
    normals: Sequence[Float64[np.ndarray, "p p"]], rights: Sequence[Float64[np.ndarray, " p"]]
) -> float:
    """Variance of the clusters' pulls over what independent observations would have; 1 at least.

    A cluster's pull is lessened by its own share in the solution. Pulls are those of one lens for
    all photos: what lenses do that no deviation describes counts as noise. With deviations solved
    for, a pot in the hand of a real phone seemed to bend.
    """
    normal = np.sum(normals, axis=0)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), MIN_WEIGHT))
    values, vectors = np.linalg.eigh(normal * np.outer(scale, scale))
    known = values > _GAUGE * values[-1]
    white = scale[:, None] * vectors[:, known] / np.sqrt(values[known])
    shown, meant = 0.0, float(known.sum())
    for one, pull in zip(normals, rights, strict=True):
        share = white.T @ one @ white
        meant -= float((share**2).sum())
        shown += float(((white.T @ pull) ** 2).sum())
    return max(1.0, shown / (_GAUSSIAN * meant)) if meant > 0.0 else 1.0
