"""Table: the outcome of every capture of a batch, as HTML, CSV and JSON.

Out     CASES/batch.json (limbgram-batch/1), CASES/batch.xlsx, CASES/batch.csv, CASES/batch.html
"""

import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from limbgram.batch.attempt import Outcome, worst_of
from limbgram.cases.case_record import write_json
from limbgram.cases.folder import CaseFolder
from limbgram.core.errors import CaseError
from limbgram.core.files import json_of, read_content, write_bytes
from limbgram.core.spreadsheet import Cell, Table, csv_of, xlsx_of
from limbgram.core.typed import TOLERANT, tree_of, value_of
from limbgram.findings import told
from limbgram.report.batch import BatchRow, batch_report, count_by_verdict
from limbgram.report.drawings.drawing import Picture
from limbgram.report.html import html_of

_SCHEMA = "limbgram-batch/1"
_THUMB_PX = 420
_STATES = {
    "finished": "computed",
    "unchanged": "as it was",
    "refused": "refused",
    "died": "died in every attempt",
    "failed": "fault of the program",
    "cancelled": "stopped",
}
_LARGEST_BYTES = 256_000_000
NAMES = ("batch.json", "batch.xlsx", "batch.csv", "batch.html")


@dataclass(frozen=True)
class BatchTable:
    """The outcomes of a batch as JSON, and the files they were written to."""

    content: dict[str, Any]
    line: str
    """Counts by verdict, in one line."""
    exit_code: int
    written: tuple[Path | str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class _Kept:
    """What is read of an earlier table."""

    schema: str
    captures: tuple[Outcome, ...]


def write_table(
    outcomes: Sequence[Outcome], cases: Path, notes: Sequence[str], *, stopped: bool
) -> BatchTable:
    """Write the four files, each whole or not at all."""
    cases.mkdir(parents=True, exist_ok=True)
    table = table_of(outcomes, cases, notes, stopped=stopped)
    rows = [_row(one, cases, pictured=True) for one in outcomes]
    places = tuple(cases / name for name in NAMES)
    write_json(places[0], table.content)
    sheet = _sheet(outcomes)
    write_bytes(places[1], xlsx_of([sheet]))
    write_bytes(places[2], csv_of(sheet).encode())
    write_bytes(places[3], html_of(batch_report(rows, notes, stopped=stopped)).encode())
    return replace(table, written=places)


def table_of(
    outcomes: Sequence[Outcome], cases: Path, notes: Sequence[str], *, stopped: bool
) -> BatchTable:
    """The table without its files."""
    code = worst_of([one.exit_code for one in outcomes])
    content = {
        "schema": _SCHEMA,
        "exit_code": code,
        "stopped": stopped,
        "notes": list(notes),
        "captures": [_tree(one) for one in outcomes],
    }
    return BatchTable(content, count_by_verdict([_row(one, cases) for one in outcomes]), code)


def earlier_outcomes(cases: Path) -> dict[str, Outcome]:
    """Outcomes of the last table, by capture; none where there is none that can be read."""
    place = cases / NAMES[0]
    try:
        tree = json_of(read_content(place, _LARGEST_BYTES, CaseError))
        kept = value_of(tree, _Kept, "", TOLERANT)
    except (CaseError, ValueError):
        return {}
    return {one.name: one for one in kept.captures} if kept.schema == _SCHEMA else {}


def _tree(outcome: Outcome) -> dict[str, Any]:
    """An outcome as JSON, with English sentences beside the findings, for other programs."""
    with_sentences = replace(
        outcome,
        message=outcome.reason,
        steps=tuple(replace(step, message=step.reason) for step in outcome.steps),
    )
    return tree_of(with_sentences) | {"case": outcome.name}


def _row(outcome: Outcome, cases: Path, *, pictured: bool = False) -> BatchRow:
    return BatchRow(
        name=outcome.name,
        source=outcome.source,
        state=_STATES[outcome.state],
        light=outcome.light,
        size_checked=bool(outcome.size_checked),
        told=outcome.headline if outcome.done else outcome.reason,
        steps=tuple(step.name for step in outcome.steps if not step.exit_code),
        faults=tuple(_faults(outcome)),
        left_out=tuple((part.name, told(part.reason)) for part in outcome.set_aside),
        attempts=outcome.attempts,
        seconds=outcome.seconds,
        thumbnail=_thumbnail(cases / outcome.name, outcome.name)
        if pictured and outcome.done
        else None,
    )


def _thumbnail(case: Path, name: str) -> Picture | None:
    """The picture of the surface, reduced: the page may show hundreds."""
    drawn = CaseFolder(case).surface_picture
    if not drawn.is_file():
        return None
    file = io.BytesIO()
    with Image.open(drawn) as picture:
        picture.thumbnail((_THUMB_PX, _THUMB_PX))
        picture.convert("P", palette=Image.Palette.ADAPTIVE).save(file, "PNG", optimize=True)
    return Picture(
        name="surface", title=f"Surface of {name}", caption="",
        png=np.frombuffer(file.getvalue(), np.uint8),
    )  # fmt: skip


_HEADS = (
    "capture", "source", "state", "verdict", "size_checked", "exit_code", "attempts", "seconds",
    "steps_done", "steps_failed", "headline", "message", "left_out",
)  # fmt: skip


def _sheet(outcomes: Sequence[Outcome]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for one in outcomes:
        done = [step.name for step in one.steps if not step.exit_code]
        failed = [step.name for step in one.steps if step.exit_code]
        left_out = "; ".join(f"{part.name}: {told(part.reason)}" for part in one.set_aside)
        rows.append((
            one.name, one.source, one.state, one.light or "", one.size_checked, one.exit_code,
            one.attempts, one.seconds, " ".join(done), " ".join(failed), one.headline,
            " ".join((one.reason, *_faults(one))).strip(), left_out,
        ))  # fmt: skip
    return Table(title="captures", columns=_HEADS, rows=tuple(rows))


def _faults(outcome: Outcome) -> list[str]:
    return [f"{step.name}: {step.reason}" for step in outcome.steps if step.exit_code]
