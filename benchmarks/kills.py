"""Kills: a reconstruction is killed at random moments and continued, and nothing must tell.

A small synthetic capture is reconstructed once undisturbed. Then other cases of it are killed
(SIGKILL: the worker, the command, or both) in a random stage, again and again while the files for
other programs are written, and continued. The finished case must hold the same bytes as the
undisturbed one in everything but times, list the same files, and hold nothing half written.

    python benchmarks/kills.py --count 30 -o benchmarks/results/kills.json
"""

import argparse
import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

import numpy as np

from harness import described, machine

COMMAND = (sys.executable, "-P", "-c", "from limbgram.cli.main import app; app()")
_TIMED = ("case.json", "summary.json", "report.html", "stage.json", "log.txt", ".lock")
"""Files that hold times. What else is in them is compared apart."""
_EXPORT = "deliver"
_PATIENCE_S = 60.0
Killed = Literal["worker", "command", "both"]


@dataclass
class Moment:
    """When a process is killed: so long after its stage began."""

    stage: str
    delay_s: float
    who: Killed


@dataclass
class Reference:
    """An undisturbed run."""

    contents: dict[str, str]
    stages_s: dict[str, float] = field(default_factory=dict)


def main() -> None:
    asked = described(__doc__)
    asked.add_argument("--count", type=int, default=30, help="kills in all")
    asked.add_argument("--each", type=int, default=4, help="kills of one case before it ends")
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--photos", type=int, default=14)
    asked.add_argument("--width", type=int, default=600)
    asked.add_argument("--keep", type=Path, help="work in this new folder, and keep it")
    asked.add_argument("-o", "--out", type=Path)
    options = asked.parse_args()
    with TemporaryDirectory() as scratch:
        report = tried(options.keep or Path(scratch), options)
    text = json.dumps({**report, "machine": machine()}, indent=1) + "\n"
    if options.out is not None:
        options.out.write_text(text)
    sys.stdout.write(text)
    if report["cases_that_differ"]:
        raise SystemExit(1)


def tried(folder: Path, options: argparse.Namespace) -> dict[str, Any]:
    capture, camera = folder / "capture", folder / "camera.json"
    size = ["--photos", str(options.photos), "--width", str(options.width)]
    done("make-capture", str(capture), *size)
    board = ["--board", "14x10", "--square", "10"]
    done("calibrate", str(capture / "calibration"), *board, "-o", str(camera))
    words = ["reconstruct", str(capture / "images"), "--camera", str(camera)]
    reference = undisturbed(words, folder / "undisturbed")
    chance = np.random.default_rng(options.seed)
    kills: list[dict[str, Any]] = []
    cases, differing = 0, []
    while len(kills) < options.count:
        case = folder / f"case {cases}"
        count = min(options.each, options.count - len(kills))
        now = [*words, "-o", str(case)]
        kills += [killed(now, moment) for moment in moments(reference, chance, count)]
        finished(now)
        found = difference(reference.contents, contents(case))
        differing += [{"case": cases, **found}] if found else []
        cases += 1
    return {
        "kills": len(kills),
        "kills_that_hit": sum(kill["hit"] for kill in kills),
        "kills_in_export": sum(kill["hit"] and kill["stage"] == _EXPORT for kill in kills),
        "cases": cases,
        "cases_that_differ": differing,
        "files_compared": len(reference.contents),
        "half_written_files_seen": sum(kill["half_written"] for kill in kills),
        "of": kills,
    }


def moments(reference: Reference, chance: np.random.Generator, count: int) -> Iterator[Moment]:
    """In the order of the stages, so that a case gets on; every other one in the export."""
    names = list(reference.stages_s)
    exports = count // 2
    early = [name for name in names if name != _EXPORT]
    places = sorted(chance.choice(len(early), count - exports, replace=False).tolist())
    for name in (*(early[place] for place in places), *[_EXPORT] * exports):
        delay_s = float(chance.uniform(0, reference.stages_s[name]))
        who: Killed = ("worker", "command", "both")[int(chance.integers(3))]
        yield Moment(name, delay_s, who)


