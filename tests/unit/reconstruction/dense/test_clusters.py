"""Which points are the limb: narrow gaps part nothing, however densely points lie."""

import numpy as np

from limbgram.reconstruction.dense.region import limb_among, link_length
from limbgram.reconstruction.scale.visibility import Aim

AIM = Aim(point=np.array([0.0, 0.0, 10.0]), reach=80.0, distance=500.0)


def halves(gap_mm: float) -> np.ndarray:
    """A wall of dense points with a gap across it, the upper part the heavier one."""
    random = np.random.default_rng(3)
    upper = random.uniform([-20, 0, gap_mm / 2], [20, 1, 30], (20_000, 3))
    lower = random.uniform([-20, 0, -10], [20, 1, -gap_mm / 2], (6_000, 3))
    return np.concatenate([upper, lower])


def test_a_narrow_gap_between_dense_points_parts_nothing() -> None:
    points = halves(2.5)
    assert link_length(points) < 2.0
    limb = limb_among(points, AIM, 100)
    assert len(limb.points_mm) > 0.99 * len(points)


def test_a_wide_gap_parts_two_objects() -> None:
    points = halves(12.0)
    limb = limb_among(points, AIM, 100)
    assert len(limb.points_mm) < 0.85 * len(points)
    assert limb.points_mm[:, 2].min() > 0
