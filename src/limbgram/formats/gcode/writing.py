"""Writing: the toolpath as a G-code program for a four-axis carver, read back and simulated.

In      an aligned limb, how to carve, the control that will read the program.
Out     the file, and the carved shape by a simulation that reads the file alone.
Fails   CarveError: not aligned, A beyond its limit, or a program that would cut into the shape.
"""

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from limbgram.core.errors import CarveError
from limbgram.core.files import require, write_bytes
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.notebook import brief
from limbgram.findings import Finding, doubt, fault, note
from limbgram.formats.gcode.control import Control, Winding, check_control
from limbgram.formats.gcode.program import rotary_words, text_of
from limbgram.formats.gcode.reading import read_moves
from limbgram.formats.gcode.rules import require_taken
from limbgram.workbench.bodies import SeparateBody, outer_bodies
from limbgram.workbench.carving.setup import CarveOptions
from limbgram.workbench.carving.simulation import CarveCheck, Moves, check_carving
from limbgram.workbench.carving.slab import UncarvedTop, uncarved_top
from limbgram.workbench.carving.toolpath import Toolpath, plan_toolpath
from limbgram.workbench.limb import Limb

_ROUNDING = 0.0005 + 1e-9
_ROLLED_DEG = 0.0015 + 1e-9
"""With rollover a word may be rounded the other way, -0 is written as the smallest angle, and a
move within the last digit is left out."""
_DEEPEST_GOUGE_MM = 0.05
_LEAST_TOLD_MM = 0.05
"""Height that stays in the blank; less is reported as nothing."""
DEFAULTS = Control()
_WINDING: dict[Winding, str] = {
    "unwind": "the rotary axis turns back and stays within its limit",
    "reset": "G92 takes whole turns off the rotary axis",
    "rollover": "places within one turn, set the rotary axis to roll over",
    "continuous": "the rotary axis winds on",
}


@dataclass(frozen=True, kw_only=True)
class GcodeReport:
    """A written program, and what it carves by simulation."""

    path: Path
    toolpath: Toolpath
    lines: int
    rotary_deg: tuple[float, float]
    """Least and largest word of the rotary axis."""
    check: CarveCheck
    shape_sha256: str
    bodies_left_out: int
    """Bodies inside the limb, such as bones, and loose ones beside it: none were carved."""
    loose: tuple[SeparateBody, ...]
    """Those beside it, in the limb frame."""
    above: UncarvedTop
    """The part of the limb that stays in the blank over the last row."""

    __repr__ = brief

    @property
    def standing(self) -> Finding:
        """The finding on what stays in the blank over the last row."""
        over = self.above
        if over.rise_mm < _LEAST_TOLD_MM:
            return note("carver.whole", height_mm=over.last_mm)
        return doubt(
            "carver.stays_in_blank",
            height_mm=over.last_mm,
            rise_mm=over.rise_mm,
            side=over.side,
            share=over.share,
        )


def write_gcode(
    limb: Limb, path: Path | str, options: CarveOptions, control: Control = DEFAULTS
) -> GcodeReport:
    """Plan, write, read back, and carve by simulation from what was read.

    Raises:
        CarveError: not aligned, or the program would cut into the shape.
    """
    path = Path(path)
    limb = limb.aligned()
    check_control(control)
    if options.pattern == "helix":
        options = replace(options, most_turns=control.most_turns)
    points = limb.limb_from_mesh.apply(limb.mesh.vertices_mm)
    whole = Mesh(vertices_mm=points, faces=limb.mesh.faces)
    outside = outer_bodies(whole)
    outside.require_one_limb()
    mesh = outside.mesh
    toolpath = plan_toolpath(mesh, options)
    over = uncarved_top(mesh, toolpath.blank.to_mm)
    shape_hash = hash_of_shape(whole)
    text = text_of(toolpath, control, _header(toolpath, control, limb.side, shape_hash, over))
    found: list[CarveCheck] = []

    def check(written: Path) -> None:
        kept = written.read_text("ascii")
        require_taken(kept, control)
        moves = read_moves(kept, options, control)
        _compare(moves, toolpath, control)
        carved = check_carving(moves, toolpath.blank, options.ball_mm, mesh)
        _refuse_if_unsafe(carved, moves, options)
        found.append(carved)

    write_bytes(path, text.encode("ascii"), check)
    return GcodeReport(
        path=path,
        toolpath=toolpath,
        lines=text.count("\n"),
        rotary_deg=rotary_words(text, control),
        check=found[0],
        shape_sha256=shape_hash,
        bodies_left_out=outside.bodies_left_out,
        loose=outside.loose,
        above=over,
    )


