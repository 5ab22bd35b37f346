"""Measures: the table of girths, widths and volumes, and what the tape read."""

import math
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Response
from pydantic import BaseModel, Field

from limbgram.app.forms import REQUEST, RequestBody
from limbgram.app.replies import FindingReply
from limbgram.app.state import AppState, AppStateHere, WorkspaceHere
from limbgram.app.surface import Which, limb_of
from limbgram.cases.workspace import Workspace
from limbgram.core.interval import COVER
from limbgram.core.request_fields import Within
from limbgram.core.spreadsheet import Decimal
from limbgram.findings import Finding
from limbgram.services.measure import MeasureRequest, workbook
from limbgram.services.measure import measure as measured
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.levels import Figure
from limbgram.workbench.measures.measuring import Measures, Row, check_one_reading
from limbgram.workbench.measures.sheet import SheetRow
from limbgram.workbench.measures.table import csv_text
from limbgram.workbench.measures.tape import TapeCheck, TapeReading
from limbgram.workbench.recipe.ledger import SPACING_MM

router = APIRouter(tags=["measures"])
_XLSX = "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet"

SAME_HEIGHT_MM = 0.01
"""Heights so near are one: what a page shows of them has fewer digits."""
Millimetres = Annotated[float, Field(ge=-5000, le=5000)]


class Value(BaseModel):
    """A figure and how sure it is."""

    value: float
    sigma: float | None = Field(default=None, description="One standard deviation.")
    within: float | None = Field(default=None, description="± in 95 of 100.")


class Level(BaseModel):
    """One height of the table; lengths in mm, areas in mm2, volumes in mL."""

    height_mm: float = Field(description="In the limb frame.")
    from_reference_mm: float
    tape_mm: Value | None = Field(description="By a taut tape, smoothed over 5 mm.")
    contour_mm: Value | None = Field(description="Along the contour, smoothed over 5 mm.")
    ml_mm: Value | None = Field(description="From side to side.")
    ap_mm: Value | None = Field(description="From front to back.")
    area_mm2: Value | None
    volume_below_ml: Value | None
    loops: int
    reasons: list[FindingReply] = Field(default=[], description="Why a figure is missing.")


class Volume(BaseModel):
    """Between two heights; null stands for an end of the limb."""

    from_mm: float | None
    to_mm: float | None
    volume_ml: Value
    notes: list[FindingReply] = Field(default=[], description="Which end was taken for a height.")


class Length(BaseModel):
    """Between two places."""

    start: str
    end: str
    along_axis_mm: Value
    straight_mm: Value
    over_surface_mm: Value


class Reading(RequestBody):
    """A girth that was read on the patient."""

    height_mm: Millimetres = Field(description="From the origin of the limb frame, upwards.")
    girth_mm: float = Field(gt=0, le=5000)


class ReadingChange(RequestBody):
    """One girth that was read, read anew, or taken back."""

    height_mm: Millimetres = Field(description="Of the reading that is there.")
    girth_mm: float | None = Field(gt=0, le=5000, description="null: there is none any more.")


class TapeReply(Reading):
    """A reading beside what the scan has there, as the record has it."""

    measured_mm: Value | None = None
    difference_mm: float | None = Field(default=None, description="Positive: the scan is larger.")
    within_mm: float | None = Field(
        default=None, description="± of the difference, of tape and shape, in 95 of 100."
    )
    conflict: bool = Field(default=False, description="Tape and shape contradict each other.")
    accepted: str = Field(default="", description="When somebody went on in spite of it.")
    reason: FindingReply | None = Field(
        default=None, description="Why there is nothing to compare with."
    )


@dataclass(frozen=True, kw_only=True)
class AskMeasures(MeasureRequest):
    """What is to be measured."""

    __pydantic_config__ = REQUEST

    every_mm: Annotated[float, Within(0.1, 1000), Field(alias="spacing_mm")] = SPACING_MM
    """Of the levels."""
    of: Which = "scan"
    """Which shape of the case."""
    with_tape: bool = True
    """Hold the readings that are kept against the scan, whatever is measured."""


