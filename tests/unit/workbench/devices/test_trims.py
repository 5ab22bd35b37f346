"""Trims: points where anatomy says, curves on the surface, closed, whole at the ends of ranges."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial import Delaunay, KDTree
from tests.unit.workbench.devices.conftest import BodyOf
from tests.unit.workbench.devices.shapes import make_foot

from limbgram.core.errors import EditError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.sections import cut
from limbgram.core.mesh.topology import with_faces
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.workbench.devices.body import Body
from limbgram.workbench.devices.device import Device, devices
from limbgram.workbench.devices.layout import Opening, _depth_in_opening, _require_bridge, cover
from limbgram.workbench.devices.presets.ankle import LEAF_SPRING, SOLID
from limbgram.workbench.devices.trims import (
    _side_above_sole,
    amount_of,
    draw_trim,
    mirrored_points,
    place_point,
    values_of,
    values_on_slender_limb,
)
from limbgram.workbench.limb import Limb

DEVICES = devices()
GIVEN = {"ramus_deg": 30.0, "skeletal_ml_mm": 140.0}
"""What nobody may guess."""


def values_for(device: Device, at: str) -> dict[str, float]:
    """All measures of a trim at an end of their ranges, or every other one at the other end."""
    found: dict[str, float] = {}
    for number, one in enumerate(device.trim.measures):
        ends = one.within.least, one.within.most
        usual = GIVEN.get(one.name) if one.usual is None else one.usual
        found[one.name] = {
            "usual": usual,
            "least": ends[0],
            "most": ends[1],
            "in turn": ends[number % 2],
            "in turn, other": ends[1 - number % 2],
        }[at]
    return found


@pytest.mark.parametrize(
    ("name", "at"),
    [
        pytest.param(name, at, marks=[pytest.mark.slow] * (at != ("least", "most")[number % 2]))
        for number, name in enumerate(DEVICES)
        for at in ("usual", "least", "most", "in turn", "in turn, other")
    ],
)
def test_edges_are_whole_at_the_corners_of_their_ranges(
    body_of: BodyOf, name: str, at: str
) -> None:
    device = DEVICES[name]
    body = body_of(device.kind)
    drawn = draw_trim(body, device.trim, values_for(device, at))
    for edge in drawn.edges:
        closest = tree_on(body.mesh).closest(edge.curve.points_mm)
        assert closest.distances_mm.max() < 1e-9
        steps = np.roll(edge.curve.points_mm, -1, axis=0) - edge.curve.points_mm
        assert np.linalg.norm(steps, axis=1).max() < 1.5  # closed, and no jump
    covered = cover(body, drawn.edges)  # refuses a curve that crosses itself
    assert 0.05 < (covered.beyond_mm < 0).mean() < 0.95


def test_points_lie_where_anatomy_says(body_of: BodyOf) -> None:
    body = body_of("foot")
    values = values_of(SOLID.measures, {"ankle_lateral_mm": 9.0, "below_fibula_mm": 30.0})
    places = {one.point: np.array(one.point_mm) for one in draw_trim(body, SOLID, values).handles}
    malleolus = body.place_mm("lateral malleolus")
    ankle = places["ankle, lateral"]
    np.testing.assert_allclose((ankle - malleolus)[1:], [9.0, 0.0], atol=1e-4)
    assert ankle[0] > 20  # lateral, on a right foot
    assert places["ankle, medial"][0] < -20
    fibula = body.place_mm("fibula head")
    assert places["top, behind"][2] == pytest.approx(fibula[2] - 30.0, abs=1e-4)
    assert places["top, behind"][1] < -40


def test_a_leaf_spring_is_narrowest_over_the_ankle_axis_as_its_measure_says(
    body_of: BodyOf,
) -> None:
    body = body_of("foot")
    drawn = draw_trim(body, LEAF_SPRING, values_of(LEAF_SPRING.measures, {}))
    malleoli = np.stack([body.place_mm(f"{one} malleolus") for one in ("lateral", "medial")])
    height = next(one for one in LEAF_SPRING.measures if one.name == "spring_height_mm")
    spring = [one for one in drawn.handles if one.measure == height.name]
    assert len(spring) == 2
    for one in spring:
        over_axis_mm = one.point_mm[2] - malleoli[:, 2].mean()
        assert over_axis_mm == pytest.approx(height.usual, abs=1e-3)
    assert "over the ankle axis" in height.en
    assert "über der Knöchelachse" in height.de


def test_a_left_limb_has_the_same_edges_mirrored(body_of: BodyOf) -> None:
    values = values_of(SOLID.measures, {"ankle_lateral_mm": 8.0, "wall_medial_mm": 36.0})
    right = draw_trim(body_of("foot"), SOLID, values)
    left = draw_trim(Body.of(make_foot("left")), SOLID, values)
    for one, other in zip(right.handles, left.handles, strict=True):
        mirror = np.array(other.point_mm) * [-1, 1, 1]
        np.testing.assert_allclose(mirror, one.point_mm, atol=0.05)
    (edge,), mirrored = right.edges, left.edges[0].curve.points_mm * [-1, 1, 1]
    assert KDTree(mirrored).query(edge.curve.points_mm)[0].max() < 0.5  # as far as points lie apart


def test_a_handle_goes_where_it_says(body_of: BodyOf) -> None:
    body = body_of("foot")
    values = values_of(SOLID.measures, {})
    handles = {one.point: one for one in draw_trim(body, SOLID, values).handles}
    handle = handles["ankle, lateral"]
    assert (handle.measure, handle.least, handle.most) == ("ankle_lateral_mm", 5, 15)
    assert handle.along is not None
    np.testing.assert_allclose(handle.along[1:], [1.0, 0.0], atol=1e-3)
    moved = draw_trim(body, SOLID, {**values, "ankle_lateral_mm": values["ankle_lateral_mm"] + 1})
    there = next(one for one in moved.handles if one.point == "ankle, lateral")
    step = np.array(there.point_mm) - handle.point_mm
    np.testing.assert_allclose(step, handle.along, atol=0.15)
    others = {one.point: one.point_mm for one in moved.handles if one.point != "ankle, lateral"}
    assert all(handles[name].point_mm == place for name, place in others.items())


def test_a_point_that_was_set_free_stays(body_of: BodyOf) -> None:
    body = body_of("foot")
    values = values_of(SOLID.measures, {})
    first = {one.point: one.point_mm for one in draw_trim(body, SOLID, values).handles}
    x, y, z = first["wall, lateral"]
    free = {"edge: wall, lateral": (x, y + 6.0, z + 3.0)}
    drawn = draw_trim(body, SOLID, {**values, "wall_lateral_mm": 40.0}, free)
    handle = next(one for one in drawn.handles if one.point == "wall, lateral")
    assert handle.measure is None
    assert np.linalg.norm(np.subtract(handle.point_mm, free["edge: wall, lateral"])) < 3.0
    for name, place, code in (
        ("edge: wall", (x, y, z), "device.trim.no_point"),
        ("edge: wall, lateral", (x + 40.0, y, z), "device.trim.free_off"),
    ):
        with pytest.raises(EditError) as refused:
            draw_trim(body, SOLID, values, {name: place})
        assert refused.value.finding.code == code


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ({"ankle_lateral_mm": 15.1}, "device.value.range"),
        ({"ankle_lateral_mm": 4.9}, "device.value.range"),
        ({"ankle_lateral_mm": float("nan")}, "device.value.range"),
        ({"ankel_mm": 7.0}, "device.value.unknown"),
    ],
)
def test_values_beyond_their_ranges_are_refused(given: dict[str, float], code: str) -> None:
    with pytest.raises(EditError) as refused:
        values_of(SOLID.measures, given)
    assert refused.value.finding.code == code


def test_what_differs_between_patients_is_never_guessed() -> None:
    trim = DEVICES["ischial-containment-socket"].trim
    with pytest.raises(EditError) as refused:
        values_of(trim.measures, {})
    assert refused.value.finding.code == "device.value.needed"
    assert refused.value.finding.values["name"] == "ramus_deg"


def test_the_ramus_turns_the_medial_brim(body_of: BodyOf) -> None:
    trim = DEVICES["ischial-containment-socket"].trim
    body = body_of("transfemoral")
    angles: list[float] = []
    for ramus in (10.0, 40.0):
        drawn = draw_trim(body, trim, values_of(trim.measures, {"ramus_deg": ramus}))
        x, y, _ = next(one.point_mm for one in drawn.handles if one.point == "ramus")
        angles.append(float(np.degrees(np.arctan2(-x, y))))
    np.testing.assert_allclose(angles, [100.0, 130.0], atol=2.0)


def refusals(bodies: dict[str, Limb]) -> Iterator[tuple[Limb, str]]:
    foot = bodies["foot"]
    lacking = tuple(one for one in foot.landmarks if one.name != "medial malleolus")
    yield replace(foot, landmarks=lacking), "edit.landmark.none"
    yield replace(foot, frame=replace(foot.frame, side="none")), "device.no_side"
    yield foot.unaligned(), "edit.not_aligned"
    vertices = foot.frame.limb_from_mesh.apply(foot.mesh.vertices_mm)

    def without(gone: np.ndarray) -> Limb:
        kept = ~gone[foot.mesh.faces].any(1)
        mesh: Mesh = with_faces(foot.mesh, foot.mesh.faces[kept])
        return replace(foot, mesh=mesh)

    yield without(vertices[:, 2] > 290), "device.trim.off_limb"  # too short for its upper edge
    yield without(vertices[:, 2] > 315), "device.trim.opening"
    ankle = np.array([42, -2, 70.0])
    yield without(np.linalg.norm(vertices - ankle, axis=1) < 12), "device.trim.off_limb"
    front = np.array([41, 3, 110.0])
    yield without(np.linalg.norm(vertices - front, axis=1) < 14), "device.trim.opening"


def test_what_cannot_be_drawn_is_refused_with_the_place(bodies: dict[str, Limb]) -> None:
    values = values_of(SOLID.measures, {})
    for limb, code in refusals(bodies):
        with pytest.raises(EditError) as refused:
            draw_trim(Body.of(limb), SOLID, values)
        assert refused.value.finding.code == code
        if code.startswith("device.trim"):
            assert len(refused.value.finding.values["point_mm"]) == 3


def test_a_point_beside_a_slender_limb_is_refused_with_its_measures(
    body_of: BodyOf,
) -> None:
    """A joint's ear, 14 mm in front of a malleolus, on an ankle that is a quarter as thick."""
    foot, calf = body_of("foot").limb, DEVICES["hinged-afo-calf"].trim
    slender = replace(
        foot,
        mesh=foot.mesh.with_vertices(0.25 * foot.mesh.vertices_mm),
        landmarks=tuple(replace(one, position_mm=0.25 * one.position_mm) for one in foot.landmarks),
    )
    values = values_of(calf.measures, {"ear_mm": 14.0, "below_fibula_mm": 15.0})
    with pytest.raises(EditError) as refused:
        draw_trim(Body.of(slender), calf, values)
    told = refused.value.finding
    assert told.code == "device.trim.beside_limb"
    assert told.values["what"] == "edge: ankle, lateral"
    assert set(told.values["measures"]) == {"ear_mm", "joint_gap_mm"}
    ankle = next(one for one in slender.landmarks if one.name == "lateral malleolus")
    _, y, z = ankle.position_mm + np.array([0, 14, values["joint_gap_mm"] + 16])
    away = np.hypot(slender.mesh.vertices_mm[:, 1] - y, slender.mesh.vertices_mm[:, 2] - z)
    assert told.values["beside_mm"] == pytest.approx(away.min(), abs=0.01)
    assert away.min() > 0.5


