"""Replies: the answer of a command, for people or as JSON, and its exit code."""

import inspect
import json
import os
import signal
import sys
import threading
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import wraps
from typing import Any, ParamSpec, cast, get_args

import typer
from rich.console import Console
from rich.text import Text
from typer.models import OptionInfo

from limbgram.core.errors import (
    RED_EXIT_CODE,
    Cancelled,
    CaseError,
    LimbgramError,
    OptionsError,
    disk_finding,
    printable,
)
from limbgram.findings import LANGUAGES, Finding, advice, sentence, told

P = ParamSpec("P")

_SMALLEST, _LARGEST = 1e-9, 1e9
"""Magnitudes of numbers that options accept besides 0."""
_COLOURS = {"green": "green", "amber": "yellow", "red": "bold red"}


@dataclass(frozen=True)
class Reply:
    """The answer of a command."""

    lines: tuple[str, ...]
    """For people."""
    content: Any
    """For machines."""
    light: str = ""
    """Green, amber or red if the first line is a verdict: its colour on a terminal. Red has its own
    exit code."""
    exit_code: int = 0
    """Exit code of an answer that is not red."""


def answered(command: Callable[P, Reply | None]) -> Callable[P, None]:
    """Make a command print its reply, or its refusal without a traceback, and exit by its code.

    An OSError that reaches this place is a refusal too. With `as_json` standard output is one JSON
    document. A command that only has sub-commands returns None.
    """

    @wraps(command)
    def answer(*args: P.args, **kwargs: P.kwargs) -> None:
        as_json = bool(kwargs.get("as_json", False))
        try:
            _require_measures(kwargs, command)
            with _sigterm_as_ctrl_c():
                reply = _run(command, *args, **kwargs)
        except LimbgramError as error:
            _refuse(error, as_json)
            raise typer.Exit(error.exit_code) from error
        except KeyboardInterrupt:
            stopped = Cancelled("job.command_stopped")
            _refuse(stopped, as_json)
            raise typer.Exit(stopped.exit_code) from None
        if reply is None:
            return
        if as_json:
            sys.stdout.write(json.dumps(reply.content, indent=1, allow_nan=False) + "\n")
        else:
            _say(reply)
        if reply.light == "red":
            raise typer.Exit(RED_EXIT_CODE)
        if reply.exit_code:
            raise typer.Exit(reply.exit_code)

    answer.__annotations__ = {**command.__annotations__, "return": None}
    return answer


@contextmanager
def _sigterm_as_ctrl_c() -> Generator[None]:
    """SIGTERM raises KeyboardInterrupt, as Ctrl-C does."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _require_measures(options: Mapping[str, object], command: Callable[..., object]) -> None:
    """Refuse numbers that are no measure but that typer accepts: inf, nan, 1e400, 1e-308.

    Raises:
        OptionsError: there is such a number.
    """
    for name, value in options.items():
        for number in cast(list[object], value) if isinstance(value, list) else [value]:
            if isinstance(number, float) and number and not _SMALLEST <= abs(number) <= _LARGEST:
                raise OptionsError(
                    "options.no_measure", option=_flag(command, name), number=f"{number:g}"
                )


def _flag(command: Callable[..., object], name: str) -> str:
    """The option's name on the command line, without the two dashes.

    In an `Annotated` type, typer keeps the first name of an option as its default.
    """
    beside = get_args(inspect.signature(command).parameters[name].annotation)[1:]
    options = [one for one in beside if isinstance(one, OptionInfo)]
    flags = [str(flag) for one in options for flag in (one.default, *(one.param_decls or ()))]
    long = (flag[2:] for flag in flags if flag.startswith("--"))
    return next(long, name.replace("_", "-"))


def _run(command: Callable[P, Reply | None], *args: P.args, **kwargs: P.kwargs) -> Reply | None:
    try:
        return command(*args, **kwargs)
    except OSError as error:
        if error.errno is None:  # not from the system: a bug of ours
            raise
        raise CaseError.of(disk_finding(error)) from error


def _say(reply: Reply) -> None:
    console = Console(highlight=False, soft_wrap=True)
    for idx, line in enumerate(reply.lines):
        colour = _COLOURS.get(reply.light, "") if idx == 0 else ""
        console.print(Text(printable(line), style=colour))


def spoken(finding: Finding) -> str:
    """A finding's sentence and advice in the language of the terminal."""
    return told(finding, language())


def advised(finding: Finding) -> str:
    """A finding of a list, its advice below it where it has any."""
    said, todo = sentence(finding, language()), advice(finding, language())
    return f"  {said}" + (f"\n    -> {todo}" if todo else "")


def language() -> str:
    """Language of the terminal, by LIMBGRAM_LANGUAGE; English by default."""
    asked = os.environ.get("LIMBGRAM_LANGUAGE", "")[:2].lower()
    return asked if asked in LANGUAGES else LANGUAGES[0]


def refuse_in_json(kind: str, message: str, exit_code: int, finding: Finding | None = None) -> None:
    """Write a refusal as a JSON document to standard output."""
    error: dict[str, Any] = {"kind": kind, "message": message}
    if finding is not None:
        error["finding"] = finding.tree()
    sys.stdout.write(json.dumps({"error": error, "exit_code": exit_code}, allow_nan=False) + "\n")


def _refuse(error: LimbgramError, as_json: bool) -> None:
    if as_json:
        refuse_in_json(type(error).__name__, str(error), error.exit_code, error.finding)
        return
    console = Console(stderr=True, highlight=False)
    colour = "yellow" if isinstance(error, Cancelled) else "red"
    text = Text(printable(spoken(error.finding)), style=colour)
    console.print(text, soft_wrap=not console.is_terminal)
