"""The recipe's file: TOML that a person can read, write and correct.

    format = "limbgram recipe"
    version = 2
    name = "first fitting"
    scan_sha256 = "..."

    [[edit]]
    do = "load"
    at = "patellar tendon"
    depth_mm = 5.0
    falloff_mm = 18.0

    [[edit]]
    do = "load"
    accept = ["load on fibula head"]
    at = "fibula head"
    depth_mm = 1.0
    falloff_mm = 12.0

    [[edit]]
    do = "smoothing"
    on = false
    passes = 8

Places are landmarks by name, or [x, y, z] in millimetres in the frame that the edit names. Names
and parameters that are not known are errors that list what is.

Version 1 called the carving in of the positive "relief", which is prosthetics' word for the
opposite, and the building up "build-up". A file of version 1 is read as it was meant, "relief" as
"load", with a note, and is of version 2 when it is written again. In version 2 "relief" is refused:
nobody can know what its writer meant.
"""

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, cast, get_args

from limbgram.core.errors import OptionsError, ShapeFileError
from limbgram.core.files import read_content, toml_of
from limbgram.core.typed import Mismatch, Strictness, any_value_of, fields_of
from limbgram.findings import Finding, doubt
from limbgram.workbench.edits.edit import Edit, name_of
from limbgram.workbench.edits.editing import EDIT_NAMED
from limbgram.workbench.recipe.consent import plain_words
from limbgram.workbench.recipe.recipe import Entry, Recipe

_FORMAT, _VERSION = "limbgram recipe", 2
_BEFORE = {"relief": "load", "build-up": "relieve"}
"""Words of version 1, and what each did, in the words of today."""
_SAME = {"build-up": "relieve"}
"""Other words of the trade for an edit, taken in any version and written as the one."""
_MISREAD = "relief"
"""It is the trade's word for room, and recipes of version 1 said it for pressure."""
_LARGEST_BYTES = 4_000_000
_MOST_EDITS = 1000
_HEADER = {"format", "version", "name", "scan_sha256", "edit"}


def read_recipe(path: Path | str) -> Recipe:
    """Read a recipe's file.

    Raises:
        ShapeFileError: it cannot be read, or is no recipe.
        OptionsError: an edit or parameter that is not known.
    """
    path = Path(path)
    return parse_recipe(read_content(path, _LARGEST_BYTES, ShapeFileError), path.name)


def parse_recipe(text: str | bytes, name: str) -> Recipe:
    """A recipe from its text, or the bytes of its file."""
    try:
        tree = toml_of(text)
    except ValueError as error:
        raise ShapeFileError("recipe.file.no_toml", name=name, reason=str(error)) from error
    version: object = tree.get("version")
    known = type(version) is int and version in (1, _VERSION)
    if tree.get("format") != _FORMAT or not known:
        raise ShapeFileError(
            "recipe.file.other_format", name=name, format=_FORMAT, version=_VERSION
        )
    unknown = sorted(set(tree) - _HEADER)
    if unknown:
        raise OptionsError(
            "recipe.file.header",
            name=name,
            unknown=tuple(unknown),
            known=tuple(sorted(_HEADER - {"edit"})),
        )
    for key in ("name", "scan_sha256"):
        if not isinstance(tree.get(key, ""), str):
            raise OptionsError("recipe.file.quotes", name=name, key=key)
    listed = tree.get("edit", [])
    if not isinstance(listed, list) or len(cast(list[Any], listed)) > _MOST_EDITS:
        raise OptionsError("recipe.file.edits", name=name, most=_MOST_EDITS)
    parts, notes = cast(list[Any], listed), ()
    if version == 1:
        notes = _rename_notes(parts)
        parts = [_renamed_from_version_1(part) for part in parts]
    entries = tuple(
        _entry_of_tree(part, f"Edit {number} of {name}")
        for number, part in enumerate(parts, start=1)
    )
    return Recipe(
        name=tree.get("name", ""),
        scan_sha256=tree.get("scan_sha256", ""),
        entries=entries,
        notes=notes,
    )


