"""Making: a device from an aligned limb and an order.

In      an aligned limb of the device's kind; an Order: the device, its values, free points, and the
        recipe by which the positive is made of the limb.
Out     a Preview (handles, edges, thickness on the positive) at once, or the Made device.
Method  recipe -> positive -> edges -> covered area -> thickness -> shell -> fittings -> proof.
        The same order on the same limb gives the same bytes.
Fails   EditError, with the place: see trims, layout, shell, fittings and proof.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import cast

import numpy as np
from jaxtyping import Float64
from scipy.spatial import KDTree

from limbgram.core.errors import EditError, refusals_about, refusals_saying
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.known_words import likeliest, require_known_words
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.core.mesh.sections import Z_AXIS, cut
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.core.notebook import brief
from limbgram.findings import Finding, doubt, note
from limbgram.workbench.devices.adapter import Alignment, adapter_under
from limbgram.workbench.devices.blocks import Block, Boss
from limbgram.workbench.devices.body import Body
from limbgram.workbench.devices.device import (
    DRAW,
    Device,
    Fabrication,
    Seat,
    Slit,
    Slot,
    WallZone,
    devices,
)
from limbgram.workbench.devices.fittings import Part, hole, imported_part, with_parts
from limbgram.workbench.devices.landmark_uses import landmarks_of_edits
from limbgram.workbench.devices.layout import CoveredArea, Gap, Opening, Rib, cover
from limbgram.workbench.devices.lettering import lettering
from limbgram.workbench.devices.proof import (
    WallThickness,
    fold_findings,
    measure_wall,
    require_solid,
)
from limbgram.workbench.devices.shell import Layout, make_shell
from limbgram.workbench.devices.slots import SlotRules, SlotSurface, place_slots, widest_straps_mm
from limbgram.workbench.devices.straps import strap_findings
from limbgram.workbench.devices.thickness import Zone, draped_thickness, printed_thickness
from limbgram.workbench.devices.trims import (
    DrawnTrim,
    FreePoints,
    Handle,
    Measure,
    amount_of,
    draw_trim,
    measures_in,
    place_point,
    values_of,
    values_on_slender_limb,
)
from limbgram.workbench.edits.closing import enclosure_finding
from limbgram.workbench.frame.landmarks import unconfirmed_finding
from limbgram.workbench.limb import KIND_NAMED, Limb
from limbgram.workbench.measures.geodesic import shortest_path
from limbgram.workbench.recipe.recipe import Recipe, replay

_WALL_TOLERANCE_MM = 0.05
"""The wall may differ from the thickness asked for by this."""
_WIDTH_TOLERANCE_MM = 5.0
"""A width of the positive that differs from the patient's by more gets a doubt."""
_LEAST_SHEET_SHARE = 0.5
"""Sheets usually thin by 20 to 40 per cent over heels and malleoli; more gets a doubt."""
_ZONE_FALLOFF_MM = 10.0
"""Falloff of an ordered zone, as of ribs and seats, so that no edge shows."""
_SAME_THICKNESS_MM = 0.05
"""Walls this alike at a place count as equally thick there: their triangles differ."""
_SAME_MM = 1e-9
"""Vertices that booleans do not touch stay in place to within this."""
_NO_RECIPE = Recipe(name="")
devices()  # registers their names for findings


@dataclass(frozen=True, kw_only=True)
class ImportedBody:
    """A body of another maker, in the frame of the plate: origin in the middle of its lower face,
    Z upwards, Y forwards."""

    name: str
    solid: Mesh
    cut: bool
    """It is taken away, not joined."""


