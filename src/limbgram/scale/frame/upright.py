"""Upright: the direction that is up, told by how the photos were taken."""

from collections.abc import Sequence

import numpy as np

from limbgram.geometry.arrays import Matrix3, Points3, Vector3
from limbgram.geometry.camera import View
from limbgram.scale.sight import Aim

_AGREEING = 0.5
"""Length of the mean of unit vectors above which they count as one direction."""


def common_up(views: Sequence[View], aim: Aim) -> Vector3:
    """Up in the photos where they agree; otherwise the axis that the cameras go round.

    A ring of photos taken with the camera turned on its side has no common up in the pictures:
    then it is the normal of the cameras' plane, on the side where the cameras look down from.
    """
    ups = np.array([-view.camera_from_world.rotation[1] for view in views])
    mean = ups.mean(0)
    if np.linalg.norm(mean) > _AGREEING:
        return mean / np.linalg.norm(mean)
    centres = np.array([view.centre_in_world for view in views])
    normal = np.linalg.svd(centres - centres.mean(0))[2][2]
    above = float(normal @ (centres.mean(0) - aim.point))
    return normal if above >= 0 else -normal


def rotation_to_z(up: Vector3) -> Matrix3:
    """The shortest rotation that takes the unit vector `up` to +Z."""
    z = np.array([0.0, 0.0, 1.0])
    if up[2] < -1 + 1e-9:
        return np.diag([1.0, -1.0, -1.0])
    v = np.cross(up, z)
    skew = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + skew + skew @ skew / (1 + up[2])


def centre_of_object(points_in_world: Points3, aim: Aim) -> Vector3:
    """Median of the points near the aim."""
    near = np.linalg.norm(points_in_world - aim.point, axis=1) < aim.reach
    return np.median(points_in_world[near], axis=0) if near.any() else aim.point
