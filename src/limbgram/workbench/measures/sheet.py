"""Sheet: the measuring sheet of a kind of limb, each figure with its sigma.

In      a Limb whose kind and side are known, with landmarks.
Out     MeasuringSheet: a row for every item of the kind, with its figure or why it has none.
Method  An item depends on the surface and on where landmarks were placed. A landmark errs along the
        surface by its placing error in each direction, and with the surface along its normal. All
        is propagated to first order: the surface's part through the gradient over its vertices,
        with the covariances that the mesh carries; the placing's part by differences. A section is
        cut anew for a plane moved and tilted in each of its ways, so that it costs the same however
        many landmarks tell the plane. Where landmarks stand in for others that were not marked, a
        figure has no sigma: it is off by up to 10 degrees, which nothing here bounds.
Fails   MeasureError: nobody said the kind, or the side of what has one. What lacks a landmark, or
        cannot be cut, stands in its row with the reason.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import axis_across, rotation_to_axes
from limbgram.core.interval import HOLDS
from limbgram.core.mesh.uncertainty import extra_extremum_variance_mm2
from limbgram.core.notebook import brief, data_frame, html_of
from limbgram.core.spreadsheet import Cell, Table
from limbgram.findings import Finding, doubt, note, told
from limbgram.workbench.anatomy.directions import LEAST_MM, Anatomy
from limbgram.workbench.anatomy.kind import (
    Angle,
    AnyItem,
    Arch,
    Cranial,
    Difference,
    Distance,
    Extent,
    Extreme,
    Midpoint,
    Section,
    Share,
)
from limbgram.workbench.anatomy.landmark import USUAL, Placing
from limbgram.workbench.frame.landmarks import unconfirmed_finding
from limbgram.workbench.limb import Limb, Side
from limbgram.workbench.measures.arch import arch_apex
from limbgram.workbench.measures.cranial import cranial_figures, require_closed_above
from limbgram.workbench.measures.levels import (
    Figure,
    Level,
    Measured,
    Refused,
    Sigmas,
    area_mm2,
    levels_at,
    ml_mm,
    tape_mm,
    tape_value_mm,
)
from limbgram.workbench.measures.propagation import (
    PLACE_STEP_MM,
    CutPlane,
    Propagated,
    Subject,
    measure_section,
)

_EXTREME_STEP_MM = 2.0
_FLAT_SHARE = 0.005
_LEAST_WEIGHT = 1e-3
_COLUMNS = ("name", "measure", "value", "unit", "sigma", "sigma_of_placing", "formula", "reason")
_DIGITS = 6
_MM2_PER_CM2 = 100.0
CENTRELINE = "centreline"
"""The normal of an item that is cut across the limb's centreline."""


@dataclass(frozen=True, kw_only=True)
class SheetOptions:
    """What a sheet depends on besides the limb."""

    shoe_heel_mm: float = 0.0
    """Height of the shoe's heel."""
    shoe_sole_mm: float = 0.0
    """Height of its sole under the ball."""
    placing: Placing = USUAL
    """How well landmarks are placed where they do not say it themselves."""
    only: tuple[str, ...] = ()
    """Figures by name; empty for the whole form."""


DEFAULTS = SheetOptions()


@dataclass(frozen=True, kw_only=True)
class SheetRow:
    """One figure of the form."""

    name: str
    """In files; it ends with its unit."""
    words: Mapping[str, str]
    """What people call it, by language."""
    formula: str
    figure: Figure | None
    """Without a sigma where landmarks stand in for others: how far their figure lies from that of
    the others differs from limb to limb, and nothing bounds it."""
    placing_sigma: float | None
    """The part of its sigma that comes from placing landmarks."""
    reason: Finding | None
    """Why it has no figure."""
    places: tuple[str, ...] = ()
    """Identities of the landmarks that it depends on."""
    stand_ins: tuple[str, ...] = ()
    """Those of them that stand in for others which were not marked."""
    doubt: Finding | None = None
    """Doubt about stand-ins; else about those of them that nobody has confirmed."""
    sigma_alike: float | None = None
    """Of a figure by stand-ins: its sigma among others of this limb by the same ones."""

    @property
    def among_alike(self) -> Figure | None:
        """The figure with its sigma among others of this limb by the same landmarks."""
        if self.figure is None or self.sigma_alike is None:
            return self.figure
        return Figure(self.figure.value, self.sigma_alike)

    @property
    def unit(self) -> str:
        return unit_of(self.name)


