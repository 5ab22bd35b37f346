"""Typed values from the plain trees of JSON and TOML, and such trees from typed values.

The annotations of a frozen dataclass are the schema: a tree that does not fit them is refused with
its path, such as `parameters.k1`, in words for people. Only integers are converted, to floats: no
text becomes a number, no boolean becomes 1. A field with `core.request_fields.Text` may be a text.

Why no library: of thirteen trees that must be refused, msgspec 0.22 accepts unknown names and NaN,
and it has no union of two dataclasses; pydantic 2.14 in strict mode takes no mapping for a
dataclass, and imports in 160 ms; cattrs 26.2 has no answer for `str | tuple[float, float, float]`,
and imports in 60 ms. Their messages name types of Python and not the value.
"""

import math
import types
import typing
from collections.abc import Callable, Sequence
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, Union, cast, get_args, get_origin

from limbgram.core.errors import AS_IS, LimbgramError
from limbgram.core.request_fields import Text, Within, bare, text_of, within_of
from limbgram.findings import Finding, as_json, note

T = TypeVar("T")

Special = Callable[[object, Any, str], object]
"""Reader of a type with a form of its own: (tree, type, path) to a value, or NotImplemented."""


class Mismatch(ValueError):
    """A tree does not fit the type that is to be read."""


@dataclass(frozen=True, kw_only=True)
class Strictness:
    """What is accepted, and what is checked."""

    pass_over_unknown: bool = False
    """Ignore names that the type does not have."""
    below: float = 1e300
    """Bound on the magnitude of floats."""
    special: Special | None = None
    limits: bool = True
    """Check `Within`; False if the reader of the values does so."""


STRICT = Strictness()
TOLERANT = Strictness(pass_over_unknown=True)
"""For files that a later version may have written."""


def value_of(tree: object, hint: type[T], at: str = "", strictness: Strictness = STRICT) -> T:
    """The value of a type that a tree describes.

    Args:
        at: Path of the tree, for messages; names of fields are appended.

    Raises:
        Mismatch: the tree does not fit the type; says where, what belongs there and what is there.
    """
    return cast(T, _value(tree, hint, at, strictness))


def any_value_of(tree: object, hint: Any, at: str = "", strictness: Strictness = STRICT) -> Any:
    """`value_of` for a hint that is no class: a union, a Literal, a tuple of something."""
    return _value(tree, hint, at, strictness)


def fields_of(tree: dict[str, Any], hint: type[T], at: str = "", by: Strictness = STRICT) -> T:
    """A dataclass from a mapping; fields with a default may be missing."""
    schema = _schema(hint)
    unknown = [name for name in tree if name not in schema]
    if unknown and not by.pass_over_unknown:
        names = ", ".join(unknown)
        raise Mismatch(f"{at or 'it'} has no {names:.80}. It has: {', '.join(schema)}")
    missing = [name for name in _needed(hint) if name not in tree]
    if missing:
        raise Mismatch(f"{at or 'it'} needs {', '.join(missing)}")
    read = {
        name: _value(tree[name], wanted, _place(at, name), by)
        for name, wanted in schema.items()
        if name in tree
    }
    return hint(**read)


def tree_of(value: object) -> Any:
    """Frozen dataclasses, tuples, mappings and scalars as a tree that JSON can hold.

    A field's name is its key; a finding has its sentence beside its values. NaN and infinity, which
    JSON lacks, become None.
    """
    match value:
        case None | bool() | int() | str():
            return value
        case Path():
            return str(value)
        case float():
            return value if math.isfinite(value) else None
        case Finding():
            return as_json(value)
        case dict():
            known = cast(dict[str, object], value)
            return {name: tree_of(item) for name, item in known.items()}
        case list() | tuple():
            return [tree_of(item) for item in cast(tuple[object, ...], value)]
        case _ if is_dataclass(value) and not isinstance(value, type):
            return {field.name: tree_of(getattr(value, field.name)) for field in fields(value)}
        case _:
            raise TypeError(f"{type(value).__name__} has no place in JSON")


def _value(tree: Any, hint: Any, at: str, by: Strictness) -> Any:
    limits, text, hint = within_of(hint), text_of(hint), bare(hint)
    if text is not None and isinstance(tree, str):
        return _read(text, tree, at)
    if limits is not None and by.limits:
        return _within(_value(tree, hint, at, by), limits, at)
    found = NotImplemented if by.special is None else by.special(tree, hint, at)
    if found is not NotImplemented:
        return found
    origin, parts = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        return _one_of(tree, parts, at, by)
    if origin is tuple:
        return _sequence(tree, parts, at, by)
    if hint is Finding:
        return _finding(tree, at)
    if not _may_be(tree, hint):
        raise Mismatch(f"{at or 'it'} must be {words_of_type(hint)}, not {tree!r:.60}")
    if hint is Path:
        if not isinstance(tree, str):
            raise Mismatch(f"{at or 'it'} must be {words_of_type(hint)}, not {tree!r:.60}")
        return Path(tree)
    if is_dataclass(hint) and isinstance(hint, type):
        return fields_of(cast(dict[str, Any], tree), hint, at, by)
    if hint is float:
        if not -by.below < tree < by.below:  # false for NaN
            raise Mismatch(f"{at or 'it'} must be a number within reason, not {tree!r:.60}")
        return float(tree)
    return tree


