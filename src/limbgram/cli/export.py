"""`limbgram export`: a shape for printers, CAD programs and carvers, and what was written of it."""

from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from limbgram.cli.align import SideName
from limbgram.cli.replies import Reply, answered
from limbgram.cli.shapes import (
    ShapeArgument,
    UnitOption,
    require_apart,
    require_no_shape,
    require_output,
    shape_of,
)
from limbgram.core.errors import OptionsError, with_full_stop
from limbgram.core.files import write_bytes
from limbgram.core.geometry.frames import angle_between_deg
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import told
from limbgram.formats.aop.cost import AopReport
from limbgram.formats.aop.writing import AopOptions, Own, write_aop
from limbgram.formats.dxf import Curves, curves_of, write_polyface_dxf, write_triangles
from limbgram.formats.gate import admit, sure_in_limb_frame
from limbgram.formats.gcode.machine import Machine, read_machine, require_place, write_machine
from limbgram.formats.gcode.writing import GcodeReport, write_gcode
from limbgram.formats.limb_file import write_limb
from limbgram.formats.reading import ShapeFile
from limbgram.formats.table import FORMATS, format_of
from limbgram.workbench.bodies import Apart, Outside, kept, left_out, without_loose
from limbgram.workbench.carving.mapping import MapOptions
from limbgram.workbench.carving.setup import FAST
from limbgram.workbench.limb import Landmark, Limb, Side

_LOOK = "Compare the picture with the patient before carving."
_IN_LIMB = "in_limb_mm"
KINDS = (*(one.name for one in FORMATS if one.write is not None), "aop", "gcode")
"""Kinds of file that are written: the formats of the table, and those for carvers."""
_KEPT = " and ".join(one.name for one in FORMATS if {"colours", "sigma"} <= one.keeps)


def _kind(text: str) -> str:
    if text not in KINDS:
        raise typer.BadParameter(f"{text!r} is not one of {', '.join(map(repr, KINDS))}.")
    return text


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
    to: Annotated[
        str,
        typer.Option(
            parser=_kind,
            metavar=f"<{'|'.join(KINDS)}>",
            help=f"Kind of file; {_KEPT} keep colours and sigmas.",
        ),
    ],
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
        float | None, typer.Option(help="gcode: radius of the stub left for a tailstock, mm.")
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
    if path.suffix.lower() != f".{to}" and to != "gcode":
        raise OptionsError(f"{path.name} does not end in .{to}: programs go by the ending.")
    require_apart(path, shape)
    if to == "gcode":
        require_no_shape(path, "a program for a carver")
    read = shape_of(shape, unit)
    limb = read.limb
    confirmed = None if side is None else side.value
    match to:
        case "aop":
            sampled_anew = _OF_GRID & set(for_aop) or (spacing, to_mm) != (None, None)
            own = None if sampled_anew else _own_grid(read)
            options = replace(_aop(for_aop, spacing, to_mm), own=own)
            limb = admit(limb, confirmed)
            reply = aop_reply(limb, path, options)
        case "gcode":
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
            limb = admit(limb, confirmed)
            reply = gcode_reply(limb, path, set_up, to_mm=to_mm, keep=write_machine)
        case "dxf":
            limb = sure_in_limb_frame(limb)
            reply = dxf_reply(limb, path, spacing or 10.0, polyface=polyface)
        case _:
            limb = sure_in_limb_frame(limb)
            reply = mesh_reply(limb, path)
    return drawn(reply, limb)


def _free_default(shape: Path, to: str) -> Path:
    """Beside the shape under its name; kinds of shape under one that says that they are exports,
    so that nobody takes them for the scan.

    A file that lies there may be a scan or a case's own: nobody has said that it may go.
    """
    path = shape.with_name(f"{shape.stem}.{to}")
    kind = format_of(path)
    if kind is not None and kind.holds_limbs:
        path = shape.with_name(f"{shape.stem}-export-{to}.{to}")
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


def _refuse_others(to: str, formats: str, values: dict[str, Any]) -> None:
    """An option that the format does not know must not be passed over."""
    if values and to not in formats.split():
        names = ", ".join(f"--{_TYPED.get(name, name)}" for name in values)
        wanted = " or ".join(formats.split())
        raise OptionsError(f"{names}: for {wanted} only, and you write {to}. Leave it out.")


