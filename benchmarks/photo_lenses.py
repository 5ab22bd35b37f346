"""Lenses of single photos: what stabiliser, focus and rolling shutter cost with and without them.

    python benchmarks/photo_lenses.py -o benchmarks/results/photo_lenses.json [--seeds 41 42]

Captures of a phone (14 photos of 0.75 MP at 0.5 m, a stabiliser that wanders by 0.0025 of the
width, usual breathing and readout), each calibrated from its own board photos by the same camera.
Every capture is reconstructed twice from the same photos: with one lens for all photos, and with
lenses of their own where the residuals ask for them. Beside these, ideal photos (a false alarm is
counted where anything is set free) and a limb that steps by 8 mm between the photos, with a still
and with a stabilised lens: what is said of its movement. What OUT holds already is not done again.
"""

import json
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import limbgram
from captures import LIMBGRAM, timed
from harness import asking, found_before, machine, made_on, table, working_in, write
from limbgram.cases.scoring import LEAST_PHOTOS, centres_mm, read_truth_mesh
from limbgram.core.run import Run
from limbgram.formats.camera import read_camera
from limbgram.reconstruction.mapping.lens_deviations import largest_px
from limbgram.reconstruction.pipeline import DEFAULTS, reconstruct
from limbgram.report.accuracy.truth import KnownTruth, truth_figures
from limbgram.report.alignment import Truth
from limbgram.synthetic import (
    PHONE,
    SCALE_BOARD,
    CaptureOptions,
    Fault,
    Movement,
    make_capture,
    with_faults,
)

_CAPTURE = CaptureOptions(
    photos=14, width_px=1000, height_px=750, distance_mm=500.0, lens=PHONE, calibration_photos=10,
    samples=2, mesh_step_mm=1.0,
)  # fmt: skip
_FAULTS: dict[str, tuple[Fault, ...]] = {
    "ideal": (),
    "stabiliser": (Fault.STABILISER,),
    "rolling": (Fault.ROLLING,),
    "breathing": (Fault.BREATHING,),
    "all three": (Fault.STABILISER, Fault.ROLLING, Fault.BREATHING),
}
_STEP_MM = 8.0
_WAYS = ("never", "as asked")


@dataclass(frozen=True)
class Setting:
    """One capture."""

    fault: str
    seed: int
    moved: bool = False

    @property
    def name(self) -> str:
        return f"{self.fault.replace(' ', '-')}{'_step' * self.moved}_s{self.seed}"

    @property
    def options(self) -> CaptureOptions:
        movement = Movement(shift_mm=_STEP_MM) if self.moved else None
        chosen = replace(_CAPTURE, seed=self.seed, movement=movement)
        return with_faults(chosen, _FAULTS[self.fault])


def main() -> None:
    parser = asking(__doc__, keep="captures")
    parser.add_argument("--seeds", type=int, nargs="*", default=[41, 42])
    parser.add_argument("--faults", nargs="*", default=list(_FAULTS), choices=list(_FAULTS))
    parser.add_argument("--minutes", type=float, default=1e9, help="stop after so long")
    chosen = parser.parse_args()
    end = time.monotonic() + 60 * chosen.minutes
    known: dict[str, Any] = found_before(chosen.out, {})
    result: dict[str, Any] = {"captures": {}} | known | {"machine": machine()}
    with working_in(chosen.keep) as folder:
        for setting in _settings(chosen.seeds, chosen.faults):
            found = result["captures"].setdefault(setting.name, {})
            for way in _WAYS:
                if way in found or time.monotonic() > end:
                    continue
                found[way] = _one(setting, folder, way)
                sys.stderr.write(f"{setting.name}, {way}: {json.dumps(found[way])}\n")
                write(chosen.out, result)


def _settings(seeds: list[int], faults: list[str]) -> Iterator[Setting]:
    for seed in seeds:
        for fault in faults:
            yield Setting(fault, seed)
        for fault in ("ideal", "stabiliser"):
            if fault in faults:
                yield Setting(fault, seed, moved=True)


def _one(setting: Setting, folder: Path, way: str) -> dict[str, Any]:
    """One capture reconstructed in one way, held against the truth."""
    source = folder / setting.name
    if not source.exists():
        make_capture(source, setting.options)
    camera = source / "camera.json"
    if not camera.exists():
        words = ["calibrate", str(source / "calibration"), "--board", "14x10", "--square", "10"]
        timed([LIMBGRAM, *words, "-o", str(camera)])
    capture = limbgram.Capture(
        sources=(source / "images",),
        calibrations=(read_camera(camera),),
        board=SCALE_BOARD.board,
    )
    mapping = replace(DEFAULTS.mapping, photo_lenses=way)
    start = time.process_time()
    done = reconstruct(capture, replace(DEFAULTS, mapping=mapping), Run())
    seconds = time.process_time() - start
    scene, (vertices, faces) = done.metric.scene, read_truth_mesh(source / "truth" / "mesh.ply")
    true = centres_mm(source / "truth" / "cameras.json")
    truth = Truth(
        vertices_mm=vertices["xyz"].astype(float),
        faces=faces,
        seen=(vertices["ncam"] >= LEAST_PHOTOS) & (vertices["cap"] == 0),
        centres_mm=np.array([true[view.name] for view in scene.views]),
    )
    centres = np.array([view.centre_in_world for view in scene.views])
    pixel_mm = setting.options.distance_mm / scene.cameras[0].fx
    known = KnownTruth(kind="a capture", truth=truth, centres_mm=centres)
    figures = truth_figures(done.mesh, known, pixel_mm).figures
    return {
        "placed": len(scene.placed),
        "sigma_px": scene.sigma_px,
        "set_free": []
        if scene.own is None
        else [
            [kind, largest_px(scene, kind), chance]
            for kind, chance in zip(scene.own.deviations, scene.own.chances, strict=True)
        ],
        "movement": None if scene.movement is None else scene.movement.kind,
        "rms_mm": figures.rms_mm,
        "scale_error": figures.scale_error,
        "camera_rms_mm": figures.camera_rms_mm,
        "worst_girth_mm": max((abs(one.error_mm) for one in figures.girths), default=float("nan")),
        "error_over_sigma": None if figures.sigma is None else figures.sigma.robust_spread,
        "cpu_s": seconds,
    }


def page(result: dict[str, Any]) -> str:
    rows = [
        (
            name,
            way,
            ", ".join(kind for kind, _, _ in one["set_free"]) or "nothing",
            f"{one['sigma_px']:.3f}",
            f"{one['rms_mm']:.3f}",
            f"{100 * one['scale_error']:+.3f} %",
            f"{one['worst_girth_mm']:.2f}",
            f"{one['camera_rms_mm']:.2f}",
            "" if one["error_over_sigma"] is None else f"{one['error_over_sigma']:.2f}",
            one["movement"] or "",
        )
        for name, ways in result["captures"].items()
        for way, one in ways.items()
    ]
    heads = (
        "capture", "own lenses", "set free", "sigma px", "RMS mm", "scale", "worst girth mm",
        "centres mm", "error / sigma", "movement",
    )  # fmt: skip
    parts = ("# Lenses of single photos", made_on(result["machine"]), table(heads, rows))
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    main()
