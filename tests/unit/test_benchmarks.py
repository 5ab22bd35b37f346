"""Benchmarks are run by hand: what would only fail there is found here."""

import ast
import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

SCRIPTS = sorted((Path(__file__).parents[2] / "benchmarks").glob("*.py"))
HELP = """
import runpy, sys

PAGES, *scripts = sys.argv[1:]
for script in scripts:
    print("=", script, flush=True)
    sys.argv = [script, "--help"]
    try:
        runpy.run_path(script, run_name="__main__")
    except SystemExit as end:
        print("=", "ends" if not end.code else end.code)
    else:
        print("=", "went on")
sys.argv = ["pages.py", "-o", PAGES]
sys.path.insert(0, "")
runpy.run_path("pages.py", run_name="__main__")
"""
"""In one process, so that libraries are loaded once."""
WITHOUT_PAGE = {"constants", "constants_97", "constants_131", "demo", "kills", "spoiled", "video"}
"""Results that are read by programs, or as figures of docs/accuracy.md."""


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_no_script_defines_a_name_twice(script: Path) -> None:
    """The second definition would answer the first one's callers."""
    defined = Counter(
        node.name
        for node in ast.parse(script.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef | ast.ClassDef)
    )
    assert not [name for name, count in defined.items() if count > 1]


def test_scripts_answer_help_and_make_the_pages_of_results(tmp_path: Path) -> None:
    run = [str(path) for path in SCRIPTS if "__main__" in path.read_text("utf-8")]
    said = subprocess.run(
        [sys.executable, "-c", HELP, str(tmp_path), *run],
        cwd=SCRIPTS[0].parent,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    ).stdout
    told = [line[2:] for line in said.splitlines() if line.startswith("= ")]
    assert told == [word for script in run for word in (script, "ends")]
    assert said.count("usage: ") == len(run)

    results = {path.stem: path for path in (SCRIPTS[0].parent / "results").glob("*.json")}
    pages = {path.stem: path.read_text("utf-8") for path in tmp_path.glob("*.md")}
    assert set(results) - set(pages) == WITHOUT_PAGE
    assert all(page.startswith("# ") for page in pages.values())
    for name, run in json.loads(results["slow_tests"].read_text("utf-8"))["tests"].items():
        assert f"| {name} | {run['outcome']} |" in pages["slow_tests"]
