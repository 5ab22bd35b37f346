"""What each kind of export answers."""

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from limbgram.carving.setup import FAST
from limbgram.cli.replies import Reply
from limbgram.export.dxf import Curves, curves_of, write_triangles
from limbgram.export.workshop import (
    AopOptions,
    AopReport,
    GcodeReport,
    Machine,
    read_machine,
    write_aop,
    write_gcode,
    write_limb,
    write_machine,
    write_polyface_dxf,
)
from limbgram.export.writing import write_bytes
from limbgram.geometry.rigid import angle_between_deg
from limbgram.shape.bodies import Apart, Outside, kept, left_out, without_loose
from limbgram.shape.limb import Landmark, Limb, Side
from limbgram.surface.mesh import Mesh

_LOOK = "Compare the picture with the patient before carving."
_IN_LIMB = "in_limb_mm"


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
    unit = "m" if path.suffix.lower() == ".glb" else "mm"
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
    notes = tuple(f"Note: {note}." for note in limb.notes)
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
    from limbgram.report.shape.mirrorcheck import mirror_check

    drawing = mirror_check(mesh, landmarks, side, path.name)
    beside = path.with_name(f"{path.name}-mirror-check.png")
    return write_bytes(beside, png(drawing.figure).tobytes())
