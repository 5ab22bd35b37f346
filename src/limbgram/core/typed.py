"""Typed values and the plain trees that JSON is made of."""

import math
from dataclasses import fields, is_dataclass
from typing import Any, cast


def tree_of(value: object) -> Any:
    """Frozen dataclasses, tuples, mappings and scalars as a tree that JSON can hold.

    A field's name is its key. Where JSON has no number, for what is not known or infinite, the tree
    has None.
    """
    match value:
        case None | bool() | int() | str():
            return value
        case float():
            return value if math.isfinite(value) else None
        case dict():
            known = cast(dict[str, object], value)
            return {name: tree_of(item) for name, item in known.items()}
        case list() | tuple():
            return [tree_of(item) for item in cast(tuple[object, ...], value)]
        case _ if is_dataclass(value) and not isinstance(value, type):
            return {field.name: tree_of(getattr(value, field.name)) for field in fields(value)}
        case _:
            raise TypeError(f"{type(value).__name__} has no place in JSON")
