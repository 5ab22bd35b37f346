"""Notebooks: short representations of products, and conversions to optional libraries.

Arrays are shown by dtype and shape. pandas and pyvista are imported on demand; a refusal names the
missing one.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from html import escape
from importlib import import_module
from types import ModuleType
from typing import Any, cast

import numpy as np

from limbgram.core.errors import MissingError
from limbgram.core.spreadsheet import Table, heading

_DEEPEST, _MOST_ITEMS, _LONGEST_TEXT, _FEW_NUMBERS = 2, 3, 60, 4
_STYLE = "text-align:right;white-space:nowrap"


def brief(self: object) -> str:
    """Short representation of a product: `__repr__ = brief` in its class."""
    return _shown(self, 0)


def _shown(value: Any, depth: int) -> str:
    if isinstance(value, np.ndarray):
        if value.ndim == 1 and value.size <= _FEW_NUMBERS and value.dtype.kind in "fiub":
            return f"[{', '.join(f'{number:.6g}' for number in value.tolist())}]"
        return f"{value.dtype}[{' x '.join(map(str, value.shape))}]"
    if is_dataclass(value) and not isinstance(value, type):
        name = type(value).__name__
        if depth >= _DEEPEST:
            return f"{name}(...)"
        given = ((one.name, getattr(value, one.name)) for one in fields(value) if one.repr)
        shown = (f"{key}={_shown(one, depth + 1)}" for key, one in given if not _is_empty(one))
        return f"{name}({', '.join(shown)})"
    match value:
        case float():
            return f"{value:.6g}"
        case str():
            return repr(value if len(value) <= _LONGEST_TEXT else f"{value[:_LONGEST_TEXT]}...")
        case tuple() | list():
            listed = cast(Sequence[Any], value)
            if len(listed) <= _MOST_ITEMS:
                return f"({', '.join(_shown(one, depth + 1) for one in listed)})"
            return f"<{len(listed)} x {type(listed[0]).__name__}>"
        case Mapping():
            return f"<{len(cast(Mapping[Any, Any], value))} entries>"
        case _:
            text = repr(value)
            return text if len(text) <= _LONGEST_TEXT else f"{text[:_LONGEST_TEXT]}..."


def _is_empty(value: Any) -> bool:
    return value is None or (isinstance(value, tuple | list | str) and not value)


def html_of(table: Table, said: str = "") -> str:
    """The table as HTML, with a remark above it."""
    heads = "".join(f"<th>{escape(heading(name))}</th>" for name in table.columns)
    rows = "".join(
        "<tr>" + "".join(f'<td style="{_STYLE}">{_cell(one)}</td>' for one in row) + "</tr>"
        for row in table.rows
    )
    above = f"<p>{escape(said)}</p>" if said else ""
    return f"{above}<table><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>"


def _cell(cell: object) -> str:
    if cell is None:
        return ""
    return f"{cell:.1f}" if isinstance(cell, float) else escape(str(cell))


def data_frame(table: Table) -> Any:
    """The table as a pandas.DataFrame; empty cells are NaN.

    Raises:
        MissingError: pandas is not installed.
    """
    pandas = library("pandas")
    rows = [[math.nan if cell is None else cell for cell in row] for row in table.rows]
    return pandas.DataFrame(rows, columns=list(table.columns))


def library(name: str) -> ModuleType:
    """An optional library.

    Raises:
        MissingError: it is not installed; says the command that installs it.
    """
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise MissingError("library.missing", library=name) from error
