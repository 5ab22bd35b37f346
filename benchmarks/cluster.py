"""Cluster: captures done by a Dask cluster while everything that can fail there fails.

    python benchmarks/cluster.py kills --count 40 --kills 20 -o results/cluster-kills.json
    python benchmarks/cluster.py bytes --captures 2 -o results/cluster-bytes.json

kills   A stub takes the place of the reconstruction, a few seconds a capture. While four workers
        work, processes are killed (SIGKILL: workers, attempts, jobs), two workers sleep (SIGSTOP)
        longer than the scheduler waits for them and wake again, the scheduler is killed and
        started anew, one worker has a full disk, and the network of one is cut and mended. Every
        capture must then be done, with the bytes that it should have, or be reported.
bytes   A small synthetic capture, of which each copy lacks another photo, is reconstructed alone,
        in a batch on this machine, by clusters of 1, 2 and 4 workers, and by two workers while
        processes are killed: every file must have the same bytes, but for times.
"""

import argparse
import hashlib
import json
import shutil
import signal
import subprocess
import sys
import threading
import time
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import psutil

from batch import SETTINGS
from crew import NET, Crew, cable, crew_of, far_network, lay_stubs, small_disk, stub_sha256
from harness import asking, machine, write
from kills import COMMAND, contents, difference, done
from limbgram.batch.attempt import Plan
from limbgram.batch.captures import find_captures
from limbgram.batch.cluster import ClusterOptions, ClusterRun
from limbgram.batch.settings import Batch
from limbgram.cases.job_messages import Job


def main() -> None:
    asked = asking(__doc__.partition("\n")[0])
    asked.add_argument("what", choices=("kills", "bytes"))
    asked.add_argument("--count", type=int, default=40, help="captures of the stub")
    asked.add_argument("--captures", type=int, default=2, help="captures that are reconstructed")
    asked.add_argument("--kills", type=int, default=20)
    asked.add_argument("--seconds", type=float, default=3.0, help="that the stub works")
    asked.add_argument("--every-s", type=float, default=3.0, help="between kills, on average")
    asked.add_argument("--workers", type=int, nargs="*", default=[1, 2, 4])
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--made", type=Path, help="folder that has capture/ and camera.json")
    options = asked.parse_args()
    with TemporaryDirectory(prefix="limbgram-cluster-", ignore_cleanup_errors=True) as scratch:
        tried = kills if options.what == "kills" else same_bytes
        report = tried(Path(scratch), options)
    report = {**report, "seed": options.seed, "machine": machine()}
    write(options.out, report)
    sys.stdout.write(page(report))
    if report["wrong"]:
        raise SystemExit(1)


def kills(folder: Path, options: argparse.Namespace) -> dict[str, Any]:
    """A batch of stubs, and what became of it."""
    inside, out = folder / "in", folder / "out"
    lay_stubs(inside, options.count, options.seconds)
    ended, told, events = threading.Event(), list[dict[str, Any]](), list[dict[str, Any]]()
    with ExitStack() as held:
        crew = held.enter_context(crew_of(folder, 2))
        full = held.enter_context(small_disk(folder / "full", 1))
        far = held.enter_context(far_network())
        if full is not None:
            crew.workers.remove(crew.worker(full))  # nobody kills it
        words = (crew, options, far, ended, told)
        foe = threading.Thread(target=disturb, args=words, daemon=True)
        plans = [
            Plan(capture=one, job=Job(case=out / one.name, sources=()))
            for one in find_captures(inside, Batch(), out)
        ]
        run = ClusterRun(
            plans,
            ClusterOptions(
                address=crew.address, captures=str(inside), folder=inside, cases=str(out),
                attempts=8, module="stub_attempt",
            ),
            events.append,
        )  # fmt: skip
        foe.start()
        began = time.monotonic()
        outcomes = run.wait()
        seconds = time.monotonic() - began
        ended.set()
        foe.join(60)
        time.sleep(3.0)  # whoever woke late may try to write
    rows = [
        {
            "capture": one.name,
            "state": one.state,
            "begun": one.attempts,
            "answers": sum(result.outcome.name == one.name for result in run.results),
            "whole": is_whole(out / one.name, one.name),
            "message": one.message,
        }
        for one in outcomes
    ]
    wrong = [row["capture"] for row in rows if row["state"] == "finished" and not row["whole"]]
    wrong += [row["capture"] for row in rows if row["state"] != "finished" and not row["message"]]
    left = sorted(path.name for path in out.iterdir() if path.name.startswith("."))
    left += [path.name for path in folder.glob("scratch/**/limbgram-attempt-*")]
    return {
        "captures": rows,
        "disturbed": told,
        "seconds": round(seconds, 1),
        "scheduler_lost": sum(event["event"] == "lost" for event in events),
        "left_behind": left,
        "wrong": wrong,
        "had_small_disk": full is not None,
        "had_far_network": far is not None,
    }