def test_an_ear_yields_to_a_slender_ankle_unless_somebody_gave_its_width() -> None:
    body, calf = Body.of(make_foot("right", 0.5)), DEVICES["hinged-afo-calf"].trim
    usual = values_of(calf.measures, {})
    found = values_on_slender_limb(body, calf, usual, given=())
    assert {name for name in usual if usual[name] != found[name]} == {"ear_mm"}
    room_mm: list[float] = []
    for name in ("lateral malleolus", "medial malleolus"):
        _, y, z = body.place_mm(name) + np.array([0, 0, usual["joint_gap_mm"] + 16])
        ring = cut(body.mesh, [float(z)])[0].points_mm[:, 1]
        room_mm += [float(y - ring.min()), float(ring.max() - y)]
    assert min(room_mm) < usual["ear_mm"]
    assert min(room_mm) - 1.6 < found["ear_mm"] < min(room_mm) - 0.9
    draw_trim(body, calf, found)
    assert values_on_slender_limb(body, calf, usual, given=("ear_mm",)) == usual


def test_a_hole_of_the_scan_inside_the_device_is_refused(bodies: dict[str, Limb]) -> None:
    foot = bodies["foot"]
    vertices = foot.frame.limb_from_mesh.apply(foot.mesh.vertices_mm)
    gone = np.linalg.norm(vertices - [0, -62, 200.0], axis=1) < 12
    mesh = with_faces(foot.mesh, foot.mesh.faces[~gone[foot.mesh.faces].any(1)])
    body = Body.of(replace(foot, mesh=mesh))
    drawn = draw_trim(body, SOLID, values_of(SOLID.measures, {}))
    with pytest.raises(EditError) as refused:
        cover(body, drawn.edges)
    assert refused.value.finding.code == "device.hole"
    np.testing.assert_allclose(refused.value.finding.values["point_mm"], [0, -62, 200], atol=6)


