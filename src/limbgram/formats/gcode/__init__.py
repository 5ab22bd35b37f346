"""G-code: the toolpath in the dialect of a control, read back, and what a machine is like."""

from limbgram.formats.gcode.control import (
    Control,
    Coolant,
    DialectName,
    FeedMode,
    RotaryWord,
    Winding,
)
from limbgram.formats.gcode.machine import Machine, read_machine, require_place, write_machine
from limbgram.formats.gcode.writing import GcodeReport, hash_of_shape, write_gcode

__all__ = [
    "Control",
    "Coolant",
    "DialectName",
    "FeedMode",
    "GcodeReport",
    "Machine",
    "RotaryWord",
    "Winding",
    "hash_of_shape",
    "read_machine",
    "require_place",
    "write_gcode",
    "write_machine",
]
