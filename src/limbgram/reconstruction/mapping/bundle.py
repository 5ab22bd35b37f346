"""A bundle: placed photos, points and observations as the arrays that the kernels take."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.core.geometry.arrays import Points2, Points3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE, with_pose_step
from limbgram.core.interval import MAD_TO_SIGMA
from limbgram.reconstruction.mapping.lens_deviations import PhotoLenses
from limbgram.reconstruction.mapping.scene import Observations, OwnLenses, Scene

_FEWEST_RAYS = 2
_SMALLEST_ANGLE_DEG = 1.5
CAUCHY_SIGMAS = 2.5
"""Residual, in sigmas, at which the Cauchy weight is a half."""
_MIN_RAYS_FOR_SIGMA = 3
_SMALLEST_SIGMA_PX = 1e-4


@dataclass(frozen=True)
class Bundle:
    """Placed photos, lenses and points, with observations sorted by point.

    `photo_idx` counts placed photos only.
    """

    views: Float64[np.ndarray, "p view"]
    lens_idx: Int64[np.ndarray, " p"]
    lenses: int
    points: Points3
    photo_idx: Int64[np.ndarray, " m"]
    point_idx: Int64[np.ndarray, " m"]
    xy_px: Float64[np.ndarray, "m 2"]
    own_sigma_px: Float64[np.ndarray, " m"] | None = None
    """Standard deviation of corners of coded marks; zero for other keypoints."""
    photo_lenses: PhotoLenses | None = None
    """Parametrisation of the lenses where every photo has a deviation of its own."""

    @classmethod
    def of(cls, scene: Scene) -> "Bundle":
        """The bundle of a scene's placed photos."""
        placed = np.array(scene.placed)
        place = np.full(len(scene.names), -1)
        place[placed] = np.arange(len(placed))
        seen = scene.observations
        order = np.lexsort((seen.photo_idx, seen.point_idx))
        order = order[place[seen.photo_idx[order]] >= 0]
        return cls(
            np.array([view.packed for view in scene.views]),
            np.array(scene.lens_idx, np.int64),
            scene.lenses,
            scene.points_in_world.copy(),
            place[seen.photo_idx[order]].astype(np.int64),
            seen.point_idx[order].astype(np.int64),
            np.ascontiguousarray(seen.xy_px[order]),
            None if seen.own_sigma_px is None else seen.own_sigma_px[order],
        )

    @property
    def bounds(self) -> Int64[np.ndarray, " n"]:
        """Index of the first observation of every point, and the end."""
        return np.searchsorted(self.point_idx, np.arange(len(self.points) + 1)).astype(np.int64)

    @property
    def unknowns(self) -> int:
        """Number of unknowns of poses and lenses."""
        return POSE_SIZE * len(self.views) + LENS_SIZE * self.lenses

    def moved(self, camera_step: Float64[np.ndarray, " u"], point_step: Points3) -> "Bundle":
        """The bundle after a step of all unknowns."""
        poses = camera_step[: POSE_SIZE * len(self.views)].reshape(-1, POSE_SIZE)
        lenses = camera_step[POSE_SIZE * len(self.views) :].reshape(-1, LENS_SIZE)
        views = np.array([with_pose_step(view, step) for view, step in zip(self.views, poses)])
        views[:, 12:] += lenses[self.lens_idx]
        return replace(self, views=views, points=self.points + point_step)

    def pose_by_motion(self, shares: Float64[np.ndarray, " p"]) -> Float64[np.ndarray, "c 6"]:
        """Jacobian of the photos' poses by a rigid motion of all points about their centre.

        Args:
            shares: How much of the motion each photo shows.
        """
        middle = np.median(self.points, axis=0)
        poses = np.zeros((len(self.views), POSE_SIZE, POSE_SIZE))
        for pose, view, share in zip(poses, self.views, shares, strict=True):
            pose[:3, :3] = pose[3:, 3:] = share * view[:9].reshape(3, 3)
            pose[3:, :3] = pose[3:, 3:] @ np.cross(middle, np.eye(3)).T
        return poses.reshape(-1, POSE_SIZE)

    def lens(self, scene: Scene, idx: int) -> Float64[np.ndarray, " lens"]:
        """The lens of one camera; that of the scene where no placed photo uses it."""
        if self.photo_lenses is not None:
            return self.photo_lenses.camera_lenses[idx]
        if scene.own is not None:  # the views include deviations of single photos
            return scene.cameras[idx].packed
        users = np.flatnonzero(self.lens_idx == idx)
        return self.views[users[0], 12:] if len(users) else scene.cameras[idx].packed

    def scene(self, before: Scene) -> Scene:
        """`before` with these poses, lenses, points and observations."""
        placed = np.array(before.placed)
        poses = list(before.camera_from_world)
        for photo, view in zip(placed, self.views):
            poses[photo] = Rigid(view[:9].reshape(3, 3).copy(), view[9:12].copy())
        lenses = [
            camera.with_parameters(self.lens(before, idx))
            for idx, camera in enumerate(before.cameras)
        ]
        return replace(
            before,
            cameras=tuple(lenses),
            camera_from_world=tuple(poses),
            own=None if before.own is None else self._own_lenses(before.own, placed),
            points_in_world=self.points,
            observations=Observations(
                placed[self.photo_idx].astype(np.int32),
                self.point_idx.astype(np.int32),
                self.xy_px,
                self.own_sigma_px,
            ),
        )

    def _own_lenses(self, before: OwnLenses, placed: Int64[np.ndarray, " p"]) -> OwnLenses:
        """Lens deviations of the photos as they are now."""
        if self.photo_lenses is None:
            return before
        shifts, values, spread = before.shifts.copy(), before.values.copy(), before.spread
        shifts[placed] = self.photo_lenses.shifts
        if self.photo_lenses.is_solved:
            values[placed], spread = self.photo_lenses.values, self.photo_lenses.spread
        return replace(before, shifts=shifts, values=values, spread=spread)

    def residuals_px(self, scene: Scene) -> Points2:
        """Measured minus projected; NaN behind a camera."""
        return self.scene(scene).residuals_px()

    def sigma_px(self, scene: Scene) -> float:
        """Standard deviation of a measured coordinate, from the median of the residuals.

        A point takes three degrees of freedom of its rays, so residuals are smaller than errors;
        points with two rays are left out where there are others, and so are coded marks.
        """
        rays = np.bincount(self.point_idx, minlength=len(self.points))[self.point_idx]
        asked = rays >= min(_MIN_RAYS_FOR_SIGMA, int(rays.max()))
        if self.own_sigma_px is not None and (asked & (self.own_sigma_px == 0)).any():
            asked &= self.own_sigma_px == 0
        freedom = np.sqrt((2 * rays[asked] - 3) / (2 * rays[asked]))
        errors = np.abs(self.residuals_px(scene)[asked]) / freedom[:, None]
        return max(MAD_TO_SIGMA * float(np.nanmedian(errors)), _SMALLEST_SIGMA_PX)

    def without_outliers(self, scene: Scene, sigma_px: float, most: float) -> "Bundle":
        """The bundle without observations beyond `most` sigmas, then without weak points.

        Corners of coded marks are judged by their own sigma where that is larger: keypoints in
        sharp photos agree better than corners on bent paper.
        """
        residuals = self.residuals_px(scene)
        own = np.zeros(len(residuals)) if self.own_sigma_px is None else self.own_sigma_px
        kept = self._observations(
            np.linalg.norm(residuals, axis=1) < most * np.maximum(sigma_px, own)
        )
        return kept.without_weak_points()

    def without_weak_points(self) -> "Bundle":
        """The bundle without points that have too few rays, or too small a triangulation angle.

        Photos of a burst share many points that no other photo shows, at unknown depth.
        """
        rays = np.bincount(self.point_idx, minlength=len(self.points))
        return self.with_points(
            (rays >= _FEWEST_RAYS) & (self.widest_angle_deg() > _SMALLEST_ANGLE_DEG)
        )

    def with_points(self, keep: Bool[np.ndarray, " n"]) -> "Bundle":
        """The bundle with some of the points, and their observations."""
        kept = self._observations(keep[self.point_idx])
        number = np.cumsum(keep) - 1
        return replace(kept, points=self.points[keep], point_idx=number[kept.point_idx])

    def with_points_thinned(self, every: int) -> "Bundle":
        """The bundle with each `every`-th point."""
        return self if every < 2 else self.with_points(np.arange(len(self.points)) % every == 0)

    def widest_angle_deg(self) -> Float64[np.ndarray, " n"]:
        """By point, the triangulation angle of its first ray and the one farthest from it."""
        rotation = self.views[:, :9].reshape(-1, 3, 3)
        centres = -np.einsum("pji,pj->pi", rotation, self.views[:, 9:12])
        rays = centres[self.photo_idx] - self.points[self.point_idx]
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        start = np.minimum(self.bounds[:-1], max(len(rays) - 1, 0))
        cosine = np.einsum("ij,ij->i", rays, rays[start][self.point_idx])
        widest = np.ones(len(self.points))
        np.minimum.at(widest, self.point_idx, cosine)
        return np.degrees(np.arccos(np.clip(widest, -1.0, 1.0)))

    def _observations(self, keep: Bool[np.ndarray, " m"]) -> "Bundle":
        return replace(
            self,
            photo_idx=self.photo_idx[keep],
            point_idx=self.point_idx[keep],
            xy_px=self.xy_px[keep],
            own_sigma_px=None if self.own_sigma_px is None else self.own_sigma_px[keep],
        )
