"""Anatomy: the anatomical axes of a limb, by its landmarks and its surface.

In      the kind's description and the places of the landmarks.
Out     anatomical axes: a point, a unit direction, and how long the line is that spans it.
Fails   MeasureError: a landmark that is needed was not placed, the side is not said, or landmarks
        lie in one point or on one line.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Matrix3, Points3, Vector3
from limbgram.workbench.anatomy.centreline import Centreline, rounded_polyline
from limbgram.workbench.anatomy.kind import (
    Cross,
    Direction,
    Kind,
    Line,
    Midpoint,
    Plane,
    Square,
    SurfaceAxis,
    Tilted,
)
from limbgram.workbench.anatomy.surface_lines import (
    LineSurface,
    SurfaceLine,
    SurfacePart,
    bisecting_line,
    bisecting_line_across,
    line_under,
)

LEAST_SINE = 0.05
"""Sine of 3 degrees; directions nearer to each other span no plane."""
LEAST_MM = 1.0
"""Places nearer to each other than this span no line."""
_LINE_FITS = {"halves": bisecting_line, "halves across": bisecting_line_across, "under": line_under}
_FRAME_ROWS = {"right": 0, "anterior": 1, "long axis": 2}


@dataclass(frozen=True, kw_only=True)
class AnatomicalAxis:
    """An anatomical axis: a line, or a plane's normal."""

    name: str
    point_mm: Vector3
    direction: Vector3
    """Of unit length."""
    length_mm: float
    """Distance between the places that span it; 0 for an axis square to others."""

    def along_mm(self, points_mm: Points3) -> np.ndarray:
        """Position of each point along the direction, from the axis's own point."""
        return (points_mm - self.point_mm) @ self.direction


