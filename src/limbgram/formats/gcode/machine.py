"""The machine file: control, tool, rates and how to carve, kept as TOML for the next time.

It holds what belongs to the machine and its tool, not what belongs to one job (the blank's size,
where to end). Reading is strict: an unknown name, a wrong kind of value or one out of range is
refused, for a rate that was passed over would be carved with.
"""

import tomllib
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, cast

from limbgram.core.errors import OptionsError
from limbgram.core.files import write_bytes
from limbgram.formats.gcode.control import Control, check_control
from limbgram.workbench.carving.setup import CarveOptions, check_options

_FORMAT, _VERSION = "limbgram machine", 1
_FIRST_LINE = f'format = "{_FORMAT}"'.encode("ascii")
_LARGEST_BYTES = 65_536
_OF_THE_JOB = {"blank_diameter_mm", "blank_length_mm", "to_mm", "most_turns"}
_PATTERNS, _TURNERS = ("helix", "rings"), ("tool", "work")


@dataclass(frozen=True, kw_only=True)
class Machine:
    """A carver as it is set up."""

    control: Control = field(default_factory=Control)
    carving: CarveOptions = field(default_factory=CarveOptions)


def write_machine(machine: Machine, path: Path) -> Path:
    """Write a machine file.

    Raises:
        OptionsError: what lies there is no machine file.
    """
    require_place(path)
    check_control(machine.control)
    check_options(machine.carving)
    lines = [_FIRST_LINE.decode("ascii"), f"version = {_VERSION}"]
    for name, options in (("control", machine.control), ("carving", machine.carving)):
        lines += ["", f"[{name}]"]
        usual = type(options)()
        for key in _names(options):
            value = getattr(options, key)
            if isinstance(getattr(usual, key), float):
                value = float(value)
            lines += [] if value is None else [f"{key} = {_toml(value)}"]
    return write_bytes(path, ("\n".join(lines) + "\n").encode("ascii"))


def require_place(path: Path) -> None:
    """Refuse to write a machine file over anything but a machine file: recipes end in .toml too.

    Raises:
        OptionsError: something else lies there.
    """
    if not path.exists():
        return
    try:
        with path.open("rb") as stream:
            ours = stream.read(len(_FIRST_LINE)) == _FIRST_LINE
    except OSError:
        ours = False
    if not ours:
        raise OptionsError(
            f"{path} is there already and is no machine file. Choose another name for it."
        )


def read_machine(path: Path) -> Machine:
    """Read a machine file.

    Raises:
        OptionsError: it cannot be read, or holds what is not known or cannot be.
    """
    try:
        if path.stat().st_size > _LARGEST_BYTES:
            raise OptionsError(f"{path.name} is too large for a machine file. Name the right file.")
        tree = tomllib.loads(path.read_text("utf-8"))
    except OSError as error:
        raise OptionsError(f"{path} cannot be read: {error.strerror or error}.") from error
    except (ValueError, RecursionError) as error:  # no UTF-8, or no TOML
        raise OptionsError(f"{path.name} is no machine file: {error}. Write one anew.") from error
    unknown = sorted(set(tree) - {"format", "version", "control", "carving"})
    if tree.get("format") != _FORMAT or tree.get("version") != _VERSION or unknown:
        raise OptionsError(
            f"{path.name} is no machine file of this version: it must begin with format = "
            f'"{_FORMAT}" and version = {_VERSION}, and hold [control] and [carving] alone. '
            "--write-machine writes one."
        )
    control = replace(Control(), **_values(tree, "control", Control(), path.name))
    carving = replace(CarveOptions(), **_values(tree, "carving", CarveOptions(), path.name))
    if carving.pattern not in _PATTERNS or carving.a_turns not in _TURNERS:
        raise OptionsError(
            f"{path.name}: pattern is one of {', '.join(_PATTERNS)} and a_turns one of "
            f"{', '.join(_TURNERS)}. Correct it."
        )
    check_control(control)
    check_options(carving)
    return Machine(control=control, carving=carving)


def _names(options: Control | CarveOptions) -> list[str]:
    return [one.name for one in fields(options) if one.name not in _OF_THE_JOB]


def _values(
    tree: dict[str, Any], table: str, usual: Control | CarveOptions, name: str
) -> dict[str, Any]:
    """A table's values, each of the kind of what is usual."""
    found = tree.get(table, {})
    if not isinstance(found, dict):
        raise OptionsError(f"{name}: {table} is no table. Write [{table}] over its lines.")
    values = cast(dict[str, Any], found)
    known = _names(usual)
    for key, value in values.items():
        if key not in known:
            raise OptionsError(
                f"{name}: {key} is not known in [{table}]. Known are {', '.join(known)}."
            )
        expected = getattr(usual, key)
        kind = str if expected is None else type(expected)
        right = isinstance(value, (int, float)) if kind is float else isinstance(value, kind)
        if not right or isinstance(value, bool):
            raise OptionsError(
                f"{name}: {key} = {str(value)[:40]} is of the wrong kind. Write "
                f"{_WORDS[kind]}, such as {_toml('per-minute' if expected is None else expected)}."
            )
        if kind is float:
            try:
                values[key] = float(value)
            except OverflowError:
                raise OptionsError(f"{name}: {key} is too large. Correct it.") from None
    return values


_WORDS: dict[type, str] = {str: "a word between quotes", float: "a number", int: "a whole number"}


def _toml(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else repr(value)
