"""Evidence: what two bodies in the same photos say of lenses and of motion, in one linearisation.

In      two scenes of the same photos, each placed by the points of one body alone, lenses held,
        and the calibrations.
Out     an Evidence: normal equations in units of sigma over each photo's lens deviation, over what
        a photo's lens does to the second body alone, and over the second body's motion.
Method  Each scene's own equations (points eliminated) hold over poses, lenses and per-photo lens
        deviations. A photo has one pose: the second body's equations are moved to the first one's
        pose and to the motion between both. Poses (flat) and lenses (as calibrated) are then
        eliminated once; every hypothesis is a choice of columns of what is left. The rows are those
        of the model in which every photo shows the second body elsewhere, so that no hypothesis is
        judged by residuals that another one had cut off.
        Neighbouring keypoints share errors. Clusters of neighbouring points are taken as the
        independent facts, and the variance is scaled by what they show, with the leverage of each
        cluster taken out (Bell and McCaffrey 2002).
        The second body may see another lens than the first: no model of a lens is exact, and both
        lie elsewhere in the photos.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64, Int64
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial.transform import Rotation

from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.frames import Similarity, fit_similarity
from limbgram.core.geometry.lens import LENS_SIZE, PARAMETERS, POSE_SIZE, Camera
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.mapping.bundle import Bundle
from limbgram.reconstruction.mapping.own import DEVIATIONS, Ties, basis_of, numbers_of
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.mapping.solution import LensPrior, reduced_equations

OWN = sum(numbers_of(kind) for kind in DEVIATIONS) + 2
"""Numbers of a photo's lens deviation: those of `mapping.own`, and k1 and k2, which change with
the distance that a lens is focused at."""
MOVE = 6
"""Numbers of a rigid motion: a turn about the first body's middle, and a shift."""
CLUSTERS = 8
"""Of the points of a body; a power of two. With 32, clusters are so small that half of the errors
that neighbours share cross their borders (see tests)."""
_GAUSSIAN = 0.64
"""Variance of pulls over the equations' own weight where errors are independent and normal: Cauchy
weights lessen pulls more than they lessen the equations."""
_ALMOST_NONE = 1e-9
"""Of each unknown's own weight: what keeps equations solvable whose world frame is free."""
_GAUGE = 1e-7
_FLAT = 1e-30


@dataclass(frozen=True)
class Evidence:
    """Normal equations in units of sigma of what a hypothesis may give to each photo."""

    photos: tuple[int, ...]
    """Shown by both bodies, in their order."""
    normal: Float64[np.ndarray, "u u"]
    """Over lens deviations (9 a photo), then those that the second body alone sees (9), then its
    motion (6: turn, shift; world frame and unit of the first body)."""
    right: Float64[np.ndarray, " u"]
    camera_from_world: Float64[np.ndarray, "n 3 3"]
    """Rotation of each photo."""
    middle: Vector3
    """Of the first body, in its scene's world; motions turn about it."""
    radius: float
    """Of the first body about it: the distance that two thirds of its points do not exceed."""
    distance: float
    """Of the cameras from it, in the median."""
    facts: int
    """Clusters of points in photos: as many facts are counted as independent."""
    calibrated: bool
    """Whether a board calibrated the lenses of all photos."""
    inflation: tuple[float, float]
    """By body: variance that clusters show over that of independent observations."""

    @property
    def own(self) -> slice:
        return slice(0, OWN * len(self.photos))

    @property
    def seen_by_second(self) -> slice:
        return slice(OWN * len(self.photos), 2 * OWN * len(self.photos))

    @property
    def motion(self) -> slice:
        return slice(2 * OWN * len(self.photos), len(self.right))