def given(**values: Any) -> dict[str, Any]:
    """The values that were typed."""
    return {name: value for name, value in values.items() if value is not None}


def aop_reply(limb: Limb, path: Path, options: AopOptions) -> Reply:
    report = write_aop(limb, path, options)
    mapped = report.mapped
    picture = _picture(
        path, report.held.radius_map.surface(), report.held.landmarks, report.held.frame.side
    )
    lines = (
        f"Written: {path} (mm; {report.spokes} spokes x {report.slices} slices, "
        f"{report.height_mm:.1f} mm high; profile {options.profile}; read back and compared)",
        *_own_lines(options),
        *_axis_lines(report),
        *_cost_lines(report),
        f"Left out: {mapped.distal_cut_mm:.1f} mm below the first slice, "
        f"{mapped.proximal_cut_mm:.1f} mm above the last; {mapped.rays_mended} of {mapped.rays:,} "
        "radii were taken from their neighbours",
        f"Mirror check: {picture}. {_LOOK}",
    )
    content = {
        "written": str(path),
        "unit": "mm",
        "side": report.held.frame.side,
        "profile": options.profile,
        "own_grid": options.own is not None,
        "spokes": report.spokes,
        "slices": report.slices,
        "height_mm": report.height_mm,
        "max_mm": report.max_mm,
        "rms_mm": report.rms_mm,
        "volume_ml": report.volume_ml,
        "volume_change": report.volume_change,
        "girth_change": None if report.worst_girth is None else report.girth_change,
        "girth_change_mm": None if report.worst_girth is None else report.worst_girth.change_mm,
        "girths": [
            {
                "height_mm": level.height_mm,
                "limb_mm": level.limb_mm,
                "file_mm": level.file_mm,
                "change_mm": level.change_mm,
            }
            for level in report.girths
        ],
        "above_cap_max_mm": report.above_cap_max_mm,
        "cap": None if report.cap is None else asdict(report.cap),
        "axis_from_limb": {
            "rotation": report.axis_from_limb.rotation.tolist(),
            "translation_mm": report.axis_from_limb.translation.tolist(),
        },
        "bodies_left_out": report.bodies_left_out,
        "loose_bodies": _tree(report.loose, _IN_LIMB),
        "distal_cut_mm": mapped.distal_cut_mm,
        "proximal_cut_mm": mapped.proximal_cut_mm,
        "rays_mended": mapped.rays_mended,
        "mirror_check": str(picture),
    }
    return Reply(lines, content)


def _cost_lines(report: AopReport) -> list[str]:
    """What the format costs above the rounded tip, then at it."""
    worst, cap = report.worst_girth, report.cap
    girths = (
        "no section to compare"
        if worst is None
        else f"girths {report.girth_change:+.2%}, at most {worst.change_mm:+.2f} mm "
        f"(of {worst.limb_mm:.0f} mm, {worst.height_mm:.0f} mm high)"
    )
    where = "" if cap is None else f" above {report.mapped.first_mm + cap.to_mm:.0f} mm"
    lines = [
        f"What the format costs{where}: surface within {report.above_cap_max_mm:.2f} mm, {girths}",
        f"In all: RMS {report.rms_mm:.3f} mm, volume {report.volume_change:+.2%}",
    ]
    if cap is not None:
        lines.insert(
            1,
            f"At the rounded tip, the lowest {cap.to_mm:.0f} mm: surface within {cap.max_mm:.2f} "
            f"mm, {cap.volume_change_ml:+.2f} mL; finer with --distal-slices",
        )
    lines += _left_out(report)
    return lines


def _own_lines(options: AopOptions) -> list[str]:
    if options.own is None:
        return []
    return [
        "Spokes, slices, axis and z = 0 are those of the file that the shape was read of: its "
        "radii stand as they were. --spokes or --spacing samples them anew."
    ]


def _axis_lines(report: AopReport) -> list[str]:
    motion = report.axis_from_limb
    if not np.any(motion.translation) and np.array_equal(motion.rotation, np.eye(3)):
        return []
    middle = np.array([0.0, 0.0, report.mapped.first_mm + report.height_mm / 2])
    aside = motion.inverse.apply(middle[None])[0]
    return [
        f"Axis: fitted, not the limb's own: tilted by "
        f"{angle_between_deg(motion.rotation, np.eye(3)):.1f} degrees; at mid height it lies "
        f"{aside[0]:+.1f} mm to the right and {aside[1]:+.1f} mm to the front of it. The file's "
        "comments hold the motion back; other programs show the limb tilted."
    ]


