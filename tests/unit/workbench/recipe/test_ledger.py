"""The ledger's girths, as printed, are those of the shape at the heights that are printed."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.edits.edit import Edit, name_of
from limbgram.workbench.edits.editing import EDITS, do_edit
from limbgram.workbench.edits.extension import Extension
from limbgram.workbench.edits.fill import Fill
from limbgram.workbench.edits.flare import Flare
from limbgram.workbench.edits.mirror import Mirror
from limbgram.workbench.edits.offset import Offset
from limbgram.workbench.edits.plane_cut import PlaneCut
from limbgram.workbench.edits.reduction import Reduction
from limbgram.workbench.edits.relieve import Relieve
from limbgram.workbench.edits.repose import Repose
from limbgram.workbench.edits.trimline import Trimline
from limbgram.workbench.edits.wall import Wall
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame
from limbgram.workbench.measures.measuring import LimbMeasureOptions, measure_limb
from limbgram.workbench.recipe.file import make_edit
from limbgram.workbench.recipe.ledger import (
    SPACING_MM,
    choose_levels,
    covers_after,
    cut_cover,
    lines_of,
)
from limbgram.workbench.recipe.recipe import Entry, Recipe, replay

SIDES, SPOKES = 256, 120
RECIPE = Recipe(name="none", entries=(Entry(edit=Offset(distance_mm=1.0)),))
AS_PRINTED = re.compile(r"(\d+(?:\.\d+)?): (\d+\.\d)")


def cone(radius_mm: float, high_mm: float) -> Limb:
    """A radius that falls by 0.45 mm a millimetre: 0.1 mm of height shows in the girth."""
    made = trimesh.creation.cone(radius_mm, high_mm, sections=SIDES)
    mesh = Mesh(vertices_mm=np.asarray(made.vertices), faces=made.faces.astype(np.int32))
    return AlignedLimb(mesh=mesh, frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="left"))


def test_printed_girths_are_found_by_measuring_at_the_printed_heights() -> None:
    limb = cone(60.0, 133.3)
    done = replay(RECIPE, limb)
    told = "".join(line for line in lines_of(done.ledger) if "contour" in line or "most" in line)
    printed = [(float(level), float(girth)) for level, girth in AS_PRINTED.findall(told)]
    assert [height for height, _ in printed[:6]] == [20.0, 40.0, 60.0, 80.0, 100.0, 120.0]
    options = LimbMeasureOptions(heights_mm=tuple(height for height, _ in printed))
    for (_, girth), row in zip(printed, measure_limb(done.limb, options).rows, strict=True):
        found = row.figures["contour_mm"]
        assert found is not None
        assert girth == pytest.approx(found.value, abs=0.0501)


def test_girths_before_the_edit_are_the_cones() -> None:
    limb = cone(60.0, 133.3)
    ledger = replay(RECIPE, limb).ledger
    table = measure_limb(limb, LimbMeasureOptions(spacing_mm=SPACING_MM))
    assert list(ledger.levels_mm) == [row.height_mm for row in table.rows]
    for level, girth in zip(ledger.levels_mm, ledger.lines[0].before.girths_mm, strict=True):
        radius = 60 * (1 - level / 133.3)
        stays = 1 / (1 + (5 / (2 * math.pi * radius)) ** 4)  # of the circle as a wave
        smooth = 2 * math.pi * radius * stays * (1 - (math.pi / SIDES) ** 2 / 3)
        assert girth == pytest.approx(smooth, rel=5e-5)


@pytest.mark.parametrize("edit", [Extension(length_mm=30.0), Fill(brim=True)])
def test_what_only_adds_surface_has_a_volume_and_no_displacement(edit: Extension | Fill) -> None:
    """Beyond the brim there is no outside and inside of the old surface."""
    made = trimesh.creation.cylinder(40.0, 100.0, sections=SIDES)
    cup = made.faces[made.face_normals[:, 2] < 0.5].astype(np.int32)
    limb = replace(cone(1, 1), mesh=Mesh(vertices_mm=np.asarray(made.vertices), faces=cup))
    done = replay(Recipe(name="more", entries=(Entry(edit=edit),)), limb)
    (line,) = done.ledger.lines
    assert line.displacement is None
    assert line.extreme is None
    area = SIDES / 2 * math.sin(2 * math.pi / SIDES) * 40**2
    longer_mm = 30 if isinstance(edit, Extension) else 0
    assert line.after.volume_ml == pytest.approx((100 + longer_mm) * area / 1000, rel=0.07)
    assert not any("largest" in told for told in lines_of(done.ledger))


@pytest.mark.parametrize(
    ("edits", "volume_mm3"),
    [
        ([PlaneCut(height_mm=50.0, capped=True)], 40**2 * 50),
        ([Wall(thickness_mm=4.0)], 44**2 * 104 - 40**2 * 100),
        ([Wall(thickness_mm=4.0, side="inward")], 40**2 * 100 - 36**2 * 96),
        ([Wall(thickness_mm=4.0), PlaneCut(height_mm=50.0)], 44**2 * 54 - 40**2 * 50),
    ],
    ids=lambda one: " ".join(type(edit).title for edit in one) if isinstance(one, list) else "",
)
def test_a_cut_and_a_wall_neither_press_nor_give_room(edits: list[Edit], volume_mm3: float) -> None:
    """The cover of a cut, its rim in a wall, and a wall's second surface are no skin that moved."""
    made = trimesh.creation.cylinder(
        40.0,
        100.0,
        sections=SIDES,
        transform=trimesh.transformations.translation_matrix([0, 0, 50]),
    )
    cup = made.faces[made.face_normals[:, 2] < 0.5].astype(np.int32)
    limb = replace(cone(1, 1), mesh=Mesh(vertices_mm=np.asarray(made.vertices), faces=cup))
    done = replay(Recipe(name="cut", entries=tuple(Entry(edit=one) for one in edits)), limb)
    told = lines_of(done.ledger)
    assert [line.displacement for line in done.ledger.lines] == [None] * len(edits)
    assert not any("largest" in one or "gives pressure" in one for one in told)
    last = done.ledger.lines[-1].after
    assert last.volume_ml == pytest.approx(math.pi * volume_mm3 / 1000, rel=0.02)


