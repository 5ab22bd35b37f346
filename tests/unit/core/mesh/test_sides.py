"""Sides of faces, of triangles whose sides are known."""

import numpy as np

from limbgram.core.mesh.mesh import longest_sides_mm


def test_the_longest_side_is_found_whichever_it_is() -> None:
    """A triangle of 3, 4 and 5 mm, by each of its corners first, one far away, and a flat one."""
    corners = np.array([[0.0, 0, 0], [4, 0, 0], [0, 3, 0], [0, 0, 12], [2, 0, 0]])
    faces = np.array([[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 1, 3], [0, 4, 1]], np.int32)
    np.testing.assert_array_equal(
        longest_sides_mm(corners, faces), [5.0, 5.0, 5.0, np.sqrt(160.0), 4.0]
    )
    assert longest_sides_mm(corners, faces[:0]).shape == (0,)


def test_it_is_what_numpy_finds_to_the_last_bit() -> None:
    rng = np.random.default_rng(3)
    places = rng.normal(0, 100, (500, 3))
    faces = rng.integers(0, 500, (3000, 3), dtype=np.int32)
    corners = places[faces]
    known = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(1)
    np.testing.assert_array_equal(longest_sides_mm(places, faces), known)
