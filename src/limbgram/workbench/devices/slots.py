"""Slots: places for strap slots and vents, by the edges as they were drawn on the limb.

In      a Body, its drawn edges and gaps, and the slots of a device.
Out     an opening for each slot; the values, with the changed one of a strap that had to move.
Method  A slot begins where its point of anatomy lies, and moves up or down and round the limb until
        its nearest side keeps the stated margin to each of its edges, measured over the surface.
        Where straps of one side are too near each other, the one between the others moves; if that
        is not enough, the margins become smaller. Both change by the fewest whole millimetres that
        part the straps, and never a value that somebody gave.
Fails   EditError: a slot for which no place keeps its margins.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np
from jaxtyping import Float64
from scipy.spatial import KDTree

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.mesh.mesh import dots, unit
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.workbench.devices.body import Body
from limbgram.workbench.devices.device import EdgeMargin, Slot
from limbgram.workbench.devices.layout import Gap, Opening, depth_in_gap
from limbgram.workbench.devices.trims import (
    DrawnTrim,
    Edge,
    Measure,
    amount_of,
    measures_in,
    measures_of,
    place_point,
)
from limbgram.workbench.edits.regions import (
    barycentric_weights,
    distances_from,
    distances_from_line,
    signed_mm,
)

_REACH_MM = 140.0
"""The farthest margin and the longest slot end within it."""
_SAMPLES = 9
"""Places along a slot's centre line at which its margins are measured."""
_ROUNDS = 60
_LARGEST_STEP_MM = 12.0
"""A slot moves by no more in one round."""
_CONVERGED_MM = 0.01
_BRIDGE_RESERVE_MM = 0.5
"""Added to the least bridge, which is later checked at vertices only."""
_WIDEST_MM = 50
_MOST_MARGIN_GIVEN_UP_MM = 10
"""By so much margins may become smaller where straps would not fit above each other."""
_BESIDE_SINGLE_STRAP_MM = 40.0
"""From a strap's end to the middle of the one that yields, where there is no third strap."""
_DIRECTIONS: Final[Mapping[str, tuple[int, int]]] = {
    "up": (1, 0),
    "down": (-1, 0),
    "round": (0, 1),
    "back": (0, -1),
}
"""Components up the limb, and round it in the direction of growing angles."""


@dataclass(frozen=True, kw_only=True)
class SlotRules:
    """How much material slots leave beside them, and which measures may change for it."""

    bridge_mm: float
    """Least width of material between two slots."""
    adjustable: Mapping[str, Measure]
    """The measures whose values nobody gave, by name."""


@dataclass(frozen=True, kw_only=True)
class PlacedSlots:
    """A device's slots on a limb."""

    openings: tuple[Opening, ...]
    """In the limb frame, in the order of the slots."""
    values: Mapping[str, float]
    """All values; those that nobody gave may have changed where straps had to spread."""


@dataclass(frozen=True, kw_only=True)
class SlotSurface:
    """The surface that slots are placed on, and its distances from the edges near them."""

    body: Body
    edge_distances: Mapping["_EdgeKey", "_EdgeDistance"]

    @classmethod
    def of(
        cls, body: Body, drawn: DrawnTrim, gaps: Sequence[Gap], slots: Sequence[Slot]
    ) -> "SlotSurface":
        """The surface with distances from every edge that the slots name."""
        keys = dict.fromkeys(_edge_key(one) for slot in slots for one in slot.inside)
        return cls(
            body=body, edge_distances={key: _edge_distance(body, drawn, gaps, key) for key in keys}
        )


def place_slots(
    ground: SlotSurface,
    slots: Sequence[Slot],
    values: Mapping[str, float],
    room: SlotRules,
) -> PlacedSlots:
    """Place every slot of a device.

    Raises:
        EditError: see the head of this file.
    """
    placed = _all_openings(ground, slots, values)
    for by_mm in range(_MOST_MARGIN_GIVEN_UP_MM + 1):
        if _straps_have_room(ground, slots, placed, room):
            return placed
        parted = _with_yielding_strap_moved(ground, slots, placed, room)
        if _straps_have_room(ground, slots, parted, room):
            return parted
        nearer = _with_smaller_margins(slots, values, room, by_mm + 1.0)
        if nearer == placed.values:
            break
        placed = _all_openings(ground, slots, nearer)
    return _all_openings(ground, slots, values)