def cup(radius_mm: float, high_mm: float, step_mm: float = 5.0) -> Limb:
    """A tube with a flat bottom at 0, open above."""
    rows, spokes = round(high_mm / step_mm) + 1, SPOKES
    angle = np.arange(spokes) * 2 * np.pi / spokes
    z = np.repeat(np.linspace(0.0, high_mm, rows), spokes)
    ring = radius_mm * np.column_stack([np.cos(angle), np.sin(angle)])
    points = np.column_stack([np.tile(ring, (rows, 1)), z])
    a = np.arange((rows - 1) * spokes).reshape(rows - 1, spokes)
    b = np.roll(a, -1, axis=1)
    wall = np.stack([a, b, b + spokes, a, b + spokes, a + spokes], -1).reshape(-1, 3)
    middle = len(points)
    bottom = np.column_stack([np.roll(a[0], -1), a[0], np.full(spokes, middle)])
    points = np.vstack([points, [0.0, 0.0, 0.0]])
    mesh = Mesh(vertices_mm=points, faces=np.vstack([wall, bottom]).astype(np.int32))
    return AlignedLimb(mesh=mesh, frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="left"))


def test_the_ledger_tells_the_girth_where_an_edit_moved_most() -> None:
    """A relief of 2 mm at 70 mm fades over 8 mm: the levels at 60 and 80 mm do not show it."""
    relief = Relieve(depth_mm=2.0, falloff_mm=8.0, at=(50.0, 0.0, 70.0))
    ledger = replay(Recipe(name="room", entries=(Entry(edit=relief),)), cup(50.0, 200.0)).ledger
    (line,) = ledger.lines
    for level, before, after in zip(
        ledger.levels_mm, line.before.girths_mm, line.after.girths_mm, strict=True
    ):
        assert before is not None
        assert after == pytest.approx(before, abs=0.05), level
    assert line.extreme is not None
    assert line.extreme.height_mm == pytest.approx(70.0, abs=1.0)
    assert line.extreme.before_mm == pytest.approx(2 * math.pi * 50, rel=1e-3)
    assert line.extreme.after_mm is not None
    grown = line.extreme.after_mm - line.extreme.before_mm
    assert 0.2 < grown < 2.0  # a bump of 2 mm, 16 mm wide, seen at a smoothing length of 5 mm
    assert any("where it moved most: 70" in told for told in lines_of(ledger))


