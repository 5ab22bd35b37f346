"""The table of formats: which files hold a shape, who reads and writes them, and what they keep.

All that depends on the format uses it: readers, the formats of limbs, `limbgram export --to`, the
surfaces that a case delivers, and the tests of round trips. The table is collected: it has each
file of this folder with a line `FORMAT = Format(...)`. Files are searched for that line before they
are imported, because others of this folder import the table.
"""

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Final

from limbgram.formats.format import Format

_HERE = Path(__file__).parent
_LINE = "FORMAT = Format("


def _found() -> Iterator[Format]:
    """The formats that files in this folder and below define."""
    for file in _HERE.rglob("*.py"):
        if any(line.startswith(_LINE) for line in file.read_text("utf-8").splitlines()):
            inside = ".".join(file.relative_to(_HERE).with_suffix("").parts)
            yield import_module(f"limbgram.formats.{inside}").FORMAT


FORMATS: Final[tuple[Format, ...]] = tuple(sorted(_found(), key=lambda one: one.place))
"""In the order in which they are offered and delivered."""


def format_of(path: Path) -> Format | None:
    """The format with the path's extension; None where the table has none."""
    return next((one for one in FORMATS if one.suffix == path.suffix.lower()), None)