def undisturbed(words: list[str], case: Path) -> Reference:
    """Reconstruct once, and note how long each stage takes."""
    began: dict[str, float] = {}
    process = started([*words, "-o", str(case)])
    for stage in stages_of(process):
        began.setdefault(stage, time.monotonic())
    ended = time.monotonic()
    if process.wait():
        raise SystemExit("The undisturbed run failed.")
    times = [*began.values(), ended]
    stages_s = {name: times[k + 1] - times[k] for k, name in enumerate(began)}
    return Reference(contents(case), stages_s)


def killed(words: list[str], moment: Moment) -> dict[str, Any]:
    """Start a run and kill it; a run that is over before that moment was not hit."""
    case = Path(words[-1])
    process = started(words)
    hit = False
    for stage in stages_of(process):
        if stage == moment.stage:
            time.sleep(moment.delay_s)
            hit = kill(process, moment.who)
            break
    process.stderr.close()
    code = process.wait()
    wait_until_free(case)
    left = [path for path in case.rglob(".*") if path.name != ".lock"]
    return {
        "stage": moment.stage,
        "delay_s": round(moment.delay_s, 3),
        "who": moment.who,
        "hit": hit,
        "exit_code": code,
        "half_written": len(left),
    }


def kill(process: "subprocess.Popen[str]", who: Killed) -> bool:
    """Whether there was something to kill."""
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    workers = [int(text) for text in children.read_text().split()] if children.exists() else []
    ids = {"worker": workers, "command": [process.pid], "both": [process.pid, *workers]}[who]
    for one in ids:
        try:
            os.kill(one, signal.SIGKILL)
        except ProcessLookupError:
            return False
    return bool(ids)


def wait_until_free(case: Path) -> None:
    """A worker whose command is gone stops at its next step."""
    import fcntl

    deadline = time.monotonic() + _PATIENCE_S
    while time.monotonic() < deadline and (case / ".lock").exists():
        with (case / ".lock").open("a+") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return
            except OSError:
                time.sleep(0.1)


def finished(words: list[str]) -> None:
    process = started(words)
    said = list(stages_of(process))
    if process.wait():
        raise SystemExit(f"A continued run failed after {said[-1:]}.")


def started(words: list[str]) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [*COMMAND, *words[:-2], "--json", *words[-2:]],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def stages_of(process: "subprocess.Popen[str]") -> Iterator[str]:
    """Names of the stages as they begin."""
    last = ""
    for line in process.stderr:
        event = json.loads(line) if line.startswith("{") else {}
        if event.get("event") == "progress" and event["stage"] != last:
            last = event["stage"]
            yield last


def contents(case: Path) -> dict[str, str]:
    """What a case holds, but for times: hashes of files, and what files with times say besides."""
    held = {
        path.relative_to(case).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in case.rglob("*")
        if path.is_file() and path.name not in _TIMED
    }
    record = json.loads((case / "case.json").read_text())
    summary = json.loads((case / "summary.json").read_text())
    summary.pop("stages")
    told = {name: record[name] for name in ("state", "photos", "set_aside", "files", "versions")}
    told["stages"] = [(stage["stage"], stage["key"]) for stage in record["stages"]]
    return {**held, "case.json": json.dumps(told), "summary.json": json.dumps(summary)}


def difference(reference: dict[str, str], found: dict[str, str]) -> dict[str, list[str]]:
    """Files that differ, are missing or are too many; nothing where all is the same."""
    parts = {
        "differ": [name for name, held in reference.items() if found.get(name, held) != held],
        "missing": sorted(reference.keys() - found.keys()),
        "too_many": sorted(found.keys() - reference.keys()),
    }
    return {name: listed for name, listed in parts.items() if listed}


def done(*words: str) -> None:
    subprocess.run([*COMMAND, *words], check=True, capture_output=True)


if __name__ == "__main__":
    main()