def _all_openings(
    ground: SlotSurface, slots: Sequence[Slot], values: Mapping[str, float]
) -> PlacedSlots:
    openings = tuple(_fitted_opening(ground, slot, values) for slot in slots)
    return PlacedSlots(openings=openings, values=values)


def _with_smaller_margins(
    slots: Sequence[Slot], usual: Mapping[str, float], room: SlotRules, by_mm: float
) -> Mapping[str, float]:
    """The values with margins to the trim's edges reduced, where nobody gave them."""
    edges = [one for slot in slots for one in slot.inside if one.away in ("up", "down")]
    adjustable = [room.adjustable[name] for name in measures_in([one.margin_mm for one in edges])
            if name in room.adjustable]  # fmt: skip
    nearer = {one.name: max(one.within.least, usual[one.name] - by_mm) for one in adjustable}
    return {**usual, **nearer}


def _with_yielding_strap_moved(
    ground: SlotSurface, slots: Sequence[Slot], placed: PlacedSlots, room: SlotRules
) -> PlacedSlots:
    """The slots with the yielding strap moved, by the fewest whole millimetres, to where it fits.

    Unchanged where there is no room midway between the others, or somebody gave its place.
    """
    own = [
        one for one in zip(slots, placed.openings, strict=True) if one[0].yields in room.adjustable
    ]
    if not own or all(one.yields for one in slots if one.strap):
        return placed
    adjustable = room.adjustable[own[0][0].yields]
    now_mm = placed.values[adjustable.name]

    def at(move_mm: int) -> PlacedSlots:
        values = {**placed.values, adjustable.name: now_mm + move_mm}
        openings = (
            _fitted_opening(ground, slot, values) if slot.yields == adjustable.name else opening
            for slot, opening in zip(slots, placed.openings, strict=True)
        )
        return PlacedSlots(openings=tuple(openings), values=values)

    farther = round(
        _midway_height_mm(slots, placed, adjustable.name) - float(own[0][1].middle_mm[2])
    )
    least, most = adjustable.within.least - now_mm, adjustable.within.most - now_mm
    farther, nearer = int(np.clip(farther, least, most)), 0
    if not _straps_have_room(ground, slots, at(farther), room):
        return placed
    while abs(farther - nearer) > 1:
        between = (farther + nearer) // 2
        if _straps_have_room(ground, slots, at(between), room):
            farther = between
        else:
            nearer = between
    return at(farther)


def _midway_height_mm(slots: Sequence[Slot], placed: PlacedSlots, yields: str) -> float:
    """Height midway between the lowest ends of straps above and the highest of those below."""
    above, below = np.inf, -np.inf
    for slot, one in zip(slots, placed.openings, strict=True):
        high_mm, half_mm = float(one.middle_mm[2]), 0.5 * one.length_mm
        for inside in slot.inside if slot.yields != yields else ():
            if inside.away == "down":
                above = min(above, high_mm - half_mm)
            if inside.away == "up":
                below = max(below, high_mm + half_mm)
    if not np.isfinite([above, below]).all():
        return (
            above - _BESIDE_SINGLE_STRAP_MM
            if np.isfinite(above)
            else below + _BESIDE_SINGLE_STRAP_MM
        )
    return 0.5 * (above + below)


def widest_straps_mm(
    ground: SlotSurface,
    slots: Sequence[Slot],
    values: Mapping[str, float],
    room: SlotRules,
) -> float | None:
    """The greatest width, in whole millimetres, that all straps above each other can have.

    Returns:
        None where there are no two straps, or no width fits.
    """
    straps = {slot.strap for slot in slots if isinstance(slot.strap, str)}
    if len(straps) < 2:
        return None

    def fit(width_mm: int) -> bool:
        wide = {**values, **dict.fromkeys(straps, float(width_mm))}
        try:
            placed = place_slots(ground, slots, wide, room)
        except EditError:
            return False
        return _straps_have_room(ground, slots, placed, room)

    fits, not_fits = 0, _WIDEST_MM
    while not_fits - fits > 1:
        width_mm = (fits + not_fits) // 2
        fits, not_fits = (width_mm, not_fits) if fit(width_mm) else (fits, width_mm)
    return float(fits) if fits else None


