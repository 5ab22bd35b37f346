"""Visibility: the scene point that the cameras look at, and whether photos show points."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.lens import Camera, View

_CENTRAL = 8.0
"""Points a third of a half frame from the middle count 40 %, at half of it 14 %."""
_FAR_ASIDE = 3.0


@dataclass(frozen=True)
class Aim:
    """The point that the photos look at, in the scene's unit."""

    point: Vector3
    reach: float
    """Half the shorter side of a typical frame, at the point's distance."""
    distance: float
    """Median distance of the cameras from the point."""


def aim_of(views: Sequence[View], points_in_world: Points3) -> Aim:
    """Where the photos look: the mean of the scene points that the frames hold in the middle.

    The meeting point of the optical axes would do for a ring, not for photos taken from one side,
    where it is undetermined along the axes; the points know the distance.
    """
    aside = np.array([_off_centre(view, points_in_world) for view in views])
    central = np.exp(-_CENTRAL * np.mean(np.minimum(aside, _FAR_ASIDE) ** 2, axis=0))
    point = central @ points_in_world / central.sum()
    depths = np.array([np.linalg.norm(view.centre_in_world - point) for view in views])
    halves = np.array([_half_frame(view.camera) for view in views])
    return Aim(point, float(np.median(depths * halves)), float(np.median(depths)))


def in_frame(views: Sequence[View], points_in_world: Points3) -> Bool[np.ndarray, "v n"]:
    """Which points each view shows in its frame (occlusion is not looked at)."""
    return np.array([view.shows(points_in_world) for view in views])


def _half_frame(camera: Camera) -> float:
    """Tangent of the angle from the middle of the frame to its nearer border."""
    return min(camera.width_px / camera.fx, camera.height_px / camera.fy) / 2


def _off_centre(view: View, points_in_world: Points3) -> Float64[np.ndarray, " n"]:
    """Distance of each point from the middle of the frame, in half frames; infinite behind it."""
    in_camera = view.camera_from_world.apply(points_in_world)
    depth = np.where(in_camera[:, 2] > 0, in_camera[:, 2], np.nan)
    offset = np.linalg.norm(in_camera[:, :2] / depth[:, None], axis=1)
    return np.nan_to_num(offset, nan=np.inf) / _half_frame(view.camera)