@dataclass(frozen=True, kw_only=True)
class MeasuringSheet:
    """The form of a kind of limb, filled in."""

    kind: str
    side: Side
    shape: str
    rows: tuple[SheetRow, ...]
    doubt: Finding | None = None
    """Doubt about proposed landmarks of any figure that nobody has confirmed."""

    __repr__ = brief

    def table(self, language: str = "en") -> Table:
        """A row for every figure; those without an answer have the reason. Sigma is one standard
        deviation."""
        return Table(
            title="measuring sheet",
            columns=_COLUMNS,
            rows=tuple(
                (
                    row.name,
                    row.words[language],
                    _rounded(None if row.figure is None else row.figure.value),
                    row.unit,
                    _rounded(None if row.figure is None else row.figure.sigma),
                    _rounded(row.placing_sigma),
                    row.formula,
                    None if said is None else told(said, language),
                )
                for row in self.rows
                for said in [self.doubt_or_reason(row)]
            ),
        )

    def doubt_or_reason(self, row: SheetRow) -> Finding | None:
        """Why a figure is missing, or why it cannot be relied on; None if neither."""
        return row.reason or row.doubt

    def to_frame(self) -> Any:
        """A pandas.DataFrame with a row for each figure.

        Raises:
            MissingError: pandas is not installed.
        """
        return data_frame(self.table())

    def _repr_html_(self) -> str:
        """The form with ±, for notebooks."""
        rows = tuple(
            (
                row.words["en"],
                "" if row.figure is None else row.figure.with_interval,
                row.unit,
                None if said is None else told(said),
            )
            for row in self.rows
            for said in [self.doubt_or_reason(row)]
        )
        columns = ("measure", "value", "unit", "reason")
        said = f"{self.shape}: {self.kind}, {self.side}; {HOLDS}".removeprefix(": ")
        return html_of(Table(title="measuring sheet", columns=columns, rows=rows), said)

    def __getitem__(self, name: str) -> Figure:
        """A row's figure.

        Raises:
            MeasureError: it has none, for the reason that its row has.
            KeyError: the sheet has no row of that name.
        """
        return _figure_of({row.name: row for row in self.rows}[name])


def _rounded(value: float | None) -> Cell:
    return None if value is None else float(f"{value:.{_DIGITS}g}")


_UNITS = {"_mm": "mm", "_cm2": "cm²", "_deg": "deg", "_ml": "mL", "_per_cent": "%"}


def unit_of(name: str) -> str:
    """The unit of a figure, from the ending of its name."""
    return next((unit for ending, unit in _UNITS.items() if name.endswith(ending)), "")


def measuring_sheet(limb: Limb, options: SheetOptions = DEFAULTS) -> MeasuringSheet:
    """Fill in the form of a limb's kind.

    Raises:
        MeasureError: nobody said the kind, or the side of a limb that has one.
    """
    anatomy = limb.anatomy
    anatomy.mirror_sign()
    subject = Subject.of(limb, options.placing)
    found: dict[str, SheetRow] = {}
    heads: dict[str, Propagated] = {}
    wanted = set(options.only)
    needed = _with_parts(wanted, anatomy.kind.sheet)
    for item in anatomy.kind.sheet:
        if wanted and item.name not in needed:
            continue
        row = _row_of_item(_SheetInProgress(subject, options, found, heads), item)
        row = _with_stand_ins(row, anatomy, item)
        said = row.doubt or unconfirmed_finding(limb, row.places)
        found[item.name] = replace(row, doubt=said)
    rows = tuple(
        _without_sigma(row) if row.stand_ins else row
        for row in found.values()
        if not wanted or row.name in wanted
    )
    return MeasuringSheet(
        kind=anatomy.kind.name,
        side=limb.side,
        shape=limb.name,
        rows=rows,
        doubt=unconfirmed_finding(limb, {name for row in rows for name in row.places}),
    )


