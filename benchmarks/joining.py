"""Photos joined by coded marks where the paint is too thin to join them: before, after, and truth.

    python benchmarks/joining.py -o benchmarks/results/joining.json [--first 5] [--seeds 2]

A limb with hardly any paint turns before a still camera in large steps; the board stands still in
the room. The same photos are placed by paint alone and by paint and marks. What OUT holds already
is not done again; each line keeps its commit.
"""

import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from harness import asking, found_before, machine, made_on, table, write
from limbgram.core.errors import LimbgramError
from limbgram.core.geometry.frames import fit_similarity
from limbgram.core.run import Run
from limbgram.reconstruction.calibration.cameras import Calibration, cameras_for
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.pipeline import PipelineOptions, place_photos
from limbgram.reconstruction.targets.marks import MarkOptions
from limbgram.synthetic import Capture, CaptureOptions, Turning, make_capture
from limbgram.synthetic.props.stickers import SockSticker

GOLDEN = 0.381966
NO_MARKS = MarkOptions(min_side_px=1e9)
"""Takes every mark for too small."""
SIGMAS = np.array([0.7, 0.7, 1.0, 1.0, 0.0, 2e-3, 4e-2, 1e-4, 1e-4, 0.0])


def main() -> None:
    parser = asking(__doc__)
    parser.add_argument("--first", type=int, default=5, help="first seed")
    parser.add_argument("--seeds", type=int, default=2)
    chosen = parser.parse_args()
    found: dict[str, Any] = found_before(chosen.out, {})
    found = {"runs": {}} | found | {"machine": machine()}
    for seed in range(chosen.first, chosen.first + chosen.seeds):
        if str(seed) in found["runs"]:
            continue
        with tempfile.TemporaryDirectory() as folder:
            run = one(seed, Path(folder) / "capture")
        found["runs"][str(seed)] = run | {"commit": found["machine"]["commit"][:12]}
        write(chosen.out, found)
        sys.stderr.write(f"{seed}: {json.dumps(run)[:200]}\n")


def options_of(seed: int) -> CaptureOptions:
    """Steps, paint and marks drawn by the seed."""
    random = np.random.default_rng((seed, 23))
    count = int(random.integers(30, 48))
    turn = float(random.uniform())
    stickers = tuple(
        SockSticker(
            mark_id=20 + k,
            around=(turn + GOLDEN * k) % 1.0,
            height=0.12 + 0.76 * (k + 0.5) / count,
            side_mm=18.0,
            twist_deg=float(random.uniform(-180, 180)),
        )
        for k in range(count)
    )
    return CaptureOptions(
        seed=seed,
        photos=int(random.integers(10, 13)),
        width_px=1050,
        height_px=700,
        distance_mm=1100.0,
        calibration_photos=0,
        mesh_step_mm=2.0,
        samples=2,
        coverage=float(random.uniform(0.02, 0.06)),
        turning=Turning(board_turns=False),
        stickers=stickers,
    )


def one(seed: int, folder: Path) -> dict[str, Any]:
    options = options_of(seed)
    capture = make_capture(folder, options)
    told: dict[str, Any] = {
        "photos": options.photos,
        "marks": len(options.stickers),
        "coverage": options.coverage,
    }
    for name, marks in (("paint", NO_MARKS), ("paint and marks", MarkOptions())):
        told[name] = placed(capture, PipelineOptions(marks=marks))
    return told


def placed(capture: Capture, options: PipelineOptions) -> dict[str, Any]:
    """The photos placed, and how far their centres are from the truth."""
    camera = capture.truth.views[0].camera
    known = Calibration(camera=camera, covariance=np.diag(SIGMAS**2), source="board")
    photos = read_photos((capture.folder / "images",))
    cameras = cameras_for(photos, (known,))
    start = time.process_time()
    try:
        scene = place_photos(photos, cameras, options, Run()).scene
    except LimbgramError as refusal:
        return {"refused": str(refusal)}
    cpu_s = round(time.process_time() - start, 1)
    left_out = () if scene.marks is None else scene.marks.left_out
    return {
        "placed": len(scene.placed),
        "ring_closed": scene.ring is not None and scene.ring.closed,
        "centre_rms_mm": centre_rms_mm(scene, capture),
        "marks_left_out": list(left_out),
        "cpu_s": cpu_s,
    }


def centre_rms_mm(scene: Scene, capture: Capture) -> float:
    true = np.array([capture.truth.views[k].centre_in_world for k in scene.placed])
    here = np.array([view.centre_in_world for view in scene.views])
    off = fit_similarity(here, true).apply(here) - true
    return float(np.sqrt((off**2).sum(1).mean()))


def page(found: dict[str, Any]) -> str:
    heads = ("seed", "photos", "marks", "painted", "by", "placed", "ring", "centres mm",
             "marks left out", "CPU s", "commit")  # fmt: skip
    rows: list[list[str]] = []
    for seed, run in found["runs"].items():
        for name in ("paint", "paint and marks"):
            one = run[name]
            row = [seed, str(run["photos"]), str(run["marks"]), f"{run['coverage']:.0%}", name]
            if "refused" in one:
                row += ["refused", "", "", "", ""]
            else:
                row += [
                    str(one["placed"]),
                    "closed" if one["ring_closed"] else "open",
                    f"{one['centre_rms_mm']:.3f}",
                    ", ".join(map(str, one["marks_left_out"])),
                    f"{one['cpu_s']:g}",
                ]
            rows.append([*row, run["commit"]])
    parts = ["# Photos joined by coded marks", made_on(found["machine"]), table(heads, rows)]
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    main()