def evidence_of(
    first: Scene, second: Scene, photos: tuple[int, ...], priors: Sequence[Calibration]
) -> Evidence:
    """What both scenes say of these photos.

    Args:
        second: In any frame and size.
    """
    middle = np.median(first.points_in_world, axis=0)
    first = first.moved(Similarity(1.0, np.eye(3), -middle))
    there = np.array([first.view(k).centre_in_world for k in photos])
    here = np.array([second.view(k).centre_in_world for k in photos])
    second = second.moved(fit_similarity(here, there))
    prior = LensPrior.of(priors, hold_board_lenses=False)
    bodies = [_Body.of(scene, photos, priors) for scene in (first, second)]
    apart, moves = _apart(first, second, photos)
    layout = _Layout(len(photos), bodies[0].others, bodies[1].others, len(priors))
    normal, right = layout.empty()
    for body, maps in zip(bodies, layout.maps(apart, moves), strict=True):
        at = body.right - body.normal @ maps.offset
        normal += maps.columns.T @ (body.normal @ maps.columns)
        right += maps.columns.T @ at
    for place, offset in ((layout.lens, prior.packed - _packed(first)), (layout.lens_apart, 0.0)):
        information = np.where(np.outer(prior.free, prior.free), prior.information, 0.0)
        normal[place, place] += information
        right[place] += information @ (offset * np.ones(len(information)))
    poses = slice(0, POSE_SIZE * len(photos))
    normal[poses, poses] += _held_frame(first, photos, moves, np.diag(normal)[poses])
    free = np.ones(len(right), bool)
    free[layout.lens] = free[layout.lens_apart] = prior.free
    kept = np.arange(layout.own.start, len(right))
    before = np.flatnonzero(free[: layout.own.start])
    reduced, pulled = _eliminated(normal, right, before, kept)
    pulled += _deviations_found(first, photos, reduced)
    off = np.linalg.norm(first.points_in_world, axis=1)
    return Evidence(
        photos=photos,
        normal=reduced,
        right=pulled,
        camera_from_world=moves[:, :3, :3],
        middle=middle,
        radius=float(np.quantile(off, 2 / 3)),
        distance=float(np.median(np.linalg.norm(there, axis=1))),
        facts=len(photos) * min(body.clusters for body in bodies),
        calibrated=all(one.source == "board" for one in priors),
        inflation=(bodies[0].inflation, bodies[1].inflation),
    )


def _held_frame(
    first: Scene,
    photos: tuple[int, ...],
    moves: Float64[np.ndarray, "n 6 6"],
    weights: Float64[np.ndarray, " p"],
) -> Float64[np.ndarray, "p p"]:
    """What holds the first body's frame and size, which its observations leave free.

    Both bodies' scenes were solved apart: free, a growth of both by as much as nothing would
    part them by what already lies between them, and explain any motion.
    """
    growth = np.zeros((len(photos), POSE_SIZE, 1))
    for row, k in enumerate(photos):
        growth[row, 3:, 0] = first.view(k).camera_from_world.translation
    frame = np.concatenate([moves, growth], axis=2).reshape(-1, MOVE + 1)
    held = weights[:, None] * frame
    return held @ np.linalg.inv(frame.T @ held) @ held.T


def _packed(scene: Scene) -> Float64[np.ndarray, " l"]:
    return np.concatenate([one.packed for one in scene.cameras])


def _deviations_found(
    scene: Scene, photos: tuple[int, ...], normal: Float64[np.ndarray, "u u"]
) -> Float64[np.ndarray, " u"]:
    """What makes lens deviations count from the camera's lens, where the scene has some already."""
    found = np.zeros((len(photos), OWN))
    if scene.own is not None:
        first = 0
        for kind in scene.own.deviations:
            own = slice(first, first + numbers_of(kind))
            first = own.stop
            found[:, _place_of(kind)] = scene.own.values[list(photos), own]
    return normal[:, : found.size] @ found.ravel()


def lens_basis(camera: Camera) -> Float64[np.ndarray, "10 9"]:
    """What one unit of each number of a deviation adds to a lens."""
    bends = np.zeros((LENS_SIZE, 2))
    bends[[PARAMETERS.index("k1"), PARAMETERS.index("k2")], [0, 1]] = 1.0
    return np.hstack([basis_of(DEVIATIONS, camera), bends])


