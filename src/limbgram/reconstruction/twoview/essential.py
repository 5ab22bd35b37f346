"""The essential matrix, the relative pose, and pairs that show only a plane or a rotation.

x2^T E x1 = 0 between ideal normalized coordinates; E = [t]_x R of second_from_first = (R, t),
with t of unit length. E has four such poses; the right one has the points in front of both
cameras (cheirality test: Hartley and Zisserman, section 9.6.3).

Pairs whose matches one homography or one rotation explains agree with a whole family of
fundamental matrices, so F says nothing about them; a rotation does not even have a baseline, so no
depth can come from it.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float64
from scipy.spatial.transform import Rotation

from limbgram.core.geometry.arrays import Matrix3, Points2, Points3
from limbgram.core.geometry.frames import Rigid, cross_matrix, plane_basis
from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.twoview.fundamental import SELECTIONS, agreeing, ransac
from limbgram.reconstruction.twoview.pairs import TURNS, fit_sampson

_FEWEST_MATCHES = 6


@dataclass(frozen=True)
class RelativePose:
    """second_from_first with unit baseline, and which matches lie in front of both cameras."""

    second_from_first: Rigid
    in_front: Bool[np.ndarray, " n"]


@dataclass(frozen=True)
class RobustEssential:
    """A pose by RANSAC, and its inliers; None where none was found."""

    second_from_first: Rigid | None
    inliers: Bool[np.ndarray, " n"]


def essential_from_fundamental(
    fundamental: Matrix3, first_matrix: Matrix3, second_matrix: Matrix3
) -> Matrix3:
    """E = K2^T F K1, moved to the nearest matrix with two equal singular values."""
    u, _, vt = np.linalg.svd(second_matrix.T @ fundamental @ first_matrix)
    return (u * [1.0, 1.0, 0.0]) @ vt


def fundamental_from_pose(
    second_from_first: Rigid, first_matrix: Matrix3, second_matrix: Matrix3
) -> Matrix3:
    """F = K2^-T [t]_x R K1^-1, of unit norm."""
    essential = cross_matrix(second_from_first.translation) @ second_from_first.rotation
    fundamental = np.linalg.inv(second_matrix).T @ essential @ np.linalg.inv(first_matrix)
    return fundamental / np.linalg.norm(fundamental)


def pose_from_essential(
    essential: Matrix3, ideal_first: Points2, ideal_second: Points2
) -> RelativePose:
    """Of E's four poses the one with most matches in front of both cameras."""
    u, _, vt = np.linalg.svd(essential)
    u, vt = u * np.sign(np.linalg.det(u)), vt * np.sign(np.linalg.det(vt))
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    poses = [
        Rigid(u @ turn @ vt, sign * u[:, 2])
        for turn in (quarter, quarter.T)
        for sign in (1.0, -1.0)
    ]
    front = [in_front(pose, ideal_first, ideal_second) for pose in poses]
    best = int(np.argmax([mask.sum() for mask in front]))
    return RelativePose(poses[best], front[best])


def in_front(
    second_from_first: Rigid, ideal_first: Points2, ideal_second: Points2
) -> Bool[np.ndarray, " n"]:
    """Cheirality: whether rays meet in front of both cameras, by the signs of their depths."""
    ones = np.ones((len(ideal_first), 1))
    first = np.hstack([ideal_first, ones]) @ second_from_first.rotation.T
    second = np.hstack([ideal_second, ones])
    # depth2 second = depth1 first + t: least squares of both depths by Cramer's rule
    t = second_from_first.translation
    aa, bb = (first * first).sum(1), (second * second).sum(1)
    ab, at, bt = (first * second).sum(1), first @ t, second @ t
    determinant = aa * bb - ab * ab
    return ((ab * bt - bb * at) > 0) & ((aa * bt - ab * at) > 0) & (determinant > 0)


def estimate_essential(
    xy_first: Points2,
    xy_second: Points2,
    first_matrix: Matrix3,
    second_matrix: Matrix3,
    *,
    threshold_px: float = 1.5,
    seed: int = 0,
) -> RobustEssential:
    """The pose by RANSAC with five matches (Nister 2004), refined on its inliers.

    Pixels are freed of lens distortion. Works on planes, where F is not determined.
    """
    none = RobustEssential(None, np.zeros(len(xy_first), bool))
    if len(xy_first) < _FEWEST_MATCHES:
        return none
    straight = np.zeros(5)
    found, _ = cv2.findEssentialMat(
        xy_first,
        xy_second,
        first_matrix,
        second_matrix,
        straight,
        straight,
        ransac(threshold_px, seed),
    )
    essential = np.asarray(found, float)
    if essential.shape != (3, 3) or not np.isfinite(essential).all():
        return none
    matrices = np.linalg.inv(second_matrix), np.linalg.inv(first_matrix)
    fundamental = matrices[0].T @ essential @ matrices[1]
    inliers = agreeing(fundamental, xy_first, xy_second, threshold_px)
    if inliers.sum() < _FEWEST_MATCHES:
        return none
    pose = pose_from_essential(
        essential,
        to_normalized(first_matrix, xy_first[inliers]),
        to_normalized(second_matrix, xy_second[inliers]),
    ).second_from_first
    for _ in range(SELECTIONS):
        pose = refine_pose(pose, xy_first[inliers], xy_second[inliers], first_matrix, second_matrix)
        before = inliers
        fundamental = fundamental_from_pose(pose, first_matrix, second_matrix)
        inliers = agreeing(fundamental, xy_first, xy_second, threshold_px)
        if inliers.sum() < _FEWEST_MATCHES:
            return none
        if np.array_equal(before, inliers):
            break
    return RobustEssential(pose, inliers)


