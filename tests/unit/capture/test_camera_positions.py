"""Places in words a hand can follow."""

import numpy as np
import pytest

from limbgram.capture.camera_positions import Stand, clock_hour, height_of, stand_of
from limbgram.core.geometry.lens import Camera
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
