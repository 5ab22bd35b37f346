"""G-code: the toolpath as a plain program for a four-axis carver, and read back.

X runs along the limb's long axis, A turns, Z is the radius of the tool's tip over the rotary axis.
Cutting moves carry inverse time (G93): of a move that mostly turns, F in mm/min means another
thing on every controller. Only G0, G1, G21, G90, G93, G94, M3, M5 and M30 are used.
"""

import hashlib
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from jaxtyping import Float64

from limbgram.carving.setup import CarveOptions
from limbgram.carving.simulation import CarveCheck, Moves, check_carving
from limbgram.carving.toolpath import Strip, Toolpath, plan_toolpath
from limbgram.errors import CarveError
from limbgram.export.writing import require, write_file
from limbgram.shape.bodies import Apart, outer_bodies
from limbgram.shape.limb import Limb
from limbgram.surface.mesh import Mesh

_ROUNDING = 0.0005 + 1e-9
_WORD = re.compile(r"([A-Z])(-?\d+\.?\d*)")
_CUT = re.compile(r"G1 X(-?[0-9.]+) A(-?[0-9.]+) Z(-?[0-9.]+) F([0-9.]+)")
"""A cutting move as the program writes it."""
_KNOWN_CODES = {"G0", "G1", "G21", "G90", "G93", "G94", "M3", "M5", "M30"}
_DEEPEST_GOUGE_MM = 0.05
_FASTEST_MIN = 1e5
"""Largest F in inverse time: moves that turn the tip on the spot take no time otherwise."""


@dataclass(frozen=True, kw_only=True)
class GcodeReport:
    """The program, and what it carves by simulation."""

    path: Path
    toolpath: Toolpath
    lines: int
    check: CarveCheck
    shape_sha256: str
    bodies_left_out: int
    """Bodies inside the limb, such as bones, and loose ones beside it: none were carved."""
    loose: tuple[Apart, ...]
    """Those beside it, in the limb frame."""


def write_gcode(limb: Limb, path: Path, options: CarveOptions) -> GcodeReport:
    """Plan, write, read back, and carve by simulation from what was read.

    Raises:
        CarveError: not aligned, or the program would cut into the shape.
    """
    if limb.frame is None:
        raise CarveError(
            "The limb is not aligned, so a carver would have no axis to turn it about. Run "
            "`limbgram align` first."
        )
    points = limb.frame.limb_from_mesh.apply(limb.mesh.vertices_mm)
    whole = Mesh(vertices_mm=points, faces=limb.mesh.faces)
    outside = outer_bodies(whole)
    outside.require_one_limb()
    mesh = outside.mesh
    toolpath = plan_toolpath(mesh, options)
    shape_hash = hash_of_shape(whole)
    text = _header(toolpath, limb.frame.side, shape_hash) + _program(toolpath)
    found: list[CarveCheck] = []

    def encode(stream: BinaryIO) -> None:
        stream.write(text.encode("ascii"))

    def check(written: Path) -> None:
        moves = read_moves(written.read_text("ascii"), options)
        _compare(moves, toolpath)
        carved = check_carving(moves, toolpath.blank, options.ball_mm, mesh)
        _refuse_if_unsafe(carved)
        found.append(carved)

    write_file(path, encode, check)
    return GcodeReport(
        path=path,
        toolpath=toolpath,
        lines=text.count("\n"),
        check=found[0],
        shape_sha256=shape_hash,
        bodies_left_out=outside.bodies_left_out,
        loose=outside.loose,
    )


def hash_of_shape(mesh: Mesh) -> str:
    """Of the triangles' corners in the limb frame, in single precision."""
    corners = mesh.vertices_mm[mesh.faces].astype("<f4")
    return hashlib.sha256(corners.tobytes()).hexdigest()


def _header(toolpath: Toolpath, side: str, shape_hash: str) -> str:
    options, blank = toolpath.options, toolpath.blank
    turning = (
        "the tool round the work counter-clockwise seen from +X, the work clockwise"
        if options.a_turns == "tool"
        else "the work counter-clockwise seen from +X"
    )
    lines = (
        "limbgram, four-axis carving",
        "UNIT: MM, DEGREES",
        f"SIDE: {side.upper()}",
        f"SHAPE SHA256: {shape_hash}",
        "X: along the rotary axis, + proximal, 0 at the origin of the limb",
        "Z: radius of the tool tip, 0 on the rotary axis",
        f"A: 0 is the front, + turns {turning}",
        f"TOOL: ball end {options.tool_diameter_mm:g} mm, reach {options.tool_reach_mm:g} mm",
        f"BLANK: diameter {2 * blank.radius_mm:g} mm, free end at X {blank.from_mm:.1f}, "
        f"chuck not before X {blank.to_mm + options.ball_mm:.1f}",
        f"RIDGES: {options.scallop_mm:g} mm",
    )
    return "".join(f"( {line} )\n" for line in lines) + "G21 G90 G94\n"


