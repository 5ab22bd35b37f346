"""`limbgram report`: a shape's page and PDF for the record."""

import json
from pathlib import Path
from typing import Annotated

import typer

from limbgram.cases.folder import CaseFolder
from limbgram.cli.compare import WayName
from limbgram.cli.replies import Reply, answered
from limbgram.cli.shapes import AlignedShape, UnitOfAll, shape_of
from limbgram.core.errors import ExportError, OptionsError
from limbgram.core.files import write_bytes
from limbgram.findings import Finding, advice, sentence, told
from limbgram.formats.sidecar import hash_of, limb_file_beside
from limbgram.report.html import html_of
from limbgram.report.pdf import pdf_of
from limbgram.report.record.content import Content
from limbgram.report.record.layout import record_report
from limbgram.report.record.record import Record, RecordOptions, record_of
from limbgram.report.record.sources import CaseSource, RecipeSource, ShapeSource
from limbgram.workbench.recipe.file import read_recipe

_SHOWN = 4


@answered
def report_command(
    shape: AlignedShape,
    against: Annotated[
        Path | None,
        typer.Option(help="Another shape to compare it with: the scan, or an earlier one."),
    ] = None,
    recipe: Annotated[
        Path | None,
        typer.Option(help="Recipe that made the shape of the --against scan: its ledger is shown."),
    ] = None,
    case: Annotated[
        Path | None,
        typer.Option(help="Case folder of the scan: how sure its scale and surface are."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="Folder to write to.", show_default="SHAPE-report"),
    ] = None,
    way: Annotated[
        WayName | None,
        typer.Option(
            "--align",
            help="How the other shape is laid on it; never scaled.",
            show_default="as-is with a recipe for it, else auto",
        ),
    ] = None,
    every: Annotated[float, typer.Option(help="Spacing of the levels, mm.")] = 20.0,
    reference: Annotated[
        str | None,
        typer.Option(
            "--from",
            help="Landmark from which heights count, upwards.",
            show_default="the distal end",
        ),
    ] = None,
    unit: UnitOfAll = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,  # noqa: ARG001
) -> Reply:
    """Write the record of a shape: one page, a PDF of two sheets, and JSON.

    Four sides, measures, landmarks, what differs from another shape, what each edit did, how much
    each step may be off, and what to check before anything is made. No name is printed: files are
    told by their hashes, landmarks with names of their own by numbers.
    """
    if way is not None and against is None:
        raise OptionsError("options.report.align_alone")
    record = record_of(
        _shape(shape, unit),
        None if against is None else _shape(against, unit),
        None if recipe is None else _recipe(recipe),
        None if case is None else _case(case),
        RecordOptions(
            spacing_mm=every, reference=reference, way=None if way is None else way.value
        ),
    )
    written = _write(record, out or shape.with_name(f"{shape.stem}-report"))
    return Reply(
        (*_lines(record.content), *(f"Written: {path}" for path in written)),
        {**record.tree, "written": [str(path) for path in written]},
    )


def _shape(path: Path, unit: str | None) -> ShapeSource:
    read = shape_of(path, unit)
    beside = limb_file_beside(path)
    return ShapeSource(
        limb=read.limb,
        sha256=read.sha256,
        kind=path.suffix[1:].upper(),
        limb_file_sha256=hash_of(beside.read_bytes()) if beside.is_file() else None,
    )


def _recipe(path: Path) -> RecipeSource:
    return RecipeSource(recipe=read_recipe(path), sha256=hash_of(path.read_bytes()))


def _case(path: Path) -> CaseSource:
    from limbgram.cases.assessing import cited  # with the stages, a second for records of cases

    return cited(CaseFolder(path))


def _write(record: Record, folder: Path) -> list[Path]:
    """JSON first: page and PDF are made of its tree."""
    if CaseFolder(folder).record.exists():
        raise OptionsError("options.report.in_case", folder=str(folder))
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExportError(
            "options.report.no_folder", folder=str(folder), system=str(error.strerror or error)
        ) from error
    report = record_report(record.content, record.pictures)
    tree = json.dumps(record.tree, indent=1, ensure_ascii=False, allow_nan=False)
    return [
        write_bytes(folder / "report.json", f"{tree}\n".encode()),
        write_bytes(folder / "report.html", html_of(report).encode("utf-8")),
        write_bytes(folder / "report.pdf", pdf_of(report)),
    ]


def _lines(content: Content) -> tuple[str, ...]:
    """Side and what to check, for people at a terminal."""
    side, found = content.side, content.findings
    compared = [] if content.comparison is None else [content.comparison]
    more = [f"  and {len(found) - _SHOWN} more on the page"] if len(found) > _SHOWN else []
    return (
        f"{content.id}: {'no side' if side == 'none' else side + ' side'}, millimetres",
        *(told(Finding.from_tree(one["verdict"])) for one in compared),
        "Before anything is made from it:",
        *(f"  {sentence(one)}\n    -> {advice(one)}" for one in found[:_SHOWN]),
        *more,
    )
