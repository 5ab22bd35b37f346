"""Measuring: the table of girths, widths, volumes and lengths of one aligned limb.

In      an aligned Limb, and which heights, lengths, volumes and tape readings are wanted.
Out     Measures: a row for every height, with figures or the reason why there are none.
Fails   MeasureError: the limb is not aligned, there are several, no height has an answer, or a
        volume, length or tape reading that was asked for has none.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, Literal

import numpy as np

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.interval import COVER, HOLDS
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.notebook import brief, data_frame, html_of
from limbgram.core.spreadsheet import Table, heading
from limbgram.core.tape import PLACING_SIGMA_MM, TAPER_SHARES, taper_beside_mm
from limbgram.findings import Finding, note
from limbgram.workbench.anatomy.landmark import USUAL, Placing
from limbgram.workbench.bodies import SeparateBody, outer_bodies
from limbgram.workbench.edits.thickness import Thickness, wall_thickness
from limbgram.workbench.frame.landmarks import landmark
from limbgram.workbench.limb import AlignedLimb, Limb
from limbgram.workbench.measures.lengths import Length, Place, length_between
from limbgram.workbench.measures.levels import (
    AXIS_MM,
    DISTAL_END,
    MEASURES,
    PROXIMAL_END,
    Figure,
    Level,
    OtherOutline,
    Refused,
    Sigmas,
    Volumes,
    levels_at,
    tape_mm,
)
from limbgram.workbench.measures.measured_skin import inside_of, is_two_skinned, without_sock
from limbgram.workbench.measures.tape import TapeCheck, TapeReading, check_reading

Skin = Literal["only", "outside", "inside"]
_MOST_LEVELS = 5000
_AT_ORIGIN_MM = 0.5
"""A tip this near to the frame's origin is the distal end from which heights count."""
_BEYOND_MM = 1.0
"""A volume may begin or end this far, and a sock's thickness, beyond the limb; it is clamped."""
_TOUCHING_MM = 1e-6
"""Levels of even spacing this near to an end of the limb only touch it."""


_VOLUME = "volume_below_mm3"
_HEIGHT_VALUES = ("height_mm", "low_mm", "high_mm", "open_from_mm", "open_to_mm")
"""Heights among the values of refusals."""


@dataclass(frozen=True, kw_only=True)
class LimbMeasureOptions:
    """What is measured. Heights count from the reference, upwards."""

    spacing_mm: float = 10.0
    heights_mm: tuple[float, ...] | None = None
    """In place of even spacing."""
    reference: str | None = None
    """Landmark from which heights count; None for the limb frame's origin, where the distal
    end was when it was aligned."""
    sock_mm: float | None = None
    """Thickness of the sock in the scan, taken off first; None takes nothing more off."""
    volumes_mm: tuple[tuple[float, float], ...] = ()
    """Pairs of heights; infinite ones stand for the limb's ends."""
    lengths: tuple[tuple[str, str], ...] = ()
    """Pairs of landmarks."""
    placing: Placing = USUAL
    """How well the landmarks of lengths are placed where they do not say it themselves."""
    tape: tuple[TapeReading, ...] = ()
    through: str | None = None
    """Landmark of the limb that is measured where a plane cuts several, as a trunk and its arms;
    None for the one that the long axis goes through."""


DEFAULTS = LimbMeasureOptions()


@dataclass(frozen=True, kw_only=True)
class Row:
    """One height of the table."""

    height_mm: float
    """In the limb frame: from its origin."""
    from_reference_mm: float
    figures: Mapping[str, Figure | None]
    """By the names of MEASURES, and the volume from the distal end up to here; None where a figure
    has no answer."""
    loops: int
    """Number of loops of the measured limb: its outline and the rims of hollows in it."""
    reasons: tuple[Finding, ...]
    """Why a figure, or the whole row, is missing; empty if none is."""
    level: Level | None

    __repr__ = brief

    @property
    def others(self) -> tuple[OtherOutline, ...]:
        """Outlines of other limbs at this height; the volume counts them, no other figure does."""
        return () if self.level is None else self.level.others


@dataclass(frozen=True, kw_only=True)
class VolumeRow:
    """A volume between two heights from the reference."""

    low_mm: float
    high_mm: float
    volume_mm3: Figure
    notes: tuple[Finding, ...] = ()
    """Notes of heights just beyond the limb, for which its end was taken."""


