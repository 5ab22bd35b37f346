"""A few of the damaged files of `benchmarks/mutants.py` for each reader: read, or refused."""

import warnings
from pathlib import Path

import pytest

from limbgram.core.errors import LimbgramError

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
COUNT, SEED = 30, 2


def test_damaged_files_are_read_or_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    from mutants import mutant, readers

    outcomes = {"read": 0, "refused": 0}
    for name, reader in readers().items():
        folder = tmp_path / name
        folder.mkdir()
        for beside, content in reader.setting.items():
            (folder / beside).write_bytes(content)
        own = reader.ending if not reader.ending.startswith(".") else f"scan{reader.ending}"
        path = folder / own
        path.write_bytes(reader.whole)
        reader.read(path)  # whole, it is read
        for idx in range(COUNT):
            path.write_bytes(mutant(reader, SEED, idx))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                try:
                    reader.read(path)
                    outcomes["read"] += 1
                except LimbgramError:
                    outcomes["refused"] += 1
    assert outcomes["refused"] > 0.5 * COUNT * 22
    assert outcomes["read"] > 0.05 * COUNT * 22
