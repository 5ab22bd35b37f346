"""A film's poses: once round, each place following from the one before, never at even speed."""

from itertools import pairwise

import numpy as np
import pytest

from limbgram.core.geometry.frames import angle_between_deg
from limbgram.synthetic.photographer import film_round

TARGET = np.array([5.0, -3.0, 120.0])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_walk_is_smooth_uneven_and_goes_all_round(seed: int) -> None:
    poses = film_round(TARGET, 900.0, 300, seed)
    away = np.array([pose.centre for pose in poses]) - TARGET
    distance = np.linalg.norm(away, axis=1)
    assert distance.min() > 0.93 * 900
    assert distance.max() < 1.07 * 900
    azimuth = np.degrees(np.unwrap(np.arctan2(away[:, 1], away[:, 0])))
    speed = np.diff(azimuth)
    assert 355 < azimuth.max() - azimuth.min() < 410
    assert speed.max() > 1.3 * np.median(speed)
    turns = [angle_between_deg(a.rotation, b.rotation) for a, b in pairwise(poses)]
    assert max(turns) < 4.0
    again = film_round(TARGET, 900.0, 300, seed)
    assert all((a.rotation == b.rotation).all() for a, b in zip(poses, again, strict=True))
    ahead = np.array([pose.rotation @ (TARGET - pose.centre) for pose in poses])
    assert (ahead[:, 2] > 0.99 * distance).all()  # it looks at the limb all the time
