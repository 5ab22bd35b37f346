"""Walls against closed forms: girths and volumes of their inside, and where they are thinnest."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.errors import MeasureError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.limb_file import write_limb
from limbgram.report.drawings.drawing import Drawing
from limbgram.report.drawings.wall_thickness import wall_map
from limbgram.services.measure import MeasureFiles, MeasureRequest, measure
from limbgram.workbench.edits.thickness import Thickness, wall_thickness
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame
from limbgram.workbench.measures.measuring import LimbMeasureOptions, measure_inside, measure_limb

ROUND, INNER_MM, OUTER_MM, FLOOR_MM, HIGH_MM = 120, 40.0, 44.0, 6.0, 150.0
FLAT = np.cos(np.pi / ROUND)
"""What the sides of a polygon lie nearer than its corners."""
STEPS = 20


def _tube(radius_mm: float, low_mm: float, shift_mm: float) -> np.ndarray:
    """Rings from low to the brim, one behind the other."""
    angles = 2 * np.pi * np.arange(ROUND) / ROUND
    heights = np.linspace(low_mm, HIGH_MM, STEPS + 1)
    ring = np.column_stack([radius_mm * np.cos(angles) + shift_mm, radius_mm * np.sin(angles)])
    return np.concatenate([np.column_stack([ring, np.full(ROUND, z)]) for z in heights])


def cup(shift_mm: float = 0.0) -> Limb:
    """A cylinder's wall with a floor; its hollow may stand aside."""
    outer, inner = _tube(OUTER_MM, 0.0, 0.0), _tube(INNER_MM, FLOOR_MM, shift_mm)
    count = len(outer)
    vertices = np.concatenate([outer, inner, [[0, 0, 0], [shift_mm, 0, FLOOR_MM]]])
    k = np.arange(ROUND)
    after = (k + 1) % ROUND
    faces: list[np.ndarray] = []
    for step in range(STEPS):
        a, b = step * ROUND + k, step * ROUND + after
        faces += [np.column_stack([a, b, b + ROUND]), np.column_stack([a, b + ROUND, a + ROUND])]
        a, b = a + count, b + count
        faces += [np.column_stack([b, a, a + ROUND]), np.column_stack([b, a + ROUND, b + ROUND])]
    top, inner_top = STEPS * ROUND, count + STEPS * ROUND
    faces += [
        np.column_stack([top + k, top + after, inner_top + after]),
        np.column_stack([top + k, inner_top + after, inner_top + k]),
        np.column_stack([after, k, np.full(ROUND, 2 * count)]),
        np.column_stack([count + k, count + after, np.full(ROUND, 2 * count + 1)]),
    ]
    made = trimesh.Trimesh(vertices, np.concatenate(faces), process=False)
    assert made.is_watertight
    assert made.volume > 0
    return limb_of(made)


def limb_of(made: trimesh.Trimesh) -> Limb:
    mesh = Mesh(vertices_mm=np.asarray(made.vertices), faces=made.faces.astype(np.int32))
    return AlignedLimb(mesh=mesh, frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="left"))