@dataclass(frozen=True, kw_only=True)
class Measures:
    """All measures of a limb."""

    limb: AlignedLimb
    """The limb as it was measured, without the sock."""
    reference: str | None
    reference_mm: float
    """Its height in the limb frame."""
    tip_mm: float
    """Height of the lowest point in the limb frame: 0 where the shape is as it was aligned."""
    rows: tuple[Row, ...]
    volumes: tuple[VolumeRow, ...]
    lengths: tuple[Length, ...]
    tape: tuple[TapeCheck, ...]
    bodies_left_out: int
    """Pieces inside the limb, such as bones, and loose ones beside it: not measured."""
    loose: tuple[SeparateBody, ...]
    """Those beside it, in the limb frame."""
    skin: Skin = "only"
    """Which of a wall's two skins the figures are of; the areas and volumes of an outside are those
    of the material."""
    outer_mesh: Mesh
    """What of the shape its wall was measured on, in the limb frame: without bodies left out."""
    wall: Thickness | None = None
    """Thickness of the wall, in the limb frame; None if the shape is no wall."""
    through_mm: tuple[float, float] = AXIS_MM
    """Where a line along z goes through the limb that was measured, in the limb frame."""

    __repr__ = brief

    def to_frame(self) -> Any:
        """A pandas.DataFrame with a row for each height; every figure with its sigma.

        Raises:
            MissingError: pandas is not installed.
        """
        names = [name for name in (*MEASURES, _VOLUME) if self._has_figure(name)]
        columns = [column for name in names for column in (name, f"sigma_{name}")]
        rows = tuple(
            (
                row.height_mm,
                row.from_reference_mm,
                *chain.from_iterable(_value_and_sigma(row.figures.get(name)) for name in names),
            )
            for row in self.rows
        )
        columns = ("height_mm", "from_reference_mm", *columns)
        return data_frame(Table(title="levels", columns=columns, rows=rows))

    def plot(self, name: str = "tape_mm", axes: Any = None) -> Any:
        """A figure of MEASURES over the height, with the band of its ±; returns the axes.

        Args:
            axes: Of matplotlib, to draw on; None for new ones.
        """
        if axes is None:
            from matplotlib import pyplot  # half a second, for notebooks alone

            axes = pyplot.subplots(figsize=(5, 4), layout="constrained")[1]
        shown = [(row.from_reference_mm, row.figures[name]) for row in self.rows]
        known = [(height, figure) for height, figure in shown if figure is not None]
        heights = np.array([height for height, _ in known])
        values = np.array([figure.value for _, figure in known])
        reach = COVER * np.array([figure.sigma or 0.0 for _, figure in known])
        axes.plot(values, heights, marker=".")
        axes.fill_betweenx(heights, values - reach, values + reach, alpha=0.3)
        axes.set_xlabel(heading(name))
        axes.set_ylabel(f"height from {self.reference_name} [mm]", parse_math=False)
        return axes

    def _repr_html_(self) -> str:
        """The table with ±, for notebooks."""
        names = [name for name in (*MEASURES, _VOLUME) if self._has_figure(name)]
        columns = ("from_reference_mm", *names)
        rows = tuple(
            (row.from_reference_mm, *map(_with_interval, map(row.figures.get, names)))
            for row in self.rows
        )
        said = f"{self.limb.name}: heights in mm from {self.reference_name}; {HOLDS}"
        return html_of(Table(title="levels", columns=columns, rows=rows), said.removeprefix(": "))

    def _has_figure(self, name: str) -> bool:
        return any(row.figures.get(name) is not None for row in self.rows)

    @property
    def others_note(self) -> Finding | None:
        """A note of other limbs' outlines at the heights of the table; None without any."""
        rows = [row for row in self.rows if row.others]
        if not rows:
            return None
        return note(
            "measure.beside",
            levels=len(rows),
            of_levels=len(self.rows),
            on_axis=self.through_mm == AXIS_MM,
            others=tuple(
                note(
                    "measure.beside.at",
                    height_mm=row.from_reference_mm,
                    contours_mm=tuple(other.contour_mm for other in row.others),
                )
                for row in rows
            ),
        )

    @property
    def reference_name(self) -> str:
        """The name of what heights count from; edits and socks move the tip off the origin."""
        if self.reference is not None:
            return self.reference
        return "distal end" if abs(self.tip_mm) <= _AT_ORIGIN_MM else "origin of the limb frame"

    @property
    def reference_phrase(self) -> str:
        """What heights count from, as a phrase after `Heights from`."""
        if self.reference is not None:
            return self.reference
        away = abs(self.tip_mm) > _AT_ORIGIN_MM
        return f"the {self.reference_name}" + (
            f"; the tip lies at {self.tip_mm:.1f} mm" if away else ""
        )


