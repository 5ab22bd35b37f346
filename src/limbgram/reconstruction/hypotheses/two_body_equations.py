"""Two-body equations: joint normal equations of lenses and relative motion of two bodies.

In      two scenes of the same photos, each placed by the points of one body alone, lenses held,
        and the calibrations.
Out     TwoBodyEquations: normal equations in units of sigma over each photo's lens deviation, over
        the deviation that the second body alone sees, and over the second body's motion.
Method  Each scene's reduced equations (points eliminated) hold over poses, lenses and per-photo
        lens deviations. A photo has one pose: the second body's equations are transformed to the
        first one's pose and the motion between both. Poses (flat prior) and lenses (calibration as
        prior) are then eliminated once; every hypothesis is a choice of columns of what remains.
        The equations are linearised where every photo shows the second body elsewhere, so that no
        hypothesis is judged by residuals that the outlier rejection of another one removed.
        The second body may see another lens than the first: no lens model is exact, and the two lie
        elsewhere in the photos.
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
from limbgram.reconstruction.mapping.body_motion import MOTION_SIZE, points_in_three_photos
from limbgram.reconstruction.mapping.bundle_adjustment import LensPrior
from limbgram.reconstruction.mapping.lens_equations import (
    DEVIATION_SIZE,
    SceneEquations,
    eliminate,
    known_deviations_rhs,
    packed_lenses,
)
from limbgram.reconstruction.mapping.scene import Deviation, Scene

MIN_FIRM_POINTS = 30
"""Points shared with two other photos from which a photo that lies elsewhere is believed. Of 100
captures that kept still two had one that lay 2 and 7 mm elsewhere, with 8 and 24 such points."""


@dataclass(frozen=True)
class TwoBodyEquations:
    """Normal equations in units of sigma over lens deviations and motions of each photo."""

    photos: tuple[int, ...]
    """Placed by both bodies, in their order."""
    normal: Float64[np.ndarray, "u u"]
    """Over lens deviations (9 a photo), then those that the second body alone sees (9), then its
    motion (6: rotation, shift; world frame and unit of the first body)."""
    right: Float64[np.ndarray, " u"]
    camera_from_world: Float64[np.ndarray, "n 3 3"]
    """Rotation of each photo."""
    centre: Vector3
    """Of the first body, in its scene's world; rotations are about it."""
    radius: float
    """Of the first body: the distance from its centre that two thirds of its points stay within."""
    distance: float
    """Median distance of the cameras from the centre."""
    well_observed: Bool[np.ndarray, " n"]
    """Photos that many points of both bodies hold: a wrong match does not move them."""
    sample_size: int
    """Number of independent observations: clusters of points times photos."""
    board_calibrated: bool
    """Whether a board calibrated the lenses of all photos."""
    deviations: tuple[Deviation, ...]
    """Kinds that the adjustment freed for single photos, modelled to first order for points that
    are as far away as the rest."""
    inflation: tuple[float, float]
    """By body: variance between clusters over that of independent observations."""

    @property
    def has_known_lenses(self) -> bool:
        """Whether boards calibrated all lenses, and no photo has a lens deviation of its own."""
        return self.board_calibrated and not self.deviations

    @property
    def lens(self) -> slice:
        """Rows of the lens deviations that both bodies see."""
        return slice(0, DEVIATION_SIZE * len(self.photos))

    @property
    def second_lens(self) -> slice:
        """Rows of the lens deviations that the second body alone sees."""
        return slice(DEVIATION_SIZE * len(self.photos), 2 * DEVIATION_SIZE * len(self.photos))

    @property
    def motion(self) -> slice:
        """Rows of the second body's motions."""
        return slice(2 * DEVIATION_SIZE * len(self.photos), len(self.right))


def two_body_equations(
    first: Scene, second: Scene, photos: tuple[int, ...], priors: Sequence[Calibration]
) -> TwoBodyEquations:
    """The joint equations of both scenes over these photos.

    Args:
        second: In any frame and at any scale.
    """
    centre = np.median(first.points_in_world, axis=0)
    first = first.moved(Similarity(1.0, np.eye(3), -centre))
    centres = first.centres_in_world(photos)
    second = second.moved(fit_similarity(second.centres_in_world(photos), centres))
    prior = LensPrior.of(priors, hold_board_lenses=False)
    bodies = [SceneEquations.of(scene, photos, priors) for scene in (first, second)]
    offsets, motion_jacobians = _relative_poses(first, second, photos)
    layout = _Layout(len(photos), bodies[0].others, bodies[1].others, len(priors))
    normal, right = layout.zeros()
    for body, maps in zip(bodies, layout.maps(offsets, motion_jacobians), strict=True):
        at = body.right - body.normal @ maps.offset
        normal += maps.matrix.T @ (body.normal @ maps.matrix)
        right += maps.matrix.T @ at
    prior.add_to(normal, right, packed_lenses(first), layout.lenses.start)
    prior.add_to(normal, right, prior.packed, layout.second_lenses.start)  # zero-mean prior
    poses = slice(0, POSE_SIZE * len(photos))
    normal[poses, poses] += _gauge_prior(first, photos, motion_jacobians, np.diag(normal)[poses])
    free = np.ones(len(right), bool)
    free[layout.lenses] = free[layout.second_lenses] = prior.free
    kept = np.arange(layout.deviations.start, len(right))
    eliminated_rows = np.flatnonzero(free[: layout.deviations.start])
    reduced, reduced_right = eliminate(normal, right, eliminated_rows, kept)
    reduced_right += known_deviations_rhs(first, photos, reduced)
    off = np.linalg.norm(first.points_in_world, axis=1)
    return TwoBodyEquations(
        photos=photos,
        normal=reduced,
        right=reduced_right,
        camera_from_world=motion_jacobians[:, :3, :3],
        centre=centre,
        radius=float(np.quantile(off, 2 / 3)),
        distance=float(np.median(np.linalg.norm(centres, axis=1))),
        well_observed=np.minimum(points_in_three_photos(first), points_in_three_photos(second))[
            list(photos)
        ]
        >= MIN_FIRM_POINTS,
        sample_size=len(photos) * min(body.clusters for body in bodies),
        board_calibrated=all(one.source == "board" for one in priors),
        deviations=() if first.own is None else first.own.deviations,
        inflation=(bodies[0].inflation, bodies[1].inflation),
    )