@dataclass(frozen=True, kw_only=True)
class Anatomy:
    """A limb's landmarks by identity, in any frame, and the axes that they span."""

    kind: Kind
    places: Mapping[str, Vector3]
    """Landmarks by identity."""
    left: bool | None
    """None where the side is unknown; False for kinds without one."""
    frame: Matrix3 | None
    """Rows: right, anterior and proximal; None for what is not aligned."""
    origin_mm: Vector3
    skin: LineSurface | None = None
    """The surface; None where landmarks alone are asked for."""
    added_slopes: Mapping[str, float] = field(default_factory=dict[str, float])
    """Slopes added to fitted lines, for derivatives by them."""
    _axes: dict[str, AnatomicalAxis] = field(
        default_factory=dict[str, AnatomicalAxis], init=False, repr=False, compare=False
    )
    """Axes found so far, because axes depend on each other and figures share them."""

    def at(self, mid: Midpoint, wanted_for: str = "") -> Vector3:
        """The midpoint of landmarks.

        Raises:
            MeasureError: one of them was not placed.
        """
        missing = self.missing(mid)
        if missing:
            raise MeasureError("anatomy.missing", names=missing, wanted_for=wanted_for or None)
        used = mid.of if all(one in self.places for one in mid.of) else mid.otherwise
        return np.mean([self.places[one] for one in used], axis=0)

    def missing(self, mid: Midpoint) -> tuple[str, ...]:
        """The landmarks missing for a midpoint; of its first choice, if both choices lack some."""
        lacking = tuple(one for one in mid.of if one not in self.places)
        instead = mid.otherwise and all(one in self.places for one in mid.otherwise)
        return () if instead else lacking

    def axis(self, name: str) -> AnatomicalAxis:
        """An axis of the kind, or of the limb frame: "long axis", "anterior", "right".

        Raises:
            MeasureError: the kind has none of that name, or what spans it is missing.
        """
        if name not in self._axes:
            self._axes[name] = self._find_axis(name)
        return self._axes[name]

    def _find_axis(self, name: str) -> AnatomicalAxis:
        if name in _FRAME_ROWS:
            if self.frame is None:
                raise MeasureError("align.not_aligned", name=None)
            return _make_axis(name, self.origin_mm, self.frame[_FRAME_ROWS[name]], 0.0)
        known = {one.name: one for one in self.kind.directions}
        if name not in known:
            raise MeasureError(
                "anatomy.no_axis", name=name, kind=self.kind.name, names=tuple(known) or None
            )
        return self._axis_of_direction(known[name])

    def surface_line(self, name: str) -> SurfaceLine | None:
        """The fitted line of an axis; None for an axis by landmarks alone.

        Raises:
            MeasureError: a landmark that chooses the part is missing, or the surface is open there.
        """
        found = next((one for one in self.kind.directions if one.name == name), None)
        return self._fitted_line(found) if isinstance(found, SurfaceAxis) else None

    def with_added_slope(self, name: str, slope: float) -> "Anatomy":
        """The anatomy with a slope added to a fitted line."""
        return replace(self, added_slopes={name: slope})

    def centreline(self) -> Centreline:
        """The centreline of a limb of a bent kind.

        Raises:
            MeasureError: a landmark that it goes by is missing, two of its nodes lie in one
                point, it folds back on itself, or the kind has a straight axis.
        """
        bent = self.kind.centreline
        if bent is None:
            raise MeasureError("anatomy.straight", kind=self.kind.name)
        nodes = np.stack([self.at(mid, "centreline") for mid in bent.nodes])
        steps = np.diff(nodes, axis=0)
        steps_mm = np.linalg.norm(steps, axis=1)
        for step_mm, ends in zip(steps_mm, pairwise(bent.nodes), strict=True):
            if step_mm < LEAST_MM:
                raise MeasureError(
                    "anatomy.on_point", name="centreline", names=_landmark_names(*ends)
                )
        for k, (before, after) in enumerate(pairwise(steps / steps_mm[:, None])):
            if before @ after < 0 and np.linalg.norm(np.cross(before, after)) < LEAST_SINE:
                names = _landmark_names(*bent.nodes[k : k + 3])
                raise MeasureError("anatomy.on_line", name="centreline", names=names)
        return rounded_polyline(nodes, bent.rounded)

    def mirror_sign(self) -> float:
        """The sign of angles about a direction that is mirrored with the limb: -1 on a left one.

        Raises:
            MeasureError: the side is not said.
        """
        if self.left is None:
            raise MeasureError("anatomy.no_side", kind=self.kind.name)
        return -1.0 if self.left else 1.0

    def angle_deg(self, start: Vector3, end: Vector3, about: Vector3) -> float:
        """The angle between two directions about a third, -180 to 180, as on a right limb."""
        first, second = (one - about * (one @ about) for one in (start, end))
        turned = np.arctan2(np.cross(first, second) @ about, first @ second)
        return float(np.degrees(turned)) * self.mirror_sign()

    def _axis_of_direction(self, one: Direction) -> AnatomicalAxis:
        match one:
            case Line():
                return self._line_axis(one)
            case Plane():
                return self._plane_axis(one)
            case Cross():
                first, second = self.axis(one.first), self.axis(one.second)
                across = np.cross(first.direction, second.direction)
                self._require_apart(one.name, float(np.linalg.norm(across)))
                return _make_axis(one.name, first.point_mm, across * self.mirror_sign(), 0.0)
            case Square():
                first, second = self.axis(one.of), self.axis(one.to)
                rest = first.direction - second.direction * (first.direction @ second.direction)
                self._require_apart(one.name, float(np.linalg.norm(rest)))
                return _make_axis(one.name, first.point_mm, rest, 0.0)
            case Tilted():
                return self._tilted_axis(one)
            case SurfaceAxis():
                part, found = self._surface_part(one), self._fitted_line(one)
                slope = found.slope + self.added_slopes.get(one.name, 0.0)
                leans = part.along + slope * part.towards
                return _make_axis(one.name, found.middle_mm, leans, 2 * part.half_mm)

    def _fitted_line(self, one: SurfaceAxis) -> SurfaceLine:
        assert self.skin is not None, one.name
        return self.skin.line_of(_LINE_FITS[one.how], self._surface_part(one))

    def _surface_part(self, one: SurfaceAxis) -> SurfacePart:
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
        if half_mm < LEAST_MM or abs((none - whole) @ fades) < LEAST_MM:
            names = _landmark_names(one.start, one.end, one.whole, one.none)
            raise MeasureError("anatomy.on_point", name=one.name, names=names)
        return SurfacePart(
            name=one.name,
            middle_mm=middle,
            along=along,
            towards=towards,
            half_mm=half_mm,
            fade_direction=fades,
            full_at_mm=float((whole - middle) @ fades),
            zero_at_mm=float((none - middle) @ fades),
            skew=float(way @ aside) / float(way @ along),
            reach_mm=None if one.reach is None else one.reach * 2 * half_mm,
        )

    def _tilted_axis(self, one: Tilted) -> AnatomicalAxis:
        along, up = self.axis(one.along), self.axis(one.above).direction
        forward = along.direction - up * (along.direction @ up)
        self._require_apart(one.name, float(np.linalg.norm(forward)))
        forward = forward / np.linalg.norm(forward)
        medial = np.cross(up, forward) * self.mirror_sign()
        rises, turns = np.radians(one.up_deg), np.radians(one.medial_deg)
        level = np.cos(turns) * forward + np.sin(turns) * medial
        return _make_axis(one.name, along.point_mm, np.cos(rises) * level + np.sin(rises) * up, 0.0)

    def _line_axis(self, one: Line) -> AnatomicalAxis:
        start, end = self.at(one.start, one.name), self.at(one.end, one.name)
        along = end - start
        if one.within is not None:
            normal = self.axis(one.within).direction
            along = along - normal * (along @ normal)
        length_mm = float(np.linalg.norm(along))
        if length_mm < LEAST_MM:
            raise MeasureError(
                "anatomy.on_point", name=one.name, names=_landmark_names(one.start, one.end)
            )
        return _make_axis(one.name, start, along, length_mm)

    def _plane_axis(self, one: Plane) -> AnatomicalAxis:
        through = self._of_one_choice(one.through)
        first, second, third = (self.at(mid, one.name) for mid in through)
        normal = np.cross(second - first, third - first)
        size = np.linalg.norm(second - first) * np.linalg.norm(third - first)
        if not np.linalg.norm(normal) > LEAST_SINE * size:
            raise MeasureError("anatomy.on_line", name=one.name, names=_landmark_names(*through))
        if normal @ (self.at(one.towards, one.name) - first) < 0:
            normal = -normal
        return _make_axis(one.name, (first + second + third) / 3, normal, float(np.sqrt(size)))

    def _of_one_choice(self, mids: tuple[Midpoint, ...]) -> tuple[Midpoint, ...]:
        """The midpoints, all of their first choice or all of their second.

        A mixture would tilt a plane, as one from under the heel through the metatarsal heads.
        """
        firsts = tuple(Midpoint(mid.of) for mid in mids)
        seconds = tuple(Midpoint(mid.otherwise or mid.of) for mid in mids)
        lacks = [any(self.missing(mid) for mid in chosen) for chosen in (firsts, seconds)]
        return seconds if lacks == [True, False] else firsts

    def _require_apart(self, name: str, sine: float) -> None:
        if sine < LEAST_SINE:
            raise MeasureError("anatomy.on_line", name=name, names=None)


def _make_axis(
    name: str, point_mm: Vector3, direction: Vector3, length_mm: float
) -> AnatomicalAxis:
    return AnatomicalAxis(
        name=name,
        point_mm=point_mm,
        direction=direction / np.linalg.norm(direction),
        length_mm=length_mm,
    )


def _landmark_names(*mids: Midpoint) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for mid in mids for name in mid.of))
