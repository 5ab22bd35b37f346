"""Collections: every reader over all meshes and pictures of folders, and what becomes of them.

    python benchmarks/corpus.py -o benchmarks/results/corpus.json \
        "trimesh models, a513c0e, MIT=/data/trimesh/models" "our shapes=/data/shapes"

writes corpus.json. A folder is given as NAME=FOLDER; the name says what it is, of which version,
and under which licence. Nothing of a collection is copied but its names. Collections that stand in
the file already and are not named again stay as they are.

A mesh is read by the reader of its ending and made sound; that it has the size of a limb is not
demanded. A picture is read as a photo is, its pixels too. Each file may be read, or refused by a
LimbgramError that says why; anything else is a fault of ours, and so is a file that takes more
than 60 s of the processor or 6 GB.
"""

import io
import multiprocessing
import os
import re
import resource
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
from PIL import Image

from harness import asking, found_before, machine, made_on, write
from limbgram.core.errors import LimbgramError, PhotoError
from limbgram.findings import told
from limbgram.formats.table import format_of
from limbgram.formats.triangle_soup import sound_mesh
from limbgram.reconstruction.photos.decoding import load_colour
from limbgram.reconstruction.photos.reading import PhotoOptions, read_photos

LIMIT_S, LIMIT_BYTES = 60, 6 << 30
_LARGEST = 200 << 20
_PICTURES = (
    ".jpg", ".jpeg", ".png", ".tif", ".tiff", ".heic", ".heif", ".dng", ".bmp", ".gif", ".webp",
)  # fmt: skip
_OVERTIME = 99
_SET_ASIDE = "Set aside:\n  FILE: "
"""What stands behind it is the reason for one picture, and not for the folder."""


@dataclass(frozen=True)
class Tried:
    """What became of a file."""

    name: str
    kind: str
    outcome: str
    """read, refused, crashed or hung."""
    said: str = ""
    """Notes, the reason, or the fault."""
    seconds: float = 0.0


def mesh_of(path: Path) -> str:
    """Read a mesh; returns what was odd about it."""
    kind = format_of(path)
    assert kind is not None
    assert kind.read is not None
    soup = kind.read(path.read_bytes(), path.name)
    return "; ".join(map(told, (*soup.notes, *sound_mesh(soup.mesh, path.name).notes)))


def picture_of(path: Path) -> str:
    """Read a picture as a photo, with its pixels, beside one that is surely a photo."""
    with tempfile.TemporaryDirectory() as place:
        other = Path(place, "other.png")
        pixels = np.random.default_rng(1).integers(0, 256, (96, 128, 3), np.uint8)
        Image.fromarray(pixels).save(other)
        found = read_photos([path, other], PhotoOptions(min_photos=1))
        if found.set_aside:
            raise PhotoError.of(found.set_aside[0].reason)
        for photo in found.photos:
            load_colour(photo)
    return ""


def tried(path: Path, name: str) -> Tried:
    """What becomes of one file."""
    kind = format_of(path)
    is_mesh = kind is not None and kind.read is not None
    read = mesh_of if is_mesh else picture_of
    ending = path.suffix.lower()
    began = time.process_time()
    signal.setitimer(signal.ITIMER_PROF, LIMIT_S)
    try:
        outcome, said = "read", read(path)
    except LimbgramError as refusal:
        outcome, said = "refused", str(refusal)
    except Exception as fault:  # any kind is what is looked for
        at = fault.__traceback__
        while at is not None and at.tb_next is not None:
            at = at.tb_next
        where = "" if at is None else Path(at.tb_frame.f_code.co_filename).name
        outcome, said = "crashed", f"{type(fault).__name__} in {where}: {fault}"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    said = said.replace(str(path), "FILE").replace(path.name, "FILE")[:300]
    return Tried(name, ending, outcome, said, round(time.process_time() - began, 2))


def _start() -> None:
    warnings.simplefilter("ignore")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    resource.setrlimit(resource.RLIMIT_AS, (LIMIT_BYTES, LIMIT_BYTES))
    signal.signal(signal.SIGPROF, _too_long)


