"""What the nightly run says of figures inside and outside their bounds."""

import importlib
import math
import sys
from pathlib import Path
from types import ModuleType

import pytest

FOLDER = str(Path(__file__).parents[2] / "benchmarks")
KNOWN = {
    "exit code": 0,
    "photos placed": 15,
    "RMS mm": 0.03,
    "95 % mm": 0.06,
    "bias mm": -0.002,
    "scale error %": 0.003,
    "worst girth mm": -0.2,
    "volume error %": 0.0,
    "error / sigma": 1.0,
    "CPU s": 100.0,
    "peak MB": 1000.0,
}


@pytest.fixture(scope="module")
def nightly() -> ModuleType:
    sys.path.insert(0, FOLDER)
    try:
        return importlib.import_module("nightly")
    finally:
        sys.path.remove(FOLDER)


def test_the_committed_figures_lie_inside_their_own_bounds(nightly: ModuleType) -> None:
    findings = nightly.judged(KNOWN, KNOWN)
    assert [finding.name for finding in findings] == [*KNOWN]
    assert all(finding.inside for finding in findings)
    assert "OUTSIDE" not in "\n".join(nightly.table(findings))


@pytest.mark.parametrize("name", KNOWN)
@pytest.mark.parametrize("beyond", [-1, 1])
def test_a_figure_beyond_either_bound_is_named(nightly: ModuleType, name: str, beyond: int) -> None:
    (known,) = (one for one in nightly.judged(KNOWN, KNOWN) if one.name == name)
    edge = known.low if beyond < 0 else known.high
    step = max(1e-6, 1e-6 * abs(edge))
    findings = nightly.judged(KNOWN, KNOWN | {name: edge + beyond * step})
    assert [finding.name for finding in findings if not finding.inside] == [name]
    (line,) = (line for line in nightly.table(findings) if "OUTSIDE" in line)
    assert line.split("  ")[1] == name
    inside = nightly.judged(
        KNOWN, KNOWN | {name: edge - beyond * min(step, known.high - known.low)}
    )
    assert all(finding.inside for finding in inside)


def test_a_figure_that_is_missing_or_no_number_lies_outside(nightly: ModuleType) -> None:
    missing = {name: value for name, value in KNOWN.items() if name != "RMS mm"}
    for found in (missing, KNOWN | {"RMS mm": math.nan}):
        findings = nightly.judged(KNOWN, found)
        assert [finding.name for finding in findings if not finding.inside] == ["RMS mm"]


def test_the_committed_results_have_every_figure(nightly: ModuleType) -> None:
    for name in (*nightly.RENDERED, nightly.DEMO):
        figures = nightly.figures_of(nightly.committed(name))
        assert figures.keys() == nightly.BOUNDS.keys()
        assert all(math.isfinite(value) for value in figures.values())
        assert figures["exit code"] == 0


def test_a_run_that_was_refused_lies_outside(nightly: ModuleType) -> None:
    known = nightly.figures_of(nightly.committed("limb_ring15"))
    refused = {"reconstruct": {"exit_code": 4, "cpu_s": known["CPU s"], "peak_mb": 300}}
    findings = nightly.judged(known, nightly.figures_of(refused))
    outside = {finding.name for finding in findings if not finding.inside}
    assert outside == nightly.BOUNDS.keys() - {"CPU s"}
