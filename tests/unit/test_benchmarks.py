"""Benchmarks are run by hand: what would only fail there is found here."""

import ast
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

SCRIPTS = sorted((Path(__file__).parents[2] / "benchmarks").glob("*.py"))
HELP = """
import runpy, sys

for script in sys.argv[1:]:
    print("=", script, flush=True)
    sys.argv = [script, "--help"]
    try:
        runpy.run_path(script, run_name="__main__")
    except SystemExit as end:
        print("=", "ends" if not end.code else end.code)
    else:
        print("=", "went on")
"""
"""In one process, so that libraries are loaded once."""


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_no_script_defines_a_name_twice(script: Path) -> None:
    """The second definition would answer the first one's callers."""
    defined = Counter(
        node.name
        for node in ast.parse(script.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef | ast.ClassDef)
    )
    assert not [name for name, count in defined.items() if count > 1]


def test_every_script_answers_help_and_does_nothing_else() -> None:
    run = [str(path) for path in SCRIPTS if "__main__" in path.read_text("utf-8")]
    said = subprocess.run(
        [sys.executable, "-c", HELP, *run],
        cwd=SCRIPTS[0].parent,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    ).stdout
    told = [line[2:] for line in said.splitlines() if line.startswith("= ")]
    assert told == [word for script in run for word in (script, "ends")]
    assert said.count("usage: ") == len(run)