def half_shell() -> Limb:
    """The wall without its floor, on one side of the axis."""
    angles = np.linspace(0, np.pi, ROUND // 2 + 1)
    arc = np.column_stack([np.cos(angles), np.sin(angles)])
    profile = np.concatenate([OUTER_MM * arc, INNER_MM * arc[::-1]])
    heights = np.linspace(0, HIGH_MM, STEPS + 1)
    count, along = len(profile), len(arc)
    vertices = np.concatenate([np.column_stack([profile, np.full(count, z)]) for z in heights])
    k = np.arange(count)
    after = (k + 1) % count
    faces: list[np.ndarray] = []
    for step in range(STEPS):
        a, b = step * count + k, step * count + after
        faces += [np.column_stack([a, b, b + count]), np.column_stack([a, b + count, a + count])]
    one = np.arange(along - 1)
    other = count - 1 - one
    for base, turn in ((0, -1), (STEPS * count, 1)):
        lid = [np.column_stack([one, one + 1, other - 1]), np.column_stack([one, other - 1, other])]
        faces += [base + part[:, ::turn] for part in lid]
    made = trimesh.Trimesh(vertices, np.concatenate(faces), process=False)
    assert made.is_watertight
    assert made.volume > 0
    return limb_of(made)


OPTIONS = LimbMeasureOptions(heights_mm=(3.0, 50.3, 101.7), volumes_mm=((50.0, 100.0),))


def area(radius_mm: float) -> float:
    return ROUND / 2 * np.sin(2 * np.pi / ROUND) * radius_mm**2


def girth(radius_mm: float) -> float:
    """At the smoothing length: of the circle at the mean distance of the polygon's sides."""
    return 2 * np.pi * (1 - (np.pi / ROUND) ** 2 / 3) * radius_mm


@pytest.mark.parametrize("shift_mm", [0.0, 2.5])
def test_the_inside_of_a_cup_has_its_own_girths_and_volumes(shift_mm: float) -> None:
    found = measure_inside(cup(shift_mm), OPTIONS)
    assert found.skin == "inside"
    solid, low, high = found.rows
    assert solid.level is None, "the floor has no inside"
    for row in (low, high):
        tape, contour = row.figures["tape_mm"], row.figures["contour_mm"]
        assert tape is not None
        assert contour is not None
        for figure in (tape, contour):
            assert figure.value == pytest.approx(girth(INNER_MM), rel=3e-5)
        held = row.figures["volume_below_mm3"]
        assert held is not None
        assert held.value == pytest.approx(area(INNER_MM) * (row.height_mm - FLOOR_MM), rel=1e-9)
    assert found.volumes[0].volume_mm3.value == pytest.approx(50 * area(INNER_MM), rel=1e-9)
    assert found.tip_mm == pytest.approx(FLOOR_MM)


def test_without_a_word_the_outside_is_measured_and_said_to_be() -> None:
    found = measure_limb(cup(), OPTIONS)
    assert found.skin == "outside"
    figures = found.rows[1].figures
    assert figures["tape_mm"] is not None
    assert figures["tape_mm"].value == pytest.approx(girth(OUTER_MM), rel=3e-5)
    assert figures["area_mm2"] is not None
    assert figures["area_mm2"].value == pytest.approx(area(OUTER_MM) - area(INNER_MM), rel=1e-9)


def test_a_wall_tells_where_it_is_thinnest() -> None:
    even = wall_thickness(cup().mesh)
    assert even is not None
    assert even.thinnest_mm == pytest.approx((OUTER_MM - INNER_MM) * FLAT, rel=1e-3)
    assert even.median_mm == pytest.approx((OUTER_MM - INNER_MM) * FLAT, rel=1e-3)
    thin = wall_thickness(cup(3.5).mesh)
    assert thin is not None
    assert thin.thinnest_mm == pytest.approx((OUTER_MM - INNER_MM - 3.5) * FLAT, abs=0.01)
    assert thin.place_mm[0] > 43
    assert abs(thin.place_mm[1]) < 6
    at = thin.at_vertices_mm[np.abs(cup(3.5).mesh.vertices_mm[:, 2] - 75) < 3]
    assert np.nanmin(at) == pytest.approx(0.5, abs=0.02)
    assert np.nanmax(at) == pytest.approx(7.5, abs=0.05)


def test_a_half_shell_has_a_thickness_and_no_inner_girth() -> None:
    half = half_shell()
    found = measure_limb(half, OPTIONS)
    assert found.skin == "only"
    assert found.wall is not None
    assert found.wall.thinnest_mm == pytest.approx((OUTER_MM - INNER_MM) * FLAT, rel=1e-2)
    with pytest.raises(MeasureError, match="open on a side"):
        measure_inside(half, OPTIONS)


@pytest.mark.parametrize("scale", [1.0, 0.4])
def test_a_limb_is_no_wall(scale: float) -> None:
    made = trimesh.creation.capsule(height=150, radius=50, count=(48, 48))
    mesh = Mesh(vertices_mm=scale * np.asarray(made.vertices), faces=made.faces.astype(np.int32))
    limb = replace(cup(), mesh=mesh)
    found = measure_limb(limb, LimbMeasureOptions(spacing_mm=20))
    assert (found.skin, found.wall) == ("only", None)
    with pytest.raises(MeasureError, match="no inside"):
        measure_inside(limb)


def test_a_screw_hole_makes_no_second_skin() -> None:
    made = trimesh.creation.annulus(r_min=5, r_max=45, height=150, sections=90)
    mesh = Mesh(vertices_mm=np.asarray(made.vertices), faces=made.faces.astype(np.int32))
    limb = replace(cup(), mesh=mesh)
    assert measure_limb(limb, LimbMeasureOptions(spacing_mm=20)).skin == "only"


def test_the_command_measures_either_side_and_draws_the_wall(tmp_path: Path) -> None:
    scan, walls, table = tmp_path / "s.ply", tmp_path / "walls.png", tmp_path / "t.csv"
    write_limb(cup(2.0), scan)

    def printed_by(*words: str | Path) -> str:
        answer = CliRunner().invoke(app, ["measure", str(scan), *map(str, words)])
        assert answer.exit_code == 0, answer.output
        return answer.stdout

    outside = printed_by("--height", "80")
    assert "the OUTSIDE of a wall" in outside
    assert "2.00 mm thick where it is thinnest" in outside
    inside = printed_by("--height", "80", "--inside", "--csv", table, "--walls", walls)
    assert "the INSIDE of the wall" in inside
    assert f"{girth(INNER_MM):.1f}" in inside
    assert table.read_text().splitlines()[1].endswith(",inside,5.0")
    assert walls.read_bytes()[:4] == b"\x89PNG"
    tree = json.loads(printed_by("--height", "80", "--inside", "--json"))
    assert tree["skin"] == "inside"
    assert tree["wall"]["thinnest_mm"] == pytest.approx(2.0, abs=0.01)


def test_the_map_is_drawn_on_the_surface_whose_wall_was_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A crumb beside the wall is left out of the measures, its vertices and the sock of the map."""
    crumb, wall = trimesh.creation.icosphere(radius=3), cup(2.0).mesh
    crumb.apply_translation([120, 0, 75])
    mesh = Mesh(
        vertices_mm=np.concatenate([crumb.vertices, wall.vertices_mm]),
        faces=np.concatenate([crumb.faces, wall.faces + len(crumb.vertices)]).astype(np.int32),
    )
    drawn: list[tuple[Mesh, Thickness]] = []
    measured = wall_thickness(wall)
    assert measured is not None
    picture = wall_map(wall, measured)

    def kept(shown: Mesh, thickness: Thickness) -> Drawing:
        drawn.append((shown, thickness))
        return picture

    monkeypatch.setattr("limbgram.report.drawings.wall_thickness.wall_map", kept)
    for inside, sock_mm in ((False, None), (True, None), (False, 0.5)):
        ask = MeasureRequest(heights_mm=(80,), inside=inside, sock_mm=sock_mm)
        measure(replace(cup(2.0), mesh=mesh), ask, MeasureFiles(walls=tmp_path / "walls.png"))
        shown, thickness = drawn.pop()
        assert len(thickness.at_vertices_mm) == len(shown) == len(wall)
        width_mm = 2 * (OUTER_MM - (sock_mm or 0.0))
        assert np.ptp(shown.vertices_mm[:, 0]) == pytest.approx(width_mm, abs=0.01)


def test_a_crumb_beside_a_wall_is_neither_measured_nor_drawn(tmp_path: Path) -> None:
    plain = cup()
    crumb = trimesh.creation.box((4.0, 4.0, 0.5))
    mesh = Mesh(
        vertices_mm=np.concatenate(
            [crumb.vertices + np.array([90, 0, 50]), plain.mesh.vertices_mm]
        ),
        faces=np.concatenate([crumb.faces, plain.mesh.faces + len(crumb.vertices)]).astype(
            np.int32
        ),
    )
    limb = plain.with_mesh(mesh)
    alone, beside = (measure_inside(one, OPTIONS).wall for one in (plain, limb))
    assert alone is not None
    assert beside is not None
    assert beside.thinnest_mm == pytest.approx(alone.thinnest_mm)
    for inside in (True, False):
        picture = tmp_path / f"{inside}.png"
        ask = MeasureRequest(heights_mm=(50.3,), inside=inside)
        measure(limb, ask, MeasureFiles(walls=picture))
        assert picture.read_bytes()[:4] == b"\x89PNG"
