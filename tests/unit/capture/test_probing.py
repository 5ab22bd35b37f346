"""Probing against bodies whose place, size and form are known."""

import tracemalloc

import numpy as np
import pytest

from limbgram.capture.probing import find_cylinder, find_spheres, narrowest_mm, surface_of
from limbgram.core.mesh.mesh import Mesh
from limbgram.synthetic.props.gauges import BallBar, GaugeCylinder, make_gauge, sphere_centres_mm

BASE_MM = 60.0
STEP_MM = 1.2


def gauge(one: BallBar | GaugeCylinder, noise_mm: float = 0.0) -> Mesh:
    limb = make_gauge(one, STEP_MM, BASE_MM)
    noise = np.random.default_rng(3).normal(0, noise_mm, len(limb.mesh))
    return limb.mesh.with_vertices(limb.mesh.vertices_mm + noise[:, None] * limb.normals)


def test_both_spheres_of_a_leaning_bar_are_found_where_they_are() -> None:
    bar = BallBar(lean_deg=20.0)
    found = find_spheres(surface_of([gauge(bar)]), 50.4)  # the nominal size is only a start
    assert len(found) == 2
    truth = sphere_centres_mm(bar, BASE_MM)
    for middle in truth:
        nearest = min(found, key=lambda one: float(np.linalg.norm(one.middle_mm - middle)))
        np.testing.assert_allclose(nearest.middle_mm, middle, atol=2e-3)
        assert nearest.diameter_mm == pytest.approx(50.0, abs=1e-3)
        assert nearest.form_mm < 1e-3
        assert 0.8 < nearest.seen < 1.0  # the bar and the strip along it are left out


def test_what_lies_far_away_costs_no_memory() -> None:
    """Two balls of 10 mm at the ends of two metres: a grid over all would have 10^10 cells."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=4, radius=5.0)
    middles = np.array([[0.0, 0.0, 0.0], [1200.0, 1100.0, 1150.0]])
    meshes = [
        Mesh(vertices_mm=np.asarray(ball.vertices) + one, faces=np.asarray(ball.faces, np.int32))
        for one in middles
    ]
    tracemalloc.start()
    try:
        found = find_spheres(surface_of(meshes), 10.0)
        peak_mb = tracemalloc.get_traced_memory()[1] / 2**20
    finally:
        tracemalloc.stop()
    assert len(found) == 2
    for middle in middles:
        nearest = min(found, key=lambda one: float(np.linalg.norm(one.middle_mm - middle)))
        np.testing.assert_allclose(nearest.middle_mm, middle, atol=0.01)
        assert nearest.diameter_mm == pytest.approx(10.0, abs=0.02)
    assert peak_mb < 50


def test_noise_on_the_surface_is_form_and_hardly_size() -> None:
    found = find_spheres(surface_of([gauge(BallBar(), noise_mm=0.05)]), 50.0)
    for one in found:
        assert one.diameter_mm == pytest.approx(50.0, abs=0.01)
        assert 3.5 * 0.05 < one.form_95_mm < 4.4 * 0.05  # 3.92 sigmas of a Gaussian
        assert one.form_mm > 1.3 * one.form_95_mm


def test_lobes_of_a_known_height_are_the_form() -> None:
    found = find_spheres(surface_of([gauge(BallBar(form_mm=0.4))]), 50.0)
    assert len(found) == 2
    assert all(one.form_mm == pytest.approx(0.4, abs=0.02) for one in found)


def test_a_bump_on_the_sphere_is_an_error_of_form_and_no_border() -> None:
    mesh = gauge(BallBar())
    _, upper = sphere_centres_mm(BallBar(), BASE_MM)
    place = upper + np.array([0.0, 25.0, 0.0])
    near = np.linalg.norm(mesh.vertices_mm - place, axis=1) < 3.0
    assert near.sum() > 5
    raised = mesh.with_vertices(
        mesh.vertices_mm + np.where(near, 1.6, 0.0)[:, None] * np.array([0.0, 1.0, 0.0])
    )
    found = find_spheres(surface_of([raised]), 50.0)
    one = max(found, key=lambda one: one.middle_mm[2])
    assert one.form_mm > 1.4
    assert one.form_95_mm < 0.2


def test_what_no_photo_measured_does_not_count() -> None:
    mesh = gauge(BallBar())
    _, upper = sphere_centres_mm(BallBar(), BASE_MM)
    cap = mesh.vertices_mm[:, 2] > upper[2] + 15.0
    dented = Mesh(
        vertices_mm=mesh.vertices_mm - np.where(cap, 0.7, 0.0)[:, None] * np.array([0, 0, 1.0]),
        faces=mesh.faces,
        filled=cap,
    )
    one = max(find_spheres(surface_of([dented]), 50.0), key=lambda one: one.middle_mm[2])
    assert one.diameter_mm == pytest.approx(50.0, abs=2e-3)
    assert one.form_mm < 5e-3
    assert not cap[one.vertices].any()


def test_spheres_apart_from_each_other_are_found_in_several_bodies() -> None:
    one = gauge(BallBar())
    far = one.with_vertices(one.vertices_mm + np.array([400.0, 0.0, 0.0]))
    assert len(find_spheres(surface_of([one, far]), 50.0)) == 4


def test_no_sphere_is_made_of_a_cylinder_or_of_another_size() -> None:
    assert find_spheres(surface_of([gauge(GaugeCylinder())]), 50.0) == ()
    assert find_spheres(surface_of([gauge(BallBar())]), 35.0) == ()


def test_a_leaning_cylinder_is_found_without_its_faces() -> None:
    cylinder = GaugeCylinder(lean_deg=12.0, diameter_mm=80.0, length_mm=150.0)
    one = find_cylinder(surface_of([gauge(cylinder)]), 80.5)
    assert one is not None
    assert one.axis is not None
    assert abs(one.axis[2]) == pytest.approx(np.cos(np.radians(12.0)), abs=1e-5)
    assert one.diameter_mm == pytest.approx(80.0, abs=2e-3)
    assert one.form_mm < 5e-3
    assert one.seen == 1.0


def test_lobes_of_a_cylinder_are_its_form() -> None:
    one = find_cylinder(surface_of([gauge(GaugeCylinder(form_mm=0.5))]), 100.0)
    assert one is not None
    assert one.form_mm == pytest.approx(0.5, abs=0.01)


def test_a_ball_bar_is_no_cylinder_of_its_spheres_size() -> None:
    assert find_cylinder(surface_of([gauge(BallBar())]), 120.0) is None


def test_the_narrowest_shell_against_every_shell() -> None:
    rng = np.random.default_rng(7)
    off, areas = rng.normal(size=60), rng.uniform(0.5, 2.0, 60)
    widths = [
        high - low
        for low in off
        for high in off
        if areas[(off >= low) & (off <= high)].sum() >= 0.9 * areas.sum()
    ]
    assert narrowest_mm(off, areas, 0.9) == pytest.approx(min(widths))
