"""The machine file: settings of a carver (control, tool, rates, carving) as TOML.

It holds the settings of the machine and its tool, not those of one job (the blank's size, the last
row). Reading is strict: an unknown name, a wrong type or a value out of range is refused, because
an ignored rate would damage the blank.
"""

import codecs
from dataclasses import dataclass, field, fields
from pathlib import Path

from limbgram.core.errors import OptionsError, reason_of
from limbgram.core.files import ContentError, read_content, toml_of, without_mark, write_bytes
from limbgram.core.typed import value_of
from limbgram.findings import note
from limbgram.formats.gcode.control import Control, check_control
from limbgram.workbench.carving.setup import CarveOptions, check_options

_FORMAT, _VERSION = "limbgram machine", 1
_FIRST_LINE = f'format = "{_FORMAT}"'.encode("ascii")
_LARGEST_BYTES = 65_536
_OF_THE_JOB = {"blank_diameter_mm", "blank_length_mm", "to_mm", "most_turns"}


@dataclass(frozen=True, kw_only=True)
class Machine:
    """A carver as it is set up."""

    control: Control = field(default_factory=Control)
    carving: CarveOptions = field(default_factory=CarveOptions)
    names_tool: bool = field(default=False, compare=False)
    """Whether its file names the tool's diameter."""


def write_machine(machine: Machine, path: Path | str) -> Path:
    """Write a machine file.

    Raises:
        OptionsError: what lies there is no machine file.
    """
    path = Path(path)
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
    """Refuse to overwrite another kind of file: recipes end in .toml, too.

    Raises:
        OptionsError: something else lies there.
    """
    if not path.exists():
        return
    try:
        with path.open("rb") as stream:
            begin = stream.read(len(codecs.BOM_UTF8) + len(_FIRST_LINE))
            ours = without_mark(begin).startswith(_FIRST_LINE)
    except OSError:
        ours = False
    if not ours:
        raise OptionsError("carver.file.in_the_way", path=str(path))


def read_machine(path: Path | str) -> Machine:
    """Read a machine file.

    Raises:
        OptionsError: it cannot be read, or holds an unknown name or a wrong value.
    """
    path = Path(path)
    content = read_content(path, _LARGEST_BYTES, OptionsError, note("carver.file.name_it"))
    try:
        tree = toml_of(content)
    except ValueError as error:  # no UTF-8, or no TOML
        raise OptionsError("carver.file.unread", name=path.name, why=reason_of(error)) from error
    unknown = set(tree) - {"format", "version", "control", "carving"}
    if tree.get("format") != _FORMAT or tree.get("version") != _VERSION or unknown:
        raise OptionsError("carver.file.version", name=path.name, format=_FORMAT, version=_VERSION)
    try:
        control = value_of(tree.get("control", {}), Control, "control")
        carving = value_of(tree.get("carving", {}), CarveOptions, "carving")
        of_the_job = sorted(_OF_THE_JOB.intersection(tree.get("carving", {})))
        if of_the_job:
            raise ContentError("carver.file.of_the_job", settings=tuple(of_the_job))
    except ValueError as error:
        raise OptionsError("carver.file.wrong", name=path.name, why=reason_of(error)) from error
    check_control(control)
    check_options(carving)
    names_tool = "tool_diameter_mm" in tree.get("carving", {})
    return Machine(control=control, carving=carving, names_tool=names_tool)


def _names(options: Control | CarveOptions) -> list[str]:
    return [one.name for one in fields(options) if one.name not in _OF_THE_JOB]


def _toml(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else repr(value)