def _place_of(kind: str) -> slice:
    """Among the numbers of a photo's deviation."""
    first = 0
    for one in DEVIATIONS:
        if one == kind:
            return slice(first, first + numbers_of(one))
        first += numbers_of(one)
    raise KeyError(kind)


def _eliminated(
    normal: Float64[np.ndarray, "u u"],
    right: Float64[np.ndarray, " u"],
    out: Int64[np.ndarray, " o"],
    kept: Int64[np.ndarray, " k"],
) -> tuple[Float64[np.ndarray, "k k"], Float64[np.ndarray, " k"]]:
    """The equations that remain once some unknowns are solved for."""
    solved = solved_for(
        normal[np.ix_(out, out)], np.column_stack([right[out], normal[np.ix_(out, kept)]])
    )
    cross = normal[np.ix_(kept, out)]
    return normal[np.ix_(kept, kept)] - cross @ solved[:, 1:], right[kept] - cross @ solved[:, 0]


def solved_for(
    normal: Float64[np.ndarray, "u u"], right: Float64[np.ndarray, "u k"]
) -> Float64[np.ndarray, "u k"]:
    """Solutions of equations some directions of which carry nothing."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), _FLAT))
    scaled = normal * np.outer(scale, scale)
    scaled[np.diag_indices_from(scaled)] += _ALMOST_NONE
    return scale[:, None] * cho_solve(cho_factor(scaled), scale[:, None] * right)


@dataclass(frozen=True)
class _Maps:
    """A body's own unknowns by those of both: columns @ unknowns + offset."""

    columns: Float64[np.ndarray, "b u"]
    offset: Float64[np.ndarray, " b"]


@dataclass(frozen=True)
class _Layout:
    """Where the unknowns of both bodies stand: poses, poses of photos that one body alone places,
    cameras' lenses, what the second body sees of these alone, then those that hypotheses use."""

    photos: int
    first_others: int
    second_others: int
    cameras: int

    @property
    def lens(self) -> slice:
        first = POSE_SIZE * (self.photos + self.first_others + self.second_others)
        return slice(first, first + LENS_SIZE * self.cameras)

    @property
    def lens_apart(self) -> slice:
        return slice(self.lens.stop, self.lens.stop + LENS_SIZE * self.cameras)

    @property
    def own(self) -> slice:
        return slice(self.lens_apart.stop, self.lens_apart.stop + OWN * self.photos)

    def empty(self) -> tuple[Float64[np.ndarray, "u u"], Float64[np.ndarray, " u"]]:
        size = self.own.stop + (OWN + MOVE) * self.photos
        return np.zeros((size, size)), np.zeros(size)

    def maps(
        self, apart: Float64[np.ndarray, "n 6"], moves: Float64[np.ndarray, "n 6 6"]
    ) -> tuple[_Maps, _Maps]:
        """Of the first and of the second body."""
        size = self.own.stop + (OWN + MOVE) * self.photos
        common, lenses = POSE_SIZE * self.photos, LENS_SIZE * self.cameras
        found: list[_Maps] = []
        others_at = common
        for body, others in enumerate((self.first_others, self.second_others)):
            poses = POSE_SIZE * (self.photos + others)
            rows = poses + lenses + OWN * self.photos
            columns, offset = np.zeros((rows, size)), np.zeros(rows)
            columns[:common, :common] = np.eye(common)
            more = slice(others_at, others_at + POSE_SIZE * others)
            others_at = more.stop
            columns[common:poses, more] = np.eye(POSE_SIZE * others)
            columns[poses : poses + lenses, self.lens] = np.eye(lenses)
            columns[poses + lenses :, self.own] = np.eye(OWN * self.photos)
            if body == 1:
                columns[poses : poses + lenses, self.lens_apart] = np.eye(lenses)
                alone = slice(self.own.stop, self.own.stop + OWN * self.photos)
                columns[poses + lenses :, alone] = np.eye(OWN * self.photos)
                for k in range(self.photos):
                    pose = slice(POSE_SIZE * k, POSE_SIZE * (k + 1))
                    motion = slice(alone.stop + MOVE * k, alone.stop + MOVE * (k + 1))
                    columns[pose, motion] = moves[k]
                offset[:common] = -apart.ravel()
            found.append(_Maps(columns, offset))
        return found[0], found[1]


