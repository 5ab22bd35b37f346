"""Corners: a board's corners as points of the scene, from all photos that see them.

Corners that contradict the others are dropped: where the limb's silhouette cuts the board, a
detector puts some of them a pixel and more beside the truth. How far the errors of single photos
(their poses above all) move the corners is told by leaving out one photo after the other.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int32

from limbgram.errors import ScaleError
from limbgram.geometry.arrays import Points2, Points3
from limbgram.geometry.camera import View
from limbgram.geometry.triangulation import triangulate
from limbgram.mapping.scene import Scene
from limbgram.photos.photo import SetAside
from limbgram.targets.detections import BoardDetections

_LEAST_SIGHTINGS = 3
_ROUNDS = 20
_LEAST_LIMIT_PX = 0.3
_LIMIT_SIGMAS = 4.0
_RAYLEIGH_MEDIAN = 1.1774
_MOST_RESIDUAL = 0.001
"""Typical residual above which the board cannot have lain still, as a share of the width."""
_LEAST_TRUST = 0.5
"""A photo of whose corners fewer agree with the other photos is left out."""


@dataclass(frozen=True, kw_only=True)
class SceneCorners:
    """Corners of the board, located in the scene."""

    ids: Int32[np.ndarray, " n"]
    points_in_world: Points3
    without_photo: Float64[np.ndarray, "p n 3"]
    """The same points, each time without one of the p photos."""
    sightings: "Sightings"
    """Those that were believed, of corners located or not."""
    sigma_px: float
    """Standard deviation of one measured coordinate, from the residuals."""
    set_aside: tuple[SetAside, ...]


@dataclass(frozen=True)
class Sightings:
    """Corner point_idx[k] of the board appears in views[view_idx[k]] at xy_px[k]."""

    views: tuple[View, ...]
    view_idx: Int32[np.ndarray, " m"]
    point_idx: Int32[np.ndarray, " m"]
    xy_px: Points2
    count: int

    def only(self, kept: np.ndarray) -> "Sightings":
        return Sightings(
            self.views, self.view_idx[kept], self.point_idx[kept], self.xy_px[kept], self.count
        )

    def points(self) -> Points3:
        """The corners; NaN where they are not seen enough."""
        if not self.views:
            return np.full((self.count, 3), np.nan)
        located = triangulate(self.views, self.view_idx, self.point_idx, self.xy_px, self.count)
        return located.points_in_world

    def residuals_px(self, points: Points3) -> Float64[np.ndarray, " m"]:
        """Distance between measured and projected pixels; NaN where the point is unknown."""
        distances = np.full(len(self.xy_px), np.nan)
        for idx, view in enumerate(self.views):
            rows = self.view_idx == idx
            projected = view.project(points[self.point_idx[rows]])
            distances[rows] = np.linalg.norm(self.xy_px[rows] - projected, axis=1)
        return distances


def locate_corners(scene: Scene, detections: BoardDetections) -> SceneCorners:
    """Triangulate the corners that at least three placed photos see.

    Raises:
        ScaleError: the board's corners contradict each other in all photos.
    """
    sightings = _sightings(scene, detections)
    believed = _consistent(sightings)
    _check_still(believed, sightings)
    trusted, doubted = _without_strangers(believed, sightings)
    points = trusted.points()
    seen = np.bincount(trusted.point_idx, minlength=trusted.count)
    known = np.isfinite(points).all(1) & (seen >= _LEAST_SIGHTINGS)
    replicates = _leave_one_out(trusted, points)
    return SceneCorners(
        ids=np.flatnonzero(known).astype(np.int32),
        points_in_world=points[known],
        without_photo=replicates[:, known],
        sightings=trusted,
        sigma_px=_sigma_px(trusted.residuals_px(points)),
        set_aside=doubted,
    )


def _sightings(scene: Scene, detections: BoardDetections) -> Sightings:
    index = {scene.names[k]: k for k in scene.placed}
    seen = [photo for photo in detections.photos if photo.name in index]
    views = tuple(scene.view(index[photo.name]) for photo in seen)
    lengths = [len(photo.ids) for photo in seen]
    return Sightings(
        views,
        np.repeat(np.arange(len(seen), dtype=np.int32), lengths),
        np.concatenate([photo.ids for photo in seen] or [np.zeros(0, np.int32)]),
        np.concatenate([photo.xy_px for photo in seen] or [np.zeros((0, 2))]),
        len(detections.corners_mm),
    )


def _consistent(sightings: Sightings) -> Sightings:
    """Drop each corner's worst sighting while it is far beyond the usual residual."""
    for _ in range(_ROUNDS):
        residuals = sightings.residuals_px(sightings.points())
        limit = max(_LEAST_LIMIT_PX, _LIMIT_SIGMAS * _sigma_px(residuals))
        worst = np.zeros(sightings.count)
        np.maximum.at(worst, sightings.point_idx, np.nan_to_num(residuals))
        dropped = (residuals > limit) & (residuals == worst[sightings.point_idx])
        if not dropped.any():
            break
        sightings = sightings.only(~dropped)
    return sightings


def _check_still(believed: Sightings, sightings: Sightings) -> None:
    if not len(believed.xy_px):
        return
    sigma_px = _sigma_px(sightings.residuals_px(believed.points()))
    if sigma_px > _MOST_RESIDUAL * max(view.camera.width_px for view in sightings.views):
        raise ScaleError(
            f"The board's corners miss each other by {sigma_px:.1f} px in the "
            f"{len(sightings.views)} photos that show it. The board moved against the limb, or "
            "it is another board than the one described. Fix it beside the limb, or leave it "
            "out and give a known distance."
        )


def _without_strangers(
    believed: Sightings, sightings: Sightings
) -> tuple[Sightings, tuple[SetAside, ...]]:
    """Leave out photos in which most corners contradict the other photos."""
    before = np.bincount(sightings.view_idx, minlength=len(sightings.views))
    after = np.bincount(believed.view_idx, minlength=len(sightings.views))
    strange = after < _LEAST_TRUST * before
    doubted = tuple(
        SetAside(
            sightings.views[k].name,
            f"{before[k] - after[k]} of its {before[k]} board corners contradict the other "
            "photos; it was not used for the scale",
        )
        for k in np.flatnonzero(strange)
    )
    return believed.only(~strange[believed.view_idx]), doubted


def _leave_one_out(sightings: Sightings, points: Points3) -> Float64[np.ndarray, "p n 3"]:
    """The points without each photo in turn; a point that needs the photo stays where it is."""
    replicates = [
        sightings.only(sightings.view_idx != photo).points()
        for photo in np.unique(sightings.view_idx)
    ]
    stack = np.array(replicates).reshape(-1, *points.shape)
    return np.where(np.isfinite(stack), stack, points)


def _sigma_px(residuals: Float64[np.ndarray, " m"]) -> float:
    """Robust sigma of one coordinate from distances in two."""
    known = residuals[np.isfinite(residuals)]
    return float(np.median(known)) / _RAYLEIGH_MEDIAN if len(known) else 0.0
