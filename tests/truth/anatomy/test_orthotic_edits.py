"""Edits of orthotists, against what each says it does: which way, how far, where."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.errors import EditError
from limbgram.core.mesh.topology import find_edges, volume_mm3
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.findings import Finding
from limbgram.workbench.edits.arch_fill import ArchFill
from limbgram.workbench.edits.build_ups import BuildUps
from limbgram.workbench.edits.cutting import ON_CUT_MM
from limbgram.workbench.edits.edit import Edit, name_of
from limbgram.workbench.edits.editing import EDITS, do_edit
from limbgram.workbench.edits.expansion import Expansion
from limbgram.workbench.edits.heel_skive import HeelSkive
from limbgram.workbench.edits.pad import Pad
from limbgram.workbench.edits.plantar_board import PlantarBoard
from limbgram.workbench.edits.repose import Repose
from limbgram.workbench.edits.roll import Roll
from limbgram.workbench.edits.room import Room
from limbgram.workbench.edits.sole import Sole
from limbgram.workbench.edits.spine import Spine
from limbgram.workbench.frame.landmarks import with_landmarks
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb
from limbgram.workbench.recipe.file import make_edit

MakeLimb = Callable[..., Limb]
SIDES = [False, True]


def name_of_edit(edit: Edit) -> str:
    return name_of(type(edit))


def steps(limb: Limb, after: Limb) -> np.ndarray:
    """How each vertex moved, in the frame of the sole: lateral, forward, up."""
    sole = Sole.of(limb)
    assert len(after.mesh) == len(limb.mesh)
    return (after.mesh.vertices_mm - limb.mesh.vertices_mm) @ sole.rotation.T


KINDS = ("foot", "torso")
OF_A_KIND = [(edit, one) for edit in EDITS for one in edit.about.kinds if one in KINDS]


@pytest.mark.parametrize(("kind", "of"), OF_A_KIND, ids=lambda one: getattr(one, "__name__", one))
def test_landmarks_stay_on_the_surface(
    foot_of: MakeLimb, trunk_of: MakeLimb, kind: type[Edit], of: str
) -> None:
    """Those of the kind, and others in between, also where the edit knows none of them."""
    limb = foot_of() if of == "foot" else trunk_of()
    spread = np.random.default_rng(4).choice(len(limb.mesh), 60, replace=False)
    places = limb.mesh.vertices_mm[spread]
    marks = [Landmark(name=f"no. {k}", position_mm=at) for k, at in enumerate(places)]
    limb = with_landmarks(limb, [*limb.landmarks, *marks])
    joint = {"joint": "side bend", "by_deg": 2.0} if kind is Repose and of == "torso" else {}
    after = do_edit(limb, make_edit(name_of(kind), {**kind.about.example, **joint}, "its example"))

    def off_mm(one: Limb) -> np.ndarray:
        return (
            tree_on(one.mesh)
            .closest(np.stack([mark.position_mm for mark in one.landmarks]))
            .distances_mm
        )

    gone = [one for one in after.notes if one.code == "edit.landmark.cut_off"]
    assert len(after.landmarks) + len(gone) == len(limb.landmarks)
    assert off_mm(after).max() < off_mm(limb).max() + ON_CUT_MM


@pytest.mark.parametrize("left", SIDES)
def test_a_board_makes_heel_and_ball_flat(foot_of: MakeLimb, left: bool) -> None:
    sole = Sole.of(foot_of(left=left))
    limb = sole.limb
    after = do_edit(limb, PlantarBoard(depth_mm=3.0, blend_mm=2.0))
    moved = steps(limb, after)
    high = sole.points_mm[:, 2]
    pressed = sole.plantar & (high < 3.0)
    assert pressed.sum() > 50
    np.testing.assert_allclose(high[pressed] + moved[pressed, 2], 3.0, atol=1e-9)
    assert np.abs(moved[high > 5.0]).max() < 1e-9
    assert volume_mm3(after.mesh) < volume_mm3(limb.mesh)


@pytest.mark.parametrize("left", SIDES)
def test_an_arch_fill_adds_under_the_medial_arch(foot_of: MakeLimb, left: bool) -> None:
    sole = Sole.of(foot_of(left=left))
    limb = sole.limb
    after = do_edit(limb, ArchFill(depth_mm=3.2))
    moved = steps(limb, after)
    assert moved[:, 2].min() == pytest.approx(-3.2, abs=1e-9)
    assert moved[:, 2].max() <= 1e-12
    deepest = sole.points_mm[int(moved[:, 2].argmin())]
    assert deepest[0] < 0  # medial
    assert 0.25 < deepest[1] / sole.length_mm < 0.75
    assert deepest[2] < 0.6 * sole.arch[2]  # under the arch, not beside the navicular
    sunk = moved[:, 2] < 0
    assert (sole.points_mm[sunk, 2] + moved[sunk, 2]).min() > -1e-9
    assert volume_mm3(after.mesh) > volume_mm3(limb.mesh)


@pytest.mark.parametrize("relief_mm", [0.0, 0.15])
def test_an_arch_fill_runs_out_without_a_step(foot_of: MakeLimb, relief_mm: float) -> None:
    """Up the medial side too, which hangs over: what moved in full and what stayed were one edge
    apart there, so that a smooth surface folded and a rough one was refused."""
    limb = Sole.of(foot_of()).limb
    rough = np.random.default_rng(3).normal(0, relief_mm, (len(limb.mesh), 1))
    limb = limb.with_mesh(
        limb.mesh.with_vertices(limb.mesh.vertices_mm + rough * limb.mesh.vertex_normals())
    )
    limb = Sole.of(limb).limb
    after = do_edit(limb, ArchFill(depth_mm=3.2))
    down = steps(limb, after)[:, 2]
    ends = find_edges(limb.mesh.faces).ends
    edges = np.diff(limb.mesh.vertices_mm[ends], axis=1)[:, 0]
    slopes = np.abs(np.diff(down[ends], axis=1))[:, 0] / np.linalg.norm(edges, axis=1)
    turned = (after.mesh.face_normals() * limb.mesh.face_normals()).sum(1)
    assert turned.min() > 0
    assert 0.1 < slopes.max() < 1


@pytest.mark.parametrize("on", ["medial", "lateral"])
@pytest.mark.parametrize("left", SIDES)
def test_a_skive_takes_a_slanting_flat_off_one_side(foot_of: MakeLimb, left: bool, on: str) -> None:
    sole = Sole.of(foot_of(left=left))
    limb = sole.limb
    after = do_edit(limb, HeelSkive(depth_mm=4.0, border=on))  # type: ignore[arg-type]
    moved = steps(limb, after)
    assert moved[:, 2].max() == pytest.approx(4.0, abs=0.3)
    assert moved[:, 2].min() >= 0
    deepest = sole.points_mm[int(moved[:, 2].argmax())]
    assert (deepest[0] < 0) == (on == "medial")
    assert deepest[1] < 0.35 * sole.length_mm
    # On the flat, heights rise with the tilt towards that side.
    flat = (moved[:, 2] > 0) & (sole.points_mm[:, 1] < 0.15 * sole.length_mm)
    where = (sole.points_mm + moved)[flat]
    outwards = where[:, 0] * (-1 if on == "medial" else 1)
    slope = np.polyfit(outwards, where[:, 2], 1)[0]
    assert np.degrees(np.arctan(slope)) == pytest.approx(15.0, abs=0.5)
    assert volume_mm3(after.mesh) < volume_mm3(limb.mesh)


@pytest.mark.parametrize("left", SIDES)
def test_an_expansion_widens_the_lateral_border_and_the_heel(foot_of: MakeLimb, left: bool) -> None:
    sole = Sole.of(foot_of(left=left))
    limb = sole.limb
    moved = steps(limb, do_edit(limb, Expansion(lateral_mm=4.0, heel_mm=3.0, height_mm=60.0)))
    assert 3.5 < moved[sole.points_mm[:, 1] > 0.4 * sole.length_mm, 0].max() <= 4.0 + 1e-9
    back = sole.points_mm[:, 1] < 0.1 * sole.length_mm
    assert -3.0 <= moved[back, 1].min() < -1.5
    middle = (sole.points_mm[:, 1] > 0.5 * sole.length_mm) & (sole.points_mm[:, 0] < 0)
    assert np.abs(moved[middle, 0]).max() < 0.5
    assert np.abs(moved[sole.points_mm[:, 2] > 60.0]).max() == 0


@pytest.mark.parametrize("edit", [PlantarBoard(), ArchFill(), Expansion()], ids=name_of_edit)
def test_heights_over_the_sole_need_the_places_under_it(foot_of: MakeLimb, edit: Edit) -> None:
    """Else an expansion that ends at 20 mm would reach 44 mm up an adult's foot."""
    limb = foot_of()
    place = "plantar first metatarsal head"
    marks = tuple(one for one in limb.landmarks if one.name != place)
    with pytest.raises(EditError) as refused:
        do_edit(replace(limb, landmarks=marks), edit)
    reason = refused.value.finding.values["reason"]
    assert isinstance(reason, Finding)
    assert reason.values["names"] == (place,)


