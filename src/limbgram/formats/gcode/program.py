"""The program: a toolpath in words of one control.

X runs along the limb's long axis, A is the rotary axis, Z the radius of the tool's tip over it. The
meaning of F depends on the control (control.py); it is computed so that the tool's centre keeps its
speed over the surface.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import CarveError
from limbgram.formats.gcode.control import TURN_DEG, Control
from limbgram.workbench.carving.setup import CarveOptions
from limbgram.workbench.carving.toolpath import Strip, Toolpath

SAFE_START = "G21 G17 G40 G49 G54 G80 G90 G94"
"""Units, plane, no cutter radius, no tool length, first zero, no cycle, absolute, per minute."""
_COOLANT = {"none": (), "mist": ("M7",), "flood": ("M8",)}
_LEAST_DEG = 0.001


def text_of(toolpath: Toolpath, control: Control, header: tuple[str, ...]) -> str:
    """The whole program."""
    options, habits = toolpath.options, control.habits
    safe = f"G0 Z{toolpath.blank.radius_mm + options.clearance_mm:.3f}"
    lines = ["%", f"O{control.program_number:04d}"] if habits.percent else []
    lines += [_comment(line, control) for line in header]
    lines.append(SAFE_START)
    if habits.path_control:
        lines.append(habits.path_control.format(options.tolerance_mm))
    if control.tool_number:
        lines += [f"T{control.tool_number} M6", f"G43 H{control.tool_number}"]
    lines.append(safe)
    if options.spindle_rpm:
        lines.append(f"S{options.spindle_rpm} M3")
        lines += [_dwell(control)] if control.spindle_start_s else []
    lines += _COOLANT[control.coolant]
    parts = ["\n".join(lines), "\n"]
    counter = _Counter(control)
    for strip in toolpath.strips:
        parts += _strip(strip, options, control, counter)
        parts.append(f"{safe}\n")
    end = ["M9"] if control.coolant != "none" else []
    end += ["M5"] if options.spindle_rpm else []
    end += ["M30", "%"] if habits.percent else ["M30"]
    return "".join(parts) + "\n".join(end) + "\n"


def rotary_words(text: str, control: Control) -> tuple[float, float]:
    """The smallest and the largest word of the rotary axis in a program."""
    plain = re.sub(r"\(.*?\)", "", text)
    words = np.array(re.findall(rf" {control.letter}(-?[0-9.]+)", plain), np.float64)
    return float(words.min()), float(words.max())


def as_machine_counts(strip: Strip, options: CarveOptions) -> Float64[np.ndarray, " k"]:
    """The angles of a strip, with the machine's sense of rotation."""
    return strip.a_deg if options.a_turns == "tool" else -strip.a_deg


def inverse_minutes(strip: Strip, options: CarveOptions) -> Float64[np.ndarray, " k"]:
    """1/min of each move, by its length over the surface and the fastest turn of A."""
    turn_deg = np.abs(np.diff(strip.a_deg))
    arc_mm = np.radians(turn_deg) * (strip.centre_mm[1:] + strip.centre_mm[:-1]) / 2
    length_mm = np.sqrt(np.diff(strip.x_mm) ** 2 + np.diff(strip.centre_mm) ** 2 + arc_mm**2)
    minutes = np.maximum(length_mm / options.feed_mm_min, turn_deg / options.turn_deg_min)
    return 1 / np.maximum(minutes, 1e-9)


@dataclass(frozen=True)
class _Run:
    """Points of a strip between two resets of the rotary axis."""

    start: int
    end: int
    taken_off_deg: float
    line: str
    """The G92 line before them, if any."""