@pytest.mark.parametrize("x_mm", [-16.0, -9.0, 0.0, 9.0])
def test_an_opening_that_leaves_too_narrow_a_bridge_is_refused(x_mm: float) -> None:
    """On a plane, the device ending at x = 0: a slot of 6 mm, upright, its middle at x."""
    x, y = (one.ravel() for one in np.meshgrid(np.arange(-60, 31.0), np.arange(-40, 41.0)))
    plane = Mesh(
        vertices_mm=np.column_stack([x, y, 0 * x]),
        faces=Delaunay(np.column_stack([x, y])).simplices.astype(np.int32),
    )
    slot = Opening(
        name="slot",
        middle_mm=np.array([x_mm, 0.0, 0.0]),
        along=np.array([0.0, 1, 0]),
        length_mm=30.0,
        width_mm=6.0,
        measures=("slot_mm",),
    )
    depth, bridge_mm = _depth_in_opening(plane, slot), -x_mm - 3
    others = [("edge", x), ("vent", x - 10.0)]
    if bridge_mm > 7:
        _require_bridge(plane, x, depth, slot, bridge_mm - 0.5, others)
    with pytest.raises(EditError) as refused:
        _require_bridge(plane, x, depth, slot, max(bridge_mm, 5.0) + 0.5, others)
    told = refused.value.finding
    assert told.code == "device.opening.edge"
    assert told.values["wide_mm"] == pytest.approx(max(bridge_mm, 0.0), abs=0.3)
    assert told.values["measures"] == ("slot_mm",)
    assert told.values["beside"] == "edge"
    assert -17 < told.values["point_mm"][0] < 20
    assert abs(told.values["point_mm"][1]) < 20


