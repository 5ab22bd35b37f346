"""`limbgram export`: a shape for printers, CAD programs and carvers."""

from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from limbgram.carving import MapOptions
from limbgram.cli.replies import Reply, answered
from limbgram.cli.workbench.align import SideName
from limbgram.cli.workbench.exporting import (
    Asked,
    aop_reply,
    drawn,
    dxf_reply,
    gcode_reply,
    given,
    machine_of,
    mesh_reply,
)
from limbgram.cli.workbench.stating import (
    ShapeArgument,
    UnitOption,
    require_apart,
    require_no_shape,
    require_output,
    shape_of,
)
from limbgram.errors import OptionsError
from limbgram.export.workshop import AopOptions, Own, admit, sure_in_limb_frame
from limbgram.export.workshop.gcode import require_place
from limbgram.shape.reading import ShapeFile


class FormatName(StrEnum):
    """Kinds of file that are written."""

    STL = "stl"
    DXF = "dxf"
    AOP = "aop"
    GCODE = "gcode"
    PLY = "ply"
    OBJ = "obj"
    GLB = "glb"


class ProfileName(StrEnum):
    """Whose AOP files to write."""

    MM = "mm"
    OMEGA = "omega"
    AMPSCAN = "ampscan"


class AxisName(StrEnum):
    """Round which axis radii are taken."""

    LIMB = "limb"
    FIT = "fit"


class LineEndName(StrEnum):
    """How lines end."""

    LF = "lf"
    CR = "cr"
    CRLF = "crlf"


class PatternName(StrEnum):
    """How the finishing pass goes round."""

    HELIX = "helix"
    RINGS = "rings"


class PresetName(StrEnum):
    """How much time carving may take."""

    FINE = "fine"
    FAST = "fast"


class DialectName(StrEnum):
    """Whose G-code."""

    LINUXCNC = "linuxcnc"
    MACH = "mach"
    FANUC = "fanuc"
    GRBL = "grbl"


class WindingName(StrEnum):
    """How the rotary axis counts its turns."""

    UNWIND = "unwind"
    RESET = "reset"
    ROLLOVER = "rollover"
    CONTINUOUS = "continuous"


class FeedModeName(StrEnum):
    """How moves carry their feed."""

    INVERSE_TIME = "inverse-time"
    PER_MINUTE = "per-minute"


class CoolantName(StrEnum):
    """What cools, or blows the dust away."""

    NONE = "none"
    MIST = "mist"
    FLOOD = "flood"


class RotaryName(StrEnum):
    """Letter of the axis that turns about X."""

    A = "A"
    B = "B"
    C = "C"
    Y = "Y"


class TurnName(StrEnum):
    """What turns counter-clockwise when A grows."""

    TOOL = "tool"
    WORK = "work"


_TYPED = {
    "spokes_listed": "list-spokes",
    "slices_listed": "even-slices",
    "line_end": "line-end",
    "from_mm": "from-mm",
    "to_mm": "to-mm",
    "distal_slices": "distal-slices",
    "tool_diameter_mm": "tool",
    "tool_reach_mm": "reach",
    "blank_diameter_mm": "blank",
    "blank_length_mm": "blank-length",
    "spigot_mm": "spigot",
    "mandrel_diameter_mm": "mandrel",
    "rough_depth_mm": "rough-depth",
    "plunge_mm_min": "plunge",
    "turn_deg_min": "turn-rate",
    "spindle_rpm": "spindle",
    "a_limit_deg": "a-limit",
    "rotary_word": "rotary-word",
    "tool_number": "tool-number",
    "spindle_start_s": "spindle-start",
    "write_machine": "write-machine",
    "program_number": "program-number",
    "scallop_mm": "scallop",
    "feed_mm_min": "feed",
    "feed": "feed-mode",
    "a_turns": "a-turns",
}
"""Options as they are typed, where the library calls them otherwise."""
_OF_GRID = {"spokes", "from_mm", "distal_slices", "axis"}
"""Options for AOP that ask for other radii than an AOP's own."""


