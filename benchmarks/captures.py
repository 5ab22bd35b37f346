"""Whole runs, photos to STL, on captures with and without truth: JSON, a table and a plot.

    python benchmarks/captures.py DATA --judge "python evaluate.py" -o benchmarks/results/all.json
    python benchmarks/captures.py --sweep all paper --rivals -o benchmarks/results/sweep.json

DATA holds rendered/SET (images, calibration, truth) and photos/{flowerpot,skull}; a sweep makes
its captures with the project's own generator (sweep.py). Everything runs through the command
line, each set from nothing in a new folder, calibration from the set's own board photos.
`limbgram accuracy --truth` compares with the truth; a judge, where one is given, scores
deliverables/surface.stl as well. Of a sweep, OUT.png is drawn
beside OUT.json (tables.py).
"""

import argparse
import json
import os
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from harness import asking, machine, write
from limbgram.cases.deliverables import surface_of
from limbgram.core.errors import RED_EXIT_CODE
from limbgram.core.geometry.frames import Rigid, angle_between_deg, fit_similarity
from rivals import installed
from sweep import parse_settings
from tables import plot

HERE = Path(__file__).parent
LIMBGRAM = str(Path(sys.executable).with_name("limbgram"))
CALIBRATED_WITH = {"limb_sparse15": "limb_ring15"}
"""Sets without board photos of their own, and the set of the same camera that has them."""
REPEATED = (
    "rms_mm",
    "p95_mm",
    "mean_mm",
    "within",
    "scale_error",
    "girths",
    "volume_error",
    "sigma",
)
"""Figures against the truth that are kept of a repeat."""
JUDGED = (0, RED_EXIT_CODE)
"""Exit codes of a program that went all the way: green or amber, and red."""


def main() -> None:
    parser = asking(__doc__, keep="captures and case folders")
    parser.add_argument("data", type=Path, nargs="*")
    parser.add_argument("--judge", help="command that scores: RESULT SET --align rigid ...")
    parser.add_argument("--sets", nargs="*", help="only these, by folder name")
    parser.add_argument(
        "--sweep", nargs="*", default=[], help="PHOTOSxMEGAPIXELS such as 8x1, 'all', 'paper'"
    )
    parser.add_argument("--seed", type=int, default=11, help="of the sweep's captures")
    parser.add_argument("--rivals", action="store_true", help="run rivals that are installed")
    parser.add_argument(
        "--repeats", type=int, default=0, help="more runs of a set, each without one of its photos"
    )
    chosen = parser.parse_args()
    results: dict[str, Any] = {"machine": machine(), "sets": {}}
    chosen.out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        folder = chosen.keep or Path(scratch)
        for source, known in jobs(chosen, folder):
            sys.stderr.write(f"{source.name}\n")
            result = known | one_set(source, folder / source.name, chosen.judge)
            camera = folder / source.name / "camera.json"
            if chosen.repeats and camera.exists() and (source / "truth").is_dir():
                result["repeats"] = list(repeats(source, camera, chosen.repeats))
            if chosen.rivals and camera.exists():
                result["rivals"] = against_rivals(source, camera, folder / f"{source.name}_rivals")
            results["sets"][source.name] = result
            write(chosen.out, results)
            plot(results, chosen.out.with_suffix(".png"))


