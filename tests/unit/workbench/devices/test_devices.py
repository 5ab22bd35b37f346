"""Devices: each preset becomes one closed solid as thick as asked, again to the byte, editable."""

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.unit.workbench.devices.shapes import make_foot

from limbgram.core.errors import EditError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import find_edges, volume_mm3
from limbgram.findings import Finding, Value
from limbgram.findings.tell import filled, terms
from limbgram.formats.threemf import write_3mf
from limbgram.workbench.anatomy.known_kinds import KIND_NAMED
from limbgram.workbench.devices.body import Body
from limbgram.workbench.devices.device import WallZone, devices
from limbgram.workbench.devices.making import Order, make_device, preview_device
from limbgram.workbench.devices.proof import require_solid
from limbgram.workbench.edits.offset import Offset
from limbgram.workbench.edits.repose import Repose
from limbgram.workbench.edits.roll import Roll
from limbgram.workbench.limb import KINDS, Landmark, Limb
from limbgram.workbench.recipe.recipe import Entry, Recipe

DEVICES = devices()
GIVEN = {"ischial-containment-socket": {"ramus_deg": 30.0, "skeletal_ml_mm": 140.0}}
QUICK = "foot-orthosis"
OF_EACH_MAKE = ("hinged-afo-calf", "ucbl", "tlso-front", "tsb-socket")
"""A shell with a joint, a cup, a trunk, a socket on its plate: each takes up to half a
minute. Edges of all devices are drawn at the corners of their ranges in test_trims."""
EPICONDYLES = {"lateral femoral epicondyle", "medial femoral epicondyle"}
"""Known by name, though no place of the transtibial limb's own list."""


def test_every_device_is_complete() -> None:
    assert len(DEVICES) >= 15
    assert "head" not in {one.kind for one in DEVICES.values()}  # measured, and no more
    for name, device in DEVICES.items():
        assert device.name == name
        assert device.kind in KINDS
        assert device.en
        assert device.de != device.en or name == "ucbl"
        for made in device.wall:
            measures = device.measures(made)
            assert len({one.name for one in measures}) == len(measures)
            for one in measures:
                assert one.en, one.name
                assert one.de, one.name
                assert one.name.endswith(("_mm", "_deg"))
                assert one.usual is None or one.within.holds(one.usual)


def test_refusals_name_devices_and_their_parts_in_german() -> None:
    for device in DEVICES.values():
        assert filled("{name:term}", {"name": device.en}, "de") == device.de
        parts = [
            *(loop.name for loop in device.trim.loops),
            *(f"{one.name}: {point.name}" for one in device.trim.loops for point in one.points),
            *(loop.keeps.name for loop in device.trim.loops),
            *(one.name for one in (*device.slots, *device.pads, *device.ridges)),
            *(f"{one.name}, hole" for one in device.seats),
        ]
        for part in parts:
            pieces = re.split(", |: ", part)
            assert all(f"part {one}" in terms("de") for one in pieces), part
            assert filled("{what:part}", {"what": part}, "de").count(", ") == part.count(", ")
    assert filled("{what:part}", {"what": "brim: scoop, lateral"}, "de") == (
        "Schaftrand: Sehnenmulde, lateral"
    )


def test_every_landmark_of_a_device_is_known_of_its_kind_of_limb() -> None:
    for device in DEVICES.values():
        known = {place.identity for place in KIND_NAMED[device.kind].places}
        assert set(device.landmarks) <= known | EPICONDYLES
        assert {device.label.at.at, device.label.at.towards or "heel"} <= known | {"heel"}


