"""The tree of triangles: the nearest place, whatever the mesh is like."""

import numpy as np
import pytest

from limbgram.core.mesh.closest_point import TriangleTree


@pytest.mark.parametrize("count", [1, 2, 4, 5, 33])
def test_the_nearest_of_level_triangles_is_the_one_below(count: int) -> None:
    corner = np.arange(count) * 10.0
    low = np.column_stack([corner, np.zeros(count), np.zeros(count)])
    vertices = np.concatenate([low, low + np.array([4, 0, 0]), low + np.array([0, 4, 0])])
    faces = np.arange(3 * count, dtype=np.int32).reshape(3, count).T
    found = TriangleTree.of(vertices, faces).closest(low + np.array([1, 1, 7]))
    np.testing.assert_array_equal(found.faces, np.arange(count))
    np.testing.assert_allclose(found.points_mm, low + np.array([1, 1, 0]), atol=1e-12)
    np.testing.assert_allclose(found.distances_mm, 7)


def test_triangles_all_in_one_place_have_a_nearest_too() -> None:
    vertices = np.zeros((3, 3))
    found = TriangleTree.of(vertices, np.zeros((9, 3), np.int32)).closest(np.array([[3.0, 0, 4]]))
    np.testing.assert_allclose(found.distances_mm, 5)


def test_a_mesh_without_faces_has_no_nearest_place() -> None:
    with pytest.raises(ValueError, match="without faces"):
        TriangleTree.of(np.zeros((3, 3)), np.empty((0, 3), np.int32))


@pytest.mark.parametrize("corners", [(0, 0, 1), (0, 1, 0), (1, 0, 0), (0, 1, 2), (2, 1, 0)])
def test_a_triangle_without_an_area_is_its_edges(corners: tuple[int, int, int]) -> None:
    """Two corners in one place, or three in a row, as a closing may leave them."""
    row = np.array([[0.0, 0, 0], [2.0, 0, 0], [1.0, 0, 0]])
    tree = TriangleTree.of(row, np.array([corners], np.int32))
    x = np.array([-3.0, 0.0, 0.3, 1.0, 1.7, 2.0, 6.0])
    for y, z in [(4.0, 3.0), (-1.0, 0.0), (0.0, 0.0)]:
        queries = np.column_stack([x, np.full(7, y), np.full(7, z)])
        nearest = np.column_stack([np.clip(x, 0, 2), np.zeros((7, 2))])
        found = tree.closest(queries)
        away_mm = np.linalg.norm(queries - nearest, axis=1)
        np.testing.assert_allclose(found.distances_mm, away_mm, atol=1e-12)
        np.testing.assert_allclose(found.points_mm, nearest, atol=1e-12)
