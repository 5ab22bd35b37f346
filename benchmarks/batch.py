"""Batch: a folder of captures, good and bad, done by one command while its processes are killed.

One small synthetic capture is made; its copies lack another photo each, half of them are zips.
Beside them lie captures that cannot be done: one photo, text named as photos, a zip bomb, a zip
that leaves its folder, settings with a slip. The folder is done once undisturbed, and once while
processes are killed at random moments (SIGKILL: a worker, or the command itself, which is then
started again). Whatever has a result must hold the same bytes both times and as
`limbgram reconstruct` makes them alone; whatever has none must say why. Then the command runs once
more and must compute nothing.

    python benchmarks/batch.py --kills 10 -o benchmarks/results/batch.json
    python benchmarks/batch.py --data DATA --keep FOLDER -o benchmarks/results/batch-real.json

With --data the captures of DATA (`rendered/SET`, `photos/flowerpot`) are done in one batch by one
settings file; and once more under kills, if --kills is given with it.
"""

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from harness import asking, machine, working_in, write
from kills import COMMAND, contents, difference, done

HERE = Path(__file__).parent
SETTINGS = """
camera = "camera.json"
side = "left"
[align]
axis = "+z"
anterior = "+y"
[measure]
every_mm = 20
[[export]]
to = "aop"
"""
REAL = """
photos = "images"
side = "left"
[align]
axis = "+z"
anterior = "+y"
[measure]
every_mm = 20
[[export]]
to = "stl"
[report]
"""
FLOWERPOT = """[capture.flowerpot]
board = "none"
known_distances = "flowerpot_picks.json"
side = "none"
"""
RENDERED = {
    "limb_ring15": "limb_ring15",
    "limb_sparse15": "limb_ring15",
    "foot_ring24": "foot_ring24",
}
"""Rendered sets, and the set whose board photos calibrate the camera of each."""


def main() -> None:
    asked = asking(__doc__)
    asked.add_argument("--captures", type=int, default=6, help="good ones")
    asked.add_argument("--kills", type=int, help="10 if not given, with --data none")
    asked.add_argument("--every-s", type=float, default=8.0, help="between kills, on average")
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--photos", type=int, default=14)
    asked.add_argument("--width", type=int, default=600)
    asked.add_argument("--at-once", type=int, default=2)
    asked.add_argument("--data", type=Path, help="do the captures that lie there instead")
    asked.add_argument("--sets", nargs="+", help="only these of DATA, if not all")
    asked.add_argument("--keep", type=Path, help="work in this folder, and keep it")
    options = asked.parse_args()
    if options.kills is None:
        options.kills = 10 if options.data is None else 0
    with working_in(options.keep) as folder:
        report = killed_and_not(folder, options) if options.data is None else real(folder, options)
    report = {**report, "seed": options.seed, "machine": machine()}
    write(options.out, report)
    sys.stdout.write(page(report))
    if report["wrong"]:
        raise SystemExit(1)


def killed_and_not(folder: Path, options: argparse.Namespace) -> dict[str, Any]:
    inside = laid(folder, options)
    alone = folder / "alone"
    done(
        "reconstruct",
        str(inside / "P01"),
        "--camera",
        str(inside / "camera.json"),
        "-o",
        str(alone),
    )
    words = ["batch", str(inside), "-o"]
    began = time.monotonic()
    code = ended(started([*words, str(folder / "undisturbed")], options))
    undisturbed_s = time.monotonic() - began
    kills, killed_code = disturbed([*words, str(folder / "killed")], options)
    began = time.monotonic()
    again_code = ended(started([*words, str(folder / "killed")], options))
    again_s = time.monotonic() - began
    first, second = outcomes(folder / "undisturbed"), outcomes(folder / "killed")
    rows = [
        {
            "capture": name,
            "undisturbed": told(first[name]),
            "killed": told(second[name]),
            "message": first[name]["message"],
            "difference": compared(folder, name, first[name]),
        }
        for name in first
    ]
    reference = contents(folder / "undisturbed" / "P01")
    apart = {name: held for name, held in contents(alone).items() if name != "case.json"}
    wrong = [row["capture"] for row in rows if row["difference"]]
    wrong += (
        ["P01 alone"] if any(reference.get(name) != held for name, held in apart.items()) else []
    )
    wrong += [
        row["capture"]
        for row in rows
        if row["undisturbed"].replace("finished", "unchanged") != row["killed"]
    ]
    left = [str(path) for path in (folder / "killed").rglob(".*.part*")]
    return {
        "wrong": wrong + left,
        "captures": rows,
        "exit_codes": {"undisturbed": code, "killed": killed_code, "again": again_code},
        "kills": kills,
        "at_once": options.at_once,
        "undisturbed_s": round(undisturbed_s, 1),
        "again_s": round(again_s, 1),
        "files_compared_with_alone": len(apart),
    }


