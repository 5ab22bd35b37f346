"""Masks: what they change of a good capture, and what they save of one with a spoiled background.

    python benchmarks/masks.py -o benchmarks/results/masks.json [--seeds 2]

Each seed is a small capture. Its background is spoiled by that of a walk the other way round
another limb in another room: only the limb and the board stay. The masks are those that `limbgram
masks` makes of the good capture's case, given back by `--masks`: of all photos, and of all but two.
Every second limb is painted sparsely, so that the room counts for more. What OUT holds already is
not done again.
"""

import json
import shutil
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from PIL import Image

from captures import JUDGED, LIMBGRAM, accuracy, timed
from harness import asking, found_before, machine, made_on, table, write
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.targets.board_detection import find_board
from limbgram.synthetic import CaptureOptions, make_capture
from limbgram.synthetic.props.board import SCALE_BOARD

SMALL = CaptureOptions(
    photos=14, width_px=900, height_px=600, calibration_photos=12, mesh_step_mm=1.0, samples=2
)
SPARSE = 0.12
"""Share of the sock that the paint of every second seed hides."""
FIRST_SEED = 501
OTHER = 1000
"""Added to a seed, the other walk's."""
EDGE_PX = 6
"""Of the first room that is left round the limb."""
LEFT_WHOLE = 2
"""Photos without a mask."""


def main() -> None:
    parser = asking(__doc__, keep="captures and cases")
    parser.add_argument("--seeds", type=int, default=2)
    chosen = parser.parse_args()
    found: dict[str, Any] = found_before(chosen.out, {})
    found = {"runs": {}} | found | {"machine": machine()}
    with tempfile.TemporaryDirectory() as scratch:
        for seed in range(FIRST_SEED, FIRST_SEED + chosen.seeds):
            if str(seed) in found["runs"]:
                continue
            folder = (chosen.keep or Path(scratch)) / str(seed)
            folder.mkdir(parents=True, exist_ok=True)
            found["runs"][str(seed)] = one(seed, folder)
            write(chosen.out, found)
            sys.stderr.write(f"{seed}: {json.dumps(found['runs'][str(seed)])}\n")


def one(seed: int, folder: Path) -> dict[str, Any]:
    """A good capture and a spoiled one, without masks and with."""
    good, spoiled, masks, few = (folder / name for name in ("good", "spoiled", "masks", "few"))
    if not good.exists():
        sparse = {} if seed % 2 else {"coverage": SPARSE}
        make_capture(good, replace(SMALL, seed=seed, **sparse))
    if not spoiled.exists():
        spoil(good, seed, folder, spoiled)
    camera = folder / "camera.json"
    board = ["--board", "14x10", "--square", "10", "-o", str(camera)]
    timed([LIMBGRAM, "calibrate", str(good / "calibration"), *board])
    runs = {"good, no masks": reconstructed(good, good, camera, folder / "case")}
    shutil.rmtree(masks, ignore_errors=True)
    timed([LIMBGRAM, "masks", str(folder / "case"), "-o", str(masks)])
    shutil.rmtree(few, ignore_errors=True)
    shutil.copytree(masks, few)
    for mask in sorted(few.glob("*.png"))[:LEFT_WHOLE]:
        mask.unlink()
    for name, source, given in (
        ("good, its own masks", good, masks),
        ("spoiled, no masks", spoiled, None),
        ("spoiled, masks", spoiled, masks),
        (f"spoiled, masks but for {LEFT_WHOLE}", spoiled, few),
    ):
        runs[name] = reconstructed(source, good, camera, folder / "case-2", given)
    return runs


def spoil(good: Path, seed: int, folder: Path, spoiled: Path) -> None:
    """The same limb and board in the room of another walk, the other way round."""
    other = folder / "other"
    if not other.exists():
        make_capture(other, replace(SMALL, seed=seed + OTHER, board=None, calibration_photos=0))
    (spoiled / "images").mkdir(parents=True)
    photos = read_photos([good / "images"])
    boards = {one.photo_idx: one for one in find_board(photos, SCALE_BOARD.board).photos}
    elsewhere = sorted((other / "images").iterdir(), reverse=True)
    for idx, (photo, room) in enumerate(zip(photos.photos, elsewhere, strict=True)):
        mask = good / "truth" / "masks" / Path(photo.name).with_suffix(".png")
        keep = np.asarray(Image.open(mask).convert("L")) > 127
        keep = cv2.dilate(keep.astype(np.uint8), np.ones((2 * EDGE_PX + 1,) * 2, np.uint8))
        if idx in boards:
            corners = boards[idx].xy_px
            hull = cv2.convexHull(corners.astype(np.float32))
            middle = hull.mean(axis=0)
            wider = np.round(middle + 1.6 * (hull - middle)).astype(np.int32)
            cv2.fillConvexPoly(keep, wider, 1)
        with Image.open(photo.path) as picture:
            ours, exif = np.asarray(picture.convert("RGB")), picture.getexif()
        theirs = np.asarray(Image.open(room).convert("RGB"))
        both = np.where(keep[:, :, None] > 0, ours, theirs)
        Image.fromarray(both).save(spoiled / "images" / photo.name, quality=94, exif=exif)


def reconstructed(
    source: Path, truth: Path, camera: Path, case: Path, masks: Path | None = None
) -> dict[str, Any]:
    """What came of it, against the truth."""
    shutil.rmtree(case, ignore_errors=True)
    command = [LIMBGRAM, "reconstruct", str(source / "images"), "--camera", str(camera)]
    run = timed([*command, "-o", str(case), *([] if masks is None else ["--masks", str(masks)])])
    if run["exit_code"] not in JUDGED:
        return run
    said, summary = accuracy(case, truth), json.loads((case / "summary.json").read_text())
    return run | {
        "light": said["light"],
        "headline": said["headline"],
        "placed": summary["scene"]["placed"],
        "notes": summary["scene"]["notes"],
        "rms_mm": said["truth"]["rms_mm"],
        "p95_mm": said["truth"]["p95_mm"],
        "scale_error": said["truth"]["scale_error"],
    }


def page(found: dict[str, Any]) -> str:
    heads = ("seed", "capture", "exit", "verdict", "placed", "RMS mm", "95 % mm", "scale", "CPU s",
             "what was said")  # fmt: skip
    rows: list[list[str]] = []
    for seed, runs in found["runs"].items():
        for name, run in runs.items():
            row = [seed, name, str(run["exit_code"])]
            if "rms_mm" in run:
                row += [run["light"], str(run["placed"]), f"{run['rms_mm']:.3f}",
                        f"{run['p95_mm']:.3f}", f"{run['scale_error']:+.3%}"]  # fmt: skip
            else:
                row += [""] * 5
            told = " ".join(run.get("notes", [])) or " ".join(run["message"].split())
            rows.append([*row, f"{run['cpu_s']:.0f}", told])
    return "\n\n".join(["# masks", made_on(found["machine"]), table(heads, rows)]) + "\n"


if __name__ == "__main__":
    main()
