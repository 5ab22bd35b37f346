"""Titles of stages: each stage that is run has one for people."""

import ast
from pathlib import Path

import pytest

import limbgram
from limbgram.report.stages import stage_title

ROOM = Path(limbgram.__file__).parent
RUN = ("reconstruction/pipeline.py", "reconstruction/poses.py", "capture/coach.py")
"""Modules that run stages."""


def stages_of(module: str) -> set[str]:
    """Names of what the module gives to a run."""
    calls = (one for one in ast.walk(ast.parse((ROOM / module).read_text("utf-8"))))
    return {
        call.args[0].id
        for call in calls
        if isinstance(call, ast.Call)
        and isinstance(call.func, ast.Name)
        and call.func.id == "run"
        and call.args
        and isinstance(call.args[0], ast.Name)
    }


@pytest.mark.parametrize("stage", sorted(set().union(*map(stages_of, RUN))))
def test_a_stage_is_called_by_its_title(stage: str) -> None:
    assert stage_title(stage) != stage.replace("_", " ").capitalize()


def test_an_unknown_stage_is_called_by_its_name() -> None:
    assert stage_title("wind_up") == "Wind up"
