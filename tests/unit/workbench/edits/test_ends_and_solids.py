"""Ends, walls, filling, mirroring: against volumes and places known beforehand."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree
from tests.unit.workbench.edits.conftest import stump

from limbgram.core.errors import EditError
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    boundary_loops,
    is_edge_manifold,
    volume_mm3,
    with_faces,
)
from limbgram.findings import doubt, note
from limbgram.workbench.edits.distal_end import DistalEnd
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.extension import Extension
from limbgram.workbench.edits.fill import Fill
from limbgram.workbench.edits.flare import Flare
from limbgram.workbench.edits.load import Load
from limbgram.workbench.edits.mirror import Mirror
from limbgram.workbench.edits.offset import Offset
from limbgram.workbench.edits.plane_cut import PlaneCut
from limbgram.workbench.edits.thickness import wall_thickness
from limbgram.workbench.edits.wall import Wall
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.measuring import LimbMeasureOptions, measure_limb
from limbgram.workbench.recipe.recipe import Entry, Recipe, replay

RADIUS_MM, TOP_MM, SPOKES = 40.0, 160.0, 72

POLYGON_AREA = SPOKES / 2 * np.sin(2 * np.pi / SPOKES) * RADIUS_MM**2


def in_limb(limb: Limb) -> np.ndarray:
    return limb.frame.limb_from_mesh.apply(limb.mesh.vertices_mm)


def test_an_extension_goes_on_as_the_tube_does(limb: Limb) -> None:
    longer = do_edit(limb, Extension(length_mm=25))
    points = in_limb(longer)
    assert points[:, 2].max() == pytest.approx(TOP_MM + 25, abs=1e-9)
    new = points[len(limb.mesh) :]
    np.testing.assert_allclose(np.hypot(new[:, 0], new[:, 1]), RADIUS_MM, atol=0.05)
    gained = volume_mm3(longer.mesh) - volume_mm3(limb.mesh)
    assert gained == pytest.approx(25 * POLYGON_AREA, rel=2e-3)
    assert longer.mesh.filled is not None
    assert longer.mesh.filled.sum() == len(new)


def test_a_long_extension_of_a_fine_brim_stays_small(limb: Limb) -> None:
    fine = do_edit(limb, Flare(depth_mm=0.001, height_mm=2.0))
    (loop,) = boundary_loops(fine.mesh.faces)
    longer = do_edit(fine, Extension(length_mm=200.0))
    assert len(longer.mesh.faces) - len(fine.mesh.faces) == 100 * 2 * len(loop)
    assert in_limb(longer)[:, 2].max() == pytest.approx(TOP_MM + 200, abs=0.01)
    more = volume_mm3(longer.mesh) - volume_mm3(fine.mesh)
    assert more == pytest.approx(200 * POLYGON_AREA, rel=0.01)


def test_an_extension_levels_a_slanting_brim(limb: Limb) -> None:
    slanting = do_edit(limb, PlaneCut(height_mm=110, forward_deg=25))
    level = do_edit(slanting, Extension(length_mm=10))
    (rim,) = boundary_loops(level.mesh.faces)
    top = in_limb(slanting)[:, 2].max() + 10
    np.testing.assert_allclose(in_limb(level)[rim, 2], top, atol=1e-9)


def test_a_flare_opens_the_brim_by_its_depth(limb: Limb) -> None:
    bent = do_edit(limb, Flare(depth_mm=6, height_mm=20))
    points = in_limb(bent)
    radius = np.hypot(points[:, 0], points[:, 1])
    rim = points[:, 2] > TOP_MM - 1e-6
    assert radius[rim].max() == pytest.approx(RADIUS_MM + 6, abs=1e-6)
    expected = RADIUS_MM + 6 * np.clip(1 - (TOP_MM - points[:, 2]) / 20, 0, 1) ** 2
    tube = points[:, 2] > RADIUS_MM
    np.testing.assert_allclose(radius[tube], expected[tube], atol=0.06)


def test_the_distal_end_gets_longer_and_rounder(limb: Limb) -> None:
    longer = do_edit(limb, DistalEnd(height_mm=30, lengthen_mm=8))
    assert in_limb(longer)[:, 2].min() == pytest.approx(-8, abs=1e-9)
    above = in_limb(limb)[:, 2] >= 30
    np.testing.assert_allclose(
        longer.mesh.vertices_mm[above], limb.mesh.vertices_mm[above], atol=1e-9
    )
    square = do_edit(limb, PlaneCut(height_mm=50, keep="proximal", capped=True))
    points = in_limb(do_edit(square, DistalEnd(height_mm=40, roundness=1.0)))
    low = 50.0
    ends = points[points[:, 2] < low + 40 - 0.31 * 40]
    onto = (
        np.hypot(ends[:, 0], ends[:, 1]) ** 2 / RADIUS_MM**2 + ((low + 40 - ends[:, 2]) / 40) ** 2
    )
    np.testing.assert_allclose(onto, 1, atol=0.03)


@pytest.mark.parametrize(("side", "sign"), [("outward", 1), ("inward", -1)])
def test_a_wall_is_watertight_and_of_the_right_volume(limb: Limb, side: str, sign: int) -> None:
    solid = do_edit(limb, Wall(thickness_mm=4, side=side))  # pyright: ignore
    assert not boundary_loops(solid.mesh.faces)
    other = do_edit(limb, Offset(distance_mm=4.0 * sign))
    shell = sign * (volume_mm3(other.mesh) - volume_mm3(limb.mesh))
    assert volume_mm3(solid.mesh) == pytest.approx(shell, rel=1e-3)
    r, s = RADIUS_MM, RADIUS_MM + 4 * sign
    true = sign * np.pi * (2 / 3 * (s**3 - r**3) + 120 * (s**2 - r**2))
    assert volume_mm3(solid.mesh) == pytest.approx(true, rel=5e-3)
    with pytest.raises(EditError, match="closed"):
        do_edit(solid, Wall(thickness_mm=1))


def test_holes_are_filled_and_the_brim_only_if_asked(limb: Limb) -> None:
    middle = limb.mesh.vertices_mm[limb.mesh.faces].mean(1)
    away = np.linalg.norm(middle - limb.landmarks[0].position_mm, axis=1) > 8
    torn = limb.with_mesh(with_faces(limb.mesh, limb.mesh.faces[away]))
    mended = do_edit(torn, Fill())
    assert len(boundary_loops(torn.mesh.faces)) == 2
    assert len(boundary_loops(mended.mesh.faces)) == 1
    assert volume_mm3(mended.mesh) == pytest.approx(volume_mm3(limb.mesh), rel=1e-3)
    assert not boundary_loops(do_edit(torn, Fill(brim=True)).mesh.faces)
    with pytest.raises(EditError, match="no hole"):
        do_edit(limb, Fill())


def test_a_brim_is_closed_straight_across(limb: Limb) -> None:
    cut = do_edit(limb, Flare(depth_mm=10, height_mm=30))
    closed = do_edit(cut, Fill(brim=True))
    assert not boundary_loops(closed.mesh.faces)
    assert volume_mm3(closed.mesh) == pytest.approx(volume_mm3(cut.mesh), rel=1e-4)
    lid = in_limb(closed)[len(cut.mesh) :]
    assert len(lid) > 20
    np.testing.assert_allclose(lid[:, 2], TOP_MM, atol=0.1)


def test_a_brim_turned_over_is_closed_by_a_dome_and_said_so(limb: Limb) -> None:
    mesh = limb.mesh
    (loop,) = boundary_loops(mesh.faces)
    ahead, count = np.roll(loop, -1), len(mesh)
    out = count + np.arange(len(loop), dtype=np.int32)
    onward = np.roll(out, -1)
    flange = np.concatenate(
        [np.column_stack([ahead, loop, out]), np.column_stack([ahead, out, onward])]
    )
    wide = in_limb(limb)[loop] * np.array([1.25, 1.25, 1.0])
    places = np.concatenate([mesh.vertices_mm, limb.frame.limb_from_mesh.inverse.apply(wide)])
    hat = limb.with_mesh(Mesh(vertices_mm=places, faces=np.concatenate([mesh.faces, flange])))
    closed = do_edit(hat, Fill(brim=True))
    assert not boundary_loops(closed.mesh.faces)
    assert note("edit.fill.domed") in closed.notes
    assert volume_mm3(closed.mesh) > 1.02 * volume_mm3(hat.mesh)


def test_the_edge_of_a_loose_scrap_is_no_hole(limb: Limb) -> None:
    """Closed, a lone triangle would lie there twice; a hole in another piece is still filled."""
    mesh, last = limb.mesh, len(limb.mesh)
    inwards = 0.8 * mesh.vertices_mm[mesh.faces[300]] + 0.2 * mesh.vertices_mm.mean(0)
    scrap = np.arange(last, last + 3, dtype=np.int32)[None]
    both = replace(
        mesh,
        vertices_mm=np.concatenate([mesh.vertices_mm, inwards]),
        faces=np.concatenate([mesh.faces, scrap]),
    )
    with pytest.raises(EditError, match="no hole but the edges of loose scraps"):
        do_edit(limb.with_mesh(both), Fill())
    torn = replace(both, faces=np.delete(both.faces, 1000, axis=0))
    mended = do_edit(limb.with_mesh(torn), Fill()).mesh
    assert len(boundary_loops(mended.faces)) == 2
    assert volume_mm3(with_faces(mended, mended.faces[mended.faces.max(1) < last])) == (
        pytest.approx(volume_mm3(mesh), rel=1e-9)
    )


def test_a_hole_that_touches_itself_is_left_and_told(limb: Limb) -> None:
    """Two opposite triangles of the six round a vertex are gone; its two sheets part there."""
    mesh, vertex = limb.mesh, 1 + 20 * SPOKES
    gone = [np.array([1369, 1442, 1441]), np.array([1512, 1441, 1513])]
    faces = mesh.faces[[not any((face == one).all() for one in gone) for face in mesh.faces]]
    other = len(mesh)
    sheet = (faces == 1442).any(1) | (faces == 1514).any(1) | (faces == 1513).any(1)
    faces = np.where(sheet[:, None] & (faces == vertex), other, faces).astype(np.int32)
    places = np.concatenate([mesh.vertices_mm, mesh.vertices_mm[[vertex]]])
    torn = limb.with_mesh(replace(mesh, vertices_mm=places, faces=faces))
    assert [len(loop) for loop in boundary_loops(faces)] == [SPOKES, 6]
    with pytest.raises(EditError, match="only holes that touch themselves"):
        do_edit(torn, Fill())
    closed = do_edit(torn, Fill(brim=True))
    assert closed.notes == (doubt("edit.fill.left", count=1),)
    assert [len(loop) for loop in boundary_loops(closed.mesh.faces)] == [6]
    assert (closed.mesh.face_normals() != 0).any(1).all()


def test_a_mirror_swaps_sides_only_when_the_new_side_is_confirmed(limb: Limb) -> None:
    with pytest.raises(EditError, match='confirmed_side = "left"'):
        do_edit(limb, Mirror(confirmed_side="right"))
    other = do_edit(limb, Mirror(confirmed_side="left"))
    assert other.frame.side == "left"
    np.testing.assert_allclose(in_limb(other), in_limb(limb) * [-1, 1, 1], atol=1e-9)
    marks = other.frame.limb_from_mesh.apply(
        np.stack([mark.position_mm for mark in other.landmarks])
    )
    np.testing.assert_allclose(marks, [[0, RADIUS_MM, 100], [-RADIUS_MM, 0, 100]], atol=1e-9)
    assert volume_mm3(other.mesh) == pytest.approx(volume_mm3(limb.mesh), rel=1e-12)
    again = do_edit(other, Mirror(confirmed_side="right"))
    np.testing.assert_allclose(again.mesh.vertices_mm, limb.mesh.vertices_mm, atol=1e-9)
    unsure = replace(limb, frame=replace(limb.frame, side="none"))
    with pytest.raises(EditError, match="nobody has said"):
        do_edit(unsure, Mirror(confirmed_side="left"))


def test_a_mirrored_limb_measures_as_the_limb_did_where_relief_is_lost_obliquely(
    limb: Limb,
) -> None:
    outward = in_limb(limb) * [1, 1, 0] / RADIUS_MM
    oblique = np.cos(np.radians(30)) * np.cross([0, 0, 1], outward) + [0, 0, 0.5]
    lost = replace(
        limb.mesh,
        sigma_mm=np.full(len(limb.mesh), 0.05, np.float32),
        lost_length=np.tile(np.float32([0.002, 0.0002]), (len(limb.mesh), 1)),
        lost_across=(0.002 * oblique @ limb.frame.limb_from_mesh.rotation).astype(np.float32),
    )
    scanned = limb.with_mesh(lost)

    def tape_mm(one: Limb) -> float:
        (row,) = measure_limb(one, LimbMeasureOptions(heights_mm=(100.0,))).rows
        return row.figures["tape_mm"].value

    mirrored = do_edit(scanned, Mirror(confirmed_side="left"))
    assert tape_mm(mirrored) == pytest.approx(tape_mm(scanned), abs=1e-3)
    assert tape_mm(mirrored) > tape_mm(limb) + 0.2


def test_a_wall_says_where_it_is_thinnest(limb: Limb) -> None:
    made = do_edit(limb, Wall(thickness_mm=4))
    assert made.notes[-1].code == "edit.wall.thickness"
    found = wall_thickness(made.mesh)
    assert found is not None
    assert found.thinnest_mm == pytest.approx(4, abs=0.1)
    thin = do_edit(limb, Wall(thickness_mm=1.5))
    assert any(one.code == "edit.wall.unstudied" for one in thin.notes)


def test_a_wall_thinner_than_can_be_made_is_refused(limb: Limb) -> None:
    with pytest.raises(EditError, match=r"1 mm or more, not 0\.2"):
        do_edit(limb, Wall(thickness_mm=0.2))
    made = do_edit(limb, Wall(thickness_mm=0.2, least_mm=0.1))
    assert wall_thickness(made.mesh) is not None
    with pytest.raises(EditError, match="above 0 and up to 2000 mm"):
        do_edit(limb, Wall(thickness_mm=0.2, least_mm=0))


@pytest.mark.parametrize("side", ["outward", "inward"])
@pytest.mark.parametrize(("wide", "told"), [(2, True), (8, False)])
def test_a_tongue_of_the_edge_that_is_narrower_than_the_wall_is_told(
    side: str, wide: int, told: bool
) -> None:
    """It stands 8 mm out of the brim; its sides are radial, so it is narrowest at the inner skin.
    From skin to skin the wall is nowhere thinner than asked."""
    mesh = stump(144, 2.0)
    x, y, z = np.moveaxis(mesh.vertices_mm[mesh.faces], 2, 0)
    half_deg = 360 / 144 * wide / 2
    beside = np.abs(np.degrees(np.arctan2(y, x))).max(1) > half_deg + 0.01
    tongued = with_faces(mesh, mesh.faces[~(beside & (z.min(1) > TOP_MM - 8.1))])
    made = do_edit(Limb(mesh=tongued), Wall(thickness_mm=5, side=side))
    thickness = next(one for one in made.notes if one.code == "edit.wall.thickness")
    assert thickness.values["thinnest_mm"] > 4.95
    strips = [one for one in made.notes if one.code == "edit.wall.narrow"]
    assert bool(strips) is told
    if told:
        inner_mm = RADIUS_MM if side == "outward" else RADIUS_MM - 5
        across_mm = 2 * inner_mm * np.sin(np.radians(half_deg))
        assert across_mm < strips[0].values["width_mm"] < across_mm * (1 + 1.5 / inner_mm)
        x_mm, y_mm, z_mm = strips[0].values["point_mm"]
        assert inner_mm - 0.1 < x_mm < inner_mm + 1
        assert abs(y_mm) == pytest.approx(across_mm / 2, abs=0.1)
        assert TOP_MM - 8 < z_mm < TOP_MM


def ragged(limb: Limb, depth_mm: float) -> Limb:
    """Every second place of the brim bent inward, as the torn edge of a scan."""
    border = np.unique(boundary_half_edges(limb.mesh.faces))
    points = limb.frame.limb_from_mesh.apply(limb.mesh.vertices_mm)
    points[border[::2], :2] *= 1 - depth_mm / RADIUS_MM
    points[border[::2], 2] += 1.0
    vertices = limb.frame.limb_from_mesh.inverse.apply(points)
    return replace(limb, mesh=limb.mesh.with_vertices(vertices))


@pytest.mark.slow
def test_a_ragged_brim_is_cut_before_it_becomes_a_wall(limb: Limb) -> None:
    torn = ragged(limb, 4.0)
    with pytest.raises(EditError, match="cut it by a plane"):
        do_edit(torn, Wall(thickness_mm=3))
    heights = limb.frame.limb_from_mesh.apply(limb.mesh.vertices_mm)[:, 2]
    cut = do_edit(torn, PlaneCut(height_mm=float(heights.max()) - 12))
    assert do_edit(cut, Wall(thickness_mm=3)).notes[-1].code == "edit.wall.thickness"


@pytest.mark.slow
def test_a_brim_of_teeth_becomes_a_wall_without_them() -> None:
    """As a scan's own edge: most triangles along the brim stand out of it, each by itself."""
    mesh = stump(144, 2.0)
    height = mesh.vertices_mm[mesh.faces][:, :, 2]
    upper = (height == TOP_MM).sum(1) == 2  # the triangles that have a side on the brim
    gone = upper & (np.random.default_rng(3).random(len(upper)) < 0.7)
    torn = with_faces(mesh, mesh.faces[~gone])
    made = do_edit(Limb(mesh=torn), Wall(thickness_mm=3))
    assert is_edge_manifold(made.mesh.faces)
    assert not len(boundary_half_edges(made.mesh.faces))
    found = wall_thickness(made.mesh)
    assert found is not None
    assert found.thinnest_mm == pytest.approx(3, abs=0.05)
    left_mm2 = made.notes[0].values["area_mm2"]
    row_mm2 = 2 * np.pi * RADIUS_MM * 2.0
    assert 0.1 * row_mm2 < left_mm2 < 2 * row_mm2
    assert made.notes[0].code == "edit.wall.trimmed"