def _value_and_sigma(figure: Figure | None) -> tuple[float | None, float | None]:
    return (None, None) if figure is None else (figure.value, figure.sigma)


def _with_interval(figure: Figure | None) -> str:
    return "" if figure is None else figure.with_interval


def measure_limb(limb: Limb, options: LimbMeasureOptions = DEFAULTS) -> Measures:
    """Measure an aligned limb."""
    limb = limb.aligned()
    bare = limb if options.sock_mm is None else without_sock(limb, options.sock_mm)
    outside = outer_bodies(bare.mesh_in_limb)
    outside.require_one_limb()
    sigmas = Sigmas.of(outside.mesh)
    zero = _reference_mm(bare, options.reference)
    heights = _heights(sigmas, zero, options)
    volumes = Volumes.of(sigmas)
    through_mm = _through_mm(bare, options.through)
    cuts = levels_at(sigmas.mesh, heights, through_mm)
    rows = tuple(_row_of_level(sigmas, volumes, level, zero) for level in cuts)
    levels = [row.level for row in rows if row.level is not None]
    if not levels:
        raise MeasureError("measure.no_level", first=rows[0].reasons[0])
    return Measures(
        limb=bare,
        reference=options.reference,
        reference_mm=zero,
        tip_mm=float(sigmas.mesh.vertices_mm[:, 2].min()),
        rows=rows,
        volumes=tuple(
            _volume_row(volumes, zero, span, _BEYOND_MM + bare.sock_mm)
            for span in options.volumes_mm
        ),
        lengths=tuple(
            length_between(
                sigmas,
                _place_of(bare, start, options.placing),
                _place_of(bare, end, options.placing),
            )
            for start, end in options.lengths
        ),
        tape=_tape_checks(sigmas, zero, options.tape, through_mm),
        bodies_left_out=outside.bodies_left_out,
        loose=outside.loose,
        skin="outside" if is_two_skinned(levels) else "only",
        outer_mesh=sigmas.mesh,
        wall=wall_thickness(sigmas.mesh),
        through_mm=through_mm,
    )


def measure_inside(limb: Limb, options: LimbMeasureOptions = DEFAULTS) -> Measures:
    """Measure the inside of an aligned wall, such as a socket.

    Raises:
        MeasureError: it encloses no hollow, or as `measure_limb`.
    """
    found = measure_limb(inside_of(limb), options)
    whole = outer_bodies(limb.aligned().mesh_in_limb).mesh
    return replace(found, skin="inside", outer_mesh=whole, wall=wall_thickness(whole))


def check_one_reading(found: Measures, reading: TapeReading) -> TapeCheck | Finding:
    """Compare one tape reading with a measured limb; a finding says why it cannot be compared.

    In a list of readings one that lies beyond the limb must not hide the others.
    """
    sigmas = Sigmas.of(outer_bodies(found.limb.mesh_in_limb).mesh)
    return _check_of_reading(sigmas, found.reference_mm, reading, found.through_mm)


def _reference_mm(limb: AlignedLimb, name: str | None) -> float:
    return 0.0 if name is None else float(_place_of(limb, name).in_limb_mm[2])


def _through_mm(limb: AlignedLimb, name: str | None) -> tuple[float, float]:
    if name is None:
        return AXIS_MM
    x, y, _ = _place_of(limb, name).in_limb_mm.tolist()
    return x, y


def _place_of(limb: AlignedLimb, name: str, placing: Placing = USUAL) -> Place:
    mark = landmark(limb, name)
    return Place(name, limb.landmark_in_limb_mm(mark), placing.of(mark))


def _heights(sigmas: Sigmas, zero: float, options: LimbMeasureOptions) -> list[float]:
    """Heights in the limb frame: those asked for, or all multiples of the spacing in the limb."""
    if options.heights_mm is not None:
        if not options.heights_mm or not all(map(math.isfinite, options.heights_mm)):
            raise OptionsError("measure.heights.not_numbers")
        return [height + zero for height in options.heights_mm]
    if not options.spacing_mm > 0:
        raise OptionsError("measure.spacing.not_positive", spacing_mm=options.spacing_mm)
    z = sigmas.mesh.vertices_mm[:, 2]
    low, high = float(z.min()) - zero + _TOUCHING_MM, float(z.max()) - zero - _TOUCHING_MM
    first, last = math.floor(low / options.spacing_mm) + 1, math.ceil(high / options.spacing_mm) - 1
    if not 0 <= last - first < _MOST_LEVELS:
        raise OptionsError(
            "measure.spacing.levels",
            spacing_mm=options.spacing_mm,
            levels=last - first + 1,
            limb_mm=high - low,
            most=_MOST_LEVELS,
        )
    return [k * options.spacing_mm + zero for k in range(first, last + 1)]