_EdgeKey = tuple[str, tuple[str, str] | None]


def _edge_key(inside: EdgeMargin) -> _EdgeKey:
    return inside.edge, inside.stretch


@dataclass(frozen=True)
class _EdgeDistance:
    """Distance over the surface from an edge, or from a stretch of one."""

    away_mm: Float64[np.ndarray, " n"]
    """Of each vertex, on both sides of the edge."""
    edge: Edge | None
    """None for a gap."""
    gap: Gap | None

    def inside(self, places: Points3) -> Float64[np.ndarray, " k"]:
        """1 where the device is, -1 beyond the edge."""
        if self.gap is not None:
            return -np.sign(depth_in_gap(places, self.gap))
        assert self.edge is not None
        kept = signed_mm(self.edge.keeps_mm[None], self.edge.curve)[0]
        return np.sign(kept * signed_mm(places, self.edge.curve))


def _edge_distance(
    body: Body, drawn: DrawnTrim, gaps: Sequence[Gap], key: _EdgeKey
) -> _EdgeDistance:
    name, stretch = key
    gap = next((one for one in gaps if one.name == name), None)
    if gap is not None:
        return _EdgeDistance(_distance_from_gap_mm(body, gap), None, gap)
    edge = next(one for one in drawn.edges if one.name == name)
    line = edge.curve.points_mm
    if stretch is not None:
        at = {one.point: one.point_mm for one in drawn.handles if one.loop == name}
        first, last = (int(KDTree(line).query(at[one])[1]) for one in stretch)
        line = np.roll(line, -first, axis=0)[: (last - first) % len(line) + 1]
    return _EdgeDistance(distances_from_line(body.mesh, line, _REACH_MM), edge, None)


def _distance_from_gap_mm(body: Body, gap: Gap) -> Float64[np.ndarray, " n"]:
    """Distance over the surface of each vertex from a gap's sides."""
    mesh = body.mesh
    off = depth_in_gap(mesh.vertices_mm, gap)
    faces = mesh.faces[(off[mesh.faces] < 0).any(1) & (off[mesh.faces] > 0).any(1)]
    faces = faces[(mesh.vertices_mm[faces] @ gap.outward > 0).all(1)]
    start = np.full(len(mesh), np.inf)
    near = np.unique(faces)
    slant = np.sqrt(np.maximum(1 - (mesh.vertex_normals()[near] @ gap.across) ** 2, 0.05))
    start[near] = np.abs(off[near]) / slant
    return distances_from(mesh, start, np.ones(len(mesh), np.bool_), _REACH_MM)


def _fitted_opening(ground: SlotSurface, slot: Slot, values: Mapping[str, float]) -> Opening:
    """The opening of a slot, moved until it keeps its margins.

    Raises:
        EditError: there is no such place.
    """
    body = ground.body
    place = place_point(body, slot.name, slot.at, values)
    opening = _opening_at(body, slot, place, values)
    if not slot.inside:
        return opening
    middle = body.section_centre_mm(float(place[2]), slot.at.at)
    right, ahead, _ = body.directions("limb")
    out = right if body.limb.kind == "torso" else body.lateral()
    angle = float(np.arctan2((place - middle) @ out, (place - middle) @ ahead))
    for _ in range(_ROUNDS):
        margins = [_margin_mm(ground, opening, one) for one in slot.inside]
        lacks = np.subtract([amount_of(one.margin_mm, values) for one in slot.inside], margins)
        if np.abs(lacks).max() < _CONVERGED_MM:
            return opening
        ways = np.array([_DIRECTIONS[one.away] for one in slot.inside])
        up_mm, round_mm = np.clip(lacks @ ways, -_LARGEST_STEP_MM, _LARGEST_STEP_MM).tolist()
        angle += round_mm / float(np.linalg.norm((place - middle)[:2]))
        look = -(np.cos(angle) * ahead + np.sin(angle) * out)
        aim = np.array([middle[0], middle[1], place[2] + up_mm])
        met = body.first_hit_mm(aim, look)
        if met is None:
            break
        place = met
        opening = _opening_at(body, slot, place, values)
    raise _no_room_error(ground, slot, opening, values)


