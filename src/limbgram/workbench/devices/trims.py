"""Trims: the edges of a device as parametric curves on the surface.

In      a Body, a Trim (data), and values for its measures.
Out     DrawnTrim: closed curves on the surface, and for each point a handle that an app can drag.
Method  A point stands at landmarks, moved by what the measures say along anatomical directions, and
        is what is seen of the surface there from one side; or at a height, looking at the limb's
        middle from an angle. A fair curve goes through all (curves).
Fails   EditError: a landmark that is missing, a value out of its range or not given though nobody
        may guess it, a limb too short or too slender, a hole or the open brim where the trim runs.
        Each names the point.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Int64
from scipy.spatial import KDTree

from limbgram.core.errors import EditError, MeasureError, refusals_about
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.mesh.topology import boundary_half_edges
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.core.request_fields import Within
from limbgram.workbench.devices.body import Axes, Body
from limbgram.workbench.devices.curves import fair_curve
from limbgram.workbench.edits.regions import Curve

SeenFrom = Literal["anterior", "posterior", "lateral", "medial", "right", "left", "plantar"]
_LEAST_FROM_BRIM_MM = 3.0
"""A trim runs no nearer to an open edge of the scan: an edge and its roundness need a surface."""
_FARTHEST_FREE_MM = 10.0
_ARCH_SEARCH_MM = 25.0
"""The side of a foot is looked for up to this high above a place under it."""
_FACING_DOWN = np.sqrt(0.5)
"""Cosine to straight down beyond which a surface faces down rather than to a side."""
_PROBE_STEP_MM = 0.5
"""Change of a measure by which its handle's direction is probed, and step of a search."""
_SIDE_RESERVE_MM = 1.0
"""A measure that yields keeps its points this far inside the limb's outline."""


@dataclass(frozen=True, kw_only=True)
class Measure:
    """One number of a device, with its range: the clinic's own, and no advice."""

    name: str
    """Ends in its unit."""
    usual: float | None
    """None: depends on the patient in a way that nobody may guess; it has to be given."""
    within: Within
    en: str
    de: str
    yields: bool = False
    """Where nobody gave it, it becomes smaller on a limb too slender for the usual value."""

    @property
    def unit(self) -> str:
        """The unit, from the end of its name."""
        return self.name.rpartition("_")[2]

    @property
    def label(self) -> Mapping[str, str]:
        return {"en": self.en, "de": self.de}


Term = float | str
Amount = Term | tuple[Term, ...]
"""Millimetres or degrees; or a measure's name, with a minus or a factor before it, "-0.5*width_mm";
or the sum of several."""
_TERM = re.compile(r"(-?)(?:([0-9.]+)\*)?([a-z]\w*)")


@dataclass(frozen=True, kw_only=True)
class TrimPoint:
    """A point of a trim, defined by anatomy."""

    name: str
    at: str
    """Landmark."""
    towards: str = ""
    """Second landmark: the point starts between both."""
    share: float = 0.0
    """How far from the first to the second."""
    up_mm: Amount = 0.0
    ahead_mm: Amount = 0.0
    out_mm: Amount = 0.0
    """Lateral; on a trunk to the right."""
    above_sole_mm: Amount | None = None
    """Height over the sole, in place of the landmark's. Looked at from a side, where the surface at
    that height is the foot's underside, as under a high arch: the lowest place of its side."""
    axes: Axes = "limb"
    """Whose directions these are."""
    seen_from: SeenFrom = "lateral"
    """The side from which the surface is seen."""
    around_deg: Amount | None = None
    """In place of that: looking at the limb's middle at that height, from the front by 0, from
    lateral (on a trunk the right) by 90."""
    round_mm: Amount = 0.0
    """From there so far round the limb, as on a circle; the way in which angles grow."""


def point_round_axis(name: str, at: str, up_mm: Amount, around_deg: Amount) -> TrimPoint:
    """A point at the height of a landmark or above it, by its angle round the limb."""
    return TrimPoint(name=name, at=at, up_mm=up_mm, around_deg=around_deg)