@answered
def export_command(
    shape: ShapeArgument,
    to: Annotated[FormatName, typer.Option(help="Kind of file.")],
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
        SideName | None,
        typer.Option(help="Side of the patient, confirmed; aop and gcode demand it."),
    ] = None,
    unit: UnitOption = None,
    spacing: Annotated[
        float | None, typer.Option(help="aop: between slices; dxf: between sections; mm.")
    ] = None,
    from_mm: Annotated[
        float | None,
        typer.Option(help="aop: height of the first slice in the limb; not with --axis fit."),
    ] = None,
    to_mm: Annotated[
        float | None,
        typer.Option(help="aop, gcode: height of the last; not with --axis fit."),
    ] = None,
    spokes: Annotated[
        int | None,
        typer.Option(
            help="aop: radii round a slice.",
            show_default="an AOP's own spokes and slices, else 120",
        ),
    ] = None,
    distal_slices: Annotated[
        int | None, typer.Option(help="aop: more slices at the rounded tip.")
    ] = None,
    profile: Annotated[ProfileName | None, typer.Option(help="aop: whose habits.")] = None,
    axis: Annotated[
        AxisName | None,
        typer.Option(
            help="aop: the limb's own axis, or one fitted so that radii are single; this from end "
            "to end, without --from-mm and --to-mm.",
            show_default="limb",
        ),
    ] = None,
    line_end: Annotated[LineEndName | None, typer.Option(help="aop: end of lines.")] = None,
    list_spokes: Annotated[
        bool, typer.Option("--list-spokes", help="aop: every angle one by one.")
    ] = False,
    even_slices: Annotated[
        bool, typer.Option("--even-slices", help="aop: the spacing in place of every height.")
    ] = False,
    polyface: Annotated[
        bool, typer.Option("--polyface", help="dxf: joined meshes, not single faces.")
    ] = False,
    tool: Annotated[float | None, typer.Option(help="gcode: diameter of the ball end, mm.")] = None,
    reach: Annotated[float | None, typer.Option(help="gcode: tool's tip to holder, mm.")] = None,
    blank: Annotated[float | None, typer.Option(help="gcode: diameter of the blank, mm.")] = None,
    blank_length: Annotated[float | None, typer.Option(help="gcode: length of it, mm.")] = None,
    spigot: Annotated[
        float | None, typer.Option(help="gcode: radius left for a tailstock, mm.")
    ] = None,
    scallop: Annotated[float | None, typer.Option(help="gcode: height of ridges, mm.")] = None,
    feed: Annotated[float | None, typer.Option(help="gcode: mm/min over the surface.")] = None,
    pattern: Annotated[PatternName | None, typer.Option(help="gcode: way of finishing.")] = None,
    a_turns: Annotated[
        TurnName | None,
        typer.Option(help="gcode: what turns counter-clockwise, seen from proximal, as A grows."),
    ] = None,
    preset: Annotated[
        PresetName | None,
        typer.Option(help="gcode: fine, or fast: a 19 mm tool and ridges of 0.15 mm."),
    ] = None,
    mandrel: Annotated[
        float | None, typer.Option(help="gcode: diameter of a bar through the blank, mm.")
    ] = None,
    rough_depth: Annotated[
        float | None, typer.Option(help="gcode: depth of a roughing layer, mm.")
    ] = None,
    plunge: Annotated[float | None, typer.Option(help="gcode: mm/min into the blank.")] = None,
    turn_rate: Annotated[
        float | None, typer.Option(help="gcode: fastest turning, degrees/min.")
    ] = None,
    spindle: Annotated[int | None, typer.Option(help="gcode: rpm; 0 leaves it to you.")] = None,
    spindle_start: Annotated[
        float | None, typer.Option(help="gcode: seconds to wait for the spindle.")
    ] = None,
    coolant: Annotated[CoolantName | None, typer.Option(help="gcode: M7, M8 or none.")] = None,
    tool_number: Annotated[
        int | None, typer.Option(help="gcode: called by T, M6 and G43; 0 for no call.")
    ] = None,
    dialect: Annotated[DialectName | None, typer.Option(help="gcode: the control.")] = None,
    program_number: Annotated[int | None, typer.Option(help="gcode: O number for fanuc.")] = None,
    winding: Annotated[
        WindingName | None,
        typer.Option(
            help="gcode: unwind turns back in time; reset takes turns off by G92; rollover writes "
            "places within one turn, as the control must be set; continuous winds on."
        ),
    ] = None,
    a_limit: Annotated[
        float | None, typer.Option(help="gcode: degrees that A may count to either side.")
    ] = None,
    feed_mode: Annotated[
        FeedModeName | None,
        typer.Option(help="gcode: G93, or per minute.", show_default="as the dialect does"),
    ] = None,
    rotary_word: Annotated[
        RotaryName | None, typer.Option(help="gcode: letter of the axis that turns about X.")
    ] = None,
    machine: Annotated[
        Path | None, typer.Option(help="gcode: machine file; what is typed goes over it.")
    ] = None,
    write_machine: Annotated[
        Path | None, typer.Option(help="gcode: keep all this as a machine file (.toml).")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,  # noqa: ARG001
) -> Reply:
    """Write a shape for other programs and machines, in millimetres, and read the file back.

    An aligned shape is written in its limb frame: +Z proximal, +Y anterior, +X the patient's
    right. For a carver (aop, gcode) the shape must be aligned and its side confirmed; a picture
    beside the file shows what it holds, to be compared with the patient.
    """
    for_aop = given(
        spokes=spokes,
        profile=None if profile is None else profile.value,
        axis=None if axis is None else axis.value,
        line_end=None if line_end is None else line_end.value,
        from_mm=from_mm,
        distal_slices=distal_slices,
        spokes_listed=list_spokes or None,
        slices_listed=False if even_slices else None,
    )
    for_gcode = given(
        tool_diameter_mm=tool,
        tool_reach_mm=reach,
        blank_diameter_mm=blank,
        blank_length_mm=blank_length,
        spigot_mm=spigot,
        mandrel_diameter_mm=mandrel,
        scallop_mm=scallop,
        rough_depth_mm=rough_depth,
        feed_mm_min=feed,
        plunge_mm_min=plunge,
        turn_deg_min=turn_rate,
        spindle_rpm=spindle,
        pattern=None if pattern is None else pattern.value,
        a_turns=None if a_turns is None else a_turns.value,
    )
    for_control = given(
        dialect=None if dialect is None else dialect.value,
        winding=None if winding is None else winding.value,
        feed=None if feed_mode is None else feed_mode.value,
        a_limit_deg=a_limit,
        rotary_word=None if rotary_word is None else rotary_word.value,
        tool_number=tool_number,
        spindle_start_s=spindle_start,
        coolant=None if coolant is None else coolant.value,
        program_number=program_number,
    )
    kept = given(preset=preset, machine=machine, write_machine=write_machine)
    _refuse_others(to, "aop", for_aop)
    _refuse_others(to, "gcode", {**for_gcode, **for_control, **kept})
    _refuse_others(to, "dxf", given(polyface=polyface or None))
    _refuse_others(to, "aop gcode", given(to_mm=to_mm))
    _refuse_others(to, "aop dxf", given(spacing=spacing))
    path = out or _free_default(shape, to)
    if path.suffix.lower() != f".{to.value}" and to is not FormatName.GCODE:
        raise OptionsError(f"{path.name} does not end in .{to.value}: programs go by the ending.")
    require_apart(path, shape)
    if to is FormatName.GCODE:
        require_no_shape(path, "a program for a carver")
    read = shape_of(shape, unit)
    limb = read.limb
    confirmed = None if side is None else side.value
    match to:
        case FormatName.AOP:
            sampled_anew = _OF_GRID & set(for_aop) or (spacing, to_mm) != (None, None)
            own = None if sampled_anew else _own_grid(read)
            options = replace(_aop(for_aop, spacing, to_mm), own=own)
            reply = aop_reply(admit(limb, confirmed), path, options)
        case FormatName.GCODE:
            asked = Asked(for_gcode, for_control, machine, fast=preset is PresetName.FAST)
            set_up = machine_of(asked)
            if write_machine is not None:
                require_output(write_machine, ".toml", "a machine file")
                require_place(write_machine)
            for other in (machine, write_machine):
                if other is not None and other.resolve() == path.resolve():
                    raise OptionsError(
                        f"{path.name} is named for the program and for the machine file. Choose "
                        "another name for one."
                    )
            reply = gcode_reply(
                admit(limb, confirmed), path, set_up, to_mm=to_mm, keep=write_machine
            )
        case FormatName.DXF:
            reply = dxf_reply(sure_in_limb_frame(limb), path, spacing or 10.0, polyface=polyface)
        case _:
            reply = mesh_reply(sure_in_limb_frame(limb), path)
    return drawn(reply, limb)


