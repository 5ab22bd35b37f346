"""Landmarks carried from a marked foot to another scan of it: the vertices tell where they lie."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.frames import Rigid
from limbgram.formats.limb_file import write_limb
from limbgram.formats.reading import read_limb
from limbgram.report.blocks import Table
from limbgram.report.record.layout import record_report
from limbgram.report.record.record import record_of
from limbgram.report.record.sources import ShapeSource
from limbgram.services.align import confirm, propose
from limbgram.workbench.compare.carried_landmarks import Carried, carry_landmarks
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.repose import Repose
from limbgram.workbench.frame.landmarks import unconfirmed_finding
from limbgram.workbench.limb import AlignedLimb, Limb, Side
from limbgram.workbench.measures.sheet import SheetOptions, measuring_sheet

from .conftest import MakeLimb

LYING = Rigid.from_rotation_vector(np.array([0.4, -0.8, 0.3]), np.array([60.0, -20.0, 35.0]))
"""How today's scan lies to the marked one."""
SIDES = "medial", "lateral"
INSIDE = 2.448
"""Sigmas along both directions of a surface within which 95 of 100 lie."""


@pytest.fixture
def marked(foot_of: MakeLimb) -> Limb:
    """Its landmarks lie exactly, so that all their error is the carrying's."""
    limb = foot_of()
    exact = tuple(replace(mark, sigma_mm=0.0) for mark in limb.landmarks)
    return replace(limb, landmarks=exact, name="before.ply")


def today(limb: Limb) -> Limb:
    """A scan that lies elsewhere, without landmarks and axes."""
    return Limb(mesh=limb.mesh.moved(LYING), kind=limb.kind, name="today.ply")


def errors_mm(found: Carried, truth: Limb) -> dict[str, float]:
    places = {mark.name: LYING.apply(mark.position_mm[None])[0] for mark in truth.landmarks}
    return {
        one.name: float(np.linalg.norm(one.position_mm - places[one.name]))
        for one in found.landmarks
    }


def reasons(found: Carried) -> dict[str, str]:
    return {one.name: one.reason.code for one in found.left_out}


def about(limb: Limb, name: str) -> np.ndarray:
    """How far each vertex lies from a landmark."""
    return np.linalg.norm(limb.mesh.vertices_mm - limb.landmark(name).position_mm, axis=1)


def test_an_unchanged_limb_has_its_landmarks_where_they_were(marked: Limb) -> None:
    found = carry_landmarks(today(marked), marked, "right")
    assert found.left_out == ()
    assert max(errors_mm(found, marked).values()) < 0.05
    assert all(one.placed == "proposed" and not one.confirmed for one in found.landmarks)


def test_a_limb_that_lost_volume_and_is_held_otherwise(marked: Limb) -> None:
    turned = do_edit(marked, Repose(joint="ankle", by_deg=4.0))
    line = turned.centreline()
    along_mm = np.linspace(0.0, line.length_mm, 400)
    middles = np.stack([line.at(one).point_mm for one in along_mm])

    def thinner(points: np.ndarray) -> np.ndarray:
        """By 3 % towards the centreline, which is smooth though its nearest place jumps."""
        apart = np.linalg.norm(points[:, None] - middles[None], axis=2)
        near = np.exp(-(apart - apart.min(1, keepdims=True)) / 5.0)
        return points + 0.03 * (near / near.sum(1, keepdims=True) @ middles - points)

    marks = thinner(np.stack([mark.position_mm for mark in turned.landmarks]))
    truth = replace(
        turned,
        mesh=turned.mesh.with_vertices(thinner(turned.mesh.vertices_mm)),
        landmarks=tuple(
            replace(mark, position_mm=at) for mark, at in zip(turned.landmarks, marks, strict=True)
        ),
    )
    found = carry_landmarks(today(truth), marked, "right")
    off_mm = errors_mm(found, truth)
    assert len(off_mm) == 20
    assert float(np.sqrt(np.mean(np.square([*off_mm.values()])))) < 1.0
    assert max(off_mm.values()) < 3.0
    stated = {one.landmark.name: one.carrying_mm for one in found.places}
    inside = [off_mm[name] < INSIDE * sigma for name, sigma in stated.items()]
    assert np.mean(inside) >= 0.9
    # A place on the plain shank slides more than a toe, and says so.
    assert stated["tibial crest"] > 2 * stated["first toe"]


def test_where_the_scan_ends_or_was_filled_nothing_is_proposed(marked: Limb) -> None:
    below_mm = marked.landmark("tibial tubercle").position_mm[2] - 10.0
    cut = keep_positive(marked.mesh, below_mm - marked.mesh.vertices_mm[:, 2]).mesh
    short = replace(marked, mesh=cut)
    short = short.with_mesh(replace(short.mesh, filled=about(short, "navicular") < 20))
    found = carry_landmarks(today(short), marked, "right")
    gone = {"tibial tubercle", "fibula head", "medial tibial condyle", "navicular"}
    assert set(reasons(found)) == gone
    assert {reasons(found)[name] for name in gone - {"navicular"}} <= {
        "carried.unmeasured",
        "carried.little",
        "carried.apart",
    }
    assert reasons(found)["navicular"] == "carried.unmeasured"