def _left_out(report: AopReport | GcodeReport) -> list[str]:
    told = left_out(report.bodies_left_out, report.loose, frame="in the limb frame")
    return [f"{sentence}." for sentence in told]


@dataclass(frozen=True)
class Asked:
    """What was typed of carving, by the names of the library."""

    carving: dict[str, Any]
    control: dict[str, Any]
    machine: Path | None
    fast: bool


def machine_of(asked: Asked) -> Machine:
    """What was typed, over the preset, over the machine file, over what is usual.

    The preset takes the larger tool only where neither names one.
    """
    kept = Machine() if asked.machine is None else read_machine(asked.machine)
    fast = dict(FAST) if asked.fast else {}
    if asked.machine is not None:
        fast.pop("tool_diameter_mm", None)
    return Machine(
        control=replace(kept.control, **asked.control),
        carving=replace(kept.carving, **{**fast, **asked.carving}),
    )


def gcode_reply(
    limb: Limb, path: Path, machine: Machine, *, to_mm: float | None, keep: Path | None
) -> Reply:
    options, control = replace(machine.carving, to_mm=to_mm), machine.control
    report = write_gcode(limb, path, options, control)
    kept = None if keep is None else write_machine(machine, keep)
    check, blank = report.check, report.toolpath.blank
    side: Side = "none" if limb.frame is None else limb.frame.side
    picture = _picture(path, check.carved.surface(), limb.landmarks, side)
    lines = (
        f"Written: {path} (mm; {report.lines:,} lines, about {check.minutes:.0f} min of cutting; "
        "read back and compared)",
        f"Control: {control.dialect}, {control.winding}: {control.rotary_word} from "
        f"{report.rotary_deg[0]:,.0f} to {report.rotary_deg[1]:,.0f} degrees; feed "
        f"{'in inverse time (G93)' if control.inverse_time else 'per minute'}",
        f"Blank: diameter {2 * blank.radius_mm:.0f} mm, free end at X {blank.from_mm:.1f} mm, "
        f"chuck not before X {blank.to_mm + options.ball_mm:.1f} mm; tool: ball end "
        f"{options.tool_diameter_mm:g} mm; A turns the {options.a_turns}",
        f"Carved by simulation: {check.gouge_mm:.3f} mm into the shape at most; ridges "
        f"{check.scallop_mm:.3f} mm (95 %); {check.left_mm:.2f} mm left where the tool cannot "
        f"reach ({check.left_share:.2%} of the surface over 0.2 mm)",
        told(report.standing),
        *_left_out(report),
        *(() if kept is None else (f"Machine file: {kept}",)),
        f"Mirror check: {picture}. {_LOOK}",
    )
    content = {
        "written": str(path),
        "unit": "mm",
        "side": side,
        "dialect": control.dialect,
        "winding": control.winding,
        "rotary_deg": list(report.rotary_deg),
        "machine": None if kept is None else str(kept),
        "shape_sha256": report.shape_sha256,
        "bodies_left_out": report.bodies_left_out,
        "loose_bodies": _tree(report.loose, _IN_LIMB),
        "lines": report.lines,
        "minutes": check.minutes,
        "blank_diameter_mm": 2 * blank.radius_mm,
        "blank_from_mm": blank.from_mm,
        "blank_to_mm": blank.to_mm,
        "a_turns": options.a_turns,
        "gouge_mm": check.gouge_mm,
        "scallop_mm": check.scallop_mm,
        "left_mm": check.left_mm,
        "left_share": check.left_share,
        "last_row_mm": report.above.last_mm,
        "proximal_cut_mm": report.above.rise_mm,
        "proximal_cut_at": report.above.side,
        "proximal_cut_share": report.above.share,
        "rapid_hits": check.rapid_hits,
        "mirror_check": str(picture),
    }
    return Reply(lines, content)


