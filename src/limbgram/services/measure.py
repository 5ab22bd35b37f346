"""Measure: a shape by level, and what is written of the table.

In      an aligned shape, or one that is measured across its file's z; what is asked of it.
Out     Sheet: the table, the shape made to agree with the tape, and the files that were asked for.
Fails   MeasureError: not aligned, or something that was asked for has no answer.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np

from limbgram.core.errors import OptionsError
from limbgram.core.files import write_bytes
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.notebook import brief
from limbgram.core.request_fields import AtMost, Flag, Panel, Within
from limbgram.core.spreadsheet import Decimal, csv_of, xlsx_of
from limbgram.formats.export_checks import as_kept
from limbgram.formats.limb_file import write_limb
from limbgram.services.parse_text import PAIR, READING, SPAN, Height, Pair, Span
from limbgram.workbench.anatomy.landmark import USUAL, Placing
from limbgram.workbench.bodies import outer_bodies
from limbgram.workbench.edits.thickness import Thickness
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame
from limbgram.workbench.measures.along import AlongCentreline, measure_along
from limbgram.workbench.measures.measuring import (
    LimbMeasureOptions,
    Measures,
    measure_inside,
    measure_limb,
)
from limbgram.workbench.measures.sheet import MeasuringSheet, SheetOptions, measuring_sheet
from limbgram.workbench.measures.table import csv_text, tables
from limbgram.workbench.measures.tape import TapeFit, TapeReading, fit_to_tape

_SHEET = Panel("Measuring sheet")


@dataclass(frozen=True, kw_only=True)
class SheetRequest:
    """What a measuring sheet hangs on besides the limb."""

    shoe_heel_mm: Annotated[float, Within(0, 150), Flag("shoe-heel"), _SHEET] = 0.0
    """Height of the shoe's heel, mm: it inclines the shank."""
    shoe_sole_mm: Annotated[float, Within(0, 150), Flag("shoe-sole"), _SHEET] = 0.0
    """Height of its sole under the ball, mm."""
    click_mm: Annotated[float | None, Within(0, 50), _SHEET] = None
    """How well landmarks were placed that were clicked: one standard deviation in each direction
    along the surface, mm; without it 2, which is assumed."""
    painted_mm: Annotated[float | None, Within(0, 50), _SHEET] = None
    """The same of landmarks at painted marks; without it 1."""
    proposed_mm: Annotated[float | None, Within(0, 50), _SHEET] = None
    """The same of landmarks that were proposed and confirmed; without it 3."""

    def of_sheet(self) -> SheetOptions:
        """What the measuring sheet hangs on."""
        return SheetOptions(
            shoe_heel_mm=self.shoe_heel_mm,
            shoe_sole_mm=self.shoe_sole_mm,
            placing=Placing(
                click_mm=USUAL.click_mm if self.click_mm is None else self.click_mm,
                painted_mm=USUAL.painted_mm if self.painted_mm is None else self.painted_mm,
                proposed_mm=USUAL.proposed_mm if self.proposed_mm is None else self.proposed_mm,
            ),
        )


@dataclass(frozen=True, kw_only=True)
class MeasureRequest(SheetRequest):
    """What is measured; heights count from the reference, upwards."""

    every_mm: Annotated[float, Within(0.1, 1000), Flag("every")] = 10.0
    """Spacing of the levels, mm."""
    heights_mm: Annotated[tuple[Height, ...] | None, AtMost(500), Flag("height")] = None
    """Only at this height, mm."""
    reference: Annotated[str | None, Flag("from")] = None
    """Landmark from which heights count, upwards; without it the distal end."""
    volumes: Annotated[tuple[Annotated[Span, SPAN], ...], AtMost(100), Flag("volume")] = ()
    """Volume between two heights: 20:150, end:150."""
    lengths: Annotated[tuple[Annotated[Pair, PAIR], ...], AtMost(100), Flag("length")] = ()
    """Between two landmarks, over the surface too: "patella:tibia end"."""
    through: str | None = None
    """Landmark of the limb to measure where a plane cuts several; without it the one that the long
    axis goes through."""
    sock_mm: Annotated[float | None, Within(0, 20), Flag("sock")] = None
    """Thickness of the sock in the scan, mm, taken off first; without it nothing is taken off."""
    tapes: Annotated[tuple[Annotated[TapeReading, READING], ...], AtMost(100), Flag("tape")] = ()
    """A girth that was read: HEIGHT=GIRTH, mm. It counts as read to 3 mm in 95 of 100; state
    another as HEIGHT=GIRTH+-2."""
    inside: bool = False
    """Measure what a wall holds, such as the inside of a socket."""
    unaligned: bool = False
    """Measure across the file's z, from its lowest point."""
    along: bool = False
    """Also measure across the kind's centreline, which bends in a foot, and along it."""
    sheet: Annotated[bool, _SHEET] = False
    """Fill in the measuring sheet of the kind of limb, beside the levels."""

    def options(self) -> LimbMeasureOptions:
        """The options of the workbench."""
        return LimbMeasureOptions(
            spacing_mm=self.every_mm,
            heights_mm=self.heights_mm,
            reference=self.reference,
            sock_mm=self.sock_mm,
            volumes_mm=tuple(
                (-math.inf if low is None else low, math.inf if high is None else high)
                for low, high in self.volumes
            ),
            lengths=self.lengths,
            placing=self.of_sheet().placing,
            tape=self.tapes,
            through=self.through,
        )