@dataclass(frozen=True, kw_only=True)
class Order:
    """A device as it is ordered."""

    device: str
    values: Mapping[str, float] = field(default_factory=dict[str, float])
    """Values by measure; what is not given has its usual value."""
    made: Fabrication | None = None
    """None: the usual fabrication of the device."""
    free: FreePoints = field(default_factory=dict[str, tuple[float, float, float]])
    recipe: Recipe = _NO_RECIPE
    """The edits that make the positive from the limb."""
    bodies: tuple[ImportedBody, ...] = ()
    zones: tuple[WallZone, ...] = ()
    """Thicker or thinner zones of a printed wall, besides those of the device itself."""
    lettering: str = ""
    """Raised text on the outer side of a printed wall: patient, side, date."""

    __repr__ = brief

    def __post_init__(self) -> None:
        require_known_words(self)


@dataclass(frozen=True, kw_only=True)
class Preview:
    """A device on its positive, before it has a body. All in the limb frame."""

    device: Device
    made: Fabrication
    values: Mapping[str, float]
    positive: Limb
    """After the recipe, in the axes of the limb that was given."""
    body: Body
    drawn: DrawnTrim
    openings: tuple[Opening, ...]
    """Slots and vents, as they were placed."""
    layout: Layout
    """The positive's surface, how far each vertex lies beyond the edges, and the thickness."""
    thinnest_mm: float
    thinnest_point_mm: tuple[float, float, float]
    findings: tuple[Finding, ...]

    __repr__ = brief

    @property
    def handles(self) -> tuple[Handle, ...]:
        return self.drawn.handles


@dataclass(frozen=True, kw_only=True)
class FinishedDevice:
    """A finished device."""

    preview: Preview
    solid: Mesh
    """Closed, in the limb frame."""
    wall: WallThickness
    """Of its shell."""
    thickness_mm: Float64[np.ndarray, " n"]
    """At each vertex of the solid; NaN on edges, blocks and fittings."""
    alignment: Alignment | None
    findings: tuple[Finding, ...]

    __repr__ = brief


def device_named(name: str) -> Device:
    """The device of this name.

    Raises:
        EditError: there is none.
    """
    known = devices()
    if name not in known:
        raise EditError(
            "device.unknown", name=name, known=tuple(known), meant=likeliest(name, known)
        )
    return known[name]


def preview_device(limb: Limb, order: Order) -> Preview:
    """A device's edges, handles and thickness on its positive.

    Raises:
        EditError: see the head of this file.
    """
    device = device_named(order.device)
    made = order.made or device.usual_fabrication
    if made not in device.wall:
        raise EditError("device.made.other", name=device.en, made=made)
    if limb.kind != device.kind:
        raise EditError("device.kind", name=device.en, kind=device.kind, limb=limb.kind)
    measures = device.measures(made)
    values = values_of(measures, order.values)
    positive = replay(order.recipe, limb).limb if order.recipe.entries else limb
    with refusals_about(device.en), _refusals_with_labels(measures):
        return _preview_on_positive(positive, order, device, made, values)


def _refusals_with_labels(measures: Iterable[Measure]) -> AbstractContextManager[None]:
    """Add the labels of measures to refusals that carry only their names.

    Args:
        measures: Those that could be chosen differently; the innermost call counts.
    """

    def with_labels(finding: Finding) -> Finding:
        named = finding.values.get("measures")
        if not isinstance(named, tuple) or "labels" in finding.values:
            return finding
        labels = tuple(
            note("device.measure", label=one.en, name=one.name)
            for one in measures
            if one.name in named
        )
        told = {"measures": named if labels else None, "labels": labels}
        return replace(finding, values={**finding.values, **told})

    return refusals_saying(with_labels)


def _refusals_with_strap_width(
    ground: SlotSurface, slots: Sequence[Slot], values: Mapping[str, float], room: SlotRules
) -> AbstractContextManager[None]:
    """Add to a refusal of a slot beside another how wide straps may be."""

    def with_strap_width(finding: Finding) -> Finding:
        if finding.code != "device.opening.edge":
            return finding
        beside_slot = finding.values["beside"] in {slot.name for slot in slots}
        fits_mm = widest_straps_mm(ground, slots, values, room) if beside_slot else None
        return replace(finding, values={**finding.values, "fits_mm": fits_mm})

    return refusals_saying(with_strap_width)


