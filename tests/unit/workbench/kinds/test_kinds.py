"""Kinds of limb: that the data of each hangs together, and what follows from it."""

import tracemalloc
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import told
from limbgram.findings.tell import terms
from limbgram.workbench.anatomy.centreline import rounded_polyline, straight_centreline
from limbgram.workbench.anatomy.directions import Anatomy
from limbgram.workbench.anatomy.kind import Angle, Kind, Midpoint, SurfaceAxis
from limbgram.workbench.anatomy.known_kinds import KIND_NAMED, KINDS
from limbgram.workbench.anatomy.landmark import Landmark, Placing
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame
from limbgram.workbench.measures.sheet import angle_deg, unit_of

EACH = list(KIND_NAMED.values())


def mids(value: object) -> Iterator[Midpoint]:
    """All middles of landmarks anywhere in a kind's data."""
    if isinstance(value, Midpoint):
        yield value
    elif isinstance(value, tuple):
        for one in value:
            yield from mids(one)
    elif hasattr(value, "__dataclass_fields__"):
        for name in value.__dataclass_fields__:  # type: ignore[attr-defined]
            yield from mids(getattr(value, name))


def anatomy_of(kind: Kind, *, left: bool = False) -> Anatomy:
    """With a place for every landmark, at random."""
    random = np.random.default_rng(3)
    return Anatomy(
        kind=kind,
        places={one.identity: random.normal(0, 100, 3) for one in kind.places},
        left=left,
        frame=np.eye(3),
        origin_mm=np.zeros(3),
    )


def test_the_names_that_files_have_are_kept() -> None:
    assert {"transtibial", "transfemoral", "foot", "torso"} <= set(KINDS)
    assert KINDS[:4] == ("transtibial", "transfemoral", "foot", "torso")


@pytest.mark.parametrize("kind", EACH, ids=lambda kind: kind.name)
def test_a_kinds_data_hang_together(kind: Kind) -> None:
    known = {one.identity for one in kind.places}
    for mid in mids((kind.directions, kind.sheet, kind.joints, kind.centreline)):
        assert set(mid.of) | set(mid.otherwise) <= known
    assert set(kind.presets) <= known
    names = [one.name for one in kind.sheet]
    assert len(set(names)) == len(names)
    assert all(unit_of(name) for name in names)
    assert set(kind.words) == {"en", "de"}
    assert all(one.de for one in kind.places)
    whys = {one.why for one in kind.sensitive}
    assert whys <= set(terms("de"))


@pytest.mark.parametrize("kind", EACH, ids=lambda kind: kind.name)
def test_every_direction_that_is_named_is_there_and_mirrored_with_the_limb(kind: Kind) -> None:
    right = anatomy_of(kind)
    flip = np.array([-1.0, 1.0, 1.0])
    left = Anatomy(
        kind=kind,
        places={name: at * flip for name, at in right.places.items()},
        left=True,
        frame=np.eye(3),
        origin_mm=np.zeros(3),
    )
    asked = {one.name for one in kind.directions}
    for item in kind.sheet:
        for field in ("of", "to", "about", "along", "up", "normal", "holds"):
            name = getattr(item, field, None)
            if isinstance(name, str) and name and name != "centreline":
                asked.add(name)
    asked |= {joint.axis for joint in kind.joints}
    # Those that a surface tells are mirrored with it: tests/truth/anatomy.
    asked -= {one.name for one in kind.directions if isinstance(one, SurfaceAxis)}
    for name in asked - {"right", "anterior", "long axis"}:
        direction = right.axis(name).direction
        assert np.linalg.norm(direction) == pytest.approx(1.0)
        np.testing.assert_allclose(left.axis(name).direction, direction * flip, atol=1e-12)


def test_what_is_missing_is_named() -> None:
    foot = anatomy_of(KIND_NAMED["foot"])
    places = {name: at for name, at in foot.places.items() if name != "lateral malleolus"}
    lacking = Anatomy(kind=foot.kind, places=places, left=False, frame=None, origin_mm=np.zeros(3))
    with pytest.raises(MeasureError) as refused:
        lacking.axis("ankle")
    assert refused.value.finding.values["names"] == ("lateral malleolus",)
    with pytest.raises(MeasureError) as refused:
        lacking.axis("elbow")
    assert refused.value.finding.code == "anatomy.no_axis"
    with pytest.raises(MeasureError) as refused:
        lacking.axis("long axis")
    assert refused.value.finding.code == "align.not_aligned"
    # The tubercle stands in for the head of the fibula.
    del places["fibula head"]
    at = lacking.at(Midpoint(("fibula head",), otherwise=("tibial tubercle",)))
    np.testing.assert_array_equal(at, places["tibial tubercle"])


