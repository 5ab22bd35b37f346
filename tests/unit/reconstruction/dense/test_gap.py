"""Pieces of one object that lie apart: the spheres of a ball bar."""

import numpy as np

from limbgram.core.geometry.arrays import Points3
from limbgram.reconstruction.dense.region import limb_among
from limbgram.reconstruction.scale.visibility import Aim

AIM = Aim(np.zeros(3), 200.0, 1000.0)


def ball(height_mm: float, count: int) -> Points3:
    points = np.random.default_rng(count).normal(size=(count, 3))
    points *= 25.0 / np.linalg.norm(points, axis=1, keepdims=True)
    return points + np.array([0.0, 0.0, height_mm])


def test_a_gap_that_is_named_parts_nothing() -> None:
    lower, upper = ball(-75.0, 900), ball(75.0, 400)
    points = np.concatenate([lower, upper])
    assert len(limb_among(points, AIM, 50).points_mm) == len(lower)
    joined = limb_among(points, AIM, 50, gap_mm=125.0)
    assert len(joined.points_mm) == len(points)
    assert joined.link_mm == 125.0


def test_what_lies_beyond_the_gap_stays_apart() -> None:
    lower, far = ball(-75.0, 900), ball(400.0, 200)
    found = limb_among(np.concatenate([lower, far]), AIM, 50, gap_mm=125.0)
    assert len(found.points_mm) == len(lower)
