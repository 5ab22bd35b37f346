"""A body: a known shape, such as a board's corners, as unknowns of the bundle adjustment.

Unknowns: turn (3), shift (3) and growth (1) of the whole, then three a corner, because prints are
no perfect grids: how far it sits from its place, expected to be nought give or take `shape_sigma`.
Like points, all are eliminated from the equations of photos and lenses (Schur complement), and
follow from their step afterwards.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64, Int64
from scipy.spatial.transform import Rotation

from limbgram.core.geometry.arrays import Points2, Points3
from limbgram.core.geometry.frames import SIMILARITY_SIZE, Rigid, Similarity
from limbgram.core.geometry.lens import (
    LENS_SIZE,
    POSE_SIZE,
    differentiate_all,
    lens_derivatives,
)
from limbgram.core.optimisation import ArrowheadEquations
from limbgram.reconstruction.mapping.bundle import CAUCHY_SIGMAS, Bundle
from limbgram.reconstruction.mapping.bundle_equations import robust_cost


@dataclass(frozen=True, kw_only=True)
class Body:
    """Corner corner_idx[k] appears in placed photo photo_idx[k] at xy_px[k]; sorted by corner."""

    shape: Points3
    """The corners in the body's own frame, as made."""
    world_from_body: Similarity
    offsets: Points3
    """From their places in the world, in its unit."""
    shape_sigma: float
    """Standard deviation of one coordinate of an offset, in the world's unit."""
    photo_idx: Int64[np.ndarray, " m"]
    corner_idx: Int64[np.ndarray, " m"]
    xy_px: Float64[np.ndarray, "m 2"]
    sigma_px: float
    """Standard deviation of a measured coordinate."""

    @property
    def corners(self) -> Points3:
        """In the world."""
        return self.world_from_body.apply(self.shape) + self.offsets

    def cost(self, bundle: Bundle, inflation: float) -> float:
        """Robust sum of squares, pixels in units of `inflation` sigmas, and of the offsets."""
        bounds = np.searchsorted(self.corner_idx, np.arange(len(self.shape) + 1)).astype(np.int64)
        limit_px = CAUCHY_SIGMAS * self.sigma_px
        measured = robust_cost(
            bundle.views, self.photo_idx, bounds, self.xy_px, self.corners, limit_px
        )
        offsets = float((self.offsets**2).sum()) / self.shape_sigma**2
        return measured / (inflation * self.sigma_px) ** 2 + offsets

    def equations(self, bundle: Bundle, inflation: float) -> "BodyEquations":
        """What the body says about photos and lenses, and how it follows them."""
        corners, count = self.corners, len(self.shape)
        by_rest = np.zeros((len(self.xy_px), 2, bundle.unknowns + SIMILARITY_SIZE))
        by_corner, residual = np.zeros((len(self.xy_px), 2, 3)), np.zeros_like(self.xy_px)
        for k in np.unique(self.photo_idx):
            rows = np.flatnonzero(self.photo_idx == k)
            points = np.ascontiguousarray(corners[self.corner_idx[rows]])
            by_point, by_pose = np.zeros((len(rows), 2, 3)), np.zeros((len(rows), 2, POSE_SIZE))
            by_lens = np.zeros((len(rows), 2, LENS_SIZE))
            differentiate_all(bundle.views[k], points, by_point, by_pose, by_lens)
            lens = POSE_SIZE * len(bundle.views) + LENS_SIZE * bundle.lens_idx[k]
            by_rest[rows, :, POSE_SIZE * k : POSE_SIZE * (k + 1)] = by_pose
            by_rest[rows, :, lens : lens + LENS_SIZE] = by_lens
            by_corner[rows] = by_point
            residual[rows] = self.xy_px[rows] - _projected(bundle.views[k], points)
        by_rest[:, :, -SIMILARITY_SIZE:] = by_corner @ self._by_whole()[self.corner_idx]

        spread = (residual**2).sum(1) / (CAUCHY_SIGMAS * self.sigma_px) ** 2
        root = 1.0 / (inflation * self.sigma_px * np.sqrt(1.0 + spread))
        by_rest, by_corner = by_rest * root[:, None, None], by_corner * root[:, None, None]
        residual = residual * root[:, None]
        own = np.tile(np.eye(3) / self.shape_sigma**2, (count, 1, 1))
        cross = np.zeros((count, 3, by_rest.shape[2]))
        right = -self.offsets / self.shape_sigma**2
        np.add.at(own, self.corner_idx, np.einsum("mai,maj->mij", by_corner, by_corner))
        np.add.at(cross, self.corner_idx, np.einsum("mai,mau->miu", by_corner, by_rest))
        np.add.at(right, self.corner_idx, np.einsum("mai,ma->mi", by_corner, residual))
        flat = by_rest.reshape(-1, by_rest.shape[2])
        return BodyEquations(flat.T @ flat, flat.T @ residual.ravel(), own, cross, right)

    def moved(self, whole: Float64[np.ndarray, "7"], corners: Points3) -> "Body":
        """The body after a step of its unknowns."""
        before = self.world_from_body
        after = Similarity(
            before.scale * float(np.exp(whole[6])),
            Rotation.from_rotvec(whole[:3]).as_matrix() @ before.rotation,
            before.translation + whole[3:6],
        )
        return replace(self, world_from_body=after, offsets=self.offsets + corners)

    def _by_whole(self) -> Float64[np.ndarray, "n 3 7"]:
        """How the corners move with the whole, which turns and grows about its own origin."""
        return moves_of_whole(
            self.world_from_body.apply(self.shape) - self.world_from_body.translation
        )