@dataclass(frozen=True, kw_only=True)
class MeasureFiles:
    """What is written of the table."""

    fit: Path | None = None
    """Write a shape whose girths agree with the tape readings."""
    xlsx: Path | None = None
    """Write the tables for a spreadsheet (.xlsx), a sheet each; with --sheet the measuring sheet
    too."""
    csv: Path | None = None
    """Write the table of levels as text (CSV)."""
    decimal: Decimal = "point"
    """Decimal sign of the text; with a comma semicolons part its columns, as spreadsheets set to
    German, French or the like expect."""
    sheet_csv: Path | None = None
    """Write the measuring sheet as CSV."""
    picture: Path | None = None
    """Write a picture of it (PNG)."""
    walls: Path | None = None
    """Write a map of a wall's thickness (PNG)."""


NO_FILES = MeasureFiles()


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """What was measured and written."""

    measures: Measures
    fitted: TapeFit | None
    """The shape made to agree with the tape, where that was asked for."""
    written: tuple[Path, ...]
    form: MeasuringSheet | None = None
    """The measuring sheet of its kind, where that was asked for."""
    along: AlongCentreline | None = None
    """What was measured across its centreline, where that was asked for."""

    __repr__ = brief


def measure(limb: Limb, ask: MeasureRequest, files: MeasureFiles = NO_FILES) -> Sheet:
    """Measure a shape by level; a height that has no answer stands in the table with the reason.

    Raises:
        OptionsError: a fit without a tape or of an inside, or a map of a wall that is none.
        MeasureError: not aligned, or something that was asked for has no answer.
    """
    if files.fit is not None and not ask.tapes:
        raise OptionsError("options.measure.fit_without_tape")
    if files.fit is not None and ask.inside:
        raise OptionsError("options.measure.fit_inside")
    limb = _standing(limb) if ask.unaligned else limb.aligned()
    options = ask.options()
    measures = measure_inside(limb, options) if ask.inside else measure_limb(limb, options)
    if files.walls is not None and measures.wall is None:
        raise OptionsError("options.measure.no_walls")
    fitted = (
        None
        if files.fit is None
        else fit_to_tape(measures.limb, ask.tapes, measures.reference_mm, measures.through_mm)
    )
    if files.fit is not None and fitted is not None:
        fitted = replace(fitted, limb=as_kept(fitted.limb, files.fit))
    wanted = ask.sheet or files.sheet_csv is not None
    of_sheet = ask.of_sheet()
    form = measuring_sheet(measures.limb, of_sheet) if wanted else None
    along = (
        measure_along(measures.limb, ask.every_mm, ask.lengths, of_sheet.placing)
        if ask.along
        else None
    )
    found = Sheet(measures=measures, fitted=fitted, written=(), form=form, along=along)
    return replace(found, written=tuple(_written(found, files)))


def workbook(found: Sheet) -> bytes:
    """All tables for a spreadsheet, a sheet each; the measuring sheet too, where it was asked."""
    along = () if found.along is None else found.along.tables()
    return xlsx_of([*tables(found.measures, found.form), *along])


def _standing(limb: Limb) -> AlignedLimb:
    """The limb with the axes of its file, from its lowest point."""
    lowest_mm = float(outer_bodies(limb.mesh).mesh.vertices_mm[:, 2].min())
    up = Rigid(np.eye(3), np.array([0.0, 0.0, -lowest_mm]))
    return limb.with_frame(LimbFrame(limb_from_mesh=up, side="none"))


def _written(found: Sheet, files: MeasureFiles) -> Iterator[Path]:
    measures, fitted, form = found.measures, found.fitted, found.form
    if files.xlsx is not None:
        yield write_bytes(files.xlsx, workbook(found))
    if files.csv is not None:
        yield write_bytes(files.csv, csv_text(measures, files.decimal).encode())
    if files.picture is not None:
        yield write_bytes(files.picture, _picture(measures))
    if files.fit is not None and fitted is not None:
        yield write_limb(fitted.limb, files.fit)
    if files.walls is not None and measures.wall is not None:
        yield write_bytes(files.walls, _map(measures.outer_mesh, measures.wall))
    if files.sheet_csv is not None and form is not None:
        yield write_bytes(files.sheet_csv, csv_of(form.table(), files.decimal).encode())


def _picture(measures: Measures) -> bytes:
    """Drawn only where asked: what draws takes longer to import than a shape to measure."""
    from limbgram.report.drawings.drawing import png
    from limbgram.report.drawings.sections import sections_drawing

    return png(sections_drawing(measures).figure).tobytes()


def _map(mesh_in_limb: Mesh, wall: Thickness) -> bytes:
    from limbgram.report.drawings.drawing import png
    from limbgram.report.drawings.wall_thickness import wall_map

    return png(wall_map(mesh_in_limb, wall).figure).tobytes()