def _with_parts(wanted: set[str], sheet: Iterable[AnyItem]) -> set[str]:
    """The wanted figures, and those of which they are made."""
    parts = {name for item in sheet if item.name in wanted for name in _parts_of(item)}
    return {*wanted, *parts}


def _with_stand_ins(row: SheetRow, anatomy: Anatomy, item: AnyItem) -> SheetRow:
    """The row, with a doubt about landmarks that stand in for others in it."""
    kind = anatomy.kind
    parts = [one for one in kind.sheet if one.name in _parts_of(item)]
    lacking: dict[str, None] = {}
    stand_ins: dict[str, None] = {}
    for mid in kind.midpoints_in((item, parts, kind.centreline)):
        lacks = [name for name in mid.of if name not in anatomy.places]
        if lacks and not set(mid.otherwise).isdisjoint(row.places):
            lacking |= dict.fromkeys(lacks)
            stand_ins |= dict.fromkeys(mid.otherwise)
    if not stand_ins:
        return row
    said = doubt("measure.sheet.stand_ins", lacking=tuple(lacking), stand_ins=tuple(stand_ins))
    return replace(row, stand_ins=tuple(stand_ins), doubt=said)


def _without_sigma(row: SheetRow) -> SheetRow:
    """A row of a figure by stand-ins as it is given."""
    if row.figure is None:
        return row
    bare, sigma = Figure(row.figure.value, None), row.figure.sigma
    return replace(row, figure=bare, placing_sigma=None, sigma_alike=sigma)


def _parts_of(item: AnyItem) -> tuple[str, ...]:
    """The figures of which another one is made."""
    match item:
        case Share():
            return item.part, item.whole
        case Difference():
            return item.part, item.less
        case _:
            return ()


@dataclass(frozen=True)
class _SheetInProgress:
    """A sheet that is being filled in."""

    subject: Subject
    options: SheetOptions
    rows: Mapping[str, SheetRow]
    """The rows filled in before."""
    heads: dict[str, Propagated]
    """Figures of a head, all computed when the first is asked for."""


def _row_of_item(filling: _SheetInProgress, item: AnyItem) -> SheetRow:
    found, reason = None, None
    try:
        found = _figure_of_item(filling, item)
    except MeasureError as error:
        reason = error.finding
    return SheetRow(
        name=item.name,
        words=item.words,
        formula=item.note,
        figure=None if found is None else found.figure,
        placing_sigma=None if found is None else found.placing_sigma,
        reason=reason,
        places=() if found is None else found.places,
    )


@dataclass(frozen=True, kw_only=True)
class _FigureOfItem:
    """A figure of an item, with the part of landmarks in it."""

    figure: Figure
    placing_sigma: float | None = None
    places: tuple[str, ...] = ()

    @classmethod
    def of(cls, subject: Subject, propagated: Propagated) -> "_FigureOfItem":
        figure, placing = subject.figure(propagated)
        return cls(figure=figure, placing_sigma=placing, places=tuple(propagated.by_place))


def _figure_of_item(filling: _SheetInProgress, item: AnyItem) -> _FigureOfItem:
    subject = filling.subject
    match item:
        case Angle():
            pitch_mm = filling.options.shoe_heel_mm - filling.options.shoe_sole_mm
            return _FigureOfItem.of(subject, _angle(subject, item, pitch_mm))
        case Distance():
            found = _propagated_by_landmarks(subject, lambda one: _distance_mm(one, item))
            return _FigureOfItem.of(subject, found)
        case Share():
            return _per_cent_of(filling.rows[item.part], filling.rows[item.whole])
        case Difference():
            return _difference(filling.rows[item.part], filling.rows[item.less])
        case Extent():
            return _FigureOfItem.of(subject, _extent(subject, item))
        case Section():
            return _FigureOfItem.of(subject, _section(subject, item))
        case Extreme():
            return _extreme(subject, item)
        case Arch():
            return _FigureOfItem.of(subject, arch_apex(subject, item))
        case Cranial():
            if not filling.heads:
                filling.heads.update(cranial_figures(subject))
            if item.what not in filling.heads:
                require_closed_above(subject)
            return _FigureOfItem.of(subject, filling.heads[item.what])


