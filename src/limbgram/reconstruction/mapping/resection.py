"""Resection: the pose of a photo from known points and their images."""

import cv2
import numpy as np
from jaxtyping import Int32

from limbgram.core.geometry.arrays import Points2, Points3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera

FEWEST_POINTS = 6
"""Points that a direct linear transform takes."""
LARGEST_MISS_PX = 3.0
"""Largest reprojection error of an inlier."""


def resect(lens: Camera, points_in_world: Points3, xy_px: Points2) -> Rigid | None:
    """camera_from_world from points and their images: RANSAC, then least squares on the inliers.

    None where too few points agree.
    """
    if len(points_in_world) < FEWEST_POINTS:
        return None
    ideal = lens.normalize(xy_px)
    found, turn, shift, inliers = cv2.solvePnPRansac(
        points_in_world,
        ideal,
        np.eye(3),
        np.zeros(5),
        reprojectionError=LARGEST_MISS_PX / lens.fx,
        iterationsCount=1000,
        confidence=0.9999,
    )
    if not found or len(inliers) < FEWEST_POINTS:
        return None
    good: Int32[np.ndarray, " k"] = np.asarray(inliers, np.int32).ravel()
    turn, shift = cv2.solvePnPRefineLM(
        points_in_world[good], ideal[good], np.eye(3), np.zeros(5), turn, shift
    )
    return Rigid.from_rotation_vector(np.asarray(turn, float).ravel(), shift.ravel())
