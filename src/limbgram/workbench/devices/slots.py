"""Slots: where the slots of straps and the vents lie, by the edges as they were drawn on the limb.

In      a Body, its drawn edges and gaps, and the slots of a device.
Out     an opening for each slot; the values, with that of a strap which moved out of others' way.
Method  A slot begins where its point of anatomy lies, and moves up or down and round the limb until
        its own nearest side lies as far inside each edge that holds it as its margin says, over the
        surface. Where straps of one side are too near each other, the one between the others moves,
        then they come nearer to their edges, by the fewest whole millimetres that part them; never
        by a value that somebody gave.
Fails   EditError: a slot that no place lies so far inside its edges.
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
from limbgram.workbench.devices.device import Inside, Slot
from limbgram.workbench.devices.layout import Gap, Opening, beyond_gap
from limbgram.workbench.devices.trims import (
    Drawn,
    Edge,
    Measure,
    amount_of,
    measures_in,
    measures_of,
    place_point,
)
from limbgram.workbench.edits.regions import (
    corner_shares,
    distances_from,
    distances_from_line,
    signed_mm,
)

_REACH_MM = 140.0
"""The farthest margin and the longest slot end within it."""
_SAMPLES = 9
"""Places along a slot's middle line at which its margins are looked at."""
_ROUNDS = 60
_MOST_MM = 12.0
"""A slot moves by no more at once."""
_NEAR_MM = 0.01
_SPARE_MM = 0.5
"""More than the least bridge, which is looked at on vertices."""
_WIDEST_MM = 50
_MOST_NARROWER_MM = 10
"""By so much slots come nearer to edges than usual, where straps would not fit above each other."""
_ALONE_MM = 40.0
"""From another strap's end to the middle of the one that yields, where there is no third."""
_WAYS: Final[Mapping[str, tuple[int, int]]] = {
    "up": (1, 0),
    "down": (-1, 0),
    "round": (0, 1),
    "back": (0, -1),
}
"""Up the limb, and round it as angles grow."""


@dataclass(frozen=True, kw_only=True)
class Room:
    """What slots leave beside them, and what may give way for it."""

    bridge_mm: float
    """Least width of what stays between two slots."""
    soft: Mapping[str, Measure]
    """The measures whose values nobody gave, by name."""


@dataclass(frozen=True, kw_only=True)
class Placed:
    """A device's slots on a limb."""

    openings: tuple[Opening, ...]
    """In the limb frame, in the order of the slots."""
    values: Mapping[str, float]
    """Those that were given as they were, others where straps had to spread."""


@dataclass(frozen=True, kw_only=True)
class Ground:
    """What slots are placed on: the surface, and how far it lies from the edges that hold them."""

    body: Body
    held: Mapping["_Key", "_Hold"]

    @classmethod
    def of(cls, body: Body, drawn: Drawn, gaps: Sequence[Gap], slots: Sequence[Slot]) -> "Ground":
        """For all edges that slots name."""
        keys = dict.fromkeys(_key(one) for slot in slots for one in slot.inside)
        return cls(body=body, held={key: _hold(body, drawn, gaps, key) for key in keys})


def place_slots(
    ground: Ground,
    slots: Sequence[Slot],
    values: Mapping[str, float],
    room: Room,
) -> Placed:
    """Every slot's opening.

    Raises:
        EditError: see the head of this file.
    """
    placed = _placed(ground, slots, values)
    for by_mm in range(_MOST_NARROWER_MM + 1):
        if _at_ease(ground, slots, placed, room):
            return placed
        parted = _waist_parted(ground, slots, placed, room)
        if _at_ease(ground, slots, parted, room):
            return parted
        nearer = _nearer_edges(slots, values, room, by_mm + 1.0)
        if nearer == placed.values:
            break
        placed = _placed(ground, slots, nearer)
    return _placed(ground, slots, values)


def _placed(ground: Ground, slots: Sequence[Slot], values: Mapping[str, float]) -> Placed:
    openings = tuple(_settled(ground, slot, values) for slot in slots)
    return Placed(openings=openings, values=values)


