"""The list of commands, and commands that come out of their files when called."""

import subprocess
import sys

import pytest
from typer.testing import CliRunner

from limbgram.cli.main import COMMANDS, app, loaded

_HEAVY = ("numpy", "scipy", "numba", "cv2", "matplotlib", "pycolmap", "trimesh")


@pytest.mark.parametrize("name", COMMANDS)
def test_the_list_says_of_each_command_what_its_own_help_begins_with(name: str) -> None:
    first = " ".join(loaded(name).help.split("\n\n")[0].split())
    assert COMMANDS[name][1] == first


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_answers_by_its_own_help(name: str) -> None:
    answer = CliRunner().invoke(app, [name, "--help"], env={"COLUMNS": "200"})
    assert answer.exit_code == 0
    assert f"limbgram {name}" in answer.output
    assert "--json" in answer.output or "COMMAND" in answer.output


def test_a_mistyped_command_is_refused_with_the_nearest_name() -> None:
    answer = CliRunner().invoke(app, ["measur"])
    assert answer.exit_code == 2
    assert "'measure'" in answer.output


def test_the_list_of_commands_waits_for_no_library() -> None:
    asked = f"""
import sys
from limbgram.cli.main import app
try:
    app(["--help"])
except SystemExit as end:
    sys.exit(str([name for name in {_HEAVY} if name in sys.modules]) if not end.code else 1)
"""
    answer = subprocess.run(
        [sys.executable, "-c", asked], capture_output=True, text=True, check=False
    )
    assert "reconstruct" in answer.stdout
    assert answer.stderr.strip() == "[]"
