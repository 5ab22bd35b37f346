"""The tree of triangles: the nearest place, whatever the mesh is like."""

import numpy as np
import pytest

from limbgram.core.mesh.closest import TriangleTree


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
