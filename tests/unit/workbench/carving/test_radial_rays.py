"""Rays from the axis against surfaces whose radius is known."""

import numpy as np
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.carving.radial_rays import axis_heights_mm, cast_radii
from limbgram.workbench.carving.slab import clip_between_heights, volume_between_mm3


def mesh_of(shape: trimesh.Trimesh) -> Mesh:
    return Mesh(vertices_mm=np.asarray(shape.vertices), faces=shape.faces.astype(np.int32))


@settings(max_examples=40)
@given(
    x=st.floats(-40, 40),
    y=st.floats(-40, 40),
    height=st.floats(-0.99, 0.99),
    angle=st.floats(0, 359.9),
)
def test_a_box_off_the_axis(x: float, y: float, height: float, angle: float) -> None:
    half = 50.0
    box = trimesh.creation.box((2 * half,) * 3)
    box.apply_translation((x, y, 0))
    found = cast_radii(mesh_of(box), np.array([angle]), np.array([half * height]))
    towards = np.array([np.sin(np.radians(angle)), np.cos(np.radians(angle))])
    walls = np.where(towards > 0, half, -half) + np.array([x, y])
    with np.errstate(divide="ignore"):
        expected = np.where(np.abs(towards) > 1e-12, walls / towards, np.inf).min()
    assert found.crossings[0, 0] == 1
    np.testing.assert_allclose(found.radii_mm[0, 0], expected, rtol=1e-9)
    np.testing.assert_allclose(found.girths_mm[0], 400.0, rtol=1e-12)


def test_beside_the_axis_a_ray_crosses_twice_or_never() -> None:
    ball = trimesh.creation.icosphere(subdivisions=5, radius=20)
    ball.apply_translation((50, 0, 0))
    found = cast_radii(mesh_of(ball), np.array([0.0, 90.0, 180.0, 270.0]), np.array([0.1]))
    assert found.crossings[0].tolist() == [0, 2, 0, 0]
    np.testing.assert_allclose(found.outermost_mm[0], [0, 70, 0, 0], atol=0.05)
    np.testing.assert_allclose(found.beneath_mm[0], [0, 30, 0, 0], atol=0.05)
    assert np.isnan(found.radii_mm).all()


@settings(max_examples=30)
@given(seed=st.integers(0, 10**6))
def test_a_ray_through_corners_counts_once(seed: int) -> None:
    """Rays and planes through the mesh's own vertices: the hardest places."""
    rng = np.random.default_rng(seed)
    ball = trimesh.creation.uv_sphere(radius=50, count=[12, 16])
    ball.apply_transform(trimesh.transformations.random_rotation_matrix(rng.random(3)))
    mesh = mesh_of(ball)
    thetas = np.sort(np.degrees(np.arctan2(*mesh.vertices_mm[:, :2].T)) % 360)
    levels = np.sort(mesh.vertices_mm[np.abs(mesh.vertices_mm[:, 2]) < 45, 2])
    assert (cast_radii(mesh, np.unique(thetas), np.unique(levels)).crossings == 1).all()


def test_the_axis_pierces_through_vertices_and_faces() -> None:
    ball = mesh_of(trimesh.creation.uv_sphere(radius=50, count=[12, 16]))
    heights = axis_heights_mm(ball)
    np.testing.assert_allclose([heights.min(), heights.max()], [-50, 50])
    moved = ball.with_vertices(ball.vertices_mm + np.array([3.0, 7.0, 10.0]))
    low, high = axis_heights_mm(moved)
    np.testing.assert_allclose((low + high) / 2, 10, atol=0.5)
    aside = ball.with_vertices(ball.vertices_mm + np.array([60.0, 0, 0]))
    assert not len(axis_heights_mm(aside))


def test_the_volume_between_two_levels() -> None:
    cone = trimesh.creation.cone(radius=60, height=180, sections=500)
    part = clip_between_heights(mesh_of(cone), 45.0, 90.0)
    circle = np.sin(2 * np.pi / 500) / (2 * np.pi / 500)
    expected = circle * np.pi * 45 / 3 * (45**2 + 45 * 30 + 30**2)
    np.testing.assert_allclose(volume_between_mm3(part), expected, rtol=1e-9)
