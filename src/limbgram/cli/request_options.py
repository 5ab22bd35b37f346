"""Request options: command-line options generated from the fields of requests.

    @asking
    def measure_command(shape: ShapeArgument, ask: MeasureRequest) -> Reply: ...

`asking` turns a parameter whose type is a request into one option for each of its fields, with the
field's type, default, limits and meaning, and calls the command with the request. Of several kinds
of one thing, `ask: Annotated[Export, Kinds(EXPORTS, by="to")]`, the options of all stand side by
side; the option `to` chooses the kind, and what it does not have is refused.
"""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, is_dataclass
from enum import Enum
from functools import wraps
from typing import Annotated, Any, Literal, TypeVar, cast, get_args, get_origin

import typer

from limbgram.core.errors import OptionsError
from limbgram.core.request_fields import Declared, bare, declared

R = TypeVar("R")

_NO_LIMIT = 1e9
"""Limits above this are not shown in help."""


@dataclass(frozen=True)
class Kinds:
    """Alternative request types, of which an option chooses one."""

    requests: Mapping[str, type]
    by: str
    """The command's parameter that names the kind."""

    def options(self) -> list[inspect.Parameter]:
        """The options of all kinds, each once, with the names of the kinds that have it."""
        fields: dict[str, dict[str, Declared]] = {}
        for kind, request in self.requests.items():
            for field in declared(request):
                fields.setdefault(field.name, {})[kind] = field
        return [_option(next(iter(of.values())), of) for of in fields.values()]

    def made(self, given: dict[str, Any], kind: str) -> Any:
        """The request of a kind; pops the options of all kinds from `given`.

        Raises:
            OptionsError: an option of another kind was typed, or a number beyond its limits.
        """
        every = {one.name: one for request in self.requests.values() for one in declared(request)}
        taken = {name: given.pop(name) for name in every}
        typed = {
            name: value
            for name, value in taken.items()
            if value is not None and value is not False  # 0 is typed, and equals False
        }
        request = self.requests[kind]
        others = sorted(set(typed) - {field.name for field in declared(request)})
        if others:
            having = {name for name in self.requests if others[0] in _names(self.requests[name])}
            raise OptionsError(
                "ask.other_kind",
                options=tuple(f"--{every[name].flag}" for name in others),
                kinds=tuple(name for name in self.requests if name in having),
                kind=kind,
            )
        return made(request, typed)


def asking(command: Callable[..., R]) -> Callable[..., R]:
    """Replace the request parameters of a command by options for their fields."""
    plain = inspect.signature(command)
    requests = {
        name: one.annotation
        for name, one in plain.parameters.items()
        if is_dataclass(one.annotation) or _kinds_of(one.annotation) is not None
    }
    parameters = [one for name, one in plain.parameters.items() if name not in requests]
    for request in requests.values():
        parameters += _options(request)

    @wraps(command)
    def ask(**given: Any) -> R:
        for name, request in requests.items():
            kinds = _kinds_of(request)
            if kinds is None:
                values = {field.name: given.pop(field.name) for field in declared(request)}
                given[name] = made(cast(type, request), values)
            else:
                given[name] = kinds.made(given, given[kinds.by])
        return command(**given)

    named = [one.replace(kind=inspect.Parameter.KEYWORD_ONLY) for one in parameters]
    vars(ask)["__signature__"] = plain.replace(parameters=named)
    ask.__annotations__ = {one.name: one.annotation for one in parameters}
    return ask


def made(request: Callable[..., R], given: Mapping[str, Any]) -> R:
    """A request from the options that were typed; the others have their defaults.

    Raises:
        OptionsError: a number beyond its limits, or a text that cannot be read.
    """
    values: dict[str, Any] = {}
    for field in declared(cast(type, request)):
        value = given.get(field.name)
        if value is None or value == []:
            continue
        if field.within is not None:
            _require_within(field, value)
        values[field.name] = (
            tuple(_read(field, one) for one in value) if field.several else _read(field, value)
        )
    return request(**values)


