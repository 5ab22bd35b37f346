"""Convex hulls in the plane: against Qhull, and of points whose hull is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull, QhullError

from limbgram.core.geometry.hull import convex_hull


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(3, 300), wide=st.floats(1e-3, 1e3))
def test_it_has_the_corners_that_qhull_finds_in_the_same_order(
    seed: int, count: int, wide: float
) -> None:
    points = np.random.default_rng(seed).normal(0, 50, (count, 2)) * [wide, 1.0]
    found, known = convex_hull(points), ConvexHull(points).vertices
    first = int(np.flatnonzero(known == found[0])[0])
    np.testing.assert_array_equal(found, np.roll(known, -first))


def test_it_goes_anticlockwise_round_an_outline_whichever_way_that_is_walked() -> None:
    angles = 2 * np.pi * np.arange(64) / 64
    ring = np.column_stack([300 + 60 * np.cos(angles), 40 * np.sin(angles) - 20])
    np.testing.assert_array_equal(np.sort(convex_hull(ring)), np.arange(64))
    assert set(np.diff(convex_hull(ring)) % 64) == {1}
    assert set(np.diff(convex_hull(ring[::-1])) % 64) == {63}


def test_points_on_its_sides_and_points_met_twice_are_no_corners() -> None:
    square = np.array([[x, y] for x in range(5) for y in range(5)] * 2, float)
    found = square[convex_hull(square)]
    assert {tuple(one) for one in found.tolist()} == {(0, 0), (4, 0), (4, 4), (0, 4)}
    assert len(found) == 4


@pytest.mark.parametrize("count", [1, 2, 3, 50])
def test_what_has_no_inside_is_refused(count: int) -> None:
    with pytest.raises(QhullError):
        convex_hull(np.arange(count)[:, None] * np.array([1.0, 0.3]))


def test_what_is_not_finite_is_refused() -> None:
    with pytest.raises(ValueError, match="NaN"):
        convex_hull(np.array([[0.0, 0], [1, 0], [np.nan, 1], [0, 1]]))
