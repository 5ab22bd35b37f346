"""`limbgram print`: sheets in true size, and files that know their measured size."""

from pathlib import Path
from typing import Annotated, Any

import typer

from limbgram.cli.replies import Reply, answered
from limbgram.cli.request_options import asking
from limbgram.formats.printed_size import PrintedSize
from limbgram.formats.sheets.kinds import KINDS, KindName
from limbgram.services.print_sheets import PrintRequest, WrittenSheet, print_sheets


@answered
@asking
def print_command(
    kind: Annotated[
        KindName,
        typer.Argument(
            help="; ".join(f"{one.name.value} {one.use}" for one in KINDS)
            + "; kit is all of them.",
        ),
    ],
    ask: PrintRequest,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--out",
            help="PDF to write; NAME.json is written beside it. For the kit a folder.",
            show_default="KIND.pdf, or kit",
        ),
    ] = None,
    as_json: Annotated[  # noqa: ARG001
        bool, typer.Option("--json", help="Reply as JSON.")
    ] = False,
) -> Reply:
    """Make sheets to print at true size, and files that keep their measured sizes.

    Print at 100 %, measure the ruler, and run the command again with --measured-mm. Then give the
    file of a board to `reconstruct --board` or `calibrate --board`, and the file of bars, mat or
    ring to `reconstruct --marks`: every length follows the print.
    """
    printed = print_sheets(kind, ask, out)
    contents = [_content(one, printed.size) for one in printed.sheets]
    lines = [f"{one.sheet.title}, on {ask.page}: {one.path}" for one in printed.sheets]
    lines += _next(printed.sheets[0], printed.size)
    return Reply(tuple(lines), contents[0] if len(contents) == 1 else {"sheets": contents})


def _content(one: WrittenSheet, size: PrintedSize | None) -> dict[str, Any]:
    sheet = one.sheet
    content: dict[str, Any] = {
        "kind": one.kind.value,
        "sheet": str(one.path),
        "title": sheet.title,
        "ruler_mm": sheet.ruler_mm,
        "ruler_down_mm": sheet.ruler_down_mm,
        "growth": None if size is None else size.growth,
    }
    if sheet.board is not None:
        return content | {"board_file": str(one.file), "board": str(sheet.board)}
    return content | {"marks_file": str(one.file), "plates": len(sheet.plates)}


def _next(one: WrittenSheet, size: PrintedSize | None) -> tuple[str, ...]:
    """What to do with the print."""
    sheet = one.sheet
    if size is None:
        return (
            "Print it at 100 % (actual size) and fix it flat. Then measure the ruler across the "
            f"page, {sheet.ruler_mm:g} mm, with a steel rule, and run this again with "
            "--measured-mm.",
            f"Until then {one.file} holds the size as drawn.",
        )
    told = f"The print has {size.growth:.4f} of its drawn size"
    if sheet.board is not None:
        return (
            f"{told}: squares of {sheet.board.square_mm * size.growth:.3f} mm.",
            f"Give it as --board {one.file}.",
        )
    if not sheet.plates:
        return (f"{told}.",)
    return (f"{told}; {one.file} says so.",)