def _propagated_by_landmarks(subject: Subject, what: Callable[[Anatomy], float]) -> Propagated:
    """A value that depends on landmarks alone, with its derivatives."""
    value = what(subject.anatomy)
    slopes = subject.slopes(lambda one: np.array([what(one)]))
    return Propagated(value=value, by_place={name: rows[:, 0] for name, rows in slopes.items()})


def _angle(subject: Subject, item: Angle, pitch_mm: float) -> Propagated:
    """An angle, with its derivatives by landmarks and by axes fitted to the surface."""

    def what(anatomy: Anatomy) -> float:
        return angle_deg(anatomy, item, pitch_mm)

    by_vertex = subject.vertex_slopes_by_axes(what, (item.of, item.to, item.about))
    return replace(_propagated_by_landmarks(subject, what), by_vertex=by_vertex)


def angle_deg(anatomy: Anatomy, item: Angle, pitch_mm: float = 0.0) -> float:
    """An angle of the sheet, -180 to 180; a shoe's pitch is added where it counts.

    Raises:
        MeasureError: a landmark that tells it was not placed, or the surface is open there.
    """
    start, end, about = (anatomy.axis(one).direction for one in (item.of, item.to, item.about))
    turned = anatomy.angle_deg(start, end, about) - item.zero_deg
    if item.pitch is not None:
        heel, ball = (anatomy.at(one, item.en) for one in item.pitch)
        turned += float(np.degrees(np.arctan2(pitch_mm, np.linalg.norm(ball - heel))))
    return (turned + 180.0) % 360.0 - 180.0


def _distance_mm(anatomy: Anatomy, item: Distance) -> float:
    way = anatomy.at(item.end, item.en) - anatomy.at(item.start, item.en)
    if item.along is None:
        return float(np.linalg.norm(way))
    return float(way @ anatomy.axis(item.along).direction)


def _per_cent_of(part: SheetRow, whole: SheetRow) -> _FigureOfItem:
    """One figure as per cent of another; errors count as independent, which widens the interval.

    Raises:
        MeasureError: one has no answer, or the landmarks of the other lie in one point.
    """
    above, below = _figure_of(part), _figure_of(whole)
    if not abs(below.value) > LEAST_MM:
        raise MeasureError("measure.sheet.no_whole", whole=whole.words["en"], least_mm=LEAST_MM)
    value = 100 * above.value / below.value
    places = _places_of_rows(part, whole)
    if above.sigma is None or below.sigma is None:
        return _FigureOfItem(figure=Figure(value, None), places=places)
    spread = math.hypot(100 * above.sigma, value * below.sigma) / abs(below.value)
    return _FigureOfItem(figure=Figure(value, spread), places=places)


def _difference(part: SheetRow, less: SheetRow) -> _FigureOfItem:
    """One figure less another; they use different landmarks, so their errors are independent."""
    figures = _figure_of(part), _figure_of(less)
    value, places = figures[0].value - figures[1].value, _places_of_rows(part, less)
    spreads = [one.sigma for one in figures if one.sigma is not None]
    whole = math.hypot(*spreads) if len(spreads) == len(figures) else None
    placings = [one.placing_sigma for one in (part, less) if one.placing_sigma is not None]
    placing = math.hypot(*placings) if placings else None
    return _FigureOfItem(figure=Figure(value, whole), placing_sigma=placing, places=places)


def _places_of_rows(*rows: SheetRow) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for row in rows for name in row.places))


def _figure_of(row: SheetRow) -> Figure:
    if row.figure is None:
        raise MeasureError.of(row.reason or note("measure.sheet.none"))
    return row.figure


def _extent(subject: Subject, item: Extent) -> Propagated:
    """Extent along a direction of the surface below a place."""
    points = subject.sigmas.mesh.vertices_mm

    along, up = (subject.anatomy.axis(name).direction for name in (item.along, item.up))
    heights = points @ up
    below = heights <= subject.anatomy.at(item.below, item.en) @ up
    if not below.any():
        raise MeasureError("measure.sheet.nothing_below", names=item.below.of)
    reach = np.where(below, points @ along, np.nan)
    low, high = int(np.nanargmin(reach)), int(np.nanargmax(reach))
    way = points[high] - points[low]
    gradient = np.zeros(len(points))
    gradient[high] += subject.sigmas.normals[high] @ along
    gradient[low] -= subject.sigmas.normals[low] @ along
    slopes = subject.slopes(lambda one: one.axis(item.along).direction)
    ids = np.flatnonzero(below)
    beyond = [
        extra_extremum_variance_mm2(
            subject.sigmas.mesh,
            points[ids] @ way_out,
            ids[:, None],
            (subject.sigmas.normals[ids] @ way_out)[:, None],
        )
        for way_out in (along, -along)
    ]
    return Propagated(
        value=float(way @ along),
        by_vertex=gradient,
        by_place={name: rows @ way for name, rows in slopes.items()},
        extra_variance=sum(beyond),
    )