def test_where_the_shape_has_changed_nothing_is_proposed(marked: Limb) -> None:
    swollen = 8.0 * np.exp(-((about(marked, "navicular") / 20.0) ** 2))
    normals = marked.mesh.vertex_normals()
    mesh = marked.mesh.with_vertices(marked.mesh.vertices_mm + swollen[:, None] * normals)
    found = carry_landmarks(today(marked.with_mesh(mesh)), marked, "right")
    assert reasons(found)["navicular"] in {"carried.changed", "carried.little", "carried.apart"}
    assert errors_mm(found, marked)["fibula head"] < 0.5


def test_what_is_another_limb_is_refused(marked: Limb, foot_of: MakeLimb) -> None:
    cases: tuple[tuple[Limb, Side, str], ...] = (
        (today(marked), "left", "carried.side"),
        (replace(today(marked), kind="transtibial"), "right", "carried.kind"),
        (today(foot_of(left=True)), "right", "carried.other_limb"),
        (today(foot_of("adult_female")), "right", "carried.other_limb"),
    )
    for limb, side, code in cases:
        with pytest.raises(MeasureError) as refused:
            carry_landmarks(limb, marked, side)
        assert refused.value.finding.code == code


def test_the_limb_file_keeps_what_nobody_confirmed(marked: Limb, tmp_path: Path) -> None:
    open_marks = tuple(
        replace(mark, placed="proposed", sigma_mm=1.5, confirmed=mark.name == "heel")
        for mark in marked.landmarks
    )
    read = read_limb(write_limb(replace(marked, landmarks=open_marks), tmp_path / "today.ply"))
    assert [one.name for one in read.landmarks if one.confirmed] == ["heel"]
    assert [one.code for one in read.notes] == ["landmark.unconfirmed"]


def test_nobody_takes_a_proposal_for_a_place_that_was_felt_for(marked: Limb) -> None:
    assert isinstance(marked, AlignedLimb)
    proposed = propose(today(marked), marked, "right", "foot").limb
    proposed = proposed.with_frame(
        replace(marked.frame, limb_from_mesh=marked.frame.limb_from_mesh @ LYING.inverse)
    )
    ankle = SheetOptions(only=("ankle_deg",))
    said = measuring_sheet(proposed, ankle).doubt
    assert said is not None
    assert said.code == "landmark.unconfirmed"
    two = confirm(proposed, ("navicular", "Ferse"))
    assert {one.name for one in two.landmarks if one.confirmed} == {"navicular", "heel"}
    assert unconfirmed_finding(two) is not None
    looked_at = confirm(proposed, ("all",))
    assert unconfirmed_finding(looked_at) is None
    assert measuring_sheet(looked_at, ankle).doubt is None
    # What nobody confirmed is not carried on, either.
    again = carry_landmarks(today(marked), proposed, "right")
    assert set(reasons(again).values()) == {"carried.unconfirmed"}


def test_a_limb_whose_parts_stayed_as_they_were_is_told_surely(marked: Limb) -> None:
    """Growth alone: no part moves beside the rest, so that even a plain shank tells its places."""
    size = 1.02
    grown = replace(
        marked,
        mesh=marked.mesh.with_vertices(size * marked.mesh.vertices_mm),
        landmarks=tuple(
            replace(mark, position_mm=size * mark.position_mm) for mark in marked.landmarks
        ),
    )
    found = carry_landmarks(today(grown), marked, "right")
    off_mm = errors_mm(found, grown)
    stated = {one.landmark.name: one.carrying_mm for one in found.places}
    assert all(off_mm[name] < INSIDE * sigma for name, sigma in stated.items())
    assert max(stated.values()) < 0.5


def test_skin_that_may_slide_is_stated_apart_and_beside_turned_joints_alone(marked: Limb) -> None:
    turned = do_edit(marked, Repose(joint="ankle", by_deg=5.0))
    found = carry_landmarks(today(turned), marked, "right")
    slid = {one.landmark.name: one.sliding_mm for one in found.places if one.sliding_mm > 0}
    assert set(slid) == {"medial malleolus", "lateral malleolus"}
    size_mm = float(np.sqrt(marked.mesh.area_mm2()))
    for mm in slid.values():  # 3 % of the size for a radian; parts turn about as far as the joint
        assert 0.7 < mm / (0.03 * size_mm * np.radians(5.0)) < 1.5
    for one in found.places:
        whole = np.hypot(one.carrying_mm, one.sliding_mm)  # the marked ones lie exactly
        assert one.landmark.sigma_mm == pytest.approx(whole)


def test_the_record_s_sheet_names_what_each_figure_goes_by_unconfirmed(marked: Limb) -> None:
    marks = tuple(replace(one, confirmed=one.name != "navicular") for one in marked.landmarks)
    assert isinstance(marked, AlignedLimb)
    under = 0.5 * sum(marked.landmark(f"{one} malleolus").position_mm for one in SIDES)
    stood = Rigid(np.eye(3), -under * np.array([1.0, 1.0, 0.0]))
    limb = marked.with_frame(replace(marked.frame, limb_from_mesh=stood))
    limb = replace(limb, landmarks=marks)
    source = ShapeSource(limb=limb, sha256=64 * "a", kind="PLY", limb_file_sha256=None)
    record = record_of(source)
    report = record_report(record.content, record.pictures)
    (section,) = (one for one in report.sections if one.title == "Measuring sheet")
    (table,) = (one for one in section.blocks if isinstance(one, Table))
    said = {row[0]: row[-1] for row in table.rows}
    assert said["Height of the navicular"] == "navicular (not confirmed)"
    assert said["Height of the lateral malleolus"] == ""