@pytest.mark.slow
def test_teeth_of_a_part_of_an_open_edge_cost_nothing_elsewhere() -> None:
    """A tube that is open at both ends; 60 degrees of its upper edge are teeth, the lower is cut
    level."""
    mesh = stump(144, 2.0)
    x, y, z = np.moveaxis(mesh.vertices_mm[mesh.faces], 2, 0)
    toothed = np.abs(np.arctan2(y, x)).max(1) < np.radians(30)
    upper = toothed & ((z == TOP_MM).sum(1) == 2)
    gone = upper & (np.random.default_rng(3).random(len(upper)) < 0.7)
    torn = with_faces(mesh, mesh.faces[~gone & (z > RADIUS_MM - 0.1).all(1)])
    made = do_edit(Limb(mesh=torn), Wall(thickness_mm=6))
    left_out = made.notes[0]
    assert left_out.code == "edit.wall.trimmed"
    row_mm2 = np.radians(60) * RADIUS_MM * 2.0
    assert 0.1 * row_mm2 < left_out.values["area_mm2"] < 2 * row_mm2
    x, y, z = torn.vertices_mm.T
    sound = (z == TOP_MM) & (np.abs(np.arctan2(y, x)) > np.radians(45))
    assert KDTree(made.mesh.vertices_mm).query(torn.vertices_mm[sound])[0].max() == 0
    brim = made.mesh.faces[unit(made.mesh.face_normals())[:, 2] < -np.sqrt(0.5)]
    heights_mm = made.mesh.vertices_mm[brim, 2]
    np.testing.assert_allclose(heights_mm[heights_mm.min(1) < RADIUS_MM + 3], RADIUS_MM, atol=0.01)


