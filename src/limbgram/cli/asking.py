"""Asking: options of the command line made of requests, which say themselves what they take.

    @asking
    def measure_command(shape: ShapeArgument, ask: MeasureRequest) -> Reply: ...

`asking` turns each parameter whose type is a request into one option for each of its fields, with
the field's type, default, limits and meaning, and calls the command with the request. Several kinds
of one thing, such as the files that are written, are a mapping of requests: the options of all
stand side by side, and one that the chosen kind does not have is refused.
"""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import MISSING, is_dataclass
from functools import wraps
from typing import Annotated, Any, TypeVar, get_args, get_origin

import typer

from limbgram.core.declared import Declared, bare, declared
from limbgram.core.errors import OptionsError

R = TypeVar("R")


def asking(command: Callable[..., R]) -> Callable[..., R]:
    """The command with options in the place of its requests."""
    plain = inspect.signature(command)
    requests = {
        name: one.annotation
        for name, one in plain.parameters.items()
        if isinstance(one.annotation, type) and is_dataclass(one.annotation)
    }
    parameters: list[inspect.Parameter] = []
    for name, one in plain.parameters.items():
        parameters += _options(requests[name]) if name in requests else [one]

    @wraps(command)
    def ask(**given: Any) -> R:
        for name, kind in requests.items():
            values = {field.name: given.pop(field.name) for field in declared(kind)}
            given[name] = made(kind, values)
        return command(**given)

    ask.__signature__ = plain.replace(parameters=parameters)  # pyright: ignore[reportAttributeAccessIssue, reportFunctionMemberAccess]
    ask.__annotations__ = {one.name: one.annotation for one in parameters}
    return ask


def options_of_kinds(kinds: Mapping[str, type]) -> list[inspect.Parameter]:
    """The options of several requests, each once, with the names of those that have it."""
    fields: dict[str, tuple[Declared, list[str]]] = {}
    for kind, request in kinds.items():
        for field in declared(request):
            fields.setdefault(field.name, (field, []))[1].append(kind)
    return [_option(field, ", ".join(of)) for field, of in fields.values()]


def chosen(kinds: Mapping[str, type[R]], kind: str, given: Mapping[str, Any]) -> R:
    """The request of a kind from the options that were typed.

    Raises:
        OptionsError: an option of another kind was typed, or a number beyond its limits.
    """
    typed = {name: value for name, value in given.items() if value is not None}
    own = {field.name for field in declared(kinds[kind])}
    others = [name for name in typed if name not in own]
    if others:
        flags = {field.name: field.flag for one in kinds.values() for field in declared(one)}
        having = [one for one in kinds if set(others) & {f.name for f in declared(kinds[one])}]
        raise OptionsError(
            "ask.other_kind",
            options=tuple(f"--{flags[name]}" for name in others),
            kinds=tuple(having),
            kind=kind,
        )
    return made(kinds[kind], typed)


def made(request: type[R], given: Mapping[str, Any]) -> R:
    """A request from the options that were typed; what was not typed has its default.

    Raises:
        OptionsError: a number beyond its limits.
    """
    values: dict[str, Any] = {}
    for field in declared(request):
        value = given.get(field.name)
        if value is None:
            continue
        values[field.name] = tuple(value) if isinstance(value, list) else value
        if field.within is not None:
            _require_within(field, value)
    return request(**values)


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


def _options(request: type) -> list[inspect.Parameter]:
    return [_option(field) for field in declared(request)]


def _option(field: Declared, of: str = "") -> inspect.Parameter:
    """One option: None where nothing is typed, so that the request's own default stands."""
    several = get_origin(field.hint) is tuple
    hint = list[bare(get_args(field.hint)[0])] if several else field.hint
    meaning = f"{of}: {field.meaning}" if of else field.meaning
    known = field.default not in (None, MISSING, ()) and field.hint is not bool
    option = typer.Option(
        f"--{field.flag}",
        help=meaning if not several else f"{meaning} Repeatable.",
        show_default=str(field.default) if known else False,
    )
    default = ... if field.required and not of else None
    return inspect.Parameter(
        field.name,
        inspect.Parameter.KEYWORD_ONLY,
        default=default,
        annotation=Annotated[hint if default is ... else hint | None, option],
    )