def _preview_on_positive(
    positive: Limb, order: Order, device: Device, made: Fabrication, values: Mapping[str, float]
) -> Preview:
    body = Body.of(positive)
    body.require_marked(device.landmarks, device.en)
    body.require_sides(device.landmarks)
    broad, values = values, values_on_slender_limb(body, device.trim, values, order.values)
    above = [one for one in device.measures(made) if values[one.name] > one.within.least]
    with _refusals_with_labels(above):
        drawn = draw_trim(body, device.trim, values, order.free)
    asked = [
        slot
        for slot in device.slots
        if amount_of(slot.width_mm, values) > 0 and amount_of(slot.asked, values) > 0
    ]
    gaps = [_gap(one, values) for one in device.slits]
    wall_mm = values[device.wall[made].name]  # a bridge that is narrower has no wall, only edges
    adjustable = [one for one in device.measures(made) if one.name not in order.values]
    room = SlotRules(bridge_mm=wall_mm, adjustable={one.name: one for one in adjustable})
    ground = SlotSurface.of(body, drawn, gaps, asked)
    placed = place_slots(ground, asked, values, room)
    slender, values = values, placed.values
    ribs = _ribs(body, device, made, values)
    with _refusals_with_strap_width(ground, asked, values, room):
        covered = cover(body, drawn.edges, placed.openings, gaps, wall_mm, ribs)
    zones = _zones(body, device, made, order, values)
    layout = Layout(
        positive=covered.positive,
        beyond_mm=covered.beyond_mm,
        thickness_mm=_thickness(covered, values, device.wall[made], made, zones, ribs),
    )
    _require_zones(order.zones, body, layout, device.wall[made])
    less, moved = (
        _changed_measures(adjustable, broad, slender),
        _changed_measures(adjustable, slender, values),
    )
    thinnest_mm, thinnest_point_mm = _thinnest_place(layout)
    return Preview(
        device=device,
        made=made,
        values=values,
        positive=positive,
        body=body,
        drawn=drawn,
        openings=placed.openings,
        layout=layout,
        thinnest_mm=thinnest_mm,
        thinnest_point_mm=thinnest_point_mm,
        findings=(
            *_unconfirmed_landmarks(positive, device, order),
            *_width_findings(body, device, values),
            *(
                note("device.zone", place=one.at, add_mm=one.add_mm, reach_mm=one.reach_mm)
                for one in order.zones
            ),
            *((note("device.trim.slender", measures=less),) if less else ()),
            *((note("device.strap.moved", measures=moved),) if moved else ()),
            *strap_findings(body, asked, placed.openings, values, order.recipe),
        ),
    )


def _unconfirmed_landmarks(limb: Limb, device: Device, order: Order) -> tuple[Finding, ...]:
    """A note of unconfirmed landmarks that edges, fittings, zones or the recipe's edits use."""
    edited = landmarks_of_edits(order.recipe, KIND_NAMED[device.kind])
    lettered = (device.label.at.at, device.label.at.towards) if order.lettering else ()
    zones = [one.at for one in order.zones]
    said = unconfirmed_finding(limb, {*device.landmarks, *zones, *lettered, *edited})
    return () if said is None else (said,)


def _changed_measures(
    adjustable: Iterable[Measure], usual: Mapping[str, float], chosen: Mapping[str, float]
) -> tuple[Finding, ...]:
    """Notes of adjustable values that differ from the usual ones on this limb."""
    return tuple(
        note(
            "device.measure.now",
            label=one.en,
            name=one.name,
            usual=usual[one.name],
            chosen=chosen[one.name],
            unit=one.unit,
        )
        for one in adjustable
        if chosen[one.name] != usual[one.name]
    )