@pytest.mark.parametrize(("name", "front"), [("tlso-front", 1), ("tlso-back", -1)])
def test_straps_of_a_trunk_lie_beside_the_opening(
    bodies: dict[str, Limb], name: str, front: int
) -> None:
    preview = preview_device(bodies["torso"], Order(device=name, made="printed"))
    body = preview.body
    waist_mm = 0.5 * (body.place_mm("right waist") + body.place_mm("left waist"))[2]
    straps = [one for one in preview.device.slots if one.strap]
    assert len(straps) == 6
    for slot, opening in zip(preview.device.slots, preview.openings, strict=False):
        x, y, z = opening.middle_mm
        if slot.name.startswith("waist"):
            assert z == pytest.approx(waist_mm, abs=0.01)
        # To the slot's side, 2.5 mm from its middle; the surface turns by a few degrees there.
        assert abs(x) - preview.values["gap_mm"] / 2 == pytest.approx(22.5, abs=0.6)
        assert (x > 0) == slot.name.endswith("right")
        assert y * front > 50
    assert not preview.findings


def test_straps_over_bone_or_half_in_a_roll_are_told(bodies: dict[str, Limb]) -> None:
    limb = bodies["torso"]
    waist_mm = float(Body.of(limb).place_mm("right waist")[2])
    beside = limb.frame.limb_from_mesh.inverse.apply(np.array([[43.0, 78.0, waist_mm + 5]]))[0]
    sore = Landmark(name="scar", position_mm=beside)
    marked = replace(limb, landmarks=(*limb.landmarks, sore))
    roll = Roll(depth_mm=8.0, band_mm=30.0, at_mm=waist_mm + 25.0)
    recipe = Recipe(name="", entries=(Entry(edit=roll),))
    one = {"chest_strap_mm": 0.0, "pelvis_strap_mm": 0.0}
    order = Order(device="tlso-front", made="printed", recipe=recipe, values=one)
    told = {(one.code, one.values["name"]) for one in preview_device(marked, order).findings}
    assert told == {
        ("device.strap.on_place", "waist strap, right"),
        ("device.strap.roll", "waist strap, right"),
        ("device.strap.roll", "waist strap, left"),
    }
    none = replace(order, values={**one, "waist_strap_mm": 0.0})
    assert not preview_device(marked, none).findings


def test_advice_to_choose_less_names_no_measure_that_is_at_its_least() -> None:
    """An ankle a quarter as thick: ears yield to their least, unless somebody gave another size."""
    order = Order(device="hinged-afo-calf")

    def advised(order: Order) -> set[Value]:
        with pytest.raises(EditError) as refused:
            preview_device(make_foot(size=0.25), order)
        found = refused.value.finding
        assert found.code == "device.trim.beside_limb"
        labels = found.values["labels"]
        assert isinstance(labels, tuple)
        return {one.values["name"] for one in labels if isinstance(one, Finding)}

    assert "ear_mm" not in advised(order)
    assert "ear_mm" in advised(replace(order, values={"ear_mm": 20.0}))


@pytest.mark.slow
def test_a_strap_too_near_another_is_told_with_the_width_that_fits(bodies: dict[str, Limb]) -> None:
    """Slots keep the ends at their edges, the waist's its middle: a bridge loses 1.5 W + 3 mm."""
    widths = ("chest_strap_mm", "waist_strap_mm", "pelvis_strap_mm")
    wide = dict.fromkeys(widths, 50.0)
    values = {**wide, "waist_strap_up_mm": 40.0, "chest_strap_below_mm": 50.0}
    order = Order(device="tlso-front", made="printed", values=values)
    narrow = preview_device(
        bodies["torso"], replace(order, values={**values, **dict.fromkeys(widths, 10.0)})
    )
    slots = {one.name: one for one in narrow.openings}
    chest, waist = slots["chest strap, right"], slots["waist strap, right"]
    bridge_mm = float(np.linalg.norm(chest.middle_mm - waist.middle_mm)) - 13.0
    fits_mm = 10 + np.floor((bridge_mm - narrow.values["wall_mm"]) / 1.5)
    with pytest.raises(EditError) as refused:
        preview_device(bodies["torso"], order)
    told = refused.value.finding
    assert told.code == "device.opening.edge"
    assert {told.values["name"], told.values["beside"]} == {
        "waist strap, right",
        "chest strap, right",
    }
    assert told.values["fits_mm"] == pytest.approx(fits_mm, abs=1)
    fitting = {**values, **dict.fromkeys(widths, told.values["fits_mm"])}
    preview_device(bodies["torso"], replace(order, values=fitting))