@pytest.mark.slow
def test_an_open_edge_that_is_crumpled_deeply_loses_no_more_than_its_crumples() -> None:
    """The uppermost 12 mm of 18 degrees of the tube are waves too tight for the wall."""
    mesh = stump(144, 2.0)
    x, y, z = mesh.vertices_mm.T
    crumpled = np.exp(-((np.arctan2(y, x) / 0.15) ** 4)) * (z > TOP_MM - 13)
    waves = 1 - 3 / RADIUS_MM * crumpled * np.cos(np.pi * np.round(z / 2))
    torn = mesh.with_vertices(mesh.vertices_mm * np.column_stack([waves, waves, 0 * z + 1]))
    made = do_edit(Limb(mesh=torn), Wall(thickness_mm=3))
    assert is_edge_manifold(made.mesh.faces)
    assert not len(boundary_half_edges(made.mesh.faces))
    left_out = made.notes[0]
    assert left_out.code == "edit.wall.trimmed"
    crumples = with_faces(torn, torn.faces[(crumpled > 0.1)[torn.faces].any(1)])
    assert 0 < left_out.values["area_mm2"] < crumples.area_mm2()
    sound_mm = torn.vertices_mm[(z == TOP_MM) & (np.abs(np.arctan2(y, x)) > np.radians(45))]
    assert KDTree(made.mesh.vertices_mm).query(sound_mm)[0].max() == 0
    found = wall_thickness(made.mesh)
    assert found is not None
    assert 2 < found.thinnest_mm <= 3.01
    assert found.median_mm == pytest.approx(3, abs=0.02)