def jobs(chosen: argparse.Namespace, folder: Path) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Captures to run, and what is known of them; those of a sweep are made when asked for."""
    for data in chosen.data:
        for source in sorted([*data.glob("rendered/*"), *data.glob("photos/*")]):
            if not chosen.sets or source.name in chosen.sets:
                yield source, {"photos": count_photos(source)}
    for setting in parse_settings(chosen.sweep, chosen.seed):
        source = folder / "captures" / setting.name
        source.parent.mkdir(parents=True, exist_ok=True)
        made = {}
        if not source.exists():
            made = timed([sys.executable, str(HERE / "sweep.py"), str(source), *setting.arguments])
        yield source, {"photos": setting.photos, "setting": asdict(setting), "made": made}


def count_photos(source: Path) -> int:
    return sum(file.is_file() for file in (source / "images").iterdir())


def against_rivals(source: Path, camera: Path, folder: Path) -> dict[str, Any]:
    """Every installed rival in a process of its own, its poses against the truth."""
    found: dict[str, Any] = {}
    for rival in installed():
        out = folder / rival
        command = [sys.executable, str(HERE / "rivals.py"), rival]
        found[rival] = timed([*command, str(source / "images"), str(camera), str(out)])
        if (out / "poses.json").exists():
            found[rival]["poses"] = against_known(out / "poses.json", source)
    return found


def one_set(source: Path, case: Path, judge: str | None) -> dict[str, Any]:
    """Calibrate where there are board photos, reconstruct, score."""
    case.mkdir(parents=True)
    command = ["reconstruct", str(source / "images"), "-o", str(case / "case"), "--json"]
    result: dict[str, Any] = {}
    picks: list[Path] = []
    boards = source.with_name(CALIBRATED_WITH.get(source.name, source.name)) / "calibration"
    if boards.is_dir():
        camera = case / "camera.json"
        board = ["--board", "14x10", "--square", "10", "-o", str(camera)]
        result["calibrate"] = timed([LIMBGRAM, "calibrate", str(boards), *board])
        command += ["--camera", str(camera)]
    elif picks := list(HERE.glob(f"{source.name}_picks.json")):
        command += ["--known-distance", str(picks[0]), "--no-board"]
    else:
        command += ["--unscaled", "--no-board"]
    result["reconstruct"] = timed([LIMBGRAM, *command])
    summary = case / "case" / "summary.json"
    if summary.exists():
        result["summary"] = json.loads(summary.read_text())
    named = "poses.json" if boards.is_dir() or picks else "poses-unitless.json"
    poses = case / "case" / "deliverables" / named
    if poses.exists():
        result["poses"] = against_known(poses, source)
        result["accuracy"] = accuracy(case / "case", source)
    if judge and poses.exists() and (source / "truth").is_dir():
        result["score"] = score(judge, case / "case" / "deliverables", source, case / "score.json")
    return result


def repeats(source: Path, camera: Path, count: int) -> Iterator[dict[str, Any]]:
    """The same set without one photo, another one each time, evenly spread over the set."""
    photos = sorted(file for file in (source / "images").iterdir() if file.is_file())
    for left_out in photos[len(photos) // (2 * count) :: len(photos) // count][:count]:
        kept = [str(photo) for photo in photos if photo != left_out]
        with tempfile.TemporaryDirectory() as scratch:
            case = Path(scratch) / "case"
            run = timed([LIMBGRAM, "reconstruct", *kept, "--camera", str(camera), "-o", str(case)])
            said = accuracy(case, source)
        truth = {name: said["truth"][name] for name in REPEATED}
        yield {"left_out": left_out.name, "exit_code": run["exit_code"], "truth": truth}


def accuracy(case: Path, source: Path) -> dict[str, Any]:
    """What the case says of itself, and its comparison with the truth where there is one.

    That is None where the surface lies too far from the truth to be compared.
    """
    own = _accuracy_tree(case)
    said = {name: own[name] for name in ("light", "criteria", "expected")}
    said |= {"headline": own["headline"]["sentence"]}
    against = _accuracy_tree(case, source) if (source / "truth").is_dir() else own
    return said | {"truth": against.get("truth")}


def _accuracy_tree(case: Path, truth: Path | None = None) -> dict[str, Any]:
    command = [LIMBGRAM, "accuracy", str(case), "--json"]
    if truth is not None:
        command += ["--truth", str(truth)]
    said = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False)
    tree: dict[str, Any] = json.loads(said.stdout)  # a red verdict has an exit code of its own
    return tree


def timed(command: list[str], environment: Mapping[str, str] | None = None) -> dict[str, Any]:
    """Run a program; wall and CPU seconds of it and its children, largest peak of one process."""
    start = time.perf_counter()
    with tempfile.TemporaryFile() as log:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=log, env=environment)
        _, status, usage = os.wait4(process.pid, 0)
        log.seek(0)
        words = log.read().decode(errors="replace")
    code = os.waitstatus_to_exitcode(status)
    return {
        "exit_code": code,
        "message": "" if code in JUDGED else words[-800:],
        "wall_s": round(time.perf_counter() - start, 1),
        "cpu_s": round(usage.ru_utime + usage.ru_stime, 1),
        "peak_mb": round(usage.ru_maxrss / 1024),
    }


def score(judge: str, deliverables: Path, source: Path, out: Path) -> dict[str, Any]:
    """The judge's figures that the project promises."""
    files = [str(surface_of(deliverables, ".stl")), str(source), "--align", "rigid"]
    files += ["--poses", str(deliverables / "poses.json"), "--out", str(out)]
    subprocess.run([*shlex.split(judge), *files], stdout=subprocess.DEVNULL, check=True)
    full = json.loads(out.read_text())
    return {
        "accuracy_mm": full["accuracy_mm"],
        "completeness_within": full["completeness"]["within"],
        "scale_error_percent": full["scale_error_percent"],
        "girth_errors_mm": [level["error_mm"] for level in full["circumference"]],
        "volume": full["volume"],
        "mesh": full["mesh"],
    }


def against_known(poses: Path, source: Path) -> dict[str, Any] | None:
    """Poses against the truth of a capture, or against reference poses; None without either."""
    if (source / "truth" / "cameras.json").exists():
        return against_poses(read_poses(poses), read_poses(source / "truth" / "cameras.json"))
    reference = list(source.glob("reference_poses*.txt"))
    return against_poses(read_poses(poses), read_reference(reference[0])) if reference else None


def read_poses(path: Path) -> dict[str, Rigid]:
    """camera_from_world by the photo's name without its ending."""
    return {
        Path(pose["name"]).stem: Rigid(np.array(pose["R"]), np.array(pose["t"], float))
        for pose in json.loads(path.read_text())["images"]
    }


def read_reference(path: Path) -> dict[str, Rigid]:
    """The same from lines of name, quaternion (w first) and translation."""
    found: dict[str, Rigid] = {}
    for line in path.read_text().splitlines():
        if not line or line.startswith("#"):
            continue
        name, *numbers = line.split()
        w, x, y, z, *translation = map(float, numbers)
        rotation = Rotation.from_quat([x, y, z, w]).as_matrix()
        found[Path(name).stem] = Rigid(rotation, np.array(translation))
    return found


def against_poses(ours: dict[str, Rigid], theirs: dict[str, Rigid]) -> dict[str, Any]:
    """Camera centres and directions, after a similarity."""
    names = sorted(ours.keys() & theirs.keys())
    centres = np.array([ours[name].centre for name in names])
    known = np.array([theirs[name].centre for name in names])
    fit = fit_similarity(centres, known)
    misses = np.linalg.norm(fit.apply(centres) - known, axis=1)
    radius = np.linalg.norm(known - known.mean(0), axis=1).mean()
    turns = [
        angle_between_deg(fit.move_camera(ours[name]).rotation, theirs[name].rotation)
        for name in names
    ]
    return {
        "photos": len(names),
        "centres_rms_percent_of_radius": float(100 * np.sqrt(np.mean(misses**2)) / radius),
        "rotation_mean_deg": float(np.mean(turns)),
        "rotation_max_deg": float(np.max(turns)),
    }


if __name__ == "__main__":
    main()
