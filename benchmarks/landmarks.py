"""Landmarks: those of a marked visit, proposed on a later scan of the same limb, against the truth.

    python benchmarks/landmarks.py DATA --half report -o benchmarks/results/landmarks.json
    python benchmarks/landmarks.py DATA --half choose -o FILE

Pairs of visits are made of one surface (`visits.py` says how). Truth is where the skin at the
landmark went: its place in the triangle on which it lay. Where the ankle turns, the skin within
10 mm of a malleolus stays with the bone, and the turn sets in over 15 mm more (`Repose`): whether
living skin does so is not known. The allowance that is assumed for skin that slides
(`CarriedPlace.sliding_mm`) is counted apart: inside with all that is stated, and without it.

Errors are counted along the surface, as they are stated; one is inside where it is shorter than
2.448 standard deviations of one direction. Constants of the program are chosen on `--half choose`,
on other shapes and seeds than `report`. What stands in OUT already is kept, with its commit.
"""

import argparse
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from harness import asking, found_before, machine, write
from landmark_tables import rms
from limbgram.core.errors import LimbgramError
from limbgram.services.align import propose
from visits import MAN_MM, Subject, subjects_of, visits


def main() -> None:
    parser = asking(__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("--half", choices=("choose", "report"), default="report")
    parser.add_argument("--pairs", type=int, default=16, help="of each kind")
    parser.add_argument("--only", nargs="*", default=[], help="these kinds alone")
    chosen = parser.parse_args()
    run(chosen)


def run(chosen: argparse.Namespace) -> None:
    """Every pair that is not in OUT yet, in turns of the kinds."""
    result = found_before(chosen.out, {"half": chosen.half, "pairs": {}})
    result["machine"] = machine()
    kinds = [one for one in MAN_MM if not chosen.only or one in chosen.only]
    subjects = {kind: subjects_of(kind, chosen.data, chosen.half) for kind in kinds}
    for number in range(chosen.pairs):
        for kind in kinds:
            subject = subjects[kind][number % len(subjects[kind])]
            seed = 2 * number + (chosen.half == "report")
            name = f"{kind} / {subject.name} / {seed}"
            if name in result["pairs"]:
                continue
            row = _measured(subject, seed)
            row["commit"] = result["machine"]["commit"]
            result["pairs"][name] = row
            write(chosen.out, result)
            sys.stderr.write(f"{name}: {_line(row)}\n")


def _line(row: dict[str, Any]) -> str:
    if row["refused"]:
        return row["refused"]
    told = [one for one in row["landmarks"].values() if "off_mm" in one]
    off = [one["off_mm"] for one in told]
    ratio = [one["off_mm"] / np.hypot(one["carrying_mm"], one["sliding_mm"]) for one in told]
    return (
        f"{len(off)} of {len(row['landmarks'])}, RMS {rms(off):.2f} mm, "
        f"over sigma {rms(ratio) / np.sqrt(2):.2f}, {row['cpu_s']} s"
    )


def _measured(subject: Subject, seed: int) -> dict[str, Any]:
    """One pair: each landmark's error and what was stated of it, or why it was not proposed."""
    rng = np.random.default_rng([seed, *subject.name.encode()])
    pair = visits(subject, rng)
    start = time.process_time()
    row: dict[str, Any] = {
        "kind": subject.kind,
        "limb": subject.name,
        "changes": pair.changes,
        "refused": None,
    }
    try:
        carried = propose(pair.today, pair.marked, pair.marked.side, subject.kind).carried
    except LimbgramError as error:
        return row | {"refused": error.finding.code, "says": str(error)}
    marks: dict[str, Any] = {}
    for one in carried.left_out:
        marks[one.name] = {"refused": one.reason.code}
    for one in carried.places:
        name = one.landmark.name
        off = one.landmark.position_mm - pair.places_mm[name]
        normal = pair.normals[name]
        marks[name] = {
            "off_mm": float(np.linalg.norm(off - (off @ normal) * normal)),
            "carrying_mm": one.carrying_mm,
            "sliding_mm": one.sliding_mm,
        }
    for name in pair.gone:
        marks[name]["gone"] = True
    row["landmarks"] = marks
    row["rms_mm"] = carried.rms_mm
    row["cpu_s"] = round(time.process_time() - start, 1)
    return row


if __name__ == "__main__":
    main()