def test_volumes_are_compared_between_the_same_two_heights() -> None:
    """A reduction of the girth by 3 %, then a trimline that dips to 150 mm in front."""
    angles = np.radians(np.arange(0, 360, 15))
    through = tuple(
        (48.5 * math.cos(a), 48.5 * math.sin(a), 170.0 - 20.0 * math.sin(a)) for a in angles
    )
    reduced = Reduction(heights_mm=(0.0, 200.0), per_cent=(3.0, 3.0), of="girth")
    entries = (Entry(edit=reduced), Entry(edit=Trimline(through=through)))
    ledger = replay(Recipe(name="socket", entries=entries), cup(50.0, 200.0)).ledger
    first, second = ledger.lines
    area_mm2 = SPOKES / 2 * math.sin(2 * math.pi / SPOKES) * 50.0**2
    assert first.volume is not None
    assert first.volume.low_mm is None
    assert first.volume.high_mm == pytest.approx(200.0, abs=1e-6)
    assert first.volume.before_ml == pytest.approx(area_mm2 * 200 / 1000, rel=1e-6)
    assert first.volume.after_ml == pytest.approx(0.97**2 * area_mm2 * 200 / 1000, rel=1e-4)
    assert second.volume is not None
    assert second.volume.high_mm == pytest.approx(150.0, abs=0.5)
    assert second.volume.after_ml == pytest.approx(second.volume.before_ml, rel=1e-6)
    together = ledger.volume
    assert together is not None
    assert together.high_mm == second.volume.high_mm
    change = (0.97**2 - 1) * area_mm2 * second.volume.high_mm / 1000
    assert together.after_ml - together.before_ml == pytest.approx(change, rel=2e-3)
    assert "All edits together: volume from the distal end to 150" in "\n".join(lines_of(ledger))


@pytest.mark.parametrize("share", [0.3, 0.5, 0.7])
def test_a_trimline_anywhere_leaves_a_volume_to_compare(share: float) -> None:
    high = 200.0 * share
    ring = np.radians(np.arange(0, 360, 15))
    through = tuple((50.0 * math.cos(a), 50.0 * math.sin(a), high) for a in ring)
    recipe = Recipe(name="short", entries=(Entry(edit=Trimline(through=through)),))
    (line,) = replay(recipe, cup(50.0, 200.0)).ledger.lines
    assert line.volume is not None
    assert line.volume.high_mm == pytest.approx(high, abs=0.5)
    area_mm2 = SPOKES / 2 * math.sin(2 * math.pi / SPOKES) * 50.0**2
    assert line.volume.before_ml == pytest.approx(area_mm2 * line.volume.high_mm / 1000, rel=1e-6)
    assert line.volume.after_ml == pytest.approx(line.volume.before_ml, rel=1e-6)


AREA_MM2 = SPOKES / 2 * math.sin(2 * math.pi / SPOKES) * 50.0**2
"""Of a section of `cup(50, ...)`."""
RING = np.radians(np.arange(0, 360, 15))
SLOPE_DEG = math.degrees(math.atan(0.4))
"""Rises by 20 mm over the radius of `cup(50, ...)`."""
SLANTED = Trimline(
    through=tuple((50 * math.cos(a), 50 * math.sin(a), 120 - 20 * math.sin(a)) for a in RING)
)