def is_whole(case: Path, name: str) -> bool:
    """Whether the files of the stub are there, with their bytes, and no others."""
    files = {
        path.relative_to(case).as_posix(): path for path in case.rglob("*")
        if path.is_file() and path.name != ".lock"
    }  # fmt: skip
    made = ("batch/done.json", "deliverables/surface.ply", "log.txt", "summary.json")
    wanted = {*made, "case.json"}
    if set(files) != wanted:
        return False
    content = files["deliverables/surface.ply"].read_bytes()
    return hashlib.sha256(content).hexdigest() == stub_sha256(name)


def disturb(
    crew: Crew,
    options: argparse.Namespace,
    far: tuple[str, ...] | None,
    ended: threading.Event,
    told: list[dict[str, Any]],
) -> None:
    """Do harm until the batch has ended; workers that are gone are started anew."""
    chance, began = np.random.default_rng(options.seed), time.monotonic()
    lone = None if far is None else far_worker(crew, far)
    killed, slept, other = 0, 0, ["network"] * (lone is not None) + ["scheduler"]
    while not ended.wait(float(chance.exponential(options.every_s))):
        for process in [one for one in crew.workers if one.poll() is not None]:
            crew.workers.remove(process)
            crew.worker()
        at = {"at_s": round(time.monotonic() - began, 1)}
        if killed in (5, 10) and slept < killed // 5:
            slept += 1
            told.append({"what": "SIGSTOP", **at, **asleep(crew, chance, ended)})
        elif other and killed >= 8 and killed % 4 == 0:
            what = other.pop()
            told.append({"what": what, **at, **(cut(ended) if what == "network" else anew(crew))})
        elif killed < options.kills:
            hit = kill_one(crew, chance)
            killed += hit is not None
            told += [{"what": "SIGKILL", **at, **hit}] if hit else []


def far_worker(crew: Crew, far: tuple[str, ...]) -> "subprocess.Popen[bytes]":
    port = crew.address.rpartition(":")[2]
    return crew.worker(None, *far, address=f"tcp://{NET[0]}:{port}")


def kill_one(crew: Crew, chance: np.random.Generator) -> dict[str, Any] | None:
    """Kill a worker or one of the processes below it."""
    trees = [tree(one.pid) for one in crew.workers if one.poll() is None]
    found = [tree for tree in trees if len(tree) > 1]
    if not found:
        return None
    chosen = found[int(chance.integers(len(found)))]
    place = int(chance.integers(len(chosen)))
    try:
        chosen[place].send_signal(signal.SIGKILL)
    except psutil.NoSuchProcess:
        return None
    return {"who": ("worker", "attempt", "job")[min(place, 2)]}


def tree(pid: int) -> list[psutil.Process]:
    """A worker and what it started, in this order; of a worker elsewhere, without its starter."""
    try:
        top = psutil.Process(pid)
        return [top, *top.children(recursive=True)]
    except psutil.NoSuchProcess:
        return []


