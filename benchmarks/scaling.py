"""Scaling: what a cluster costs a case, and where 100 to 10,000 workers would wait.

    python benchmarks/scaling.py -o results/scaling.json

Measured here: the wall time of captures of a stub on 1, 2 and 4 workers (the stub sleeps, so that
the processors of this machine do not limit it); what starting the process of an errand takes; what
a scheduler takes for a task, and this process for giving out and accepting a case of usual size.
Simulated from that: batches on many workers, which share one scheduler, one store and one process
that accepts. Of the published times of stages: what two workers could bring to one case.
"""

import argparse
import heapq
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from distributed import Client

from crew import crew_of, lay_stubs
from harness import asking, machine, write
from limbgram.batch.attempt import Plan
from limbgram.batch.attempt_process import order_of
from limbgram.batch.captures import find_captures
from limbgram.batch.cluster import ClusterOptions, ClusterRun
from limbgram.batch.settings import Batch
from limbgram.batch.storage import CasesInFolder
from limbgram.cases.job_messages import Job

HERE = Path(__file__).parent
BY_PHOTO_OR_PAIR = (
    "read photos", "detect", "match", "verify", "follow points", "find board", "estimate depth",
    "fuse", "measure",
)  # fmt: skip
"""Stages whose work could be parted by photo or pair, if nothing in them were done once."""
CASE_FILES, CASE_MB = 100, 130
"""Of the finished case of 15 photos of 3.8 megapixels."""
PHOTOS_MB = 60
STORE_MB_A_S = (1250.0, 12500.0)
"""A store behind 10 Gbit/s, and one that gives ten times as much."""
LINK_MB_A_S = 125.0
"""Of one worker: 1 Gbit/s."""
NEEDED = 1.6


def main() -> None:
    asked = asking(__doc__.partition("\n")[0])
    asked.add_argument("--captures", type=int, default=8)
    asked.add_argument("--seconds", type=float, default=8.0, help="that the stub sleeps")
    asked.add_argument("--workers", type=int, nargs="*", default=[1, 2, 4])
    asked.add_argument("--tasks", type=int, default=300, help="empty tasks for the scheduler")
    asked.add_argument("--case-s", type=float, default=60.0, help="of a case in the simulation")
    options = asked.parse_args()
    report: dict[str, Any] = {
        "load_before": round(os.getloadavg()[0], 1),
        "here": [here(count, options) for count in options.workers],
        "parts_s": parts_s(options),
    }
    report["simulated"] = [
        simulated(report["parts_s"], workers, store, options.case_s)
        for store in STORE_MB_A_S
        for workers in (100, 300, 1000, 3000, 10000)
    ]
    report["one_case_on_two"] = two_workers(report["parts_s"]["start"])
    report |= {"machine": machine(), "case_s": options.case_s, "captures": options.captures,
               "stub_s": options.seconds}  # fmt: skip
    write(options.out, report)
    sys.stdout.write(page(report))


def here(count: int, options: argparse.Namespace) -> dict[str, Any]:
    """A batch of stubs on so many workers of this machine."""
    with (
        TemporaryDirectory(prefix="limbgram-scaling-") as scratch,
        crew_of(Path(scratch), count, ttl_s=60.0) as crew,
    ):
        folder, out = Path(scratch) / "in", Path(scratch) / "out"
        lay_stubs(folder, options.captures, options.seconds)
        run = ClusterRun(
            plans_of(folder, out),
            ClusterOptions(
                address=crew.address, captures=str(folder), folder=folder, cases=str(out),
                module="stub_errand",
            ),
            lambda _: None,
        )  # fmt: skip
        began = time.monotonic()
        outcomes = run.wait()
        seconds = time.monotonic() - began
    if {one.state for one in outcomes} != {"finished"}:
        raise SystemExit(f"A batch of stubs failed: {outcomes}")
    work_s = float(np.mean([result.work_s for result in run.results]))
    return {
        "workers": count,
        "seconds": round(seconds, 1),
        "work_a_case_s": round(work_s, 2),
        "overhead_a_case_s": round(seconds * count / options.captures - work_s, 2),
    }


def plans_of(folder: Path, out: Path) -> list[Plan]:
    found = find_captures(folder, Batch(), out)
    return [Plan(capture=one, job=Job(case=out / one.name, sources=())) for one in found]


