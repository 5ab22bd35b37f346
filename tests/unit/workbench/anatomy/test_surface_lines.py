"""Lines that a surface tells, against shapes whose lines are known."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import with_faces
from limbgram.workbench.anatomy.surface_lines import (
    LineSurface,
    SurfaceLine,
    SurfacePart,
    bisecting_line,
    bisecting_line_across,
    line_under,
)

SLOPE = 0.11


def leaning_heel(*, wedge: float = 0.0) -> Mesh:
    """An upright elliptic cylinder, 60 x 90 mm and 120 high, whose middles lean in x."""
    around = 2 * np.pi * np.arange(96) / 96
    out, up = np.arange(1, 15) / 15, np.linspace(-60, 60, 41)
    radii = np.concatenate([out, np.ones(len(up)), out[::-1]])
    heights = np.concatenate([np.full(len(out), -60.0), up, np.full(len(out), 60.0)])
    x, y = (np.outer(radii, one) for one in (30 * np.cos(around), 45 * np.sin(around)))
    rings = np.stack([x, y, np.repeat(heights[:, None], len(around), 1)], -1)
    points = np.concatenate([rings.reshape(-1, 3), [[0, 0, -60], [0, 0, 60]]])
    ids = np.arange(rings[..., 0].size).reshape(rings.shape[:2])
    after = np.roll(ids, -1, axis=1)
    low, high = np.full_like(ids[0], ids.size), np.full_like(ids[0], ids.size + 1)
    faces = [
        np.stack([ids[:-1], after[:-1], after[1:]], -1).reshape(-1, 3),
        np.stack([ids[:-1], after[1:], ids[1:]], -1).reshape(-1, 3),
        np.stack([low, after[0], ids[0]], -1),
        np.stack([high, ids[-1], after[-1]], -1),
    ]
    points[:, 0] *= 1 + wedge * points[:, 2]
    points[:, 0] += SLOPE * points[:, 2]
    return Mesh(vertices_mm=points, faces=np.concatenate(faces).astype(np.int32))


def behind(**changed: object) -> SurfacePart:
    """What lies between -25 and 25 mm, behind the middle."""
    part = SurfacePart(
        name="heel bisection",
        middle_mm=np.zeros(3),
        along=np.array([0.0, 0.0, 1.0]),
        towards=np.array([1.0, 0.0, 0.0]),
        half_mm=25.0,
        fade_direction=np.array([0.0, -1.0, 0.0]),
        full_at_mm=40.0,
        zero_at_mm=0.0,
    )
    return replace(part, **changed)


def below(**changed: object) -> SurfacePart:
    part = SurfacePart(
        name="under the forefoot",
        middle_mm=np.array([0.0, 0.0, -60.0]),
        along=np.array([1.0, 0.0, 0.0]),
        towards=np.array([0.0, 0.0, 1.0]),
        half_mm=22.0,
        fade_direction=np.array([0.0, 0.0, 1.0]),
        full_at_mm=0.0,
        zero_at_mm=60.0,
        reach_mm=12.0,
    )
    return replace(part, **changed)


def test_the_line_that_halves_a_leaning_cylinder_leans_with_it() -> None:
    found = bisecting_line(LineSurface(mesh=leaning_heel()), behind())
    assert found.slope == pytest.approx(SLOPE, abs=1e-4)
    x, _, z = found.middle_mm
    assert x == pytest.approx(SLOPE * z, abs=1e-3)


@pytest.mark.parametrize("moved_mm", [(3.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 3.0)])
@pytest.mark.parametrize("half_mm", [15.0, 25.0])
def test_it_does_not_hang_on_where_the_part_was_chosen(
    moved_mm: tuple[float, float, float], half_mm: float
) -> None:
    part = behind(middle_mm=np.array(moved_mm), half_mm=half_mm)
    assert bisecting_line(LineSurface(mesh=leaning_heel()), part).slope == pytest.approx(
        SLOPE, abs=2e-4
    )


def test_a_taper_that_is_alike_on_both_sides_does_not_lean() -> None:
    straight = bisecting_line(LineSurface(mesh=leaning_heel(wedge=0.004)), behind())
    assert straight.slope == pytest.approx(SLOPE, abs=1e-3)


def test_a_bulging_heel_keeps_its_line_in_a_frame_that_rolls() -> None:
    """Middles of slanting sections do not lie on a barrel's axis; those of square ones do."""
    mesh = leaning_heel()
    points = mesh.vertices_mm.copy()
    x = points[:, 0] - SLOPE * points[:, 2]
    points[:, 0] = x * (1 - (points[:, 2] / 90) ** 2)
    lean, roll = 0.1, 0.12
    tilt = Rigid.from_rotation_vector(np.array([0.0, lean, 0.0]), np.zeros(3))
    barrel = LineSurface(mesh=mesh.with_vertices(tilt.apply(points)))
    part = behind().turned(roll)
    assert bisecting_line_across(barrel, part).slope == pytest.approx(np.tan(lean - roll), abs=1e-4)
    assert abs(bisecting_line(barrel, part).slope - np.tan(lean - roll)) > 0.001
    ball = 40 * mesh.vertices_mm / np.linalg.norm(mesh.vertices_mm, axis=1)[:, None]
    with pytest.raises(MeasureError) as refused:
        bisecting_line_across(LineSurface(mesh=mesh.with_vertices(ball)), behind())
    assert refused.value.finding.code == "anatomy.round_part"


