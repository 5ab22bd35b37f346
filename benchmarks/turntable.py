"""Limbs that turn before a still camera, and casts that are turned over, against the exact truth.

    python benchmarks/turntable.py -o benchmarks/results/turntable.json [--first 71] [--seeds 3]

Every capture is made by the project's generator, small, and run through the command line; the
results are written after each with its commit, and a run goes on where an earlier one ended.
`right` is a surface within its own stated error, or red; `refused` says what to do; `wrong` and
`failed` must not be. A red surface may lie too far from the truth to be compared.
"""

import json
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from captures import JUDGED, LIMBGRAM, accuracy, timed
from harness import asking, found_before, machine, working_in, write
from limbgram.synthetic import CaptureOptions, TurnedOver, Turning, make_capture

SMALL = CaptureOptions(
    photos=16,
    width_px=900,
    height_px=600,
    distance_mm=1500.0,
    calibration_photos=0,
    mesh_step_mm=1.5,
    samples=2,
)
SPARSE = 0.12
"""Share of the sock that sparse paint hides."""
SWAY_MM = 6.0
CASES: dict[str, CaptureOptions] = {
    "sparse paint before a patterned screen": replace(SMALL, turning=Turning(), coverage=SPARSE),
    "patterned strips nearer than the limb": replace(SMALL, turning=Turning(before=True)),
    "patient on a stool who sways": replace(
        SMALL, turning=Turning(sway_mm=SWAY_MM, before=True), coverage=0.3
    ),
    "board that stands still": replace(SMALL, turning=Turning(board_turns=False)),
    "cast turned over": replace(SMALL, turning=TurnedOver(), photos=32),
    "cast turned over, sparse paint": replace(
        SMALL, turning=TurnedOver(), photos=32, coverage=SPARSE
    ),
    "walk round, nothing stands still": SMALL,
}
WITHIN = 3.0
"""A surface is wrong if its error is more than this many times the error that it states, and no red
light warns of it."""


def main() -> None:
    parser = asking(__doc__, keep="captures and cases")
    parser.add_argument("--first", type=int, default=71, help="first seed")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--only", nargs="*", help="these cases alone")
    chosen = parser.parse_args()
    found = found_before(chosen.out, {"runs": []})
    found["machine"] = machine()
    with working_in(chosen.keep) as folder:
        camera = calibrated(folder)
        for seed in range(chosen.first, chosen.first + chosen.seeds):
            for name in chosen.only or CASES:
                if any((run["case"], run["seed"]) == (name, seed) for run in found["runs"]):
                    continue
                made = {"commit": found["machine"]["commit"][:12]}
                found["runs"].append(one(name, seed, camera, folder) | made)
                write(chosen.out, found)
                sys.stderr.write(f"{name}, seed {seed}: {found['runs'][-1]['outcome']}\n")


def calibrated(folder: Path) -> Path:
    """The camera file of all captures: they have one lens."""
    camera, source = folder / "camera.json", folder / "calibration"
    if not camera.exists():
        if not source.exists():
            make_capture(source, replace(SMALL, seed=1, photos=3, calibration_photos=12))
        board = ["--board", "14x10", "--square", "10", "-o", str(camera)]
        timed([LIMBGRAM, "calibrate", str(source / "calibration"), *board])
    return camera


def one(name: str, seed: int, camera: Path, folder: Path) -> dict[str, Any]:
    """Make a capture, reconstruct it, compare it with its truth."""
    label = f"{list(CASES).index(name)}-{seed}"
    source, case = folder / label, folder / f"{label}-case"
    if not source.exists():
        make_capture(source, replace(CASES[name], seed=seed))
    shutil.rmtree(case, ignore_errors=True)
    command = [LIMBGRAM, "reconstruct", str(source / "images"), "--camera", str(camera)]
    run = timed([*command, "-o", str(case), "--json"])
    told: dict[str, Any] = {"case": name, "seed": seed, "photos": CASES[name].photos, "run": run}
    if run["exit_code"] not in JUDGED:
        refused = '"event": "refused"' in run["message"]
        return told | {"outcome": "refused" if refused else "failed", "said": run["message"]}
    summary = json.loads((case / "summary.json").read_text("utf-8"))
    judged = accuracy(case, source)
    truth, stated, red = judged["truth"], stated_rms_mm(judged), judged["light"] == "red"
    if truth is None:
        outcome = "right" if red else "wrong"
        return told | {"outcome": outcome, "light": judged["light"], "said": judged["headline"]}
    return told | {
        "outcome": "right" if red or truth["rms_mm"] < WITHIN * stated else "wrong",
        "light": judged["light"],
        "headline": judged["headline"],
        "placed": summary["scene"]["placed"],
        "notes": summary["scene"]["notes"],
        "rms_mm": truth["rms_mm"],
        "p95_mm": truth["p95_mm"],
        "stated_rms_mm": stated,
        "scale_error": truth["scale_error"],
        "volume_error": truth["volume_error"],
        "open_edges": summary["mesh"]["open_edges"],
        "filled_share": summary["mesh"]["filled_share"],
        "bodies": max(1, len(summary["parts"])),
    }


def stated_rms_mm(judged: dict[str, Any]) -> float:
    (row,) = (one for one in judged["criteria"] if one["key"] == "surface_rms")
    return float(row["value"])


def page(found: dict[str, Any]) -> str:
    """The runs as a table."""
    at = found["machine"]
    versions = ", ".join(f"{name} {one}" for name, one in at["versions"].items())
    heads = (
        "capture", "seed", "outcome", "verdict", "placed", "RMS mm", "95 % mm", "stated RMS mm",
        "scale", "open edges", "filled", "bodies", "CPU s",
    )  # fmt: skip
    lines = [
        "# turntable",
        "",
        f"{at['processor']}, {at['cores']} cores, {at['memory_gb']:.0f} GB; {at['system']}; Python "
        f"{at['python']}; commit {at['commit'][:12]}; {versions}",
        "",
        f"| {' | '.join(heads)} |",
        f"|{' --- |' * len(heads)}",
    ]
    for run in found["runs"]:
        cells = [run["case"], str(run["seed"]), run["outcome"]]
        if "rms_mm" not in run:
            cells += [run.get("light", ""), *[""] * 8]
        else:
            cells += [
                run["light"], f"{run['placed']} of {run['photos']}", f"{run['rms_mm']:.3f}",
                f"{run['p95_mm']:.3f}", f"{run['stated_rms_mm']:.3f}",
                f"{run['scale_error']:+.3%}", str(run["open_edges"]),
                f"{run['filled_share']:.1%}", str(run["bodies"]),
            ]  # fmt: skip
        lines.append(f"| {' | '.join([*cells, format(run['run']['cpu_s'], '.0f')])} |")
    refusals = [run for run in found["runs"] if "rms_mm" not in run]
    if refusals:
        lines += ["", "## What was refused, failed, or cannot be compared", ""]
        lines += [f"- {one['case']}, seed {one['seed']}: {_words(one['said'])}" for one in refusals]
    return "\n".join(lines) + "\n"


def _words(said: str) -> str:
    """The refusal in what was printed, or its last line."""
    last = said.strip().splitlines()[-1] if said.strip() else ""
    try:
        return str(json.loads(last)["message"])
    except (ValueError, KeyError, TypeError):
        return last


if __name__ == "__main__":
    main()
