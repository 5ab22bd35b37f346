"""Ball Pivoting on shapes known exactly."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.errors import SurfaceError
from limbgram.core.mesh.mesh import Cloud
from limbgram.core.mesh.topology import boundary_half_edges, face_components, is_edge_manifold
from limbgram.core.mesh.topology import volume_mm3 as volume_of
from limbgram.reconstruction.surface.pivoting import measure_spacing_mm, pivot


def test_a_sphere_is_wrapped_outwards_by_its_own_points(sphere_cloud: Cloud) -> None:
    mesh = pivot(sphere_cloud)
    assert is_edge_manifold(mesh.faces)
    assert len(mesh) > 0.97 * len(sphere_cloud)
    assert len(boundary_half_edges(mesh.faces)) < 0.02 * len(mesh.faces)
    assert volume_of(mesh) == pytest.approx(4 / 3 * np.pi * 30**3, rel=0.005)
    own = {tuple(point) for point in sphere_cloud.points_mm.astype(float).tolist()}
    assert {tuple(vertex) for vertex in mesh.vertices_mm.tolist()} <= own


def test_a_torus_keeps_its_hole(make_cloud: Callable[..., Cloud]) -> None:
    rings = []
    for row, v in enumerate(np.linspace(0, 2 * np.pi, 50, endpoint=False)):
        count = round(2 * np.pi * (30 + 8 * np.cos(v)))
        u = 2 * np.pi * (np.arange(count) + 0.5 * (row % 2)) / count
        rings.append(np.column_stack([u, np.full(count, v)]))
    u, v = np.concatenate(rings).T
    normals = np.column_stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)])
    centres = 30 * np.column_stack([np.cos(u), np.sin(u), np.zeros(len(u))])
    mesh = pivot(make_cloud(centres + 8 * normals, normals))
    assert not len(boundary_half_edges(mesh.faces))
    edges = len(mesh.faces) * 3 // 2
    assert len(mesh) - edges + len(mesh.faces) == 0  # Euler's number of a torus
    assert volume_of(mesh) == pytest.approx(2 * np.pi**2 * 30 * 64, rel=0.01)


def test_a_gap_wider_than_the_balls_stays_open(open_cylinder: Callable[[float], Cloud]) -> None:
    cloud = open_cylinder(0.0)
    away = np.linalg.norm(cloud.points_mm - [20, 0, 30], axis=1) > 8
    part = _chosen(cloud, away)
    mesh = pivot(part)
    middle = np.linalg.norm(mesh.vertices_mm[mesh.faces].mean(1) - [20, 0, 30], axis=1)
    assert 6 < middle.min() < 9


def test_order_of_the_points_does_not_change_the_surface(sphere_cloud: Cloud) -> None:
    shuffled = _chosen(sphere_cloud, np.random.default_rng(1).permutation(len(sphere_cloud)))
    one, two = pivot(sphere_cloud), pivot(shuffled)
    np.testing.assert_array_equal(one.vertices_mm, two.vertices_mm)
    np.testing.assert_array_equal(one.faces, two.faces)


def test_a_second_sheet_nearer_than_the_thinning_is_left_out(sphere_cloud: Cloud) -> None:
    twice = Cloud(
        points_mm=np.concatenate([sphere_cloud.points_mm, sphere_cloud.points_mm * 1.003]),
        normals=np.tile(sphere_cloud.normals, (2, 1)),
        colours=np.tile(sphere_cloud.colours, (2, 1)),
        views=np.tile(sphere_cloud.views, 2),
        spacing_mm=1.0,
    )
    mesh = pivot(twice)
    assert len(np.unique(face_components(mesh.faces))) == 1
    assert 0.9 * len(sphere_cloud) < len(mesh) < 1.1 * len(sphere_cloud)


def test_spacing_is_the_side_of_a_points_square(sphere_cloud: Cloud) -> None:
    assert measure_spacing_mm(sphere_cloud) == pytest.approx(1.0, abs=0.15)


def test_a_handful_of_points_is_refused(sphere_cloud: Cloud) -> None:
    with pytest.raises(SurfaceError, match="20 points"):
        pivot(_chosen(sphere_cloud, np.arange(20)))


def test_a_cloud_inside_out_is_wrapped_the_way_its_normals_say(sphere_cloud: Cloud) -> None:
    mesh = pivot(replace(sphere_cloud, normals=-sphere_cloud.normals))
    assert volume_of(mesh) < -0.99 * 4 / 3 * np.pi * 30**3


def _chosen(cloud: Cloud, rows: np.ndarray) -> Cloud:
    return Cloud(
        points_mm=cloud.points_mm[rows],
        normals=cloud.normals[rows],
        colours=cloud.colours[rows],
        views=cloud.views[rows],
        spacing_mm=cloud.spacing_mm,
    )
