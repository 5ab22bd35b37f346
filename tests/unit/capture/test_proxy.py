"""The proxy against limbs of known shape: cones that stand, lie, and are seen from one side."""

from dataclasses import replace

import numpy as np
import pytest

from limbgram.capture.proxy import COLUMNS, LimbProxy, gaps_mm, plain_tube, proxy_of

FIRST = np.array([1000.0, 0.0, 0.0])
LENGTH, LOWER, UPPER = 240.0, 60.0, 45.0


def cone(count: int, seed: int, around: tuple[float, float] = (-np.pi, np.pi)) -> np.ndarray:
    """Points on a cone about the upright, its middle at 0, with a flat upper end."""
    rng = np.random.default_rng(seed)
    z, turn = rng.uniform(0, LENGTH, count), rng.uniform(*around, count)
    radius = LOWER + (UPPER - LOWER) * z / LENGTH
    side = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), z - LENGTH / 2])
    aside = UPPER * np.sqrt(rng.uniform(0, 1, count // 6))
    turn = rng.uniform(*around, count // 6)
    end = np.column_stack(
        [aside * np.cos(turn), aside * np.sin(turn), np.full(len(turn), LENGTH / 2)]
    )
    return np.concatenate([side, end])


ROUGH_MM = 5.0
"""A tenth of the radius: what the flat end takes off the uppermost row, which no limb has."""


def off_the_cone(proxy: LimbProxy) -> np.ndarray:
    """Distances of the side's cells from the cone, about the proxy's own axis through 0."""
    side = proxy.mesh.vertices_mm[: proxy.side_rows * COLUMNS]
    z = side @ proxy.axis
    radius = np.linalg.norm(side - np.outer(z, proxy.axis), axis=1)
    return radius - (LOWER + (UPPER - LOWER) * (z / LENGTH + 0.5))


def test_a_standing_cone_is_found_in_place_and_size() -> None:
    proxy = proxy_of(cone(3000, 1), FIRST)
    off = off_the_cone(proxy)
    assert np.abs(off).max() < ROUGH_MM
    assert np.abs(off).max() > 1e-3  # it is a rough surface through points, not the truth
    assert abs(proxy.length / LENGTH - 0.95) < 0.06
    assert proxy.known.all()
    outward = proxy.mesh.vertex_normals()
    assert (np.einsum("ni,ni->n", outward, proxy.mesh.vertices_mm - proxy.middle) > 0).all()
    np.testing.assert_allclose(proxy.axis, [0, 0, 1])
    np.testing.assert_allclose(proxy.first, [1, 0, 0], atol=0.02)


def test_a_cone_seen_from_one_side_is_closed_behind() -> None:
    proxy = proxy_of(cone(3000, 2, around=(-2.0, 2.0)), FIRST)
    assert np.abs(off_the_cone(proxy)).max() < 0.15 * LOWER


def test_a_lying_limb_has_its_own_long_axis() -> None:
    points = cone(3000, 3)[:, [2, 1, 0]] * [1, -1, 1]
    proxy = proxy_of(points, np.array([0.0, 0.0, 900.0]))
    assert abs(proxy.axis[0]) > 0.999
    off = (
        off_the_cone(proxy) if proxy.axis[0] > 0 else off_the_cone(replace(proxy, axis=-proxy.axis))
    )
    assert np.abs(off).max() < 1.3 * ROUGH_MM
    assert np.median(np.abs(off)) < 2.5


def test_an_end_without_points_is_left_open() -> None:
    points = cone(3000, 4)
    bare = points[np.abs(points[:, 2] - LENGTH / 2) > 1e-9]
    proxy = proxy_of(bare, FIRST)
    assert not proxy.known[-1]
    assert proxy.known[: proxy.side_rows * COLUMNS].all()


@pytest.mark.parametrize("radius", [30.0, 70.0])
def test_a_planned_limb_has_the_size_that_was_asked(radius: float) -> None:
    heights = np.array([0.0, 150.0, 300.0])
    proxy = plain_tube(heights, np.full(3, radius), 0.8 * radius)
    assert abs(proxy.radius / radius - 1) < 0.05
    assert abs(proxy.length / (300 + 0.8 * radius) - 0.95) < 0.06
    assert np.linalg.norm(proxy.middle[:2]) < 1.0


def test_gaps_are_the_way_to_the_nearest_point_along_the_skin() -> None:
    points = cone(6000, 3)
    proxy = proxy_of(points, FIRST)
    dense = gaps_mm(proxy, points)
    assert 0.5 < np.median(dense[proxy.known]) < 4.0  # 2,500 mm^2 for 19 points: 3 mm on average
    turn, z = np.arctan2(points[:, 1], points[:, 0]), points[:, 2]
    window = (np.abs(turn) < np.radians(45)) & (np.abs(z) < 40)
    bare = gaps_mm(proxy, points[~window])
    side = proxy.by_row(bare)[: proxy.side_rows]
    before = proxy.by_row(dense)[: proxy.side_rows]
    middle = side[proxy.side_rows // 2]
    assert 25 < middle[0] < 45  # 42 mm round to the window's side, 40 mm to its ends
    np.testing.assert_allclose(middle[6:19], before[proxy.side_rows // 2][6:19], atol=1e-9)
