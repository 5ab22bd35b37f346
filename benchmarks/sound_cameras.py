"""Sound cameras: what captures without a fault of the camera ask of the lenses of single photos.

    python benchmarks/sound_cameras.py -o benchmarks/results/sound_cameras.json [--seeds 51]

Small captures (0.35 MP) of other kinds than the usual walk round a painted limb: other limbs,
sparse paint, few photos, two heights, a turntable, a limb that moves, cloth that creeps, things
round it that are moved, no camera file. They are placed, and not made a surface of. A row says how
far the sum of squares would fall if photos had numbers for themselves, how far if the points were
two bodies that move against each other (each less two a number), and what was set free: nothing
should be. Beside them stand a stabiliser and a rolling shutter, which should be found. What OUT
holds already is not done again.
"""

import json
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from harness import asking, found_before, machine, made_on, table, write
from limbgram.core.geometry.lens import PARAMETERS, Camera
from limbgram.core.run import Run
from limbgram.reconstruction.calibration.cameras import Calibration, cameras_for
from limbgram.reconstruction.mapping.bundle_adjustment import adjust
from limbgram.reconstruction.mapping.lens_selection import lens_scores
from limbgram.reconstruction.mapping.two_bodies import AIC_PER_PARAMETER, explained_by_two_bodies
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.pipeline import DEFAULTS, place_photos
from limbgram.synthetic import (
    PHONE,
    CaptureOptions,
    Fault,
    LimbKind,
    Movement,
    MovementKind,
    Turning,
    make_capture,
    with_faults,
)

_SMALL = CaptureOptions(
    photos=12,
    width_px=720,
    height_px=480,
    calibration_photos=0,
    samples=2,
    mesh_step_mm=1.5,
)
_PHONE = replace(_SMALL, width_px=680, height_px=510, distance_mm=500.0, lens=PHONE)
_SIGMAS = {
    "fx": 0.2, "fy": 0.2, "cx": 0.5, "cy": 0.5, "k1": 1e-3, "k2": 3e-3, "p1": 1e-4, "p2": 1e-4,
}  # fmt: skip
"""Of a calibration that is given true."""
_WITHOUT_FILE = "no camera file"
_FAULTY = ("stabiliser", "rolling shutter")
KINDS: dict[str, CaptureOptions] = {
    "walk round": _SMALL,
    "phone": _PHONE,
    "thigh": replace(_PHONE, kind=LimbKind.TRANSFEMORAL),
    "bulbous": replace(_SMALL, kind=LimbKind.BULBOUS),
    "sparse paint": replace(_PHONE, coverage=0.12),
    "8 photos": replace(_PHONE, photos=8),
    "two heights": replace(_SMALL, photos=16, rings=2),
    "turntable": replace(_SMALL, photos=16, turning=Turning()),
    "limb steps by 8 mm": replace(_PHONE, movement=Movement(shift_mm=8.0)),
    "limb steps by 2 mm": replace(_PHONE, movement=Movement(shift_mm=2.0)),
    "limb drifts by 4 mm": replace(
        _PHONE, movement=Movement(kind=MovementKind.DRIFT, shift_mm=4.0)
    ),
    "cloth creeps": with_faults(_PHONE, [Fault.CREEP]),
    "things round it moved": with_faults(_PHONE, [Fault.BACKGROUND]),
    _WITHOUT_FILE: _PHONE,
    "stabiliser": with_faults(_PHONE, [Fault.STABILISER]),
    "rolling shutter": with_faults(_PHONE, [Fault.ROLLING]),
}


def main() -> None:
    parser = asking(__doc__)
    parser.add_argument("--seeds", type=int, nargs="*", default=[51])
    parser.add_argument("--kinds", nargs="*", default=list(KINDS), choices=list(KINDS))
    parser.add_argument("--minutes", type=float, default=1e9, help="stop after so long")
    chosen = parser.parse_args()
    end = time.monotonic() + 60 * chosen.minutes
    known: dict[str, Any] = found_before(chosen.out, {})
    result: dict[str, Any] = {"captures": {}} | known | {"machine": machine()}
    for seed in chosen.seeds:
        for kind in chosen.kinds:
            name = f"{kind}, seed {seed}"
            if name in result["captures"] or time.monotonic() > end:
                continue
            result["captures"][name] = found = _one(kind, seed)
            sys.stderr.write(f"{name}: {json.dumps(found)}\n")
            write(chosen.out, result)


def _one(kind: str, seed: int) -> dict[str, Any]:
    """One capture placed, and what its residuals ask for with one lens for all photos."""
    with tempfile.TemporaryDirectory() as scratch:
        source = Path(scratch) / "capture"
        make_capture(source, replace(KINDS[kind], seed=seed))
        given = [] if kind == _WITHOUT_FILE else [_true_calibration(source)]
        run = Run()
        photos = read_photos((source / "images",), DEFAULTS.photos)
        cameras = cameras_for(photos, given)
        placing = place_photos(photos, cameras, DEFAULTS, run)
    scene = placing.scene
    alike = adjust(replace(scene, own=None), cameras.calibrations)
    scores = lens_scores(alike, cameras.calibrations)
    return {
        "faulty": kind in _FAULTY,
        "placed": len(scene.placed),
        "sigma_px": alike.sigma_px,
        "asked": {
            one.deviation: {
                "fall_a_number": one.statistic / one.dof,
                "chance": one.p_value,
                "fall": one.statistic,
                "explains": one.statistic - AIC_PER_PARAMETER * one.dof,
            }
            for one in scores
        },
        "two_bodies_explain": explained_by_two_bodies(alike, cameras.calibrations, 30_000)
        if scores
        else None,
        "set_free": [] if scene.own is None else [*scene.own.deviations],
    }


def _true_calibration(source: Path) -> Calibration:
    told = json.loads((source / "truth" / "cameras.json").read_text())
    lens = told["intrinsics"] | told["distortion"]
    size = {"width_px": lens.pop("width"), "height_px": lens.pop("height")}
    return Calibration(
        camera=Camera(**size, **lens),
        covariance=np.diag([_SIGMAS.get(name, 0.0) ** 2 for name in PARAMETERS]),
        source="board",
    )


def page(result: dict[str, Any]) -> str:
    rows = [
        (
            name,
            str(one["placed"]),
            f"{one['sigma_px']:.3f}",
            *(_asked(one["asked"].get(kind)) for kind in _ASKED),
            "" if one["two_bodies_explain"] is None else f"{one['two_bodies_explain']:.0f}",
            ", ".join(one["set_free"]) or "nothing",
        )
        for name, one in result["captures"].items()
    ]
    false = [
        name for name, one in result["captures"].items() if one["set_free"] and not one["faulty"]
    ]
    sound = sum(not one["faulty"] for one in result["captures"].values())
    told = (
        f"{len(false)} of {sound} captures by sound cameras were given lenses of single photos"
        f"{': ' + '; '.join(false) if false else ''}. Cells: by how much the sum of squares would "
        "fall, less two a number, and (in brackets) the whole fall per number; a kind is set free "
        "where that is beyond chance and beyond what two bodies explain, less two a number as well."
    )
    heads = ("capture", "placed", "sigma px", *_ASKED, "two bodies", "set free")
    parts = ("# Sound cameras", made_on(result["machine"]), told, table(heads, rows))
    return "\n\n".join(parts) + "\n"


_ASKED = ("principal point", "focal length", "rolling shutter")


def _asked(one: dict[str, float] | None) -> str:
    return "" if one is None else f"{one['explains']:.0f} ({one['fall_a_number']:.2f})"


if __name__ == "__main__":
    main()