def plane_of_item(anatomy: Anatomy, item: Section) -> CutPlane:
    """The cutting plane of an item.

    Raises:
        MeasureError: a landmark that tells it was not placed.
    """
    at = anatomy.at(item.at, item.en)
    if item.normal == CENTRELINE:
        curve = anatomy.centreline()
        normal = curve.at(float(curve.nearest_mm(at[None])[0])).direction
    else:
        normal = anatomy.axis(item.normal).direction
    if item.holds:
        held = anatomy.axis(item.holds).direction
        normal = normal - held * (normal @ held)
        normal /= np.linalg.norm(normal)
    x_axis = anatomy.axis(item.along).direction if item.along else axis_across(normal)
    rotation = rotation_to_axes(normal, x_axis)
    through_mm = rotation @ at
    through_mm[2] += item.beyond_mm
    if item.parted is not None:
        through_mm[0] = rotation[0] @ anatomy.at(item.parted, item.en)
    return CutPlane(rotation=rotation, through_mm=through_mm)


def _section(subject: Subject, item: Section) -> Propagated:
    measure = _SECTION_MEASURES[item.what]
    return measure_section(subject, lambda one: plane_of_item(one, item), {item.what: measure})[
        item.what
    ]


def half_cm2(level: Level, side: int) -> Measured:
    """Area of the material on one side of the y axis: towards x (1) or against it (-1).

    By the theorem of Green: the height of each piece of the outlines times the mean reach over the
    line along it, which is nothing where it lies on the other side.
    """
    points, after = level.points_mm, level.after
    start, end = side * points[:, 0], side * points[after, 0]
    rise = side * (points[after, 1] - points[:, 1])
    p, q = np.maximum(start, 0.0), np.maximum(end, 0.0)
    astride = (start > 0) != (end > 0)
    run = np.where(astride, np.abs(start - end), 1.0)
    reach = np.where(astride, (p + q) ** 2 / (2 * run), (p + q) / 2)
    share = np.where(astride, (p + q) / run, 1.0)  # of the piece that lies beyond
    both = (start > 0) & (end > 0)
    by_start = np.where(astride, np.where(start > 0, share - share**2 / 2, share**2 / 2), both / 2)
    by_end = np.where(astride, np.where(end > 0, share - share**2 / 2, share**2 / 2), both / 2)
    slopes = np.zeros_like(points)
    slopes[:, 0] += side * rise * by_start
    slopes[after, 0] += side * rise * by_end
    slopes[:, 1] -= side * reach
    slopes[after, 1] += side * reach
    return Measured(float(rise @ reach) / _MM2_PER_CM2, slopes / _MM2_PER_CM2)


def turn_deg(level: Level) -> Measured:
    """Angle of a section's longest principal axis from x, -90 to 90."""
    weights = area_mm2(level).slopes
    points, after = level.points_mm, level.after
    middle, (xx, xy, yy) = _centroid_and_moments(points, points[after])
    x, y = (points - middle).T
    difference, mixed = xx - yy, 2 * xy
    size = max(difference**2 + mixed**2, 1e-300)
    turned = 0.5 * np.arctan2(mixed, difference)
    slope = 0.5 * (difference * 2 * x * y - mixed * (x**2 - y**2)) / size
    return Measured(float(np.degrees(turned)), np.degrees(slope[:, None] * weights))


