"""Report: the record of a shape as a page, a PDF of two sheets, and JSON.

In      an aligned shape; what it is compared with, the recipe, the case of its scan, if any.
Out     the record and its three files in a folder.
Fails   MeasureError: not aligned. OptionsError: a recipe of neither shape. ExportError: the folder
        cannot be made.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from limbgram.core.errors import OptionsError
from limbgram.core.files import make_folder, require_folder, write_bytes
from limbgram.core.request_fields import Flag, Within
from limbgram.report.html import html_of
from limbgram.report.pdf import pdf_of
from limbgram.report.record.layout import record_report
from limbgram.report.record.record import Record, RecordOptions, record_of
from limbgram.report.record.sources import CaseSource, RecipeSource, ShapeSource
from limbgram.workbench.compare.registration import Way


@dataclass(frozen=True, kw_only=True)
class ReportRequest:
    """What the record shows."""

    align: Way | None = None
    """How the other shape is laid on it; never scaled. Without it as-is with a recipe for it, else
    auto."""
    every_mm: Annotated[float, Within(0.1, 1000), Flag("every")] = 20.0
    """Spacing of the levels, mm."""
    reference: Annotated[str | None, Flag("from")] = None
    """Landmark from which heights count, upwards; without it the distal end."""


@dataclass(frozen=True, kw_only=True)
class Subject:
    """What a record is of."""

    shape: ShapeSource
    against: ShapeSource | None = None
    """Another shape to compare it with."""
    recipe: RecipeSource | None = None
    """That made the shape of the other one."""
    case: CaseSource | None = None
    """Of the scan: how sure its scale and surface are."""


@dataclass(frozen=True, kw_only=True)
class Reported:
    """A record and its files."""

    record: Record
    written: tuple[Path, ...]


def report(subject: Subject, ask: ReportRequest, folder: Path) -> Reported:
    """Write the record of a shape.

    Raises:
        OptionsError: a way to lay a shape on this one, and there is none; or a recipe of neither.
        MeasureError: the shape is not aligned.
        ExportError: the folder cannot be made.
    """
    if ask.align is not None and subject.against is None:
        raise OptionsError("options.report.align_alone")
    require_folder(folder)
    options = RecordOptions(spacing_mm=ask.every_mm, reference=ask.reference, way=ask.align)
    record = record_of(subject.shape, subject.against, subject.recipe, subject.case, options)
    return Reported(record=record, written=_written(record, folder))


def _written(record: Record, folder: Path) -> tuple[Path, ...]:
    """JSON first: page and PDF are made of its tree."""
    make_folder(folder)
    laid = record_report(record.content, record.pictures)
    tree = json.dumps(record.tree, indent=1, ensure_ascii=False, allow_nan=False)
    return (
        write_bytes(folder / "report.json", f"{tree}\n".encode()),
        write_bytes(folder / "report.html", html_of(laid).encode("utf-8")),
        write_bytes(folder / "report.pdf", pdf_of(laid)),
    )
