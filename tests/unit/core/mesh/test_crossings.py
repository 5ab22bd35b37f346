"""Crossings: found where triangles pass through each other, and nowhere else."""

import numpy as np

from limbgram.core.mesh.crossings import find_crossings


def test_two_triangles_through_each_other_are_found() -> None:
    vertices = np.array(
        [[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, -1], [1, 1, 1], [5, 5, 0]], np.float64
    )
    faces = np.array([[0, 1, 2], [3, 4, 5]], np.int32)
    np.testing.assert_array_equal(find_crossings(vertices, faces), [[0, 1]])
    vertices[3:, :2] += 10
    assert not len(find_crossings(vertices, faces))


def test_touching_and_lying_in_one_plane_is_no_crossing() -> None:
    vertices = np.array(
        [[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 0], [1, 1, 2], [2, 1, 2]], np.float64
    )
    assert not len(find_crossings(vertices, np.array([[0, 1, 2], [3, 4, 5]], np.int32)))
    flat = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 0], [3, 1, 0], [1, 3, 0]], np.float64)
    assert not len(find_crossings(flat, np.array([[0, 1, 2], [3, 4, 5]], np.int32)))


def test_a_crowd_agrees_with_looking_at_every_pair() -> None:
    rng = np.random.default_rng(3)
    vertices = rng.normal(size=(120, 3))
    faces = np.arange(120).reshape(-1, 3).astype(np.int32)
    expected = [
        [i, j]
        for i in range(len(faces))
        for j in range(i + 1, len(faces))
        if _pierced(vertices[faces[i]], vertices[faces[j]])
        or _pierced(vertices[faces[j]], vertices[faces[i]])
    ]
    assert len(expected) > 50
    np.testing.assert_array_equal(find_crossings(vertices, faces), expected)
    asked = np.arange(len(faces)) % 3 == 0
    some = [pair for pair in expected if asked[pair].any()]
    np.testing.assert_array_equal(find_crossings(vertices, faces, asked), some)


def _pierced(edges: np.ndarray, triangle: np.ndarray) -> bool:
    """Whether an edge of one triangle meets the inside of the other, by solving for where."""
    for k in range(3):
        start, way = edges[k], edges[(k + 1) % 3] - edges[k]
        system = np.column_stack([triangle[1] - triangle[0], triangle[2] - triangle[0], -way])
        u, v, t = np.linalg.solve(system, start - triangle[0])
        if u > 0 and v > 0 and u + v < 1 and 0 < t < 1:
            return True
    return False


def test_mirror_images_that_meet_edge_on_edge_are_found() -> None:
    one = np.array([[-1, 0, 0], [1, -1, 0], [1, 1, 0.5]], np.float64)
    two = one * [-1, 1, 1]
    faces = np.array([[0, 1, 2], [3, 4, 5]], np.int32)
    assert len(find_crossings(np.concatenate([one, two[:, [0, 1, 2]]]), faces)) == 1


def test_triangles_with_one_corner_in_common_cross_only_beyond_it() -> None:
    vertices = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [2, 2, -1], [2, 2, 3]], np.float64)
    faces = np.array([[0, 1, 2], [0, 3, 4]], np.int32)
    assert len(find_crossings(vertices, faces)) == 1
    vertices[3:, :2] *= -1
    assert not len(find_crossings(vertices, faces))