def _too_long(_signal: int, _frame: FrameType | None) -> None:
    os._exit(_OVERTIME)


def files_of(folder: Path) -> list[Path]:
    """Meshes and pictures of a folder and all below it."""
    found: list[Path] = []
    for path in sorted(folder.rglob("*")):
        kind = format_of(path)
        known = (kind is not None and kind.read is not None) or path.suffix.lower() in _PICTURES
        if known and path.is_file() and path.stat().st_size <= _LARGEST:
            found.append(path)
    return found


def all_of(folder: Path) -> list[Tried]:
    """Every file of a collection, one process at a time, a new one where one died."""
    results: list[Tried] = []
    pool: ProcessPoolExecutor | None = None
    for path in files_of(folder):
        name = path.relative_to(folder).as_posix()
        if pool is None:
            spawn = multiprocessing.get_context("spawn")
            pool = ProcessPoolExecutor(1, spawn, initializer=_start)
        try:
            results.append(pool.submit(tried, path, name).result())
        except BrokenProcessPool:
            results.append(Tried(name, path.suffix.lower(), "hung", "the process ended"))
            pool = None
    if pool is not None:
        pool.shutdown()
    return results


def page(found: dict[str, Any]) -> str:
    """The outcomes as tables."""
    out = io.StringIO()
    out.write("# Public collections\n\nMade by `python benchmarks/corpus.py`.\n\n")
    for computer in dict.fromkeys(map(made_on, found["machines"].values())):
        tried_there = [one for one, on in found["machines"].items() if made_on(on) == computer]
        out.write(f"- {computer}: {'; '.join(tried_there)}\n")
    out.write("\n")
    out.write("| collection | ending | files | read | with a note | refused | crashed | hung ")
    out.write("| longest s |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n")
    reasons: Counter[str] = Counter()
    faults: list[str] = []
    for collection, files in found["collections"].items():
        for ending in sorted({one["kind"] for one in files}):
            rows = [one for one in files if one["kind"] == ending]
            count = Counter(one["outcome"] for one in rows)
            noted = sum(one["outcome"] == "read" and bool(one["said"]) for one in rows)
            longest = max(one["seconds"] for one in rows)
            out.write(
                f"| {collection} | {ending} | {len(rows)} | {count['read']} | {noted} | "
                f"{count['refused']} | {count['crashed']} | {count['hung']} | {longest:.1f} |\n"
            )
        for one in files:
            if one["outcome"] == "refused":
                said = one["said"].partition(_SET_ASIDE)[2] or one["said"].partition(". ")[0]
                reason = re.sub(r"[\d,.]*\d", "N", said)
                reasons[f"{one['kind']}: {reason}"] += 1
            elif one["outcome"] != "read":
                faults.append(f"{collection}, {one['name']}: {one['outcome']}, {one['said']}")
    out.write("\n## Why files were refused\n\n| files | reason |\n| --- | --- |\n")
    for reason, times in reasons.most_common():
        out.write(f"| {times} | {reason.replace('|', ' ')} |\n")
    out.write("\n## Faults\n\n")
    out.write("\n".join(f"- {fault}" for fault in faults) if faults else "None.")
    out.write("\n")
    return out.getvalue()


def main() -> int:
    parser = asking((__doc__ or "").splitlines()[0])
    parser.add_argument("collections", nargs="+", help="NAME=FOLDER")
    asked = parser.parse_args()
    found = found_before(asked.out, {"machines": {}, "collections": {}})
    done: list[Tried] = []
    for typed in asked.collections:
        name, _, folder = typed.partition("=")
        tried_now = all_of(Path(folder))
        found["machines"][name] = machine()
        found["collections"][name] = [asdict(one) for one in tried_now]
        done += tried_now
    write(asked.out, found)
    return int(any(one.outcome in ("crashed", "hung") for one in done))


if __name__ == "__main__":
    sys.exit(main())
