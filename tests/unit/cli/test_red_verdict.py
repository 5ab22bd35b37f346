"""A red verdict has an exit code of its own, and everybody reads the same word."""

import json
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from limbgram.cli.main import app as limbgram
from limbgram.cli.replies import Reply, answered
from limbgram.core.errors import RED_EXIT_CODE


def command(light: str) -> typer.Typer:
    app = typer.Typer()

    @app.command()
    @answered
    def judge(as_json: bool = False) -> Reply:  # noqa: ARG001  # pyright: ignore
        return Reply((f"{light.upper()}: so it is.", "second line"), {"light": light}, light)

    return app


@pytest.mark.parametrize(("light", "code"), [("green", 0), ("amber", 0), ("red", 7), ("", 0)])
@pytest.mark.parametrize("words", [(), ("--as-json",)])
def test_red_ends_with_its_own_code_and_is_told_all_the_same(
    light: str, code: int, words: tuple[str, ...]
) -> None:
    result = CliRunner().invoke(command(light), list(words))
    assert result.exit_code == code
    if words:
        assert json.loads(result.stdout) == {"light": light}
    else:
        assert result.stdout.splitlines()[0] == f"{light.upper()}: so it is."


@pytest.mark.parametrize(("light", "escape"), [("green", "32m"), ("amber", "33m"), ("red", "31m")])
def test_a_terminal_shows_the_verdict_in_its_colour(
    light: str, escape: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    first, second = CliRunner().invoke(command(light), []).stdout.splitlines()
    assert escape in first
    assert f"{light.upper()}: so it is." in first
    assert second == "second line"


def test_the_help_lists_the_code() -> None:
    said: Any = CliRunner().invoke(limbgram, ["--help"]).output
    assert RED_EXIT_CODE == 7
    assert "7: done, and the verdict is RED" in " ".join(said.split())