def make_device(limb: Limb, order: Order) -> FinishedDevice:
    """Make the device as one closed solid, and prove it.

    Raises:
        EditError: see the head of this file.
    """
    preview = preview_device(limb, order)
    device, values, body = preview.device, preview.values, preview.body
    blocks: list[Block] = []
    parts: list[Part] = []
    for seat in device.seats:
        if not amount_of(seat.hole_mm, values) > 0:
            continue
        boss, drilled = _seat(body, seat, preview.layout, values)
        blocks.append(boss)
        parts.append(drilled)
    alignment = None
    if device.adapter:
        with refusals_about("adapter"):
            plate = adapter_under(body, preview.layout, values, device.adapter)
        alignment = plate.alignment
        blocks.append(plate.block)
        parts += plate.parts
    elif order.bodies:
        raise EditError("device.part.no_plate", name=order.bodies[0].name)
    for one in order.bodies:
        assert alignment is not None
        how = "cut" if one.cut else "join"
        parts.append(imported_part(one.name, one.solid, alignment.limb_from_plate, how))
    with _refusals_with_causes_of_folds(preview, order, blocks):
        shell = make_shell(preview.layout, blocks)
    if order.lettering:
        parts.append(_lettering_part(preview, shell.solid, order.lettering))
    wall = measure_wall(shell.solid, preview.layout, blocks)
    solid = with_parts(shell.solid, parts)
    require_solid(solid)
    return FinishedDevice(
        preview=preview,
        solid=solid,
        wall=wall,
        thickness_mm=_thickness_on_solid(shell.solid, wall, solid),
        alignment=alignment,
        findings=(*preview.findings, *_wall_findings(preview, wall, solid, shell.pieces_left_out)),
    )


def _refusals_with_causes_of_folds(
    preview: Preview, order: Order, blocks: Sequence[Block]
) -> AbstractContextManager[None]:
    """Add to a refusal of a fold what thickens the wall there and without which it does not fold.

    Each is left out in turn and the shell made again.
    """

    def folds_without(less: Order, place_mm: Sequence[float]) -> bool:
        values = values_of(preview.device.measures(preview.made), less.values)
        layout = _preview_on_positive(
            preview.positive, less, preview.device, preview.made, values
        ).layout
        near_mm = 2 * float(preview.layout.thickness_mm.max())
        there_mm = [_thickest_near(one, place_mm, near_mm) for one in (preview.layout, layout)]
        if there_mm[0] - there_mm[1] < _SAME_THICKNESS_MM:
            return True
        try:
            make_shell(layout, blocks)
        except EditError:
            return True
        return False

    def with_causes(finding: Finding) -> Finding:
        if finding.code != "device.folds":
            return finding
        place_mm = cast(tuple[float, ...], finding.values["point_mm"])
        causes = [
            cause
            for cause, less in _orders_of_less(preview, order)
            if not folds_without(less, place_mm)
        ]
        return replace(finding, values={**finding.values, "causes": tuple(causes) or None})

    return refusals_saying(with_causes)


def _orders_of_less(preview: Preview, order: Order) -> Iterator[tuple[Finding, Order]]:
    """Everything that thickens a printed wall here and there, and the order without it."""
    device = preview.device
    thickening = measures_in([one.add_mm for one in (*device.pads, *device.ridges)])
    for one in device.measures(preview.made):
        if one.name in thickening and preview.values[one.name] > 0 and one.within.holds(0.0):
            cause = note("device.measure", label=one.en, name=one.name)
            yield cause, replace(order, values={**order.values, one.name: 0.0})
    for zone in order.zones:
        cause = note("device.zone", place=zone.at, add_mm=zone.add_mm, reach_mm=zone.reach_mm)
        yield cause, replace(order, zones=tuple(one for one in order.zones if one is not zone))


def _thickest_near(layout: Layout, place_mm: Sequence[float], within_mm: float) -> float:
    """The greatest thickness of the wall near a place on its outer side."""
    near = KDTree(layout.positive.vertices_mm).query_ball_point(place_mm, within_mm)
    return float(layout.thickness_mm[near].max(initial=0.0))


