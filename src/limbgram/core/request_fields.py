"""Request fields: the fields of a request, described once for command line, app, files and help.

A request or an edit is a frozen dataclass: annotation and default say what may be given, and the
docstring under a field what it means. Beside the type may stand `Within` (limits), `Usual` (the
value used for None), `Flag` (a shorter name on the command line), `Text` (how the value is written
as a text) and `Panel` (the heading in help).

    spacing_mm: Annotated[float, Within(0.1, 50), Flag("spacing")] = 2.0
    \"\"\"Between slices.\"\"\"
"""

import ast
import inspect
import textwrap
import types
import typing
from collections.abc import Callable, Iterator
from dataclasses import MISSING, dataclass, fields
from functools import cache
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, Union, cast, get_args, get_origin

from limbgram.core.syntax import PARSING


@dataclass(frozen=True)
class Within:
    """Limits of a number, both included."""

    least: float
    most: float
    above: bool = False
    """The least is excluded: 0 mm is no length."""

    __is_annotated_types_grouped_metadata__: ClassVar[Literal[True]] = True

    def __iter__(self) -> Iterator[Any]:
        """The constraints for pydantic, if the dataclass is a body of the app."""
        from annotated_types import Ge, Gt, Le

        return iter((Gt(self.least) if self.above else Ge(self.least), Le(self.most)))

    def holds(self, value: float) -> bool:
        return self.least <= value <= self.most and not (  # false for NaN
            self.above and value == self.least
        )


@dataclass(frozen=True)
class Usual:
    """The value used if a field is None and neither a file nor a preset gives it."""

    value: int | float


@dataclass(frozen=True)
class Flag:
    """Name of a field on the command line."""

    name: str


@dataclass(frozen=True)
class Text:
    """Text form of a structured value, for the command line and files; JSON has its parts."""

    read: Callable[[str, str], Any]
    """From a text and where it stands: the option, or the path in a file."""
    write: Callable[[Any], str] = str
    """Inverse of `read`."""


@dataclass(frozen=True)
class AtMost:
    """Largest length of a list in a body of the app."""

    count: int

    __is_annotated_types_grouped_metadata__: ClassVar[Literal[True]] = True

    def __iter__(self) -> Iterator[Any]:
        """The constraint for pydantic."""
        from annotated_types import MaxLen

        return iter((MaxLen(self.count),))


@dataclass(frozen=True)
class Panel:
    """Heading under which help shows a field."""

    title: str


@dataclass(frozen=True, kw_only=True)
class Declared:
    """One field of a request, with all that is declared of it."""

    name: str
    hint: Any
    """Its type without `Annotated` and None."""
    optional: bool
    """Whether it may be None."""
    default: Any
    """MISSING if it is required."""
    meaning: str
    """The docstring under the field."""
    within: Within | None
    usual: int | float | None
    """See `Usual`."""
    text: Text | None
    flag: str
    """Name on the command line, without the two dashes."""
    panel: str | None

    @property
    def required(self) -> bool:
        return self.default is MISSING

    @property
    def unit(self) -> str:
        """Its unit, by the ending of its name; empty if it has none."""
        return next((unit for ending, unit in _UNITS.items() if self.name.endswith(ending)), "")

    @property
    def several(self) -> bool:
        """Whether it is a tuple of any length."""
        return get_origin(self.hint) is tuple and get_args(self.hint)[1:] == (...,)

    @property
    def choices(self) -> tuple[str, ...]:
        """The values of a Literal; empty for other types."""
        return get_args(self.hint) if get_origin(self.hint) is Literal else ()


_UNITS = {
    "_mm_min": "mm/min",
    "_deg_min": "deg/min",
    "_mm": "mm",
    "_deg": "deg",
    "_px": "px",
    "_rpm": "rpm",
    "_s": "s",
    "_gb": "GB",
    "per_cent": "%",
}


@cache
def declared(kind: type) -> tuple[Declared, ...]:
    """The fields of a dataclass in their order."""
    hints = typing.get_type_hints(kind, include_extras=True)
    meanings = _meanings(kind)
    return tuple(
        _declared(one.name, hints[one.name], _default(one), meanings.get(one.name, ""))
        for one in fields(kind)
        if one.init
    )


def purpose_of(kind: type) -> str:
    """The first paragraph of a dataclass's docstring, in one line."""
    return " ".join(inspect.cleandoc(kind.__doc__ or "").split("\n\n")[0].split())


def words_of(request: Any) -> list[str]:
    """A request as command-line options, without those at their defaults."""
    words: list[str] = []
    for field in declared(type(request)):
        value = getattr(request, field.name)
        if value == field.default:
            continue
        if field.hint is bool:
            words.append(f"--{field.flag}")
        else:
            several = cast(tuple[Any, ...], value) if field.several else (value,)
            written = str if field.text is None else field.text.write
            words += [f"--{field.flag}={written(one)}" for one in several]
    return words


def bare(hint: Any) -> Any:
    """A type without `Annotated`."""
    return get_args(hint)[0] if get_origin(hint) is Annotated else hint


def within_of(hint: Any) -> Within | None:
    """The `Within` of an annotated type."""
    return next((one for one in _beside(hint) if isinstance(one, Within)), None)


def text_of(hint: Any) -> Text | None:
    """The `Text` of an annotated type."""
    return next((one for one in _beside(hint) if isinstance(one, Text)), None)


def _beside(hint: Any) -> tuple[Any, ...]:
    return get_args(hint)[1:] if get_origin(hint) is Annotated else ()


def _declared(name: str, hint: Any, default: Any, meaning: str) -> Declared:
    plain, optional = _without_none(bare(hint))
    flag = next(
        (one.name for one in _beside(hint) if isinstance(one, Flag)), name.replace("_", "-")
    )
    return Declared(
        name=name,
        hint=plain,
        optional=optional,
        default=default,
        meaning=meaning,
        within=within_of(_each(plain)) or within_of(hint),
        usual=next((one.value for one in _beside(hint) if isinstance(one, Usual)), None),
        text=text_of(_each(plain)) or text_of(hint),
        flag=flag,
        panel=next((one.title for one in _beside(hint) if isinstance(one, Panel)), None),
    )


def _without_none(hint: Any) -> tuple[Any, bool]:
    if get_origin(hint) not in (Union, types.UnionType):
        return hint, False
    others = [part for part in get_args(hint) if part is not types.NoneType]
    plain = others[0] if len(others) == 1 else hint
    return plain, len(others) < len(get_args(hint))


def _each(hint: Any) -> Any:
    """The element type of a tuple; other types as they are."""
    return get_args(hint)[0] if get_origin(hint) is tuple else hint


def _default(field: Any) -> Any:
    return field.default if field.default_factory is MISSING else field.default_factory()


def _meanings(kind: type) -> dict[str, str]:
    """The docstrings under the fields, inherited ones included, from the source."""
    meanings: dict[str, str] = {}
    for made in reversed(kind.__mro__):
        if "__dataclass_fields__" in vars(made):
            meanings |= _under_fields(made)
    return meanings


def _under_fields(kind: type) -> dict[str, str]:
    with PARSING:
        source = textwrap.dedent(inspect.getsource(kind))
        body = cast(ast.ClassDef, ast.parse(source).body[0]).body
    meanings: dict[str, str] = {}
    for line, below in pairwise(body):
        if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name):
            text = below.value if isinstance(below, ast.Expr) else None
            if isinstance(text, ast.Constant):
                meanings[line.target.id] = " ".join(str(text.value).split())
    return meanings