def _read(field: Declared, typed: Any) -> Any:
    if field.text is not None:
        return field.text.read(typed, f"--{field.flag}")
    return typed.value if _choices_of_each(field) else typed


def _choices_of_each(field: Declared) -> tuple[str, ...]:
    """The choices of a repeatable Literal; empty for other fields."""
    each = bare(get_args(field.hint)[0]) if field.several else None
    return get_args(each) if get_origin(each) is Literal else ()


def _kinds_of(hint: Any) -> Kinds | None:
    beside = get_args(hint)[1:] if get_origin(hint) is Annotated else ()
    return next((one for one in beside if isinstance(one, Kinds)), None)


def _names(request: type) -> set[str]:
    return {field.name for field in declared(request)}


def _require_within(field: Declared, value: Any) -> None:
    limits = field.within
    assert limits is not None
    for number in value if isinstance(value, list | tuple) else [value]:
        if not limits.holds(number):
            raise OptionsError(
                "ask.beyond_limits",
                option=f"--{field.flag}",
                value=number,
                least=limits.least,
                most=limits.most,
            )


def _options(request: Any) -> list[inspect.Parameter]:
    kinds = _kinds_of(request)
    return [_option(one) for one in declared(request)] if kinds is None else kinds.options()


def _option(field: Declared, of: Mapping[str, Declared] | None = None) -> inspect.Parameter:
    """One option; its default is None, so that the request's own default applies.

    A boolean is a flag, off by default in every request.

    Args:
        of: The same field in each kind that has it.
    """
    several, words = field.several, _choices_of_each(field)
    each = bare(get_args(field.hint)[0]) if several else field.hint
    each = each if field.text is None else str
    if words:  # typer repeats options of an Enum, not of a Literal
        each = Enum(field.name, [(one, one) for one in words])
    hint = list[each] if several else each
    meaning = _meaning_by_kind(of) if of else f"{field.meaning}{_limits(field)}"
    switch = field.hint is bool
    option = typer.Option(
        f"--{field.flag}",
        help=meaning + (" Repeatable." if several else "") + _defaults(field, of),
        show_default=False,  # it stands in the help text
        rich_help_panel=field.panel,
    )
    needed = field.required and not of
    return inspect.Parameter(
        field.name,
        inspect.Parameter.KEYWORD_ONLY,
        default=... if needed else False if switch else None,
        annotation=Annotated[hint if needed or switch else hint | None, option],
    )


def _meaning_by_kind(of: Mapping[str, Declared]) -> str:
    """What the field means, after the kinds for which it means it."""
    kinds: dict[str, list[str]] = {}
    for kind, field in of.items():
        kinds.setdefault(field.meaning, []).append(kind)
    return " ".join(f"{', '.join(named)}: {meaning}" for meaning, named in kinds.items())


def _limits(field: Declared) -> str:
    limits = field.within
    if limits is None or limits.most > _NO_LIMIT:
        return ""
    return f" From {limits.least:.12g} to {limits.most:.12g}."


def _defaults(field: Declared, of: Mapping[str, Declared] | None) -> str:
    """The default in words, by kind if the kinds differ."""
    by_kind = {kind: _default(one) for kind, one in (of or {"": field}).items()}
    if len({*by_kind.values()}) > 1:
        told = ", ".join(f"{kind} {value}" for kind, value in by_kind.items() if value)
    else:
        told = next(iter(by_kind.values()))
    return f" Default: {told}." if told else ""


def _default(field: Declared) -> str:
    value = field.default.value if isinstance(field.default, Enum) else field.default
    value = field.usual if value is None else value
    if field.hint is bool or value in (None, MISSING, (), ""):
        return ""
    return f"{value:.12g}" if isinstance(value, float) else f"{value}"
