"""Benchmarks are run by hand: what would only fail there is found here."""

import ast
from collections import Counter
from pathlib import Path

import pytest

SCRIPTS = sorted((Path(__file__).parents[2] / "benchmarks").glob("*.py"))


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_no_script_defines_a_name_twice(script: Path) -> None:
    """The second definition would answer the first one's callers."""
    defined = Counter(
        node.name
        for node in ast.parse(script.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef | ast.ClassDef)
    )
    assert not [name for name, count in defined.items() if count > 1]
