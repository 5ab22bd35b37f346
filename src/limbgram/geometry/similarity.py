"""Similarities: rigid motion and scale, and their least-squares fit (Umeyama 1991)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.geometry.arrays import Matrix3, Points3, Vector3
from limbgram.geometry.rigid import Rigid


@dataclass(frozen=True)
class Similarity:
    """x_in_b = scale * rotation @ x_in_a + translation."""

    scale: float
    rotation: Matrix3
    translation: Vector3

    @property
    def inverse(self) -> "Similarity":
        scale = 1.0 / self.scale
        return Similarity(
            scale, self.rotation.T.copy(), -scale * (self.rotation.T @ self.translation)
        )

    def apply(self, points_in_a: Points3) -> Points3:
        return self.scale * points_in_a @ self.rotation.T + self.translation

    def move_camera(self, camera_from_a: Rigid) -> Rigid:
        """camera_from_b, where the camera's own frame takes the scale of b."""
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
    from_a, from_b = points_in_a - mean_a, points_in_b - mean_b
    u, singular, vt = np.linalg.svd((from_b * share[:, None]).T @ from_a)
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    rotation = (u * signs) @ vt
    scale = float((singular * signs).sum() / (share @ (from_a**2).sum(1))) if with_scale else 1.0
    return Similarity(scale, rotation, mean_b - scale * rotation @ mean_a)
