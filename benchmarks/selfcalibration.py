"""What it costs to have no calibration and no board: the same photos with and without them.

    python benchmarks/selfcalibration.py DATA -o benchmarks/results/selfcalibration.json

Rendered captures, and captures of the generator by a camera and by a phone from near. Each is
reconstructed with the camera file of its board photos; without it, the lens found from the photos
of the limb alone; and without board as well, the scale from printed scale bars, or from one length
on the limb that a tape measured. A tape is wrong by 0.5 mm (one sigma, drawn by the seed), its ends
are picked by hand to 0.7 px in the photos that show them. All against the exact truth. What is made
anew takes the place of what OUT holds; each line keeps its commit.

One tape is one draw, and every vertex shares its error. So the scene of the taped case is scaled by
a hundred more tapes, each read and picked anew, and the error of its size is held against the sigma
that is stated for it; the true size is that of the cameras' places.
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

from captures import LIMBGRAM, accuracy, read_poses, timed
from harness import asking, found_before, machine, made_on, table, working_in, write
from limbgram.cases.stage_cache import read_product
from limbgram.core.geometry.frames import fit_similarity
from limbgram.formats.marks_file import PrintedKind, write_marks
from limbgram.formats.sheets.coded import draw_bars
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.scale.scaling import to_millimetres
from limbgram.services.parse_capture import read_distances
from limbgram.synthetic import (
    CaptureOptions,
    make_capture,
    places_mm,
    scattered_spots,
    stage_truth,
)
from limbgram.synthetic.rendering.renderer import seen
from sweep import phone

Result = dict[str, Any]
SETS = ("limb_ring15", "foot_ring24")
_TAPE_MM, _PICK_PX = 0.5, 0.7
_SPOTS = 4
_FIRST_TAPE = 40
_TAPES = 100


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
    parser = asking(__doc__, keep="captures and cases")
    parser.add_argument("data", type=Path, nargs="?", help="folder with the rendered captures")
    parser.add_argument("--sets", nargs="*", default=list(SETS))
    parser.add_argument("--made", type=int, default=3, help="captures of the generator")
    chosen = parser.parse_args()
    with working_in(chosen.keep) as folder:
        results: Result = found_before(chosen.out, {})
        results = {"captures": {}} | results | {"machine": machine()}
        for name, source, options in _captures(chosen, folder):
            found: Result = results["captures"].setdefault(name, {})
            for way, words in _ways(source, folder / source.name, options):
                sys.stderr.write(f"{name}: {way}\n")
                case = folder / source.name / way.replace(", ", "_").replace(" ", "-")
                made = {"commit": results["machine"]["commit"][:12]}
                found[way] = _one(source, case, words) | made
                if options is not None and "--known-distance" in words:
                    found[way]["tapes"] = _more_tapes(source, case, _Taped.of(options))
                write(chosen.out, results)


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
    taped.write_text(json.dumps(_Taped.of(options).read(_FIRST_TAPE), indent=1))
    yield "no camera file, one taped length", ["--known-distance", str(taped)]


@dataclass(frozen=True)
class _Taped:
    """The farthest two of the painted marks, and where photos show them."""

    seed: int
    length_mm: float
    seen: tuple[tuple[str, int, np.ndarray], ...]
    """Photo, end of the tape, and pixel."""

    @classmethod
    def of(cls, options: CaptureOptions) -> "_Taped":
        truth = stage_truth(options)
        places = np.array(places_mm(truth.limb, options.spots))
        apart = np.linalg.norm(places[:, None] - places[None], axis=2)
        ends = np.unravel_index(np.argmax(apart), apart.shape)
        vertices = truth.limb.mesh.vertices_mm
        nearest = [int(np.argmin(np.linalg.norm(vertices - places[k], axis=1))) for k in ends]
        found: list[tuple[str, int, np.ndarray]] = []
        for view in truth.views:
            visible = seen(view, truth.limb)
            found += [
                (view.name, end, view.project(vertices[vertex][None])[0])
                for end, vertex in enumerate(nearest)
                if visible[vertex]
            ]
        return cls(options.seed, float(apart[ends]), tuple(found))

    def read(self, draw: int) -> list[Result]:
        """As a person would measure and pick it; each draw another time."""
        rng = np.random.default_rng((self.seed, draw))
        picks: list[list[Result]] = [[], []]
        for photo, end, xy_px in self.seen:
            x, y = xy_px + rng.normal(0, _PICK_PX, 2)
            picks[end].append({"photo": photo, "x_px": float(x), "y_px": float(y)})
        length = round(float(self.length_mm + rng.normal(0, _TAPE_MM)), 1)
        ends = {"first": picks[0], "second": picks[1]}
        return [{"label": "taped", "length_mm": length, "length_sigma_mm": _TAPE_MM, **ends}]


def _more_tapes(source: Path, case: Path, taped: _Taped) -> Result:
    """Scale the case's scene by many tapes, and hold each size against its sigma."""
    folder = next((case / "stages").glob("place*"))
    key = json.loads((folder / "stage.json").read_text())["key"]
    scene, _ = read_product(folder, key, Scene, case)
    assert isinstance(scene, Scene)
    known = read_poses(source / "truth" / "cameras.json")
    placed = [scene.view(k) for k in scene.placed]
    ours = np.array([view.centre_in_world for view in placed])
    mm_per_unit = fit_similarity(
        ours, np.array([known[Path(view.name).stem].centre for view in placed])
    ).scale
    errors: list[float] = []
    sigmas: list[float] = []
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch) / "tape.json"
        for draw in range(_FIRST_TAPE, _FIRST_TAPE + _TAPES):
            file.write_text(json.dumps(taped.read(draw)))
            metric = to_millimetres(scene, None, read_distances(file))
            there = np.array([view.centre_in_world for view in metric.scene.views])
            errors.append(fit_similarity(ours, there).scale / mm_per_unit - 1)
            sigmas.append(metric.scale.relative_sigma)
    ratios = np.array(errors) / np.array(sigmas)
    return {
        "tapes": _TAPES,
        "length_mm": taped.length_mm,
        "rms_error": float(np.sqrt(np.mean(np.square(errors)))),
        "mean_sigma": float(np.mean(sigmas)),
        "error_over_sigma": float(np.sqrt(np.mean(ratios**2))),
        "within_sigma": float(np.mean(np.abs(ratios) <= 1)),
        "within_two_sigmas": float(np.mean(np.abs(ratios) <= 2)),
    }


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


