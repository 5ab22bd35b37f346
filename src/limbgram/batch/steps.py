"""Steps: the commands of a batch that follow the surface (align, recipe, measure, export, report).

In      Settings of a capture, whose files are found.
Out     Steps, each the words of a `limbgram` command; and what became of one that was run.
Method  A step runs in a process of its own, so that it can be ended, and writes into a folder of
        its own. The command is the one of the terminal: its files have the same bytes.
"""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, cast

from limbgram.batch.settings import Align, ExportUse, Settings
from limbgram.batch.stopping import Stopping
from limbgram.cases.child_process import environment
from limbgram.core.errors import (
    RED_EXIT_CODE,
    Cancelled,
    LimbgramError,
    OptionsError,
    in_words,
)
from limbgram.core.files import json_of, read_content
from limbgram.core.request_fields import words_of
from limbgram.core.run import NEUTRAL_FOLDER
from limbgram.core.typed import any_value_of
from limbgram.findings import Finding
from limbgram.services.align import AlignRequest
from limbgram.services.export import FOR_CARVERS, Gcode, file_name
from limbgram.services.measure import MeasureRequest

SURFACE, SHAPE, EDITED, CASE, OUT = "{surface}", "{shape}", "{edited}", "{case}", "{out}"
"""Placeholders: the delivered surface, the current shape (the surface, or what the recipe made),
the path of the edited shape, the case, and the folder of the step. `{file0}` is the first of the
step's files. Words without paths are the same on every machine."""

StepName = Literal["align", "measure", "recipe", "export", "report"]

_COMMAND = (sys.executable, "-P", "-c", "from limbgram.cli.main import app; app()")
_MODULES: dict[StepName, str] = {
    "align": "limbgram.cli.align",
    "measure": "limbgram.cli.measure",
    "recipe": "limbgram.cli.edit",
    "export": "limbgram.cli.export",
    "report": "limbgram.cli.report",
}
_LARGEST_BYTES = 1_000_000


@dataclass(frozen=True, kw_only=True)
class Step:
    """One command that follows the surface."""

    name: str
    """Also of its folder; exports are numbered."""
    kind: StepName
    words: tuple[str, ...]
    files: tuple[Path, ...] = ()
    """Files that it reads beside the shape."""

    @property
    def module(self) -> str:
        """The module that it runs: its source is part of the step's key."""
        return _MODULES[self.kind]


@dataclass(frozen=True, kw_only=True)
class Places:
    """The paths that stand in for a step's placeholders."""

    surface: Path
    shape: Path
    edited: Path
    case: Path
    out: Path

    def filled(self, step: Step) -> tuple[str, ...]:
        named = {
            SURFACE: self.surface,
            SHAPE: self.shape,
            EDITED: self.edited,
            CASE: self.case,
            OUT: self.out,
            **{_file_word(idx): file for idx, file in enumerate(step.files)},
        }
        return tuple(_filled(word, named) for word in step.words)


@dataclass(frozen=True)
class StepReply:
    """The JSON that a command answered with."""

    content: dict[str, Any]


def steps_of(settings: Settings, name: str, located: Callable[[str], Path]) -> tuple[Step, ...]:
    """The steps in their order: align, edit, measure, export, record.

    Args:
        name: Of the capture: exported files are called by it.
        located: Finds a file that the settings name.

    Raises:
        OptionsError: a file of landmarks holds something else.
    """
    return tuple(_steps(settings, name, located))