def _nearer_edges(
    slots: Sequence[Slot], usual: Mapping[str, float], room: Room, by_mm: float
) -> Mapping[str, float]:
    """The values, but the slots nearer to edges of the trim where nobody gave how near."""
    edges = [one for slot in slots for one in slot.inside if one.away in ("up", "down")]
    soft = [room.soft[name] for name in measures_in([one.margin_mm for one in edges])
            if name in room.soft]  # fmt: skip
    nearer = {one.name: max(one.within.least, usual[one.name] - by_mm) for one in soft}
    return {**usual, **nearer}


def _waist_parted(ground: Ground, slots: Sequence[Slot], placed: Placed, room: Room) -> Placed:
    """With the strap that yields moved, by the fewest whole millimetres, to where it has room.

    As it is where there is none midway between the others, or somebody gave its place.
    """
    own = [one for one in zip(slots, placed.openings, strict=True) if one[0].yields in room.soft]
    if not own or all(one.yields for one in slots if one.strap):
        return placed
    soft = room.soft[own[0][0].yields]
    now_mm = placed.values[soft.name]

    def at(move_mm: int) -> Placed:
        values = {**placed.values, soft.name: now_mm + move_mm}
        openings = (
            _settled(ground, slot, values) if slot.yields == soft.name else opening
            for slot, opening in zip(slots, placed.openings, strict=True)
        )
        return Placed(openings=tuple(openings), values=values)

    farther = round(_midway_mm(slots, placed, soft.name) - float(own[0][1].middle_mm[2]))
    least, most = soft.within.least - now_mm, soft.within.most - now_mm
    farther, nearer = int(np.clip(farther, least, most)), 0
    if not _at_ease(ground, slots, at(farther), room):
        return placed
    while abs(farther - nearer) > 1:
        between = (farther + nearer) // 2
        if _at_ease(ground, slots, at(between), room):
            farther = between
        else:
            nearer = between
    return at(farther)


def _midway_mm(slots: Sequence[Slot], placed: Placed, yields: str) -> float:
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
        return above - _ALONE_MM if np.isfinite(above) else below + _ALONE_MM
    return 0.5 * (above + below)


def widest_straps_mm(
    ground: Ground,
    slots: Sequence[Slot],
    values: Mapping[str, float],
    room: Room,
) -> float | None:
    """How wide straps above each other may be, all alike, in whole millimetres.

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
        return _at_ease(ground, slots, placed, room)

    fits, not_fits = 0, _WIDEST_MM
    while not_fits - fits > 1:
        width_mm = (fits + not_fits) // 2
        fits, not_fits = (width_mm, not_fits) if fit(width_mm) else (fits, width_mm)
    return float(fits) if fits else None


_Key = tuple[str, tuple[str, str] | None]


def _key(inside: Inside) -> _Key:
    return inside.edge, inside.stretch


@dataclass(frozen=True)
class _Hold:
    """An edge, or a stretch of one, that slots keep away from."""

    away_mm: Float64[np.ndarray, " n"]
    """Over the surface, of each vertex, to whichever side."""
    edge: Edge | None
    """None for a gap."""
    gap: Gap | None

    def inside(self, places: Points3) -> Float64[np.ndarray, " k"]:
        """1 where the device is, -1 beyond the edge."""
        if self.gap is not None:
            return -np.sign(beyond_gap(places, self.gap))
        assert self.edge is not None
        kept = signed_mm(self.edge.keeps_mm[None], self.edge.curve)[0]
        return np.sign(kept * signed_mm(places, self.edge.curve))


def _hold(body: Body, drawn: Drawn, gaps: Sequence[Gap], key: _Key) -> _Hold:
    name, stretch = key
    gap = next((one for one in gaps if one.name == name), None)
    if gap is not None:
        return _Hold(_from_gap_mm(body, gap), None, gap)
    edge = next(one for one in drawn.edges if one.name == name)
    line = edge.curve.points_mm
    if stretch is not None:
        at = {one.point: one.point_mm for one in drawn.handles if one.loop == name}
        first, last = (int(KDTree(line).query(at[one])[1]) for one in stretch)
        line = np.roll(line, -first, axis=0)[: (last - first) % len(line) + 1]
    return _Hold(distances_from_line(body.mesh, line, _REACH_MM), edge, None)


def _from_gap_mm(body: Body, gap: Gap) -> Float64[np.ndarray, " n"]:
    """Over the surface, of each vertex from a gap's sides."""
    mesh = body.mesh
    off = beyond_gap(mesh.vertices_mm, gap)
    faces = mesh.faces[(off[mesh.faces] < 0).any(1) & (off[mesh.faces] > 0).any(1)]
    faces = faces[(mesh.vertices_mm[faces] @ gap.outward > 0).all(1)]
    start = np.full(len(mesh), np.inf)
    near = np.unique(faces)
    slant = np.sqrt(np.maximum(1 - (mesh.vertex_normals()[near] @ gap.across) ** 2, 0.05))
    start[near] = np.abs(off[near]) / slant
    return distances_from(mesh, start, np.ones(len(mesh), np.bool_), _REACH_MM)


