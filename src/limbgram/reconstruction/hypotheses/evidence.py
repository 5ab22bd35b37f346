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
        The second body may see another lens than the first: no model of a lens is exact, and both
        lie elsewhere in the photos.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64
from scipy.spatial.transform import Rotation

from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import Similarity, fit_similarity
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.mapping.lens_evidence import (
    OWN,
    SceneEquations,
    deviations_found,
    eliminated,
    packed,
)
from limbgram.reconstruction.mapping.movement import tied_points
from limbgram.reconstruction.mapping.scene import Deviation, Scene
from limbgram.reconstruction.mapping.solution import LensPrior

MOVE = 6
"""Numbers of a rigid motion: a turn about the first body's middle, and a shift."""
FIRMLY = 30
"""Points shared with two others from which a photo that lies elsewhere is believed. Of 100 captures
that kept still two had one that lay 2 and 7 mm elsewhere by the surroundings, held by 8 and 24."""


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
    firm: Bool[np.ndarray, " n"]
    """Photos that many points of both bodies hold: a wrong match does not move them."""
    facts: int
    """Clusters of points in photos: as many facts are counted as independent."""
    by_boards: bool
    """Whether a board calibrated the lenses of all photos."""
    deviations: tuple[Deviation, ...]
    """In which single photos have lenses of their own: these are known to first order, for what
    lies as far away as the rest."""
    inflation: tuple[float, float]
    """By body: variance that clusters show over that of independent observations."""

    @property
    def calibrated(self) -> bool:
        """Whether all lenses are known, and single photos have none of their own."""
        return self.by_boards and not self.deviations

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
    bodies = [SceneEquations.of(scene, photos, priors) for scene in (first, second)]
    apart, moves = _apart(first, second, photos)
    layout = _Layout(len(photos), bodies[0].others, bodies[1].others, len(priors))
    normal, right = layout.empty()
    for body, maps in zip(bodies, layout.maps(apart, moves), strict=True):
        at = body.right - body.normal @ maps.offset
        normal += maps.columns.T @ (body.normal @ maps.columns)
        right += maps.columns.T @ at
    prior.join(normal, right, packed(first), layout.lens.start)
    prior.join(normal, right, prior.packed, layout.lens_apart.start)  # drawn to nought
    poses = slice(0, POSE_SIZE * len(photos))
    normal[poses, poses] += _held_frame(first, photos, moves, np.diag(normal)[poses])
    free = np.ones(len(right), bool)
    free[layout.lens] = free[layout.lens_apart] = prior.free
    kept = np.arange(layout.own.start, len(right))
    before = np.flatnonzero(free[: layout.own.start])
    reduced, pulled = eliminated(normal, right, before, kept)
    pulled += deviations_found(first, photos, reduced)
    off = np.linalg.norm(first.points_in_world, axis=1)
    return Evidence(
        photos=photos,
        normal=reduced,
        right=pulled,
        camera_from_world=moves[:, :3, :3],
        middle=middle,
        radius=float(np.quantile(off, 2 / 3)),
        distance=float(np.median(np.linalg.norm(there, axis=1))),
        firm=np.minimum(tied_points(first), tied_points(second))[list(photos)] >= FIRMLY,
        facts=len(photos) * min(body.clusters for body in bodies),
        by_boards=all(one.source == "board" for one in priors),
        deviations=() if first.own is None else first.own.deviations,
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
