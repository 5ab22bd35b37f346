"""Repair against shapes known exactly: one piece, holes filled to the true surface, brim open."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from limbgram.core.errors import SurfaceError
from limbgram.core.mesh.mesh import Cloud, Mesh
from limbgram.core.mesh.topology import (
    boundary_loops,
    face_components,
    is_edge_manifold,
    is_vertex_manifold,
    volume_mm3,
)
from limbgram.reconstruction.surface.cleaning import drop_degenerate_and_duplicate, make_manifold
from limbgram.reconstruction.surface.holes import find_openings
from limbgram.reconstruction.surface.parts import tell_parts
from limbgram.reconstruction.surface.pivoting import pivot
from limbgram.reconstruction.surface.poisson import poisson
from limbgram.reconstruction.surface.repair import repair


def whole_of(mesh: Mesh, cloud: Cloud) -> Mesh:
    return repair(tell_parts(mesh, cloud), cloud)


def assert_whole(mesh: Mesh, openings: int) -> None:
    assert is_edge_manifold(mesh.faces)
    assert is_vertex_manifold(mesh.faces)
    assert not face_components(mesh.faces).any()
    assert len(boundary_loops(mesh.faces)) == openings


def test_a_noisy_thimble_is_whole_but_for_its_brim(open_cylinder: Callable[[float], Cloud]) -> None:
    cloud = open_cylinder(0.07)
    mesh = whole_of(pivot(cloud), cloud)
    assert_whole(mesh, openings=1)
    brim_mm = mesh.vertices_mm[boundary_loops(mesh.faces)[0]]
    around_mm = np.linalg.norm(brim_mm - np.roll(brim_mm, 1, axis=0), axis=1).sum()
    assert around_mm == pytest.approx(2 * np.pi * 20, rel=0.03)
    assert brim_mm[:, 2].max() < 3
    rms = np.sqrt((_beside_thimble(mesh.vertices_mm) ** 2).mean())
    assert 0.06 < rms < 0.08


@pytest.mark.parametrize("axis", ["z", "x", "y"])
def test_a_narrow_brim_is_one_however_the_limb_lies(axis: str) -> None:
    """A neck of 14 mm on a ball of 40, as a shank on its foot; lying, it was closed by a dome."""
    from_pole = np.linspace(1e-3, np.pi - np.arcsin(14 / 40), 60)
    ball = np.column_stack([40 * np.sin(from_pole), -40 * np.cos(from_pole)])
    neck = np.column_stack([np.full(20, 14.0), np.linspace(ball[-1, 1] + 1, 90.0, 20)])
    turned = {"z": np.eye(3), "x": np.eye(3)[[2, 0, 1]], "y": np.eye(3)[[1, 2, 0]]}[axis]
    bottle = _revolved(np.vstack([ball, neck]))
    for shape, is_brim in ((bottle, True), (_revolved(ball), axis == "z")):
        found = find_openings(shape.vertices_mm @ turned.T, shape.faces)
        assert (found.brim is not None) == is_brim
        assert len(found.holes) == (0 if is_brim else 1)


def _revolved(profile_mm: np.ndarray) -> Mesh:
    """A surface of revolution about z, closed below, from radii and heights."""
    angle = 2 * np.pi * np.arange(72) / 72
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    rows = [np.column_stack([radius * ring, np.full(72, z)]) for radius, z in profile_mm[1:]]
    vertices = np.vstack([[[0.0, 0.0, profile_mm[0, 1]]], *rows])
    k = np.arange(72)
    after = (k + 1) % 72
    faces = [np.column_stack([np.zeros(72), 1 + after, 1 + k])]
    for row in range(len(rows) - 1):
        low, high = 1 + 72 * row, 73 + 72 * row
        faces.append(np.column_stack([low + k, low + after, high + k]))
        faces.append(np.column_stack([low + after, high + after, high + k]))
    return Mesh(vertices_mm=vertices, faces=np.vstack(faces).astype(np.int32))


def test_noise_of_a_third_of_the_spacing_tears_the_balls_way_but_not_the_result(
    open_cylinder: Callable[[float], Cloud],
) -> None:
    cloud = open_cylinder(0.35)
    torn = pivot(cloud)
    assert len(boundary_loops(make_manifold(torn.faces))) > 20
    mesh = whole_of(torn, cloud)
    assert_whole(mesh, openings=1)
    rms = np.sqrt((_beside_thimble(mesh.vertices_mm) ** 2).mean())
    assert 0.3 < rms < 0.45


def test_missing_patches_are_filled_to_the_true_shape(
    make_cloud: Callable[..., Cloud], even_directions: Callable[[int], np.ndarray]
) -> None:
    axes = np.array([25.0, 20.0, 40.0])
    directions = even_directions(11_000)
    normals = directions / axes
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    whole = make_cloud(directions * axes, normals, 0.03)
    gaps = np.array([[25.0, 0, 0], [0, -20, 5], [0, 0, 40]])
    apart = np.linalg.norm(whole.points_mm[:, None] - gaps, axis=2).min(1)
    cloud = _chosen(whole, apart > 7)
    mesh = whole_of(pivot(cloud), cloud)
    assert_whole(mesh, openings=0)
    assert mesh.filled is not None
    filled = mesh.vertices_mm[mesh.filled]
    assert np.linalg.norm(filled[:, None] - gaps, axis=2).min(1).max() < 8
    # First-order distance. A flat cover would sink by 7^2 / 2 r: 2.2 mm at the pointed end.
    level = np.linalg.norm(filled / axes, axis=1)
    error = (level - 1) * level / np.linalg.norm(filled / axes**2, axis=1)
    assert np.abs(error).max() < 0.45
    assert np.sqrt((error**2).mean()) < 0.2
    assert volume_mm3(mesh) == pytest.approx(4 / 3 * np.pi * axes.prod(), rel=0.004)


def test_islands_are_dropped_and_counted(sphere_cloud: Cloud) -> None:
    small = replace(
        sphere_cloud, points_mm=(sphere_cloud.points_mm / 6 + [50, 0, 0]).astype(np.float32)
    )
    far = _chosen(small, np.arange(0, len(small), 36))
    both = _joined(sphere_cloud, far)
    mesh = whole_of(pivot(both), both)
    assert_whole(mesh, openings=0)
    assert mesh.repairs is not None
    assert mesh.repairs.islands_dropped == 1
    assert mesh.repairs.others == ()
    # Of two balls the smaller has a sixth of the radius; of points so sparse facets lie inside.
    assert mesh.repairs.island_share == pytest.approx(1 / 37, rel=0.4)
    assert mesh.vertices_mm[:, 0].max() < 31


def test_a_spike_is_taken_off(sphere_cloud: Cloud) -> None:
    mesh = whole_of(pivot(sphere_cloud), sphere_cloud)
    spiked = mesh.vertices_mm.copy()
    spiked[100] *= 1.3
    mended = whole_of(mesh.with_vertices(spiked), sphere_cloud)
    assert_whole(mended, openings=0)
    assert np.linalg.norm(mended.vertices_mm, axis=1).max() < 30.5


def test_faces_inside_out_are_turned(sphere_cloud: Cloud) -> None:
    mesh = pivot(sphere_cloud)
    turned = whole_of(replace(mesh, faces=mesh.faces[:, ::-1].copy()), sphere_cloud)
    assert volume_mm3(turned) == pytest.approx(4 / 3 * np.pi * 30**3, rel=0.005)


def test_poisson_is_cut_back_to_the_points_and_repaired(
    open_cylinder: Callable[[float], Cloud],
) -> None:
    cloud = open_cylinder(0.07)
    mesh = whole_of(poisson(cloud), cloud)
    assert_whole(mesh, openings=1)
    inside = (mesh.vertices_mm[:, 2] > 4) & (mesh.vertices_mm[:, 2] < 79)
    error = _beside_thimble(mesh.vertices_mm[inside])
    assert 0.005 < np.sqrt((error**2).mean()) < 0.07


def test_bow_ties_and_fins_are_opened() -> None:
    fan = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 5, 6]], np.int32)
    assert len(make_manifold(fan)) == 3
    fin = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4], [3, 0, 5], [5, 0, 6]], np.int32)
    np.testing.assert_array_equal(make_manifold(fin), fin[3:])


def test_flat_and_double_faces_are_dropped() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]], float)
    faces = np.array([[0, 1, 2], [1, 2, 0], [0, 1, 3], [1, 1, 2]], np.int32)
    np.testing.assert_array_equal(drop_degenerate_and_duplicate(corners, faces), faces[:1])


def test_scraps_are_refused(sphere_cloud: Cloud) -> None:
    mesh = pivot(sphere_cloud)
    with pytest.raises(SurfaceError, match="triangles"):
        whole_of(replace(mesh, faces=mesh.faces[::40].copy()), sphere_cloud)


def _beside_thimble(points: np.ndarray) -> np.ndarray:
    """Signed distance from the thimble's surface."""
    axis = np.zeros_like(points)
    axis[:, 2] = np.minimum(points[:, 2], 60)
    return np.linalg.norm(points - axis, axis=1) - 20