def _row_of_level(sigmas: Sigmas, volumes: Volumes, level: Level | Refused, zero: float) -> Row:
    height = level.height_mm
    if isinstance(level, Refused):
        nothing: dict[str, Figure | None] = dict.fromkeys([*MEASURES, "volume_below_mm3"])
        return Row(
            height_mm=height,
            from_reference_mm=height - zero,
            figures=nothing,
            loops=0,
            reasons=(_from_reference(level.reason, zero),),
            level=None,
        )
    reasons: list[Finding] = []
    figures: dict[str, Figure | None] = {}
    for name, measured in MEASURES.items():
        sloped = measured(level)
        figures[name] = None if sloped is None else sigmas.figure(level, sloped)
    if None in figures.values():
        reasons.append(note("measure.level.off_axis"))
    try:
        figures["volume_below_mm3"] = volumes.between(DISTAL_END, height)
    except MeasureError as error:
        figures["volume_below_mm3"] = None
        reasons.append(_from_reference(error.finding, zero))
    return Row(
        height_mm=height,
        from_reference_mm=height - zero,
        figures=figures,
        loops=len(level.depth),
        reasons=tuple(reasons),
        level=level,
    )


def _volume_row(
    volumes: Volumes, zero: float, span_mm: tuple[float, float], most_beyond_mm: float
) -> VolumeRow:
    """The row of a volume; a height just beyond the limb stands for its end."""
    z = volumes.sigmas.mesh.vertices_mm[:, 2]
    ends = float(z.min()), float(z.max())
    heights: list[float] = []
    notes: list[Finding] = []
    for height in (span_mm[0] + zero, span_mm[1] + zero):
        beyond, end = max((ends[0] - height, ends[0]), (height - ends[1], ends[1]))
        if 0 < beyond <= most_beyond_mm:
            heights.append(DISTAL_END if end == ends[0] else PROXIMAL_END)
            notes.append(note("measure.volume.clamped", end_mm=end - zero, asked_mm=height - zero))
        else:
            heights.append(height)
    try:
        volume_mm3 = volumes.between(*heights)
    except MeasureError as error:
        raise MeasureError.of(_from_reference(error.finding, zero)) from error
    return VolumeRow(
        low_mm=span_mm[0], high_mm=span_mm[1], volume_mm3=volume_mm3, notes=tuple(notes)
    )


def _from_reference(reason: Finding, zero: float) -> Finding:
    """A refusal with its heights counted from the reference, as those that were asked for."""
    values = {
        name: value - zero if name in _HEIGHT_VALUES and isinstance(value, float) else value
        for name, value in reason.values.items()
    }
    return replace(reason, values=values)


def _tape_checks(
    sigmas: Sigmas,
    zero: float,
    readings: tuple[TapeReading, ...],
    through_mm: tuple[float, float],
) -> tuple[TapeCheck, ...]:
    checks: list[TapeCheck] = []
    for reading in readings:
        check = _check_of_reading(sigmas, zero, reading, through_mm)
        if isinstance(check, Finding):
            raise MeasureError("tape.no_girth", reason=check)
        checks.append(check)
    return tuple(checks)


def _check_of_reading(
    sigmas: Sigmas, zero: float, reading: TapeReading, through_mm: tuple[float, float]
) -> TapeCheck | Finding:
    """The check of a reading against the shape's girth, or the reason why there is none."""
    (level,) = levels_at(sigmas.mesh, [reading.height_mm + zero], through_mm)
    if isinstance(level, Refused):
        return _from_reference(level.reason, zero)
    girth = sigmas.figure(level, tape_mm(level))
    taper_mm = max(_taper_mm(sigmas, level, way, through_mm) for way in (-1.0, 1.0))
    return check_reading(reading, level.height_mm, girth, taper_mm)


def _taper_mm(sigmas: Sigmas, level: Level, way: float, through_mm: tuple[float, float]) -> float:
    """Change of the girth over the tape's placing error to one side, from levels that are whole."""
    steps_mm = [way * PLACING_SIGMA_MM * share for share in TAPER_SHARES]
    near = levels_at(sigmas.mesh, [level.height_mm + step for step in steps_mm], through_mm)
    beside_mm = (math.nan if isinstance(one, Refused) else tape_mm(one).value for one in near)
    return taper_beside_mm(tape_mm(level).value, beside_mm)