def test_a_rounded_corner_is_an_arc_that_touches_both_legs() -> None:
    nodes = np.array([[0.0, 0, 300], [0, 0, 0], [0, 120, 0]])
    curve = rounded_polyline(nodes, 0.5)
    radius = 60.0
    assert curve.length_mm == pytest.approx(300 + 120 - 2 * radius + np.pi / 2 * radius, abs=0.1)
    middle = curve.at(240.0 + np.pi / 4 * radius)
    centre = np.array([0.0, radius, radius])
    assert np.linalg.norm(middle.point_mm - centre) == pytest.approx(radius, abs=0.1)
    np.testing.assert_allclose(middle.direction, np.array([0, 1, -1]) / np.sqrt(2), atol=0.02)
    on_shank, on_foot = np.array([[15.0, -20, 200]]), np.array([[-10.0, 100, 25]])
    assert curve.nearest_mm(on_shank)[0] == pytest.approx(100.0, abs=0.1)
    assert curve.nearest_mm(on_foot)[0] == pytest.approx(curve.length_mm - 20.0, abs=0.1)
    beyond = straight_centreline(np.zeros(3), np.array([0, 0, -50.0])).nearest_mm(
        np.array([[3.0, 0, 10]])
    )
    assert beyond[0] == pytest.approx(-10.0)


def test_a_large_scan_finds_its_planes_along_a_centreline_in_little_memory() -> None:
    curve = rounded_polyline(np.array([[0.0, 0, 400], [0, 0, 60], [0, 160, 60]]), 0.85)
    scan = np.random.default_rng(3).normal([0.0, 20.0, 150.0], 60.0, (20_000, 3))
    tracemalloc.start()
    try:
        found = curve.nearest_mm(scan)
        peak_mb = tracemalloc.get_traced_memory()[1] / 2**20
    finally:
        tracemalloc.stop()
    assert peak_mb < 20
    few = scan[::500]
    nearest = np.linalg.norm(few[:, None] - curve.points_mm, axis=2).argmin(1)
    off = ((few - curve.points_mm[nearest]) * curve.directions[nearest]).sum(1)
    between = (nearest > 0) & (nearest < len(curve.points_mm) - 1)
    wanted = (curve.lengths_mm[nearest] + off)[between]
    np.testing.assert_allclose(found[::500][between], wanted, atol=1e-9)


def test_a_placing_error_is_the_landmarks_own_or_that_of_its_way() -> None:
    ways = Placing(click_mm=1.5)
    at = np.zeros(3)
    assert ways.of(Landmark(name="a", position_mm=at)) == 1.5
    assert ways.of(Landmark(name="a", position_mm=at, placed="painted")) == ways.painted_mm
    assert ways.of(Landmark(name="a", position_mm=at, sigma_mm=0.4)) == 0.4


HEAD = {
    "sellion": (0, 90, 10),
    "right tragion": (70, 0, 0),
    "left tragion": (-70, 0, 0),
    "glabella": (0, 88, 35),
}


def test_a_head_gets_its_axes_by_its_landmarks_however_it_lies() -> None:
    corners = np.array([[x, y, z] for x in (-70, 70) for y in (-90, 90) for z in (-60, 110)], float)
    faces = np.array(
        [
            *([0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 5, 1], [0, 4, 5]),
            *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
        ],
        np.int32,
    )
    lay = Rigid.from_rotation_vector(np.array([0.4, -1.1, 0.7]), np.array([5.0, 6, 7]))
    limb = Limb(
        mesh=Mesh(vertices_mm=lay.apply(corners), faces=faces),
        landmarks=tuple(
            Landmark(name=name, position_mm=lay.apply(np.array([at], float))[0])
            for name, at in HEAD.items()
        ),
        kind="head",
    )
    frame = align(limb, AlignOptions(side="none")).frame
    found = {
        one.name: frame.limb_from_mesh.apply(one.position_mm[None])[0] for one in limb.landmarks
    }
    base = [found[name][2] for name in ("sellion", "right tragion", "left tragion")]
    assert np.ptp(base) < 1e-9
    assert found["right tragion"][0] - found["left tragion"][0] == pytest.approx(140.0)
    assert found["sellion"][1] > found["right tragion"][1] + 80
    assert found["glabella"][2] > base[0] + 10