def test_the_line_under_a_slanting_sole_is_the_soles() -> None:
    mesh = leaning_heel()
    points = mesh.vertices_mm.copy()
    points[:, 2] += 0.07 * points[:, 0] - 0.2 * points[:, 1]
    sole = mesh.with_vertices(points)
    for skew in (0.0, 0.3):  # the heads of the metatarsals lie on no line square to the foot
        found = line_under(LineSurface(mesh=sole), below(skew=skew))
        # The cylinder leans by SLOPE in x for each millimetre up; the sole itself was level.
        assert found.slope == pytest.approx(0.07, abs=1e-6)


@pytest.mark.parametrize(
    ("tell", "part"),
    [
        (bisecting_line, behind()),
        (bisecting_line_across, behind()),
        (line_under, below(middle_mm=np.array([-6.6, 0.0, -60.0]))),
    ],
)
def test_the_slope_changes_with_the_skin_as_its_gradient_says(
    tell: object, part: SurfacePart
) -> None:
    mesh = leaning_heel()
    normals = mesh.vertex_normals()
    points = mesh.vertices_mm
    bump = np.exp(-((points - [26.0, -20.0, 9.0]) ** 2).sum(1) / 900)
    bump += np.exp(-((points - [8.0, 3.0, -60.0]) ** 2).sum(1) / 200)
    first: SurfaceLine = tell(LineSurface(mesh=mesh), part)  # type: ignore[operator]
    told = float(first.by_vertex(normals) @ bump)
    moved = [
        tell(
            LineSurface(mesh=mesh.with_vertices(points + step * bump[:, None] * normals)), part
        ).slope  # type: ignore[operator]
        for step in (0.05, -0.05)
    ]
    assert abs(told) > 1e-4
    assert (moved[0] - moved[1]) / 0.1 == pytest.approx(told, rel=0.02)


def test_an_open_heel_and_an_empty_part_are_refused() -> None:
    mesh = leaning_heel()
    middles = mesh.vertices_mm[mesh.faces].mean(1)
    torn = np.linalg.norm(middles - [0.0, -45.0, 0.0], axis=1) < 8
    with pytest.raises(MeasureError) as refused:
        bisecting_line(LineSurface(mesh=with_faces(mesh, mesh.faces[~torn])), behind())
    assert refused.value.finding.code == "anatomy.open_part"
    at = np.array(refused.value.finding.values["point_mm"])
    assert np.linalg.norm(at - [0.0, -45.0, 0.0]) < 12
    with pytest.raises(MeasureError) as refused:
        bisecting_line(LineSurface(mesh=mesh), behind(middle_mm=np.array([0.0, 0.0, 200.0])))
    assert refused.value.finding.code == "anatomy.no_part"
    # A hole on the other side, in front, does not matter.
    away = np.linalg.norm(middles - [0.0, 45.0, 0.0], axis=1) < 8
    kept = bisecting_line(LineSurface(mesh=with_faces(mesh, mesh.faces[~away])), behind())
    assert kept.slope == pytest.approx(SLOPE, abs=1e-4)


def test_large_triangles_tell_the_same_lines_as_the_small_ones_that_they_consist_of() -> None:
    """A part of 30 mm, chosen out of triangles of 30 mm, and of the same plane ones quartered."""
    made = trimesh.creation.box([60.0, 90.0, 120.0])
    made = made.subdivide().subdivide()
    slanted = np.array(made.vertices) @ np.array([[1.0, 0, 0], [0, 1, 0], [SLOPE, 0.05, 1]])
    coarse = trimesh.Trimesh(slanted, made.faces, process=False)
    fine = coarse.subdivide().subdivide().subdivide()
    slopes = [
        [
            tell(LineSurface(mesh=Mesh(vertices_mm=np.array(one.vertices),
                                faces=np.array(one.faces, np.int32))), part).slope
            for tell, part in ((bisecting_line, behind(half_mm=15.0)), (line_under, below()))
        ]
        for one in (coarse, fine)
    ]  # fmt: skip
    np.testing.assert_allclose(slopes[0], slopes[1], atol=1e-3)
    assert slopes[1][0] == pytest.approx(SLOPE, abs=1e-4)
