"""A film of a rendered walk against stills of the same walk, both against the exact truth.

    python benchmarks/video.py -o benchmarks/results/video.json [--ffmpeg FFMPEG]

The walk is rendered frame by frame (uneven speed; a third of the frames blurred by the hand), coded
as a film, and its frames are chosen by `limbgram frames`. The stills are as many sharp frames of
the same walk, evenly spread, as the renderer stored them. Frames keep the name of their photo, so
that both are held against the same cameras. OpenCV codes MPEG-4 itself; H.264 and HEVC, as phones
write them, are coded by the program ffmpeg, where there is one.
"""

import argparse
import json
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from captures import LIMBGRAM, accuracy, read_poses, timed
from harness import asking, machine, working_in, write
from limbgram.synthetic import CaptureOptions, make_capture

RATE = 30
_QUALITY = 20
"""Of x264 and x265 (CRF): hardly to be told from the source by eye."""
_SHAKEN = (2, 3, 4)
"""Of nine frames one after another, those that the hand blurs."""


def main() -> None:
    parser = asking(__doc__, keep="captures and cases")
    parser.add_argument("--frames", type=int, default=108, help="of the film")
    parser.add_argument("--count", type=int, default=24, help="frames to take")
    parser.add_argument("--width", type=int, default=1200)
    parser.add_argument("--seed", type=int, default=21)
    parser.add_argument("--ffmpeg", default="ffmpeg", help="program that codes H.264 and HEVC")
    parser.add_argument(
        "--choice-only", action="store_true", help="make no surfaces: only look at what is chosen"
    )
    chosen = parser.parse_args()
    with working_in(chosen.keep) as folder:
        compare(chosen, folder)


def compare(chosen: argparse.Namespace, folder: Path) -> None:
    """Make the film, run film and stills, write the figures after each."""
    source = folder / "walk"
    shaken = tuple(k for k in range(chosen.frames) if k % 9 in _SHAKEN)
    options = CaptureOptions(
        seed=chosen.seed, photos=chosen.frames, filmed=True, width_px=chosen.width,
        height_px=round(chosen.width * 2 / 3) // 8 * 8, distance_mm=1100.0, mesh_step_mm=1.0,
        calibration_photos=0 if chosen.choice_only else 12, shaken=shaken,
        shake_px=0.006 * chosen.width, jpeg_quality=97,
    )  # fmt: skip
    if not source.exists():
        make_capture(source, options)
    frames = sorted((source / "images").iterdir())
    camera = None if chosen.choice_only else folder / "camera.json"
    if camera is not None:
        board = ["--board", "14x10", "--square", "10", "-o", str(camera)]
        timed([LIMBGRAM, "calibrate", str(source / "calibration"), *board])
    result: dict[str, Any] = {
        "machine": machine(),
        "walk": {"frames": len(frames), "width_px": options.width_px,
                 "height_px": options.height_px, "seed": options.seed, "blurred": len(shaken)},
        "runs": {},
    }  # fmt: skip

    def keep(name: str, run: dict[str, Any]) -> None:
        result["runs"][name] = run
        write(chosen.out, result)
        sys.stderr.write(f"{name}: done\n")

    if camera is not None:
        keep("stills", run_of(stills_of(chosen, source, frames, shaken, folder), source, camera,
                              folder / "stills-case"))  # fmt: skip
    coders: dict[str, Callable[[Path], Path]] = {}
    if shutil.which(chosen.ffmpeg):
        coders["h264"] = lambda to: as_phones_do(frames, to, chosen.ffmpeg, "libx264")
        coders["hevc"] = lambda to: as_phones_do(frames, to, chosen.ffmpeg, "libx265")
    coders["mpeg4"] = lambda to: mpeg4(frames, to)
    for name, coder in coders.items():
        film = coder(folder / f"{name}.mp4")
        keep(name, of_film(film, source, camera, folder / name, frames, shaken, chosen.count))