def _no_room_error(
    ground: SlotSurface, slot: Slot, opening: Opening, values: Mapping[str, float]
) -> EditError:
    """A refusal that names the edge whose margin the slot misses most."""
    asked = {one: amount_of(one.margin_mm, values) for one in slot.inside}
    worst = max(slot.inside, key=lambda one: asked[one] - _margin_mm(ground, opening, one))
    x, y, z = opening.middle_mm.tolist()
    return EditError(
        "device.slot.no_room",
        name=slot.name,
        edge=worst.edge,
        asked_mm=asked[worst],
        point_mm=(x, y, z),
        measures=opening.measures or None,
    )


def _opening_at(body: Body, slot: Slot, place: Vector3, values: Mapping[str, float]) -> Opening:
    up = np.array([0.0, 0.0, 1.0])
    margins = [one.margin_mm for one in slot.inside]
    sizes = measures_in([*margins, slot.length_mm, slot.width_mm])
    return Opening(
        name=slot.name,
        middle_mm=place,
        along=up if slot.upright else np.cross(up, body.normal_at(place)),
        length_mm=amount_of(slot.length_mm, values),
        width_mm=amount_of(slot.width_mm, values),
        measures=tuple(dict.fromkeys([*sizes, *measures_of(slot.at)])),
    )


def _centre_line(body: Body, opening: Opening) -> Points3:
    """Places on the surface along an opening, between the centres of its round ends."""
    normal = body.normal_at(opening.middle_mm)
    along = unit((opening.along - (opening.along @ normal) * normal)[None])[0]
    half_mm = 0.5 * (opening.length_mm - opening.width_mm)
    at = np.linspace(-half_mm, half_mm, _SAMPLES)
    flat = opening.middle_mm + np.outer(at, along)
    return tree_on(body.mesh).closest(flat).points_mm


def _margin_mm(ground: SlotSurface, opening: Opening, inside: EdgeMargin) -> float:
    """Distance from an edge inwards to an opening's nearest side."""
    hold, mesh = ground.edge_distances[_edge_key(inside)], ground.body.mesh
    line = _centre_line(ground.body, opening)
    corners = mesh.faces[tree_on(mesh).closest(line).faces]
    away = np.minimum(hold.away_mm, _REACH_MM)[corners]
    shares = barycentric_weights(mesh.vertices_mm[corners], line)
    own = dots(away, shares) * hold.inside(line)
    return float(own.min()) - 0.5 * opening.width_mm


def _straps_have_room(
    ground: SlotSurface, slots: Sequence[Slot], placed: PlacedSlots, room: SlotRules
) -> bool:
    """Whether bridges are left between all straps, and yielding straps keep their margins."""
    straps = [(slot, one) for slot, one in zip(slots, placed.openings, strict=True) if slot.strap]
    held = [
        one
        for slot, _ in straps
        for one in slot.inside
        if ground.edge_distances[_edge_key(one)].edge
    ]
    for slot, opening in straps:
        if slot.yields and any(
            _margin_mm(ground, opening, one) < amount_of(one.margin_mm, placed.values)
            for one in held
        ):
            return False
    lines = [_centre_line(ground.body, one) for _, one in straps]
    return all(
        float(np.linalg.norm(lines[one][:, None] - lines[two][None], axis=2).min())
        - 0.5 * (straps[one][1].width_mm + straps[two][1].width_mm)
        >= room.bridge_mm + _BRIDGE_RESERVE_MM
        for one, two in combinations(range(len(straps)), 2)
    )
