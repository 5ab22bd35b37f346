"""What it costs to have no calibration and no board: the same photos with and without them.

    python benchmarks/selfcalibration.py DATA -o benchmarks/results/selfcalibration.json

Rendered captures, and captures of the generator by a camera and by a phone from near. Each is
reconstructed with the camera file of its board photos; without it, the lens found from the photos
of the limb alone; and without board as well, the scale from printed scale bars, or from one length
on the limb that a tape measured. A tape is wrong by 0.5 mm (one sigma, drawn by the seed), its ends
are picked by hand to 0.7 px in the photos that show them. All against the exact truth.
"""

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from captures import LIMBGRAM, accuracy, machine, timed
from limbgram.formats.marks_file import PrintedKind, write_marks
from limbgram.formats.sheets.coded import draw_bars
from limbgram.synthetic import CaptureOptions, make_capture, scattered_spots, stage_truth
from limbgram.synthetic.rendering.renderer import seen
from sweep import phone
from tables import made_on, table

Result = dict[str, Any]
SETS = ("limb_ring15", "foot_ring24")
_TAPE_MM, _PICK_PX = 0.5, 0.7
_SPOTS = 4


@dataclass(frozen=True)
class Made:
    """A capture of the generator."""

    name: str
    options: CaptureOptions


def generated() -> tuple[Made, ...]:
    """A camera from 1.4 m, another limb and walk, and a phone from 0.54 m."""
    bars = draw_bars("a4").plates[:2]
    shared: Any = {"plates": bars, "calibration_photos": 12, "spots": scattered_spots(_SPOTS)}
    camera = CaptureOptions(
        photos=15, width_px=1200, height_px=800, distance_mm=1400.0, seed=31, **shared
    )
    near = replace(phone(16, 1.0, 33).options, **shared)
    return (
        Made("camera, seed 31", camera),
        Made("camera, seed 32, two heights", replace(camera, seed=32, photos=18, rings=2)),
        Made("phone, seed 33", near),
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("data", type=Path, nargs="?", help="folder with the rendered captures")
    parser.add_argument("--sets", nargs="*", default=list(SETS))
    parser.add_argument("--made", type=int, default=3, help="captures of the generator")
    parser.add_argument("--keep", type=Path, help="keep captures and cases here")
    parser.add_argument("-o", "--out", type=Path, required=True)
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = chosen.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        results: Result = {"machine": machine(), "captures": {}}
        for name, source, options in _captures(chosen, folder):
            found: Result = results["captures"].setdefault(name, {})
            for way, words in _ways(source, folder / source.name, options):
                sys.stderr.write(f"{name}: {way}\n")
                case = folder / source.name / way.replace(", ", "_").replace(" ", "-")
                found[way] = _one(source, case, words)
                chosen.out.write_text(json.dumps(results, indent=1) + "\n")
                chosen.out.with_suffix(".md").write_text(_page(results))


def _captures(
    chosen: argparse.Namespace, folder: Path
) -> Iterator[tuple[str, Path, CaptureOptions | None]]:
    for number, one in enumerate(generated()[: chosen.made]):
        source = folder / "captures" / f"made-{number + 1}"
        source.parent.mkdir(exist_ok=True)
        if not source.exists():
            make_capture(source, one.options)
        yield one.name, source, one.options
    for name in chosen.sets if chosen.data else ():
        yield name, chosen.data / "rendered" / name, None


def _ways(
    source: Path, folder: Path, options: CaptureOptions | None
) -> Iterator[tuple[str, list[str]]]:
    """Each way of reconstructing, and its words on the command line."""
    folder.mkdir(parents=True, exist_ok=True)
    camera = folder / "camera.json"
    if not camera.exists():
        board = ["--board", "14x10", "--square", "10", "-o", str(camera)]
        timed([LIMBGRAM, "calibrate", str(source / "calibration"), *board])
    yield "camera file, board", ["--camera", str(camera)]
    yield "no camera file, board", []
    if options is None:
        return
    marks = folder / "bars.json"
    if not marks.exists():
        kind = PrintedKind(kind="scale-bars", title="bars", page="a4", plates=options.plates)
        write_marks(marks, kind)
    yield "no camera file, scale bars", ["--marks", str(marks)]
    taped = folder / "taped.json"
    taped.write_text(json.dumps(_taped(options), indent=1))
    yield "no camera file, one taped length", ["--known-distance", str(taped)]


def _taped(options: CaptureOptions) -> list[Result]:
    """The farthest two of the painted marks, measured and picked as a person would."""
    truth = stage_truth(options)
    from limbgram.synthetic import places_mm

    places = np.array(places_mm(truth.limb, options.spots))
    apart = np.linalg.norm(places[:, None] - places[None], axis=2)
    first, second = np.unravel_index(np.argmax(apart), apart.shape)
    rng = np.random.default_rng((options.seed, 40))
    nearest = [
        int(np.argmin(np.linalg.norm(truth.limb.mesh.vertices_mm - places[k], axis=1)))
        for k in (first, second)
    ]
    picks: list[list[Result]] = [[], []]
    for view in truth.views:
        visible = seen(view, truth.limb)
        for end, vertex in enumerate(nearest):
            if visible[vertex]:
                place = truth.limb.mesh.vertices_mm[vertex][None]
                x, y = view.project(place)[0] + rng.normal(0, _PICK_PX, 2)
                picks[end].append({"photo": view.name, "x_px": float(x), "y_px": float(y)})
    length = float(apart[first, second] + rng.normal(0, _TAPE_MM))
    ends = {"first": picks[0], "second": picks[1]}
    return [{"label": "taped", "length_mm": round(length, 1), "length_sigma_mm": _TAPE_MM, **ends}]


def _one(source: Path, case: Path, words: list[str]) -> Result:
    done: Result = {"exit_code": 0, "message": "", "cpu_s": None}
    if not (case / "accuracy.json").exists():
        command = [LIMBGRAM, "reconstruct", str(source / "images"), "-o", str(case), *words]
        done = timed(command)
    result: Result = {name: done[name] for name in ("exit_code", "message", "cpu_s")}
    if not (case / "accuracy.json").exists():
        return result
    found = accuracy(case, source)
    own = json.loads((case / "accuracy.json").read_text())
    truth = found["truth"]
    budget = {one["part"]: one["sigma_mm"] for one in own["expected"]["budget"]}
    return result | {
        "light": found["light"],
        "headline": found["headline"],
        "expected_rms_mm": own["expected"]["rms_mm"],
        "budget_mm": budget,
        "self_calibration": own.get("self_calibration"),
        "rms_mm": truth["rms_mm"],
        "p95_mm": truth["p95_mm"],
        "scale_error": truth["scale_error"],
        "volume_error": truth["volume_error"],
        "worst_girth_mm": max((abs(one["error_mm"]) for one in truth["girths"]), default=None),
        "error_over_sigma": (truth["sigma"] or {}).get("robust_spread"),
    }


def _page(results: Result) -> str:
    heads = ("capture", "given", "RMS mm", "95 % mm", "expected RMS mm", "of it cameras mm",
             "scale", "worst girth mm", "error / sigma", "verdict")  # fmt: skip
    rows = []
    for name, ways in results["captures"].items():
        for way, one in ways.items():
            if "rms_mm" not in one:
                told = one["message"].strip().splitlines()[-1:] or [""]
                rows.append((name, way, *[""] * 7, f"exit {one['exit_code']}: {told[0][:80]}"))
                continue
            cameras = next((mm for part, mm in one["budget_mm"].items() if "camera" in part), None)
            rows.append(
                (
                    name,
                    way,
                    f"{one['rms_mm']:.3f}",
                    f"{one['p95_mm']:.3f}",
                    "" if one["expected_rms_mm"] is None else f"{one['expected_rms_mm']:.3f}",
                    "" if cameras is None else f"{cameras:.3f}",
                    f"{one['scale_error']:+.3%}",
                    "" if one["worst_girth_mm"] is None else f"{one['worst_girth_mm']:.2f}",
                    "" if one["error_over_sigma"] is None else f"{one['error_over_sigma']:.2f}",
                    one["light"],
                )
            )
    return (
        "\n\n".join(
            (
                "# selfcalibration",
                made_on(results["machine"]),
                "The same photos with and without a camera file and a board, against the exact "
                "truth; one capture each.",
                table(heads, rows),
            )
        )
        + "\n"
    )


if __name__ == "__main__":
    main()