def run_step(step: Step, places: Places, stopping: Stopping) -> StepReply:
    """Run a command to its end.

    Raises:
        LimbgramError: as the command refused it.
        StepDied: it ended without an answer.
        Cancelled: it was stopped.
    """
    process = subprocess.Popen(
        [*_COMMAND, *places.filled(step), "--json"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=NEUTRAL_FOLDER,
        env=environment(),
        start_new_session=sys.platform != "win32",
    )
    with stopping.calling(process.kill):
        try:
            output, errors = process.communicate()
        finally:
            process.kill()
    if stopping.asked:
        raise Cancelled("job.command_stopped")
    return _reply(step, process.returncode, output, errors)


class StepRefused(LimbgramError):
    """A command refused; its exit code is that of the refusal."""


class StepDied(LimbgramError):
    """A command ended without an answer."""

    exit_code = 6


def _reply(step: Step, code: int, output: bytes, errors: bytes) -> StepReply:
    try:
        content: Any = json.loads(output)
    except ValueError:
        content = None
    match content:
        case {"error": {"finding": dict(finding)}, "exit_code": int(refused)}:
            refusal = StepRefused.of(Finding.from_tree(cast(dict[str, Any], finding)))
            refusal.exit_code = refused
            raise refusal
        case {"error": {"message": str(message)}, "exit_code": int(refused)}:
            refusal = StepRefused.of(in_words(message))
            refusal.exit_code = refused
            raise refusal
        case dict() if code in (0, RED_EXIT_CODE):
            return StepReply(cast(dict[str, Any], content))
        case _:
            last = errors.decode("utf-8", "replace").strip().splitlines()[-3:]
            raise StepDied(
                "batch.step_died",
                command=step.words[0],
                code=code,
                last_lines=" / ".join(last) or None,
            )


def _steps(settings: Settings, name: str, located: Callable[[str], Path]) -> Iterator[Step]:
    if settings.align is not None:
        yield _align(settings, settings.align, located)
    if settings.recipe is not None:
        recipe = located(settings.recipe.file)
        other = ("--other-scan",) if settings.recipe.other_scan else ()
        words = ("edit", "apply", SURFACE, _file_word(0), "-o", EDITED, *other)
        yield Step(name="recipe", kind="recipe", words=words, files=(recipe,))
    if settings.measure is not None:
        yield _measure(settings.measure)
    for number, export in enumerate(settings.export or (), 1):
        yield _export(settings, export, number, name, located)
    if settings.report is not None:
        words = ("report", SHAPE, "--case", CASE, "-o", OUT, *words_of(settings.report))
        files: tuple[Path, ...] = ()
        if settings.recipe is not None:
            files = (located(settings.recipe.file),)
            words += ("--against", SURFACE, "--recipe", _file_word(0))
        yield Step(name="report", kind="report", words=words, files=files)


def _align(settings: Settings, align: Align, located: Callable[[str], Path]) -> Step:
    files: list[Path] = []
    ask = AlignRequest.of(align, settings.side or "none", settings.kind)
    words = ["align", SURFACE, *words_of(ask)]
    marks: dict[str, str] = {}
    if align.landmarks is not None:
        files.append(located(align.landmarks))
        marks = landmark_words(files[-1])
    for landmark, place in marks.items():
        words += ["--landmark", f"{landmark}={place}"]
    if align.stickers is not None:
        files.append(located(align.stickers))
        words += ["--stickers", _file_word(len(files) - 1)]
    if align.stickers is not None or any(place.startswith("#") for place in marks.values()):
        words += ["--photos", CASE]
    return Step(name="align", kind="align", words=tuple(words), files=tuple(files))


def landmark_words(path: Path) -> dict[str, str]:
    """Positions of landmarks by name, as the command line takes them.

    Raises:
        OptionsError: the file holds something else.
    """
    try:
        tree = json_of(read_content(path, _LARGEST_BYTES, OptionsError))
        if not isinstance(tree, dict):
            raise ValueError("it is no list of names with places")
        rows = cast(dict[str, Any], tree)
        return {name: _place_words(name, place) for name, place in rows.items()}
    except ValueError as error:
        raise OptionsError("batch.no_landmarks", path=str(path), why=str(error)) from error


def _place_words(name: str, place: object) -> str:
    if not name.strip() or "=" in name:
        raise ValueError(f"{name!r} is no name of a landmark")
    found = any_value_of(place, str | tuple[float, float, float], name)
    if not isinstance(found, str):
        return ",".join(repr(one) for one in found)
    if not found.startswith("#"):
        raise ValueError(f"{name} is at {found!r}, which is no place")
    return found


def _measure(ask: MeasureRequest) -> Step:
    tables = ("--xlsx", f"{OUT}/measures.xlsx", "--csv", f"{OUT}/measures.csv")
    files = (*tables, "--picture", f"{OUT}/measures.png")
    words = ("measure", SHAPE, *words_of(ask), *files)
    return Step(name="measure", kind="measure", words=words)


def _export(
    settings: Settings, export: ExportUse, number: int, name: str, located: Callable[[str], Path]
) -> Step:
    side = settings.side or "none"
    words = ["export", SHAPE, "--to", export.to, "-o", f"{OUT}/{file_name(name, export.to, side)}"]
    words += _option("--side", settings.side if export.to in FOR_CARVERS else None)
    ask, files = export.ask, ()
    if isinstance(ask, Gcode) and export.machine is not None:
        ask, files = replace(ask, machine=None), (located(export.machine),)
        words += ["--machine", _file_word(0)]
    words += words_of(ask)
    folder = f"export-{number}-{export.to}"
    return Step(name=folder, kind="export", words=tuple(words), files=files)


def _option(name: str, value: str | None) -> tuple[str, ...]:
    return () if value is None else (f"{name}={value}",)


def _file_word(idx: int) -> str:
    return f"{{file{idx}}}"


def _filled(word: str, named: dict[str, Path]) -> str:
    """The word with its placeholder replaced: all of it, or what stands before its first slash.

    Elsewhere a placeholder's text may be part of a capture's name.
    """
    head, slash, rest = word.partition("/")
    return f"{named[head]}{slash}{rest}" if head in named else word