@pytest.mark.slow
def test_straps_spread_unless_somebody_said_where(bodies: dict[str, Limb]) -> None:
    """The chest strap is put down to the waist's: that one moves down, or is refused if given."""
    order = Order(device="tlso-front", made="printed", values={"chest_strap_below_mm": 80.0})
    moved = preview_device(bodies["torso"], order)
    (told,) = moved.findings
    assert told.code == "device.strap.moved"
    assert moved.values["waist_strap_up_mm"] < 0
    assert moved.values["chest_strap_below_mm"] == 80.0
    again = preview_device(bodies["torso"], replace(order, values=moved.values))
    assert not again.findings
    for one, two in zip(moved.openings, again.openings, strict=True):
        assert one.middle_mm.tobytes() == two.middle_mm.tobytes()
    given = replace(order, values={**order.values, "waist_strap_up_mm": 0.0})
    with pytest.raises(EditError, match="chest strap"):
        preview_device(bodies["torso"], given)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["tlso-front", "tlso-back"])
def test_each_strap_of_a_trunk_adds_two_holes(bodies: dict[str, Limb], name: str) -> None:
    none = {f"{one}_strap_mm": 0.0 for one in ("chest", "waist", "pelvis")}
    for values, count in ((none, 0), ({**none, "waist_strap_mm": 38.0}, 2), ({}, 6)):
        order = Order(device=name, made="printed", values=values)
        solid = make_device(bodies["torso"], order).solid
        euler = len(solid) - len(find_edges(solid.faces).ends) + len(solid.faces)
        assert (2 - euler) // 2 == count


@pytest.mark.parametrize("name", [name for name, one in DEVICES.items() if one.pads])
def test_the_distal_pad_lies_round_the_distal_end(bodies: dict[str, Limb], name: str) -> None:
    values = {"strip_mm": 0.0, **GIVEN.get(name, {})}
    order = Order(device=name, made="printed", values=values)
    drawn = preview_device(bodies[DEVICES[name].kind], order)
    added = drawn.layout.thickness_mm - drawn.values["wall_mm"]
    thick = added > 0.5 * drawn.values["pad_mm"]
    off = drawn.layout.positive.vertices_mm[thick] - drawn.body.place_mm("distal end")
    for along in (off[:, 0], off[:, 1]):
        assert -along.min() == pytest.approx(along.max(), abs=4.0)
        assert along.max() > 20


def test_ribs_behind_the_malleoli_stiffen_a_printed_wall_and_no_sheet(
    bodies: dict[str, Limb],
) -> None:
    plain = Order(device="solid-afo", made="printed")
    ribbed = preview_device(bodies["foot"], replace(plain, values={"rib_mm": 3.0}))
    layout, wall_mm = ribbed.layout, ribbed.values["wall_mm"]
    added = layout.thickness_mm - wall_mm
    assert added.max() == pytest.approx(3.0, abs=1e-6)
    assert preview_device(bodies["foot"], plain).layout.thickness_mm.max() == wall_mm
    for name, sign in (("lateral malleolus", 1), ("medial malleolus", -1)):
        _, y, z = ribbed.body.place_mm(name)
        x_mm, y_mm, z_mm = layout.positive.vertices_mm[
            (added > 2.9) & (layout.positive.vertices_mm[:, 0] * sign > 0)
        ].T
        assert (y_mm < y).all()  # behind it, from the heel to the calf, within the shell
        assert z_mm.min() < z - 10 < z + 40 < z_mm.max()
        assert (np.abs(x_mm) > 5).all()
    assert (layout.beyond_mm[added > 2.9] < 0).all()
    with pytest.raises(EditError) as refused:
        preview_device(bodies["foot"], replace(plain, made="draped", values={"rib_mm": 3.0}))
    assert refused.value.finding.code == "device.value.unknown"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hinged-afo-calf", "hinged-afo-foot"])
