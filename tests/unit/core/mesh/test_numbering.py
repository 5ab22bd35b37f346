"""Edges, areas and nearest places, against closed forms, sorting and searching everything."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh, crosses, dots, lengths, summed
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    edge_lengths,
    faces_touching,
    find_edges,
    half_edges,
    number_pairs,
)


@given(arrays(np.int32, st.tuples(st.integers(0, 40), st.just(2)), elements=st.integers(0, 6)))
def test_pairs_are_numbered_in_rising_order_and_equal_ones_alike(pairs: np.ndarray) -> None:
    numbered = number_pairs(pairs[:, 0], pairs[:, 1])
    keys, number = np.unique(pairs[:, 0] * 10 + pairs[:, 1], return_inverse=True)
    np.testing.assert_array_equal(numbered.number, number)
    np.testing.assert_array_equal(numbered.order, np.argsort(number, kind="stable"))
    assert (
        numbered.starts.tolist() == np.searchsorted(np.sort(number), range(len(keys) + 1)).tolist()
    )


@pytest.mark.parametrize("count", [32, 33, 63, 64, 65, 96, 97, 200, 1000])
def test_a_large_heap_is_sorted_and_equal_pairs_stay_as_they_came(count: int) -> None:
    second = np.random.default_rng(count).integers(0, count // 3, count)
    numbered = number_pairs(np.zeros(count, np.int32), second.astype(np.int32))
    np.testing.assert_array_equal(numbered.order, np.argsort(second, kind="stable"))
    np.testing.assert_array_equal(numbered.number, np.unique(second, return_inverse=True)[1])


def test_a_hub_of_many_edges_is_sorted_as_well() -> None:
    rim = np.random.default_rng(3).permutation(np.arange(1, 3001))
    faces = np.column_stack([np.zeros(3000, int), rim, rim % 3000 + 1]).astype(np.int32)
    edges = find_edges(faces)
    assert len(edges.ends) == 6000
    np.testing.assert_array_equal(edges.ends[:3000], [[0, k] for k in range(1, 3001)])
    own = np.sort(half_edges(faces), axis=1)
    np.testing.assert_array_equal(edges.ends[edges.of_half_edge], own)
    np.testing.assert_array_equal(edges.uses, 2 - (edges.ends[:, 0] > 0))


def test_normals_of_faces_are_the_cross_product_to_the_last_bit() -> None:
    rng = np.random.default_rng(5)
    vertices, faces = rng.normal(size=(90, 3)) * 100, rng.integers(0, 90, (200, 3)).astype(np.int32)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    np.testing.assert_array_equal(crosses(vertices, faces), np.cross(b - a, c - a))


@pytest.mark.parametrize("apart_mm", [0.0, 1e-7, 5.0, 1e5])
def test_no_triangle_is_nearer_than_the_one_that_is_found(apart_mm: float) -> None:
    rng = np.random.default_rng(7)
    faces = np.arange(900, dtype=np.int32).reshape(-1, 3)
    corners = rng.normal(size=(300, 1, 3)) * 50 + rng.normal(size=(300, 3, 3)) * 4
    queries = corners.mean(1)[::2] + rng.normal(size=(150, 3)) * apart_mm
    tree = TriangleTree.of(corners.reshape(-1, 3), faces)
    together = tree.closest(queries)
    for query, place, face, distance in zip(
        queries, together.points_mm, together.faces, together.distances_mm, strict=True
    ):
        alone = [
            TriangleTree.of(corners[k], np.array([[0, 1, 2]], np.int32)).closest(query[None])
            for k in range(0, 300, 7)
        ]
        assert distance <= min(float(one.distances_mm[0]) for one in alone)
        np.testing.assert_allclose(np.linalg.norm(place - query), distance, atol=1e-9)
        own = TriangleTree.of(corners[face], np.array([[0, 1, 2]], np.int32)).closest(query[None])
        assert own.distances_mm[0] == distance
    turned = tree.closest(queries[::-1])
    np.testing.assert_array_equal(turned.faces[::-1], together.faces)
    np.testing.assert_array_equal(turned.points_mm[::-1], together.points_mm)


def test_each_vertex_has_a_third_of_its_triangles() -> None:
    corners = np.array([[0.0, 0, 5], [2, 0, 5], [2, 2, 5], [0, 2, 5], [9, 9, 9]])
    square = Mesh(vertices_mm=corners, faces=np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    wanted = np.array([4, 2, 4, 2, 0]) / 3
    np.testing.assert_allclose(square.vertex_areas_mm2(), wanted, rtol=1e-15)


def test_edges_of_faces_that_were_changed_in_place_are_found_anew() -> None:
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    before = find_edges(faces)
    assert find_edges(faces.copy()) is before
    faces[1] = [1, 3, 2]
    assert find_edges(faces).ends.tolist() == [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]]
    assert before.ends.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]


@given(arrays(np.int32, st.tuples(st.integers(1, 30), st.just(3)), elements=st.integers(0, 8)))
def test_neighbours_and_open_half_edges_agree_with_looking_at_every_edge(faces: np.ndarray) -> None:
    edges = find_edges(faces)
    near = edges.neighbours
    for vertex in range(faces.max() + 1):
        row = slice(near.starts[vertex], near.starts[vertex + 1])
        touching = {k: set(ends) for k, ends in enumerate(edges.ends.tolist()) if vertex in ends}
        others = {k: next(iter(ends - {vertex}), vertex) for k, ends in touching.items()}
        assert near.vertices[row].tolist() == sorted(others.values())
        assert dict(zip(near.edges[row].tolist(), near.vertices[row].tolist(), strict=True)) == (
            others
        )
    own = [tuple(sorted(ends)) for ends in half_edges(faces).tolist()]
    assert edges.open_half_edges.tolist() == [k for k, e in enumerate(own) if own.count(e) == 1]
    np.testing.assert_array_equal(
        boundary_half_edges(faces), half_edges(faces)[edges.open_half_edges]
    )


def test_lengths_products_and_areas_are_those_of_numpy_to_the_last_bit() -> None:
    rng = np.random.default_rng(11)
    ones, twos = rng.normal(size=(500, 3)) * 100, rng.normal(size=(500, 3))
    np.testing.assert_array_equal(dots(ones, twos), (ones * twos).sum(1))
    np.testing.assert_array_equal(lengths(ones), np.linalg.norm(ones, axis=1))
    faces = rng.integers(0, 500, (900, 3)).astype(np.int32)
    thirds = np.linalg.norm(crosses(ones, faces), axis=1) / 6
    np.testing.assert_array_equal(
        Mesh(vertices_mm=ones, faces=faces).vertex_areas_mm2(),
        np.bincount(faces.ravel(), np.repeat(thirds, 3), 500),
    )
    ends = rng.integers(0, 500, (700, 2)).astype(np.int32)
    np.testing.assert_array_equal(
        edge_lengths(ones, ends), np.linalg.norm(ones[ends[:, 0]] - ones[ends[:, 1]], axis=1)
    )
    weighted = rng.normal(size=(900, 3))
    corners = [np.zeros((500, 3)) for _ in range(3)]
    for corner, total in enumerate(corners):
        np.add.at(total, faces[:, corner], weighted)
    np.testing.assert_array_equal(
        summed(weighted, faces, 500), corners[0] + corners[1] + corners[2]
    )
    marked = rng.random(500) < 0.3
    np.testing.assert_array_equal(faces_touching(marked, faces), marked[faces].any(1))
