"""Request fields: what a dataclass says of its own fields, for every door that asks for them.

A request or an edit is a frozen dataclass: annotation and default say what may be given, the text
under a field what it means, `Within` between what a number lies, `Usual` what is taken where None
leaves it to others, `Flag` how the command line calls it where that is shorter, `Text` how it is
written as a text, `Panel` the heading under which help shows a field where there are many.
Command-line options, forms of the app, help and the checks of files are made of these; nothing is
written twice.

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


@dataclass(frozen=True)
class Within:
    """Between what a number may lie; both ends belong to it."""

    least: float
    most: float
    above: bool = False
    """The least itself does not belong to it: 0 mm is no length."""

    __is_annotated_types_grouped_metadata__: ClassVar[Literal[True]] = True

    def __iter__(self) -> Iterator[Any]:
        """What pydantic checks by, where the app takes the dataclass as a request's body."""
        from annotated_types import Ge, Gt, Le

        return iter((Gt(self.least) if self.above else Ge(self.least), Le(self.most)))

    def holds(self, value: float) -> bool:
        return self.least <= value <= self.most and not (  # NaN is not
            self.above and value == self.least
        )


@dataclass(frozen=True)
class Usual:
    """What is taken where a field is None and neither a file nor a preset says it."""

    value: int | float


@dataclass(frozen=True)
class Flag:
    """What the command line calls a field."""

    name: str


@dataclass(frozen=True)
class Text:
    """How a value that is more than a number or a word is written on the command line and in files.

    A body of JSON has its parts as they are.
    """

    read: Callable[[str, str], Any]
    """Of a text, and of what it was given as: the option, or the place in a file."""
    write: Callable[[Any], str] = str
    """As it is read again."""


@dataclass(frozen=True)
class AtMost:
    """How many of them may come over the network."""

    count: int

    __is_annotated_types_grouped_metadata__: ClassVar[Literal[True]] = True

    def __iter__(self) -> Iterator[Any]:
        """What pydantic checks by."""
        from annotated_types import MaxLen

        return iter((MaxLen(self.count),))


@dataclass(frozen=True)
class Panel:
    """The heading under which a field is shown."""

    title: str


@dataclass(frozen=True, kw_only=True)
class Declared:
    """One field of a dataclass, for people and for doors."""

    name: str
    hint: Any
    """Its type without what is said beside it, and without None."""
    optional: bool
    """None is one of its values."""
    default: Any
    """MISSING where one has to be given."""
    meaning: str
    """The text under the field."""
    within: Within | None
    usual: int | float | None
    """Taken where it is None and nothing else says it."""
    text: Text | None
    flag: str
    """On the command line, without the two dashes."""
    panel: str | None
    """The heading that it stands under; None where there is none."""

    @property
    def required(self) -> bool:
        return self.default is MISSING

    @property
    def unit(self) -> str:
        """By the ending of its name; empty where it has none."""
        return next((unit for ending, unit in _UNITS.items() if self.name.endswith(ending)), "")

    @property
    def several(self) -> bool:
        """Any number of one kind."""
        return get_origin(self.hint) is tuple and get_args(self.hint)[1:] == (...,)

    @property
    def choices(self) -> tuple[str, ...]:
        """The words to choose from; empty where any are."""
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
    """What a dataclass is for: the first paragraph of its docstring, in one line."""
    return " ".join(inspect.cleandoc(kind.__doc__ or "").split("\n\n")[0].split())


def words_of(request: Any) -> list[str]:
    """A request as it is typed on the command line; what has its default is not typed."""
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
    """A type without what is said beside it."""
    return get_args(hint)[0] if get_origin(hint) is Annotated else hint


def within_of(hint: Any) -> Within | None:
    """The limits that stand beside a type."""
    return next((one for one in _beside(hint) if isinstance(one, Within)), None)


def text_of(hint: Any) -> Text | None:
    """How it is written as a text, where that stands beside a type."""
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
    """The type of each of several."""
    return get_args(hint)[0] if get_origin(hint) is tuple else hint


def _default(field: Any) -> Any:
    return field.default if field.default_factory is MISSING else field.default_factory()


def _meanings(kind: type) -> dict[str, str]:
    """What the source says under each field, its own and those that it inherits."""
    meanings: dict[str, str] = {}
    for made in reversed(kind.__mro__):
        if "__dataclass_fields__" in vars(made):
            meanings |= _under_fields(made)
    return meanings


def _under_fields(kind: type) -> dict[str, str]:
    source = textwrap.dedent(inspect.getsource(kind))
    body = cast(ast.ClassDef, ast.parse(source).body[0]).body
    meanings: dict[str, str] = {}
    for line, below in pairwise(body):
        if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name):
            text = below.value if isinstance(below, ast.Expr) else None
            if isinstance(text, ast.Constant):
                meanings[line.target.id] = " ".join(str(text.value).split())
    return meanings