def test_a_point_under_the_foot_lies_on_the_lowest_place_of_its_side(
    body_of: BodyOf,
) -> None:
    """On a ball, whose side begins 45 degrees over its lowest place."""
    ball = trimesh.creation.icosphere(6, 50.0)
    mesh = Mesh(vertices_mm=np.array(ball.vertices), faces=ball.faces.astype(np.int32))
    body = Body(replace(body_of("foot").limb, mesh=mesh))
    up = np.array([0.0, 0, 1])
    for height_mm, truth_mm in ((-47.0, -np.sqrt(0.5) * 50.0), (-20.0, -20.0)):
        place = body.first_hit_mm(np.array([0.0, 0, height_mm]), np.array([-1.0, 0, 0]))
        assert place is not None
        found = _side_above_sole(body, place, np.array([-1.0, 0, 0]), up)
        assert found[2] == pytest.approx(truth_mm, abs=0.7)
        assert np.linalg.norm(found) == pytest.approx(50.0, abs=0.05)
        assert found[0] > 0


@pytest.mark.parametrize("below_mm", [80.0, 110.0, 140.0])
def test_a_front_shell_ends_level_wherever_it_ends(body_of: BodyOf, below_mm: float) -> None:
    body = body_of("foot")
    trim = DEVICES["ground-reaction-afo"].trim
    drawn = draw_trim(body, trim, values_of(trim.measures, {"shell_below_mm": below_mm}))
    curve = next(one.curve for one in drawn.edges if one.name == "front opening")
    place = {one.point: one.point_mm for one in drawn.handles if one.loop == "front opening"}
    x, y, z = curve.points_mm.T
    height = body.place_mm("tibial tubercle")[2] - below_mm
    shins = place["shin, medial"], place["shin, lateral"]
    over = (z > height - 60) & (y > shins[0][1]) & (x > shins[0][0]) & (x < shins[1][0])
    assert over.sum() > 20
    assert height - 14 < z[over].min() < z[over].max() < height + 4


