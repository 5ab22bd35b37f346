"""Resection among wrong points, on a capture with distortion."""

from typing import Any

import numpy as np

from limbgram.core.geometry.frames import angle_between_deg
from limbgram.reconstruction.mapping.resection import resect


def test_resection_finds_the_pose_among_wrong_points(good_capture: Any) -> None:
    view, points = good_capture.views[0], good_capture.points_mm[:300]
    xy_px = view.project(points)
    xy_px[::5] += 60.0
    pose = resect(view.camera, points, xy_px)
    assert pose is not None
    assert angle_between_deg(pose.rotation, view.camera_from_world.rotation) < 1e-3
    np.testing.assert_allclose(pose.centre, view.centre_in_world, atol=0.01)
    assert resect(view.camera, points[:5], xy_px[:5]) is None
