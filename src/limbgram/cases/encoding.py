"""Seals: a JSON record that holds the hash of its own text, so that a changed figure is noticed.

A seal guards against damage and against editing by hand, not against forgery: whoever can write
the file can seal it again.

Encoding: any product as a JSON tree and a list of arrays, and back, checked against its type.

A product is a frozen dataclass of arrays, scalars, strings, paths, None, tuples and other
dataclasses. The type annotations are the schema: what does not fit them is not read.

    dataclass   {"is": name, field: tree, ...}      tuple   [tree, ...]
    array       {"array": index}                    path    {"path": text}
    NaN, inf    {"float": "nan"}                    the rest as JSON has it
"""

import hashlib
import json
import math
import types
import typing
from collections.abc import Callable, Sequence
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin

import numpy as np
from jaxtyping import AbstractArray

_SEAL = "seal"


def sealed(record: dict[str, Any]) -> dict[str, Any]:
    """The record with its seal."""
    text = json.dumps(record, allow_nan=False)
    return {**record, _SEAL: hashlib.sha256(text.encode()).hexdigest()}


def unsealed(record: dict[str, Any]) -> dict[str, Any]:
    """The record without its seal.

    Raises:
        LookupError: it has none, or is not what was sealed.
    """
    plain = {name: value for name, value in record.items() if name != _SEAL}
    if sealed(plain) != record:
        raise LookupError("not what was sealed")
    return plain


Json = None | bool | int | float | str | list[Any] | dict[str, Any]


class Mismatch(ValueError):
    """A tree does not fit the type that is to be read."""


def to_tree(value: object, arrays: list[np.ndarray], path_text: Callable[[Path], str]) -> Json:
    """The JSON tree of a value; its arrays are appended to `arrays`.

    Raises:
        TypeError: the value holds something that a product must not hold.
    """
    match value:
        case None | bool() | str():
            return value
        case np.ndarray():
            arrays.append(value)
            return {"array": len(arrays) - 1}
        case np.generic():
            return to_tree(value.item(), arrays, path_text)
        case int():
            return value
        case float():
            return value if math.isfinite(value) else {"float": str(value)}
        case Path():
            return {"path": path_text(value)}
        case tuple():
            return [to_tree(item, arrays, path_text) for item in typing.cast(Any, value)]
        case _ if is_dataclass(value) and not isinstance(value, type):
            named = {f.name: getattr(value, f.name) for f in fields(value) if f.init}
            tree = {name: to_tree(item, arrays, path_text) for name, item in named.items()}
            return {"is": type(value).__name__, **tree}
        case _:
            raise TypeError(f"a product cannot hold {type(value).__name__}: {value!r:.80}")


def from_tree(tree: Json, hint: Any, arrays: Sequence[np.ndarray], root: Path) -> Any:
    """The value of type `hint` that a tree describes; relative paths are taken from `root`.

    Raises:
        Mismatch: the tree or one of its arrays does not fit the type.
    """
    origin = get_origin(hint)
    if hint is Any:
        raise Mismatch("Any is no schema")
    if origin in (Union, types.UnionType):
        return _first_fit(tree, get_args(hint), arrays, root)
    if origin is Literal:
        return _require(tree, tree in get_args(hint), hint)
    if origin is tuple:
        return _read_tuple(tree, get_args(hint), arrays, root)
    if hint is np.ndarray or (isinstance(hint, type) and issubclass(hint, AbstractArray)):
        return _read_array(tree, hint, arrays)
    if is_dataclass(hint) and isinstance(hint, type):
        return _read_dataclass(tree, hint, arrays, root)
    if hint is Path:
        text = tree.get("path") if isinstance(tree, dict) else None
        return root / str(_require(text, isinstance(text, str), hint))
    return _read_scalar(tree, hint)


def _require(value: Any, fits: bool, hint: Any) -> Any:
    if not fits:
        raise Mismatch(f"{value!r:.80} is no {hint}")
    return value


def _first_fit(
    tree: Json, hints: Sequence[Any], arrays: Sequence[np.ndarray], root: Path
) -> object:
    for hint in hints:
        try:
            return from_tree(tree, hint, arrays, root)
        except Mismatch:
            continue
    raise Mismatch(f"{tree!r:.80} is none of {hints}")


def _read_tuple(
    tree: Json, hints: Sequence[Any], arrays: Sequence[np.ndarray], root: Path
) -> tuple[object, ...]:
    items = typing.cast(list[Any], _require(tree, isinstance(tree, list), tuple))
    if len(hints) == 2 and hints[1] is Ellipsis:
        hints = [hints[0]] * len(items)
    _require(tree, len(items) == len(hints), hints)
    return tuple(
        from_tree(item, hint, arrays, root) for item, hint in zip(items, hints, strict=True)
    )


def _read_array(tree: Json, hint: Any, arrays: Sequence[np.ndarray]) -> np.ndarray:
    idx = tree.get("array") if isinstance(tree, dict) else None
    if not isinstance(idx, int) or not 0 <= idx < len(arrays):
        raise Mismatch(f"{tree!r:.80} is no array")
    array = arrays[idx]
    if not isinstance(array, hint):
        raise Mismatch(f"an array of {array.dtype} {array.shape} is no {hint}")
    return array


def _read_dataclass(tree: Json, hint: Any, arrays: Sequence[np.ndarray], root: Path) -> object:
    if not isinstance(tree, dict) or tree.get("is") != hint.__name__:
        raise Mismatch(f"{tree!r:.80} is no {hint.__name__}")
    schema = _schema(hint)
    given = tree.keys() - {"is"}
    # A field that came later, with a default, is missing in what an older version kept.
    _require(sorted(tree), _needed(hint) <= given <= schema.keys(), hint)
    return hint(**{name: from_tree(tree[name], schema[name], arrays, root) for name in given})


def _read_scalar(tree: Json, hint: Any) -> object:
    if hint is float:
        if isinstance(tree, dict) and tree.get("float") in ("nan", "inf", "-inf"):
            return float(tree["float"])
        fits = isinstance(tree, int | float) and not isinstance(tree, bool)
        return float(_require(tree, fits, hint))
    if hint is None or hint is type(None):
        return _require(tree, tree is None, hint)
    if hint in (bool, int, str):
        return _require(tree, type(tree) is hint, hint)
    raise Mismatch(f"{hint} cannot be read back")


@cache
def _schema(hint: type) -> dict[str, Any]:
    hints = typing.get_type_hints(hint)
    return {f.name: hints[f.name] for f in fields(typing.cast(Any, hint)) if f.init}


@cache
def _needed(hint: type) -> frozenset[str]:
    """Fields without a default."""
    return frozenset(
        f.name
        for f in fields(typing.cast(Any, hint))
        if f.init and f.default is MISSING and f.default_factory is MISSING
    )
