"""Real cameras: what each of their faults costs, alone and all together, and what the verdict says.

    python benchmarks/cameras.py -o benchmarks/results/cameras.json
    python benchmarks/cameras.py --setups phone --faults none stabiliser all --seeds 41 -o OUT.json
    python benchmarks/cameras.py --setups phone12 --faults stabiliser+processing+jpeg -o OUT.json
    python benchmarks/cameras.py --setups phone --faults all --strength 2 -o OUT.json

Each capture is made by `synthetic` (usual.py: the faults and their usual strengths), calibrated
from its own board photos, which the same camera took with the same faults, and reconstructed
through the command line; `limbgram accuracy --truth` compares with the truth. What stands in OUT
already is kept, so that a run that was stopped goes on.

A capture holds where its RMS is at most 1.5 times that of the same capture by an ideal camera, or
its sigma says so (error over sigma spreads 0.8 to 1.25); and never holds where its verdict is green
and less than 95 % of it lies within 0.25 mm.
"""

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from captures import one_set
from harness import asking, machine
from limbgram.core.files import write_bytes
from limbgram.synthetic import PHONE, CaptureOptions, Fault, make_capture, with_faults

WORST_RATIO = 1.5
HONEST_SPREAD = (0.8, 1.25)
WORST_GREEN_P95_MM = 0.25
IDEAL, ALL = "none", "all"

SETUPS = {
    "phone": CaptureOptions(
        photos=14,
        width_px=1000,
        height_px=750,
        distance_mm=500.0,
        lens=PHONE,
        calibration_photos=10,
        samples=3,
    ),
    "phone12": CaptureOptions(
        photos=24,
        width_px=4032,
        height_px=3024,
        distance_mm=560.0,
        lens=PHONE,
        calibration_photos=10,
        samples=2,
    ),
    "body": CaptureOptions(
        photos=12, width_px=900, height_px=600, calibration_photos=10, samples=3
    ),
}
"""A phone as wide as 26 mm on film at 0.5 m, its 12 MP reduced; the same with all its 12 MP; a
50 mm lens at 1.5 m."""


@dataclass(frozen=True)
class Case:
    """One capture of the benchmark."""

    setup: str
    fault: str
    """One, several with + between them, `none`, or `all`."""
    seed: int
    strength: float = 1.0
    """How many times as strong as is usual."""

    @property
    def name(self) -> str:
        times = "" if self.strength == 1.0 else f"_x{self.strength:g}"
        return f"{self.setup}_{self.fault}_{self.seed}{times}"

    @property
    def options(self) -> CaptureOptions:
        ideal = replace(SETUPS[self.setup], seed=self.seed)
        return with_faults(ideal, _faults_of(self.fault), self.strength)


def _faults_of(said: str) -> list[Fault]:
    """The faults that a word such as `stabiliser+jpeg` names."""
    if said == IDEAL:
        return []
    return list(Fault) if said == ALL else [Fault(one) for one in said.split("+")]


def main() -> None:
    parser = asking(__doc__, keep="captures and case folders")
    known = [IDEAL, *(one.value for one in Fault), ALL]
    parser.add_argument("--setups", nargs="*", choices=list(SETUPS), default=list(SETUPS))
    parser.add_argument(
        "--faults", nargs="*", default=known, help=f"of {', '.join(known)}; several with + between"
    )
    parser.add_argument("--strength", type=float, default=1.0, help="times what is usual")
    parser.add_argument("--seeds", nargs="*", type=int, default=[41, 42])
    chosen = parser.parse_args()
    results: dict[str, Any] = {"machine": machine(), "captures": {}}
    if chosen.out.exists():
        results["captures"] = json.loads(chosen.out.read_text())["captures"]
    chosen.out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        folder = chosen.keep or Path(scratch)
        for case in _cases(chosen):
            if case.name in results["captures"]:
                continue
            sys.stderr.write(f"{case.name}\n")
            results["captures"][case.name] = measured(case, folder)
            judge(results["captures"])
            write_bytes(chosen.out, (json.dumps(results, indent=1) + "\n").encode())


def _cases(chosen: argparse.Namespace) -> Iterator[Case]:
    for seed in chosen.seeds:
        for fault in chosen.faults:
            for setup in chosen.setups:
                yield Case(setup, fault, seed, 1.0 if fault == IDEAL else chosen.strength)


