"""Harness: what benchmarks share. Arguments, the machine, the file of results, tables.

    parser = asking(__doc__, keep="captures and cases")
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    results = {"machine": machine(), "runs": {}}
    with working_in(chosen.keep) as folder:
        ...
        write(chosen.out, results)

Results are written after each run, so that a benchmark that is stopped leaves what it found; each
replaces the file of before at once, and never half. Where a benchmark has a function `page`, it
gives the results as Markdown for people, and `pages.py` writes it.
"""

import argparse
import json
import os
import platform
import subprocess
import tempfile
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

import limbgram
from limbgram.core.files import write_bytes

LIBRARIES = ("limbgram", "numpy", "numba", "opencv-python-headless", "pycolmap", "scipy")
Result = dict[str, Any]


def described(about: str | None) -> argparse.ArgumentParser:
    """A parser whose help is the docstring of the benchmark, line by line."""
    return argparse.ArgumentParser(
        description=about, formatter_class=argparse.RawDescriptionHelpFormatter
    )


def asking(about: str | None, out: Path | None = None, keep: str = "") -> argparse.ArgumentParser:
    """A parser that knows `-o`, the file of results, and `--keep`.

    Args:
        about: The docstring of the benchmark, as help shows it.
        out: Where results go if nobody says; else `-o` has to be given.
        keep: What `--keep FOLDER` leaves there; empty: there is no such argument.
    """
    parser = described(about)
    parser.add_argument("-o", "--out", type=Path, default=out, required=out is None)
    if keep:
        parser.add_argument("--keep", type=Path, help=f"keep {keep} here")
    return parser


@contextmanager
def working_in(keep: Path | None) -> Generator[Path]:
    """The folder to keep, made if need be, or one for the time being."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        yield folder


def found_before(out: Path, otherwise: Result) -> Result:
    """What a file of results holds already, to be added to."""
    return json.loads(out.read_text("utf-8")) if out.exists() else otherwise


def write(out: Path, results: Result) -> None:
    """Write OUT.json; `pages.py` makes a page for people of it."""
    out.parent.mkdir(parents=True, exist_ok=True)
    write_bytes(out, (json.dumps(results, indent=1) + "\n").encode())


def machine() -> Result:
    """What the figures were measured on."""
    measured = Path(limbgram.__file__).parent  # which PYTHONPATH may have chosen
    commit = subprocess.run(
        ["git", "-C", str(measured), "rev-parse", "HEAD"],
        capture_output=True,
        text=True,
        check=False,
    )
    return {
        "system": platform.platform(),
        "processor": platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "memory_gb": os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30,
        "python": platform.python_version(),
        "versions": {name: version(name) for name in LIBRARIES},
        "commit": commit.stdout.strip(),
    }


def made_on(machine: Result) -> str:
    """What `machine` found out, as a line."""
    versions = ", ".join(f"{name} {number}" for name, number in machine["versions"].items())
    return (
        f"{machine['processor']}, {machine['cores']} cores, {machine['memory_gb']:.0f} GB; "
        f"{machine['system']}; Python {machine['python']}; commit {machine['commit'][:12]}; "
        f"{versions}"
    )


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Markdown; a bar in a cell would end it."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(
        "| " + " | ".join(cell.replace("|", "/") for cell in row) + " |" for row in lines
    )