def laid(folder: Path, options: argparse.Namespace) -> Path:
    """The folder of captures."""
    capture, inside = folder / "capture", folder / "in"
    size = ["--photos", str(options.photos), "--width", str(options.width)]
    done("make-capture", str(capture), *size, "--seed", str(options.seed + 10))
    inside.mkdir()
    board = ["--board", "14x10", "--square", "10"]
    done("calibrate", str(capture / "calibration"), *board, "-o", str(inside / "camera.json"))
    (inside / "batch.toml").write_text(SETTINGS)
    photos = sorted((capture / "images").iterdir())
    for number in range(1, options.captures + 1):
        taken = [photo for k, photo in enumerate(photos, 1) if k != number]
        if number % 2:
            (inside / f"P{number:02d}").mkdir()
            for photo in taken:
                shutil.copy(photo, inside / f"P{number:02d}")
        else:
            with zipfile.ZipFile(inside / f"P{number:02d}.zip", "w") as archive:
                for photo in taken:
                    archive.write(photo, f"export/{photo.name}")
    (inside / "one photo").mkdir()
    shutil.copy(photos[0], inside / "one photo")
    (inside / "text").mkdir()
    for number in range(4):
        (inside / "text" / f"{number}.jpg").write_text("no photo")
    (inside / "slip").mkdir()
    (inside / "slip" / "capture.toml").write_text('camra = "camera.json"')
    with zipfile.ZipFile(inside / "bomb.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.jpg", bytes(60_000_000))
    with zipfile.ZipFile(inside / "outside.zip", "w") as archive:
        archive.writestr("../../a.jpg", b"a")
    return inside


def disturbed(words: list[str], options: argparse.Namespace) -> tuple[list[dict[str, Any]], int]:
    """Do the batch, and kill its processes until so many kills have hit."""
    chance = np.random.default_rng(options.seed)
    kills: list[dict[str, Any]] = []
    while True:
        process = started([*words, "--attempts", "10"], options)
        stages: dict[str, str] = {}
        listener = threading.Thread(target=listen, args=(process, stages), daemon=True)
        listener.start()
        while process.poll() is None and len(kills) < options.kills:
            time.sleep(float(chance.exponential(options.every_s)))
            kill = killed(process, stages, command=bool(chance.random() < 0.25))
            kills += [kill] if kill else []
        code = process.wait()
        if code != -signal.SIGKILL:
            return kills, code


def listen(process: "subprocess.Popen[str]", stages: dict[str, str]) -> None:
    for line in process.stderr:
        event = json.loads(line) if line.startswith("{") else {}
        if event.get("event") == "progress":
            stages[event["capture"]] = event["stage"]


def killed(
    process: "subprocess.Popen[str]", stages: dict[str, str], *, command: bool
) -> dict[str, Any] | None:
    """Kill the command or one of its workers; what was hit, None where there was nothing."""
    workers = [
        (int(child), case_of(int(child)))
        for task in Path(f"/proc/{process.pid}/task").glob("*/children")
        for child in task.read_text().split()
    ]
    if process.poll() is not None or not (workers or command):
        return None
    pid, who = (process.pid, "the command") if command else workers[0]
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        return None
    return {"who": who, "stages": dict(stages) if command else stages.get(who, "start")}


def case_of(pid: int) -> str:
    """The capture at which a process works."""
    try:
        parts = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return "gone"
    found = [Path(part.decode()) for part in parts if part.startswith(b"/") and b"/killed/" in part]
    return found[0].parts[found[0].parts.index("killed") + 1] if found else "a step"


def real(folder: Path, options: argparse.Namespace) -> dict[str, Any]:
    """The captures of a folder of data, by one settings file."""
    inside = folder / "in"
    inside.mkdir(exist_ok=True)
    text = REAL
    for name, board in RENDERED.items():
        place = options.data / "rendered" / name
        if not place.is_dir() or not wanted(name, options):
            continue
        camera = inside / f"{board}.camera.json"
        if not camera.exists():
            photos = options.data / "rendered" / board / "calibration"
            done("calibrate", str(photos), "--board", "14x10", "--square", "10", "-o", str(camera))
        (inside / name).unlink(missing_ok=True)
        (inside / name).symlink_to(place.resolve())
        kind = 'kind = "foot"\n' if name.startswith("foot") else ""
        text += f'[capture.{name}]\ncamera = "{camera.name}"\n{kind}'
    (inside / "flowerpot").unlink(missing_ok=True)
    if wanted("flowerpot", options):
        (inside / "flowerpot").symlink_to((options.data / "photos" / "flowerpot").resolve())
        shutil.copy(HERE / "flowerpot_picks.json", inside)
        text += FLOWERPOT
    (inside / "batch.toml").write_text(text)
    words = ["batch", str(inside), "-o"]
    began = time.monotonic()
    code = ended(started([*words, str(folder / "undisturbed")], options))
    seconds = time.monotonic() - began
    codes, kills = {"undisturbed": code}, []
    if options.kills:
        kills, codes["killed"] = disturbed([*words, str(folder / "killed")], options)
    found = outcomes(folder / "undisturbed")
    rows = [
        {
            "capture": name,
            "undisturbed": told(one),
            "headline": one["headline"],
            "message": one["message"],
            "steps": {step["name"]: step["message"] or step["state"] for step in one["steps"]},
            "cpu_s": round(sum(stage.get("cpu_s", 0.0) for stage in record(folder, name)), 1),
            "peak_mb": round(
                max((one.get("peak_mb", 0.0) for one in record(folder, name)), default=0)
            ),
            "seconds": one["seconds"],
            "difference": compared(folder, name, one) if options.kills else {},
        }
        for name, one in found.items()
    ]
    wrong = [row["capture"] for row in rows if row["message"] or row["difference"]]
    if options.kills:
        ends = outcomes(folder / "killed")
        wrong += [name for name, one in found.items() if one["light"] != ends[name]["light"]]
        wrong += [str(path) for path in (folder / "killed").rglob(".*.part*")]
    return {
        "wrong": wrong,
        "captures": rows,
        "exit_codes": codes,
        "kills": kills,
        "undisturbed_s": round(seconds, 1),
    }