def test_the_preset_is_built_up_over_each_marked_bone(foot_of: MakeLimb) -> None:
    limb = foot_of()
    after = do_edit(limb, BuildUps(times=0.5, falloff_mm=12.0, flat_mm=3.0, without=("heel",)))
    for name, height_mm in (("medial malleolus", 5.0), ("navicular", 4.0), ("tibial crest", 2.5)):
        before, behind = limb.landmark(name).position_mm, after.landmark(name).position_mm
        assert np.linalg.norm(behind - before) == pytest.approx(height_mm / 2, abs=0.35)
    heel = after.landmark("heel").position_mm - limb.landmark("heel").position_mm
    assert np.linalg.norm(heel) < 1e-9
    assert volume_mm3(after.mesh) > volume_mm3(limb.mesh)
    assert after.notes[-1].code == "edit.build_ups.done"
    bare = AlignedLimb(mesh=limb.mesh, frame=limb.frame, kind="foot")
    with pytest.raises(EditError) as refused:
        do_edit(bare, BuildUps())
    assert refused.value.finding.code == "edit.build_ups.none"


@pytest.mark.parametrize(("kind", "sign"), [(Pad, -1), (Room, 1)])
def test_a_pad_presses_and_a_room_gives_way(
    trunk_of: MakeLimb, kind: type[Pad] | type[Room], sign: int
) -> None:
    limb = trunk_of()
    edit = kind(at="right waist", depth_mm=12.0, width_mm=70.0, height_mm=100.0)
    after = do_edit(limb, edit)
    shift = after.landmark("right waist").position_mm - limb.landmark("right waist").position_mm
    assert np.linalg.norm(shift) == pytest.approx(12.0, abs=0.2)
    assert sign * shift[0] > 10  # the right waist looks to the right
    assert sign * (volume_mm3(after.mesh) - volume_mm3(limb.mesh)) > 20_000
    others = ("left waist", "xiphoid", "sacrum")
    for name in others:
        off = after.landmark(name).position_mm - limb.landmark(name).position_mm
        assert np.linalg.norm(off) < 1e-9


