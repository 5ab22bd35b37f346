"""Rules: checks a program line by line by the rules of its control, before the file is kept.

A control refuses a line when it comes to it, with the spindle running and the blank half carved.
What is refused here is refused by Grbl 1.1h (`gcode.c` and `report.c` of its source) or by
LinuxCNC 2.9 (its interpreter `rs274`), or alarms a Fanuc (PS0009 to PS0011, PS1202); Mach reads
RS274/NGC, as LinuxCNC does. Codes, letters and length of a line differ by control. Of other rules
the strictest holds for all; no state of an earlier program is assumed: units, plane, zero, distance
mode and feed mode are set before an axis moves.

Not checked here: the state of the machine (tool table, limits, offsets), and the effect of the
moves on the blank, which the simulation checks (writing.py).
"""

import re
from dataclasses import dataclass, field

from limbgram.core.errors import CarveError
from limbgram.findings import Finding, note
from limbgram.formats.gcode.control import TURN_DEG, Control

_GROUPS = {
    "motion": {"G0", "G1", "G80"},
    "plane": {"G17"},
    "units": {"G21"},
    "distance": {"G90"},
    "feed": {"G93", "G94"},
    "cutter": {"G40"},
    "length": {"G43", "G49"},
    "zero": {"G54"},
    "path": {"G64"},
    "aside": {"G4", "G92"},
    "end": {"M30"},
    "tool": {"M6"},
    "spindle": {"M3", "M5"},
    "coolant": {"M7", "M8", "M9"},
}
"""Modal groups of the codes that programs of this form have: a line may have one of each group."""
_GROUP_OF = {code: group for group, codes in _GROUPS.items() for code in codes}
_SET_BEFORE_MOVES = frozenset(("plane", "units", "distance", "feed", "cutter", "zero"))
_NEVER_NEGATIVE = frozenset("FHNPST")
"""The letters of values, those of axes apart."""
_USED_BY = {"P": ("G4", "G64"), "H": ("G43",)}
"""Letters that are refused on a line without a code that uses them."""
_WORD = re.compile(r"([A-Z])([-+]?(?:\d+\.?\d*|\.\d+))")
_WORDS = re.compile(rf"(?:{_WORD.pattern})*")
_NUMBER = re.compile(r"O\d{1,4}(?:\(.*\))?")


@dataclass
class _State:
    """The modal state of the control."""

    control: Control
    codes: frozenset[str]
    axes: frozenset[str]
    values: frozenset[str]
    spindle_by_program: bool
    """Whether the program starts the spindle; else the operator does."""
    modal: dict[str, str] = field(default_factory=dict)
    feed: float = 0.0
    ended: bool = False


def require_taken(text: str, control: Control) -> None:
    """Refuse a program with a line that its control would refuse or misread.

    Raises:
        CarveError: with the line, its number and the reason.
    """
    habits = control.habits
    tools, path = habits.tools, bool(habits.path_control)
    known = {"G43": tools, "M6": tools, "G64": path, "M7": habits.mist}
    axes = frozenset("XZ") | {control.letter}
    state = _State(
        control=control,
        codes=frozenset(code for code in _GROUP_OF if known.get(code, True)),
        axes=axes,
        values=axes | (_NEVER_NEGATIVE if tools else _NEVER_NEGATIVE - {"H"}),
        spindle_by_program=re.search(r"^[^(\n]*\bM3\b", text, re.MULTILINE) is not None,
    )
    lines = text.splitlines()
    for number, line in enumerate(lines, 1):
        framed = habits.percent and number in (1, 2, len(lines))
        why = _frame_fault(line, number) if framed else _refusal(line, state)
        if why is not None:
            raise CarveError(
                "carver.refused", dialect=control.dialect, line=number, text=line[:60], why=why
            )
    if not state.ended or state.modal.get("spindle") == "M3":
        raise CarveError("carver.no_end", dialect=control.dialect)


def _frame_fault(line: str, number: int) -> Finding | None:
    """Why a line of the frame is wrong: % first and last, the program number second."""
    framed = _NUMBER.fullmatch(line) if number == 2 else line == "%"
    return None if framed else note("carver.line.frame")


def _refusal(line: str, state: _State) -> Finding | None:
    """Why the control would refuse a line; None if it would not."""
    habits = state.control.habits
    plain = re.sub(r"\([^()]*\)|\s", "", line)
    if habits.percent and line != line.upper():
        return note("carver.line.small_letters")
    plain = plain.upper()
    if len(plain if habits.blanks_free else line) > habits.longest_line:
        return note("carver.line.too_long", letters=len(line), most=habits.longest_line)
    if not _WORDS.fullmatch(plain):
        return note("carver.line.form")
    codes: dict[str, str] = {}
    values: dict[str, float] = {}
    for letter, number in _WORD.findall(plain):
        word = f"{letter}{number}"
        if letter in "GM":
            code = f"{letter}{float(number):g}"
            if code not in state.codes:
                return note("carver.line.unknown", word=word)
            group = _GROUP_OF[code]
            if group in codes:
                return note("carver.line.two_of_a_group", one=codes[group], two=code)
            codes[group] = code
        elif letter not in state.values:
            return note("carver.line.unknown", word=word)
        elif letter in values:
            return note("carver.line.twice", letter=letter)
        elif letter in _NEVER_NEGATIVE and float(number) < 0:
            return note("carver.line.negative", word=word)
        elif habits.percent and letter in state.axes | {"F"} and "." not in number:
            return note("carver.line.no_point", word=word)
        else:
            values[letter] = float(number)
    return _executed(codes, values, state)


def _executed(codes: dict[str, str], values: dict[str, float], state: _State) -> Finding | None:
    """Apply a line to the state; why it cannot be executed, or None."""
    if state.ended and (codes or values):
        return note("carver.line.after_end")
    moved = state.axes & values.keys()
    if "feed" in codes and codes["feed"] != state.modal.get("feed"):
        state.feed = 0.0  # its unit changes
    aside = codes.pop("aside", None)
    state.modal |= codes
    state.ended = "end" in codes
    inverse, motion = state.modal.get("feed") == "G93", state.modal.get("motion")
    state.feed = values.get("F", 0.0 if inverse else state.feed)
    for letter, takers in _USED_BY.items():
        if letter in values and not {aside, *codes.values()} & set(takers):
            return note("carver.line.unused", letter=letter)
    if aside == "G4":
        return None if "P" in values and not moved else note("carver.line.dwell")
    if aside == "G92":
        alone = moved == frozenset(state.control.letter) and "motion" not in codes
        return None if alone else note("carver.line.offset")
    if not moved:
        return None
    unset = _SET_BEFORE_MOVES - state.modal.keys()
    if unset:
        return note("carver.line.untold", codes=tuple(sorted(_GROUPS[min(unset)])))
    return _moved(values, motion, state)


def _moved(values: dict[str, float], motion: str | None, state: _State) -> Finding | None:
    if motion not in ("G0", "G1"):
        return note("carver.line.no_motion")
    if motion == "G1" and not state.feed:
        return note("carver.line.no_feed")
    if motion == "G1" and state.spindle_by_program and state.modal.get("spindle") != "M3":
        return note("carver.line.spindle")
    control = state.control
    if control.winding == "rollover" and abs(values.get(control.letter, 0.0)) >= TURN_DEG:
        return note("carver.line.whole_turn", letter=control.letter)
    return None