def asleep(crew: Crew, chance: np.random.Generator, ended: threading.Event) -> dict[str, Any]:
    """Let a worker and all below it sleep for longer than the scheduler waits, then wake it."""
    busy = [found for one in crew.workers if len(found := tree(one.pid)) > 1] or [[]]
    chosen = busy[int(chance.integers(len(busy)))]
    for one in chosen:
        one.suspend()
    seconds = 3 * crew.ttl_s
    ended.wait(seconds)
    for one in reversed(chosen):
        if one.is_running():
            one.resume()
    return {"who": f"{len(chosen)} processes of a worker", "seconds": seconds}


def cut(ended: threading.Event) -> dict[str, Any]:
    cable(up=False)
    ended.wait(20.0)
    cable(up=True)
    return {"who": "cable of one worker", "seconds": 20.0}


def anew(crew: Crew) -> dict[str, Any]:
    assert crew.head is not None
    crew.head.kill()
    crew.head.wait()
    time.sleep(2.0)
    crew.scheduler()
    return {"who": "scheduler", "seconds": 2.0}


def same_bytes(folder: Path, options: argparse.Namespace) -> dict[str, Any]:
    """The same captures by every way, and where bytes differ."""
    inside = laid(folder, options)
    words = ["--camera", str(inside / "camera.json")]
    done("reconstruct", str(inside / "P01"), *words, "-o", str(folder / "alone"))
    rows = [way(folder, "batch", ["--at-once", "2"])]
    rows += [
        way(folder, f"cluster {count}", ["--cluster", f"local:{count}"])
        for count in options.workers
    ]
    if options.kills:
        rows.append(way_killed(folder, options))
    names = sorted(path.name for path in (folder / "batch").iterdir() if path.is_dir())
    held = {name: contents(folder / "batch" / name) for name in names}
    alone = contents(folder / "alone")
    apart = {
        name for name, text in alone.items() if held["P01"].get(name) != text
    } - {"case.json"}  # fmt: skip
    for row in rows:
        row["differs"] = {
            name: found
            for name in names
            if (found := difference(held[name], contents(folder / row["way"] / name)))
        }
    wrong = [row["way"] for row in rows if row["differs"] or row["exit_code"]]
    return {
        "captures": len(names),
        "files_a_case": len(held["P01"]),
        "alone_differs": sorted(apart),
        "ways": rows,
        "wrong": wrong + sorted(apart),
    }


def laid(folder: Path, options: argparse.Namespace) -> Path:
    made = options.made or folder
    if options.made is None:
        size = ["--photos", "14", "--width", "600", "--seed", str(options.seed + 20)]
        done("make-capture", str(folder / "capture"), *size)
        board = ["--board", "14x10", "--square", "10"]
        photos = str(folder / "capture" / "calibration")
        done("calibrate", photos, *board, "-o", str(folder / "camera.json"))
    inside = folder / "in"
    inside.mkdir()
    shutil.copy(made / "camera.json", inside)
    (inside / "batch.toml").write_text(SETTINGS)
    photos = sorted((made / "capture" / "images").iterdir())
    for number in range(1, options.captures + 1):
        (inside / f"P{number:02d}").mkdir()
        for k, photo in enumerate(photos, 1):
            if k != number:
                shutil.copy(photo, inside / f"P{number:02d}")
    return inside


def way(folder: Path, name: str, words: list[str]) -> dict[str, Any]:
    began = time.monotonic()
    command = [*COMMAND, "batch", str(folder / "in"), "-o", str(folder / name), *words, "--json"]
    ended = subprocess.run(command, check=False, capture_output=True)
    row = {
        "way": name,
        "exit_code": ended.returncode,
        "seconds": round(time.monotonic() - began, 1),
    }
    table = json.loads(ended.stdout)
    row["begun"] = {one["name"]: one["attempts"] for one in table.get("captures", [])}
    return row