def page(results: Result) -> str:
    heads = ("capture", "given", "RMS mm", "95 % mm", "expected RMS mm", "of it cameras mm",
             "scale", "worst girth mm", "error / sigma", "verdict", "commit")  # fmt: skip
    rows = []
    for name, ways in results["captures"].items():
        for way, one in ways.items():
            if "rms_mm" not in one:
                told = one["message"].strip().splitlines()[-1:] or [""]
                refused = f"exit {one['exit_code']}: {told[0][:80]}"
                rows.append((name, way, *[""] * 7, refused, one["commit"]))
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
                    one["commit"],
                )
            )
    said = [
        "# selfcalibration",
        made_on(results["machine"]),
        "The same photos with and without a camera file and a board, against the exact truth; one "
        "capture each. All vertices share the error of a scale, so error / sigma of one taped "
        "length speaks of one reading of the tape.",
        table(heads, rows),
    ]
    tapes = [
        (name, one["tapes"])
        for name, ways in results["captures"].items()
        for one in ways.values()
        if "tapes" in one
    ]
    if tapes:
        said += [
            "The same scenes scaled by many readings of that tape (0.5 mm, ends picked to 0.7 px), "
            "each with errors of its own: is the stated sigma of the size honest?",
            table(
                ("capture", "tapes", "length mm", "RMS error of the size", "stated sigma",
                 "error / sigma", "within 1 sigma", "within 2"),
                [
                    (name, str(one["tapes"]), f"{one['length_mm']:.1f}", f"{one['rms_error']:.3%}",
                     f"{one['mean_sigma']:.3%}", f"{one['error_over_sigma']:.2f}",
                     f"{one['within_sigma']:.0%}", f"{one['within_two_sigmas']:.0%}")
                    for name, one in tapes
                ],
            ),
        ]  # fmt: skip
    return "\n\n".join(said) + "\n"


if __name__ == "__main__":
    main()
