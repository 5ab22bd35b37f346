"""Places in words a hand can follow."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from limbgram.capture.camera_positions import (
    Stand,
    camera_as_held,
    clock_hour,
    height_of,
    stand_of,
)
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.findings import told

CAMERA = Camera(width_px=300, height_px=200, fx=300.0, fy=300.0, cx=150.0, cy=100.0)


@pytest.mark.parametrize(
    ("azimuth_deg", "hour"), [(0, 12), (30, 11), (90, 9), (180, 6), (270, 3), (350, 12)]
)
def test_clocks_turn_clockwise(azimuth_deg: float, hour: int) -> None:
    assert clock_hour(azimuth_deg) == hour


@pytest.mark.parametrize(
    ("elevation_deg", "words"),
    [
        (3, "level with the limb's middle"),
        (28, "30 degrees above level"),
        (-20, "20 degrees below level"),
        (80, "from straight above"),
    ],
)
def test_heights_are_said_in_steps(elevation_deg: float, words: str) -> None:
    assert told(height_of(elevation_deg)) == words


def test_a_stand_and_its_view_are_the_same_place() -> None:
    middle = np.array([10.0, -20.0, 130.0])
    stand = Stand(azimuth_deg=200.0, elevation_deg=35.0, distance=800.0)
    view = stand.view(CAMERA, middle, first_rad=0.7)
    back = stand_of(view.centre_in_world, middle, 0.7)
    assert back.azimuth_deg == pytest.approx(200.0)
    assert back.elevation_deg == pytest.approx(35.0)
    assert back.distance == pytest.approx(800.0)
    np.testing.assert_allclose(view.project(middle[None])[0], [150.0, 100.0], atol=1e-6)


@pytest.mark.parametrize("quarters", [0, 1, 2, 3])
def test_a_camera_is_taken_as_most_photos_were_held(quarters: int) -> None:
    """Upright pictures of a sensor that lies: the photo's long side stands along the limb."""
    turn = Rotation.from_euler("z", 90 * quarters, degrees=True).as_matrix()
    views: list[View] = []
    for k in range(5):
        stand = Stand(azimuth_deg=72.0 * k, elevation_deg=30.0, distance=800.0)
        level = stand.view(CAMERA, np.zeros(3), first_rad=0.0)
        pose = level.camera_from_world
        held = Rigid(turn @ pose.rotation, turn @ pose.translation)
        views.append(replace(level, camera_from_world=held) if k else level)
    held = camera_as_held(views)
    assert (held.width_px, held.height_px) == ((200, 300) if quarters % 2 else (300, 200))
    assert (held == CAMERA) == (quarters % 2 == 0)
