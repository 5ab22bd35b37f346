"""`limbgram print`: sheets in true size, and files that know their measured size."""

from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from limbgram.cli.captures import DEFAULT_BOARD, parse_board
from limbgram.cli.replies import Reply, answered
from limbgram.core.errors import OptionsError
from limbgram.core.files import write_bytes
from limbgram.formats.board_file import require_board_place, write_board
from limbgram.formats.camera import read_camera
from limbgram.formats.marks_file import PrintedKind, require_marks_place, write_marks
from limbgram.formats.printed import PrintedSize, Reading
from limbgram.formats.sheets.kinds import KINDS, LENS_BOARD, KindName, SheetKind, SheetOptions
from limbgram.formats.sheets.page import Sheet


class Page(StrEnum):
    """On what."""

    A4 = "a4"
    LETTER = "letter"
    A3 = "a3"
    TABLOID = "tabloid"
    A2 = "a2"
    A1 = "a1"
    A0 = "a0"


_FILM_MM = 36.0
"""Width of the film that focal lengths in 35 mm terms belong to."""


@answered
def print_command(
    kind: Annotated[
        KindName,
        typer.Argument(
            help="; ".join(f"{one.name.value} {one.use}" for one in KINDS)
            + "; kit is all of them.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--out",
            help="PDF to write; NAME.json is written beside it. For the kit a folder.",
            show_default="KIND.pdf, or kit",
        ),
    ] = None,
    page: Annotated[Page, typer.Option(help="Paper.")] = Page.A4,
    board: Annotated[
        str | None,
        typer.Option(
            help="Another board: charuco:SQUARES:SQUARE_MM:MARKER_MM:DICTIONARY or "
            "checkerboard:INNER_CORNERS:SQUARE_MM.",
            show_default=f"{DEFAULT_BOARD} or checkerboard:{LENS_BOARD.columns}x{LENS_BOARD.rows}:"
            f"{LENS_BOARD.square_mm:g}",
        ),
    ] = None,
    sticker_mm: Annotated[
        float, typer.Option(help="Side of a sticker's mark.")
    ] = SheetOptions().sticker_mm,
    first: Annotated[int, typer.Option(help="Number of the first sticker.")] = 0,
    pixel_mm: Annotated[
        float | None,
        typer.Option(
            help="For the sock: what one pixel shows of the limb.",
            show_default=f"{SheetOptions().pixel_mm:g}",
        ),
    ] = None,
    distance_mm: Annotated[
        float | None,
        typer.Option(
            help="For the sock, instead: distance of the camera, with --camera, or with "
            "--focal-35mm and --width-px."
        ),
    ] = None,
    camera: Annotated[
        Path | None, typer.Option(help="Camera file that --distance-mm goes with.")
    ] = None,
    focal_35mm: Annotated[
        float | None, typer.Option("--focal-35mm", help="Focal length in 35 mm terms.")
    ] = None,
    width_px: Annotated[
        int | None, typer.Option(help="Pixels along the longer side of a photo.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Another seed, another sock pattern.")] = 0,
    measured_mm: Annotated[
        float | None,
        typer.Option(
            "--measured-mm",
            help="What a steel rule says of the printed ruler across the page, to a tenth of a mm. "
            "For the kit, of the scale board's: the printer makes all sheets alike.",
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
    """Make sheets to print in true size, and files that know their measured size.

    Print at 100 %, measure the ruler, and run the command again with --measured-mm. Then give the
    file of a board to `reconstruct --board` or `calibrate --board`, and the file of bars, mat or
    ring to `reconstruct --marks`: every length follows the print.
    """
    options = SheetOptions(
        board=None if board is None else parse_board(board),
        sticker_mm=sticker_mm,
        first=first,
        pixel_mm=_pixel_mm(pixel_mm, distance_mm, camera, focal_35mm, width_px),
        distance_mm=distance_mm,
        seed=seed,
    )
    chosen = [one for one in KINDS if kind in (one.name, KindName.KIT)]
    if len(chosen) == 1:
        out = out or Path(f"{kind.value}.pdf")
        if out.suffix.lower() != ".pdf":
            raise OptionsError("options.print.no_name", name=out.name)
        places = [out]
    else:
        folder = out or Path(KindName.KIT.value)
        if folder.suffix:
            raise OptionsError("options.print.kit_into_folder", name=folder.name)
        if options.board is not None:
            raise OptionsError("options.print.kit_has_boards")
        places = [folder / f"{one.name.value}.pdf" for one in chosen]
    sheets = [one.draw(page.value, options) for one in chosen]
    printed = _printed(sheets[0], measured_mm, measured_down_mm)
    files = [place.with_suffix(".json") for place in places]
    for sheet, file in zip(sheets, files, strict=True):
        (require_marks_place if sheet.board is None else require_board_place)(file, printed)
    contents = [
        _keep(one, sheet, place, printed)
        for one, sheet, place in zip(chosen, sheets, places, strict=True)
    ]
    lines = [f"{sheet.title}, on {page.value}: {place}" for sheet, place in zip(sheets, places)]
    lines += _next(sheets[0], printed, files[0])
    return Reply(tuple(lines), contents[0] if len(contents) == 1 else {"sheets": contents})


def _pixel_mm(
    pixel_mm: float | None,
    distance_mm: float | None,
    camera: Path | None,
    focal_35mm: float | None,
    width_px: int | None,
) -> float:
    """What one pixel shows, told or from distance and lens."""
    by_lens = (camera is not None, focal_35mm is not None and width_px is not None)
    if distance_mm is None:
        if camera is not None or focal_35mm is not None or width_px is not None:
            raise OptionsError("options.print.lens_alone")
        return SheetOptions().pixel_mm if pixel_mm is None else pixel_mm
    if pixel_mm is not None or sum(by_lens) != 1 or not distance_mm > 0:
        raise OptionsError("options.print.pixel")
    if camera is not None:
        return distance_mm / read_camera(camera).camera.fx
    return distance_mm * _FILM_MM / ((focal_35mm or 0.0) * (width_px or 0) or float("nan"))


def _printed(sheet: Sheet, across_mm: float | None, down_mm: float | None) -> PrintedSize | None:
    if across_mm is None:
        if down_mm is not None:
            raise OptionsError("options.print.measured_across")
        return None
    return PrintedSize(
        across=Reading(drawn_mm=sheet.ruler_mm, measured_mm=across_mm),
        down=None
        if down_mm is None
        else Reading(drawn_mm=sheet.ruler_down_mm, measured_mm=down_mm),
    )


def _keep(
    kind: SheetKind, sheet: Sheet, place: Path, printed: PrintedSize | None
) -> dict[str, Any]:
    """Write a sheet and the file beside it."""
    file = place.with_suffix(".json")
    place.parent.mkdir(parents=True, exist_ok=True)
    write_bytes(place, sheet.pdf)
    if sheet.board is not None:
        write_board(file, sheet.board, printed)
    else:
        kept = PrintedKind(
            kind=kind.name.value, title=sheet.title, page=sheet.page, plates=sheet.plates
        )
        write_marks(file, replace(kept, printed=printed))
    content: dict[str, Any] = {
        "kind": kind.name.value,
        "sheet": str(place),
        "title": sheet.title,
        "ruler_mm": sheet.ruler_mm,
        "ruler_down_mm": sheet.ruler_down_mm,
        "growth": None if printed is None else printed.growth,
    }
    if sheet.board is not None:
        return content | {"board_file": str(file), "board": str(sheet.board)}
    return content | {"marks_file": str(file), "plates": len(sheet.plates)}


def _next(sheet: Sheet, printed: PrintedSize | None, file: Path) -> tuple[str, ...]:
    if printed is None:
        return (
            "Print it at 100 % (actual size) and fix it flat. Then measure the ruler across the "
            f"page, {sheet.ruler_mm:g} mm, with a steel rule, and run this again with "
            "--measured-mm.",
            f"Until then {file} holds the size as drawn.",
        )
    told = f"The print has {printed.growth:.4f} of its drawn size"
    if sheet.board is not None:
        return (
            f"{told}: squares of {sheet.board.square_mm * printed.growth:.3f} mm.",
            f"Give it as --board {file}.",
        )
    if not sheet.plates:
        return (f"{told}.",)
    return (f"{told}; {file} says so.",)
