"""Grbl: the whole program as Grbl 1.1 would take it, line by line, before the file is kept.

A control refuses a line when it comes to it, with the spindle running and the blank half carved.
The rules are those of `gcode.c` and `report.c` of Grbl 1.1h, as far as programs without arcs,
probes and offsets meet them; a controller with more axes (grblHAL, FluidNC) takes their letters
besides.
"""

import re
from dataclasses import dataclass, field

from limbgram.core.errors import CarveError

_LONGEST_LINE = 79
"""Letters that fit its buffer of 80, without blanks and comments."""
_GROUPS = {
    "motion": {"G0", "G1", "G2", "G3", "G80"},
    "plane": {"G17", "G18", "G19"},
    "distance": {"G90", "G91"},
    "feed": {"G93", "G94"},
    "units": {"G20", "G21"},
    "cutter": {"G40"},
    "length": {"G43.1", "G49"},
    "zero": {"G54", "G55", "G56", "G57", "G58", "G59"},
    "path": {"G61"},
    "aside": {"G4", "G10", "G28", "G30", "G53", "G92", "G92.1"},
    "end": {"M0", "M1", "M2", "M30"},
    "spindle": {"M3", "M4", "M5"},
    "coolant": {"M8", "M9"},
}
_GROUP_OF = {code: group for group, codes in _GROUPS.items() for code in codes}
_VALUES = frozenset("FIJKLNPRSTXYZ")
_NEVER_NEGATIVE = frozenset("FNPST")
_AXES = frozenset("XYZ")
_WORD = re.compile(r"([A-Z])([-+]?(?:\d+\.?\d*|\.\d+))")
_WORDS = re.compile(rf"(?:{_WORD.pattern})*")
_UNSUPPORTED, _FORM, _TWICE, _GROUP_TWICE, _NEGATIVE = 20, 2, 25, 21, 4
_NO_FEED, _MISSING, _TOO_LONG, _NO_MOTION = 22, 28, 11, 31


@dataclass
class _State:
    """What holds from line to line."""

    motion: str = "G0"
    inverse: bool = False
    feed: float = 0.0
    ended: bool = False
    axes: frozenset[str] = field(default_factory=lambda: _AXES)


def require_taken(text: str, rotary_letter: str) -> None:
    """Refuse a program of which Grbl would refuse a line.

    Args:
        rotary_letter: Of the axis that turns: X, Y and Z alone are stock Grbl's.

    Raises:
        CarveError: with the line, its number and the number of Grbl's error.
    """
    state = _State(axes=_AXES | {rotary_letter})
    for number, line in enumerate(text.splitlines(), 1):
        error = _error(line, state)
        if error:
            raise CarveError("carver.grbl_refuses", line=number, text=line[:60], error=error)


def _error(line: str, state: _State) -> int:
    """Number of the error that Grbl answers with; 0 for ok."""
    plain = re.sub(r"\(.*?\)|;.*|\s", "", line).upper()
    if len(plain) > _LONGEST_LINE:
        return _TOO_LONG
    if not _WORDS.fullmatch(plain):
        return _FORM
    groups: set[str] = set()
    codes: set[str] = set()
    values: dict[str, float] = {}
    for letter, number in _WORD.findall(plain):
        if letter in "GM":
            code = f"{letter}{float(number):g}"
            group = _GROUP_OF.get(code)
            if group is None:
                return _UNSUPPORTED
            if group in groups:
                return _GROUP_TWICE
            groups.add(group)
            codes.add(code)
        elif letter not in _VALUES and letter not in state.axes:
            return _UNSUPPORTED
        elif letter in values:
            return _TWICE
        else:
            values[letter] = float(number)
            if letter in _NEVER_NEGATIVE and values[letter] < 0:
                return _NEGATIVE
    return _carried_out(codes, values, state)


def _carried_out(codes: set[str], values: dict[str, float], state: _State) -> int:
    moved = state.axes & values.keys()
    state.inverse = "G93" in codes or (state.inverse and "G94" not in codes)
    if codes & {"G93", "G94"}:
        state.feed = 0.0  # it counts otherwise from here on
    state.motion = next(iter(codes & _GROUPS["motion"]), state.motion)
    feed = values.get("F", 0.0 if state.inverse else state.feed)
    state.feed = feed
    if "G4" in codes:
        return 0 if "P" in values else _MISSING
    if "G92" in codes:
        return 0 if moved else _MISSING
    if moved and state.motion == "G80":
        return _NO_MOTION
    if moved and state.motion == "G1" and not feed:
        return _NO_FEED
    return 0
