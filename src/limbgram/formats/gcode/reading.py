"""Reading back: the moves of a G-code program, as its control would make them."""

import math
import re

import numpy as np

from limbgram.core.files import require
from limbgram.findings import fault
from limbgram.formats.gcode.control import TURN_DEG, Control
from limbgram.formats.gcode.program import SAFE_START
from limbgram.workbench.carving.setup import CarveOptions
from limbgram.workbench.carving.simulation import Moves

_WORD = re.compile(r"([A-Z])(-?\d+\.?\d*)")
_CODES = {"G0", "G1", "G93", "G94", "M3", "M5", "M6", "M7", "M8", "M9", "M30", *SAFE_START.split()}
_NOT_MOVES = ("G4", "G43", "G64", "G92")
"""Codes whose words are no targets of a move."""


def read_moves(text: str, options: CarveOptions, control: Control) -> Moves:
    """The moves of a program of this form.

    Raises:
        ExportError: a word that the writer does not use.
    """
    sign = 1.0 if options.a_turns == "tool" else -1.0
    letter = control.letter
    cutting = re.compile(rf"G1 X(-?[0-9.]+) {letter}(-?[0-9.]+) Z(-?[0-9.]+) F([0-9.]+)")
    x, a, z, feed = 0.0, 0.0, math.inf, math.inf
    off = 0.0
    rapid, inverse, minutes = True, False, 0.0
    rows: list[tuple[float, float, float]] = []
    fast: list[bool] = []
    for line in text.splitlines():
        cut = cutting.fullmatch(line)
        if cut is not None:  # nearly all lines: a short cut of the general case below
            rapid, before = False, (x, a, z)
            x, z, feed = float(cut[1]), float(cut[3]), float(cut[4])
            a = _angle_deg(cut[2], a, off, control)
        else:
            words = _WORD.findall(re.sub(r"\(.*?\)", "", line))
            codes = [f"{name}{value}" for name, value in words]
            values = {name: value for name, value in words if name not in "GM"}
            if any(code in _NOT_MOVES for code in codes):
                if "G92" in codes:
                    require(set(values) == {letter}, fault("carver.read.line", line=line))
                    off = a - float(values[letter])
                continue
            for name, value in words:
                known = name in f"XZFSTO{letter}" or f"{name}{value}" in _CODES
                require(known, fault("carver.read.word", word=f"{name}{value}"))
            rapid = "G0" in codes or (rapid and "G1" not in codes)
            inverse = "G93" in codes or (inverse and "G94" not in codes)
            before = (x, a, z)
            feed = float(values.get("F", feed))
            if not values.keys() & {"X", "Z", letter}:
                continue
            x, z = float(values.get("X", x)), float(values.get("Z", z))
            if letter in values:
                a = _angle_deg(values[letter], a, off, control)
        rows.append((x, sign * a, z))
        fast.append(rapid)
        if not rapid:
            length = math.sqrt((x - before[0]) ** 2 + (a - before[1]) ** 2 + (z - before[2]) ** 2)
            minutes += 1 / feed if inverse else length / feed
    targets = np.array(rows)
    return Moves(
        x_mm=targets[:, 0],
        a_deg=targets[:, 1],
        tip_mm=targets[:, 2],
        rapid=np.array(fast),
        minutes=minutes,
    )


def _angle_deg(word: str, at_deg: float, offset_deg: float, control: Control) -> float:
    """Angle of the rotary axis after a word, all turns counted.

    Args:
        at_deg: Angle before it.
        offset_deg: Turns that G92 took off so far.
    """
    if control.winding != "rollover":
        return float(word) + offset_deg
    way_deg = (abs(float(word)) - at_deg) % TURN_DEG
    if control.habits.rollover == "shortest":
        return at_deg + (way_deg if way_deg <= TURN_DEG / 2 else way_deg - TURN_DEG)
    return at_deg + (way_deg - TURN_DEG if word.startswith("-") else way_deg)