def _free_default(shape: Path, to: FormatName) -> Path:
    """Beside the shape under its name; kinds of shape under one that says that they are exports,
    so that nobody takes them for the scan.

    A file that lies there may be a scan or a case's own: nobody has said that it may go.
    """
    with_limb_file = to in (FormatName.STL, FormatName.PLY, FormatName.OBJ, FormatName.GLB)
    own = f"-export-{to.value}" if with_limb_file else ""
    path = shape.with_name(f"{shape.stem}{own}.{to.value}")
    if path.exists():
        raise OptionsError(
            f"{path} is there already, and may be another program's or a scan. Choose a name with "
            "-o; the same name writes over it."
        )
    return path


def _own_grid(read: ShapeFile) -> Own | None:
    """Spokes, slices and axis of an AOP, as long as its axes are the limb's still."""
    frame, declared = read.limb.frame, read.declared
    if read.grid is None or frame is None or declared is None:
        return None
    own, now = declared.limb_from_mesh, frame.limb_from_mesh
    same = np.array_equal(own.rotation, now.rotation) and np.array_equal(
        own.translation, now.translation
    )
    return Own(grid=read.grid, limb_from_file=own) if same else None


def _aop(values: dict[str, Any], spacing: float | None, to_mm: float | None) -> AopOptions:
    ours = {"spokes", "from_mm", "distal_slices"}
    of_map = {name: value for name, value in values.items() if name in ours}
    of_map |= given(spacing_mm=spacing, to_mm=to_mm)
    others = {name: value for name, value in values.items() if name not in ours}
    return replace(AopOptions(), map=replace(MapOptions(), **of_map), **others)


def _refuse_others(to: FormatName, formats: str, values: dict[str, Any]) -> None:
    """An option that the format does not know must not be passed over."""
    if values and to.value not in formats.split():
        names = ", ".join(f"--{_TYPED.get(name, name)}" for name in values)
        wanted = " or ".join(formats.split())
        raise OptionsError(f"{names}: for {wanted} only, and you write {to.value}. Leave it out.")
