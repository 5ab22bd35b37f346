"""Doubt: how a surface whose capture was judged red goes on saying so.

By its name, which travels with every copy, and from there by the limb file of whatever is made
from it.
"""

from pathlib import Path

_MARK = "-RED"
RED = (
    "this surface comes from a capture whose verdict is RED: much of the limb is missing, or its "
    "size or shape may be wrong by a ply of sock or more; report.html of the case says why. Make "
    "nothing from it unchecked"
)


def marked_red(path: Path) -> Path:
    """The name of a red result: surface.stl becomes surface-RED.stl."""
    return path.with_name(f"{path.stem}{_MARK}{path.suffix}")


def doubt_of_name(name: str) -> str:
    """What a file's name says against it; empty where it says nothing."""
    stem = Path(name).stem
    return RED if stem.removesuffix("-unitless").endswith(_MARK) else ""
