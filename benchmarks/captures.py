"""Whole runs, photos to STL, on captures with and without truth; results as one JSON file.

    python benchmarks/captures.py DATA --judge "python evaluate.py" -o benchmarks/results/all.json

DATA holds rendered/SET (images, calibration, truth) and photos/{flowerpot,skull}. Everything runs
through the command line, each set from nothing in a new folder, calibration from the set's own
board photos. The judge scores deliverables/surface.stl against the truth after a rigid alignment.
"""

import argparse
import json
import os
import platform
import shlex
import subprocess
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from limbgram.geometry.rigid import Rigid, angle_between_deg
from limbgram.geometry.similarity import fit_similarity

HERE = Path(__file__).parent
LIBRARIES = ("limbgram", "numpy", "numba", "opencv-python-headless", "pycolmap", "scipy")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("--judge", help="command that scores: RESULT SET --align rigid ...")
    parser.add_argument("--sets", nargs="*", help="only these, by folder name")
    parser.add_argument("--keep", type=Path, help="keep the case folders here")
    parser.add_argument("-o", "--out", type=Path, required=True)
    chosen = parser.parse_args()
    results: dict[str, Any] = {"machine": machine(), "sets": {}}
    with tempfile.TemporaryDirectory() as scratch:
        folder = chosen.keep or Path(scratch)
        for source in sorted([*chosen.data.glob("rendered/*"), *chosen.data.glob("photos/*")]):
            if chosen.sets and source.name not in chosen.sets:
                continue
            sys.stderr.write(f"{source.name}\n")
            results["sets"][source.name] = one_set(source, folder / source.name, chosen.judge)
            chosen.out.parent.mkdir(parents=True, exist_ok=True)
            chosen.out.write_text(json.dumps(results, indent=1) + "\n")


def one_set(source: Path, case: Path, judge: str | None) -> dict[str, Any]:
    """Calibrate where there are board photos, reconstruct, score."""
    case.mkdir(parents=True)
    command = ["reconstruct", str(source / "images"), "-o", str(case / "case"), "--json"]
    result: dict[str, Any] = {}
    picks: list[Path] = []
    if (source / "calibration").is_dir():
        camera = case / "camera.json"
        board = ["--board", "14x10", "--square", "10", "-o", str(camera)]
        result["calibrate"] = timed(["calibrate", str(source / "calibration"), *board])
        command += ["--camera", str(camera)]
    elif picks := list(HERE.glob(f"{source.name}_picks.json")):
        command += ["--known-distance", str(picks[0]), "--no-board"]
    else:
        command += ["--unscaled", "--no-board"]
    result["reconstruct"] = timed(command)
    summary = case / "case" / "summary.json"
    if summary.exists():
        result["summary"] = json.loads(summary.read_text())
    named = "poses.json" if (source / "calibration").is_dir() or picks else "poses-unitless.json"
    poses = case / "case" / "deliverables" / named
    if poses.exists() and (reference := list(source.glob("reference_poses*.txt"))):
        result["poses"] = against_reference(poses, reference[0])
    if judge and poses.exists() and (source / "truth").is_dir():
        result["score"] = score(judge, case / "case" / "deliverables", source, case / "score.json")
    return result


def timed(arguments: list[str]) -> dict[str, Any]:
    """Run limbgram; wall and CPU seconds of it and its children, largest peak of one process."""
    start = time.perf_counter()
    with tempfile.TemporaryFile() as log:
        process = subprocess.Popen(
            [Path(sys.executable).with_name("limbgram"), *arguments],
            stdout=subprocess.DEVNULL,
            stderr=log,
        )
        _, status, usage = os.wait4(process.pid, 0)
        log.seek(0)
        words = log.read().decode(errors="replace")
    code = os.waitstatus_to_exitcode(status)
    return {
        "exit_code": code,
        "message": "" if code == 0 else words[-800:],
        "wall_s": round(time.perf_counter() - start, 1),
        "cpu_s": round(usage.ru_utime + usage.ru_stime, 1),
        "peak_mb": round(usage.ru_maxrss / 1024),
    }


def score(judge: str, deliverables: Path, source: Path, out: Path) -> dict[str, Any]:
    """The judge's figures that the project promises."""
    files = [str(deliverables / "surface.stl"), str(source), "--align", "rigid"]
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


def against_reference(poses: Path, reference: Path) -> dict[str, Any]:
    """Camera centres and directions against reference poses, after a similarity."""
    ours = {
        Path(pose["name"]).stem: Rigid(np.array(pose["R"]), np.array(pose["t"]))
        for pose in json.loads(poses.read_text())["images"]
    }
    theirs: dict[str, Rigid] = {}
    for line in reference.read_text().splitlines():
        if not line or line.startswith("#"):
            continue
        name, *numbers = line.split()
        w, x, y, z, *translation = map(float, numbers)
        rotation = Rotation.from_quat([x, y, z, w]).as_matrix()
        theirs[Path(name).stem] = Rigid(rotation, np.array(translation))
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


def machine() -> dict[str, Any]:
    """What the figures were measured on."""
    commit = subprocess.run(
        ["git", "-C", str(HERE), "rev-parse", "HEAD"], capture_output=True, text=True, check=False
    )
    return {
        "system": platform.platform(),
        "processor": platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "versions": {name: version(name) for name in LIBRARIES},
        "commit": commit.stdout.strip(),
    }


if __name__ == "__main__":
    main()