def parts_s(options: argparse.Namespace) -> dict[str, float]:
    """What each part of a case takes beside its work, seconds; of starting a process, CPU."""
    before = os.times()
    for _ in range(3):
        subprocess.run(
            [sys.executable, "-P", "-c", "import limbgram.batch.attempt_process"], check=True
        )
    after = os.times()
    start = (after.children_user + after.children_system) - (
        before.children_user + before.children_system
    )
    with TemporaryDirectory(prefix="limbgram-scaling-") as scratch:
        folder = Path(scratch)
        with crew_of(folder, 2) as crew, Client(crew.address, set_as_default=False) as client:
            client.gather(client.map(_nothing, range(20), pure=False))
            began = time.monotonic()
            client.gather(client.map(_nothing, range(options.tasks), pure=False))
            task = (time.monotonic() - began) / options.tasks
        lay_stubs(folder / "in", 20, 1.0)
        plans = plans_of(folder / "in", folder / "out")
        began = time.monotonic()
        for plan in plans:
            order_of(plan, str(folder / "in"), folder / "in", str(folder / "out"), 1)
        give = (time.monotonic() - began) / len(plans)
        bring, accept = brought(folder)
    return {
        "start": round(start / 3, 3),
        "scheduler": round(task, 5),
        "give out": round(give, 5),
        "bring": round(bring, 3),
        "accept": round(accept, 4),
    }


def _nothing(_: int) -> None:
    """A task that does nothing."""


