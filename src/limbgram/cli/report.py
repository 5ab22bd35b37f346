"""`limbgram report`: a shape's page and PDF for the record."""

from pathlib import Path
from typing import Annotated

import typer

from limbgram.cases.folder import CaseFolder
from limbgram.cli.replies import Reply, advised, answered, spoken
from limbgram.cli.request_options import asking
from limbgram.cli.shape_options import AlignedShape, UnitOfAll, shape_of
from limbgram.core.errors import OptionsError
from limbgram.findings import Finding
from limbgram.formats.sidecar import hash_of, limb_file_beside
from limbgram.report.record.content import Content
from limbgram.report.record.sources import CaseSource, RecipeSource, ShapeSource
from limbgram.services.report import ReportRequest, Subject, report
from limbgram.workbench.recipe.file import read_recipe

_SHOWN = 4


@answered
@asking
def report_command(
    shape: AlignedShape,
    ask: ReportRequest,
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
    unit: UnitOfAll = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,  # noqa: ARG001
) -> Reply:
    """Write the record of a shape: one page, a PDF of two sheets, and JSON.

    Four sides, measures, landmarks, what differs from another shape, what each edit did, how much
    each step may be off, and what to check before anything is made. No name is printed: files are
    told by their hashes, landmarks with names of their own by numbers.
    """
    folder = out or shape.with_name(f"{shape.stem}-report")
    if CaseFolder(folder).record.exists():
        raise OptionsError("options.report.in_case", folder=str(folder))
    subject = Subject(
        shape=_shape(shape, unit),
        against=None if against is None else _shape(against, unit),
        recipe=None if recipe is None else _recipe(recipe),
        case=None if case is None else _case(case),
    )
    done = report(subject, ask, folder)
    return Reply(
        (*_lines(done.record.content), *(f"Written: {path}" for path in done.written)),
        {**done.record.tree, "written": [str(path) for path in done.written]},
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
    from limbgram.cases.case_assessment import (
        cited,  # with the stages, a second for records of cases
    )

    return cited(CaseFolder(path))


def _lines(content: Content) -> tuple[str, ...]:
    """Side and what to check, for people at a terminal."""
    side, found = content.side, content.findings
    compared = [] if content.comparison is None else [content.comparison]
    more = [f"  and {len(found) - _SHOWN} more on the page"] if len(found) > _SHOWN else []
    return (
        f"{content.id}: {'no side' if side == 'none' else side + ' side'}, millimetres",
        *(spoken(Finding.from_tree(one["verdict"])) for one in compared),
        "Before anything is made from it:",
        *map(advised, found[:_SHOWN]),
        *more,
    )