@pytest.mark.parametrize(
    ("spokes", "deep_mm", "wide"),
    [pytest.param(288, 12.0, 0.07, marks=pytest.mark.slow), (144, 8.0, 0.1)],
)
def test_a_slit_is_filled_where_a_wall_has_no_room_in_it(
    spokes: int, deep_mm: float, wide: float
) -> None:
    """Along the limb, 3 mm round its ground; 8 mm of wall go round the tube over it."""
    mesh = stump(spokes, 288 / spokes)
    x, y, z = mesh.vertices_mm.T
    deep = deep_mm * np.exp(-((np.arctan2(y, x) / wide) ** 2)) * np.exp(-(((z - 90) / 25) ** 4))
    inward = np.column_stack([1 - deep / RADIUS_MM, 1 - deep / RADIUS_MM, np.ones(len(z))])
    grooved = mesh.with_vertices(mesh.vertices_mm * inward)
    made = do_edit(Limb(mesh=grooved), Wall(thickness_mm=8, least_mm=7.9))
    assert not len(boundary_half_edges(made.mesh.faces))
    thickness = next(one for one in made.notes if one.code == "edit.wall.thickness")
    assert 7.95 < thickness.values["thinnest_mm"] <= 8
    filled = next(one for one in made.notes if one.code == "edit.wall.solid")
    x_mm, y_mm, z_mm = filled.values["point_mm"]
    assert 25 < x_mm < 40
    assert abs(y_mm) < 4
    assert 60 < z_mm < 120
    added = (8 * 2 * np.pi * 44 * 120) + 2 / 3 * np.pi * (48**3 - 40**3)
    slit = volume_mm3(mesh) - volume_mm3(grooved)
    assert added < volume_mm3(made.mesh) < added + slit


def test_a_wall_that_a_later_edit_thins_is_refused(limb: Limb) -> None:
    inward = Entry(edit=Wall(thickness_mm=4, side="inward"))
    kept = Load(at="front", depth_mm=2.0, flat_mm=6.0, falloff_mm=10.0)
    meant = ("load on unknown place",)
    replay(Recipe(name="x", entries=(inward, Entry(edit=kept, accept=meant))), limb)
    thinning = Entry(edit=replace(kept, depth_mm=3.4), accept=meant)
    with pytest.raises(EditError, match=r"Edit 2 .*0\.6\d mm thick where it is thinnest"):
        replay(Recipe(name="x", entries=(inward, thinning)), limb)