def test_a_stop_has_a_seat_with_one_hole_more(bodies: dict[str, Limb], name: str) -> None:
    plain = make_device(bodies["foot"], Order(device=name, made="printed"))
    order = Order(device=name, made="printed", values={"stop_hole_mm": 5.0})
    seated = make_device(bodies["foot"], order)

    def holes(solid: Mesh) -> int:
        """Of a closed solid in one piece: half of 2 less vertices, edges and faces by Euler."""
        return (2 - (len(solid) - len(find_edges(solid.faces).ends) + len(solid.faces))) // 2

    assert holes(seated.solid) == holes(plain.solid) + 1
    # A disc of radius 8 mm over the wall by 1.5 mm, less its hole; the back is round beneath it.
    disc_mm3 = np.pi * (8.0**2 - 2.5**2) * 1.5
    assert 0.8 < (volume_mm3(seated.solid) - volume_mm3(plain.solid)) / disc_mm3 < 1.6


@pytest.mark.slow
@pytest.mark.parametrize("name", DEVICES)
def test_every_device_has_room_for_a_name_a_side_and_a_date(
    bodies: dict[str, Limb], name: str
) -> None:
    order = Order(
        device=name, made="printed", values=GIVEN.get(name, {}), lettering="A.M. left 11/26"
    )
    made = make_device(bodies[DEVICES[name].kind], order)
    plain = make_device(bodies[DEVICES[name].kind], replace(order, lettering=""))
    require_solid(made.solid)
    assert 50 < volume_mm3(made.solid) - volume_mm3(plain.solid) < 400


@pytest.mark.slow
@pytest.mark.parametrize("name", OF_EACH_MAKE)
def test_a_device_of_each_make_is_one_solid_as_thick_as_asked(
    bodies: dict[str, Limb], name: str, tmp_path: Path
) -> None:
    device = DEVICES[name]
    made = make_device(bodies[device.kind], Order(device=name, values=GIVEN.get(name, {})))
    require_solid(made.solid)
    assert made.wall.off_mm < 0.05
    assert made.wall.thinnest_mm > made.preview.thinnest_mm - 0.05
    assert volume_mm3(made.solid) > 1e4
    assert "device.not_tested" in {one.code for one in made.findings}
    if shutil.which("prusa-slicer"):
        path = write_3mf(made.solid, tmp_path / "device.3mf", "mm")
        said = subprocess.run(
            ["prusa-slicer", "--info", str(path)], capture_output=True, text=True, check=True
        ).stdout
        assert "manifold = yes" in said
        assert "repair" not in said
        assert "number_of_parts =  1" in said


def test_the_same_order_gives_the_same_bytes_and_the_wall_as_asked() -> None:
    foot = make_foot(size=0.7)
    order = Order(device=QUICK, made="printed", values={"wall_mm": 3.0})
    one = make_device(foot, order)
    two = make_device(foot, order)
    assert one.solid.vertices_mm.tobytes() == two.solid.vertices_mm.tobytes()
    assert one.solid.faces.tobytes() == two.solid.faces.tobytes()
    require_solid(one.solid)
    known = one.thickness_mm[np.isfinite(one.thickness_mm)]
    assert len(known) > 0.3 * len(one.solid)
    np.testing.assert_allclose(np.median(known), 3.0, atol=0.02)
    assert one.wall.thinnest_mm > 2.85


