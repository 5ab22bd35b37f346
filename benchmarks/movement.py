"""A limb that moves while it is photographed: is it noticed, and what becomes of the surface?

    python benchmarks/movement.py -o benchmarks/results/movement.json [--seeds 6] [--surfaces 2]

Captures of 12 photos of 0.35 MP, rendered with the limb in another place of the room in half of the
photos (a step), a little farther in each (a drift), elsewhere in every photo (a sway), or nowhere
else (still). Every seed is another limb, paint, walk, room and direction of the movement. Photos
are placed and looked at for movement; of some the whole surface is made and held against the truth,
which is told in the limb's own frame. What OUT holds already is not done again, so that a long list
can be worked off in several goes (--minutes, --only still:0 step:2); each line keeps its commit.
"""

import argparse
import json
import statistics
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from captures import LIMBGRAM, accuracy, timed
from harness import asking, found_before, machine, made_on, table, working_in, write
from limbgram.core.run import Run
from limbgram.formats.camera import read_camera
from limbgram.reconstruction.calibration.cameras import Calibration, cameras_for
from limbgram.reconstruction.movement import LabelledScene, find_movement, tell_sides
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.pipeline import PipelineOptions, place_photos
from limbgram.reconstruction.scale.visibility import aim_of
from limbgram.synthetic import CaptureOptions, Movement, MovementKind, make_capture

_BOARD = "charuco:7x5:30:22:4X4_50"
_FIRST_SEED = 301
_DISTANCE_MM = 1500.0
_CLASSES = (
    ("still", 0.0),
    ("step", 2.0),
    ("drift", 2.0),
    ("step", 8.0),
    ("drift", 8.0),
    ("step", 4.0),
    ("step", 10.0),
    ("sway", 4.0),
    ("drift", 4.0),
    ("drift", 10.0),
    ("sway", 8.0),
    ("sway", 2.0),
    ("sway", 10.0),
)
"""In the order of a go, so that one that is cut short has some of each."""
_SURFACES = (("still", 0.0), ("step", 8.0), ("drift", 8.0), ("sway", 4.0))
"""Of these the surface is made as well."""


@dataclass(frozen=True)
class Setting:
    """One capture."""

    kind: str
    shift_mm: float
    seed: int

    @property
    def name(self) -> str:
        return f"{self.kind}_{self.shift_mm:g}_s{self.seed}"

    @property
    def options(self) -> CaptureOptions:
        movement = None
        if self.kind != "still":
            movement = Movement(kind=MovementKind(self.kind), shift_mm=self.shift_mm)
        return CaptureOptions(
            seed=self.seed, photos=12, width_px=720, height_px=480, calibration_photos=0,
            mesh_step_mm=1.0, samples=2, movement=movement, distance_mm=_DISTANCE_MM,
        )  # fmt: skip


def main() -> None:
    parser = asking(__doc__, keep="captures and cases")
    parser.add_argument("--seeds", type=int, default=6, help="captures of each kind")
    parser.add_argument("--surfaces", type=int, default=2, help="surfaces of each of four kinds")
    parser.add_argument("--only", nargs="*", help="these movements alone, KIND:MM")
    parser.add_argument("--minutes", type=float, default=1e9, help="stop after so long")
    chosen = parser.parse_args()
    with working_in(chosen.keep) as folder:
        work(chosen, folder)


def work(chosen: argparse.Namespace, folder: Path) -> None:
    """Everything that is not there yet, written after each."""
    known: dict[str, Any] = found_before(chosen.out, {})
    result = {"looks": {}, "surfaces": {}} | known | {"machine": machine()}
    camera_file = camera_of(folder)
    camera = read_camera(camera_file)
    end = time.monotonic() + 60 * chosen.minutes
    for setting, surface in settings(chosen.seeds, chosen.surfaces):
        part = result["surfaces" if surface else "looks"]
        if chosen.only and f"{setting.kind}:{setting.shift_mm:g}" not in chosen.only:
            continue
        if setting.name in part or time.monotonic() > end:
            continue
        source = folder / setting.name
        if not source.exists():
            make_capture(source, setting.options)
        part[setting.name] = (
            surfaced(setting, source, camera_file, folder)
            if surface
            else looked(setting, source, camera)
        ) | {"commit": result["machine"]["commit"][:12]}
        write(chosen.out, result)
        sys.stderr.write(f"{setting.name}: {json.dumps(part[setting.name])[:200]}\n")


def settings(seeds: int, surfaces: int) -> Iterator[tuple[Setting, bool]]:
    """The captures, and whether the surface is made."""
    for k in range(max(seeds, surfaces)):
        for row, (kind, shift_mm) in enumerate(_CLASSES):
            setting = Setting(kind, shift_mm, _FIRST_SEED + k + 100 * row)
            if k < seeds:
                yield setting, False
            if k < surfaces and (kind, shift_mm) in _SURFACES:
                yield setting, True


