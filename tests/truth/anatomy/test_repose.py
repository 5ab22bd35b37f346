"""Turned joints, against angles that are known and against the way back."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from limbgram.core.errors import EditError
from limbgram.core.mesh.topology import volume_mm3
from limbgram.findings import told
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.repose import JointTurn, Repose
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.sheet import SheetOptions, measuring_sheet

MakeLimb = Callable[..., Limb]
JOINTS = [("ankle", 10.0), ("ankle", -10.0), ("hindfoot", 6.0), ("forefoot", 8.0), ("toes", 12.0)]
ADULT_MM = 25.0


@pytest.mark.parametrize("left", [False, True])
@pytest.mark.parametrize(("about", "by_deg"), JOINTS)
def test_the_way_back_restores_the_scan(
    foot_of: MakeLimb, about: str, by_deg: float, left: bool
) -> None:
    limb = foot_of(left=left)
    there = do_edit(limb, Repose(joint=about, by_deg=by_deg, beyond=True))
    back = do_edit(there, Repose(joint=about, by_deg=-by_deg, beyond=True))
    moved = np.linalg.norm(there.mesh.vertices_mm - limb.mesh.vertices_mm, axis=1)
    assert moved.max() > 3.0
    off = np.linalg.norm(back.mesh.vertices_mm - limb.mesh.vertices_mm, axis=1)
    assert off.max() < 0.01
    for one, other in zip(limb.landmarks, back.landmarks, strict=True):
        assert np.linalg.norm(one.position_mm - other.position_mm) < 0.01


@pytest.mark.parametrize("left", [False, True])
def test_the_foot_is_turned_as_a_whole_about_the_ankle(foot_of: MakeLimb, left: bool) -> None:
    """Away from the band, all is where an exact turn about the malleoli has it."""
    limb = foot_of(left=left)
    turn = JointTurn.of(limb.anatomy, "ankle", 10.0 * (-1 if left else 1), ADULT_MM)
    shares = turn.shares(limb.mesh.vertices_mm)
    after = do_edit(limb, Repose(joint="ankle", by_deg=10.0, beyond=True))
    axis = limb.axis("ankle")
    angle = np.radians(10.0) * (-1 if left else 1)
    off = limb.mesh.vertices_mm - axis.point_mm
    along = np.outer(off @ axis.direction, axis.direction)
    exact = (
        axis.point_mm
        + along
        + np.cos(angle) * (off - along)
        + np.sin(angle) * np.cross(axis.direction, off)
    )
    apart = np.linalg.norm(after.mesh.vertices_mm - exact, axis=1)
    distal, proximal = shares >= 1 - 1e-12, shares <= 1e-12
    assert distal.sum() > 300
    assert proximal.sum() > 150
    assert apart[distal].max() < 1e-9
    still = after.mesh.vertices_mm[proximal] - limb.mesh.vertices_mm[proximal]
    assert np.abs(still).max() < 1e-9
    front = limb.landmark("second toe").position_mm, after.landmark("second toe").position_mm
    assert front[1][2] > front[0][2] + 20  # dorsiflexion lifts the toes, on both sides


@pytest.mark.parametrize("left", [False, True])
@pytest.mark.parametrize(
    ("about", "by_deg", "figure"),
    [
        ("ankle", 8.0, "dorsiflexion_deg"),
        ("hindfoot", 5.0, "hindfoot_deg"),
        ("forefoot", 6.0, "forefoot_deg"),
    ],
)
def test_the_sheet_reads_the_turn(
    foot_of: MakeLimb, about: str, by_deg: float, figure: str, left: bool
) -> None:
    limb = foot_of(left=left)
    asked = SheetOptions(only=(figure,))
    before = measuring_sheet(limb, asked)[figure].value
    after = do_edit(limb, Repose(joint=about, by_deg=by_deg, band_mm=8.0, beyond=True))
    turned = measuring_sheet(after, asked)[figure].value - before
    # The sheet's angle is seen along the foot, the turn is about the joint's own slanting axis.
    assert turned == pytest.approx(by_deg, abs=1.5)
    assert turned > 0.7 * by_deg


@pytest.mark.parametrize("left", [False, True])
@pytest.mark.parametrize(("up_deg", "medial_deg"), [(None, None), (30.0, 10.0), (0.0, 0.0)])
def test_the_hindfoot_turns_about_the_subtalar_axis(
    foot_of: MakeLimb, up_deg: float | None, medial_deg: float | None, left: bool
) -> None:
    """Below the band all is where an exact turn about the stated axis through the heel has it."""
    limb = foot_of(left=left)
    up, medial = np.radians([42.0 if up_deg is None else up_deg, 23.0 if up_deg is None else 10.0])
    medial = medial if up_deg != 0 else 0.0
    sole = limb.axis("plantar").direction
    forward = limb.axis("foot").direction
    inwards = np.cross(sole, forward) * (-1 if left else 1)
    assert inwards[0] * (1 if left else -1) > 0.9  # the right foot's medial side is at -x
    axis = np.cos(up) * (np.cos(medial) * forward + np.sin(medial) * inwards) + np.sin(up) * sole
    assert np.linalg.norm(axis) == pytest.approx(1.0)
    after = do_edit(
        limb, Repose(joint="hindfoot", by_deg=6.0, axis_up_deg=up_deg, axis_medial_deg=medial_deg)
    )
    angle = np.radians(6.0) * (-1 if left else 1)
    off = limb.mesh.vertices_mm - limb.landmark("heel").position_mm
    along = np.outer(off @ axis, axis)
    turned = along + np.cos(angle) * (off - along) + np.sin(angle) * np.cross(axis, off)
    exact = limb.landmark("heel").position_mm + turned
    low = off @ sole < 0
    assert low.sum() > 200
    np.testing.assert_allclose(after.mesh.vertices_mm[low], exact[low], atol=1e-9)
    lifted = after.mesh.vertices_mm - limb.mesh.vertices_mm
    ball = [limb.landmark(f"{one} metatarsal head").position_mm for one in ("first", "fifth")]
    first, fifth = (
        lifted[int(np.linalg.norm(limb.mesh.vertices_mm - at, axis=1).argmin())] for at in ball
    )
    assert (first - fifth) @ sole > 3.0  # supination: the medial border rises over the lateral one


def test_only_an_axis_that_no_landmark_tells_can_be_stated(foot_of: MakeLimb) -> None:
    with pytest.raises(EditError) as refused:
        do_edit(foot_of(), Repose(joint="ankle", by_deg=5.0, axis_up_deg=40.0))
    assert refused.value.finding.code == "edit.repose.told_by_landmarks"


@pytest.mark.parametrize(("joint", "axis"), [("side bend", 0), ("extension", 1)])
def test_a_trunk_bends_and_comes_back(trunk_of: MakeLimb, joint: str, axis: int) -> None:
    limb = trunk_of()
    there = do_edit(limb, Repose(joint=joint, by_deg=6.0, band_mm=80.0))
    shift = there.landmark("seventh cervical vertebra").position_mm
    shift = shift - limb.landmark("seventh cervical vertebra").position_mm
    height = limb.landmark("seventh cervical vertebra").position_mm[2]
    height -= limb.landmark("third lumbar vertebra").position_mm[2]
    sign = 1 if axis == 0 else -1  # to the right; backwards
    assert sign * shift[axis] == pytest.approx(height * np.sin(np.radians(6.0)), rel=0.1)
    pelvis = there.landmark("sacrum").position_mm - limb.landmark("sacrum").position_mm
    assert np.linalg.norm(pelvis) < 0.5
    back = do_edit(there, Repose(joint=joint, by_deg=-6.0, band_mm=80.0))
    assert np.abs(back.mesh.vertices_mm - limb.mesh.vertices_mm).max() < 0.01


def test_more_than_is_stated_has_to_be_meant(foot_of: MakeLimb) -> None:
    limb = foot_of()
    with pytest.raises(EditError) as refused:
        do_edit(limb, Repose(joint="ankle", by_deg=21.0, band_mm=60.0))
    assert refused.value.finding.code == "edit.repose.beyond"
    with pytest.raises(EditError) as refused:
        do_edit(limb, Repose(joint="ankle", by_deg=18.0, band_mm=8.0))
    assert refused.value.finding.values["strain"] > 0.25  # type: ignore[operator]
    with pytest.raises(EditError) as refused:
        do_edit(limb, Repose(joint="ankle", by_deg=44.0, band_mm=5.0, beyond=True))
    assert refused.value.finding.code in ("edit.repose.torn", "edit.unsound")


def test_what_was_done_is_told(foot_of: MakeLimb) -> None:
    limb = foot_of()
    after = do_edit(limb, Repose(joint="ankle", by_deg=5.0))
    done, read = after.notes[-2:]
    assert (done.code, read.code) == ("edit.repose.done", "edit.repose.read")
    assert done.values["by_deg"] == 5.0
    assert 0.02 < float(done.values["strain"]) < 0.25  # type: ignore[arg-type]
    volumes = [volume_mm3(one.mesh) for one in (limb, after)]
    assert abs(volumes[1] / volumes[0] - 1) < 0.02


@pytest.mark.parametrize("left", [False, True])
def test_turn_and_clinical_angle_are_both_told(foot_of: MakeLimb, left: bool) -> None:
    """The angle that changed is that of a foot turned exactly, against a shank that stays."""
    limb = foot_of(left=left, sigma_mm=0.2)
    read = do_edit(limb, Repose(joint="ankle", by_deg=-8.0)).notes[-1]
    turn = Rotation.from_rotvec(
        np.radians(8.0 if left else -8.0) * limb.axis("ankle").direction
    ).as_matrix()
    angles = []
    for rotation in (np.eye(3), turn):
        foot, sole = (rotation @ limb.axis(one).direction for one in ("foot", "plantar"))
        shank = limb.axis("shank").direction
        angles.append(np.degrees(np.arctan2(shank @ sole, shank @ foot)))
    change = float(read.values["change_deg"])  # type: ignore[arg-type]
    assert read.values["before_deg"] == pytest.approx(angles[0], abs=1e-6)
    assert change == pytest.approx(angles[1] - angles[0], abs=0.02)
    assert 6.0 < change < 7.9  # plantarflexion opens the angle; the axis slants
    sheet = measuring_sheet(limb, SheetOptions(only=("ankle_deg",)))["ankle_deg"]
    assert sheet.interval is not None
    assert read.values["before_deg"] == sheet.value
    assert read.values["before_within_deg"] == sheet.interval.above > 0.5
    assert "±" in told(read)
    assert told(read).startswith("Ankle, shank to plantar plane; 90 is plantigrade: ")
    assert told(read, "de").startswith("Sprunggelenk, Unterschenkel zur Plantarebene")


@pytest.mark.parametrize("left", [False, True])
@pytest.mark.parametrize(
    ("joint", "figure", "by_deg"),
    [
        ("ankle", "ankle_deg", 6.0),
        ("hindfoot", "hindfoot_deg", 4.0),
        ("forefoot", "forefoot_deg", -5.0),
        ("toes", "toes_up_deg", 9.0),
    ],
)
def test_a_joint_is_turned_until_the_sheet_reads_the_angle(
    foot_of: MakeLimb, joint: str, figure: str, by_deg: float, left: bool
) -> None:
    limb = foot_of(left=left)
    asked = SheetOptions(only=(figure,))
    turned = do_edit(limb, Repose(joint=joint, by_deg=by_deg, beyond=True))
    wanted = round(measuring_sheet(turned, asked)[figure].value, 1)
    after = do_edit(limb, Repose(joint=joint, to_deg=wanted, beyond=True))
    assert measuring_sheet(after, asked)[figure].value == pytest.approx(wanted, abs=1e-4)
    done = after.notes[-2].values["by_deg"]
    assert done == pytest.approx(by_deg, abs=0.2)
    back = do_edit(after, Repose(joint=joint, by_deg=-float(done), beyond=True))  # type: ignore[arg-type]
    assert np.abs(back.mesh.vertices_mm - limb.mesh.vertices_mm).max() < 0.01


def test_a_trunk_is_turned_until_the_sheet_reads_the_angle(trunk_of: MakeLimb) -> None:
    limb = trunk_of()
    for joint, figure, change in (
        ("side bend", "side_bend_deg", 5.0),
        ("extension", "lordosis_deg", 4.0),
    ):
        asked = SheetOptions(only=(figure,))
        wanted = measuring_sheet(limb, asked)[figure].value + change
        after = do_edit(limb, Repose(joint=joint, to_deg=wanted, band_mm=60.0))
        assert measuring_sheet(after, asked)[figure].value == pytest.approx(wanted, abs=1e-4)
        assert 0.9 * change < float(after.notes[-2].values["by_deg"]) < 3 * change  # type: ignore[arg-type]


def test_an_angle_by_stand_ins_is_told_with_the_turn(foot_of: MakeLimb) -> None:
    limb = foot_of()
    marks = tuple(one for one in limb.landmarks if one.name != "medial tibial condyle")
    for one, doubted in ((limb, False), (replace(limb, landmarks=marks), True)):
        after = do_edit(one, Repose(joint="ankle", by_deg=2.0))
        assert ("measure.sheet.stand_ins" in [note.code for note in after.notes]) is doubted


def test_one_of_turn_and_angle_is_given(foot_of: MakeLimb) -> None:
    limb = foot_of()
    for edit in (Repose(joint="ankle"), Repose(joint="ankle", by_deg=3.0, to_deg=90.0)):
        with pytest.raises(EditError) as refused:
            do_edit(limb, edit)
        assert refused.value.finding.code == "edit.repose.one_of_two"
    with pytest.raises(EditError) as refused:
        do_edit(limb, Repose(joint="ankle", to_deg=0.0))  # dorsiflexion is meant
    assert refused.value.finding.code == "edit.repose.out_of_reach"
    assert 60 < refused.value.finding.values["before_deg"] < 120  # type: ignore[operator]


def test_a_missing_landmark_and_another_kind_are_named(foot_of: MakeLimb) -> None:
    limb = foot_of()
    marks = tuple(one for one in limb.landmarks if one.name != "lateral malleolus")
    with pytest.raises(EditError) as refused:
        do_edit(replace(limb, landmarks=marks), Repose(joint="ankle", by_deg=5.0))
    reason = refused.value.finding.values["reason"]
    assert reason.values["names"] == ("lateral malleolus",)  # type: ignore[union-attr]
    with pytest.raises(EditError) as refused:
        do_edit(replace(limb, kind="transtibial"), Repose(joint="ankle", by_deg=5.0))
    assert refused.value.finding.code == "edit.kind"