@pytest.mark.parametrize(
    ("edits", "low_mm", "high_mm"),
    [
        ([PlaneCut(height_mm=80.0, capped=True)], None, 80.0),
        ([PlaneCut(height_mm=80.0, capped=True, keep="proximal")], 80.0, 200.0),
        ([PlaneCut(height_mm=120.0, capped=True, forward_deg=SLOPE_DEG)], None, 100.0),
        ([Fill(brim=True), PlaneCut(height_mm=80.0)], None, 80.0),
        ([Fill(brim=True), SLANTED], None, 100.0),
    ],
    ids=("level", "distal part", "slanted", "of a solid", "trimline of a solid"),
)
def test_what_a_covered_cut_takes_away_is_no_change_of_volume(
    edits: list[Edit], low_mm: float | None, high_mm: float
) -> None:
    """Between the tip and the lowest place of the cut nothing moved."""
    recipe = Recipe(name="cap", entries=tuple(Entry(edit=edit) for edit in edits))
    ledger = replay(recipe, cup(50.0, 200.0)).ledger
    for volume in (ledger.lines[-1].volume, ledger.volume):
        assert volume is not None
        assert volume.low_mm == (None if low_mm is None else pytest.approx(low_mm, abs=0.01))
        assert volume.high_mm is not None
        assert volume.high_mm == pytest.approx(high_mm, abs=0.1)
        of_span = AREA_MM2 * (volume.high_mm - (volume.low_mm or 0.0)) / 1000
        assert volume.before_ml == pytest.approx(of_span, rel=1e-6)
        assert volume.after_ml == pytest.approx(of_span, rel=1e-6)


def test_a_reduction_is_counted_beside_a_covered_cut() -> None:
    """3 % of the girth, closed, cut level at 100 mm: 0.97 squared of what lay below it before."""
    reduced = Reduction(heights_mm=(0.0, 200.0), per_cent=(3.0, 3.0), of="girth")
    entries = [Entry(edit=one) for one in (reduced, Fill(brim=True), PlaneCut(height_mm=100.0))]
    ledger = replay(Recipe(name="r", entries=tuple(entries)), cup(50.0, 200.0)).ledger
    assert ledger.volume is not None
    assert ledger.volume.high_mm == pytest.approx(100.0, abs=0.01)
    assert ledger.volume.before_ml == pytest.approx(AREA_MM2 * 100 / 1000, rel=1e-6)
    assert ledger.volume.after_ml == pytest.approx(0.97**2 * AREA_MM2 * 100 / 1000, rel=1e-3)


def test_a_level_through_the_cover_of_a_cut_has_no_girth() -> None:
    """The cover lies between 100 and 140 mm: a tape at 120 mm would run across it."""
    entries = (Entry(edit=Fill(brim=True)), Entry(edit=SLANTED))
    ledger = replay(Recipe(name="slanted", entries=entries), cup(50.0, 200.0)).ledger
    assert ledger.levels_mm == (20, 40, 60, 80, 100, 120, 140, 160, 180)
    told = [girth is not None for girth in ledger.lines[-1].after.girths_mm]
    assert told == [True] * 5 + [False] * 4


ANKLE_MM = 150.0


def test_a_cover_goes_along_with_a_joint_that_is_turned() -> None:
    """Cut level at 40 mm and turned by 10 degrees about 150 mm, the cover slants from below 40 to
    over it: a tape at 40 mm would run across it."""
    places = {
        "medial malleolus": (45.0, 0.0, ANKLE_MM),
        "lateral malleolus": (-45.0, 0.0, ANKLE_MM),
        "tibial tubercle": (0.0, 50.0, 195.0),
        "first metatarsal head": (20.0, 0.0, 45.0),
        "fifth metatarsal head": (-20.0, 0.0, 45.0),
    }
    foot = replace(
        cup(50.0, 200.0),
        kind="foot",
        landmarks=tuple(
            Landmark(name=name, position_mm=np.array(at)) for name, at in places.items()
        ),
    )
    cut = PlaneCut(height_mm=40.0, keep="proximal", capped=True)
    turned = Repose(joint="ankle", by_deg=10.0, band_mm=60.0)
    ledger = replay(Recipe(name="r", entries=(Entry(edit=cut), Entry(edit=turned))), foot).ledger
    at = ledger.levels_mm.index(40)
    slant_mm = 50.0 * np.sin(np.radians(10.0))
    middle_mm = ANKLE_MM - (ANKLE_MM - 40.0) * np.cos(np.radians(10.0))
    assert middle_mm - slant_mm < 40.0 < middle_mm + slant_mm
    assert ledger.lines[-1].after.girths_mm[at] is None
    beyond = next(k for k, z in enumerate(ledger.levels_mm) if z > middle_mm + slant_mm)
    assert ledger.lines[-1].after.girths_mm[beyond] is not None