def _wall_findings(
    preview: Preview, wall: WallThickness, solid: Mesh, crumbs: int
) -> Sequence[Finding]:
    told = note(
        "device.wall",
        made=preview.made,
        thinnest_mm=wall.thinnest_mm,
        point_mm=wall.thinnest_point_mm,
        thickest_mm=wall.thickest_mm,
    )
    off = (
        () if wall.off_mm <= _WALL_TOLERANCE_MM else (doubt("device.wall.off", off_mm=wall.off_mm),)
    )
    sheet_mm = preview.values[preview.device.wall[preview.made].name]
    if preview.made == "draped" and wall.thinnest_mm < _LEAST_SHEET_SHARE * sheet_mm:
        thin = doubt(
            "device.wall.thin",
            thinnest_mm=wall.thinnest_mm,
            sheet_mm=sheet_mm,
            point_mm=wall.thinnest_point_mm,
        )
        off = (thin, *off)
    left = (doubt("device.crumbs", count=crumbs),) if crumbs else ()
    return (
        told,
        enclosure_finding(solid),
        *off,
        *left,
        *fold_findings(solid),
        note("device.not_tested"),
    )


def _thickness_on_solid(shell: Mesh, wall: WallThickness, solid: Mesh) -> Float64[np.ndarray, " n"]:
    """The shell's thickness at those vertices of the solid that are still the shell's."""
    away_mm, at = KDTree(shell.vertices_mm).query(solid.vertices_mm, workers=1)
    return np.where(away_mm < _SAME_MM, wall.at_vertices_mm[at], np.nan)


def _gap(slit: Slit, values: Mapping[str, float]) -> Gap:
    return Gap(
        name=slit.name,
        outward=np.array([0.0, 1.0 if slit.side == "anterior" else -1.0, 0.0]),
        across=np.array([1.0, 0.0, 0.0]),
        width_mm=amount_of(slit.width_mm, values),
    )


def _thickness(
    covered: CoveredArea,
    values: Mapping[str, float],
    wall: Measure,
    made: Fabrication,
    zones: Sequence[Zone],
    ribs: Sequence[Rib],
) -> Float64[np.ndarray, " n"]:
    if made == "draped":
        return draped_thickness(covered, values[wall.name], values[DRAW.name])
    return printed_thickness(covered, values[wall.name], zones, ribs)


def _zones(
    body: Body, device: Device, made: Fabrication, order: Order, values: Mapping[str, float]
) -> list[Zone]:
    """The thicker and thinner zones of a printed wall: the device's, and the ordered ones."""
    if made == "draped":
        if order.zones:
            raise EditError("device.zone.draped", place=order.zones[0].at)
        return []
    own = [
        Zone(
            middle_mm=place_point(body, pad.name, pad.at, values),
            reach_mm=pad.reach_mm,
            falloff_mm=pad.falloff_mm,
            add_mm=amount_of(pad.add_mm, values),
        )
        for pad in device.pads
        if amount_of(pad.add_mm, values) > 0
    ]
    ordered = [
        Zone(
            middle_mm=body.place_mm(one.at),
            reach_mm=one.reach_mm,
            falloff_mm=_ZONE_FALLOFF_MM,
            add_mm=one.add_mm,
        )
        for one in order.zones
    ]
    return own + ordered


def _require_zones(zones: Sequence[WallZone], body: Body, layout: Layout, wall: Measure) -> None:
    """Refuse a zone that the device does not cover, or one that leaves the wall too thin."""
    mesh = layout.positive
    for zone in zones:
        x, y, z = body.place_mm(zone.at).tolist()
        nearest = mesh.faces[tree_on(mesh).closest(np.array([[x, y, z]])).faces[0]]
        if layout.beyond_mm[nearest].min() > 0:
            raise EditError("device.zone.outside", place=zone.at, point_mm=(x, y, z))
    thinnest_mm, point_mm = _thinnest_place(layout)
    least_mm = wall.within.least
    if zones and thinnest_mm < least_mm:
        raise EditError(
            "device.zone.thin", thinnest_mm=thinnest_mm, least_mm=least_mm, point_mm=point_mm
        )


