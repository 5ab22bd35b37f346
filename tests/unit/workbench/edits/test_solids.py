"""What was a solid stays one, and a brim that was cut level stays level: against known shapes."""

from dataclasses import replace

import numpy as np
import pytest
from tests.unit.workbench.edits.conftest import RADIUS_MM, TOP_MM, stump
from tests.unit.workbench.edits.test_cutting import wave

from limbgram.core.errors import EditError
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.folds import find_bent
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    enclosed_by,
    face_components,
    is_edge_manifold,
    is_vertex_manifold,
    is_watertight,
    volume_mm3,
    with_faces,
)
from limbgram.reconstruction.surface.cleaning import largest_manifold
from limbgram.workbench.edits.closing import closed_again
from limbgram.workbench.edits.edit import Edit, name_of
from limbgram.workbench.edits.editing import EDITS, do_edit
from limbgram.workbench.edits.fill import Fill
from limbgram.workbench.edits.membrane import with_openings_spanned
from limbgram.workbench.edits.plane_cut import PlaneCut
from limbgram.workbench.edits.thickness import wall_thickness
from limbgram.workbench.edits.trimline import Trimline
from limbgram.workbench.edits.wall import Wall
from limbgram.workbench.limb import Limb
from limbgram.workbench.recipe.file import make_edit
from limbgram.workbench.recipe.recipe import Entry, Recipe, replay

WALL_MM = 4.0
OUTER_MM = RADIUS_MM + WALL_MM


def require_one_sound_solid(solid: Mesh) -> None:
    assert is_edge_manifold(solid.faces)
    assert is_vertex_manifold(solid.faces)
    assert not len(boundary_half_edges(solid.faces))
    assert int(face_components(solid.faces).max()) == 0
    every = np.ones(len(solid.faces), np.bool_)
    assert not len(find_crossings(solid.vertices_mm, solid.faces, every))
    assert not len(find_bent(solid, every))


def in_limb(limb: Limb) -> np.ndarray:
    return limb.frame.limb_from_mesh.apply(limb.mesh.vertices_mm)


def shell_mm3(height_mm: float) -> float:
    """Of the stump's wall, outward, below a height in its tube."""
    dome = 2 / 3 * np.pi * (OUTER_MM**3 - RADIUS_MM**3)
    return dome + np.pi * (OUTER_MM**2 - RADIUS_MM**2) * (height_mm - RADIUS_MM)


@pytest.fixture(scope="module")
def solid(limb: Limb) -> Limb:
    return do_edit(limb, Wall(thickness_mm=WALL_MM))


@pytest.mark.parametrize("keep", ["distal", "proximal"])
def test_a_wall_cut_level_has_a_flat_ring_for_a_rim(solid: Limb, keep: str) -> None:
    cut = do_edit(solid, PlaneCut(height_mm=101.3, keep=keep))  # pyright: ignore
    require_one_sound_solid(cut.mesh)
    true = shell_mm3(101.3) if keep == "distal" else shell_mm3(TOP_MM) - shell_mm3(101.3)
    assert volume_mm3(cut.mesh) == pytest.approx(true, rel=4e-3)
    upright = cut.mesh.with_vertices(in_limb(cut))
    normals = upright.face_normals()
    level = np.abs(upright.vertices_mm[:, 2][upright.faces] - 101.3).max(1) < 1e-6
    looks_up = 1.0 if keep == "distal" else -1.0
    ring_mm2 = float((normals[level, 2] * looks_up).sum()) / 2
    assert ring_mm2 == pytest.approx(np.pi * (OUTER_MM**2 - RADIUS_MM**2), rel=4e-3)


def test_a_wall_cut_aslant_is_as_large_as_one_cut_level_at_its_middle(solid: Limb) -> None:
    cut = do_edit(solid, PlaneCut(height_mm=100.0, forward_deg=25.0, right_deg=-10.0))
    require_one_sound_solid(cut.mesh)
    assert volume_mm3(cut.mesh) == pytest.approx(shell_mm3(100.0), rel=4e-3)


def test_a_trimline_goes_straight_through_a_wall(solid: Limb) -> None:
    whole_mm3 = volume_mm3(solid.mesh)
    parts_mm3: list[float] = []
    for keep in ("distal", "proximal"):
        cut = do_edit(solid, Trimline(through=wave(), keep=keep))
        require_one_sound_solid(cut.mesh)
        parts_mm3.append(volume_mm3(cut.mesh))
        thickness = wall_thickness(cut.mesh)
        assert thickness is not None
        assert thickness.thinnest_mm == pytest.approx(WALL_MM, abs=0.05)
    assert sum(parts_mm3) == pytest.approx(whole_mm3, rel=1e-3)
    assert parts_mm3[0] == pytest.approx(shell_mm3(110.0), rel=5e-3)  # the wave's mean height


