"""The examples run as they stand, and what they print agrees with the shapes that they make."""

import ast
import json
import math
import re
import runpy
import sys
from pathlib import Path
from typing import Any

import pytest
from matplotlib import pyplot

EXAMPLES = Path(__file__).parents[2] / "examples"


def printed(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "path", [str(EXAMPLES), *sys.path])
    runpy.run_path(str(EXAMPLES / name), run_name="__main__")


def test_girths_and_volume_are_those_of_the_shape(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    printed("measure_a_limb.py", tmp_path, monkeypatch)
    said = capsys.readouterr().out
    girths = {int(h): float(g) for h, g in re.findall(r"(\d+) mm up: girth ([\d.]+)", said)}
    for height, girth in girths.items():
        radius = 50 + (height - 50) / 170 * 8
        assert girth == pytest.approx(2 * math.pi * radius, rel=5e-4)
    low, high = 50.0, 50 + 100 / 170 * 8
    volume_ml = math.pi * 100 / 3 * (low**2 + low * high + high**2) / 1000
    found = re.search(r"([\d.]+) mL", said)
    assert found
    assert float(found[1]) == pytest.approx(volume_ml, rel=1e-3)


def test_the_others_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in sorted({path.name for path in EXAMPLES.glob("*_*.py")} - {"measure_a_limb.py"}):
        printed(name, tmp_path, monkeypatch)
    said = capsys.readouterr().out
    assert re.search(r"relieve.*: \+\d", said)
    assert re.search(r"load.*: -\d", said)
    assert "Refused:" in said
    assert "The limb shrinks" in said
    assert (tmp_path / "socket.stl").stat().st_size > 84
    assert (tmp_path / "stump.aop").is_file()


def test_the_notebook_runs_and_shows_what_it_shows_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [str(EXAMPLES), *sys.path])
    cells = json.loads((EXAMPLES / "first_steps.ipynb").read_text("utf-8"))["cells"]
    names: dict[str, Any] = {}
    shown = 0
    for cell in cells:
        if cell["cell_type"] != "code":
            continue
        *before, last = ast.parse("".join(cell["source"])).body
        exec(compile(ast.Module(before, []), "cell", "exec"), names)
        if not isinstance(last, ast.Expr):
            exec(compile(ast.Module([last], []), "cell", "exec"), names)
            continue
        value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
        for html in (one["data"].get("text/html") for one in cell["outputs"]):
            if html is not None:
                assert value._repr_html_() == "".join(html)
                shown += 1
    assert shown == 2
    pyplot.close("all")