def _projected(view: Float64[np.ndarray, " view"], points: Points3) -> Points2:
    """Pixels as the kernels have them, also where the lens model folds inside the picture."""
    in_camera = Rigid(view[:9].reshape(3, 3), view[9:12]).apply(points)
    depth = np.where(in_camera[:, 2] > 0.0, in_camera[:, 2], np.inf)  # derivatives are zero there
    return lens_derivatives(in_camera[:, 0] / depth, in_camera[:, 1] / depth, view[12:]).xy_px


def moves_of_whole(arms: Points3) -> Float64[np.ndarray, "n 3 7"]:
    """How points so far from its origin move with a body that turns, shifts and grows."""
    moves = np.zeros((len(arms), 3, SIMILARITY_SIZE))
    moves[:, :, :3] = np.cross(np.eye(3), arms[:, None]).transpose(0, 2, 1)
    moves[:, :, 3:6] = np.eye(3)
    moves[:, :, 6] = arms
    return moves


class BodyEquations(ArrowheadEquations):
    """In units of sigma: photos, lenses and the whole are shared, each corner is a block."""

    def of_cameras(self) -> tuple[Float64[np.ndarray, "u u"], Float64[np.ndarray, " u"]]:
        """Normal matrix and right side that remain for photos and lenses."""
        normal, right = self.reduced()
        cameras, whole = slice(None, -SIMILARITY_SIZE), slice(-SIMILARITY_SIZE, None)
        follow = np.linalg.solve(normal[whole, whole], normal[whole, cameras])
        return (
            normal[cameras, cameras] - normal[cameras, whole] @ follow,
            right[cameras] - follow.T @ right[whole],
        )

    def follow(
        self, cameras: Float64[np.ndarray, " u"]
    ) -> tuple[Float64[np.ndarray, "7"], Points3]:
        """Steps of the whole and of the corners after one of photos and lenses."""
        normal, right = self.reduced()
        left = right[-SIMILARITY_SIZE:] - normal[-SIMILARITY_SIZE:, :-SIMILARITY_SIZE] @ cameras
        whole = np.linalg.solve(normal[-SIMILARITY_SIZE:, -SIMILARITY_SIZE:], left)
        return whole, self.back_substituted(np.concatenate([cameras, whole]))