def test_a_trimline_is_drawn_on_the_outside_whichever_side_its_points_lie_on(
    solid: Limb,
) -> None:
    """A landmark lies on the skin, which is the inside of a socket over it."""
    outside = np.array(wave()) * [OUTER_MM / RADIUS_MM, OUTER_MM / RADIUS_MM, 1.0]
    mixed = tuple(
        tuple(map(float, one if k % 2 else two))
        for k, (one, two) in enumerate(zip(outside, wave(), strict=True))
    )
    cut = do_edit(solid, Trimline(through=mixed))  # pyright: ignore
    require_one_sound_solid(cut.mesh)
    assert volume_mm3(cut.mesh) == pytest.approx(shell_mm3(110.0), rel=5e-3)


@pytest.mark.parametrize(
    "cut", [PlaneCut(height_mm=100.0), Trimline(through=wave()), PlaneCut(height_mm=70.0)]
)
def test_a_positive_that_is_cut_is_closed_across(limb: Limb, cut: Edit) -> None:
    positive = do_edit(limb, Fill(brim=True))
    after = do_edit(positive, cut)
    require_one_sound_solid(after.mesh)
    height_mm = 110.0 if isinstance(cut, Trimline) else cut.height_mm  # pyright: ignore
    true = 2 / 3 * np.pi * RADIUS_MM**3 + np.pi * RADIUS_MM**2 * (height_mm - RADIUS_MM)
    assert volume_mm3(after.mesh) == pytest.approx(true, rel=6e-3)


@pytest.mark.parametrize("kind", EDITS, ids=lambda kind: kind.__name__)
def test_every_edit_of_a_solid_leaves_a_solid_or_is_refused(solid: Limb, kind: type[Edit]) -> None:
    edit = make_edit(name_of(kind), kind.about.example, "the test")
    try:
        after = do_edit(solid, edit)
    except EditError:
        return
    assert is_watertight(after.mesh.faces)


def test_an_edit_that_leaves_no_surface_of_a_solid_is_refused(solid: Limb) -> None:
    none = replace(solid.mesh, faces=solid.mesh.faces[:0])
    with pytest.raises(EditError) as refused:
        closed_again(solid.mesh, none)
    assert refused.value.finding.code == "edit.branches"


def test_each_reply_says_whether_the_shape_is_watertight_and_what_it_holds(limb: Limb) -> None:
    entries = (Entry(edit=PlaneCut(height_mm=120.0)), Entry(edit=Wall(thickness_mm=WALL_MM)))
    lines = replay(Recipe(name="x", entries=entries), limb).ledger.lines
    opened, closed = (line.told[-1] for line in lines)
    assert opened.code == closed.code == "edit.enclosed"
    assert not opened.values["watertight"]
    assert opened.values["open_edges"] == 72
    positive_ml = (2 / 3 * RADIUS_MM**3 + RADIUS_MM**2 * (120 - RADIUS_MM)) * np.pi / 1000
    assert opened.values["volume_ml"] == pytest.approx(positive_ml, rel=5e-3)
    assert closed.values["watertight"]
    assert closed.values["open_edges"] == 0
    assert closed.values["volume_ml"] == pytest.approx(shell_mm3(120.0) / 1000, rel=5e-3)


def test_a_cut_branching_surface_is_not_watertight() -> None:
    box = _box(2.0, 0.0)
    assert enclosed_by(Mesh(vertices_mm=box.vertices_mm, faces=box.faces)).watertight
    twice = np.concatenate([box.faces, box.faces[:, ::-1]])
    assert not is_watertight(twice)
    assert not is_watertight(box.faces[:-1])
    assert not is_watertight(box.faces[:0])


def _box(size_mm: float, at_mm: float) -> Mesh:
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float64)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]
    return Mesh(vertices_mm=at_mm + size_mm * corners, faces=np.array(faces, np.int32))


def widened(limb: Limb, slope_deg: float, flat: float) -> Limb:
    """The stump as a cone above its dome, of an elliptic section."""
    mesh = stump(96, 3.0)
    wide = 1 + np.tan(np.radians(slope_deg)) * np.maximum(mesh.vertices_mm[:, 2] - 40, 0) / 40
    places = mesh.vertices_mm * np.column_stack([wide, flat * wide, np.ones(len(wide))])
    return limb.with_mesh(mesh.with_vertices(limb.frame.limb_from_mesh.inverse.apply(places)))


BRIMS = [(0, 1.0, 0), (12, 1.0, 0), (-12, 1.0, 0), (25, 0.8, 0), (0, 0.75, 15), (8, 0.75, 12)]
"""Slope of the wall and tilt of the cut, degrees, and the section's flatness between them."""
WALLS = [("outward", 2.0), ("inward", 8.0), ("inward", 2.0), ("outward", 8.0)]