def test_a_bent_tube_is_straight_along_its_centreline() -> None:
    """A shank of 200 mm, an arc of 90 degrees, a foot of 100 mm: places in closed form."""
    curve = rounded_polyline(np.array([[0, 0, 260.0], [0, 0, 0], [0, 160.0, 0]]), 0.375)
    radius_mm = 60.0  # 0.375 of 160 mm, at a right angle
    lengths_mm = np.array([200.0, radius_mm * np.pi / 2, 100.0])
    assert curve.length_mm == pytest.approx(lengths_mm.sum(), rel=1e-4)
    along, round_rad = np.meshgrid(np.linspace(5, 380, 76), np.radians(np.arange(0, 360, 10)))
    turned = np.clip((along - lengths_mm[0]) / radius_mm, 0, np.pi / 2)
    before, after = np.minimum(along, 200.0), np.maximum(along - lengths_mm[:2].sum(), 0.0)
    middles = np.stack(
        [
            np.zeros_like(along),
            radius_mm * (1 - np.cos(turned)) + after,
            260.0 - before - radius_mm * np.sin(turned),
        ],
        axis=-1,
    )
    front = np.stack([np.zeros_like(along), np.cos(turned), np.sin(turned)], axis=-1)
    tube_mm = 25.0
    x, y = tube_mm * np.sin(round_rad), tube_mm * np.cos(round_rad)
    places = middles + y[..., None] * front + x[..., None] * [1.0, 0.0, 0.0]
    found = curve.straightened(places.reshape(-1, 3), np.array([1.0, 0.0, 0.0]))
    wanted = np.stack([x, y, lengths_mm.sum() - along], axis=-1).reshape(-1, 3)
    np.testing.assert_allclose(found, wanted, atol=0.2)  # the curve has a node a millimetre


@pytest.mark.parametrize("kind", EACH, ids=lambda kind: kind.name)
def test_sentences_say_figures_axes_and_joints_by_words(kind: Kind) -> None:
    for language in ("en", "de"):
        known = terms(language)
        assert known[f"kind {kind.name}"] == kind.words[language]
        for item in kind.sheet:
            assert known.get(item.en, item.en) == item.words[language]
        for direction in kind.directions:
            assert f"axis {direction.name}" in known, direction.name
    for joint in kind.joints:
        assert terms("de")[joint.name] == joint.de
        assert joint.reads in {one.name for one in kind.sheet if isinstance(one, Angle)}


def test_what_a_landmark_is_wanted_for_is_said_in_words() -> None:
    trunk = KIND_NAMED["torso"]
    with pytest.raises(MeasureError) as refused:
        Anatomy(kind=trunk, places={}, left=False, frame=np.eye(3), origin_mm=np.zeros(3)).at(
            Midpoint(("right nipple", "left nipple")), "Waist up to the nipple line"
        )
    assert str(refused.value).startswith(
        "Not marked: right nipple and left nipple (needed for: Waist up to the nipple line)."
    )
    assert told(refused.value.finding, "de").startswith(
        "Nicht markiert: rechte Brustwarze und linke Brustwarze (gebraucht für: Taille bis "
        "Brustwarzenlinie)."
    )


@pytest.mark.parametrize("kind", [one for one in EACH if not one.sided], ids=lambda kind: kind.name)
def test_a_kind_without_a_side_is_the_same_whatever_side_somebody_said(kind: Kind) -> None:
    random = np.random.default_rng(5)
    marks = tuple(
        Landmark(name=one.identity, position_mm=random.normal(0, 100, 3)) for one in kind.places
    )
    mesh = Mesh(vertices_mm=np.eye(3), faces=np.array([[0, 1, 2]], np.int32))
    plain, said = (
        AlignedLimb(
            mesh=mesh,
            landmarks=marks,
            kind=kind.name,
            frame=LimbFrame(limb_from_mesh=Rigid.identity(), side=side),
        ).anatomy
        for side in ("none", "left")
    )
    for one in kind.directions:
        np.testing.assert_array_equal(said.axis(one.name).direction, plain.axis(one.name).direction)
    angles = [one for one in kind.sheet if isinstance(one, Angle)]
    assert [angle_deg(said, one) for one in angles] == [angle_deg(plain, one) for one in angles]


def test_a_centreline_through_one_point_twice_is_refused() -> None:
    kind = KIND_NAMED["foot"]
    places = dict(anatomy_of(kind).places)
    for name in ("first metatarsal head", "fifth metatarsal head", "second toe"):
        places[name] = np.array([0.0, 150.0, 0.0])
    foot = replace(anatomy_of(kind), places=places)
    with pytest.raises(MeasureError) as refused:
        foot.centreline()
    assert refused.value.finding.code == "anatomy.on_point"
    assert refused.value.finding.values["names"] == (
        *("first metatarsal head", "fifth metatarsal head"),
        "second toe",
    )


def test_a_centreline_that_folds_back_is_refused() -> None:
    """A ball of the foot marked on the shank: no arc leads from a line back along itself."""
    kind = KIND_NAMED["foot"]
    assert kind.centreline is not None
    places = dict(anatomy_of(kind).places)
    heights_mm = ((0.0, 400.0), (0.0, 0.0), (0.0, 100.0), (150.0, 100.0))
    for mid, (y, z) in zip(kind.centreline.nodes, heights_mm, strict=True):
        places |= dict.fromkeys(mid.of, np.array([0.0, y, z]))
    with pytest.raises(MeasureError) as refused:
        replace(anatomy_of(kind), places=places).centreline()
    assert refused.value.finding.code == "anatomy.on_line"
    assert "heel" in refused.value.finding.values["names"]
