"""`limbgram print`: a board on paper in true size, and the board file beside it."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from limbgram.cli.captures import DEFAULT_BOARD, parse_board
from limbgram.cli.replies import Reply, answered
from limbgram.core.errors import OptionsError
from limbgram.core.files import write_bytes
from limbgram.formats.board_file import PrintedSize, Reading, require_board_place, write_board
from limbgram.formats.board_sheet import BoardSheet, draw_board_sheet
from limbgram.reconstruction.targets.board import Board

_LENS_BOARD = "checkerboard:14x10:10"


class Kind(StrEnum):
    """What is printed."""

    SCALE = "scale-board"
    LENS = "checkerboard"


class Page(StrEnum):
    """On what."""

    A4 = "a4"
    LETTER = "letter"
    A3 = "a3"
    TABLOID = "tabloid"


@answered
def print_command(
    kind: Annotated[
        Kind,
        typer.Argument(
            help="scale-board lies beside the limb and sets the scale; checkerboard calibrates "
            "the camera."
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--out",
            help="PDF to write; NAME.json is written beside it.",
            show_default="KIND.pdf",
        ),
    ] = None,
    page: Annotated[Page, typer.Option(help="Paper.")] = Page.A4,
    board: Annotated[
        str | None,
        typer.Option(
            help="Another pattern: charuco:SQUARES:SQUARE_MM:MARKER_MM:DICTIONARY or "
            "checkerboard:INNER_CORNERS:SQUARE_MM.",
            show_default=f"{DEFAULT_BOARD} or {_LENS_BOARD}",
        ),
    ] = None,
    measured_mm: Annotated[
        float | None,
        typer.Option(
            "--measured-mm",
            help="What a steel rule says of the printed ruler across the page, to a tenth of a mm.",
        ),
    ] = None,
    measured_down_mm: Annotated[
        float | None,
        typer.Option("--measured-down-mm", help="The same of the ruler down the page."),
    ] = None,
    as_json: Annotated[  # noqa: ARG001
        bool, typer.Option("--json", help="Reply as JSON.")
    ] = False,
) -> Reply:
    """Make a board to print in true size, and the board file that knows its measured size.

    Print it at 100 %, measure its ruler, and run the command again with --measured-mm. Then give
    the board file to `reconstruct --board` or `calibrate --board`: every length follows the print.
    """
    out = out or Path(f"{kind.value}.pdf")
    if out.suffix.lower() != ".pdf":
        raise OptionsError(f"{out.name} is no name for a sheet. Let it end in .pdf.")
    sheet = draw_board_sheet(_pattern(kind, board), page.value)
    printed = _printed(sheet, measured_mm, measured_down_mm)
    file = out.with_suffix(".json")
    require_board_place(file, printed)
    out.parent.mkdir(parents=True, exist_ok=True)
    write_bytes(out, sheet.pdf)
    write_board(file, sheet.board, printed)
    return Reply(
        (f"{sheet.board}, on {page.value}: {out}", *_next(sheet, printed, file)),
        {
            "sheet": str(out),
            "board_file": str(file),
            "board": str(sheet.board),
            "ruler_mm": sheet.ruler_mm,
            "ruler_down_mm": sheet.ruler_down_mm,
            "growth": None if printed is None else printed.growth,
        },
    )


def _pattern(kind: Kind, text: str | None) -> Board:
    board = parse_board(text or (DEFAULT_BOARD if kind is Kind.SCALE else _LENS_BOARD))
    if kind is Kind.LENS and board.kind != "checkerboard":
        raise OptionsError("--board names a ChArUco board: print it as a scale-board.")
    return board


def _printed(
    sheet: BoardSheet, across_mm: float | None, down_mm: float | None
) -> PrintedSize | None:
    if across_mm is None:
        if down_mm is not None:
            raise OptionsError("Give --measured-mm, the ruler across the page, too.")
        return None
    return PrintedSize(
        across=Reading(drawn_mm=sheet.ruler_mm, measured_mm=across_mm),
        down=None
        if down_mm is None
        else Reading(drawn_mm=sheet.ruler_down_mm, measured_mm=down_mm),
    )


def _next(sheet: BoardSheet, printed: PrintedSize | None, file: Path) -> tuple[str, ...]:
    if printed is None:
        return (
            "Print it at 100 % (actual size) and fix it flat. Then measure the ruler across the "
            f"page, {sheet.ruler_mm:g} mm, with a steel rule, and run this again with "
            "--measured-mm.",
            f"Until then {file} holds the size as drawn.",
        )
    return (
        f"The print has {printed.growth:.4f} of its drawn size: squares of "
        f"{sheet.board.square_mm * printed.growth:.3f} mm.",
        f"Give it as --board {file}.",
    )