def make_edit(kind: str, parameters: Mapping[str, Any], what: str) -> Edit:
    """An edit from its name and parameters.

    Raises:
        OptionsError: a name or parameter that is not known, missing, or of the wrong kind.
    """
    if kind == _MISREAD:
        raise OptionsError("recipe.relief", what=what, kind=kind)
    made = EDIT_NAMED.get(_SAME.get(kind, kind))
    if made is None:
        raise OptionsError("recipe.no_such_edit", what=what, kind=kind, known=tuple(EDIT_NAMED))
    try:
        return fields_of(dict(parameters), made, f"{what}: {kind}", _STRICTNESS)
    except Mismatch as error:
        raise OptionsError("recipe.mismatch", reason=str(error)) from error


def encode_recipe(recipe: Recipe) -> bytes:
    """The recipe's file; reading it gives an equal recipe.

    Every parameter that has a value is written, defaults too: a recipe stands by itself, and does
    the same when a later version has another default.
    """
    lines = [f'format = "{_FORMAT}"', f"version = {_VERSION}", f"name = {toml_text(recipe.name)}"]
    if recipe.scan_sha256:
        lines.append(f"scan_sha256 = {toml_text(recipe.scan_sha256)}")
    for entry in recipe.entries:
        lines += ["", "[[edit]]", f"do = {toml_text(name_of(type(entry.edit)))}"]
        lines += [] if entry.on else ["on = false"]
        lines += [f"accept = {_toml_value(entry.accept)}"] if entry.accept else []
        for field in fields(entry.edit):
            value = getattr(entry.edit, field.name)
            if value is not None:
                lines.append(f"{field.name} = {_toml_value(value)}")
    return ("\n".join(lines) + "\n").encode()


def _renamed_from_version_1(part: Any) -> Any:
    """An edit of version 1 under the word that means today what its own meant then."""
    if not isinstance(part, dict):
        return part
    tree = cast(dict[str, Any], part)
    kind = tree.get("do")
    return {**tree, "do": _BEFORE.get(kind, kind)} if isinstance(kind, str) else tree


def _rename_notes(parts: list[Any]) -> tuple[Finding, ...]:
    """Notes for a reader of a file of version 1 about renamed edits."""
    kinds = [cast(dict[str, Any], part).get("do") for part in parts if isinstance(part, dict)]
    numbers = tuple(number for number, kind in enumerate(kinds, start=1) if kind == _MISREAD)
    if not numbers:
        return ()
    return (doubt("recipe.relief_was_load", count=len(numbers), numbers=numbers),)


def _entry_of_tree(part: Any, what: str) -> Entry:
    if not isinstance(part, dict):
        raise OptionsError("recipe.file.entry", what=what)
    tree = dict(cast(dict[str, Any], part))
    kind, on = tree.pop("do", ""), tree.pop("on", True)
    if not isinstance(on, bool):
        raise OptionsError("recipe.file.switch", what=what)
    try:
        accept = any_value_of(tree.pop("accept", []), tuple[str, ...], f"{what}: accept")
    except Mismatch as error:
        raise OptionsError("recipe.mismatch", reason=str(error)) from error
    words = plain_words(accept, what)
    return Entry(edit=make_edit(str(kind), tree, what), on=on, accept=words)


def _place_error_hint(tree: object, hint: Any, at: str) -> object:
    """Where an edit takes a place: what belongs there, in words that say what places are."""
    if str in get_args(hint) and not isinstance(tree, str | list | tuple):
        raise Mismatch(f"{at} must be a landmark's name in quotes, or [x, y, z], not {tree!r:.60}")
    return NotImplemented


_STRICTNESS = Strictness(
    below=1e6, special=_place_error_hint, limits=False
)  # see editing.require_valid


def _toml_value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return toml_text(value)
    if isinstance(value, tuple):
        return f"[{', '.join(_toml_value(part) for part in cast(tuple[Any, ...], value))}]"
    return repr(value)


def toml_text(value: str) -> str:
    """A text in quotes; control characters escaped as TOML asks."""
    plain = value.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c >= " " and c != "\x7f" else f"\\u{ord(c):04x}" for c in plain) + '"'