def brought(folder: Path) -> tuple[float, float]:
    """Seconds to bring a case of usual size to a folder, and to accept it: medians of five."""
    case, cases = folder / "case", CasesInFolder(folder / "cases")
    case.mkdir()
    chance = np.random.default_rng(1)
    for number in range(CASE_FILES):
        content = chance.integers(256, size=CASE_MB * 1_000_000 // CASE_FILES, dtype=np.uint8)
        (case / f"{number}").write_bytes(content.tobytes())
    cases.begin()
    times: list[tuple[float, float]] = []
    for number in range(5):
        began = time.monotonic()
        total = cases.bring(case, f"P{number}", f"{number}", _go_on)
        there = time.monotonic()
        cases.accept(f"P{number}", f"{number}", "", total)
        times.append((there - began, time.monotonic() - there))
    return float(np.median([one for one, _ in times])), float(np.median([one for _, one in times]))


def _go_on() -> None:
    """Nobody asks to stop."""


@dataclass
class Station:
    """Something that all workers share, and that serves one after the other."""

    free_at: float = 0.0
    busy_s: float = 0.0

    def serve(self, now: float, seconds: float) -> float:
        self.free_at = max(now, self.free_at) + seconds
        self.busy_s += seconds
        return self.free_at


def simulated(
    parts: dict[str, float], workers: int, store_mb_a_s: float, case_s: float
) -> dict[str, Any]:
    """A batch of ten cases a worker: each passes scheduler, store, worker, store, acceptance."""
    chance = np.random.default_rng(1)
    names = ("scheduler", "reading", "writing", "accepting")
    stations = {name: Station() for name in names}
    begin = [(0.0, worker) for worker in range(workers)]
    cases, last, waiting = 10 * workers, 0.0, [(at, 0, worker) for at, worker in begin]
    heapq.heapify(waiting)
    left = cases
    while waiting:
        now, step, worker = heapq.heappop(waiting)
        match step:
            case 0:
                if not left:
                    continue
                left -= 1
                at = stations["scheduler"].serve(now, parts["scheduler"] + parts["give out"])
                heapq.heappush(waiting, (at, 1, worker))
            case 1:
                at = stations["reading"].serve(now, PHOTOS_MB / store_mb_a_s)
                at = max(at, now + PHOTOS_MB / LINK_MB_A_S)
                work_s = case_s * float(chance.lognormal(-0.045, 0.3)) + parts["start"]
                heapq.heappush(waiting, (at + work_s, 2, worker))
            case 2:
                at = stations["writing"].serve(now, CASE_MB / store_mb_a_s)
                at = max(at, now + CASE_MB / LINK_MB_A_S)
                heapq.heappush(waiting, (at, 0, worker))
                heapq.heappush(waiting, (at, 3, worker))
            case _:
                last = max(last, stations["accepting"].serve(now, parts["accept"]))
    busy = {name: round(station.busy_s / last, 3) for name, station in stations.items()}
    return {
        "workers": workers,
        "store_mb_a_s": store_mb_a_s,
        "cases_an_hour": round(cases / last * 3600),
        "efficiency": round(cases * case_s / last / workers, 3),
        "busy": busy,
        "fullest": max(busy, key=lambda name: busy[name]),
    }


def two_workers(start_s: float) -> list[dict[str, Any]]:
    """Speed-up of one case on two workers: at most, and with what it costs to part it."""
    rows: list[dict[str, Any]] = []
    for file in ("cost.json", "growth.json"):
        for name, told in json.loads((HERE / "results" / file).read_text())["sets"].items():
            runs = told.get("limbgram") or [{}]
            stages = runs[0].get("stages", ())
            if not stages:
                continue
            total = sum(one["wall_s"] for one in stages)
            parted = sum(one["wall_s"] for one in stages if one["stage"] in BY_PHOTO_OR_PAIR)
            moved_s = told["photos"] * CASE_MB / 15 / LINK_MB_A_S
            rows.append({
                "set": name,
                "photos": told["photos"],
                "megapixels": told["megapixels"],
                "seconds": round(total, 1),
                "share": round(parted / total, 3),
                "at_most": round(total / (total - parted / 2), 2),
                "with_costs": round(total / (total - parted / 2 + start_s + moved_s), 2),
            })  # fmt: skip
    return rows


def page(report: dict[str, Any]) -> str:
    made_on, load = report["machine"], report["load_before"]
    return "\n".join((
        "# How a batch scales",
        "",
        "A laboratory notebook: made by `benchmarks/scaling.py`, each figure measured once, on a "
        f"machine with {made_on['cores']} cores that had other work (load {load}).",
        "",
        *_on_one_machine(report),
        *_on_many_machines(report),
        *_on_two_workers(report["one_case_on_two"]),
        json.dumps(made_on),
        "",
    ))  # fmt: skip


def _on_one_machine(report: dict[str, Any]) -> Iterator[str]:
    parts = report["parts_s"]
    alone = next((row["seconds"] for row in report["here"] if row["workers"] == 1), None)
    yield from (
        "## On one machine",
        "",
        f"{report['captures']} captures of a stub that sleeps for {report['stub_s']:g} s, each in "
        "the processes of a real one:",
        "",
        "| workers | s | speed-up | beside the work, s a case |",
        "|---|---|---|---|",
    )
    for row in report["here"]:
        faster = "" if alone is None else format(alone / row["seconds"], ".2f")
        yield f"| {row['workers']} | {row['seconds']} | {faster} | {row['overhead_a_case_s']} |"
    yield from (
        "",
        f"Beside the work a case costs: starting its process ({parts['start']:.1f} s of one "
        f"processor, most of it loading programs), a task of the scheduler "
        f"({1000 * parts['scheduler']:.1f} ms), giving it out ({1000 * parts['give out']:.1f} ms), "
        f"bringing {CASE_MB} MB in {CASE_FILES} files to the disk ({parts['bring']:.1f} s), and "
        f"accepting it ({1000 * parts['accept']:.1f} ms).",
        "",
    )


def _on_many_machines(report: dict[str, Any]) -> Iterator[str]:
    yield from (
        "## On many machines, simulated",
        "",
        f"Cases of {report['case_s']:g} s on average, {PHOTOS_MB} MB of photos in and {CASE_MB} MB "
        "out, ten a worker, with the costs above. Every worker has 1 Gbit/s; all share a store, a "
        "scheduler, and the one process that accepts. Efficiency is the share of the workers' "
        "time that is spent on cases. Nothing of this was run on so many machines.",
        "",
        "| workers | store, MB/s | cases an hour | efficiency | fullest | busy |",
        "|---|---|---|---|---|---|",
    )
    for row in report["simulated"]:
        yield (
            f"| {row['workers']} | {row['store_mb_a_s']:g} | {row['cases_an_hour']:,} | "
            f"{row['efficiency']:.0%} | {row['fullest']} | {row['busy'][row['fullest']]:.0%} |"
        )
    yield ""


def _on_two_workers(rows: list[dict[str, Any]]) -> Iterator[str]:
    enough = [row["set"] for row in rows if row["with_costs"] >= NEEDED]
    yield from (
        "## One case on two workers",
        "",
        "If the stages that work photo by photo or pair by pair were parted between two workers "
        "without loss, one case would be faster by the first number at most. Starting the second "
        "process and moving the products of the stages at 1 Gbit/s leaves the second. Both are "
        f"bounds from above: inside these stages, too, some things are done once. It was to be "
        f"built where two workers bring {NEEDED}.",
        "",
        "| capture | photos x MP | s | at most | with costs |",
        "|---|---|---|---|---|",
    )
    for row in rows:
        yield (
            f"| {row['set']} | {row['photos']} x {row['megapixels']:.0f} | {row['seconds']} | "
            f"{row['at_most']} | {row['with_costs']} |"
        )
    yield from (
        "",
        f"{len(enough)} of {len(rows)} captures could reach {NEEDED} even so"
        f"{': ' + ', '.join(enough) if enough else ''}. An ordinary capture cannot; for the large "
        "ones this is a bound, not a measurement. A machine with twice the processors brings the "
        "same without moving anything, and it was not built: one case stays on one machine.",
        "",
    )


if __name__ == "__main__":
    main()
