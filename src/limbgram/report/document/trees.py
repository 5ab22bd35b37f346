"""Trees: the JSON that reports keep, for those who write it and those who only read it."""

import math
from typing import Any

ACCURACY_SCHEMA = "limbgram-accuracy/1"
"""Kind of an accuracy.json: records of shapes read it without the part that makes it."""


def finite(tree: Any) -> Any:
    """The same tree with None for what JSON has no number for."""
    match tree:
        case dict():
            return {name: finite(item) for name, item in tree.items()}
        case list() | tuple():
            return [finite(item) for item in tree]
        case float():
            return tree if math.isfinite(tree) else None
        case _:
            return tree
