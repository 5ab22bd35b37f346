"""Distances with closed forms: spheres, cubes, cylinders, cones."""

import numpy as np
import pytest
import trimesh

from limbgram.core.errors import MeasureError
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.compare.counterparts import CounterpartSurface
from limbgram.workbench.compare.deviation import area_quantile, deviation


def sphere(radius_mm: float, centre: tuple[float, float, float] = (0, 0, 0)) -> Mesh:
    ball = trimesh.creation.icosphere(subdivisions=5, radius=radius_mm)
    return Mesh(
        vertices_mm=np.asarray(ball.vertices) + np.array(centre, float),
        faces=np.asarray(ball.faces, np.int32),
    )


def box(half_mm: float) -> Mesh:
    solid = trimesh.creation.box(extents=[2 * half_mm] * 3)
    return Mesh(
        vertices_mm=np.asarray(solid.vertices, float), faces=np.asarray(solid.faces, np.int32)
    )


def tube(radius_mm: float, top_mm: float) -> Mesh:
    angles = 2 * np.pi * np.arange(90) / 90
    rows = round(top_mm / 5) + 1
    wall = np.concatenate(
        [
            np.column_stack(
                [radius_mm * np.cos(angles), radius_mm * np.sin(angles), 0 * angles + z]
            )
            for z in 5.0 * np.arange(rows)
        ]
    )
    i, j = (k.ravel() for k in np.meshgrid(np.arange(rows - 1), np.arange(90), indexing="ij"))
    here, beside = i * 90 + j, i * 90 + (j + 1) % 90
    faces = np.concatenate(
        [
            np.column_stack([here, beside, beside + 90]),
            np.column_stack([here, beside + 90, here + 90]),
        ]
    )
    return Mesh(vertices_mm=wall, faces=faces.astype(np.int32))


FACET_MM = 0.02
"""Largest sag of the spheres' facets."""


def test_a_larger_sphere_lies_outside_everywhere_by_the_difference() -> None:
    found = deviation(sphere(50), sphere(51), brim_mm=5)
    for one_way in (found.on_first, found.on_second):
        np.testing.assert_allclose(one_way.difference_mm, 1.0, atol=FACET_MM)
        assert one_way.figures.compared_share == pytest.approx(1.0)
        assert one_way.figures.mean_mm == pytest.approx(1.0, abs=FACET_MM)
        assert one_way.figures.rms_mm == pytest.approx(1.0, abs=FACET_MM)
    assert found.hausdorff95_mm == pytest.approx(1.0, abs=FACET_MM)
    assert found.snae_p95_deg < 0.5
    assert deviation(sphere(51), sphere(50), 5).on_first.figures.mean_mm == pytest.approx(
        -1.0, abs=FACET_MM
    )


def test_an_offset_sphere_differs_as_its_formula_says() -> None:
    shift = np.array([0.0, 0, 2])
    first, second = sphere(50), sphere(50, (0, 0, 2))
    found = deviation(first, second, brim_mm=5)
    expected = 50 - np.linalg.norm(first.vertices_mm - shift, axis=1)
    np.testing.assert_allclose(found.on_first.difference_mm, expected, atol=FACET_MM)
    back = np.linalg.norm(second.vertices_mm, axis=1) - 50
    np.testing.assert_allclose(found.on_second.difference_mm, back, atol=FACET_MM)
    figures = found.on_first.figures
    assert figures.mean_mm == pytest.approx(-(2**2) / (3 * 50), abs=0.015)
    assert figures.rms_mm == pytest.approx(2 / np.sqrt(3), abs=0.02)
    assert figures.mean_abs_mm == pytest.approx(1.0, abs=0.02)
    assert figures.p95_mm == pytest.approx(0.95 * 2, abs=0.03)
    assert figures.largest_mm == pytest.approx(2.0, abs=0.03)


def test_corners_and_edges_of_a_box_tell_inside_from_outside() -> None:
    ground = CounterpartSurface.of(box(10), 0.0)
    outside = np.array([[11.0, 11, 11], [11, 11, 0], [11, 0, 0], [10.5, -13, 2]])
    np.testing.assert_allclose(
        ground.counterparts(outside).signed_mm, [3**0.5, 2**0.5, 1, np.hypot(0.5, 3)]
    )
    inside = np.array([[9.0, 9.5, 9.8], [0, 0, 9]])
    np.testing.assert_allclose(ground.counterparts(inside).signed_mm, [-0.2, -1])


def test_what_lies_beyond_the_brim_has_no_figure() -> None:
    found = deviation(tube(50, 200), tube(50.5, 100), brim_mm=6)
    heights = tube(50, 200).vertices_mm[:, 2]
    known = np.isfinite(found.on_first.difference_mm)
    assert not known[(heights > 95) | (heights < 6)].any()
    assert known[(heights > 10) & (heights < 90)].all()
    assert found.on_first.figures.compared_share == pytest.approx(0.43, abs=0.05)
    np.testing.assert_allclose(found.on_first.difference_mm[known], 0.5, atol=1e-2)


def test_filled_parts_have_no_figure() -> None:
    ball = sphere(50)
    filled = ball.vertices_mm[:, 2] > 0
    guessed = Mesh(vertices_mm=ball.vertices_mm, faces=ball.faces, filled=filled)
    found = deviation(guessed, sphere(51), brim_mm=0)
    assert not np.isfinite(found.on_first.difference_mm[filled]).any()
    assert np.isfinite(found.on_first.difference_mm[~filled]).all()
    assert found.on_second.figures.compared_share == pytest.approx(0.5, abs=0.03)


def test_shells_that_do_not_face_each_other_are_refused() -> None:
    far = tube(50, 100)
    far = far.with_vertices(far.vertices_mm + np.array([0, 0, 500.0]))
    with pytest.raises(MeasureError, match="do not face each other"):
        deviation(tube(50, 100), far, brim_mm=5)


def test_a_tilted_wall_turns_its_normals_by_its_angle() -> None:
    straight, cone = tube(50, 100), tube(50, 100)
    lean = 0.05
    vertices = cone.vertices_mm.copy()
    vertices[:, :2] *= (1 + lean * (vertices[:, 2] - 50) / 50)[:, None]
    found = deviation(straight, cone.with_vertices(vertices), brim_mm=6)
    assert found.snae_mean_deg == pytest.approx(np.degrees(np.arctan(lean)), rel=0.01)


def test_quantiles_go_by_area_not_by_count() -> None:
    values, areas = np.array([1.0, 2, 3]), np.array([1.0, 1, 98])
    assert area_quantile(values, areas, 0.5) == pytest.approx(3.0, abs=0.05)
    assert area_quantile(np.arange(101.0), np.ones(101), 0.25) == pytest.approx(24.75)