def _centroid_and_moments(
    points: Float64[np.ndarray, "k 2"], after: Float64[np.ndarray, "k 2"]
) -> tuple[Float64[np.ndarray, "2"], tuple[float, float, float]]:
    """Centroid of a section's area, and its central second moments: xx, xy, yy.

    By the theorem of Green over the outline's pieces; the rims of hollows take away.
    """
    shift = points.mean(0)
    (x, y), (u, v) = (points - shift).T, (after - shift).T
    doubled = x * v - u * y
    area = doubled.sum() / 2
    middle = np.array([(doubled * (x + u)).sum(), (doubled * (y + v)).sum()]) / (6 * area)
    xx = (doubled * (x * x + x * u + u * u)).sum() / 12 - area * middle[0] ** 2
    yy = (doubled * (y * y + y * v + v * v)).sum() / 12 - area * middle[1] ** 2
    xy = (doubled * (x * v + 2 * x * y + 2 * u * v + u * y)).sum() / 24
    return middle + shift, (float(xx), float(xy - area * middle[0] * middle[1]), float(yy))


_SECTION_MEASURES: Mapping[str, Callable[[Level], Measured]] = {
    "girth": tape_mm,
    "width": ml_mm,
    "turn": turn_deg,
    "half along": partial(half_cm2, side=1),
    "half against": partial(half_cm2, side=-1),
}


def _extreme(subject: Subject, item: Extreme) -> _FigureOfItem:
    """The largest or smallest girth between two places, its height, or the width there.

    There a girth does not change with its height, so that only the surface's errors and those of
    the direction count; but landmarks say between which heights it is looked for.
    """
    found = _GirthExtreme.of(subject, item)
    if item.height_from is not None:
        return _FigureOfItem.of(subject, found.height(subject, item, item.height_from))
    if item.width_along:
        return _FigureOfItem.of(subject, found.width(subject, item))
    slopes = subject.slopes(lambda one: _search_heights_mm(one, item))
    return _FigureOfItem(
        figure=found.turned.figure(found.level, tape_mm(found.level)), places=tuple(slopes)
    )


def _search_heights_mm(anatomy: Anatomy, item: Extreme) -> Float64[np.ndarray, " 2"]:
    """The heights between which the extreme is searched."""
    up = anatomy.axis(item.normal).direction
    return np.array([up @ anatomy.at(end, item.en) for end in item.between])