class _Counter:
    """The angle of the rotary axis, as its control counts it."""

    def __init__(self, control: Control) -> None:
        self._control = control
        self._taken_off = 0.0
        self._at_deg: float | None = None
        """Angle within a turn; None before the first word."""

    def to_start(self, x_mm: float, a_deg: float) -> str:
        """The lines that bring the raised tool over a strip's start; the angle stays."""
        line = self._reset(a_deg) if self._control.winding == "reset" else ""
        if self._control.winding != "rollover":
            word = f" {self._letter}{a_deg - self._taken_off:.3f}"
        elif self._at_deg is not None:
            word = ""  # it is there; with the other sign the same angle would be a turn
        else:
            word = self._word(self._wrapped(a_deg, 1.0))
        return f"{line}G0 X{x_mm:.3f}{word}\n"

    def wrapped(self, a_deg: Float64[np.ndarray, " k"]) -> Iterator[str]:
        """Words within one turn for all points but the first; empty where the axis does not turn.

        A control that goes by the sign might take a rounded word for a turn.
        """
        for before, after in zip(a_deg[:-1].tolist(), a_deg[1:].tolist(), strict=True):
            yield self._word(self._wrapped(after, after - before))

    def runs(self, a_deg: Float64[np.ndarray, " k"]) -> Iterator[_Run]:
        """The points of a strip, split where whole turns are taken off."""
        if self._control.winding != "reset":
            yield _Run(0, len(a_deg), 0.0, "")
            return
        line, start = "", 0
        while start < len(a_deg):
            over = np.abs(a_deg[start:] - self._taken_off) > self._control.a_limit_deg
            end = start + int(over.argmax()) if over.any() else len(a_deg)
            yield _Run(start, end, self._taken_off, line)
            if end < len(a_deg):
                line = self._reset(float(a_deg[end - 1]))
            start = end

    def _reset(self, a_deg: float) -> str:
        """Take whole turns off the count; returns the G92 line, empty where there are none."""
        counted_deg = a_deg - self._taken_off
        turns_deg = TURN_DEG * float(np.trunc(counted_deg / TURN_DEG))
        self._taken_off += turns_deg
        return f"G92 {self._letter}{counted_deg - turns_deg:.3f}\n" if turns_deg else ""

    @property
    def _letter(self) -> str:
        return self._control.letter

    def _word(self, wrapped: str) -> str:
        """The word of an angle within a turn; empty where the axis is there, to the last digit."""
        to_deg = abs(float(wrapped))
        if self._at_deg is not None:
            apart = (to_deg - self._at_deg) % TURN_DEG
            if min(apart, TURN_DEG - apart) < 1.5 * _LEAST_DEG:
                return ""
        self._at_deg = to_deg
        return f" {self._letter}{wrapped}"

    def _wrapped(self, a_deg: float, way: float) -> str:
        within = round(a_deg % TURN_DEG, 3) % TURN_DEG
        if self._control.habits.rollover == "shortest" or way >= 0:
            return f"{within:.3f}"
        return f"-{max(within, _LEAST_DEG):.3f}"  # minus nothing has no sign on some controls


def _strip(strip: Strip, options: CarveOptions, control: Control, counter: _Counter) -> list[str]:
    a_deg = as_machine_counts(strip, options)
    tips = strip.centre_mm - options.ball_mm
    _require_within(a_deg, control)
    parts = [f"{_comment(strip.name, control)}\n"]
    parts.append(counter.to_start(float(strip.x_mm[0]), float(a_deg[0])))
    parts.append(f"G1 Z{tips[0]:.3f} F{options.plunge_mm_min:.1f}\n")
    feeds = _feeds(strip, options, control)
    parts += ["G93\n"] if control.inverse_time else []
    if control.winding == "rollover":
        words = counter.wrapped(a_deg)
        rows = zip(strip.x_mm[1:].tolist(), words, tips[1:].tolist(), feeds.tolist(), strict=True)
        parts += [f"G1 X{x:.3f}{word} Z{z:.3f} F{feed:.2f}\n" for x, word, z, feed in rows]
    else:
        form = f"G1 X%.3f {control.letter}%.3f Z%.3f F%.2f\n"
        for run in counter.runs(a_deg):
            places = slice(max(run.start, 1), run.end)
            rows = np.column_stack([strip.x_mm, a_deg - run.taken_off_deg, tips])[places]
            rows = np.column_stack([rows, feeds[places.start - 1 : run.end - 1]])
            parts += [run.line, form * len(rows) % tuple(rows.ravel())]
    parts += ["G94\n"] if control.inverse_time else []
    return parts


def _feeds(strip: Strip, options: CarveOptions, control: Control) -> Float64[np.ndarray, " k"]:
    """F of each cutting move."""
    feeds = inverse_minutes(strip, options)
    if not control.inverse_time:
        # These controls count a degree as a millimetre.
        steps = (np.diff(strip.x_mm), np.diff(strip.a_deg), np.diff(strip.centre_mm))
        feeds = feeds * np.sqrt(sum(step**2 for step in steps))
    return np.clip(feeds, 0.01, control.habits.largest_feed)


def _require_within(a_deg: Float64[np.ndarray, " k"], control: Control) -> None:
    largest = float(np.abs(a_deg).max())
    if control.winding in ("continuous", "unwind") and largest > control.a_limit_deg:
        raise CarveError("carver.winds_up", largest_deg=largest, limit_deg=control.a_limit_deg)


def _dwell(control: Control) -> str:
    seconds = control.spindle_start_s
    return f"G4 P{1000 * seconds:.0f}" if control.habits.milliseconds else f"G4 P{seconds:.1f}"


def _comment(text: str, control: Control) -> str:
    if control.habits.percent:
        return f"({text.upper().replace(':', ' =')})"
    return f"( {text} )"