def _within(number: Any, limits: Within, at: str) -> Any:
    """A number that lies within its limits; None passes."""
    if number is not None and not limits.holds(number):
        lie = "be above" if limits.above else "lie between"
        to = "and up to" if limits.above else "and"
        raise Mismatch(
            f"{at or 'it'} must {lie} {limits.least:g} {to} {limits.most:g}, not {number:g}"
        )
    return number


def _read(text: Text, written: str, at: str) -> Any:
    try:
        return text.read(written, at)
    except LimbgramError as error:
        raise Mismatch(f"{at}: {error}") from error


def _finding(tree: object, at: str) -> Finding:
    if isinstance(tree, str):  # a sentence, as earlier versions kept it
        return note(AS_IS, message=tree)
    try:
        return Finding.from_tree(tree)
    except ValueError as error:
        raise Mismatch(f"{at or 'it'} must be a finding: {error}") from error


def _one_of(tree: Any, parts: Sequence[Any], at: str, by: Strictness) -> Any:
    """The first type of a union that fits; if only one can be meant, its own error."""
    if tree == "" and {*parts} == {Finding, types.NoneType}:  # as earlier versions wrote it
        return None
    likely = [part for part in parts if _may_be(tree, part)]
    errors: list[Mismatch] = []
    for part in likely:
        try:
            return _value(tree, part, at, by)
        except Mismatch as error:
            errors.append(error)
    if len(errors) == 1:
        raise errors[0]
    wanted = " or ".join(words_of_type(part) for part in parts if part is not types.NoneType)
    raise Mismatch(f"{at or 'it'} must be {wanted}, not {tree!r:.60}")


def _sequence(tree: Any, parts: Sequence[Any], at: str, by: Strictness) -> tuple[Any, ...]:
    if isinstance(tree, str) and parts[0] is Finding:  # a sentence, as earlier versions kept it
        tree = [tree] if tree else []
    if not isinstance(tree, list | tuple):
        raise Mismatch(f"{at or 'it'} must be a list in brackets, not {tree!r:.60}")
    items = cast(Sequence[Any], tree)
    if len(parts) == 2 and parts[1] is Ellipsis:
        parts = [parts[0]] * len(items)
    if len(items) != len(parts):
        kind = "numbers" if set(parts) <= {int, float} else "entries"
        raise Mismatch(f"{at or 'it'} must have {len(parts)} {kind}, not {len(items)}")
    return tuple(
        _value(item, part, f"{at}[{k}]", by)
        for k, (item, part) in enumerate(zip(items, parts, strict=True))
    )


def _may_be(tree: object, hint: Any) -> bool:
    """Whether a tree is of the kind that a type is written as; its content is not checked."""
    if get_origin(hint) is Literal:
        return any(type(tree) is type(one) and tree == one for one in get_args(hint))
    if get_origin(hint) is tuple:
        return isinstance(tree, list | tuple)
    if hint is Finding:
        return isinstance(tree, dict | str)
    if is_dataclass(hint):
        return isinstance(tree, dict)
    if hint is float:
        return isinstance(tree, int | float) and not isinstance(tree, bool)
    if hint in (bool, int, str, None, types.NoneType):
        return isinstance(tree, types.NoneType if hint is None else hint) and (
            hint is bool or not isinstance(tree, bool)
        )
    return True  # `special` decides


def words_of_type(hint: Any) -> str:
    """What a type is written as, for people."""
    if get_origin(hint) is Annotated:
        return words_of_type(get_args(hint)[0])
    if get_origin(hint) is Literal:
        choices = get_args(hint)
        return f"{'one of ' if len(choices) > 1 else ''}{', '.join(map(str, choices))}"
    if get_origin(hint) is tuple:
        return "a list in brackets"
    if get_origin(hint) in (Union, types.UnionType):
        parts = [part for part in get_args(hint) if part is not types.NoneType]
        return " or ".join(words_of_type(part) for part in parts)
    if is_dataclass(hint):
        return "a table"
    return _KINDS.get(hint, str(hint))


_KINDS: dict[Any, str] = {
    float: "a number",
    int: "a whole number",
    bool: "true or false",
    str: "a text",
    Path: "the name of a file",
    types.NoneType: "nothing",
}


def _place(at: str, name: str) -> str:
    return f"{at}.{name}" if at else name


@cache
def _schema(hint: type) -> dict[str, Any]:
    hints = typing.get_type_hints(hint, include_extras=True)
    return {field.name: hints[field.name] for field in fields(cast(Any, hint)) if field.init}


@cache
def _needed(hint: type) -> tuple[str, ...]:
    """Fields without a default."""
    return tuple(
        field.name
        for field in fields(cast(Any, hint))
        if field.init and field.default is MISSING and field.default_factory is MISSING
    )