def test_a_cover_stays_where_vertices_were_numbered_anew() -> None:
    """As many vertices are no sign that each is the one that had its number before."""
    limb = cup(50.0, 200.0)
    faces = len(limb.mesh) - 1 - limb.mesh.faces
    anew = replace(limb, mesh=Mesh(vertices_mm=limb.mesh.vertices_mm[::-1].copy(), faces=faces))
    cover = limb.mesh.vertices_mm[:5]
    np.testing.assert_array_equal(covers_after((cover,), limb, anew)[0], cover)


def test_a_wall_has_no_volume_to_compare_with_the_limb() -> None:
    """Its material, 4 mm thick, is a fifth of what the limb encloses; no limb has shrunk so."""
    reduced = Reduction(heights_mm=(0.0, 200.0), per_cent=(3.0, 3.0), of="girth")
    edits = (reduced, Wall(thickness_mm=4.0), PlaneCut(height_mm=100.0))
    recipe = Recipe(name="socket", entries=tuple(Entry(edit=edit) for edit in edits))
    ledger = replay(recipe, cup(50.0, 200.0)).ledger
    first, wall, cut = ledger.lines
    assert first.volume == ledger.volume
    assert wall.volume is None
    assert "recipe.becomes_wall" in [one.code for one in wall.told]
    assert cut.volume is not None
    assert cut.volume.high_mm == pytest.approx(100.0, abs=0.01)
    assert cut.volume.after_ml == pytest.approx(cut.volume.before_ml, rel=1e-6)
    told = "\n".join(lines_of(ledger))
    assert "All edits before no. 2 together: volume from the distal end to 200.0 mm" in told
    assert "not comparable" not in told


@pytest.mark.parametrize("side", ["outward", "inward"])
def test_girths_of_a_wall_are_those_of_the_skin_that_touches_the_limb(side: str) -> None:
    """Its other side, 4 mm of radius away, would show 25 mm that nobody gave or took."""
    made = make_edit("wall", {"thickness_mm": 4.0, "side": side}, "wall")
    edits = (made, PlaneCut(height_mm=150.0))
    recipe = Recipe(name="socket", entries=tuple(Entry(edit=edit) for edit in edits))
    wall, cut = replay(recipe, cup(50.0, 200.0)).ledger.lines
    kept = [girth for girth in wall.after.girths_mm if girth is not None]
    assert len(kept) >= 8
    for before, after in zip(wall.before.girths_mm, wall.after.girths_mm, strict=True):
        assert after is None or after == pytest.approx(before, abs=0.3)
    for before, after in zip(wall.after.girths_mm[:7], cut.after.girths_mm[:7], strict=True):
        assert after is None or after == pytest.approx(before, abs=0.3)


