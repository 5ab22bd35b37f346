"""Exports: files for carvers, printers and other programs, with what was read back of each."""

from dataclasses import replace
from typing import Annotated, Literal

from fastapi import APIRouter, Path
from fastapi.responses import FileResponse
from pydantic import BaseModel, Field

from limbgram.app.clinic import BenchHere, ClinicHere
from limbgram.app.replies import PICTURE
from limbgram.cases.handover import (
    FileKind,
    HandedOver,
    HandoverOptions,
    hand_over,
    handed,
    handed_over,
)
from limbgram.formats.aop.profiles import Profile
from limbgram.formats.aop.writing import AopOptions, LineEnd
from limbgram.formats.gcode.control import Control, DialectName, Winding
from limbgram.workbench.carving.mapping import MapOptions
from limbgram.workbench.carving.setup import CarveOptions
from limbgram.workbench.limb import Side

router = APIRouter(tags=["export"])

NameHere = Annotated[
    str, Path(max_length=80, pattern=r"^[A-Za-z0-9][A-Za-z0-9.-]*$", description="Of the file.")
]


class AopSettings(BaseModel):
    """What a carver's AOP file is like."""

    spokes: int = Field(default=120, ge=8, le=3600)
    spacing_mm: float = Field(default=2.0, ge=0.1, le=50)
    distal_slices: int = Field(
        default=0, ge=0, le=100, description="More slices at the rounded tip."
    )
    profile: Profile = Field(default="mm", description="Whose habits.")
    axis: Literal["limb", "fit"] = "limb"
    line_end: LineEnd = "lf"


class CarverSettings(BaseModel):
    """A four-axis carver."""

    tool_diameter_mm: float = Field(default=12.0, ge=1, le=60)
    tool_reach_mm: float = Field(default=120.0, ge=5, le=1000)
    blank_diameter_mm: float | None = Field(default=None, ge=10, le=3000)
    scallop_mm: float = Field(default=0.05, ge=0.001, le=2, description="Height of ridges.")
    feed_mm_min: float = Field(default=3000.0, ge=10, le=50_000)
    dialect: DialectName = "linuxcnc"
    winding: Winding = "unwind"


class NewExport(BaseModel):
    """Which file to write."""

    kind: FileKind
    side: Side = Field(description="Said anew by whoever looks at the patient; never filled in.")
    signed_by: str = Field(
        default="", max_length=300, description="For a red capture: who takes it on, and why."
    )
    aop: AopSettings = Field(default=AopSettings())
    sections_mm: float = Field(default=10.0, ge=0.5, le=200, description="Of a DXF.")
    carver: CarverSettings = Field(default=CarverSettings())


@router.get("/cases/{case_id}/exports")
def list_exports(bench: BenchHere) -> list[HandedOver]:
    """The files that were written, the newest first."""
    return list(handed_over(bench))


@router.post("/cases/{case_id}/exports", status_code=201)
def new_export(clinic: ClinicHere, bench: BenchHere, given: NewExport) -> HandedOver:
    """Write a file, read it back, compare, and draw the picture to hold against the patient."""
    written = hand_over(bench, clinic.desk.work(bench), _options(given))
    clinic.news.tell(bench.case.case_id, "work")
    return written


@router.get("/cases/{case_id}/exports/{name}", response_class=FileResponse, responses=PICTURE)
def read_export(bench: BenchHere, name: NameHere) -> FileResponse:
    """The file."""
    found = handed(bench, name)
    return FileResponse(
        bench.files / found.name, filename=found.name, media_type="application/octet-stream"
    )


@router.get(
    "/cases/{case_id}/exports/{name}/mirror", response_class=FileResponse, responses=PICTURE
)
def read_mirror(bench: BenchHere, name: NameHere) -> FileResponse:
    """The mirror check: what the file holds, to be held against the patient."""
    return FileResponse(bench.files / f"{handed(bench, name).name}.mirror.png")


def _options(given: NewExport) -> HandoverOptions:
    aop, carver = given.aop, given.carver
    of_map = MapOptions(
        spokes=aop.spokes, spacing_mm=aop.spacing_mm, distal_slices=aop.distal_slices
    )
    return HandoverOptions(
        kind=given.kind,
        side=given.side,
        signed_by=given.signed_by,
        aop=AopOptions(map=of_map, profile=aop.profile, axis=aop.axis, line_end=aop.line_end),
        sections_mm=given.sections_mm,
        carving=replace(
            CarveOptions(),
            tool_diameter_mm=carver.tool_diameter_mm,
            tool_reach_mm=carver.tool_reach_mm,
            blank_diameter_mm=carver.blank_diameter_mm,
            scallop_mm=carver.scallop_mm,
            feed_mm_min=carver.feed_mm_min,
        ),
        control=Control(dialect=carver.dialect, winding=carver.winding),
    )