def test_a_pad_under_the_ball_lies_along_the_foot(foot_of: MakeLimb) -> None:
    limb = foot_of()
    at = "plantar first metatarsal head"
    after = do_edit(limb, Pad(at=at, depth_mm=2.0, width_mm=10.0, height_mm=30.0))
    turn = Sole.of(limb).rotation
    start = limb.landmark(at).position_mm
    given = limb.mesh.vertices_mm
    up = ((after.mesh.vertices_mm[: len(given)] - given) @ turn.T)[:, 2]
    lateral, forward, high = ((given[up > 0.01] - start) @ turn.T).T
    assert up.min() > -1e-9
    assert np.ptp(forward) > 2 * np.ptp(lateral)
    assert high.max() < 10.0  # the upper side of the foot stays


def test_a_roll_is_deepest_at_the_sides(trunk_of: MakeLimb) -> None:
    limb = trunk_of()
    after = do_edit(limb, Roll(depth_mm=15.0, above="right waist", band_mm=40.0, front=0.2))
    waist = after.landmark("right waist").position_mm - limb.landmark("right waist").position_mm
    navel = after.landmark("navel").position_mm - limb.landmark("navel").position_mm
    assert waist[0] == pytest.approx(-15.0, abs=0.6)
    assert -4.0 < navel[1] < -1.0
    chest = after.landmark("xiphoid").position_mm - limb.landmark("xiphoid").position_mm
    assert np.linalg.norm(chest) == 0


def test_levels_are_shifted_and_turned_and_come_back(trunk_of: MakeLimb) -> None:
    limb = trunk_of()
    sacrum = limb.landmark("sacrum").position_mm[2]
    spine = limb.landmark("xiphoid").position_mm[2] - sacrum
    levels = (0.0, spine, spine + 150.0)
    there = Spine(
        heights_mm=levels, right_mm=(0, 20.0, 5.0), turn_deg=(0, 10.0, 10.0), above="sacrum"
    )
    after = do_edit(limb, there)
    z = limb.mesh.vertices_mm[:, 2] - sacrum
    assert np.abs((after.mesh.vertices_mm - limb.mesh.vertices_mm)[z < 0]).max() < 1e-9
    at = limb.landmark("xiphoid").position_mm
    half = np.radians(5.0)
    turn = np.array([[np.cos(half), -np.sin(half)], [np.sin(half), np.cos(half)]])
    asked = turn @ (turn @ at[:2] + [20.0, 0.0])
    np.testing.assert_allclose(after.landmark("xiphoid").position_mm[:2], asked, atol=0.05)
    back = Spine(
        heights_mm=levels, right_mm=(0, -20.0, -5.0), turn_deg=(0, -10.0, -10.0), above="sacrum"
    )
    home = do_edit(after, back)
    assert np.abs(home.mesh.vertices_mm - limb.mesh.vertices_mm).max() < 1e-9
    bent = do_edit(
        limb,
        Spine(
            heights_mm=(-60.0, 150.0),
            bend_right_deg=(0.0, 9.0),
            bend_back_deg=(0.0, -6.0),
            above="third lumbar vertebra",
        ),
    )
    read = [one.values for one in bent.notes if one.code == "edit.repose.read"]
    changes = [float(one["change_deg"]) for one in read]
    assert 6.0 < changes[0] < 9.0  # of the whole chest, a part of which lies within the bend
    assert -6.0 < changes[1] < -2.0
    with pytest.raises(EditError) as refused:
        do_edit(limb, Spine(heights_mm=(0.0, 20.0), right_mm=(0, 50.0), above="sacrum"))
    assert refused.value.finding.code == "edit.spine.strain"
