"""The slow tests: whole captures and stress, which README's test command leaves out.

    python benchmarks/slow_tests.py -o benchmarks/results/slow_tests.json

In      the tests that are marked slow, with the data of LIMBGRAM_DATA where it is set.
Out     OUT.json: every test's outcome and seconds, and why one was skipped; exit code 1
        if one failed.
Method  pytest on two cores, as README calls it, but for the marker.
"""

import json
import sys
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from harness import described, machine, made_on, table

ROOT = Path(__file__).parents[1]


@dataclass
class Outcomes:
    """A plugin of pytest that keeps how each test ended."""

    rows: dict[str, dict[str, Any]] = field(default_factory=dict)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Of setting up, calling and tearing down: their seconds together, the worst outcome."""
        row = self.rows.setdefault(report.nodeid, {"outcome": "passed", "seconds": 0.0})
        row["seconds"] = round(row["seconds"] + report.duration, 1)
        if not report.passed:
            row["outcome"] = report.outcome
            row["reason"] = _reason(report)


def _reason(report: pytest.TestReport) -> list[str]:
    """The last line of what it says, without where the project lies on this machine."""
    if isinstance(report.longrepr, tuple):  # a skipped one: file, line and reason
        return [report.longrepr[2]]
    return [line.replace(f"{ROOT}/", "") for line in report.longreprtext.splitlines()[-1:]]


def page(results: dict[str, Any]) -> str:
    rows = results["tests"]
    ended = Counter(row["outcome"] for row in rows.values())
    said = ", ".join(f"{count} {outcome}" for outcome, count in sorted(ended.items()))
    heads = ("test", "outcome", "s", "why")
    cells = [
        (name, row["outcome"], f"{row['seconds']:.0f}", " ".join(row.get("reason", ())))
        for name, row in rows.items()
    ]
    return "\n\n".join(
        (
            "# Slow tests",
            f"{said}. Seconds of a machine that does two tests at a time.",
            table(heads, cells),
            made_on(results["machine"]) + "\n",
        )
    )


def main() -> None:
    parser = described(__doc__)
    parser.add_argument("-o", "--output", type=Path, default=None)
    parser.add_argument("tests", nargs="*", default=[str(ROOT / "tests")])
    asked = parser.parse_args()
    outcomes = Outcomes()
    words = ["-m", "slow", "-n", "2", "-q", f"--rootdir={ROOT}", *asked.tests]
    code = pytest.main(words, plugins=[outcomes])
    results = {"machine": machine(), "tests": dict(sorted(outcomes.rows.items()))}
    if asked.output is not None:
        asked.output.write_text(json.dumps(results, indent=1) + "\n", "utf-8")
    sys.exit(code)


if __name__ == "__main__":
    main()
