"""Sources: the files a record stands on, and what is printed instead of their names.

File names, folder names and landmarks' own names are often patients' names. A record prints none
of them: a file is told by the first digits of its SHA-256, a landmark whose name no template knows
by its number.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from limbgram.shape.frame.landmarks import NAMES
from limbgram.shape.limb import Limb
from limbgram.shape.recipe import Recipe

_DIGITS = 8
_KNOWN = {row.name for rows in NAMES.values() for row in rows}


@dataclass(frozen=True, kw_only=True)
class ShapeSource:
    """A shape and the file it was read from."""

    limb: Limb
    sha256: str
    kind: str
    """Ending of the file, such as PLY."""
    limb_file_sha256: str | None
    """Of the limb file beside it; None without one."""

    @property
    def id(self) -> str:
        return f"shape {self.sha256[:_DIGITS]}"


@dataclass(frozen=True, kw_only=True)
class RecipeSource:
    """A recipe and the hash of its file."""

    recipe: Recipe
    sha256: str

    @property
    def id(self) -> str:
        return f"recipe {self.sha256[:_DIGITS]}"


@dataclass(frozen=True, kw_only=True)
class CaseSource:
    """What a finished case says of its own accuracy."""

    sha256: str
    """Of its case.json."""
    accuracy: dict[str, Any]
    """The tree of its accuracy.json."""
    files: frozenset[str]
    """SHA-256 of every file that it delivered."""

    @property
    def id(self) -> str:
        return f"case {self.sha256[:_DIGITS]}"


def printed_names(*shapes: ShapeSource | None) -> dict[str, str]:
    """What is printed for each landmark's name: a template's name as it is, others numbered."""
    printed: dict[str, str] = {}
    own = 0
    for shape in shapes:
        for mark in () if shape is None else shape.limb.landmarks:
            if mark.name in printed:
                continue
            own += mark.name not in _KNOWN
            printed[mark.name] = mark.name if mark.name in _KNOWN else f"own landmark {own}"
    return printed


def nameless(source: ShapeSource, printed: Mapping[str, str]) -> ShapeSource:
    """The shape under its id, with landmarks under the names that are printed."""
    limb = source.limb
    return replace(
        source,
        limb=replace(
            limb,
            name=source.id,
            landmarks=tuple(
                replace(mark, name=printed.get(mark.name, mark.name)) for mark in limb.landmarks
            ),
            notes=tuple(_without(note, limb.name, source.id) for note in limb.notes),
        ),
    )


def in_print(text: str, printed: Mapping[str, str]) -> str:
    """An edit in words, its landmarks under the names that are printed."""
    for name, told in printed.items():
        text = text.replace(f'"{name}"', f'"{told}"')
    return text


def _without(note: str, name: str, told: str) -> str:
    return note.replace(name, told) if name else note