def _program(toolpath: Toolpath) -> str:
    options = toolpath.options
    safe_mm = toolpath.blank.radius_mm + options.clearance_mm
    parts = [f"G0 Z{safe_mm:.3f}\n"]
    if options.spindle_rpm:
        parts.append(f"S{options.spindle_rpm} M3\n")
    for strip, a_deg in zip(toolpath.strips, _wound(toolpath), strict=True):
        tips = strip.centre_mm - options.ball_mm
        parts.append(f"( {strip.name} )\nG0 X{strip.x_mm[0]:.3f} A{a_deg[0]:.3f}\n")
        parts.append(f"G1 Z{tips[0]:.3f} F{options.plunge_mm_min:.0f}\nG93\n")
        rows = np.column_stack([strip.x_mm, a_deg, tips])[1:]
        rows = np.column_stack([rows, _inverse_minutes(strip, options)])
        parts.append("G1 X%.3f A%.3f Z%.3f F%.2f\n" * len(rows) % tuple(rows.ravel()))
        parts.append(f"G94\nG0 Z{safe_mm:.3f}\n")
    return "".join(parts) + ("M5\n" if options.spindle_rpm else "") + "M30\n"


def _wound(toolpath: Toolpath) -> list[Float64[np.ndarray, " k"]]:
    """The angles of every strip as the machine counts them: on from where the last one ended."""
    sign = 1.0 if toolpath.options.a_turns == "tool" else -1.0
    at = 0.0
    wound: list[Float64[np.ndarray, " k"]] = []
    for strip in toolpath.strips:
        a_deg = sign * strip.a_deg
        a_deg = a_deg + 360.0 * round((at - float(a_deg[0])) / 360)
        at = float(a_deg[-1])
        wound.append(a_deg)
    return wound


def _inverse_minutes(strip: Strip, options: CarveOptions) -> Float64[np.ndarray, " k"]:
    """One over the time of each move: by the way over the surface, and no faster than A turns."""
    turn = np.abs(np.diff(strip.a_deg))
    round_mm = np.radians(turn) * (strip.centre_mm[1:] + strip.centre_mm[:-1]) / 2
    way = np.sqrt(np.diff(strip.x_mm) ** 2 + np.diff(strip.centre_mm) ** 2 + round_mm**2)
    minutes = np.maximum(way / options.feed_mm_min, turn / options.turn_deg_min)
    return 1 / np.maximum(minutes, 1 / _FASTEST_MIN)


def read_moves(text: str, options: CarveOptions) -> Moves:
    """The moves of a program of this form.

    Raises:
        ExportError: a word that the writer does not use.
    """
    sign = 1.0 if options.a_turns == "tool" else -1.0
    state = {"X": 0.0, "A": 0.0, "Z": math.inf, "F": math.inf}
    rapid, inverse, minutes = True, False, 0.0
    rows: list[tuple[float, float, float]] = []
    fast: list[bool] = []
    for line in text.splitlines():
        cut = _CUT.fullmatch(line) if inverse and not rapid else None
        if cut is not None:  # nearly all lines: told by one look what the words below would tell
            x, a, z, f = map(float, cut.groups())
            state.update(X=x, A=a, Z=z, F=f)
            rows.append((x, sign * a, z))
            fast.append(False)
            minutes += 1 / f
            continue
        words = _WORD.findall(re.sub(r"\(.*?\)", "", line))
        before = (state["X"], state["Z"])
        for letter, value in words:
            code = f"{letter}{value}"
            if letter in ("G", "M"):
                require(code in _KNOWN_CODES, f"the word {code}")
                rapid = {"G0": True, "G1": False}.get(code, rapid)
                inverse = {"G93": True, "G94": False}.get(code, inverse)
            else:
                require(letter in "XAZFS", f"the word {code}")
                state[letter] = float(value)
        if any(letter in "XAZ" for letter, _ in words):
            rows.append((state["X"], sign * state["A"], state["Z"]))
            fast.append(rapid)
            if not rapid:
                way = math.hypot(state["X"] - before[0], state["Z"] - before[1])
                minutes += 1 / state["F"] if inverse else way / state["F"]
    places = np.array(rows)
    return Moves(
        x_mm=places[:, 0],
        a_deg=places[:, 1],
        tip_mm=places[:, 2],
        rapid=np.array(fast),
        minutes=minutes,
    )


def _compare(moves: Moves, toolpath: Toolpath) -> None:
    """The cutting moves read are the toolpath's places, within the program's digits."""
    sign = 1.0 if toolpath.options.a_turns == "tool" else -1.0
    ball = toolpath.options.ball_mm
    cutting = ~moves.rapid
    wanted = np.concatenate(
        [
            np.column_stack([strip.x_mm, sign * a_deg, strip.centre_mm - ball])
            for strip, a_deg in zip(toolpath.strips, _wound(toolpath), strict=True)
        ]
    )
    found = np.column_stack([moves.x_mm, moves.a_deg, moves.tip_mm])[cutting]
    require(found.shape == wanted.shape, f"{len(found)} cutting moves of {len(wanted)}")
    apart = float(np.abs(found - wanted).max())
    require(apart <= _ROUNDING, f"a place {apart:.3g} mm or degrees off")


def _refuse_if_unsafe(check: CarveCheck) -> None:
    if check.gouge_mm > _DEEPEST_GOUGE_MM or check.rapid_hits:
        raise CarveError(
            f"The program was not kept: by simulation it cuts {check.gouge_mm:.3f} mm into the "
            f"shape ({_DEEPEST_GOUGE_MM:g} mm is allowed) and makes {check.rapid_hits} rapid moves "
            "inside the blank. Take a smaller tolerance or a larger tool."
        )
