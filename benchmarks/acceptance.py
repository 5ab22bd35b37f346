"""Whether the certificate of `limbgram verify-setup` is right: known errors are put in and found.

    python benchmarks/acceptance.py --keep FOLDER -o benchmarks/results/acceptance.json

The generator photographs ball bars and gauge cylinders; the artefact file says what a calibration
laboratory would have said, and the rendered body differs from it by a known error: all lengths
0.1 % larger, or lobes on spheres and cylinder. Whole runs through the command line. What was put in
stands beside what the certificate says, and beside the size error that the exact places of cameras
and spheres give without any fit of a sphere.
"""

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from captures import LIMBGRAM, read_poses
from harness import asking, machine, made_on, table, working_in, write
from limbgram.core.geometry.frames import fit_similarity
from limbgram.formats.reading import read_limb
from limbgram.synthetic import CaptureOptions, make_capture
from limbgram.synthetic.props.gauges import BallBar, Gauge, GaugeCylinder, sphere_centres_mm
from limbgram.synthetic.truth import BASE_MM

Result = dict[str, Any]
_NEAR = 0.04
"""Of the radius: vertices so near to the true sphere are compared with it."""


@dataclass(frozen=True)
class Trial:
    """A rendered gauge, and the error that its artefact file does not know of."""

    name: str
    gauge: Gauge
    put_in: dict[str, float]
    """By kind of error, mm."""
    seed: int = 5
    mpe: tuple[str, ...] = ("0.3", "form=0.3")
    expected: str = "pass"


TRIALS = (
    Trial("bar as calibrated", BallBar(), {"size": 0.0, "spacing": 0.0, "form": 0.0}),
    Trial(
        "bar as calibrated, another seed, leaning 20 deg",
        BallBar(lean_deg=20.0),
        {"size": 0.0, "spacing": 0.0, "form": 0.0},
        seed=17,
    ),
    Trial(
        "bar 0.1 % larger",
        BallBar(diameter_mm=50.05, spacing_mm=150.15),
        {"size": 0.05, "spacing": 0.15, "form": 0.0},
        mpe=("0.3", "spacing=0.10"),
        expected="fail",
    ),
    Trial(
        "bar with lobes of 0.40 mm",
        BallBar(form_mm=0.4),
        {"size": 0.0, "spacing": 0.0, "form": 0.4},
        mpe=("0.3", "form=0.25"),
        expected="fail",
    ),
    Trial("cylinder as calibrated", GaugeCylinder(), {"size": 0.0, "form": 0.0}),
    Trial(
        "cylinder 0.1 % larger",
        GaugeCylinder(diameter_mm=100.1, length_mm=180.18),
        {"size": 0.1, "form": 0.0},
        seed=23,
        mpe=("0.3", "size=0.06"),
        expected="fail",
    ),
    Trial(
        "cylinder with lobes of 0.40 mm",
        GaugeCylinder(form_mm=0.4),
        {"size": 0.0, "form": 0.4},
        mpe=("0.3", "form=0.25"),
        expected="fail",
    ),
)

BAR_FILE = """format = "limbgram artefact"
version = 1
name = "Ball bar"
spheres = [
  {name = "A", diameter_mm = 50.0, uncertainty_mm = 0.004, form_mm = 0.002},
  {name = "B", diameter_mm = 50.0, uncertainty_mm = 0.004, form_mm = 0.002},
]
lengths = [{first = "A", second = "B", length_mm = 150.0, uncertainty_mm = 0.006}]
"""
CYLINDER_FILE = """format = "limbgram artefact"
version = 1
name = "Gauge cylinder"
cylinder = {name = "C", diameter_mm = 100.0, uncertainty_mm = 0.004, form_mm = 0.002}
"""


def main() -> None:
    parser = asking(__doc__, keep="captures and cases")
    parser.add_argument("--photos", type=int, default=15)
    parser.add_argument("--width", type=int, default=1200)
    chosen = parser.parse_args()
    with working_in(chosen.keep) as folder:
        results: Result = {
            "machine": machine(),
            "photos": chosen.photos,
            "width_px": chosen.width,
            "trials": {},
        }
        for number, trial in enumerate(TRIALS):
            sys.stderr.write(f"{trial.name}\n")
            found = tried(trial, folder / f"trial-{number + 1}", chosen.photos, chosen.width)
            results["trials"][trial.name] = found
            write(chosen.out, results)


