"""The table of carried landmarks counts what it says it counts."""

import importlib
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest


@pytest.fixture(scope="module")
def tables() -> ModuleType:
    sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
    try:
        return importlib.import_module("landmark_tables")
    finally:
        sys.path.pop(0)


def test_shares_are_of_what_the_scan_holds_and_the_allowance_counts_apart(
    tables: ModuleType,
) -> None:
    marks: list[dict[str, Any]] = [
        {"off_mm": 1.0, "carrying_mm": 1.0, "sliding_mm": 0.0},
        {"off_mm": 3.0, "carrying_mm": 1.0, "sliding_mm": 1.0},  # within 2.448 x 1.414 alone
        {"off_mm": 4.0, "carrying_mm": 1.0, "sliding_mm": 0.0},
        {"refused": "carried.loose"},
        {"refused": "carried.unmeasured", "gone": True},
        {"off_mm": 9.0, "carrying_mm": 1.0, "sliding_mm": 0.0, "gone": True},
    ]
    told, refused, gone, rms, _, stated, inside, alone = tables.summary(marks)
    assert (told, refused, gone) == ("3 of 4", "25.0%", "1 of 2")
    assert rms == "2.94"  # the root of 26 / 3
    assert stated == "1.63"  # of both directions: the root of 2 (1 + 2 + 1) / 3
    assert (inside, alone) == ("66.7%", "33.3%")
