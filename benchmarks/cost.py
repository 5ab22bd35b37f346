"""What a whole run costs: photos to STL, beside pycolmap's own sparse step on the same photos.

    python benchmarks/cost.py DATA -o benchmarks/results/cost.json
    python benchmarks/cost.py DATA --sets limb_ring15 p60x1 --repeats 3 -o /tmp/cost.json

In      DATA with rendered/limb_ring15 and photos/flowerpot; all other captures are made by the
        project's own generator or by resizing, once if `--captures` names a folder that stays.
Out     OUT.json with every run; beside it OUT.png, drawn of it alone (cost_tables.py).
Method  Machines differ, so cost is a ratio: CPU seconds of `limbgram reconstruct` over those of
        pycolmap extracting, matching and mapping with all its defaults and no lens given
        (rivals.py). The two take turns, and the least of each is kept, because a busy machine only
        adds seconds. Calibration is not part of a run: a camera is calibrated once.
"""

import json
import os
import shutil
import sys
import tempfile
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from PIL import Image

import limbgram
from captures import HERE, JUDGED, LIMBGRAM, accuracy, count_photos, timed
from cost_tables import plot
from harness import asking, machine, write
from sweep import Setting, paper, phone

Result = dict[str, Any]
SEED, PHONE_SEED = 11, 7
PHONE_MEGAPIXELS = 4032 * 3024 / 1e6
WARM_UP = "warm-up"
_STL_HEAD, _STL_FACE = 84, 50
"""Bytes of a binary STL before its triangles, and of one triangle."""


@dataclass(frozen=True)
class Given:
    """A capture that is there, by its folder in DATA."""

    folder: str


@dataclass(frozen=True)
class Resized:
    """Some photos of another capture, evenly spread, `factor` times as wide."""

    of: str
    photos: int
    factor: float


@dataclass(frozen=True, kw_only=True)
class Measured:
    """A capture whose cost is measured."""

    what: str
    """In words, for the tables."""
    source: Given | Setting | Resized
    rival: bool = False
    """Whether pycolmap takes turns with us."""


SETS: Mapping[str, Measured] = {
    "limb_ring15": Measured(
        what="limb, rendered, 15 x 3.8 MP", source=Given("rendered/limb_ring15"), rival=True
    ),
    "paper": Measured(
        what="the published paper's set-up, 15 x 15 MP, 2 m", source=paper(SEED), rival=True
    ),
    "p60x1": Measured(what="limb, 60 x 1 MP", source=Setting(60, 1.0, SEED), rival=True),
    "p30x1": Measured(what="limb, 30 x 1 MP", source=Setting(30, 1.0, SEED), rival=True),
    "p15x1": Measured(what="limb, 15 x 1 MP", source=Setting(15, 1.0, SEED), rival=True),
    "pot31x13": Measured(
        what="pot that fills the frame, 31 x 13 MP (phone photos enlarged twice)",
        source=Resized("flowerpot", 31, 2.0),
    ),
    "phone60x12": Measured(
        what="limb by a phone, 60 x 12 MP", source=phone(60, PHONE_MEGAPIXELS, PHONE_SEED)
    ),
    "phone30x48": Measured(
        what="limb by a phone, 30 x 48 MP (enlarged twice)",
        source=Resized("phone60x12", 30, 2.0),
    ),
    "phone30x12": Measured(
        what="limb by a phone, 30 x 12 MP", source=Resized("phone60x12", 30, 1.0)
    ),
    "phone30x3": Measured(
        what="limb by a phone, 30 x 3 MP (reduced)", source=Resized("phone60x12", 30, 0.5)
    ),
    "phone30x1": Measured(
        what="limb by a phone, 30 x 0.8 MP (reduced)", source=Resized("phone60x12", 30, 0.25)
    ),
}
_SOURCES: Mapping[str, Given | Setting | Resized] = {
    "flowerpot": Given("photos/flowerpot"),
    **{name: one.source for name, one in SETS.items()},
}


