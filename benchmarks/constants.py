"""Constants: numbers of the sources are changed, one at a time; the tests beside them must notice.

    python benchmarks/constants.py --seed 31 --count 20 -o benchmarks/results/constants.json

draws numbers that have a name of their own (`_NEAR_MM = 15.0`) from all modules, changes one in a
copy of the sources by half of itself, and runs the tests that mirror its folder with `-x`. Where no
test notices, nothing that is kept holds the number: its test is missing.
"""

import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from harness import asking, machine, write

ROOT = Path(__file__).parents[1]
SOURCES = ROOT / "src" / "limbgram"
TESTS = ROOT / "tests" / "unit"


@dataclass(frozen=True)
class Constant:
    """A number with a name, in a module."""

    module: str
    line: int
    name: str
    value: float

    @property
    def changed(self) -> float:
        """Half as much again; of a whole number the next whole one at least."""
        if isinstance(self.value, int):
            return self.value + max(1, abs(self.value) // 2)
        return 1.5 * self.value if self.value else 1.0

    @property
    def tests(self) -> Path:
        """The nearest folder of tests that mirrors its own."""
        folder = TESTS / Path(self.module).parent
        while not any(folder.glob("test_*.py")):
            folder = folder.parent
        return folder


def constants() -> Iterator[Constant]:
    for path in sorted(SOURCES.rglob("*.py")):
        for line in ast.parse(path.read_text("utf-8")).body:
            match line:
                case ast.Assign(
                    targets=[ast.Name(id=name)], value=ast.Constant(value=int() | float() as value)
                ) if not isinstance(value, bool):
                    module = path.relative_to(SOURCES).as_posix()
                    yield Constant(module, line.lineno, name, value)


def is_noticed(constant: Constant, copy: Path, limit_s: float) -> bool | None:
    """Whether a test fails once the constant is changed; None where they take too long."""
    file = copy / "limbgram" / constant.module
    whole = file.read_text("utf-8")
    lines = whole.splitlines(keepends=True)
    lines[constant.line - 1] = f"{constant.name} = {constant.changed!r}\n"
    file.write_text("".join(lines), "utf-8")
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
    try:
        done = subprocess.run(
            [*command, "-o", "pythonpath=", str(constant.tests)],
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": str(copy)},
            stdout=subprocess.DEVNULL,
            timeout=limit_s,
        )
    except subprocess.TimeoutExpired:
        return None
    finally:
        file.write_text(whole, "utf-8")
    return done.returncode != 0


def main() -> None:
    parser = asking(__doc__)
    parser.add_argument("--seed", type=int, default=31)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--limit", type=float, default=600.0, help="Seconds for each.")
    asked = parser.parse_args()
    drawn = random.Random(asked.seed).sample(list(constants()), asked.count)
    told: list[dict[str, object]] = []
    kept = {"seed": asked.seed, "machine": machine(), "drawn": told}
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "src"
        shutil.copytree(ROOT / "src", copy)
        for one in drawn:
            noticed = is_noticed(one, copy, asked.limit)
            told.append({**asdict(one), "changed": one.changed, "noticed": noticed})
            write(asked.out, kept)
            print(one.module, one.name, one.value, "->", one.changed, noticed, flush=True)  # noqa: T201


if __name__ == "__main__":
    main()
