"""The command `limbgram`: one file a command; each parses, calls one function, replies.

A command's file is imported when it is called, so the list of commands comes at once.
"""

import logging
import os
import sys
from collections.abc import Generator, Sequence
from contextlib import chdir, contextmanager
from importlib import import_module
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from importlib.util import spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any, cast

import typer
from typer.core import TyperGroup
from typer.main import get_command

from limbgram.cli.replies import refuse_in_json
from limbgram.core.errors import printable
from limbgram.core.run import NEUTRAL_FOLDER, garbage_collection_paused

_HELP = """From photographs taken round a limb to its surface in millimetres.

1. `limbgram print kit -o kit`; then again with `--measured-mm` and what a ruler reads on the print
2. `limbgram calibrate BOARD_PHOTOS --board kit/checkerboard.json -o camera.json`
3. `limbgram reconstruct PHOTOS --camera camera.json --board kit/scale-board.json -o CASE`
4. open CASE/report.html; the files for other programs lie in CASE/deliverables

No photos at hand? `limbgram demo` makes some and goes all the way. `limbgram app` does the whole
work in a browser.

**Exit codes**

- **0**: done
- **1**: a bug of ours: please report the traceback
- **2**: an option cannot be used
- **3**: photos, a shape, a camera file or a case folder cannot be read, or the case not written
- **4**: photos or shape cannot give the answer: the message says why and what to do
- **5**: a file could not be written and verified
- **6**: the system or a library ended the program; the same command continues
- **7**: done, and the verdict is RED: files are written and named so (surface-RED.stl); make
  nothing from them unchecked. GREEN and AMBER end with 0. Also: a kit that failed its test, a
  `check` that did not answer GO, and a log of the app that is not as it was written
- **8**: the test of a kit could neither be passed nor failed
- **130**: stopped by Ctrl-C or SIGTERM; the same command continues

With `LIMBGRAM_LANGUAGE=de` in the environment, refusals, notes and findings are told in German;
tables, labels and the summary of `reconstruct` stay English. JSON has codes, values and English.
"""

COMMANDS = {
    "app": (
        "app:app_command",
        "Open the app in the browser: photos go in, a checked shape and its files come out.",
    ),
    "reconstruct": (
        "reconstruct:reconstruct_command",
        "Make the surface of a limb, in millimetres, from photos taken round it.",
    ),
    "batch": (
        "batch:batch_command",
        "Reconstruct a folder of captures: a case, measures and files of each, and one table.",
    ),
    "accuracy": (
        "accuracy:accuracy_command",
        "Say how accurate a finished case is: one page, a PDF of two pages, and JSON.",
    ),
    "check": (
        "check:check_command",
        "Say within a minute whether a capture is good, or which photos to add and from where.",
    ),
    "plan": (
        "plan:plan_command",
        "Plan a capture: number of photos, heights, distance, aperture, size of the paint.",
    ),
    "frames": (
        "frames:frames_command",
        "Take the sharp, well-spread frames out of a video, and say why each was taken or not.",
    ),
    "masks": (
        "masks:masks_command",
        "Write a case's masks, what it took for the limb in each photo, to correct and use again.",
    ),
    "undistort": (
        "undistort:undistort_command",
        "Write a case's photos without distortion, with a COLMAP model of pinhole cameras.",
    ),
    "calibrate": (
        "calibrate:calibrate_command",
        "Find the lens of a camera from photos of a flat board at different angles.",
    ),
    "verify-setup": (
        "verify_setup:verify_setup_command",
        "Prove your own kit: camera, board, room and hands, on an artefact of known size.",
    ),
    "print": (
        "print_sheets:print_command",
        "Make sheets to print at true size, and files that keep their measured sizes.",
    ),
    "demo": (
        "demo:demo_command",
        "Photograph a synthetic limb, calibrate, reconstruct, and compare with the truth.",
    ),
    "make-capture": (
        "make_capture:make_capture_command",
        "Make photos of a painted limb, photos of a calibration board, and the exact truth.",
    ),
    "warm-up": (
        "warm_up:warm_up_command",
        "Compile the fast parts once, so that the first capture does not wait for it.",
    ),
    "align": (
        "align:align_command",
        "Give a shape its axes: +Z proximal, +Y anterior, +X the patient's right, origin distal.",
    ),
    "measure": (
        "measure:measure_command",
        "Measure a shape by level: girth as a taut tape and along the contour, widths, area, "
        "volume.",
    ),
    "compare": (
        "compare:compare_command",
        "Compare shapes: where they differ, by how much, and whether it matters for the fit.",
    ),
    "trend": (
        "trend:trend_command",
        "Follow a limb's measuring sheet over visits: what changed, by how much, and how surely.",
    ),
    "export": (
        "export:export_command",
        "Write a shape for other programs and machines, in millimetres, and read the file back.",
    ),
    "report": (
        "report:report_command",
        "Write the record of a shape: one page, a PDF of two sheets, and JSON.",
    ),
    "edit": (
        "edit:edit_app",
        "Adjust a shape by a recipe: a readable file with an ordered list of edits.",
    ),
    "device": (
        "device:device_command",
        "Make an orthosis or a socket on an aligned limb: one closed solid, read back and proved.",
    ),
    "template": (
        "template:template_app",
        "Keep a rectification as a template and apply it to other limbs.",
    ),
}
"""Module and name of each command, and the first line of its help."""


