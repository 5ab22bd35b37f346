"""The glossary: every figure of an assessment with its unit and what exactly it is.

It is read off the fields of the figures: each entry is a field, so none can be without its figure.
"""

import types
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from typing import Any, Union, cast, get_args, get_origin, get_type_hints

from limbgram.report.accuracy.figures import Figures

_ORDER = (
    "expected",
    "truth",
    "surface",
    "lengths",
    "residuals",
    "network",
    "poses",
    "images",
    "movement",
)
"""What most people ask for stands first."""


@dataclass(frozen=True)
class Term:
    """One figure."""

    path: str
    """Names of the fields that lead to it, with points between."""
    title: str
    unit: str
    definition: str


@cache
def terms() -> tuple[Term, ...]:
    """Every figure that has a meaning, in the order of `_ORDER` and of the fields."""
    found = sorted(_terms(Figures, ""), key=lambda term: _ORDER.index(term.path.split(".")[0]))
    return tuple(found)


def value_at(figures: object, path: str) -> Any:
    """What a path leads to, in figures or in the tree of them; None where there is no table."""
    here = figures
    while path and here is not None:
        table = cast(Mapping[str, object], here if isinstance(here, dict) else vars(here))
        # A name may have points in it, such as "0.1 mm".
        name = next(one for one in table if f"{path}.".startswith(f"{one}."))
        here, path = table[name], path[len(name) + 1 :]
    return here


def glossary_tree() -> dict[str, Any]:
    """Title, unit and definition by path, for machines."""
    return {
        term.path: {"title": term.title, "unit": term.unit, "definition": term.definition}
        for term in terms()
    }


def _terms(table: type, before: str) -> Iterator[Term]:
    hints = get_type_hints(table)
    for field in fields(table):
        path, known = before + field.name, field.metadata
        if "title" in known:
            yield Term(path, **known)
        else:
            for name, entry in known.items():
                yield Term(f"{path}.{name}", **entry)
        below = _table(hints[field.name])
        if below is not None:
            yield from _terms(below, f"{path}.")


def _table(hint: Any) -> type | None:
    """The class of a field that is a table of its own, perhaps absent."""
    choices = get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)
    return next((one for one in choices if isinstance(one, type) and is_dataclass(one)), None)
