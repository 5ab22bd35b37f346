"""The control: which dialect of G-code it reads, and how its rotary axis counts.

linuxcnc    RS274/NGC. G93 gives a move's time. Of a move of X and A in feed per minute F is that
            of X alone, so such moves are not written that way. Wrapped rotary (WRAPPED_ROTARY =
            1): the sign of the word is the way to turn, its size the place within a turn.
mach        Mach3 and Mach4. As LinuxCNC, but for rollover: a cutting move is not taken the short
            way there, so it is not written. The dwell is in seconds: with Mach3's setting "G04
            Dwell param in Milliseconds" it is hardly any. Turn "Ang Short Rot on G0" off.
fanuc       Program between % signs, O number, capitals. Dwell in milliseconds. Roll-over (parameter
            1008, ROA 1, RAB 0): an absolute word is taken the short way. Feed per minute counts a
            degree as a millimetre; inverse time is an option there, and an alarm without it.
grbl        Grbl 1.1 and what was made of it. Feed per minute counts a degree as a millimetre, as
            its rotary axis is a linear one in all but name (grblHAL's rotary fix does not: take
            inverse time with it). No tool change, no tool length, no rollover. Grbl itself has
            three axes, so that Y turns, and refuses an A; grblHAL and FluidNC may have an A.
"""

from dataclasses import dataclass
from typing import Literal, get_args

from limbgram.core.errors import OptionsError

DialectName = Literal["linuxcnc", "mach", "fanuc", "grbl"]
Winding = Literal["unwind", "reset", "rollover", "continuous"]
"""unwind: the helix turns back before A comes to its limit, and A comes to nothing greater.

reset: G92 takes whole turns off A when it comes to its limit; the machine's own count goes on.
rollover: A is written within one turn; the control must be set to take it so.
continuous: A winds on; refused where it would go beyond its limit."""
FeedMode = Literal["inverse-time", "per-minute"]
Coolant = Literal["none", "mist", "flood"]
RotaryWord = Literal["A", "B", "C", "Y"]

TURN_DEG = 360.0


@dataclass(frozen=True, kw_only=True)
class Dialect:
    """What controls of one family read."""

    feeds: tuple[FeedMode, ...]
    """The first is taken unasked."""
    rollover: Literal["sign", "shortest", "none"]
    """Which way a word within one turn is gone to."""
    milliseconds: bool = False
    """Of a dwell, instead of seconds."""
    tools: bool = True
    """T, M6 and G43 are known."""
    mist: bool = True
    """M7 is known."""
    longest_line: int = 255
    blanks_free: bool = False
    """A line's blanks and comments are not counted in its length."""
    percent: bool = False
    """The program stands between % signs and has an O number, in capitals."""
    path_control: str = ""
    """What keeps straight moves from being rounded far off, with the tolerance in mm."""
    rotary_word: RotaryWord = "A"
    """Letter of the axis that turns, on a control of which nothing more is known."""
    largest_feed: float = 99999.0
    """A larger F is not written: such a move takes a little longer."""


DIALECTS: dict[DialectName, Dialect] = {
    "linuxcnc": Dialect(feeds=("inverse-time",), rollover="sign", path_control="G64 P{:.3f}"),
    "mach": Dialect(feeds=("inverse-time",), rollover="none", path_control="G64"),
    "fanuc": Dialect(
        feeds=("inverse-time", "per-minute"), rollover="shortest", milliseconds=True, percent=True
    ),
    "grbl": Dialect(
        feeds=("per-minute", "inverse-time"),
        rollover="none",
        tools=False,
        mist=False,
        longest_line=79,
        blanks_free=True,
        rotary_word="Y",
    ),
}


@dataclass(frozen=True, kw_only=True)
class Control:
    """One machine's control."""

    dialect: DialectName = "linuxcnc"
    winding: Winding = "unwind"
    feed: FeedMode | None = None
    """How cutting moves carry their feed; None for the dialect's usual way."""
    a_limit_deg: float = 9999.0
    """A goes no farther than this to either side, which LinuxCNC's wizard sets and any control can
    write; nothing to rollover."""
    rotary_word: RotaryWord | None = None
    """Letter of the axis that turns about X; None for the one that the dialect's plainest control
    has."""
    tool_number: int = 0
    """Called by T, M6 and G43; 0 leaves the tool to whoever sets the machine up."""
    spindle_start_s: float = 3.0
    """Waited after the spindle is told to run."""
    coolant: Coolant = "none"
    program_number: int = 1000
    """O number, where programs have one."""

    @property
    def habits(self) -> Dialect:
        return DIALECTS[self.dialect]

    @property
    def letter(self) -> RotaryWord:
        """Of the axis that turns about X."""
        return self.rotary_word or self.habits.rotary_word

    @property
    def inverse_time(self) -> bool:
        return (self.feed or self.habits.feeds[0]) == "inverse-time"

    @property
    def most_turns(self) -> int | None:
        """Turns of a helix before it turns back; None where it winds on."""
        return int(self.a_limit_deg // TURN_DEG) if self.winding == "unwind" else None


_LIMITS: dict[str, tuple[float, float]] = {
    "a_limit_deg": (720, 1e7),
    "tool_number": (0, 9999),
    "spindle_start_s": (0, 600),
    "program_number": (1, 9999),
}
_CHOICES: dict[str, tuple[str, ...]] = {
    "dialect": get_args(DialectName),
    "winding": get_args(Winding),
    "coolant": get_args(Coolant),
    "rotary_word": get_args(RotaryWord),
}


def check_control(control: Control) -> None:
    """Refuse what the control does not read."""
    for name, (low, high) in _LIMITS.items():
        value = float(getattr(control, name))
        if not low <= value <= high:
            raise OptionsError("carver.setting", setting=name, value=value, least=low, most=high)
    for name, known in _CHOICES.items():
        unsaid = name == "rotary_word" and control.rotary_word is None
        if getattr(control, name) not in known and not unsaid:
            value = getattr(control, name)
            raise OptionsError("carver.choice", setting=name, value=value, known=known)
    habits = control.habits
    if control.feed is not None and control.feed not in habits.feeds:
        raise OptionsError(
            "carver.feed", feed=control.feed, dialect=control.dialect, known=habits.feeds
        )
    if control.winding == "rollover" and habits.rollover == "none":
        raise OptionsError("carver.rollover", dialect=control.dialect)
    if control.tool_number and not habits.tools:
        raise OptionsError("carver.tool_change", dialect=control.dialect)
