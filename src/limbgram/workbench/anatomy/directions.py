"""Anatomy: the directions of a limb as its landmarks span them.

In      the kind's description and the places of the landmarks.
Out     anatomical axes: a point, a unit direction, and how long the line is that spans it.
Fails   MeasureError: a landmark that is needed was not placed, the side is not said, or landmarks
        lie in one point or on one line.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Matrix3, Points3, Vector3
from limbgram.workbench.anatomy.centreline import Centreline, rounded
from limbgram.workbench.anatomy.kind import (
    Cross,
    Direction,
    Kind,
    Line,
    Mid,
    OfSurface,
    Plane,
    Square,
    Tilted,
)
from limbgram.workbench.anatomy.surface_lines import (
    Leaning,
    Part,
    Skin,
    halved,
    halved_across,
    under,
)

_LEAST_SINE = 0.05
"""Directions nearer to each other than 3 degrees tell no plane."""
_LEAST_MM = 1.0
"""Places nearer to each other than this tell no line."""
_LINES = {"halves": halved, "halves across": halved_across, "under": under}
_OF_FRAME = {"right": 0, "anterior": 1, "long axis": 2}


@dataclass(frozen=True, kw_only=True)
class AnatomicalAxis:
    """A line, or a plane's normal, by landmarks."""

    name: str
    point_mm: Vector3
    direction: Vector3
    """Of unit length."""
    length_mm: float
    """Between the places that span it; 0 for what is square to others."""

    def along_mm(self, points_mm: Points3) -> np.ndarray:
        """How far each point lies along the direction, from the axis's own point."""
        return (points_mm - self.point_mm) @ self.direction


