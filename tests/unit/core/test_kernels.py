"""Kept kernels: what they took from another file changes, and the next process compiles anew."""

import importlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

import limbgram
from limbgram.core.kernels import stamp

_OWN = """
from limbgram.core.kernels import njit
from tiny import numbers
from tiny.parts import Pair, SIZE, grown, turned

@njit(cache=True, nogil=True)
def answer(x):
    pair = Pair(grown(x), _near(x))
    return pair.first + pair.second + SIZE + numbers.SHIFT

@njit(cache=True)
def _near(x):
    return turned(x)
"""
_PARTS = """
from typing import NamedTuple
from limbgram.core.kernels import inlined, njit
from tiny.numbers import FACTOR

SIZE = 1000.0

class Pair(NamedTuple):
    first: float
    second: float

@inlined
def grown(x):
    return FACTOR * x

@njit(inline="always")
def turned(x):
    return -x
"""
_NUMBERS = """
FACTOR = 10.0
SHIFT = 0.5
"""
_ASKED = """
from tiny.own import answer
print(answer(2.0), sum(answer.stats.cache_hits.values()))
"""


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    """A package whose kernel takes all it can from two other files."""
    (tmp_path / "tiny").mkdir()
    for name, text in (("__init__", ""), ("own", _OWN), ("parts", _PARTS), ("numbers", _NUMBERS)):
        (tmp_path / "tiny" / f"{name}.py").write_text(text)
    return tmp_path


def answered(folder: Path, hash_seed: int = 0) -> tuple[float, int]:
    """What a new process computes, and how often it found compiled code."""
    source = Path(limbgram.__file__).parents[1]
    told = subprocess.run(
        [sys.executable, "-B", "-c", _ASKED],
        check=True,
        capture_output=True,
        text=True,
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(source), "PYTHONHASHSEED": str(hash_seed)},
    )
    value, hits = told.stdout.split()
    return float(value), int(hits)


def answered_here(folder: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[float, int]:
    """The same of this process, which reads the package anew and finds what is compiled on disk."""
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.syspath_prepend(folder)
    for name in [one for one in sys.modules if one.partition(".")[0] == "tiny"]:
        del sys.modules[name]
    answer = importlib.import_module("tiny.own").answer
    return answer(2.0), sum(answer.stats.cache_hits.values())


@pytest.mark.parametrize(
    "changes",
    [
        [("numbers", "FACTOR = 10.0", "FACTOR = 20.0", 1038.5)],
        pytest.param(
            [
                ("parts", "return FACTOR * x", "return FACTOR * x + 1.0", 1019.5),
                ("parts", "return -x", "return -x * x", 1017.5),
                ("parts", "SIZE = 1000.0", "SIZE = 2000.0", 2017.5),
                ("numbers", "SHIFT = 0.5", "SHIFT = 0.25", 2017.25),
            ],
            marks=pytest.mark.slow,
        ),
    ],
)
def test_what_another_file_gave_is_compiled_anew(
    tiny: Path, monkeypatch: pytest.MonkeyPatch, changes: list[tuple[str, str, str, float]]
) -> None:
    """A constant of what is inlined, what is inlined, what is called, other constants."""
    assert answered_here(tiny, monkeypatch) == (1018.5, 0)
    for file, before, after, value in changes:
        path = tiny / "tiny" / f"{file}.py"
        path.write_text(path.read_text().replace(before, after))
        assert answered_here(tiny, monkeypatch) == (value, 0)
    assert answered_here(tiny, monkeypatch) == (value, 1)


def test_what_has_not_changed_is_found_by_every_process(tiny: Path) -> None:
    assert answered(tiny, hash_seed=1) == (1018.5, 0)
    path = tiny / "tiny" / "parts.py"
    path.write_text("# moved down by a comment\n" + path.read_text())
    assert answered(tiny, hash_seed=2) == (1018.5, 1)


def test_a_constant_that_tells_nothing_of_itself_is_refused() -> None:
    def kernel() -> object:
        return nothing_told

    nothing_told = object()
    with pytest.raises(TypeError, match="cannot be told"):
        stamp(kernel)