def test_what_is_edited_after_changes_what_it_says(bodies: dict[str, Limb]) -> None:
    """The recipe moves the positive, a value its edge; the rest stays."""
    foot = bodies["foot"]
    plain = preview_device(foot, Order(device=QUICK))
    larger = Recipe(name="", entries=(Entry(edit=Offset(distance_mm=2.0)),))
    grown = preview_device(foot, Order(device=QUICK, recipe=larger))
    sizes = [np.ptp(one.layout.positive.vertices_mm, axis=0)[0] for one in (plain, grown)]
    assert sizes[1] - sizes[0] == pytest.approx(4.0, abs=0.3)
    deeper = preview_device(foot, Order(device=QUICK, values={"cup_mm": 20.0}))
    heights = [
        next(one.point_mm[2] for one in seen.handles if one.point == "heel, behind")
        for seen in (plain, deeper)
    ]
    assert heights[1] - heights[0] == pytest.approx(20.0 - 14.0, abs=0.3)


@pytest.mark.parametrize(
    ("values", "zones", "cause"),
    [
        pytest.param({"rib_mm": 5.0}, (), ("device.measure", "rib_mm"), marks=pytest.mark.slow),
        (
            {},
            (("heel", 1.0), ("lateral malleolus", 10.0)),
            ("device.zone", "lateral malleolus"),
        ),
    ],
)
def test_what_makes_a_wall_fold_is_named(
    values: dict[str, float], zones: tuple[tuple[str, float], ...], cause: tuple[str, str]
) -> None:
    """The same device without it is made, so that it alone is the cause."""
    child = make_foot(size=0.65)
    order = Order(
        device="solid-afo",
        made="printed",
        values=values,
        zones=tuple(WallZone(at=at, add_mm=add_mm, reach_mm=10.0) for at, add_mm in zones),
    )
    with pytest.raises(EditError) as refused:
        make_device(child, order)
    assert refused.value.finding.code == "device.folds"
    (named,) = refused.value.finding.values["causes"]
    assert (named.code, named.values.get("name", named.values.get("place"))) == cause
    assert "it would not without: " in str(refused.value)
    make_device(child, replace(order, values={}, zones=order.zones[:1]))


@pytest.mark.parametrize(("size", "below_mm"), [(0.5, 110.0), (0.45, 110.0), (0.6, 140.0)])
def test_an_edge_that_crosses_itself_names_the_measures_that_set_it(
    size: float, below_mm: float
) -> None:
    """On a child's leg the front shell would end below the ankle: less of that measure does."""
    child = make_foot(size=size)
    order = Order(device="ground-reaction-afo", values={"shell_below_mm": below_mm})
    with pytest.raises(EditError) as refused:
        preview_device(child, order)
    said = refused.value.finding
    assert said.code == "device.trim.crosses"
    assert "shell_below_mm" in said.values["measures"]
    assert "Lower edge of the front shell" in str(refused.value)
    assert not {"below_fibula_mm", "over_tubercle_mm"} & set(said.values["measures"])
    preview_device(child, replace(order, values={"shell_below_mm": 90.0}))


def test_a_draped_sheet_thins_over_the_heel_and_the_minimum_is_told(
    bodies: dict[str, Limb],
) -> None:
    seen = preview_device(bodies["foot"], Order(device="ucbl"))
    assert seen.made == "draped"
    assert 0.55 * 4.8 < seen.thinnest_mm < 0.85 * 4.8
    x, y, z = seen.thinnest_point_mm
    assert y < -40  # at the heel
    assert z < 30
    assert abs(x) < 40


def test_a_width_that_contradicts_the_patient_is_pointed_out(bodies: dict[str, Limb]) -> None:
    def found(ml_mm: float) -> tuple[str, float]:
        order = Order(
            device="ischial-containment-socket",
            values={"ramus_deg": 30.0, "skeletal_ml_mm": ml_mm},
        )
        (one,) = preview_device(bodies["transfemoral"], order).findings
        assert one.code == "device.width"
        value = one.values["positive_mm"]
        assert isinstance(value, float)
        return one.gravity.value, value

    gravity, own = found(90.0)
    assert gravity == "doubt"
    assert found(own)[0] == "note"