def stills_of(
    chosen: argparse.Namespace,
    source: Path,
    frames: Sequence[Path],
    shaken: Sequence[int],
    folder: Path,
) -> Path:
    """As many sharp frames as are taken of a film, evenly round, as a photographer would."""
    sharp = [k for k in range(len(frames)) if k not in shaken]
    turns = azimuths_deg(source, frames)
    spread = [
        min(sharp, key=lambda k, at=at: abs(turns[k] - at))
        for at in np.linspace(turns[0], turns[0] + 360, chosen.count, endpoint=False)
    ]
    stills = folder / "stills"
    stills.mkdir(exist_ok=True)
    for k in sorted(set(spread)):
        shutil.copy(frames[k], stills / frames[k].name)
    return stills


def of_film(
    film: Path,
    source: Path,
    camera: Path | None,
    folder: Path,
    frames: Sequence[Path],
    shaken: Sequence[int],
    count: int,
) -> dict[str, Any]:
    """Choose the film's frames, name them as their photos, reconstruct."""
    cost = timed([LIMBGRAM, "frames", str(film), "-o", str(folder), "--count", str(count)])
    record = json.loads((folder / "frames.json").read_text())
    taken = [frame["number"] for frame in record["frames"] if frame["taken"]]
    images = folder / "named"
    images.mkdir(exist_ok=True)
    for frame in record["frames"]:
        if frame["taken"]:
            named = images / frames[frame["number"]].name
            shutil.copy(folder / "photos" / frame["name"], named)
    turns = azimuths_deg(source, frames)
    by_time = np.linspace(0, len(frames) - 1, len(taken)).round().astype(int).tolist()
    found = {
        "film_mb": round(film.stat().st_size / 2**20, 2),
        "frames": cost,
        "taken": len(taken),
        "taken_blurred": len(set(taken) & set(shaken)),
        "largest_gap_deg": largest_gap_deg(turns[taken]),
        "evenly_in_time": {
            "taken_blurred": len(set(by_time) & set(shaken)),
            "largest_gap_deg": largest_gap_deg(turns[by_time]),
        },
    }
    return found if camera is None else found | run_of(images, source, camera, folder / "case")


def largest_gap_deg(turns: np.ndarray) -> float:
    """Widest angle without a frame, over a walk that ends where it began."""
    around = np.sort(turns % 360.0)
    return round(float(np.diff(around, append=around[0] + 360.0).max()), 1)


def run_of(images: Path, source: Path, camera: Path, case: Path) -> dict[str, Any]:
    words = ["reconstruct", str(images), "--camera", str(camera), "-o", str(case)]
    run: dict[str, Any] = {"reconstruct": timed([LIMBGRAM, *words])}
    if not (case / "summary.json").exists():
        return run
    summary = json.loads((case / "summary.json").read_text())
    run["photos"] = len(summary["photos"])
    run["placed"] = sum(photo["placed"] for photo in summary["photos"])
    return run | accuracy(case, source)


def azimuths_deg(source: Path, frames: Sequence[Path]) -> np.ndarray:
    """Where each frame was taken from, unwound."""
    poses = read_poses(source / "truth" / "cameras.json")
    centres = np.array([poses[frame.stem].centre for frame in frames])
    return np.degrees(np.unwrap(np.arctan2(centres[:, 1], centres[:, 0])))


def mpeg4(frames: Sequence[Path], to: Path) -> Path:
    first = cv2.imread(str(frames[0]))
    size = (first.shape[1], first.shape[0])
    writer = cv2.VideoWriter(str(to), cv2.VideoWriter_fourcc(*"mp4v"), RATE, size)
    for frame in frames:
        writer.write(cv2.imread(str(frame)))
    writer.release()
    return to


def as_phones_do(frames: Sequence[Path], to: Path, ffmpeg: str, codec: str) -> Path:
    """Coded in one pass at constant quality, a key frame a second.

    Not at a phone's bit rate: of a walk in few frames each is as far from the last as ten of a
    phone's film are, and at that rate would be blurred as none of those.
    """
    listed = to.with_suffix(".txt")
    listed.write_text("".join(f"file '{frame.resolve()}'\n" for frame in frames))
    words = ["-y", "-r", str(RATE), "-f", "concat", "-safe", "0", "-i", str(listed)]
    words += ["-c:v", codec, "-preset", "veryfast", "-g", str(RATE), "-crf", str(_QUALITY)]
    words += ["-pix_fmt", "yuv420p", "-r", str(RATE), str(to)]
    subprocess.run([ffmpeg, *words], check=True, capture_output=True)
    return to


if __name__ == "__main__":
    main()