@dataclass(frozen=True, kw_only=True)
class Loop:
    """One closed edge."""

    name: str
    points: tuple[TrimPoint, ...]
    keeps: TrimPoint
    """A point on the side of the edge that is kept."""


@dataclass(frozen=True, kw_only=True)
class Trim:
    """All edges of a device and the measures that shape them."""

    loops: tuple[Loop, ...]
    measures: tuple[Measure, ...]

    def landmarks(self) -> tuple[str, ...]:
        """The landmarks that it needs, each once, in the order in which points name them."""
        named = [
            name
            for loop in self.loops
            for point in (*loop.points, loop.keeps)
            for name in (point.at, point.towards)
            if name
        ]
        foot = [
            name
            for loop in self.loops
            for point in (*loop.points, loop.keeps)
            if point.axes == "foot" or point.above_sole_mm is not None
            for name in _FOOT_LANDMARKS
        ]
        return tuple(dict.fromkeys([*named, *foot]))


_FOOT_LANDMARKS = ("heel", "first metatarsal head", "fifth metatarsal head", "second toe")


@dataclass(frozen=True, kw_only=True)
class Handle:
    """A draggable point of a trim on a limb, and the measure that dragging changes."""

    loop: str
    point: str
    point_mm: tuple[float, float, float]
    """In the limb frame."""
    measure: str | None
    """None: it follows other points, or was set free."""
    value: float | None
    least: float | None
    most: float | None
    along: tuple[float, float, float] | None
    """Its displacement in millimetres for each unit of its measure."""


@dataclass(frozen=True, kw_only=True)
class Edge:
    """A closed edge of a device, drawn on a limb."""

    name: str
    curve: Curve
    """In the limb frame."""
    keeps_mm: Vector3
    points_mm: Points3
    """Its points, in the limb frame."""
    measures: tuple[tuple[str, ...], ...]
    """The measures that move each of them."""

    def measures_beside(self, places: Int64[np.ndarray, " k"]) -> tuple[str, ...]:
        """The measures that move the points before and behind places of the curve, each once."""
        count = len(self.points_mm)
        at = KDTree(self.curve.points_mm).query(self.points_mm, workers=1)[1]
        behind = np.searchsorted(np.sort(at), places, side="right")
        order = np.argsort(at, kind="stable")
        near = np.unique(order[np.concatenate([behind - 1, behind]) % count]).tolist()
        return tuple(dict.fromkeys(name for k in near for name in self.measures[k]))


@dataclass(frozen=True, kw_only=True)
class DrawnTrim:
    """A trim drawn on a limb: its edges and handles."""

    edges: tuple[Edge, ...]
    handles: tuple[Handle, ...]


FreePoints = Mapping[str, tuple[float, float, float]]
"""Points moved off their landmarks: by "loop: point", places in the limb frame."""
_NO_FREE_POINTS: FreePoints = {}


def values_of(measures: tuple[Measure, ...], given: Mapping[str, float]) -> dict[str, float]:
    """Every measure's value: the given one, or the usual one.

    Raises:
        EditError: an unknown name, a value out of its range, or one that has to be given.
    """
    unknown = sorted(set(given) - {one.name for one in measures})
    if unknown:
        raise EditError(
            "device.value.unknown", name=unknown[0], known=tuple(one.name for one in measures)
        )
    values: dict[str, float] = {}
    for one in measures:
        value = given.get(one.name, one.usual)
        if value is None:
            raise EditError("device.value.needed", name=one.name, meaning=one.en)
        if not one.within.holds(value):
            raise EditError(
                "device.value.range",
                name=one.name,
                value=value,
                least=one.within.least,
                most=one.within.most,
                unit=one.unit,
                meaning=one.en,
            )
        values[one.name] = float(value)
    return values


