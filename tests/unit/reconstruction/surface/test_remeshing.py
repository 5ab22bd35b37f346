"""Refinement, distances and sections against shapes known exactly."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.sections import cut
from limbgram.core.mesh.topology import (
    boundary_loops,
    corners_by_vertex,
    find_edges,
    half_edges,
    is_edge_manifold,
    with_faces,
)
from limbgram.reconstruction.surface.remeshing import find_twins, refine

SPHERE = trimesh.creation.icosphere(5, 30.0)


@pytest.fixture(scope="module")
def sphere() -> Mesh:
    return Mesh(vertices_mm=np.asarray(SPHERE.vertices, float), faces=SPHERE.faces.astype(np.int32))


@pytest.fixture(scope="module")
def bowl(sphere: Mesh) -> Mesh:
    """The sphere without what lies under z = -15 mm."""
    middles = sphere.vertices_mm[sphere.faces].mean(1)
    return with_faces(sphere, sphere.faces[middles[:, 2] > -15])


def test_refinement_makes_even_triangles_on_the_same_surface(bowl: Mesh) -> None:
    flagged = replace(bowl, filled=bowl.vertices_mm[:, 2] > 20)
    fine = refine(flagged, 1.5)
    ends = fine.vertices_mm[find_edges(fine.faces).ends]
    lengths = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    assert lengths.mean() == pytest.approx(1.5, rel=0.1)
    assert np.percentile(lengths, 99) < 2.1
    assert np.percentile(lengths, 1) > 0.9
    assert is_edge_manifold(fine.faces)
    assert len(boundary_loops(fine.faces)) == 1
    for source, target in ((bowl, fine), (fine, bowl)):
        tree = TriangleTree.of(target.vertices_mm, target.faces)
        assert tree.closest(source.vertices_mm).distances_mm.max() < 0.05
    assert fine.filled is not None
    clear = np.abs(fine.vertices_mm[:, 2] - 20) > 1
    np.testing.assert_array_equal(fine.filled[clear], fine.vertices_mm[clear, 2] > 20)


def test_nearest_places_agree_with_the_plain_search() -> None:
    rng = np.random.default_rng(3)
    corners = rng.normal(size=(60, 3, 3))
    points = 2 * rng.normal(size=(200, 3))
    tree = TriangleTree.of(corners.reshape(-1, 3), np.arange(180, dtype=np.int32).reshape(-1, 3))
    found = tree.closest(points)
    plain = np.array(
        [
            np.linalg.norm(
                trimesh.triangles.closest_point(corners, np.tile(point, (60, 1))) - point, axis=1
            ).min()
            for point in points
        ]
    )
    np.testing.assert_allclose(found.distances_mm, plain, atol=1e-12)
    np.testing.assert_allclose(
        np.linalg.norm(found.points_mm - points, axis=1), found.distances_mm, atol=1e-12
    )


def test_a_spheres_section_is_a_circle_run_counter_clockwise(sphere: Mesh) -> None:
    (circle,) = cut(sphere, [12.0])
    assert circle.closed
    radius = np.sqrt(30**2 - 12**2)
    assert circle.length_mm == pytest.approx(2 * np.pi * radius, rel=1e-3)
    assert circle.area_mm2(np.array([0, 0, 1.0])) == pytest.approx(np.pi * radius**2, rel=2e-3)
    np.testing.assert_allclose(circle.points_mm[:, 2], 12.0, atol=1e-12)


def test_a_torus_is_cut_into_two_loops_and_its_hole_is_negative() -> None:
    shape = trimesh.creation.torus(30.0, 8.0, major_sections=128, minor_sections=64)
    torus = Mesh(vertices_mm=np.asarray(shape.vertices, float), faces=shape.faces.astype(np.int32))
    areas = sorted(s.area_mm2(np.array([0, 0, 1.0])) for s in cut(torus, [0.001]))
    assert areas == [
        pytest.approx(-np.pi * 22**2, rel=0.01),
        pytest.approx(np.pi * 38**2, rel=0.01),
    ]
    upright = cut(torus, [0.0], np.array([1.0, 0, 0]))
    assert [s.closed for s in upright] == [True, True]


def test_planes_through_vertices_and_the_brim_give_clean_chains(bowl: Mesh) -> None:
    through = cut(bowl, [0.0], np.array([1.0, 0, 0]))  # the icosphere has vertices on x = 0
    assert [s.closed for s in through] == [False]
    span = 2 * np.pi * 30 * (180 + 60) / 360
    assert through[0].length_mm == pytest.approx(span, rel=0.03)
    assert cut(bowl, [31.0]) == ()


@pytest.mark.parametrize("vertices", [4, 30, 4000])
def test_twins_and_corners_are_those_of_a_sort(vertices: int) -> None:
    """On faces drawn at random, with open edges and edges of three faces and more."""
    rng = np.random.default_rng(vertices)
    faces = rng.integers(0, vertices, (3000, 3)).astype(np.int32)
    faces = np.concatenate([faces, SPHERE.faces[:2000].astype(np.int32)])
    ends = np.sort(half_edges(faces), axis=1)
    twins = np.full(len(ends), -1)
    order = np.lexsort((np.arange(len(ends)), ends[:, 1], ends[:, 0]))
    pairs = np.flatnonzero((ends[order[1:]] == ends[order[:-1]]).all(1))
    twins[order[pairs]] = order[pairs + 1]
    twins[order[pairs + 1]] = order[pairs]
    np.testing.assert_array_equal(find_twins(faces), twins)
    count = int(faces.max()) + 1
    starts, corners = corners_by_vertex(faces, count)
    np.testing.assert_array_equal(corners, np.argsort(faces.ravel(), kind="stable"))
    np.testing.assert_array_equal(np.diff(starts), np.bincount(faces.ravel(), minlength=count))