class SheetLine(BaseModel):
    """A figure of the measuring sheet of the kind of limb."""

    name: str
    words: dict[str, str] = Field(description="What people call it, by language.")
    unit: str
    value: Value | None
    formula: str = ""
    reason: FindingReply | None = Field(default=None, description="Why there is none.")


class MeasuresReply(BaseModel):
    """The table."""

    counted_from: str
    reference_height_mm: float
    tip_height_mm: float
    sock_mm: float
    levels: list[Level]
    volumes: list[Volume]
    lengths: list[Length]
    tape: list[TapeReply]
    notes: list[FindingReply]
    sheet: list[SheetLine] = Field(default=[], description="Where it was asked for.")


@router.post("/cases/{case_id}/measures")
def measure(app_state: AppStateHere, workspace: WorkspaceHere, given: AskMeasures) -> MeasuresReply:
    """Measure an aligned shape by level."""
    limb, _ = limb_of(app_state, workspace, given.of)
    done = measured(limb, given)
    found = done.measures
    return MeasuresReply(
        counted_from=found.reference_name,
        reference_height_mm=found.reference_mm,
        tip_height_mm=found.tip_mm,
        sock_mm=found.limb.sock_mm,
        levels=[_level(row) for row in found.rows],
        volumes=[
            Volume(
                from_mm=row.low_mm if math.isfinite(row.low_mm) else None,
                to_mm=row.high_mm if math.isfinite(row.high_mm) else None,
                volume_ml=_ml(row.volume_mm3),
                notes=[FindingReply.of(one) for one in row.notes],
            )
            for row in found.volumes
        ],
        lengths=[
            Length(
                start=one.start,
                end=one.end,
                along_axis_mm=_value(one.along_axis),
                straight_mm=_value(one.straight),
                over_surface_mm=_value(one.over_surface),
            )
            for one in found.lengths
        ],
        tape=[
            *(_tape_reply(one, one.height_mm - found.reference_mm) for one in found.tape),
            *(_tape(app_state, workspace) if given.with_tape else ()),
        ],
        notes=[FindingReply.of(one) for one in _notes(limb, found)],
        sheet=[] if done.form is None else [_sheet_line(one) for one in done.form.rows],
    )


def _sheet_line(row: SheetRow) -> SheetLine:
    return SheetLine(
        name=row.name,
        words=dict(row.words),
        unit=row.unit,
        value=None if row.figure is None else _value(row.figure),
        formula=row.formula,
        reason=None if row.reason is None else FindingReply.of(row.reason),
    )


@router.post("/cases/{case_id}/measures.xlsx", response_class=Response)
def measure_xlsx(app_state: AppStateHere, workspace: WorkspaceHere, given: AskMeasures) -> Response:
    """The same tables for a spreadsheet, a sheet each."""
    limb, _ = limb_of(app_state, workspace, given.of)
    return Response(workbook(measured(limb, given)), media_type=_XLSX)


@router.post("/cases/{case_id}/measures.csv", response_class=Response)
def measure_csv(
    app_state: AppStateHere,
    workspace: WorkspaceHere,
    given: AskMeasures,
    decimal: Decimal = "point",
) -> Response:
    """The table of levels as text; with a decimal comma semicolons part its columns."""
    limb, _ = limb_of(app_state, workspace, given.of)
    text = csv_text(measured(limb, given).measures, decimal)
    return Response(text, media_type="text/csv; charset=utf-8")


@router.get("/cases/{case_id}/tape")
def read_tape(workspace: WorkspaceHere) -> list[Reading]:
    """Girths that were read on the patient."""
    return _readings(workspace)


@router.put("/cases/{case_id}/tape")
def keep_tape(
    app_state: AppStateHere, workspace: WorkspaceHere, given: list[Reading]
) -> list[Reading]:
    """Keep all girths that were read, in place of those before; PATCH changes one of them."""
    with app_state.shape_cache.changing(workspace):
        workspace.save_tape(
            tuple(TapeReading(height_mm=one.height_mm, girth_mm=one.girth_mm) for one in given)
        )
    app_state.news.tell(workspace.case.case_id, "work")
    return _readings(workspace)