@pytest.mark.parametrize(
    ("slope_deg", "flat", "forward_deg", "thickness_mm", "side"),
    [
        pytest.param(*brim, thickness_mm, side, marks=[pytest.mark.slow] * ((k + j // 2) % 2))
        for k, brim in enumerate(BRIMS)
        for j, (side, thickness_mm) in enumerate(WALLS)
    ],
)
def test_a_brim_is_level_where_it_was_cut_level(
    limb: Limb, slope_deg: float, flat: float, forward_deg: float, thickness_mm: float, side: str
) -> None:
    cut = do_edit(
        widened(limb, slope_deg, flat), PlaneCut(height_mm=120.3, forward_deg=forward_deg)
    )
    made = do_edit(cut, Wall(thickness_mm=thickness_mm, side=side))  # pyright: ignore
    assert is_watertight(made.mesh.faces)
    thickness = next(one for one in made.notes if one.code == "edit.wall.thickness")
    assert thickness.values["thinnest_mm"] > thickness_mm - 0.05
    normal = np.array([0.0, np.tan(np.radians(forward_deg)), 1.0])
    upright = made.mesh.with_vertices(in_limb(made))
    (normal,) = unit(normal[None])
    level_mm = float((in_limb(cut) @ normal).max())
    heights = upright.vertices_mm @ normal
    rim = unit(upright.face_normals()) @ normal > 0.95
    rim &= (heights > level_mm - 1.0)[upright.faces].all(1)
    assert np.abs(heights[upright.faces[rim]] - level_mm).max() < 0.01
    if flat == 1.0:
        skin_mm = RADIUS_MM * (1 + np.tan(np.radians(slope_deg)) * (level_mm - 40) / 40)
        across_mm = thickness_mm / np.cos(np.radians(slope_deg))
        other_mm = skin_mm + (across_mm if side == "outward" else -across_mm)
        ring_mm2 = float(np.linalg.norm(upright.face_normals()[rim], axis=1).sum()) / 2
        assert ring_mm2 == pytest.approx(np.pi * abs(other_mm**2 - skin_mm**2), rel=0.02)
    assert heights.max() < level_mm + 0.01


def test_a_brim_that_a_wall_cannot_end_level_in_is_told(limb: Limb) -> None:
    """Plane and skin meet at 45 degrees: an edge as acute would be a lip."""
    cut = do_edit(widened(limb, 25, 1.0), PlaneCut(height_mm=100.0, forward_deg=20.0))
    made = do_edit(cut, Wall(thickness_mm=4.0))
    told = next(one for one in made.notes if one.code == "edit.wall.aslant")
    assert 2.0 < told.values["off_mm"] < 4.0  # 4 mm x sin 45 degrees where it is steepest
    again = do_edit(made, PlaneCut(height_mm=98.0, forward_deg=20.0))
    assert is_watertight(again.mesh.faces)


def ragged(mesh: Mesh, seed: int) -> Mesh:
    """Most triangles along the open edge are gone, each by itself."""
    at = np.zeros(len(mesh), np.bool_)
    at[boundary_half_edges(mesh.faces)] = True
    gone = (at[mesh.faces].sum(1) == 2) & (
        np.random.default_rng(seed).random(len(mesh.faces)) < 0.7
    )
    return with_faces(mesh, largest_manifold(mesh.vertices_mm, mesh.faces[~gone]))


def test_a_ragged_opening_is_spanned_without_folds() -> None:
    mesh = ragged(stump(288, 1.0), 5)
    closed = with_openings_spanned(mesh)
    closed = with_faces(closed, closed.faces)
    assert is_watertight(closed.faces)
    np.testing.assert_array_equal(closed.faces[: len(mesh.faces)], mesh.faces)
    new = np.arange(len(closed.faces)) >= len(mesh.faces)
    assert not len(find_bent(closed, new))
    assert not len(find_crossings(closed.vertices_mm, closed.faces, new))
    true = (2 / 3 * RADIUS_MM**3 + RADIUS_MM**2 * (TOP_MM - RADIUS_MM)) * np.pi
    assert volume_mm3(closed) == pytest.approx(true, rel=0.01)


@pytest.mark.parametrize("name", ["relieve", "load", "room", "pad"])
def test_what_gives_room_or_pressure_is_not_done_to_the_inside_of_a_wall(
    solid: Limb, name: str
) -> None:
    """Its outward side faces the limb: what relieves a positive would press."""
    size = (
        {"falloff_mm": 15.0} if name in ("relieve", "load") else {"width_mm": 30, "height_mm": 30}
    )
    for at, refused in (("front", True), ([0.0, OUTER_MM, 100.0], False)):
        edit = make_edit(name, {"at": at, "depth_mm": 1.0, **size}, "the test")
        if not refused:
            do_edit(solid, edit)
            continue
        with pytest.raises(EditError) as found:
            do_edit(solid, edit)
        assert found.value.finding.code == "edit.region.inside"