def dxf_reply(limb: Limb, path: Path, spacing_mm: float, *, polyface: bool) -> Reply:
    found = without_loose(limb.mesh)
    reply = _drawing_reply(limb.with_mesh(found.mesh), path, spacing_mm, polyface=polyface)
    return _naming_bodies(reply, limb, found)


def _drawing_reply(limb: Limb, path: Path, spacing_mm: float, *, polyface: bool) -> Reply:
    if not polyface:
        curves = curves_of(limb.mesh, spacing_mm)
        write_triangles(limb.mesh, path, "mm", curves)
        sections = len(curves.sections)
        lines = [f"Written: {path} (mm; {sections} sections; read back and compared)"]
        content = {"written": str(path), "unit": "mm", "sections": sections}
        return Reply((*lines, *_trimlines(curves), _axes(limb)), content)
    report = write_polyface_dxf(limb.mesh, path, spacing_mm=spacing_mm)
    sections = len(report.curves.sections)
    lines = [f"Written: {path} (mm; {sections} sections; read back and compared)"]
    if report.meshes > 1:
        lines.append(
            f"The surface was split into {report.meshes} polyface meshes that touch: the format "
            "counts to 32,767."
        )
    content = {
        "written": str(path),
        "unit": "mm",
        "meshes": report.meshes,
        "sections": sections,
    }
    return Reply((*lines, *_trimlines(report.curves), _axes(limb)), content)


def _trimlines(curves: Curves) -> list[str]:
    """What lies on the layer of the trimline, or why there is none."""
    loops = curves.trimline
    if not loops:
        why = (
            "its faces do not join to one surface"
            if loops is None
            else "the surface has no open edge"
        )
        return [f"No layer TRIMLINE_MM: {why}."]
    ahead = (np.roll(loop, -1, axis=0) - loop for loop in loops)
    lengths = ", ".join(f"{np.linalg.norm(step, axis=1).sum():.0f} mm" for step in ahead)
    return [f"Layer TRIMLINE_MM: open edges, round {lengths}"]


def mesh_reply(limb: Limb, path: Path) -> Reply:
    found = without_loose(limb.mesh)
    write_limb(limb.with_mesh(found.mesh), path)
    kind = format_of(path)
    unit = "mm" if kind is None else kind.unit
    lines = (f"Written: {path} ({unit}; read back and compared)", _axes(limb))
    return _naming_bodies(Reply(lines, {"written": str(path), "unit": unit}), limb, found)


def _naming_bodies(reply: Reply, limb: Limb, found: Outside) -> Reply:
    """The reply with the loose bodies that a printer would have made, and what else there is."""
    frame, key = ("the file", "in_mesh_mm") if limb.frame is None else ("the limb frame", _IN_LIMB)
    told = (*left_out(len(found.loose), found.loose, frame=f"in {frame}"), *kept(found))
    bodies = {
        "bodies_left_out": len(found.loose),
        "loose_bodies": _tree(found.loose, key),
        "bodies_inside": found.inside,
    }
    return replace(
        reply,
        lines=(*reply.lines, *(f"{sentence}." for sentence in told)),
        content={**reply.content, **bodies},
    )


def _tree(loose: tuple[Apart, ...], key: str) -> list[dict[str, Any]]:
    return [{key: body.place_mm.tolist(), "size_mm": body.size_mm} for body in loose]


def drawn(reply: Reply, limb: Limb) -> Reply:
    """The reply with what was odd about the shape's file."""
    notes = tuple(f"Note: {with_full_stop(note)}" for note in limb.notes)
    return replace(
        reply, lines=notes + reply.lines, content={**reply.content, "notes": list(limb.notes)}
    )


def _axes(limb: Limb) -> str:
    if limb.frame is None:
        return "The shape is not aligned: the file has the axes of the shape's own file."
    return "Axes: +Z proximal, +Y anterior, +X the patient's right; origin distal."


def _picture(path: Path, mesh: Mesh, landmarks: tuple[Landmark, ...], side: Side) -> Path:
    """Draw the mirror check beside the file; most formats need nothing that draws."""
    from limbgram.report.drawings.drawing import png
    from limbgram.report.drawings.mirrorcheck import mirror_check

    drawing = mirror_check(mesh, landmarks, side, path.name)
    beside = path.with_name(f"{path.name}-mirror-check.png")
    return write_bytes(beside, png(drawing.figure).tobytes())
