"""A film of a rendered walk against stills of the same walk, both against the exact truth.

    python benchmarks/video.py -o benchmarks/results/video.json [--h264 H264ENC] [--hevc KVAZAAR]

The walk is rendered frame by frame (uneven speed; a third of the frames blurred by the hand), coded
as a film, and its frames are chosen by `limbgram frames`. The stills are as many sharp frames of
the same walk, evenly spread, as the renderer stored them. Frames keep the name of their photo, so
that both are held against the same cameras. OpenCV codes MPEG-4 itself; H.264 and HEVC, as phones
write them, need the encoders of openh264 (h264enc) and kvazaar, both of BSD licence.
"""

import argparse
import json
import shutil
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from captures import LIMBGRAM, accuracy, machine, read_poses, timed
from limbgram.synthetic import CaptureOptions, make_capture

RATE = 30
_BITS_A_PIXEL = 0.15
"""About what phones spend: 9 megabits a second at 1080p."""
_SHAKEN = (2, 3, 4)
"""Of nine frames one after another, those that the hand blurs."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--out", type=Path, required=True)
    parser.add_argument("--frames", type=int, default=108, help="of the film")
    parser.add_argument("--count", type=int, default=24, help="frames to take")
    parser.add_argument("--width", type=int, default=1200)
    parser.add_argument("--seed", type=int, default=21)
    parser.add_argument("--h264", type=Path, help="program h264enc of openh264")
    parser.add_argument("--hevc", type=Path, help="program kvazaar")
    parser.add_argument(
        "--choice-only", action="store_true", help="make no surfaces: only look at what is chosen"
    )
    parser.add_argument("--keep", type=Path, help="keep captures and cases here")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = chosen.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
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
        chosen.out.write_text(json.dumps(result, indent=1) + "\n")
        sys.stderr.write(f"{name}: done\n")

    if camera is not None:
        keep("stills", run_of(stills_of(chosen, source, frames, shaken, folder), source, camera,
                              folder / "stills-case"))  # fmt: skip
    coders: dict[str, Callable[[Path], Path]] = {}
    if chosen.hevc:
        coders["hevc"] = lambda to: hevc(frames, to, chosen.hevc)
    if chosen.h264:
        coders["h264"] = lambda to: h264(frames, to, chosen.h264)
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


def h264(frames: Sequence[Path], to: Path, encoder: Path) -> Path:
    size = planar(frames, to.with_suffix(".yuv"))
    stream = to.with_suffix(".264")
    bits = round(_BITS_A_PIXEL * size[0] * size[1] * RATE)
    words = ["-org", str(to.with_suffix(".yuv")), "-sw", str(size[0]), "-sh", str(size[1])]
    words += ["-frin", str(RATE), "-frms", str(len(frames)), "-bf", str(stream), "-numl", "1"]
    words += ["-dw", "0", str(size[0]), "-dh", "0", str(size[1]), "-frout", "0", str(RATE)]
    words += ["-rc", "1", "-tarb", str(bits // 1000), "-ltarb", "0", str(bits // 1000)]
    words += ["-iper", "30", "-utype", "0", "-slcmd", "0", "0", "-fs", "0"]
    subprocess.run([str(encoder), *words], check=True, capture_output=True)
    return boxed(stream.read_bytes(), to, size, is_hevc=False)


def hevc(frames: Sequence[Path], to: Path, encoder: Path) -> Path:
    size = planar(frames, to.with_suffix(".yuv"))
    stream = to.with_suffix(".hevc")
    words = ["-i", str(to.with_suffix(".yuv")), "--input-res", f"{size[0]}x{size[1]}"]
    words += ["--input-fps", str(RATE), "--preset", "ultrafast", "--gop", "0", "-p", "30"]
    words += ["--bitrate", str(round(0.7 * _BITS_A_PIXEL * size[0] * size[1] * RATE))]
    words += ["--no-info", "-o", str(stream)]
    subprocess.run([str(encoder), *words], check=True, capture_output=True)
    return boxed(stream.read_bytes(), to, size, is_hevc=True)


def planar(frames: Sequence[Path], to: Path) -> tuple[int, int]:
    """The frames one after another, Y then U then V at half width and height; width, height."""
    size = (0, 0)
    with to.open("wb") as stream:
        for frame in frames:
            pixels = cv2.imread(str(frame))
            size = pixels.shape[1], pixels.shape[0]
            stream.write(cv2.cvtColor(pixels, cv2.COLOR_BGR2YUV_I420).tobytes())
    return size


def boxed(stream: bytes, to: Path, size: tuple[int, int], *, is_hevc: bool) -> Path:
    """A stream of one slice a frame, in the order in which it is shown, as MP4 (ISO 14496-12)."""
    marked = stream.replace(b"\0\0\0\1", b"\0\0\1")
    units = [unit for unit in marked.split(b"\0\0\1") if unit]
    heads: dict[int, bytes] = {}
    samples: list[bytes] = []
    keys: list[int] = []
    waiting = b""
    for unit in units:
        kind = unit[0] >> 1 & 63 if is_hevc else unit[0] & 31
        waiting += struct.pack(">I", len(unit)) + unit  # parameters may change with a key frame
        if kind in (7, 8, 32, 33, 34):
            heads.setdefault(kind, unit)
        if kind < 32 if is_hevc else kind in (1, 5):
            if 16 <= kind <= 21 if is_hevc else kind == 5:
                keys.append(len(samples))
            samples.append(waiting)
            waiting = b""
    if is_hevc:
        config = b"\1" + heads[33][3:15] + bytes.fromhex("f000fcfdf8f800000f") + bytes((3,))
        for kind in (32, 33, 34):
            config += struct.pack(">BHH", kind, 1, len(heads[kind])) + heads[kind]
        coded = box(b"hvcC", config)
    else:
        sequence, picture = heads[7], heads[8]
        config = b"\1" + sequence[1:4] + b"\xff\xe1" + struct.pack(">H", len(sequence)) + sequence
        coded = box(b"avcC", config + b"\1" + struct.pack(">H", len(picture)) + picture)
    entry = bytes(6) + struct.pack(">H", 1) + bytes(16) + struct.pack(">HH", *size)
    entry += struct.pack(">IIIH", 72 << 16, 72 << 16, 0, 1) + bytes(32) + struct.pack(">Hh", 24, -1)
    described = box(b"hvc1" if is_hevc else b"avc1", entry + coded)
    count, matrix = len(samples), struct.pack(">9i", 1 << 16, 0, 0, 0, 1 << 16, 0, 0, 0, 1 << 30)
    head = box(b"ftyp", b"isom" + bytes(4) + b"isommp41")

    def about(first_at: int) -> bytes:
        table = box(b"stsd", struct.pack(">II", 0, 1) + described)
        table += box(b"stts", struct.pack(">IIII", 0, 1, count, 1))
        table += box(b"stss", struct.pack(f">II{len(keys)}I", 0, len(keys), *(k + 1 for k in keys)))
        table += box(b"stsc", struct.pack(">IIIII", 0, 1, 1, count, 1))
        table += box(b"stsz", struct.pack(f">III{count}I", 0, 0, count, *map(len, samples)))
        table += box(b"stco", struct.pack(">III", 0, 1, first_at))
        where = box(b"dinf", box(b"dref", struct.pack(">II", 0, 1) + box(b"url ", b"\0\0\0\1")))
        media = box(b"vmhd", b"\0\0\0\1" + bytes(8)) + where + box(b"stbl", table)
        track = box(b"mdhd", struct.pack(">IIIIIHH", 0, 0, 0, RATE, count, 0x55C4, 0))
        track += box(b"hdlr", bytes(8) + b"vide" + bytes(13)) + box(b"minf", media)
        place = struct.pack(">IIIIII", 7, 0, 0, 1, 0, count) + bytes(16) + matrix
        place += struct.pack(">II", size[0] << 16, size[1] << 16)
        film = struct.pack(">IIIIIIH", 0, 0, 0, RATE, count, 1 << 16, 0x100) + bytes(10) + matrix
        film += bytes(24) + struct.pack(">I", 2)
        inside = box(b"mvhd", film) + box(b"trak", box(b"tkhd", place) + box(b"mdia", track))
        return box(b"moov", inside)

    first_at = len(head) + len(about(0)) + 8
    to.write_bytes(head + about(first_at) + box(b"mdat", b"".join(samples)))
    return to


def box(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I4s", 8 + len(content), kind) + content


if __name__ == "__main__":
    main()