def tried(trial: Trial, folder: Path, photos: int, width: int) -> Result:
    """Render, calibrate, verify."""
    options = CaptureOptions(
        gauge=trial.gauge, photos=photos, width_px=width, height_px=round(width * 2 / 3),
        distance_mm=1400.0, calibration_photos=12, seed=trial.seed, coverage=0.6,
    )  # fmt: skip
    source, camera = folder / "capture", folder / "camera.json"
    folder.mkdir(parents=True, exist_ok=True)
    if not source.exists():
        make_capture(source, options)
    board = ["--board", "14x10", "--square", "10", "-o", str(camera)]
    if not camera.exists():
        _run([LIMBGRAM, "calibrate", str(source / "calibration"), *board])
    artefact = folder / "artefact.toml"
    is_bar = isinstance(trial.gauge, BallBar)
    artefact.write_text(BAR_FILE if is_bar else CYLINDER_FILE)
    mpe = [word for one in trial.mpe for word in ("--mpe", one)]
    words = [LIMBGRAM, "verify-setup", str(artefact), str(source / "images"), *mpe]
    done = _run([*words, "--camera", str(camera), "--json"])
    reply: Result = json.loads(done.stdout)
    result: Result = {
        "put_in_mm": trial.put_in,
        "seed": trial.seed,
        "mpe": trial.mpe,
        "expected": trial.expected,
        "exit_code": done.returncode,
    }
    if "acceptance" not in reply:
        return result | {"message": reply["error"]["message"]}
    found = reply["acceptance"]
    result |= {
        "outcome": found["outcome"],
        "headline": found["headline"]["sentence"],
        "values": [
            {name: one[name] for name in ("kind", "name", "error_mm", "permissible_mm", "outcome")}
            for one in found["values"]
        ],
        "not_measured": found["not_measured"],
        "bodies": found["bodies"],
    }
    if isinstance(trial.gauge, BallBar):
        case = folder / "camera.acceptance-cases" / "capture-1"
        result["size_by_truth_mm"] = _by_truth(trial.gauge, case, source)
    return result


def _run(words: list[str]) -> subprocess.CompletedProcess[str]:
    return subprocess.run(words, capture_output=True, text=True, check=False)


def _by_truth(bar: BallBar, case: Path, source: Path) -> list[float]:
    """Twice the mean distance from the true middles, less the diameter in the artefact file.

    The surface is laid on the truth by the places of the cameras alone.
    """
    ours = read_poses(case / "deliverables" / "poses.json")
    theirs = read_poses(source / "truth" / "cameras.json")
    names = sorted(ours.keys() & theirs.keys())
    fit = fit_similarity(
        np.array([ours[name].centre for name in names]),
        np.array([theirs[name].centre for name in names]),
        with_scale=False,
    )
    files = sorted((case / "deliverables").glob("surface*.ply"))
    points, areas = [], []
    for file in files:
        mesh = read_limb(file).mesh
        kept = mesh.measured
        points.append(fit.apply(mesh.vertices_mm[kept]))
        areas.append(mesh.vertex_areas_mm2()[kept])
    places, weights = np.concatenate(points), np.concatenate(areas)
    radius, found = bar.diameter_mm / 2, []
    for middle in sphere_centres_mm(bar, BASE_MM):
        arms = places - middle
        far = np.linalg.norm(arms, axis=1)
        # off the shaft and off the edge of what is seen
        near = (np.abs(far - radius) < _NEAR * radius) & (np.abs(arms[:, 2]) < 0.6 * radius)
        found.append(round(float(2 * np.average(far[near], weights=weights[near])) - 50.0, 4))
    return found


def page(results: Result) -> str:
    heads = ("trial", "put in: size, spacing, form mm", "size", "by truth", "spacing", "form 95 %",
             "form, all", "answer", "expected")  # fmt: skip
    rows = []
    for name, one in results["trials"].items():
        if "values" not in one:
            rows.append((name, "", "", "", "", "", "", one["message"][:60], one["expected"]))
            continue
        put = one["put_in_mm"]
        rows.append(
            (
                name,
                ", ".join(f"{put[kind]:.2f}" if kind in put else "-" for kind in _KINDS),
                _listed(one, "size", "+.3f"),
                ", ".join(f"{mm:+.3f}" for mm in one.get("size_by_truth_mm", [])),
                _listed(one, "spacing", "+.3f"),
                _listed(one, "form", ".3f"),
                _listed(one, "form-all", ".3f"),
                one["outcome"],
                one["expected"],
            )
        )
    return (
        "\n\n".join(
            (
                "# acceptance",
                made_on(results["machine"]),
                f"{results['photos']} photos of {results['width_px']} px from 1400 mm; one capture "
                "each; errors in mm as the certificate has them.",
                table(heads, rows),
            )
        )
        + "\n"
    )


_KINDS = ("size", "spacing", "form")


def _listed(one: Result, kind: str, how: str) -> str:
    return ", ".join(f"{row['error_mm']:{how}}" for row in one["values"] if row["kind"] == kind)


if __name__ == "__main__":
    main()