def hash_of_shape(mesh: Mesh) -> str:
    """SHA-256 of the triangles' corners in the limb frame, in single precision."""
    corners = mesh.vertices_mm[mesh.faces].astype("<f4")
    return hashlib.sha256(corners.tobytes()).hexdigest()


def _header(
    toolpath: Toolpath, control: Control, side: str, shape_hash: str, over: UncarvedTop
) -> tuple[str, ...]:
    options, blank = toolpath.options, toolpath.blank
    turning = (
        "the tool round the work counter-clockwise seen from +X, the work clockwise"
        if options.a_turns == "tool"
        else "the work counter-clockwise seen from +X"
    )
    letter = control.letter
    tool = f" number {control.tool_number}" if control.tool_number else ""
    standing = (
        (f"MANDREL: diameter {options.mandrel_diameter_mm:g} mm through the blank",)
        if options.mandrel_diameter_mm
        else ()
    )
    return (
        "limbgram, four-axis carving",
        f"CONTROL: {control.dialect}, {_WINDING[control.winding]}",
        f"FEED: {'inverse time, G93' if control.inverse_time else 'per minute, degrees as mm'}",
        "UNIT: MM, DEGREES",
        f"SIDE: {side.upper()}",
        f"SHAPE SHA256: {shape_hash}",
        "X: along the rotary axis, + proximal, 0 at the origin of the limb",
        "Z: radius of the tool tip, 0 on the rotary axis",
        f"{letter}: 0 is the front, + turns {turning}",
        f"TOOL: ball end {options.tool_diameter_mm:g} mm{tool}, reach {options.tool_reach_mm:g} mm",
        f"BLANK: diameter {2 * blank.radius_mm:g} mm, free end at X {blank.from_mm:.1f}, "
        f"chuck not before X {blank.to_mm + options.ball_mm:.1f}",
        *standing,
        f"LAST ROW: X {over.last_mm:.1f}, the shape reaches {over.rise_mm:.1f} mm beyond it, "
        f"farthest at {letter} {_signed_deg(over, options):.0f}, which is not carved",
        f"RIDGES: {options.scallop_mm:g} mm",
    )


def _signed_deg(over: UncarvedTop, options: CarveOptions) -> float:
    """Angle of the highest point on the rotary axis, from -180 to 180."""
    turned = -over.theta_deg if options.a_turns == "tool" else over.theta_deg
    return (turned + 180.0) % 360.0 - 180.0


def _compare(moves: Moves, toolpath: Toolpath, control: Control) -> None:
    """Refuse cutting moves that differ from the toolpath by more than the program's digits."""
    ball = toolpath.options.ball_mm
    cutting = ~moves.rapid
    wanted = np.concatenate(
        [
            np.column_stack([strip.x_mm, strip.a_deg, strip.centre_mm - ball])
            for strip in toolpath.strips
        ]
    )
    found = np.column_stack([moves.x_mm, moves.a_deg, moves.tip_mm])[cutting]
    count = fault("carver.read.moves", found=len(found), written=len(wanted))
    require(found.shape == wanted.shape, count)
    apart = np.abs(found - wanted).max(0)
    rounding = np.full(3, _ROUNDING)
    rounding[1] = _ROLLED_DEG if control.winding == "rollover" else _ROUNDING
    off = fault("carver.read.place", off=float(apart.max(initial=0.0)))
    require(bool((apart <= rounding).all()), off)


def _refuse_if_unsafe(check: CarveCheck, moves: Moves, options: CarveOptions) -> None:
    mandrel_mm = options.mandrel_diameter_mm / 2
    if mandrel_mm and float(moves.tip_mm.min()) < mandrel_mm:
        raise CarveError("carver.in_mandrel")
    if check.gouge_mm > _DEEPEST_GOUGE_MM or check.rapid_hits:
        raise CarveError(
            "carver.gouges",
            gouge_mm=check.gouge_mm,
            most_mm=_DEEPEST_GOUGE_MM,
            rapid_hits=check.rapid_hits,
        )