def main() -> None:
    parser = asking(__doc__)
    parser.add_argument("data", type=Path, help="folder of rendered/SET and photos/SET")
    parser.add_argument("--sets", nargs="*", choices=[*SETS, WARM_UP], default=[*SETS, WARM_UP])
    parser.add_argument(
        "--repeats", type=int, default=2, help="runs of a set with pycolmap; the others run once"
    )
    parser.add_argument("--captures", type=Path, help="keep captures here, or find them here")
    parser.add_argument("--before", type=Path, help="an earlier OUT.json to set beside this one")
    parser.add_argument("--only-captures", action="store_true", help="make them and stop")
    chosen = parser.parse_args()
    results: Result = {"machine": machine(), "sets": {}}
    if chosen.before is not None:
        earlier = json.loads(chosen.before.read_text("utf-8"))
        results["before"] = {"machine": earlier["machine"], "sets": earlier["sets"]}
    chosen.out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        made = Captures(chosen.data, chosen.captures or Path(scratch) / "captures")
        sources = {name: made.folder(name) for name in chosen.sets if name != WARM_UP}
        if chosen.only_captures:
            return
        timed([LIMBGRAM, WARM_UP])  # what is compiled once belongs to no run
        for name in chosen.sets:
            sys.stderr.write(f"{name}\n")
            if name == WARM_UP:
                results["warm_up"] = fresh_warm_up(Path(scratch))
            else:
                repeats = chosen.repeats if SETS[name].rival else 1
                one = costs(sources[name], SETS[name].rival, repeats, Path(scratch) / name)
                results["sets"][name] = {"what": SETS[name].what} | one
            write(chosen.out, results)
            plot(results, chosen.out.with_suffix(".png"))


@dataclass(frozen=True)
class Captures:
    """Captures by name, each made when it is first asked for."""

    data: Path
    kept: Path

    def folder(self, name: str) -> Path:
        """The folder with its images, its camera file where it has one, and its truth."""
        match _SOURCES[name]:
            case Given(folder):
                given = self.data / folder
                kept = self.kept / name
                if not kept.exists():
                    kept.mkdir(parents=True)
                    for part in sorted(given.iterdir()):
                        (kept / part.name).symlink_to(part.resolve())
            case Setting() as setting:
                kept = self.kept / name
                kept.parent.mkdir(parents=True, exist_ok=True)
                if not kept.exists():
                    timed([sys.executable, str(HERE / "sweep.py"), str(kept), *setting.arguments])
            case Resized(of, photos, factor):
                kept = self.kept / name
                if not kept.exists():
                    resized(self.folder(of), kept, photos, factor)
        camera = kept / "camera.json"
        if not camera.exists() and (kept / "calibration").is_dir():
            board = ["--board", "14x10", "--square", "10", "-o", str(camera)]
            timed([LIMBGRAM, "calibrate", str(kept / "calibration"), *board])
        return kept


