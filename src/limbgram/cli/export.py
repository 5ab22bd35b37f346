"""`limbgram export`: a shape for printers, CAD programs and carvers, and what was written of it."""

from pathlib import Path
from typing import Annotated

import typer

from limbgram.cli.replies import Reply, answered, spoken
from limbgram.cli.request_options import Kinds, asking
from limbgram.cli.shape_options import (
    ShapeArgument,
    UnitOption,
    require_apart,
    require_no_shape,
    require_output,
    shape_of,
)
from limbgram.core.errors import OptionsError, with_full_stop
from limbgram.core.typed import tree_of
from limbgram.formats.table import FORMATS, format_of
from limbgram.services.export import EXPORTS, FOR_CARVERS, Export, Exported, Gcode, export
from limbgram.workbench.limb import Side

KINDS = tuple(EXPORTS)
"""Kinds of file that can be written."""
_KEPT = tuple(one.name for one in FORMATS if {"colours", "sigma"} <= one.keeps)


def _kind(text: str) -> str:
    if text not in KINDS:
        raise typer.BadParameter(f"{text!r} is not one of {', '.join(map(repr, KINDS))}.")
    return text


@answered
@asking
def export_command(
    shape: ShapeArgument,
    to: Annotated[
        str,
        typer.Option(
            parser=_kind,
            metavar=f"<{'|'.join(KINDS)}>",
            help=f"Kind of file; colours and sigmas are kept by {', '.join(_KEPT)}.",
        ),
    ],
    ask: Annotated[Export, Kinds(EXPORTS, by="to")],
    out: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--out",
            help="File to write, over an older one; without it none is written over.",
            show_default="SHAPE.aop or so",
        ),
    ] = None,
    side: Annotated[
        Side | None,
        typer.Option(help="Side of the patient, confirmed; aop and gcode demand it."),
    ] = None,
    unit: UnitOption = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,  # noqa: ARG001
) -> Reply:
    """Write a shape for other programs and machines, in millimetres, and read the file back.

    An aligned shape is written in its limb frame: +Z proximal, +Y anterior, +X the patient's
    right. For a carver (aop, gcode) the shape must be aligned and its side confirmed; a picture
    beside the file shows what it holds, to be compared with the patient.
    """
    path = out or _free_default(shape, to)
    if path.suffix.lower() != f".{to}" and to != "gcode":
        raise OptionsError("exported.no_ending", name=path.name, kind=to)
    require_apart(path, shape)
    if to == "gcode":
        require_no_shape(path, "program")
    if isinstance(ask, Gcode) and ask.write_machine is not None:
        require_output(ask.write_machine, ".toml", "machine")
    picture = path.with_name(f"{path.name}-mirror-check.png") if to in FOR_CARVERS else None
    return reply_of(export(shape_of(shape, unit), ask, path, side, picture))


def reply_of(exported: Exported) -> Reply:
    """The reply: notes on the shape's file, then what was written."""
    notes = exported.limb.notes
    return Reply(
        (
            *(f"Note: {with_full_stop(spoken(one))}" for one in notes),
            *(spoken(one) for one in exported.said),
        ),
        {
            "written": str(exported.path),
            "unit": exported.unit,
            **exported.figures,
            "notes": tree_of(notes),
        },
    )


def _free_default(shape: Path, to: str) -> Path:
    """The default path: the shape's name with the new ending; `-export-KIND` marks shape formats.

    An existing file is never replaced: it may be a scan, or a case's own.
    """
    path = shape.with_name(f"{shape.stem}.{to}")
    kind = format_of(path)
    if kind is not None and kind.holds_limbs:
        path = shape.with_name(f"{shape.stem}-export-{to}.{to}")
    if path.exists():
        raise OptionsError("exported.taken", path=str(path))
    return path