def _thinnest_place(layout: Layout) -> tuple[float, tuple[float, float, float]]:
    """The least thickness of the wall, and its place."""
    covered = np.flatnonzero(layout.beyond_mm < 0)
    thinnest = int(covered[np.argmin(layout.thickness_mm[covered])])
    x, y, z = layout.positive.vertices_mm[thinnest].tolist()
    return float(layout.thickness_mm[thinnest]), (x, y, z)


def _ribs(body: Body, device: Device, made: Fabrication, values: Mapping[str, float]) -> list[Rib]:
    """The ribs of a printed wall that are asked for."""
    return [
        Rib(
            line_mm=_path_through(
                body, [place_point(body, one.name, p, values) for p in one.through]
            ),
            width_mm=one.width_mm,
            falloff_mm=one.falloff_mm,
            add_mm=amount_of(one.add_mm, values),
        )
        for one in device.ridges
        if made == "printed" and amount_of(one.add_mm, values) > 0
    ]


def _path_through(body: Body, places: Sequence[Vector3]) -> Float64[np.ndarray, "k 3"]:
    """The polyline of shortest paths over the surface through places."""
    legs = [shortest_path(body.mesh, one, two) for one, two in pairwise(places)]
    return np.concatenate([legs[0], *(leg[1:] for leg in legs[1:])])


def _seat(body: Body, seat: Seat, layout: Layout, values: Mapping[str, float]) -> tuple[Boss, Part]:
    """The boss of a seat, and the hole through it and the wall."""
    place = place_point(body, seat.name, seat.at, values)
    with refusals_about(seat.name):
        axis = body.place_mm(seat.axis[1]) - body.place_mm(seat.axis[0])
    found = tree_on(layout.positive).closest(place[None])
    outward = layout.positive.face_normals()[found.faces[0]]
    axis = unit((axis * np.sign(axis @ outward))[None])[0]
    wall_mm = float(layout.thickness_mm[layout.positive.faces[found.faces[0]]].mean())
    high_mm = wall_mm + seat.rise_mm
    boss = Boss(
        face_mm=place + high_mm * axis,
        outward=axis,
        radius_mm=seat.radius_mm,
        depth_mm=2 * high_mm,
    )
    drilled = hole(
        f"{seat.name}, hole",
        place,
        axis,
        diameter_mm=amount_of(seat.hole_mm, values),
        depth_mm=2 * high_mm,
    )
    return boss, drilled


def _lettering_part(preview: Preview, shell: Mesh, text: str) -> Part:
    """The order's text as raised letters at the device's place for it.

    Raises:
        EditError: the wall is draped, which would bury it, or has no room.
    """
    if preview.made != "printed":
        raise EditError("device.lettering.draped", text=text)
    label, body = preview.device.label, preview.body
    place = place_point(body, "lettering", label.at, preview.values)
    outward, up = body.normal_at(place), np.array([0.0, 0.0, 1.0])
    match label.runs:
        case "up":
            runs = up
        case "round":
            runs = np.cross(up, outward)
        case "ahead":
            runs = body.directions("foot")[1]
    return lettering(shell, text, place, outward, runs)


def _width_findings(body: Body, device: Device, values: Mapping[str, float]) -> Sequence[Finding]:
    found: list[Finding] = []
    for one in device.widths:
        found_there = cut(body.mesh, [float(body.place_mm(one.at)[2])])
        if not found_there:
            continue
        outline = max(found_there, key=lambda section: section.area_mm2(Z_AXIS)).points_mm
        own_mm = float(np.ptp(outline @ body.lateral()))
        asked_mm = values[one.measure]
        judged = doubt if abs(own_mm - asked_mm) > _WIDTH_TOLERANCE_MM else note
        found.append(judged("device.width", at=one.at, positive_mm=own_mm, patient_mm=asked_mm))
    return found