def way_killed(folder: Path, options: argparse.Namespace) -> dict[str, Any]:
    """Two workers, of which processes are killed until the batch has ended."""
    ended, told = threading.Event(), list[dict[str, Any]]()
    with crew_of(folder, 2) as crew:

        def harm() -> None:
            chance = np.random.default_rng(options.seed)
            while not ended.wait(float(chance.exponential(options.every_s))):
                for process in [one for one in crew.workers if one.poll() is not None]:
                    crew.workers.remove(process)
                    crew.worker()
                hit = kill_one(crew, chance) if len(told) < options.kills else None
                told.extend([hit] if hit else [])

        foe = threading.Thread(target=harm, daemon=True)
        foe.start()
        row = way(folder, "killed", ["--cluster", crew.address, "--attempts", "10"])
        ended.set()
        foe.join()
    return {**row, "kills": [kill["who"] for kill in told]}


def page(report: dict[str, Any]) -> str:
    """What came of killing, or which bytes are the same."""
    return _page_of_kills(report) if "disturbed" in report else _page_of_bytes(report)


def _page_of_kills(report: dict[str, Any]) -> str:
    rows = report["captures"]
    states = {state: sum(row["state"] == state for row in rows) for state in
              sorted({row["state"] for row in rows})}  # fmt: skip
    counts = {what: sum(one["what"] == what for one in report["disturbed"]) for what in
              ("SIGKILL", "SIGSTOP", "scheduler", "network")}  # fmt: skip
    whole = sum(row["whole"] for row in rows)
    often = {n: sum(row["begun"] == n for row in rows) for n in
             sorted({row["begun"] for row in rows})}  # fmt: skip
    return "\n".join((
        "# A cluster on which everything fails",
        "",
        f"{len(rows)} captures of a stub in {report['seconds']} s. What became of them: "
        f"{', '.join(f'{count} {state}' for state, count in states.items())}; {whole} cases are "
        f"whole with the bytes that they should have. Left behind: "
        f"{', '.join(report['left_behind']) or 'nothing'}. Wrong: "
        f"{', '.join(report['wrong']) or 'nothing'}.",
        "",
        "| what was done to the cluster | times |",
        "|---|---|",
        *(f"| {what} | {count} |" for what, count in counts.items()),
        f"| a worker with a full disk | {int(report['had_small_disk'])} |",
        "",
        "| a capture was begun | captures |",
        "|---|---|",
        *(f"| {times} times | {count} |" for times, count in often.items()),
        "",
        "| capture | became | begun | answers taken | whole | why |",
        "|---|---|---|---|---|---|",
        *(
            f"| {row['capture']} | {row['state']} | {row['begun']} | {row['answers']} | "
            f"{'yes' if row['whole'] else 'no'} | {row['message'][:90]} |"
            for row in rows
        ),
        "",
        "| after s | what | who |",
        "|---|---|---|",
        *(f"| {one['at_s']} | {one['what']} | {one['who']} |" for one in report["disturbed"]),
        "",
        f"Seed {report['seed']}. {json.dumps(report['machine'])}",
        "",
    ))  # fmt: skip


def _page_of_bytes(report: dict[str, Any]) -> str:
    return "\n".join((
        "# The same bytes by every way",
        "",
        f"{report['captures']} small captures, {report['files_a_case']} files a case compared with "
        "the batch on one machine, without times. Alone: "
        f"{', '.join(report['alone_differs']) or 'the same bytes'}.",
        "",
        "| way | s | attempts begun | kills | bytes |",
        "|---|---|---|---|---|",
        *(
            f"| {row['way']} | {row['seconds']} | "
            f"{', '.join(f'{name}: {count}' for name, count in row['begun'].items())} | "
            f"{', '.join(row.get('kills', [])) or 'none'} | "
            f"{json.dumps(row['differs']) if row['differs'] else 'the same'} |"
            for row in report["ways"]
        ),
        "",
        f"Seed {report['seed']}. {json.dumps(report['machine'])}",
        "",
    ))  # fmt: skip


if __name__ == "__main__":
    main()