_UsageError: Any = typer.BadParameter.__base__
"""Click's UsageError, raised for a command line that cannot be parsed; typer does not export it."""


class Commands(TyperGroup):
    """The group of all commands; a command's module is imported when it is called."""

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        windows_expand_args: bool = True,
        **extra: Any,
    ) -> Any:
        """Run the command line; with --json among the arguments usage errors are JSON too."""
        arguments = sys.argv[1:] if args is None else list(args)
        in_json = standalone_mode and "--json" in arguments
        alone = standalone_mode and not in_json
        try:
            ended = super().main(args, prog_name, complete_var, alone, windows_expand_args, **extra)
        except _UsageError as error:
            if not in_json:
                raise
            refuse_in_json("OptionsError", error.format_message(), error.exit_code)
            sys.exit(error.exit_code)
        if in_json:
            sys.exit(ended)
        return ended

    def make_context(
        self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any
    ) -> Any:
        with _printable():
            return super().make_context(info_name, args, parent, **extra)

    def invoke(self, ctx: Any) -> Any:
        with _printable():
            return super().invoke(ctx)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        name, command, rest = super().resolve_command(ctx, args)
        return name, command if name is None else loaded(name), rest


@contextmanager
def _printable() -> Generator[None]:
    """Escape usage errors: they quote arguments, which may be file names from anywhere."""
    try:
        yield
    except _UsageError as error:
        error.message = printable(error.message)
        raise


_BLAS_THREADS = "OPENBLAS_NUM_THREADS"
"""Set to 1, so that matrix products have the same bytes on any number of processors and no threads
spin while they wait. Larger work is spread over threads by `core.run.in_parallel`."""


def loaded(name: str) -> Any:
    """A command with its options, imported from its module."""
    os.environ.setdefault(_BLAS_THREADS, "1")  # read once, when numpy is first imported
    # Else matplotlib tells on the terminal that it builds its font cache.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    if _SETTINGS_LEFT_ALONE not in sys.meta_path:
        sys.meta_path.insert(0, _SETTINGS_LEFT_ALONE)
    module, _, attribute = COMMANDS[name][0].partition(":")
    made = getattr(_imported(f"limbgram.cli.{module}"), attribute)
    around = _group(TyperGroup)
    if isinstance(made, typer.Typer):
        around.add_typer(made, name=name)
    else:
        around.command(name)(made)
    return cast(TyperGroup, get_command(around)).commands[name]


def _imported(module: str) -> ModuleType:
    """A module, imported in `NEUTRAL_FOLDER`."""
    if module in sys.modules:
        return sys.modules[module]
    try:
        Path.cwd()
    except FileNotFoundError as error:
        raise _UsageError(
            "The folder that you are in was moved or deleted. Change to another one (cd) and run "
            "the command again."
        ) from error
    try:
        with garbage_collection_paused(), chdir(NEUTRAL_FOLDER):
            return import_module(module)
    except RuntimeError as error:
        if "no locator available" not in str(error):  # numba's words; it has no class for it
            raise
        raise _UsageError(
            "What limbgram compiles for this processor can be kept nowhere: neither beside the "
            "program nor in your home may files be written, nor in NUMBA_CACHE_DIR if that is set. "
            "Set NUMBA_CACHE_DIR to a folder that you may write and that stays."
        ) from error


class _NeutralLoader(SourceFileLoader):
    """Loads a library in `NEUTRAL_FOLDER`."""

    def exec_module(self, module: ModuleType) -> None:
        with chdir(NEUTRAL_FOLDER):
            super().exec_module(module)


class _SettingsLeftAlone:
    """Finds the libraries that read settings from the current folder, whoever imports them.

    Some commands draw only if they are asked to, and import what draws in the midst of their work.
    """

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname not in ("matplotlib", "numba"):
            return None
        found = PathFinder.find_spec(fullname, path, target)
        if found is None or found.origin is None:
            return None
        return spec_from_file_location(
            fullname,
            found.origin,
            loader=_NeutralLoader(fullname, found.origin),
            submodule_search_locations=found.submodule_search_locations,
        )


_SETTINGS_LEFT_ALONE = _SettingsLeftAlone()


def _group(kind: type[TyperGroup]) -> typer.Typer:
    group = typer.Typer(
        name="limbgram",
        cls=kind,
        help=_HELP,
        no_args_is_help=True,
        add_completion=kind is Commands,
        pretty_exceptions_show_locals=False,
        rich_markup_mode="markdown",
    )
    group.callback()(_root)
    return group


def _listed() -> typer.Typer:
    """The commands with their help lines, none imported."""
    group = _group(Commands)
    for name, (_, line) in COMMANDS.items():
        group.command(name, help=line)(_nothing)
    return group


def _print_version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version  # a tenth of the start of every other command

        typer.echo(f"limbgram {version('limbgram')}")
        raise typer.Exit


def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="The version.")
    ] = False,
) -> None:
    """The group's own options, which are eager."""


def _nothing() -> None:
    """Placeholder of a command that is not imported yet."""


app = _listed()
