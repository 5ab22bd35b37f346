"""Pages: results as Markdown for people, made from their JSON.

    python benchmarks/pages.py                    all results that have a page, into build/results
    python benchmarks/pages.py coach cost -o .    these

A page is what the function `page` of a benchmark makes of its file of results.
"""

import importlib
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from harness import described

RESULTS = Path(__file__).parent / "results"
MADE_BY = {
    "cost": "cost_tables",
    "growth": "cost_tables",
    "explanations": "explanation_tables",
    "rendered": "tables",
    "real": "tables",
    "skull": "tables",
    "sweep": "tables",
    "device_limbs": "devices",
    "landmarks": "landmark_tables",
}
"""Results whose name does not begin with that of the benchmark that has their page."""


def main() -> None:
    parser = described(__doc__)
    parser.add_argument("names", nargs="*", help="of results; all if none is given")
    parser.add_argument("-o", "--out", type=Path, default=Path("build/results"), help="folder")
    chosen = parser.parse_args()
    chosen.out.mkdir(parents=True, exist_ok=True)
    for name in chosen.names or sorted(path.stem for path in RESULTS.glob("*.json")):
        page = page_of(name)
        if page is None:
            sys.stderr.write(f"{name}: JSON alone\n")
            continue
        out = chosen.out / f"{name}.md"
        out.write_text(page, "utf-8")
        sys.stdout.write(f"{out}\n")


def page_of(name: str) -> str | None:
    """The page of a result; none where its benchmark makes no page."""
    make: Callable[[dict[str, Any]], str] | None
    make = getattr(importlib.import_module(module_of(name)), "page", None)
    return make and make(json.loads((RESULTS / f"{name}.json").read_text("utf-8")))


def module_of(name: str) -> str:
    """The module with the page of a result: `cluster` of `cluster-kills-16`."""
    if name in MADE_BY:
        return MADE_BY[name]
    known = [path.stem for path in Path(__file__).parent.glob("*.py") if name.startswith(path.stem)]
    return max(known, key=len, default="nightly")


if __name__ == "__main__":
    main()