@pytest.mark.parametrize(
    ("order", "code"),
    [
        (Order(device="solid afo"), "device.unknown"),
        (Order(device="tlso-front"), "device.kind"),
        (Order(device=QUICK, values={"sheet_mm": 30.0}), "device.value.range"),
        (Order(device=QUICK, made="printed", values={"sheet_mm": 4.0}), "device.value.unknown"),
    ],
)
def test_orders_that_cannot_be_meant_are_refused(
    bodies: dict[str, Limb], order: Order, code: str
) -> None:
    with pytest.raises(EditError) as refused:
        preview_device(bodies["foot"], order)
    assert refused.value.finding.code == code


def test_all_landmarks_that_lack_are_named_at_once(bodies: dict[str, Limb]) -> None:
    foot = bodies["foot"]
    lacks = ("lateral malleolus", "second toe")
    limb = replace(foot, landmarks=tuple(one for one in foot.landmarks if one.name not in lacks))
    with pytest.raises(EditError) as refused:
        preview_device(limb, Order(device="solid-afo"))
    told = refused.value.finding
    assert told.code == "anatomy.missing"
    assert set(told.values["names"]) == set(lacks)  # type: ignore[arg-type]


def test_a_point_off_the_limb_is_refused_with_its_landmark(bodies: dict[str, Limb]) -> None:
    """The fibula head marked at the sole: the upper edge would lie below it."""
    foot = bodies["foot"]
    heel = foot.landmark("heel").position_mm
    marks = tuple(
        replace(one, position_mm=heel) if one.name == "fibula head" else one
        for one in foot.landmarks
    )
    with pytest.raises(EditError, match="placed by the landmark fibula head") as refused:
        preview_device(replace(foot, landmarks=marks), Order(device="posterior-leaf-spring"))
    assert refused.value.finding.code == "device.trim.off_limb"


def test_a_landmark_on_the_wrong_side_is_refused(bodies: dict[str, Limb]) -> None:
    foot = bodies["foot"]
    swapped = {"lateral malleolus": "medial malleolus", "medial malleolus": "lateral malleolus"}
    marks = tuple(replace(one, name=swapped.get(one.name, one.name)) for one in foot.landmarks)
    other = replace(foot, frame=replace(foot.frame, side="left"))
    for limb in (replace(foot, landmarks=marks), other):
        with pytest.raises(EditError) as refused:
            preview_device(limb, Order(device="solid-afo"))
        found = refused.value.finding
        assert (found.code, found.values["what"]) == (
            "device.wrong_side",
            "Solid ankle-foot orthosis",
        )


def test_of_unconfirmed_landmarks_a_device_names_those_that_it_goes_by(
    bodies: dict[str, Limb],
) -> None:
    foot = bodies["foot"]
    every = {one.name for one in foot.landmarks}

    def named(*open_names: str, turn: bool = False) -> set[str]:
        marks = tuple(replace(one, confirmed=one.name not in open_names) for one in foot.landmarks)
        edits = (Entry(edit=Repose(joint="ankle", by_deg=1.0)),) if turn else ()
        order = Order(device=QUICK, recipe=Recipe(name="", entries=edits))
        said = preview_device(replace(foot, landmarks=marks), order).findings
        found = [one.values["names"] for one in said if one.code == "landmark.unconfirmed"]
        assert len(found) <= 1
        return {name for names in found if isinstance(names, tuple) for name in map(str, names)}

    uses = every & set(DEVICES[QUICK].landmarks)
    assert "heel" in uses
    assert "medial malleolus" in every - uses
    assert named(*every) == uses
    assert named(*(every - uses)) == set()
    assert {"medial malleolus", "lateral malleolus"} <= named(*every, turn=True)
