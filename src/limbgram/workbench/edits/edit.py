"""An edit: one adjustment of a limb, and all that recipes, the ledger and the help know of it.

A kind of edit is a frozen dataclass with the attributes below. Its docstring says what it does, and
the text under each parameter what that means: the command line prints both. Recipes call the kind
by its class in small letters: PlaneCut is "plane-cut".
"""

import ast
import inspect
import re
from collections.abc import Iterator
from dataclasses import MISSING, Field, dataclass, fields
from itertools import pairwise
from typing import Any, ClassVar, Literal, Protocol, cast, get_type_hints

from limbgram.core.errors import EditError
from limbgram.workbench.limb import Limb

_LONGEST_MM = 2000.0
"""No limb is longer, and nothing on it is."""


@dataclass(frozen=True, kw_only=True)
class Effect:
    """What the ledger has to know of what an edit does to a positive."""

    moves_skin: bool = False
    """Where that carves in over what bears no pressure, the ledger says so."""
    reports_displacement: bool = True
    """The ledger says how far the surface moved. That means nothing where all of it moved, or where
    parts were only added or taken away."""
    start: Literal["stays", "follows", "anew"] = "stays"
    """The skin from which depths count: it stays, the edit is done to it too, or it is what the
    edit made."""


class Edit(Protocol):
    """A kind of edit, with its parameters."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]
    title: ClassVar[str]
    """What messages call it."""
    effect: ClassVar[Effect]

    def check(self) -> None:
        """Refuse numbers that make sense on no limb, before there is one.

        Raises:
            EditError: says what is out of its range.
        """
        ...

    def apply(self, limb: Limb) -> Limb:
        """The limb after the edit, whose numbers have been checked; see `editing.do_edit`.

        Raises:
            EditError: the edit makes no sense on this limb, or would spoil its surface.
        """
        ...


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter of a kind of edit, for people."""

    name: str
    expected: str
    """Its type and its default."""
    meaning: str


def name_of(kind: type[Edit]) -> str:
    """The name by which recipes call it."""
    return re.sub(r"(?<!^)([A-Z])", r"-\1", kind.__name__).lower()


def purpose_of(kind: type[Edit]) -> str:
    """What it does, in a line."""
    return " ".join((kind.__doc__ or "").split())


def parameters_of(kind: type[Edit]) -> tuple[Parameter, ...]:
    """Its parameters in order, each with what its source says under it."""
    hints, meanings = get_type_hints(kind), _meanings(kind)
    return tuple(
        Parameter(
            name=one.name,
            expected=_expected(hints[one.name], one.default),
            meaning=meanings.get(one.name, ""),
        )
        for one in fields(kind)
    )


def require_lengths(edit: Edit) -> None:
    """Refuse lengths that no limb has.

    Raises:
        EditError: says which.
    """
    for name, length_mm in _lengths_mm(edit):
        if not abs(length_mm) <= _LONGEST_MM:
            raise EditError(
                "edit.longer_than_limb", what=edit.title, name=name, length_mm=length_mm
            )


def _expected(hint: Any, default: object) -> str:
    kind = hint.__name__ if isinstance(hint, type) else str(hint).replace("typing.", "")
    return kind if default is MISSING else f"{kind}, else {default!r}"


def _meanings(kind: type[Edit]) -> dict[str, str]:
    """What the source says under each parameter."""
    body = cast(ast.ClassDef, ast.parse(inspect.getsource(kind)).body[0]).body
    meanings: dict[str, str] = {}
    for line, below in pairwise(body):
        if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name):
            text = below.value if isinstance(below, ast.Expr) else None
            if isinstance(text, ast.Constant):
                meanings[line.target.id] = " ".join(str(text.value).split())
    return meanings


def _lengths_mm(edit: Edit) -> Iterator[tuple[str, float]]:
    """Names and values of all that is given in millimetres, without places."""
    for field in fields(edit):
        if field.name.endswith("_mm"):
            value: float | tuple[float, ...] | None = getattr(edit, field.name)
            several = value if isinstance(value, tuple) else () if value is None else (value,)
            yield from ((field.name, number) for number in several)
