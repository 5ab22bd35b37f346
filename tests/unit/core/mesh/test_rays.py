"""Rays in a cube whose sides are known."""

import numpy as np
import trimesh

from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.rays import intersects_any

HALF_MM = 10.0
CUBE = trimesh.creation.box((2 * HALF_MM,) * 3)
TREE = TriangleTree.of(np.asarray(CUBE.vertices, float), np.asarray(CUBE.faces, np.int32))


def ways_to_the_sides() -> np.ndarray:
    """From the middle just onto the sides: anywhere, and through edges and corners."""
    drawn = np.random.default_rng(1).uniform(-1, 1, (500, 3))
    signs = np.stack(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
    ways = np.concatenate([drawn, signs[np.abs(signs).any(1)]])
    return HALF_MM * ways / np.abs(ways).max(1, keepdims=True)


def test_a_way_meets_the_side_that_it_reaches_and_none_before() -> None:
    ways = ways_to_the_sides()
    start = np.zeros_like(ways)
    assert intersects_any(TREE, start, (1 + 1e-9) * ways).all()
    assert not intersects_any(TREE, start, 0.999 * ways).any()


def test_what_lies_behind_the_start_does_not_count() -> None:
    ways = ways_to_the_sides()
    assert not intersects_any(TREE, 1.001 * ways, ways).any()