def camera_of(folder: Path) -> Path:
    """The camera of all these captures, calibrated as a clinic does."""
    camera = folder / "camera.json"
    if not camera.exists():
        bench = folder / "bench"
        if not bench.exists():
            make_capture(
                bench,
                CaptureOptions(
                    seed=300, photos=3, width_px=720, height_px=480, calibration_photos=15,
                    mesh_step_mm=2.0, samples=2, distance_mm=_DISTANCE_MM,
                ),
            )  # fmt: skip
        words = ["calibrate", str(bench / "calibration"), "--board", "14x10", "--square", "10"]
        timed([LIMBGRAM, *words, "-o", str(camera)])
    return camera


def looked(setting: Setting, source: Path, camera: Calibration) -> dict[str, Any]:
    """Place the photos and look for movement."""
    run, options = Run(), PipelineOptions()
    photos = run(read_photos, (source / "images",), options.photos)
    cameras = run(cameras_for, photos, (camera,))
    placing = place_photos(photos, cameras, options, run)
    start = time.process_time()
    labelled = LabelledScene(
        photos=photos,
        features=placing.features,
        matches=placing.matches,
        scene=placing.scene,
        sides=tell_sides(photos, placing.features, placing.scene),
        cameras=cameras,
    )
    seen = find_movement(labelled)
    cpu_s = time.process_time() - start
    found = seen.movement
    aim = aim_of(placing.scene.views, placing.scene.points_in_world)
    known = np.isfinite(found.shift)
    shift_mm = found.shift * _DISTANCE_MM / aim.distance
    return {
        "kind": setting.kind,
        "shift_mm": setting.shift_mm,
        "found": found.kind,
        "moved": found.moved,
        "largest_mm": round(float(shift_mm[known].max()), 2) if known.any() else None,
        "chance": found.chance,
        "reason": found.reason,
        "placed": len(placing.scene.placed),
        "cpu_s": round(cpu_s, 2),
    }


def surfaced(setting: Setting, source: Path, camera: Path, folder: Path) -> dict[str, Any]:
    """Make the surface and hold it against the truth."""
    case = folder / f"{setting.name}-case"
    words = ["reconstruct", str(source / "images"), "--camera", str(camera), "-o", str(case)]
    run = timed([LIMBGRAM, *words, "--board", _BOARD])
    told: dict[str, Any] = {"kind": setting.kind, "shift_mm": setting.shift_mm, "reconstruct": run}
    if not (case / "summary.json").exists():
        return told
    said = accuracy(case, source)
    truth = said["truth"]
    moved = next((one for one in said["criteria"] if one["key"] == "movement"), None)
    return told | {
        "light": said["light"],
        "headline": said["headline"],
        "movement": moved and moved["finding"]["sentence"],
        "rms_mm": truth["rms_mm"],
        "p95_mm": truth["p95_mm"],
        "mean_mm": truth["mean_mm"],
    }


def page(result: dict[str, Any]) -> str:
    """Both tables, for people."""
    looks = list(result["looks"].values())
    parts = ["# movement", made_on(result["machine"]), "## Is it noticed?", _looks(looks)]
    cpu_s = [one["cpu_s"] for one in looks]
    if cpu_s:
        parts.append(f"The look takes {statistics.median(cpu_s):.1f} CPU s (median).")
    parts += ["## Surfaces against the truth", _surfaces(result["surfaces"])]
    return "\n\n".join(parts) + "\n"


def _looks(looks: Sequence[dict[str, Any]]) -> str:
    heads = ("movement", "mm", "captures", "said to have moved", "found as",
             "mm from the reference", "largest chance")  # fmt: skip
    rows: list[Sequence[str]] = []
    for kind, shift_mm in _CLASSES:
        some = [one for one in looks if (one["kind"], one["shift_mm"]) == (kind, shift_mm)]
        if not some:
            continue
        found = sorted({one["found"] for one in some})
        named = ", ".join(f"{one} {sum(k['found'] == one for k in some)}" for one in found)
        sizes = [one["largest_mm"] for one in some if one["moved"]]
        largest = f"{min(sizes):.1f} to {max(sizes):.1f}" if sizes else "-"
        moved = sum(one["moved"] for one in some)
        chance = max(one["chance"] for one in some)
        rows.append((kind, f"{shift_mm:g}", str(len(some)), str(moved), named, largest,
                     f"{chance:.0e}"))  # fmt: skip
    return table(heads, rows)


def _surfaces(surfaces: dict[str, Any]) -> str:
    heads = ("capture", "exit", "light", "RMS mm", "95 % mm", "mean mm", "CPU s", "movement")
    rows: list[Sequence[str]] = []
    for name, one in surfaces.items():
        run = one["reconstruct"]
        figures = [
            f"{one[key]:.3f}" if key in one else "-" for key in ("rms_mm", "p95_mm", "mean_mm")
        ]
        rows.append((name, str(run["exit_code"]), one.get("light", "-"), *figures,
                     str(run["cpu_s"]), one.get("movement") or run["message"]))  # fmt: skip
    return table(heads, rows)


if __name__ == "__main__":
    main()