def resized(source: Path, target: Path, photos: int, factor: float) -> None:
    """Some photos of a capture in another size, as the camera would name them; whole or not."""
    beside = target.with_name(f".{target.name}.part")
    shutil.rmtree(beside, ignore_errors=True)
    (beside / "images").mkdir(parents=True)
    there = sorted(file for file in (source / "images").iterdir() if file.is_file())
    chosen = [there[k * len(there) // photos] for k in range(photos)]
    targets = [beside / "images" / photo.name for photo in chosen]
    if (source / "calibration").is_dir():
        boards = list((source / "calibration").iterdir())
        (beside / "calibration").mkdir()
        targets += [beside / "calibration" / photo.name for photo in boards]
        chosen += boards
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(partial(_resize, factor), chosen, targets))
    if (source / "truth").is_dir():
        (beside / "truth").symlink_to((source / "truth").resolve())
    picks = HERE / f"{source.name}_picks.json"
    if picks.exists():
        _resize_picks(picks, beside / "picks.json", {photo.name for photo in chosen}, factor)
    beside.rename(target)


def _resize(factor: float, photo: Path, target: Path) -> None:
    """Lanczos where it grows; the mean of what a pixel covers where it shrinks; else a copy."""
    if factor == 1:
        shutil.copyfile(photo, target)
        return
    with Image.open(photo) as picture:
        size = round(picture.width * factor), round(picture.height * factor)
        how = Image.Resampling.LANCZOS if factor > 1 else Image.Resampling.BOX
        told = {"exif": picture.info["exif"]} if "exif" in picture.info else {}
        picture.resize(size, how).save(target, quality=94, **told)


def _resize_picks(picks: Path, out: Path, photos: set[str], factor: float) -> None:
    """Known distances in the photos that are left; pixel centres are kept."""
    tree = json.loads(picks.read_text("utf-8"))
    for distance in tree["distances"]:
        for end in ("first", "second"):
            distance[end] = [
                pick | {axis: (pick[axis] + 0.5) * factor - 0.5 for axis in ("x_px", "y_px")}
                for pick in distance[end]
                if pick["photo"] in photos
            ]
    write(out, tree)


def costs(source: Path, rival: bool, repeats: int, scratch: Path) -> Result:
    """Runs of one capture, ours and pycolmap's in turns; the last of ours against the truth."""
    with Image.open(next(file for file in (source / "images").iterdir())) as photo:
        megapixels = photo.width * photo.height / 1e6
    found: Result = {
        "photos": count_photos(source),
        "megapixels": round(megapixels, 2),
        "load": round(os.getloadavg()[0], 2),
    }
    ours: list[Result] = []
    theirs: list[Result] = []
    for k in range(repeats):
        last = k == repeats - 1
        with tempfile.TemporaryDirectory(dir=scratch.parent) as folder:
            ours.append(whole_run(source, Path(folder) / "case", with_truth=last))
        if rival:
            with tempfile.TemporaryDirectory(dir=scratch.parent) as folder:
                theirs.append(sparse_run(source, Path(folder) / "sparse"))
    return found | {"limbgram": ours, "pycolmap": theirs}


def whole_run(source: Path, case: Path, *, with_truth: bool) -> Result:
    """Photos to STL, and what every stage took of it."""
    command = ["reconstruct", str(source / "images"), "-o", str(case), "--json"]
    if (source / "camera.json").exists():
        command += ["--camera", str(source / "camera.json")]
    elif (source / "picks.json").exists():
        command += ["--known-distance", str(source / "picks.json"), "--no-board"]
    else:
        command += ["--no-board", "--unscaled"]
    run = timed([LIMBGRAM, *command])
    if run["exit_code"] not in JUDGED:
        return run
    said = json.loads((case / "summary.json").read_text("utf-8"))
    surfaces = (case / "deliverables").glob("surface*.stl")
    run |= {
        "triangles": sum((file.stat().st_size - _STL_HEAD) // _STL_FACE for file in surfaces),
        "verdict": said["verdict"]["light"],
        "resolution": said["resolution"],
        "placed": sum(photo["placed"] for photo in said["photos"]),
        "stages": [
            {
                "stage": stage["stage"],
                "cpu_s": round(stage["cpu_s"], 2),
                "wall_s": round(stage["wall_s"], 2),
                "peak_mb": None if stage["peak_mb"] is None else round(stage["peak_mb"]),
            }
            for stage in said["stages"]
        ],
    }
    if with_truth and (source / "truth").is_dir():
        run["truth"] = accuracy(case, source)["truth"]
    return run


def sparse_run(source: Path, out: Path) -> Result:
    """pycolmap's sparse step with its defaults, in a process of its own."""
    images = str(source / "images")
    run = timed([sys.executable, str(HERE / "rivals.py"), "sparse", images, str(out)])
    told = out / "sparse.json"
    return run | (json.loads(told.read_text("utf-8")) if told.exists() else {})


def fresh_warm_up(scratch: Path) -> Result:
    """`limbgram warm-up` of a copy of the program that has never run."""
    copy = scratch / "fresh" / "limbgram"
    compiled = shutil.ignore_patterns("__pycache__")
    shutil.copytree(Path(limbgram.__file__).parent, copy, ignore=compiled)
    kept = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    told = {"PYTHONPATH": str(copy.parent), "XDG_CACHE_HOME": str(scratch / "cache")}
    return timed([LIMBGRAM, WARM_UP], kept | told)


if __name__ == "__main__":
    main()