@dataclass(frozen=True)
class _GirthExtreme:
    """Levels across a direction, and the one with the largest or smallest girth."""

    section: Section
    plane: CutPlane
    turned: Sigmas
    heights: Float64[np.ndarray, " k"]
    """Along the direction, as in the turned surface."""
    levels: tuple[Level | Refused, ...]
    girths: Float64[np.ndarray, " k"]
    at: int
    largest: bool

    @classmethod
    def of(cls, subject: Subject, item: Extreme) -> "_GirthExtreme":
        """Find the extreme girth of an item.

        Raises:
            MeasureError: there is no girth between the places, or the extreme lies at an end.
        """
        ends = [subject.anatomy.at(mid, item.en) for mid in item.between]
        section = Section(
            name=item.name, en=item.en, de=item.de, at=item.between[0], normal=item.normal
        )
        first = plane_of_item(subject.anatomy, section)
        turned = first.surface_in_frame(subject.sigmas)
        low, high = sorted(float(first.rotation[2] @ end) for end in ends)
        heights = np.linspace(low, high, max(int((high - low) / _EXTREME_STEP_MM), 8) + 1)
        levels = levels_at(turned.mesh, heights.tolist(), _mean_place_in_plane(first, ends))
        girths = np.array([_girth_mm(one) for one in levels])
        if np.isnan(girths).all():
            raise MeasureError("measure.sheet.no_girth", names=item.between[0].of)
        largest = item.which == "largest"
        at = int(np.nanargmax(girths) if largest else np.nanargmin(girths))
        if at in (0, len(girths) - 1) or np.isnan(girths[at - 1 : at + 2]).any():
            raise MeasureError("measure.sheet.no_extreme", girth_mm=float(girths[at]))
        return cls(section, first, turned, heights, levels, girths, at, largest)

    @property
    def level(self) -> Level:
        level = self.levels[self.at]
        assert isinstance(level, Level)
        return level

    def height(self, subject: Subject, item: Extreme, start: Midpoint) -> Propagated:
        """Height over a place of the apex of a parabola through the girths near the extreme.

        Where girths hardly change, the largest alone determines the height poorly; all that differ
        from it by less than half a per cent determine it together, the nearer ones more.

        Raises:
            MeasureError: they have no top.
        """
        top, gradient = self._parabola_apex(subject)

        def over_start(anatomy: Anatomy) -> float:
            up = plane_of_item(anatomy, self.section).rotation[2]
            return float(up @ (top - anatomy.at(start, item.en)))

        return replace(_propagated_by_landmarks(subject, over_start), by_vertex=gradient)

    def width(self, subject: Subject, item: Extreme) -> Propagated:
        """Caliper width at the apex; its plane moves with the surface and turns with the landmarks.

        Raises:
            MeasureError: the girths have no top.
        """
        top, gradient = self._parabola_apex(subject)
        section = replace(self.section, along=item.width_along)

        def cut_at(anatomy: Anatomy) -> CutPlane:
            rotation = plane_of_item(anatomy, section).rotation
            return CutPlane(rotation=rotation, through_mm=rotation @ top)

        found = measure_section(subject, cut_at, {"width": ml_mm})["width"]
        first = cut_at(subject.anatomy)
        beside = [
            ml_mm(first.moved_slightly(step, 0.0, 0.0, 0.0).level(subject.sigmas)).value
            for step in (PLACE_STEP_MM, -PLACE_STEP_MM)
        ]
        by_height = (beside[0] - beside[1]) / (2 * PLACE_STEP_MM)
        assert found.by_vertex is not None
        return replace(found, by_vertex=found.by_vertex + by_height * gradient)

    def _parabola_apex(self, subject: Subject) -> tuple[Vector3, Float64[np.ndarray, " n"]]:
        """The place of the parabola's apex, and the change of its height by the surface."""
        near, weights = self._levels_near_extreme()
        along = self.heights[near] - self.heights[self.at]
        columns = np.vander(along, 3, increasing=True)
        rows = np.linalg.solve(columns.T @ (columns * weights[:, None]), columns.T * weights)
        _, rise, bend = rows @ self.girths[near]
        if not (bend < 0 if self.largest else bend > 0):
            raise MeasureError("measure.sheet.no_extreme", girth_mm=float(self.girths[self.at]))
        by_girth = rise * rows[2] / (2 * bend**2) - rows[1] / (2 * bend)
        gradient = np.zeros(len(subject.sigmas.mesh))
        for k, share in zip(near.tolist(), by_girth.tolist(), strict=True):
            level = self.levels[k]
            assert isinstance(level, Level)
            gradient += share * self.turned.gradient(level, tape_mm(level))
        middle = self.level.points_mm[self.level.outer].mean(0)
        top_mm = self.heights[self.at] - rise / (2 * bend)
        return self.plane.rotation.T @ np.append(middle, top_mm), gradient

    def _levels_near_extreme(self) -> tuple[Int64[np.ndarray, " n"], Float64[np.ndarray, " n"]]:
        """The contiguous levels near the extreme, and their weights.

        Their range is found by means over five levels, so that no rough one begins or ends it.
        """
        means = np.full(len(self.girths), np.nan)
        means[2:-2] = np.convolve(self.girths, np.full(5, 0.2), "valid")
        at = self.at
        if np.isfinite(means).any():
            at = int(np.nanargmax(means) if self.largest else np.nanargmin(means))
        else:
            means[at] = self.girths[at]
        differs = np.abs(means / means[at] - 1)
        flat = differs < _FLAT_SHARE  # False where unknown
        flat[at - 1 : at + 2] = np.isfinite(self.girths[at - 1 : at + 2])
        steep = np.flatnonzero(~flat)
        low = int(steep[steep < at].max(initial=-1)) + 1
        high = int(steep[steep > at].min(initial=len(flat)))
        counts = np.nan_to_num(1 - differs[low:high] / _FLAT_SHARE)
        return np.arange(low, high), np.maximum(counts, _LEAST_WEIGHT)


def _girth_mm(level: Level | Refused) -> float:
    return np.nan if isinstance(level, Refused) else tape_value_mm(level)


def _mean_place_in_plane(plane: CutPlane, ends: list[Vector3]) -> tuple[float, float]:
    x, y, _ = np.mean([plane.rotation @ end for end in ends], axis=0).tolist()
    return x, y