def test_the_ledger_counts_the_relief_that_the_surface_lost_as_a_table_does() -> None:
    limb = cup(50.0, 200.0)
    count = len(limb.mesh)
    mesh = replace(
        limb.mesh,
        sigma_mm=np.full(count, 0.05, np.float32),
        lost_length=np.tile(np.array([0.006, 0.001], np.float32), (count, 1)),
    )
    limb = replace(limb, mesh=mesh)
    reduced = Reduction(heights_mm=(0.0, 200.0), per_cent=(3.0, 3.0), of="girth")
    ledger = replay(Recipe(name="first", entries=(Entry(edit=reduced),)), limb).ledger
    table = measure_limb(limb, LimbMeasureOptions(heights_mm=ledger.levels_mm))
    for girth, row in zip(ledger.lines[0].before.girths_mm, table.rows, strict=True):
        figure = row.figures["contour_mm"]
        assert figure is not None
        assert girth == pytest.approx(figure.value, rel=1e-9)
        assert figure.value == pytest.approx(1.006 * 2 * math.pi * 50, rel=1e-3)


def test_a_flat_shape_keeps_its_levels_apart() -> None:
    levels = choose_levels(cone(30.0, 6.0))
    assert np.allclose(np.diff(levels), 1.0)
    assert levels[0] == pytest.approx(0.5)


def test_a_cut_s_cover_is_mirrored_with_the_limb() -> None:
    """A cap that slopes to one side lies where the other side is after a mirror."""
    cut = do_edit(cup(50.0, 200.0), PlaneCut(height_mm=120.0, right_deg=20.0, capped=True))
    cover = cut_cover(cup(50.0, 200.0), cut)
    assert cover is not None
    mirrored = do_edit(cut, Mirror(confirmed_side="right"))
    (found,) = covers_after((cover,), cut, mirrored)
    np.testing.assert_allclose(found, cover * [-1.0, 1.0, 1.0], atol=1e-9)


def test_a_wall_that_is_moved_is_told_to_press_where_it_grows_outwards() -> None:
    """Its inside, which touches the limb, faces the other way: an offset of 1 mm presses there."""
    edits = (Wall(thickness_mm=4.0), Offset(distance_mm=1.0), PlaneCut(height_mm=110.0))
    recipe = Recipe(name="w", entries=tuple(Entry(edit=one) for one in edits))
    wall, moved, cut = replay(recipe, cup(50.0, 140.0)).ledger.lines
    at = 3
    before, after = wall.after.girths_mm[at], moved.after.girths_mm[at]
    assert before is not None
    assert after == pytest.approx(before - 2 * math.pi, abs=0.1)
    assert moved.displacement is not None
    assert moved.displacement.largest_mm > 0.9
    told = ["recipe.on_wall" in [one.code for one in line.told] for line in (wall, moved, cut)]
    assert told == [False, True, False]


def test_a_wall_read_from_a_file_is_told_to_press_too() -> None:
    wall = do_edit(cup(50.0, 200.0, step_mm=5.0), Wall(thickness_mm=4.0))
    entry = Entry(edit=Offset(distance_mm=1.0))
    for limb, pressed in ((wall, True), (cup(50.0, 200.0, step_mm=5.0), False)):
        (line,) = replay(Recipe(name="w", entries=(entry,)), limb).ledger.lines
        assert ("recipe.on_wall" in [one.code for one in line.told]) is pressed


def test_room_by_a_flare_counts_where_the_limb_bears_no_pressure() -> None:
    """A load beside it would else be told as pressure where the socket stands off."""
    knee = Landmark(name="mid patella", position_mm=np.array([0.0, 50.0, 135.0]))
    limb = replace(cup(50.0, 140.0), kind="transtibial", landmarks=(knee,))
    edits = (Flare(depth_mm=5.0, height_mm=40.0), Offset(distance_mm=-1.0))
    done = replay(Recipe(name="w", entries=tuple(Entry(edit=one) for one in edits)), limb)
    (landmark,) = done.limb.landmarks
    stands_off_mm = float(np.hypot(*landmark.position_mm[:2])) - 50.0
    assert stands_off_mm > 2.0
    assert done.ledger.places_mm["mid patella"] == pytest.approx(stands_off_mm, abs=0.1)


def test_all_that_moves_the_skin_counts_there_but_a_sock_taken_off() -> None:
    told = {name_of(one) for one in EDITS if one.about.effect.reports_displacement}
    counted = {name_of(one) for one in EDITS if one.about.effect.moves_skin}
    assert told - counted == {"sock"}