def values_on_slender_limb(
    body: Body, trim: Trim, values: Mapping[str, float], given: Iterable[str]
) -> dict[str, float]:
    """The values, with yielding measures reduced until all of their points hit the limb.

    They are at their least where that does not help; drawing the edge refuses then.

    Args:
        given: Measures whose values somebody gave; they stay.
    """
    found = dict(values)
    for one in trim.measures:
        if not one.yields or one.name in given:
            continue
        points = [
            (loop.name, point)
            for loop in trim.loops
            for point in loop.points
            if one.name in measures_of(point)
        ]
        while found[one.name] > one.within.least and _any_point_misses(
            body, points, {**found, one.name: found[one.name] + _SIDE_RESERVE_MM}
        ):
            found[one.name] = max(one.within.least, found[one.name] - _PROBE_STEP_MM)
    return found


def _any_point_misses(
    body: Body, points: Iterable[tuple[str, TrimPoint]], values: Mapping[str, float]
) -> bool:
    """Whether the line towards any of the points misses a slender limb."""
    for loop, point in points:
        try:
            place_point(body, loop, point, values)
        except EditError as error:
            if error.finding.code == "device.trim.beside_limb":
                return True
    return False


def draw_trim(
    body: Body, trim: Trim, values: Mapping[str, float], free: FreePoints = _NO_FREE_POINTS
) -> DrawnTrim:
    """The edges of a device on a limb.

    Args:
        values: Of every measure that the points name.

    Raises:
        EditError: see the head of this file.
    """
    known = {f"{loop.name}: {point.name}" for loop in trim.loops for point in loop.points}
    unknown = sorted(set(free) - known)
    if unknown:
        raise EditError("device.trim.no_point", name=unknown[0], known=tuple(sorted(known)))
    edges: list[Edge] = []
    handles: list[Handle] = []
    for loop in trim.loops:
        placed = [_place_or_free(body, loop, point, values, free) for point in loop.points]
        with refusals_about(loop.name):
            curve = _edge_curve(body, loop, np.stack(placed))
        edges.append(
            Edge(
                name=loop.name,
                curve=curve,
                keeps_mm=place_point(body, loop.name, loop.keeps, values),
                points_mm=np.stack(placed),
                measures=tuple(
                    () if f"{loop.name}: {point.name}" in free else measures_of(point)
                    for point in loop.points
                ),
            )
        )
        handles += [
            _handle(body, trim, loop, point, place, values, free)
            for point, place in zip(loop.points, placed, strict=True)
        ]
    return DrawnTrim(edges=tuple(edges), handles=tuple(handles))


def mirrored_points(
    points: tuple[TrimPoint, ...], rename: Mapping[str, str]
) -> tuple[TrimPoint, ...]:
    """The same points on the other side, in reverse order, for a loop all round.

    Args:
        rename: Names of landmarks and measures of one side to those of the other; applied to
            points' names, landmarks and measures alike.
    """

    def other(name: str) -> str:
        return rename.get(name, name)

    def amount(value: Amount, sign: float = 1.0) -> Amount:
        return tuple(_mirrored_term(term, other, sign) for term in terms_in(value))

    sides: dict[SeenFrom, SeenFrom] = {
        "lateral": "medial",
        "medial": "lateral",
        "right": "left",
        "left": "right",
    }
    return tuple(
        replace(
            point,
            name=other(point.name),
            at=other(point.at),
            towards=other(point.towards),
            up_mm=amount(point.up_mm),
            ahead_mm=amount(point.ahead_mm),
            out_mm=amount(point.out_mm, -1.0),
            above_sole_mm=None if point.above_sole_mm is None else amount(point.above_sole_mm),
            seen_from=sides.get(point.seen_from, point.seen_from),
            around_deg=None if point.around_deg is None else amount(point.around_deg, -1.0),
            round_mm=amount(point.round_mm, -1.0),
        )
        for point in reversed(points)
    )


def terms_in(value: Amount) -> tuple[Term, ...]:
    """The terms that an amount adds up."""
    return value if isinstance(value, tuple) else (value,)


def _mirrored_term(term: Term, other: Callable[[str], str], sign: float) -> Term:
    if not isinstance(term, str):
        return sign * term
    minus, factor, name = _parsed_term(term)
    turned = (minus == "-") != (sign < 0)
    return f"{'-' if turned else ''}{factor and f'{factor}*'}{other(name)}"