def test_a_strap_lies_as_far_behind_the_front_edge_on_any_limb(body_of: BodyOf) -> None:
    body = body_of("foot")
    device = DEVICES["solid-afo"]
    values = values_of(device.measures("printed"), {"strap_back_mm": 14.0})
    for slot, sign in zip(device.slots, (1.0, -1.0), strict=True):
        edge = place_point(body, "", replace(slot.at, round_mm=0.0), values)
        place = place_point(body, "", slot.at, values)
        middle = body.section_centre_mm(float(place[2]))
        angles = [np.arctan2(*(one - middle)[:2]) for one in (edge, place)]
        assert sign * np.degrees(angles[0]) == pytest.approx(72.0, abs=0.1)
        far_mm = sign * (angles[1] - angles[0]) * np.linalg.norm(edge - middle)
        assert far_mm == pytest.approx(14.0, abs=0.05)


def test_a_slot_is_as_long_and_wide_as_asked(body_of: BodyOf) -> None:
    body = body_of("foot")
    drawn = draw_trim(body, SOLID, values_of(SOLID.measures, {}))
    place = body.first_hit_mm(np.array([0.0, -8, 230]), np.array([0.0, 1, 0]))
    assert place is not None
    slot = Opening(
        name="slot", middle_mm=place, along=np.array([0.0, 0, 1]), length_mm=48.0, width_mm=6.0
    )
    covered = cover(body, drawn.edges, [slot])
    hole = covered.positive.vertices_mm[covered.beyond_mm > 0]
    hole = hole[np.linalg.norm(hole - place, axis=1) < 40]
    assert np.ptp(hole[:, 2]) == pytest.approx(48.0, abs=1.6)
    assert np.ptp(hole[:, 0]) == pytest.approx(6.0, abs=1.6)
    edge = np.abs(covered.beyond_mm) < 0.02
    near = edge & (np.linalg.norm(covered.positive.vertices_mm - place, axis=1) < 20)
    np.testing.assert_allclose(
        np.abs(covered.positive.vertices_mm[near, 0] - place[0]), 3.0, atol=0.1
    )


def test_amounts_are_sums_of_measures() -> None:
    values = {"a_mm": 10.0, "b_mm": 4.0}
    assert amount_of(("a_mm", "-b_mm", "0.5*b_mm", -1.0), values) == pytest.approx(7.0)
    point = replace(SOLID.loops[0].points[5], out_mm=("-0.5*a_mm", 2.0))
    (other,) = mirrored_points((point,), {"a_mm": "b_mm"})
    assert amount_of(other.out_mm, values) == pytest.approx(0.0)  # 0.5 b - 2
