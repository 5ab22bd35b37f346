"""The floor under an object, against the plane that its points were drawn on."""

import tracemalloc

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.photos.photo import Exif
from limbgram.reconstruction.scale.floor import common_up, find_floor
from limbgram.reconstruction.scale.visibility import Aim, aim_of

CAMERA = Camera(width_px=400, height_px=300, fx=500.0, fy=500.0, cx=199.5, cy=149.5)


@pytest.mark.parametrize("photos", [12, 300])
def test_the_floor_is_found_in_a_bounded_room(photos: int) -> None:
    """Every plane against every point or photo at once took 458 MB and more."""
    draw = np.random.default_rng(4)
    leaning = Rigid.looking_at(np.array([30.0, -40, 200]), np.zeros(3), np.array([0.0, 1, 0]))
    turn = leaning.rotation.T
    count = 3000
    flat = np.column_stack([draw.uniform(-150, 150, (count, 2)), draw.normal(0, 0.3, count)])
    body = np.column_stack([draw.uniform(-25, 25, (count, 2)), draw.uniform(5, 80, count)])
    points = np.concatenate([flat, body]) @ turn.T
    angles = 2 * np.pi * np.arange(photos) / photos
    eyes = np.column_stack([400 * np.cos(angles), 400 * np.sin(angles), 0 * angles + 250]) @ turn.T
    target, up = turn @ [0.0, 0.0, 40.0], turn[:, 2]
    views = [View("", CAMERA, Rigid.looking_at(eye, target, up)) for eye in eyes]
    aim = aim_of(views, points)
    tracemalloc.start()
    try:
        floor = find_floor(views, points, aim, seed=1)
        peak_mb = tracemalloc.get_traced_memory()[1] / 2**20
    finally:
        tracemalloc.stop()
    assert floor is not None
    assert np.degrees(np.arccos(min(1.0, float(floor.normal @ up)))) < 0.1
    assert floor.height == pytest.approx(0.0, abs=0.2)
    assert peak_mb < 60


def held(turns: int, degrees: float, height: float) -> list[View]:
    """Photos over an arc round the origin, stored so many quarter turns from upright."""
    angles = np.radians(np.linspace(-degrees / 2, degrees / 2, 9))
    on_side = Rigid.from_rotation_vector(np.array([0.0, 0.0, np.pi / 2 * turns]), np.zeros(3))
    eyes = np.column_stack([400 * np.cos(angles), 400 * np.sin(angles), 0 * angles + height])
    upright = [Rigid.looking_at(eye, np.zeros(3), np.array([0.0, 0.0, 1.0])) for eye in eyes]
    return [View("", CAMERA, on_side.inverse @ pose) for pose in upright]


@pytest.mark.parametrize("degrees", [100.0, 320.0])
@pytest.mark.parametrize("height", [60.0, -60.0])
@pytest.mark.parametrize("turns", [0, 1, 2, 3])
def test_up_is_as_the_photos_were_held(turns: int, height: float, degrees: float) -> None:
    """Of an arc of portraits the stored pictures agree on a side; a phone may hang upside down."""
    views = held(turns, degrees, height)
    up = common_up(views, Aim(np.zeros(3), 100.0, 400.0), [turns] * len(views))
    assert np.degrees(np.arccos(up[2])) < 15.0


def test_a_swap_of_left_and_right_reverses_the_turns() -> None:
    assert [Exif(quarter_turns=k).turns_of_up for k in range(4)] == [0, 1, 2, 3]
    swapped = [Exif(quarter_turns=k, mirrored=True).turns_of_up for k in range(4)]
    assert swapped == [0, 3, 2, 1]