def _parsed_term(term: str) -> tuple[str, str, str]:
    found = _TERM.fullmatch(term)
    assert found is not None, term
    return found[1], found[2] or "", found[3]


def amount_of(value: Amount, values: Mapping[str, float]) -> float:
    """An amount in millimetres or degrees."""
    total = 0.0
    for term in terms_in(value):
        if isinstance(term, str):
            minus, factor, name = _parsed_term(term)
            total += (-1.0 if minus else 1.0) * float(factor or 1.0) * values[name]
        else:
            total += term
    return total


def measures_in(amounts: Iterable[Amount]) -> tuple[str, ...]:
    """The measures that amounts name, each once."""
    terms = (term for one in amounts for term in terms_in(one) if isinstance(term, str))
    return tuple(dict.fromkeys(_parsed_term(term)[2] for term in terms))


def measures_of(point: TrimPoint) -> tuple[str, ...]:
    """The measures that move a point."""
    amounts = (
        *(point.up_mm, point.ahead_mm, point.out_mm),
        *(one for one in (point.above_sole_mm, point.around_deg) if one is not None),
        point.round_mm,
    )
    return measures_in(amounts)


def _place_or_free(
    body: Body, loop: Loop, point: TrimPoint, values: Mapping[str, float], free: FreePoints
) -> Vector3:
    name = f"{loop.name}: {point.name}"
    if name in free:
        place = np.array(free[name], np.float64)
        nearest = tree_on(body.mesh).closest(place[None])
        if not nearest.distances_mm[0] <= _FARTHEST_FREE_MM:
            raise EditError(
                "device.trim.free_off",
                name=name,
                off_mm=float(nearest.distances_mm[0]),
                most_mm=_FARTHEST_FREE_MM,
            )
        return nearest.points_mm[0]
    return place_point(body, loop.name, point, values)


def place_point(body: Body, of: str, point: TrimPoint, values: Mapping[str, float]) -> Vector3:
    """Where a point lies on a limb, in the limb frame.

    Args:
        of: What it is a point of, for refusals.

    Raises:
        EditError: a landmark is missing, or the surface is not there.
    """
    with refusals_about(f"{of}: {point.name}"):
        return _point_on_surface(body, point, values)


def _point_on_surface(body: Body, point: TrimPoint, values: Mapping[str, float]) -> Vector3:
    """The point of the surface that is seen where a trim point is aimed at."""
    base = body.place_mm(point.at)
    if point.towards:
        base = base + point.share * (body.place_mm(point.towards) - base)
    right, ahead, up = body.directions(point.axes)
    out = right if body.limb.kind == "torso" else right * body.lateral()[0]
    aim = (
        base
        + amount_of(point.up_mm, values) * up
        + amount_of(point.ahead_mm, values) * ahead
        + amount_of(point.out_mm, values) * out
    )
    if point.above_sole_mm is not None:
        up = body.directions("foot")[2]
        high = body.sole_height_mm() + amount_of(point.above_sole_mm, values)
        aim = aim + (high - aim @ up) * up
    if point.around_deg is not None:
        angle = np.radians(amount_of(point.around_deg, values))
        aim = body.section_centre_mm(float(aim[2]), point.at)
        look = -(np.cos(angle) * ahead + np.sin(angle) * out)
        far_mm = amount_of(point.round_mm, values)
        met = body.first_hit_mm(aim, look) if far_mm else None
        if met is not None:
            angle += far_mm / float(np.linalg.norm(met - aim))
            look = -(np.cos(angle) * ahead + np.sin(angle) * out)
    else:
        look = {
            "anterior": -ahead,
            "posterior": ahead,
            "lateral": -out,
            "medial": out,
            "right": -right,
            "left": right,
            "plantar": up,
        }[point.seen_from]
    met = body.first_hit_mm(aim, look)
    if met is None:
        raise _miss_error(body, point, aim, look)
    if point.above_sole_mm is not None and point.seen_from in ("lateral", "medial"):
        return _side_above_sole(body, met, look, body.directions("foot")[2])
    return met


