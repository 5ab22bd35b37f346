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
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from harness import asking, found_before, machine, made_on, table, write
from limbgram.core.errors import LimbgramError
from limbgram.services.align import propose
from visits import MAN_MM, Subject, subjects_of, visits

INSIDE: Final = 2.448
"""Standard deviations of one direction within which 95 of 100 places of a plane lie."""


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
        f"{len(off)} of {len(row['landmarks'])}, RMS {_rms(off):.2f} mm, "
        f"over sigma {_rms(ratio) / np.sqrt(2):.2f}, {row['cpu_s']} s"
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


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else float("nan")


def page(result: dict[str, Any]) -> str:
    """By kind, by landmark, and what was refused."""
    rows = list(result["pairs"].values())
    commits = dict.fromkeys(row["commit"][:12] for row in rows)
    heads = ("", "pairs", "proposed", "refused", "gone, yet proposed", "RMS mm", "95 % mm",
             "stated RMS mm", "inside", "without allowance")  # fmt: skip
    return (
        "\n\n".join(
            [
                f"# Landmarks of an earlier visit, half of shapes and seeds: {result['half']}",
                f"{made_on(result['machine'])}; rows of commits {', '.join(commits)}",
                "Errors along the surface of places that the later scan holds; inside: shorter "
                f"than {INSIDE} standard deviations of one direction; and without what is assumed "
                "of skin that slides. Refused: of those that the scan holds.",
                "## By kind",
                table(heads, [_by(rows, kind, f"{kind}") for kind in _kinds(rows)]),
                "## By limb",
                table(heads, [_by(rows, kind, limb, limb) for kind, limb in _limbs(rows)]),
                "## By landmark",
                *(
                    part
                    for kind in _kinds(rows)
                    for part in (f"### {kind}", _landmarks(rows, kind))
                ),
                "\n".join(_reasons(rows)),
            ]
        )
        + "\n"
    )


def _kinds(rows: Sequence[dict[str, Any]]) -> list[str]:
    return list(dict.fromkeys(row["kind"] for row in rows))


def _limbs(rows: Sequence[dict[str, Any]]) -> list[tuple[str, str]]:
    return sorted(dict.fromkeys((row["kind"], row["limb"]) for row in rows))


def marks_of(rows: Sequence[dict[str, Any]], kind: str, limb: str = "") -> list[tuple[str, Any]]:
    """Name and figures of each landmark of the pairs of a kind."""
    return [
        mark
        for row in rows
        if row["kind"] == kind and (not limb or row["limb"] == limb) and not row["refused"]
        for mark in row["landmarks"].items()
    ]


def _by(rows: Sequence[dict[str, Any]], kind: str, label: str, limb: str = "") -> Sequence[str]:
    own = [row for row in rows if row["kind"] == kind and (not limb or row["limb"] == limb)]
    marks = [mark for _, mark in marks_of(rows, kind, limb)]
    none = sum(bool(row["refused"]) for row in own)
    pairs = f"{len(own)}" + (f" ({none} refused)" if none else "")
    return (label if not limb else f"{kind}, {label}", pairs, *summary(marks))


def summary(marks: Sequence[dict[str, Any]]) -> Sequence[str]:
    """Figures of landmarks, as cells."""
    held = [one for one in marks if not one.get("gone")]
    told = [one for one in held if "off_mm" in one]
    wrong = sum("off_mm" in one for one in marks if one.get("gone"))
    off = [one["off_mm"] for one in told]
    stated = [float(np.hypot(one["carrying_mm"], one["sliding_mm"])) for one in told]
    inside = np.less(off, INSIDE * np.array(stated))
    alone = [one["off_mm"] < INSIDE * one["carrying_mm"] for one in told]
    if not told:
        return (f"0 of {len(held)}", "", f"{wrong}", "", "", "", "", "")
    return (
        f"{len(told)} of {len(held)}",
        f"{1 - len(told) / len(held):.1%}",
        f"{wrong} of {len(marks) - len(held)}",
        f"{_rms(off):.2f}",
        f"{np.quantile(off, 0.95):.2f}",
        f"{np.sqrt(2) * _rms(stated):.2f}",
        f"{np.mean(inside):.1%}",
        f"{np.mean(alone):.1%}",
    )


def _landmarks(rows: Sequence[dict[str, Any]], kind: str) -> str:
    heads = ("landmark", "proposed", "refused", "gone, yet proposed", "RMS mm", "95 % mm",
             "stated RMS mm", "inside", "without allowance")  # fmt: skip
    marks = marks_of(rows, kind)
    names = dict.fromkeys(name for name, _ in marks)
    return table(
        heads, [(name, *summary([one for own, one in marks if own == name])) for name in names]
    )


def _reasons(rows: Sequence[dict[str, Any]]) -> Iterator[str]:
    """How often each reason was given, of places that the scan holds and of others."""
    for kind in _kinds(rows):
        marks = [one for _, one in marks_of(rows, kind) if "refused" in one]
        codes = sorted({one["refused"] for one in marks})
        told = ", ".join(
            f"{code} {sum(one['refused'] == code for one in marks if not one.get('gone'))} + "
            f"{sum(one['refused'] == code for one in marks if one.get('gone'))} gone"
            for code in codes
        )
        yield f"- {kind}: {told or 'none refused'}"


if __name__ == "__main__":
    main()