@router.patch("/cases/{case_id}/tape")
def change_tape(
    app_state: AppStateHere, workspace: WorkspaceHere, given: ReadingChange
) -> list[Reading]:
    """Keep, change or take back the girth at one height; the others stay as they are."""
    with app_state.shape_cache.changing(workspace):
        kept = [
            one for one in workspace.tape() if abs(one.height_mm - given.height_mm) > SAME_HEIGHT_MM
        ]
        if given.girth_mm is not None:
            kept.append(TapeReading(height_mm=given.height_mm, girth_mm=given.girth_mm))
        workspace.save_tape(tuple(sorted(kept, key=lambda one: one.height_mm)))
    app_state.news.tell(workspace.case.case_id, "work")
    return _readings(workspace)


@router.post("/cases/{case_id}/tape/accept")
def accept_tape(app_state: AppStateHere, workspace: WorkspaceHere, given: Reading) -> list[Reading]:
    """Note, for the record, that somebody goes on in spite of what this reading says."""
    with app_state.shape_cache.changing(workspace):
        workspace.accept_tape(
            next(
                (
                    one
                    for one in workspace.tape()
                    if abs(one.height_mm - given.height_mm) <= SAME_HEIGHT_MM
                    and one.girth_mm == given.girth_mm
                ),
                TapeReading(height_mm=given.height_mm, girth_mm=given.girth_mm),
            )
        )
    app_state.news.tell(workspace.case.case_id, "work")
    return _readings(workspace)


def _readings(workspace: Workspace) -> list[Reading]:
    return [Reading(height_mm=one.height_mm, girth_mm=one.girth_mm) for one in workspace.tape()]


def _tape(app_state: AppState, workspace: Workspace) -> list[TapeReply]:
    """Each reading by itself, held against the scan as in the record, whatever shape is shown.

    One above the brim must not hide the others.
    """
    standings = {one.read.reading: one for one in workspace.tape_standings() if not one.withdrawn}
    replies: list[TapeReply] = []
    for reading in workspace.tape():
        checked = check_one_reading(app_state.shape_cache.shape(workspace).measures, reading)
        if isinstance(checked, TapeCheck):
            reply = _tape_reply(checked, reading.height_mm)
            reply.accepted = standings[reading].accepted if reading in standings else ""
        else:
            reply = TapeReply(
                height_mm=reading.height_mm,
                girth_mm=reading.girth_mm,
                reason=FindingReply.of(checked),
            )
        replies.append(reply)
    return replies


def _tape_reply(check: TapeCheck, height_mm: float) -> TapeReply:
    """Args:
    height_mm: As it was read: from the reference.
    """
    return TapeReply(
        height_mm=height_mm,
        girth_mm=check.read_mm,
        measured_mm=_value(check.measured),
        difference_mm=check.difference_mm,
        within_mm=COVER * check.sigma_mm,
        conflict=check.conflict,
    )


def _notes(limb: Limb, found: Measures) -> tuple[Finding, ...]:
    return limb.notes if found.others_note is None else (*limb.notes, found.others_note)


def _level(row: Row) -> Level:
    figures = {name: None if one is None else _value(one) for name, one in row.figures.items()}
    below = row.figures["volume_below_mm3"]
    return Level(
        height_mm=row.height_mm,
        from_reference_mm=row.from_reference_mm,
        tape_mm=figures["tape_mm"],
        contour_mm=figures["contour_mm"],
        ml_mm=figures["ml_mm"],
        ap_mm=figures["ap_mm"],
        area_mm2=figures["area_mm2"],
        volume_below_ml=None if below is None else _ml(below),
        loops=row.loops,
        reasons=[FindingReply.of(one) for one in row.reasons],
    )


def _value(figure: Figure) -> Value:
    within = None if figure.sigma is None else COVER * figure.sigma
    return Value(value=figure.value, sigma=figure.sigma, within=within)


def _ml(figure: Figure) -> Value:
    sigma = None if figure.sigma is None else figure.sigma / 1000
    return _value(Figure(figure.value / 1000, sigma))