def wanted(name: str, options: argparse.Namespace) -> bool:
    return options.sets is None or name in options.sets


def record(folder: Path, name: str) -> list[dict[str, Any]]:
    """What the stages of a case cost."""
    return json.loads((folder / "undisturbed" / name / "case.json").read_text()).get("stages", [])


def started(words: list[str], options: argparse.Namespace) -> "subprocess.Popen[str]":
    more = ["--json", "--at-once", str(options.at_once)]
    return subprocess.Popen(
        [*COMMAND, *words, *more], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )


def ended(process: "subprocess.Popen[str]") -> int:
    listen(process, {})
    return process.wait()


def outcomes(cases: Path) -> dict[str, Any]:
    kept = json.loads((cases / "batch.json").read_text())
    return {one["name"]: one for one in kept["captures"]}


def told(outcome: dict[str, Any]) -> str:
    return f"{outcome['state']} {outcome['light'] or ''}".strip()


def compared(folder: Path, name: str, outcome: dict[str, Any]) -> dict[str, list[str]]:
    if outcome["light"] is None:
        return {}
    return difference(contents(folder / "undisturbed" / name), contents(folder / "killed" / name))


def page(report: dict[str, Any]) -> str:
    lines = ["# Batch", ""]
    hits = len(report["kills"])
    commands = sum(kill["who"] == "the command" for kill in report["kills"])
    if "again_s" in report:
        lines += [
            f"{len(report['captures'])} captures, {report['at_once']} at a time, in "
            f"{report['undisturbed_s']} s undisturbed. {hits} kills: {commands} of the command, "
            f"{hits - commands} of workers. Run once more: {report['again_s']} s.",
            "",
            "| capture | undisturbed | after the kills, run once more | bytes | why |",
            "|---|---|---|---|---|",
        ]
        lines += [
            f"| {row['capture']} | {row['undisturbed']} | {row['killed']} | "
            f"{bytes_of(row)} | {row['message'][:90]} |"
            for row in report["captures"]
        ]
    else:
        lines += [
            f"In {report['undisturbed_s']} s undisturbed; once more under {hits} kills: {commands} "
            f"of the command, {hits - commands} of workers.",
            "",
            "| capture | became | CPU s | peak MB | steps | after the kills | verdict |",
            "|---|---|---|---|---|---|---|",
        ]
        lines += [
            f"| {row['capture']} | {row['undisturbed']} | {row['cpu_s']} | {row['peak_mb']} | "
            f"{', '.join(f'{name}: {state}' for name, state in row['steps'].items())} | "
            f"{row['difference'] or 'same bytes' if hits else 'not tried'} | "
            f"{row['headline'] or row['message']} |"
            for row in report["captures"]
        ]
    if hits:
        lines += ["", "| killed | at stage |", "|---|---|"]
        lines += [f"| {kill['who']} | {stage_of(kill)} |" for kill in report["kills"]]
    about = report["machine"]
    lines += ["", f"Exit codes: {report['exit_codes']}. Wrong: {report['wrong'] or 'nothing'}.", ""]
    lines += [f"Seed {report['seed']}. {json.dumps(about)}", ""]
    return "\n".join(lines)


def bytes_of(row: dict[str, Any]) -> str:
    if row["difference"]:
        return f"differ: {row['difference']}"
    return "same" if "green" in row["undisturbed"] or "amber" in row["undisturbed"] else "none"


def stage_of(kill: dict[str, Any]) -> str:
    stages = kill["stages"]
    return stages if isinstance(stages, str) else "; ".join(f"{k}: {v}" for k, v in stages.items())


if __name__ == "__main__":
    main()