def _chosen(cloud: Cloud, rows: np.ndarray) -> Cloud:
    return replace(
        cloud,
        points_mm=cloud.points_mm[rows],
        normals=cloud.normals[rows],
        colours=cloud.colours[rows],
        views=cloud.views[rows],
    )


def _joined(one: Cloud, two: Cloud) -> Cloud:
    return replace(
        one,
        points_mm=np.concatenate([one.points_mm, two.points_mm]),
        normals=np.concatenate([one.normals, two.normals]),
        colours=np.concatenate([one.colours, two.colours]),
        views=np.concatenate([one.views, two.views]),
    )


def test_each_opening_is_closed_by_itself_for_the_volume() -> None:
    """A prism, closed or open at one end or both: flat ends add what the prism has."""
    count, radius_mm, high_mm = 24, 30.0, 100.0
    drum = trimesh.creation.cylinder(radius_mm, high_mm, sections=count)
    drum.apply_translation((400.0, -20.0, 7.0))
    exact = count / 2 * np.sin(2 * np.pi / count) * radius_mm**2 * high_mm
    normals, faces = drum.face_normals, drum.faces.astype(np.int32)
    for kept in (normals[:, 2] < 2, normals[:, 2] < 0.5, np.abs(normals[:, 2]) < 0.5):
        mesh = Mesh(vertices_mm=np.asarray(drum.vertices), faces=faces[kept])
        assert volume_mm3(mesh) == pytest.approx(exact, rel=1e-12)