def _side_above_sole(body: Body, met_mm: Vector3, look: Vector3, up: Vector3) -> Vector3:
    """The place itself, or the lowest one above it that faces sideways rather than down."""
    place = met_mm
    for rise_mm in np.arange(0.0, _ARCH_SEARCH_MM, _PROBE_STEP_MM):
        above = body.first_hit_mm(met_mm + rise_mm * up, look)
        if above is None:
            break
        place = above
        if body.normal_at(place) @ up > -_FACING_DOWN:
            return place
    return met_mm


def _miss_error(body: Body, point: TrimPoint, aim_mm: Vector3, look: Vector3) -> EditError:
    """A refusal that says why a point misses: the limb is too slender, or too short."""
    lowest_mm, highest_mm = body.mesh.vertices_mm[:, 2].min(), body.mesh.vertices_mm[:, 2].max()
    place: tuple[float, ...] = tuple(aim_mm.tolist())
    beside_mm = body.miss_distance_mm(aim_mm, look)
    if beside_mm > 0 and lowest_mm < aim_mm[2] < highest_mm:
        return EditError(
            "device.trim.beside_limb",
            point_mm=place,
            beside_mm=beside_mm,
            measures=measures_of(point) or None,
        )
    return EditError(
        "device.trim.off_limb",
        at=point.at,
        point_mm=place,
        lowest_mm=float(lowest_mm),
        highest_mm=float(highest_mm),
    )


def _edge_curve(body: Body, loop: Loop, placed: Points3) -> Curve:
    border = np.unique(boundary_half_edges(body.mesh.faces))
    open_edge = KDTree(body.mesh.vertices_mm[border]) if len(border) else None
    try:
        curve = fair_curve(body.mesh, placed)
    except MeasureError as error:
        raise EditError("device.trim.apart") from error
    if open_edge is not None:
        near = open_edge.query(curve.points_mm)[0]
        at = int(np.argmin(near))
        if near[at] < _LEAST_FROM_BRIM_MM:
            raise EditError(
                "device.trim.opening",
                name=loop.name,
                point_mm=tuple(curve.points_mm[at].tolist()),
                near=_nearest_point_name(loop, placed, curve.points_mm[at]),
                least_mm=_LEAST_FROM_BRIM_MM,
            )
    return curve


def _nearest_point_name(loop: Loop, placed: Points3, place_mm: Vector3) -> str:
    away = np.linalg.norm(placed - place_mm, axis=1)
    return loop.points[int(np.argmin(away))].name


def _handle(
    body: Body,
    trim: Trim,
    loop: Loop,
    point: TrimPoint,
    place_mm: Vector3,
    values: Mapping[str, float],
    free: FreePoints,
) -> Handle:
    x, y, z = place_mm.tolist()
    own = () if f"{loop.name}: {point.name}" in free else measures_of(point)
    if not own:
        return Handle(
            loop=loop.name,
            point=point.name,
            point_mm=(x, y, z),
            measure=None,
            value=None,
            least=None,
            most=None,
            along=None,
        )
    measure = next(one for one in trim.measures if one.name == own[0])
    value = values[measure.name]
    step = _PROBE_STEP_MM if value + _PROBE_STEP_MM <= measure.within.most else -_PROBE_STEP_MM
    along = None
    try:
        there = place_point(body, loop.name, point, {**values, measure.name: value + step})
    except EditError:
        pass  # at the limb's end: the handle stands, and nothing says where it goes
    else:
        if not np.allclose(there, place_mm):  # held by the foot's side
            dx, dy, dz = ((there - place_mm) / step).tolist()
            along = (dx, dy, dz)
    return Handle(
        loop=loop.name,
        point=point.name,
        point_mm=(x, y, z),
        measure=measure.name,
        value=value,
        least=measure.within.least,
        most=measure.within.most,
        along=along,
    )
