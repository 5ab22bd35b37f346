"""Captures that cannot give a right answer: what limbgram says of each, and how wrong it is.

    python benchmarks/spoiled.py SET -o benchmarks/results/spoiled.json

SET is a capture with board photos and a truth (rendered, or of `limbgram make-capture`). Photos
are taken away, damaged or mirrored, the board's size or the camera file is stated wrongly; each
goes through the command line. A green verdict with exit code 0 on any of them is a defect.
"""

import json
import math
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageEnhance, ImageFilter, ImageOps

from captures import LIMBGRAM, accuracy, read_poses, timed
from harness import asking, machine, working_in, write
from limbgram.core.geometry.frames import fit_similarity

Photos = Sequence[Path]
_LAID, _OTHER_SIZE = 0.5, 0.005
"""Below this share within 0.25 mm, and beyond this error of the distances between camera places,
a surface was not laid onto the truth, because it is of another size."""
_JPEG_QUALITY = 95
"""Of photos that were damaged and stored as JPEG once more."""


def all_of(photos: Photos) -> Photos:
    return photos


def half_ring(photos: Photos) -> Photos:
    return photos[: (len(photos) + 1) // 2]


def three(photos: Photos) -> Photos:
    return photos[:3]


def every_second(photos: Photos) -> Photos:
    return photos[::2]


def blurred(photo: Image.Image) -> Image.Image:
    return photo.filter(ImageFilter.GaussianBlur(6.0))


def overexposed(photo: Image.Image) -> Image.Image:
    return ImageEnhance.Brightness(photo).enhance(4.0)


def zoomed(by: float) -> Callable[[Image.Image], Image.Image]:
    """A digital zoom: the middle of the picture, enlarged to its size."""

    def enlarge(photo: Image.Image) -> Image.Image:
        width, height = photo.size
        box = tuple(0.5 * side * (1 + way / by) for way in (-1, 1) for side in (width, height))
        return photo.resize((width, height), Image.Resampling.BICUBIC, box=box)

    return enlarge


def longer(camera: dict[str, Any]) -> dict[str, Any]:
    """A focal length 3 % too long."""
    lens = camera["parameters"]
    return camera | {"parameters": lens | {"fx": 1.03 * lens["fx"], "fy": 1.03 * lens["fy"]}}


def foreign(camera: dict[str, Any]) -> dict[str, Any]:
    """A phone's: other pixels, another lens."""
    lens = {"fx": 3100.0, "fy": 3100.0, "cx": 1999.5, "cy": 1499.5}
    stated = {"width_px": 4000, "height_px": 3000, "label": "a phone", "focal_mm": 4.3}
    return camera | stated | {"parameters": camera["parameters"] | lens}


@dataclass(frozen=True)
class Spoiled:
    """One way of spoiling a good capture."""

    title: str
    photos: Callable[[Photos], Photos] = all_of
    image: Callable[[Image.Image], Image.Image] | None = None
    images: slice = field(default_factory=lambda: slice(None))
    """Photos that the change is made to."""
    camera: Callable[[dict[str, Any]], dict[str, Any]] | None = None
    words: Sequence[str] = field(default=())


CAPTURES = (
    Spoiled("half of the ring", half_ring),
    Spoiled("three neighbouring photos", three),
    Spoiled("every second photo of the ring", every_second),
    Spoiled("board stated 10 % too large", words=("--board", "charuco:7x5:33:24.2:4X4_50")),
    Spoiled("focal length 3 % too long", camera=longer),
    Spoiled("every photo blurred", image=blurred),
    Spoiled("every photo overexposed", image=overexposed),
    Spoiled("every photo mirrored", image=ImageOps.mirror),
    Spoiled("camera file of another camera", camera=foreign),
    Spoiled("the second half of the photos zoomed by 5 %", image=zoomed(1.05), images=slice(8, 15)),
    Spoiled("every other photo zoomed by 20 %", image=zoomed(1.2), images=slice(1, None, 2)),
)


def main() -> None:
    parser = asking(__doc__, keep="the case folders")
    parser.add_argument("source", type=Path)
    chosen = parser.parse_args()
    with working_in(chosen.keep) as folder:
        camera = folder / "camera.json"
        board = ["--board", "14x10", "--square", "10", "-o", str(camera)]
        timed([LIMBGRAM, "calibrate", str(chosen.source / "calibration"), *board])
        captures: list[dict[str, Any]] = []
        for number, one in enumerate(CAPTURES):
            captures.append(tried(one, chosen.source, camera, folder / f"{number}"))
            sys.stderr.write(f"{one.title}: exit {captures[-1]['exit_code']}\n")
            result = {"machine": machine(), "of": chosen.source.name, "captures": captures}
            write(chosen.out, result)


def tried(one: Spoiled, source: Path, camera: Path, folder: Path) -> dict[str, Any]:
    """Spoil the capture, run it, and hold what comes out against the truth."""
    photos = one.photos(sorted(p for p in (source / "images").iterdir() if p.is_file()))
    images = folder / "images"
    images.mkdir(parents=True)
    changed = {*photos[one.images]}
    for photo in photos:
        _store(photo, images / photo.name, one.image if photo in changed else None)
    stated = folder / "camera.json"
    tree = json.loads(camera.read_text())
    stated.write_text(json.dumps(tree if one.camera is None else one.camera(tree)))
    case = folder / "case"
    command = [LIMBGRAM, "reconstruct", str(images), "--camera", str(stated), "-o", str(case)]
    run = subprocess.run([*command, *one.words], capture_output=True, text=True, check=False)
    summary = case / "summary.json"
    finished = summary.exists()
    return {
        "title": one.title,
        "photos": len(photos),
        "exit_code": run.returncode,
        "terminal": [line.replace(str(case), "case") for line in run.stdout.splitlines() if line],
        "refusal": "" if finished else _refusal(run.stderr),
        "says": _first_line(run.stdout) if finished else _refusal(run.stderr),
        "page": _banner(case / "report.html") if finished else None,
        "truth": _truth(case, source) if finished else "no surface is made",
    }


def _store(photo: Path, kept: Path, change: Callable[[Image.Image], Image.Image] | None) -> None:
    if change is None:
        shutil.copyfile(photo, kept)
        return
    with Image.open(photo) as opened:
        exif = opened.getexif()
        change(opened.convert("RGB")).save(kept, quality=_JPEG_QUALITY, exif=exif)


def _first_line(printed: str) -> str:
    return next((line for line in printed.splitlines() if line.strip()), "")


def _refusal(printed: str) -> str:
    """The message at the end of what was printed, without the bars of progress before it."""
    return printed.strip().splitlines()[-1] if printed.strip() else ""


def _banner(page: Path) -> str | None:
    """The class of the page's banner: its colour."""
    found = re.search(r'class="(verdict[^"]*)"', page.read_text("utf-8"))
    return None if found is None else found[1]


def _truth(case: Path, source: Path) -> str:
    """Against the truth, after a rigid fit; a surface of another size fits nowhere."""
    truth = accuracy(case, source)["truth"]
    covered = truth["covered"]["0.25 mm"]
    (poses,) = (case / "deliverables").glob("poses*.json")
    ours, known = read_poses(poses), read_poses(source / "truth" / "cameras.json")
    names = sorted(ours.keys() & known.keys())
    centres = [np.array([views[name].centre for name in names]) for views in (ours, known)]
    larger = 1 / fit_similarity(*centres).scale - 1
    if covered < _LAID and abs(larger) > _OTHER_SIZE:
        return f"everything is {abs(larger):.1%} too {'large' if larger > 0 else 'small'}"
    girth = max((one["error_mm"] for one in truth["girths"]), key=abs, default=math.nan)
    return (
        f"{covered:.0%} of the visible limb lies within 0.25 mm; scale "
        f"{100 * truth['scale_error']:+z.2f} %, volume {100 * truth['volume_error']:+z.0f} %, "
        f"worst girth {girth:+z.1f} mm"
    )


if __name__ == "__main__":
    main()
