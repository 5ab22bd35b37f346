"""Encoding: products of stages as JSON trees with their arrays beside them, and sealed records.

A product is a frozen dataclass of arrays, scalars, strings, paths, None, tuples and other
dataclasses. The type annotations are the schema (`core.typed`): what does not fit is not read.

    dataclass   {"is": name, field: tree, ...}      tuple   [tree, ...]
    array       {"array": index}                    path    {"path": text}
    finding     {"code": ..., "gravity": ..., "values": ...}
    NaN, inf    {"float": "nan"}                    the rest as JSON has it

A seal is the hash of a record's own text, kept in it, so that a changed figure is noticed. It
guards against damage and against editing by hand, not against forgery: whoever can write the file
can seal it again.
"""

import hashlib
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
from jaxtyping import AbstractArray

from limbgram.core.typed import Mismatch, Strictness, any_value_of, fields_of, value_of
from limbgram.findings import Finding

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
            return [to_tree(item, arrays, path_text) for item in cast(tuple[object, ...], value)]
        case Finding():
            return value.tree()
        case _ if is_dataclass(value) and not isinstance(value, type):
            named = {f.name: getattr(value, f.name) for f in fields(value) if f.init}
            tree = {name: to_tree(item, arrays, path_text) for name, item in named.items()}
            return {"is": type(value).__name__, **tree}
        case _:
            raise TypeError(f"a product cannot hold {type(value).__name__}: {value!r:.80}")


def from_tree(tree: Json, hint: Any, arrays: Sequence[np.ndarray], root: Path) -> Any:
    """The value of type `hint` that a tree describes; relative paths start at `root`.

    A field with a default may be missing: an earlier version did not have it.

    Raises:
        Mismatch: the tree or one of its arrays does not fit the type.
    """

    def special(tree: Any, hint: Any, at: str) -> object:
        """Values that JSON has no form for: dataclasses, arrays, paths, NaN and infinity."""
        table = cast(dict[str, Any], tree) if isinstance(tree, dict) else {}
        if isinstance(hint, type) and is_dataclass(hint) and hint is not Finding:
            if table.get("is") != hint.__name__:
                raise Mismatch(f"{at or 'it'} is no {hint.__name__}: {tree!r:.80}")
            inside = {name: item for name, item in table.items() if name != "is"}
            return fields_of(inside, hint, at, strictness)
        if hint is np.ndarray or (isinstance(hint, type) and issubclass(hint, AbstractArray)):
            return _array(table.get("array"), hint, arrays, at)
        if hint is Path:
            return root / value_of(table.get("path"), str, at)
        if hint is float and table.get("float") in ("nan", "inf", "-inf"):
            return float(table["float"])
        return NotImplemented

    strictness = Strictness(special=special)
    return any_value_of(tree, hint, strictness=strictness)


def _array(idx: object, hint: Any, arrays: Sequence[np.ndarray], at: str) -> np.ndarray:
    if type(idx) is not int or not 0 <= idx < len(arrays):
        raise Mismatch(f"{at or 'it'} is no array")
    array = arrays[idx]
    if not isinstance(array, hint):
        raise Mismatch(f"{at or 'it'} is {array.dtype} {array.shape}, no {hint}")
    return array