def refine_pose(
    second_from_first: Rigid,
    xy_first: Points2,
    xy_second: Points2,
    first_matrix: Matrix3,
    second_matrix: Matrix3,
) -> Rigid:
    """The pose of the least sum of squared Sampson distances in pixels, from a start nearby."""
    start = _EssentialModel(second_from_first, first_matrix, second_matrix)
    return fit_sampson(start, xy_first, xy_second).pose


def undistorted(camera: Camera, xy_px: Points2) -> Points2:
    """Pixels freed of lens distortion: K times normalized coordinates."""
    return camera.normalize(xy_px) @ camera.matrix[:2, :2].T + camera.matrix[:2, 2]


def to_normalized(matrix: Matrix3, xy_px: Points2) -> Points2:
    """Normalized coordinates of pixels that are free of lens distortion."""
    return (np.hstack([xy_px, np.ones((len(xy_px), 1))]) @ np.linalg.inv(matrix).T)[:, :2]


@dataclass(frozen=True)
class _EssentialModel:
    """Relative pose of calibrated cameras: five parameters, rotation and baseline direction."""

    pose: Rigid
    first_matrix: Matrix3
    second_matrix: Matrix3

    @property
    def matrix(self) -> Matrix3:
        return fundamental_from_pose(self.pose, self.first_matrix, self.second_matrix)

    @property
    def by_step(self) -> Float64[np.ndarray, "5 3 3"]:
        baseline = np.tensordot(self.pose.translation, TURNS, 1)
        orthogonal = np.tensordot(self._orthogonal, TURNS, 1)
        essential = (
            np.concatenate([baseline[None], baseline @ TURNS, orthogonal]) @ self.pose.rotation
        )
        inverse = np.linalg.inv(self.first_matrix)
        fundamental = np.linalg.inv(self.second_matrix).T @ essential @ inverse
        return fundamental[1:] / np.linalg.norm(fundamental[0])

    @property
    def _orthogonal(self) -> Float64[np.ndarray, "2 3"]:
        """Directions orthogonal to the baseline."""
        return plane_basis(self.pose.translation)

    def moved(self, step: Float64[np.ndarray, "5"]) -> "_EssentialModel":
        rotation = Rotation.from_rotvec(step[:3]).as_matrix() @ self.pose.rotation
        translation = self.pose.translation + step[3:] @ self._orthogonal
        pose = Rigid(rotation, translation / np.linalg.norm(translation))
        return _EssentialModel(pose, self.first_matrix, self.second_matrix)


_ROUNDS = 5


@dataclass(frozen=True)
class RobustHomography:
    """x2 ~ H x1 in pixels freed of lens distortion, and the part of the matches it explains."""

    matrix: Matrix3
    share: float


def estimate_homography(
    xy_first: Points2, xy_second: Points2, *, threshold_px: float, seed: int = 0
) -> RobustHomography:
    """The homography with most inliers within `threshold_px`, by RANSAC; needs 4 matches."""
    found, _ = cv2.findHomography(xy_first, xy_second, ransac(threshold_px, seed))
    homography = np.asarray(found, float)
    if homography.shape != (3, 3):
        return RobustHomography(np.eye(3), 0.0)
    image = np.hstack([xy_first, np.ones((len(xy_first), 1))]) @ homography.T
    distance = np.linalg.norm(image[:, :2] / image[:, 2:] - xy_second, axis=1)
    return RobustHomography(homography, float(np.mean(distance < threshold_px)))


def poses_from_homography(
    homography: Matrix3, first_matrix: Matrix3, second_matrix: Matrix3
) -> tuple[Rigid, ...]:
    """The decompositions of a homography into second_from_first, with unit baselines.

    Two of them usually have the points in front of both cameras (Malis and Vargas 2007).
    """
    ideal = np.linalg.inv(second_matrix) @ homography @ first_matrix
    _, rotations, translations, _ = cv2.decomposeHomographyMat(ideal, np.eye(3))
    lengths = [float(np.linalg.norm(translation)) for translation in translations]
    return tuple(
        Rigid(np.asarray(rotation, float), np.asarray(translation, float).ravel() / length)
        for rotation, translation, length in zip(rotations, translations, lengths)
        if length > 0
    )


def rotation_share(
    ideal_first: Points2,
    ideal_second: Points2,
    second_matrix: Matrix3,
    *,
    threshold_px: float,
) -> float:
    """Share of the matches that a pure rotation of the camera explains to `threshold_px`.

    The rotation is fitted to the rays and, a few times over, to the better half of them.
    """
    first, second = _rays(ideal_first), _rays(ideal_second)
    weights = np.ones(len(first))
    distance = np.zeros(len(first))
    for _ in range(_ROUNDS):
        u, _, vt = np.linalg.svd((second * weights[:, None]).T @ first)
        rotation = (u * [1.0, 1.0, np.linalg.det(u) * np.linalg.det(vt)]) @ vt
        seen = first @ rotation.T @ second_matrix.T
        wanted = second @ second_matrix.T
        distance = np.linalg.norm(seen[:, :2] / seen[:, 2:] - wanted[:, :2] / wanted[:, 2:], axis=1)
        weights = (distance <= np.median(distance)).astype(float)
    return float(np.mean(distance < threshold_px))


def _rays(ideal: Points2) -> Points3:
    """Unit rays of normalized coordinates."""
    rays = np.hstack([ideal, np.ones((len(ideal), 1))])
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)