def measured(case: Case, folder: Path) -> dict[str, Any]:
    """Make the capture, reconstruct it, compare it; the figures that are published."""
    source = folder / "captures" / case.name
    if not source.exists():
        source.parent.mkdir(parents=True, exist_ok=True)
        make_capture(source, case.options)
    run = one_set(source, folder / case.name, None)
    told: dict[str, Any] = {"setup": case.setup, "fault": case.fault, "seed": case.seed}
    told["strength"] = case.strength
    told["commit"] = machine()["commit"][:7]
    if "accuracy" not in run:
        failed = next(run[step] for step in ("reconstruct", "calibrate") if step in run)
        return told | {"light": "refused", "message": _refusal(failed["message"])}
    said = run["accuracy"]
    truth = said["truth"]
    return told | {
        "light": said["light"],
        "not_green": [one["key"] for one in said["criteria"] if one["light"] != "green"],
        "headline": said["headline"],
        "expected_p95_mm": said["expected"]["p95_mm"],
        "rms_mm": truth["rms_mm"],
        "p95_mm": truth["p95_mm"],
        "scale_error": truth["scale_error"],
        "girths_mm": [one["error_mm"] for one in truth["girths"]],
        "sigma_spread": truth["sigma"]["robust_spread"],
        "sigma_within_95": truth["sigma"]["within_95_share"],
        "cpu_s": run["calibrate"]["cpu_s"] + run["reconstruct"]["cpu_s"],
    }


def _refusal(said: str) -> str:
    """The refusal at the end of what a command said as JSON lines."""
    try:
        return json.loads(said.strip().splitlines()[-1])["message"]
    except (IndexError, KeyError, ValueError):
        return said


def judge(captures: dict[str, dict[str, Any]]) -> None:
    """Say of each capture whether it holds what is promised, beside its ideal twin."""
    for one in captures.values():
        twin = captures.get(Case(one["setup"], IDEAL, one["seed"]).name)
        if one["light"] == "refused" or twin is None or twin["light"] == "refused":
            continue
        ratio = one["rms_mm"] / twin["rms_mm"]
        honest = HONEST_SPREAD[0] <= one["sigma_spread"] <= HONEST_SPREAD[1]
        lying = one["light"] == "green" and one["p95_mm"] > WORST_GREEN_P95_MM
        one["rms_ratio"] = round(ratio, 3)
        one["holds"] = (ratio <= WORST_RATIO or honest) and not lying
        one["green_but_wrong"] = lying


def page(results: dict[str, Any]) -> str:
    """One line a capture, failures beside successes."""
    rows = list(results["captures"].values())
    judged = [one for one in rows if "holds" in one]
    lines = [
        "# Real cameras",
        "",
        f"Made by `python benchmarks/cameras.py`, each line by its own commit. "
        f"{sum(one['holds'] for one in judged)} of {len(judged)} captures hold "
        f"(RMS at most {WORST_RATIO} times the ideal camera's, or error over sigma within "
        f"{HONEST_SPREAD[0]} to {HONEST_SPREAD[1]}); "
        f"Refused, or without an ideal twin: {len(rows) - len(judged)}. "
        f"Green with more than {WORST_GREEN_P95_MM} mm at 95 %: "
        f"{sum(one['green_but_wrong'] for one in judged)}.",
        "",
        "| camera | fault | times usual | seed | RMS mm | times ideal | 95 % mm | expected 95 % "
        "| error/sigma | scale % | worst girth mm | verdict | not green | holds | commit |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for one in sorted(rows, key=lambda row: (row["setup"], row["seed"])):
        start = f"| {one['setup']} | {one['fault']} | {one['strength']:g} | {one['seed']} |"
        if one["light"] == "refused":
            why = one["message"].split(". ")[0]
            lines.append(f"{start} | | | | | | | refused | {why} | | {one['commit']} |")
            continue
        girth = max(one["girths_mm"], key=abs, default=float("nan"))
        holds = {True: "yes", False: "NO", None: ""}[one.get("holds")]
        lines.append(
            f"{start} {one['rms_mm']:.3f} | {one.get('rms_ratio', '')} | {one['p95_mm']:.3f} | "
            f"{one['expected_p95_mm']:.3f} | {one['sigma_spread']:.2f} | "
            f"{100 * one['scale_error']:+.3f} | {girth:+.2f} | {one['light']} | "
            f"{', '.join(one['not_green'])} | {holds} | {one['commit']} |"
        )
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
