"""Rigid motions and similarities, their least-squares fit, and angles.

A motion is named b_from_a and takes coordinates in frame a to coordinates in frame b. The fit of a
similarity to corresponding points is Umeyama's (1991).
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from jaxtyping import Float64
from scipy.spatial.transform import Rotation

from limbgram.core.geometry.arrays import AnyPoints3, Matrix3, Points3, Vector3

_ROWS_AT_ONCE = 20_000
"""A larger matrix product wakes BLAS threads, which then spin for longer than the product takes."""


@dataclass(frozen=True)
class Rigid:
    """Rigid motion b_from_a: x_in_b = rotation @ x_in_a + translation."""

    rotation: Matrix3
    translation: Vector3

    @classmethod
    def identity(cls) -> Self:
        return cls(np.eye(3), np.zeros(3))

    @classmethod
    def from_rotation_vector(cls, rotation_vector: Vector3, translation: Vector3) -> Self:
        return cls(
            Rotation.from_rotvec(rotation_vector).as_matrix(), np.asarray(translation, float)
        )

    @classmethod
    def looking_at(cls, centre: Vector3, target: Vector3, up: Vector3) -> Self:
        """camera_from_world of a camera at `centre`: x right, y down, z towards `target`."""
        forward = (target - centre) / np.linalg.norm(target - centre)
        right = np.cross(forward, up)
        right /= np.linalg.norm(right)
        rotation = np.stack([right, np.cross(forward, right), forward])
        return cls(rotation, -rotation @ centre)

    @property
    def rotation_vector(self) -> Vector3:
        """Axis times angle, radians."""
        return Rotation.from_matrix(self.rotation).as_rotvec()

    @property
    def centre(self) -> Vector3:
        """Origin of frame b in coordinates of a: for camera_from_world, the camera centre."""
        return -self.rotation.T @ self.translation

    @property
    def inverse(self) -> "Rigid":
        return Rigid(self.rotation.T.copy(), self.centre)

    @property
    def matrix_3x4(self) -> Float64[np.ndarray, "3 4"]:
        return np.column_stack([self.rotation, self.translation])

    def __matmul__(self, other: "Rigid") -> "Rigid":
        """c_from_b @ b_from_a = c_from_a."""
        return Rigid(
            self.rotation @ other.rotation, self.rotation @ other.translation + self.translation
        )

    def apply(self, points_in_a: AnyPoints3) -> AnyPoints3:
        return rotated(points_in_a, self.rotation) + self.translation


def rotated(vectors: AnyPoints3, rotation: Matrix3) -> AnyPoints3:
    """Vectors after a rotation, computed in pieces of `_ROWS_AT_ONCE`."""
    if len(vectors) <= _ROWS_AT_ONCE:
        return vectors @ rotation.T
    pieces = np.array_split(vectors, -(-len(vectors) // _ROWS_AT_ONCE))
    return np.concatenate([piece @ rotation.T for piece in pieces])


def towards(azimuth_rad: np.ndarray | float, elevation_rad: np.ndarray | float) -> np.ndarray:
    """Unit vectors to an azimuth about z, from x, and an elevation above the plane of x and y."""
    level = np.cos(elevation_rad)
    return np.stack(
        [level * np.cos(azimuth_rad), level * np.sin(azimuth_rad), np.sin(elevation_rad)], axis=-1
    )


def cross_matrix(vector: Vector3) -> Matrix3:
    """The matrix [v]_x with [v]_x u = v x u."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def axis_across(direction: Vector3) -> Vector3:
    """The coordinate axis most nearly square to a direction."""
    return np.eye(3)[int(np.abs(direction).argmin())]


def axes_across(normal: Vector3) -> Float64[np.ndarray, "2 3"]:
    """Two axes of the plane across a unit normal, right-handed with it."""
    first = np.cross(normal, axis_across(normal))
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])


def rotation_to_axes(z: Vector3, towards: Vector3) -> Matrix3:
    """Rotation whose third row is the unit vector `z`, its first as near to `towards` as it can."""
    x = towards - (towards @ z) * z
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z])


def plane_basis(normal: Vector3) -> Float64[np.ndarray, "2 3"]:
    """Orthonormal basis of the plane across a normal of any length."""
    return np.linalg.svd(normal[None])[2][1:]


def angle_between_deg(first: Matrix3, second: Matrix3) -> float:
    """Angle of the rotation that takes one orientation to the other."""
    return float(np.degrees(Rotation.from_matrix(first.T @ second).magnitude()))


def turn_rad(one: np.ndarray | float, other: np.ndarray | float) -> np.ndarray:
    """Signed difference `one` - `other` of two angles, wrapped to -pi to pi."""
    return np.angle(np.exp(1j * (np.asarray(one) - np.asarray(other))))


SIMILARITY_SIZE = 7
"""Degrees of freedom of a similarity: rotation, translation, scale. In these seven a scene is
undetermined by photos alone (its gauge)."""


@dataclass(frozen=True)
class Similarity:
    """Similarity b_from_a: x_in_b = scale * rotation @ x_in_a + translation."""

    scale: float
    rotation: Matrix3
    translation: Vector3

    @property
    def inverse(self) -> "Similarity":
        scale = 1.0 / self.scale
        return Similarity(
            scale, self.rotation.T.copy(), -scale * (self.rotation.T @ self.translation)
        )

    def apply(self, points_in_a: AnyPoints3) -> AnyPoints3:
        return self.scale * points_in_a @ self.rotation.T + self.translation

    def move_camera(self, camera_from_a: Rigid) -> Rigid:
        """camera_from_b of this b_from_a; the camera's own frame takes the scale of b."""
        rotation = camera_from_a.rotation @ self.rotation.T
        return Rigid(rotation, self.scale * camera_from_a.translation - rotation @ self.translation)


def fit_similarity(
    points_in_a: Points3,
    points_in_b: Points3,
    *,
    with_scale: bool = True,
    weights: Float64[np.ndarray, " n"] | None = None,
) -> Similarity:
    """b_from_a of corresponding points, weighted least squares (Umeyama 1991, eq. 40-43)."""
    share = np.full(len(points_in_a), 1.0) if weights is None else weights
    share = share / share.sum()
    mean_a, mean_b = share @ points_in_a, share @ points_in_b
    centred_a, centred_b = points_in_a - mean_a, points_in_b - mean_b
    u, singular, vt = np.linalg.svd((centred_b * share[:, None]).T @ centred_a)
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    rotation = (u * signs) @ vt
    scale = 1.0
    if with_scale:
        scale = float((singular * signs).sum() / (share @ (centred_a**2).sum(1)))
    return Similarity(scale, rotation, mean_b - scale * rotation @ mean_a)