def _gauge_prior(
    first: Scene,
    photos: tuple[int, ...],
    motion_jacobians: Float64[np.ndarray, "n 6 6"],
    weights: Float64[np.ndarray, " p"],
) -> Float64[np.ndarray, "p p"]:
    """Prior that fixes the first body's frame and scale, which its observations leave free.

    Both scenes were solved apart: with a free gauge, a common change of scale would cost nothing,
    change the offset between both bodies, and so explain any motion.
    """
    scale = np.zeros((len(photos), POSE_SIZE, 1))
    for row, k in enumerate(photos):
        scale[row, 3:, 0] = first.view(k).camera_from_world.translation
    frame = np.concatenate([motion_jacobians, scale], axis=2).reshape(-1, MOTION_SIZE + 1)
    held = weights[:, None] * frame
    return held @ np.linalg.inv(frame.T @ held) @ held.T


@dataclass(frozen=True)
class _AffineMap:
    """One body's unknowns as a function of the joint ones: matrix @ joint + offset."""

    matrix: Float64[np.ndarray, "b u"]
    offset: Float64[np.ndarray, " b"]


@dataclass(frozen=True)
class _Layout:
    """Order of the joint unknowns: poses of the common photos, poses of photos that one body alone
    places, cameras' lenses, second lenses, lens deviations, second deviations, motions."""

    photos: int
    first_others: int
    second_others: int
    cameras: int

    @property
    def lenses(self) -> slice:
        first = POSE_SIZE * (self.photos + self.first_others + self.second_others)
        return slice(first, first + LENS_SIZE * self.cameras)

    @property
    def second_lenses(self) -> slice:
        """Cameras' lenses as the second body alone sees them, less the common ones."""
        return slice(self.lenses.stop, self.lenses.stop + LENS_SIZE * self.cameras)

    @property
    def deviations(self) -> slice:
        return slice(
            self.second_lenses.stop, self.second_lenses.stop + DEVIATION_SIZE * self.photos
        )

    def zeros(self) -> tuple[Float64[np.ndarray, "u u"], Float64[np.ndarray, " u"]]:
        size = self.deviations.stop + (DEVIATION_SIZE + MOTION_SIZE) * self.photos
        return np.zeros((size, size)), np.zeros(size)

    def maps(
        self, offsets: Float64[np.ndarray, "n 6"], motion_jacobians: Float64[np.ndarray, "n 6 6"]
    ) -> tuple[_AffineMap, _AffineMap]:
        """The maps to the unknowns of the first and of the second body."""
        size = self.deviations.stop + (DEVIATION_SIZE + MOTION_SIZE) * self.photos
        common, lenses = POSE_SIZE * self.photos, LENS_SIZE * self.cameras
        found: list[_AffineMap] = []
        others_at = common
        for body, others in enumerate((self.first_others, self.second_others)):
            poses = POSE_SIZE * (self.photos + others)
            rows = poses + lenses + DEVIATION_SIZE * self.photos
            matrix, offset = np.zeros((rows, size)), np.zeros(rows)
            matrix[:common, :common] = np.eye(common)
            more = slice(others_at, others_at + POSE_SIZE * others)
            others_at = more.stop
            matrix[common:poses, more] = np.eye(POSE_SIZE * others)
            matrix[poses : poses + lenses, self.lenses] = np.eye(lenses)
            matrix[poses + lenses :, self.deviations] = np.eye(DEVIATION_SIZE * self.photos)
            if body == 1:
                matrix[poses : poses + lenses, self.second_lenses] = np.eye(lenses)
                alone = slice(
                    self.deviations.stop, self.deviations.stop + DEVIATION_SIZE * self.photos
                )
                matrix[poses + lenses :, alone] = np.eye(DEVIATION_SIZE * self.photos)
                for k in range(self.photos):
                    pose = slice(POSE_SIZE * k, POSE_SIZE * (k + 1))
                    motion = slice(alone.stop + MOTION_SIZE * k, alone.stop + MOTION_SIZE * (k + 1))
                    matrix[pose, motion] = motion_jacobians[k]
                offset[:common] = -offsets.ravel()
            found.append(_AffineMap(matrix, offset))
        return found[0], found[1]


def _relative_poses(
    first: Scene, second: Scene, photos: tuple[int, ...]
) -> tuple[Float64[np.ndarray, "n 6"], Float64[np.ndarray, "n 6 6"]]:
    """Pose of each photo by the second body relative to that by the first, and its Jacobian.

    The pose is a rotation and a shift in the camera frame; its Jacobian is by a motion of the
    second body.
    """
    offsets, jacobians = (
        np.zeros((len(photos), MOTION_SIZE)),
        np.zeros((len(photos), MOTION_SIZE, MOTION_SIZE)),
    )
    for row, k in enumerate(photos):
        one, other = (scene.view(k).camera_from_world for scene in (first, second))
        offsets[row, :3] = Rotation.from_matrix(other.rotation @ one.rotation.T).as_rotvec()
        offsets[row, 3:] = other.translation - one.translation
        jacobians[row, :3, :3] = jacobians[row, 3:, 3:] = one.rotation
    return offsets, jacobians