def _apart(
    first: Scene, second: Scene, photos: tuple[int, ...]
) -> tuple[Float64[np.ndarray, "n 6"], Float64[np.ndarray, "n 6 6"]]:
    """Turn and shift of each photo between both bodies, in its frame; and by a motion there."""
    apart, moves = np.zeros((len(photos), MOVE)), np.zeros((len(photos), MOVE, MOVE))
    for row, k in enumerate(photos):
        one, other = (scene.view(k).camera_from_world for scene in (first, second))
        apart[row, :3] = Rotation.from_matrix(other.rotation @ one.rotation.T).as_rotvec()
        apart[row, 3:] = other.translation - one.translation
        moves[row, :3, :3] = moves[row, 3:, 3:] = one.rotation
    return apart, moves


@dataclass(frozen=True)
class _Body:
    """Equations of one body over poses of the common photos, of others, lenses and deviations."""

    normal: Float64[np.ndarray, "b b"]
    right: Float64[np.ndarray, " b"]
    others: int
    """Photos that this body alone places."""
    clusters: int
    inflation: float

    @classmethod
    def of(cls, scene: Scene, photos: tuple[int, ...], priors: Sequence[Calibration]) -> "_Body":
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
            for part in _clusters(bundle.points)
        ]
        firm = np.arange(POSE_SIZE * len(bundle.views))
        inflation = _inflation(
            [normal[np.ix_(firm, firm)] for normal, _ in parts], [g[firm] for _, g in parts]
        )
        normal = np.sum([one for one, _ in parts], axis=0) / inflation
        right = np.sum([one for _, one in parts], axis=0) / inflation
        return cls(normal[np.ix_(rows, rows)], right[rows], len(others), len(parts), inflation)


def _equations(
    bundle: Bundle,
    lens_idx: Int64[np.ndarray, " p"],
    basis: Float64[np.ndarray, "c 10 9"],
    sigma_px: float,
) -> tuple[Float64[np.ndarray, "u u"], Float64[np.ndarray, " u"]]:
    """Of poses, lenses and deviations, points eliminated, in units of sigma."""
    normal, right, _ = reduced_equations(bundle, lens_idx, basis, sigma_px, _ALMOST_NONE)
    return normal / sigma_px**2, right / sigma_px**2


def _clusters(points: Points3) -> list[np.ndarray]:
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


def _inflation(
    normals: Sequence[Float64[np.ndarray, "p p"]], rights: Sequence[Float64[np.ndarray, " p"]]
) -> float:
    """Variance of the clusters' pulls over what independent observations would have; 1 at least.

    A cluster's pull is lessened by its own share in the solution. Pulls are those of one lens for
    all photos: what lenses do that no deviation describes counts as noise. With deviations solved
    for, a pot in the hand of a real phone seemed to bend.
    """
    normal = np.sum(normals, axis=0)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), _FLAT))
    values, vectors = np.linalg.eigh(normal * np.outer(scale, scale))
    known = values > _GAUGE * values[-1]
    white = scale[:, None] * vectors[:, known] / np.sqrt(values[known])
    shown, meant = 0.0, float(known.sum())
    for one, pull in zip(normals, rights, strict=True):
        share = white.T @ one @ white
        meant -= float((share**2).sum())
        shown += float(((white.T @ pull) ** 2).sum())
    return max(1.0, shown / (_GAUSSIAN * meant)) if meant > 0.0 else 1.0