@dataclass(frozen=True, kw_only=True)
class Anatomy:
    """Landmarks of a limb by what they are, in any frame, and what they span there."""

    kind: Kind
    places: Mapping[str, Vector3]
    """By identity."""
    left: bool | None
    """None where the side is not said; False for what has none."""
    frame: Matrix3 | None
    """Rows: right, anterior and proximal; None for what is not aligned."""
    origin_mm: Vector3
    skin: Skin | None = None
    """The surface; None where landmarks alone are asked for."""
    leant: Mapping[str, float] = field(default_factory=dict[str, float])
    """What is added to the slope of lines that the surface tells: to see what hangs on them."""
    _axes: dict[str, AnatomicalAxis] = field(
        default_factory=dict[str, AnatomicalAxis], init=False, repr=False, compare=False
    )
    """Those that were asked for: axes hang on each other, and many figures on the same ones."""

    def at(self, mid: Mid, wanted_for: str = "") -> Vector3:
        """The middle of landmarks.

        Raises:
            MeasureError: one of them was not placed.
        """
        missing = self.missing(mid)
        if missing:
            raise MeasureError("anatomy.missing", names=missing, wanted_for=wanted_for or None)
        used = mid.of if all(one in self.places for one in mid.of) else mid.otherwise
        return np.mean([self.places[one] for one in used], axis=0)

    def missing(self, mid: Mid) -> tuple[str, ...]:
        """The landmarks that it lacks for a middle; those first wanted, where it lacks both."""
        lacking = tuple(one for one in mid.of if one not in self.places)
        instead = mid.otherwise and all(one in self.places for one in mid.otherwise)
        return () if instead else lacking

    def axis(self, name: str) -> AnatomicalAxis:
        """An axis of the kind, or of the limb frame: "long axis", "anterior", "right".

        Raises:
            MeasureError: the kind has none of that name, or what spans it is missing.
        """
        if name not in self._axes:
            self._axes[name] = self._told(name)
        return self._axes[name]

    def _told(self, name: str) -> AnatomicalAxis:
        if name in _OF_FRAME:
            if self.frame is None:
                raise MeasureError("align.not_aligned", name=None)
            return _axis(name, self.origin_mm, self.frame[_OF_FRAME[name]], 0.0)
        known = {one.name: one for one in self.kind.directions}
        if name not in known:
            raise MeasureError(
                "anatomy.no_axis", name=name, kind=self.kind.name, names=tuple(known) or None
            )
        return self._spanned(known[name])

    def leaning(self, name: str) -> Leaning | None:
        """What the surface says of an axis; None for one that landmarks alone tell.

        Raises:
            MeasureError: a landmark that chooses the part is missing, or the surface is open there.
        """
        found = next((one for one in self.kind.directions if one.name == name), None)
        return self._by_surface(found) if isinstance(found, OfSurface) else None

    def with_lean(self, name: str, slope: float) -> "Anatomy":
        """With a line that the surface tells leaning further."""
        return replace(self, leant={name: slope})

    def centreline(self) -> Centreline:
        """The curve that a bent limb's sections go by.

        Raises:
            MeasureError: a landmark that it goes by is missing, or the kind has a straight axis.
        """
        bent = self.kind.centreline
        if bent is None:
            raise MeasureError("anatomy.straight", kind=self.kind.name)
        nodes = [self.at(mid, "centreline") for mid in bent.nodes]
        return rounded(np.stack(nodes), bent.rounded)

    def sense(self) -> float:
        """What an angle about a direction that is mirrored with the limb is multiplied by.

        Raises:
            MeasureError: the side is not said.
        """
        if self.left is None:
            raise MeasureError("anatomy.no_side", kind=self.kind.name)
        return -1.0 if self.left else 1.0

    def angle_deg(self, start: Vector3, end: Vector3, about: Vector3) -> float:
        """From one direction to another as seen along a third, -180 to 180, as on a right limb."""
        first, second = (one - about * (one @ about) for one in (start, end))
        turned = np.arctan2(np.cross(first, second) @ about, first @ second)
        return float(np.degrees(turned)) * self.sense()

    def _spanned(self, one: Direction) -> AnatomicalAxis:
        match one:
            case Line():
                return self._line(one)
            case Plane():
                return self._plane(one)
            case Cross():
                first, second = self.axis(one.first), self.axis(one.second)
                across = np.cross(first.direction, second.direction)
                self._require_apart(one.name, float(np.linalg.norm(across)))
                return _axis(one.name, first.point_mm, across * self.sense(), 0.0)
            case Square():
                first, second = self.axis(one.of), self.axis(one.to)
                rest = first.direction - second.direction * (first.direction @ second.direction)
                self._require_apart(one.name, float(np.linalg.norm(rest)))
                return _axis(one.name, first.point_mm, rest, 0.0)
            case Tilted():
                return self._tilted(one)
            case OfSurface():
                part, found = self._part(one), self._by_surface(one)
                slope = found.slope + self.leant.get(one.name, 0.0)
                leans = part.along + slope * part.towards
                return _axis(one.name, found.middle_mm, leans, 2 * part.half_mm)

    def _by_surface(self, one: OfSurface) -> Leaning:
        assert self.skin is not None, one.name
        return self.skin.tell(_LINES[one.how], self._part(one))

    def _part(self, one: OfSurface) -> Part:
        start, end = self.at(one.start, one.name), self.at(one.end, one.name)
        whole, none = self.at(one.whole, one.name), self.at(one.none, one.name)
        along, towards = self.axis(one.along).direction, self.axis(one.towards).direction
        self._require_apart(one.name, float(np.linalg.norm(np.cross(along, towards))))
        towards = towards - along * (towards @ along)
        towards /= np.linalg.norm(towards)
        aside = np.cross(along, towards)
        middle, way = (start + end) / 2, end - start
        half_mm = abs(float(way @ along)) / 2
        fades = towards if one.how == "under" else aside
        if half_mm < _LEAST_MM or abs((none - whole) @ fades) < _LEAST_MM:
            names = _named(one.start, one.end, one.whole, one.none)
            raise MeasureError("anatomy.on_point", name=one.name, names=names)
        return Part(
            name=one.name,
            middle_mm=middle,
            along=along,
            towards=towards,
            half_mm=half_mm,
            fades_along=fades,
            whole_mm=float((whole - middle) @ fades),
            none_mm=float((none - middle) @ fades),
            skew=float(way @ aside) / float(way @ along),
            reach_mm=None if one.reach is None else one.reach * 2 * half_mm,
        )

    def _tilted(self, one: Tilted) -> AnatomicalAxis:
        along, up = self.axis(one.along), self.axis(one.above).direction
        forward = along.direction - up * (along.direction @ up)
        self._require_apart(one.name, float(np.linalg.norm(forward)))
        forward = forward / np.linalg.norm(forward)
        medial = np.cross(up, forward) * self.sense()
        rises, turns = np.radians(one.up_deg), np.radians(one.medial_deg)
        level = np.cos(turns) * forward + np.sin(turns) * medial
        return _axis(one.name, along.point_mm, np.cos(rises) * level + np.sin(rises) * up, 0.0)

    def _line(self, one: Line) -> AnatomicalAxis:
        start, end = self.at(one.start, one.name), self.at(one.end, one.name)
        along = end - start
        if one.within is not None:
            normal = self.axis(one.within).direction
            along = along - normal * (along @ normal)
        length_mm = float(np.linalg.norm(along))
        if length_mm < _LEAST_MM:
            raise MeasureError("anatomy.on_point", name=one.name, names=_named(one.start, one.end))
        return _axis(one.name, start, along, length_mm)

    def _plane(self, one: Plane) -> AnatomicalAxis:
        first, second, third = (self.at(mid, one.name) for mid in one.through)
        normal = np.cross(second - first, third - first)
        size = np.linalg.norm(second - first) * np.linalg.norm(third - first)
        if not np.linalg.norm(normal) > _LEAST_SINE * size:
            raise MeasureError("anatomy.on_line", name=one.name, names=_named(*one.through))
        if normal @ (self.at(one.towards, one.name) - first) < 0:
            normal = -normal
        return _axis(one.name, (first + second + third) / 3, normal, float(np.sqrt(size)))

    def _require_apart(self, name: str, sine: float) -> None:
        if sine < _LEAST_SINE:
            raise MeasureError("anatomy.on_line", name=name, names=None)


def _axis(name: str, point_mm: Vector3, direction: Vector3, length_mm: float) -> AnatomicalAxis:
    return AnatomicalAxis(
        name=name,
        point_mm=point_mm,
        direction=direction / np.linalg.norm(direction),
        length_mm=length_mm,
    )


def _named(*mids: Mid) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for mid in mids for name in mid.of))