def _settled(ground: Ground, slot: Slot, values: Mapping[str, float]) -> Opening:
    """The opening, as far inside its edges as their margins say.

    Raises:
        EditError: there is no such place.
    """
    body = ground.body
    place = place_point(body, slot.name, slot.at, values)
    opening = _opening(body, slot, place, values)
    if not slot.inside:
        return opening
    middle = body.middle_mm(float(place[2]), slot.at.at)
    right, ahead, _ = body.directions("limb")
    out = right if body.limb.kind == "torso" else body.outward()
    angle = float(np.arctan2((place - middle) @ out, (place - middle) @ ahead))
    for _ in range(_ROUNDS):
        margins = [_margin_mm(ground, opening, one) for one in slot.inside]
        lacks = np.subtract([amount_of(one.margin_mm, values) for one in slot.inside], margins)
        if np.abs(lacks).max() < _NEAR_MM:
            return opening
        ways = np.array([_WAYS[one.away] for one in slot.inside])
        up_mm, round_mm = np.clip(lacks @ ways, -_MOST_MM, _MOST_MM).tolist()
        angle += round_mm / float(np.linalg.norm((place - middle)[:2]))
        look = -(np.cos(angle) * ahead + np.sin(angle) * out)
        aim = np.array([middle[0], middle[1], place[2] + up_mm])
        met = body.met_mm(aim, look)
        if met is None:
            break
        place = met
        opening = _opening(body, slot, place, values)
    raise _no_room(ground, slot, opening, values)


def _no_room(
    ground: Ground, slot: Slot, opening: Opening, values: Mapping[str, float]
) -> EditError:
    """Names the edge from which the slot lies farthest off its margin."""
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


def _opening(body: Body, slot: Slot, place: Vector3, values: Mapping[str, float]) -> Opening:
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


def _middle_line(body: Body, opening: Opening) -> Points3:
    """Places on the surface along an opening, between the middles of its round ends."""
    normal = body.normal_at(opening.middle_mm)
    along = unit((opening.along - (opening.along @ normal) * normal)[None])[0]
    half_mm = 0.5 * (opening.length_mm - opening.width_mm)
    at = np.linspace(-half_mm, half_mm, _SAMPLES)
    flat = opening.middle_mm + np.outer(at, along)
    return tree_on(body.mesh).closest(flat).points_mm


def _margin_mm(ground: Ground, opening: Opening, inside: Inside) -> float:
    """How far an opening's nearest side lies inside an edge."""
    hold, mesh = ground.held[_key(inside)], ground.body.mesh
    line = _middle_line(ground.body, opening)
    corners = mesh.faces[tree_on(mesh).closest(line).faces]
    away = np.minimum(hold.away_mm, _REACH_MM)[corners]
    shares = corner_shares(mesh.vertices_mm[corners], line)
    own = dots(away, shares) * hold.inside(line)
    return float(own.min()) - 0.5 * opening.width_mm


def _at_ease(ground: Ground, slots: Sequence[Slot], placed: Placed, room: Room) -> bool:
    """Whether bridges are left between all straps, and those that yield stay between the others."""
    straps = [(slot, one) for slot, one in zip(slots, placed.openings, strict=True) if slot.strap]
    held = [one for slot, _ in straps for one in slot.inside if ground.held[_key(one)].edge]
    for slot, opening in straps:
        if slot.yields and any(
            _margin_mm(ground, opening, one) < amount_of(one.margin_mm, placed.values)
            for one in held
        ):
            return False
    lines = [_middle_line(ground.body, one) for _, one in straps]
    return all(
        float(np.linalg.norm(lines[one][:, None] - lines[two][None], axis=2).min())
        - 0.5 * (straps[one][1].width_mm + straps[two][1].width_mm)
        >= room.bridge_mm + _SPARE_MM
        for one, two in combinations(range(len(straps)), 2)
    )
