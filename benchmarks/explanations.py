"""What is said of captures that are sound, and of captures with one known fault.

    python benchmarks/explanations.py -o OUT.json --family sound --count 20 [--first 1]
    python benchmarks/explanations.py -o OUT.json --family real --photos LIMBGRAM_DATA/photos
    python benchmarks/explanations.py -o OUT.json --family faults --count 1 [--rows "limb steps"]
    python benchmarks/explanations.py -o OUT.json --family clinic --count 1
    python benchmarks/explanations.py -o OUT.json --join PART.json ...

Each capture is made small (0.35 MP) from its seed, goes through `limbgram check` and through
`reconstruct` up to the first dense stage, and is thrown away. A row says, for each of the two, what
blames limb, board, camera or a photo (`BLAMES`), which photos were set aside, what else was said,
how often the surroundings were refused, and the CPU seconds. What a capture truly has (the
stabiliser of a phone that has one) is no false accusation. Rows that OUT holds already are not done
again, and every row names the commit that it was measured on; with `--join` nothing is
photographed. With `--surface` the surface of a fault that `reconstruct` does not tell is made, and
the row says within how much of it 95 % lies, by the truth and as stated. More than stated is a lie.
The things photographed are three kinds of limb, a gauge cylinder, and feet, trunks and boxes
(`shapes`). Sound captures from seed 1001 on are sparsely painted ones at full size (3.8 MP); faults
from seed 2001 on are seen in 20 photos of 1.4 MP, from 3001 on of 3.8 MP. `real` are sets of
photographs of rigid things, whole and as people pass photos on: all that blames anything there is
false. To bound the cost they are 1400 px long, and what is done to sizes, EXIF and files is done to
every second photo. `clinic` has folders as they come: sizes, cuts and lenses mixed, bursts, films,
stools, which are sound, and two limbs in one folder, which are refused.
"""

import json
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, ParamSpec, TypeVar

import cv2
import numpy as np
from PIL import Image, ImageDraw
from scipy.spatial.transform import Rotation

from explanation_tables import DOORS, UNDECIDED, UNTOLD, in_short, outcome
from harness import asking, machine, write
from limbgram.cases.capture_check import check_sources
from limbgram.cases.case_assessment import read_truth
from limbgram.core.errors import LimbgramError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import PARAMETERS, Camera, View
from limbgram.core.run import Run
from limbgram.findings import Finding
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.dense.estimation import estimate_depth
from limbgram.reconstruction.movement import bending_found, lens_doubt, movement_found
from limbgram.reconstruction.photo_lenses import lenses_told
from limbgram.reconstruction.pipeline import Capture, reconstruct
from limbgram.reconstruction.targets.board import Board
from limbgram.report.accuracy.assessment import assess
from limbgram.report.accuracy.evidence import Evidence
from limbgram.synthetic import (
    PHONE,
    SCALE_BOARD,
    CaptureOptions,
    Fault,
    LimbKind,
    Movement,
    MovementKind,
    Paint,
    TurnedOver,
    Turning,
    distance_for,
    make_capture,
    with_faults,
)
from limbgram.synthetic.props.gauges import GaugeCylinder
from shapes import SHAPES, shape_of

P = ParamSpec("P")
T = TypeVar("T")

BLAMES: dict[str, tuple[str, ...]] = {
    "limb": (
        "movement.step", "movement.drift", "movement.restless", "movement.unclear",
        "movement.photo",
        "movement.shape.bent", "coach.moved", "coach.bent", "coach.turned_over",
        "coach.board_tipped",
        "placing.poses_apart", "placing.side",
    ),
    "board": (
        "board.moved", "board.photo", "board.off_plane", "board.bent", "board.back",
        "board.stretched", "board.probably_moved", "board.halves_disagree", "board.mirrored",
        "board.other_layout", "board.other_ratio", "board.stands_still", "scale.cause",
    ),
    "camera": ("lens.",),
    "photo": (
        "placing.photo.misses", "placing.photo.contradicted", "placing.photo.plain",
        "placing.photo.disagrees", "placing.photo.same_spot", "photo.blurred",
        "photo.mirrored", "photo.other_lens", "photo.refocused",
        "photo.most", "pairs.turned",
    ),
}  # fmt: skip
"""Codes, or how they begin, by what they blame."""
_SMALL = CaptureOptions(
    photos=12, width_px=720, height_px=480, calibration_photos=0, samples=2, mesh_step_mm=1.5
)
_PHONE = replace(_SMALL, width_px=680, height_px=510, distance_mm=500.0, lens=PHONE)
_FULL = replace(_SMALL, photos=15, width_px=2376, height_px=1584, mesh_step_mm=0.7)
_FULL_PHONE = replace(_FULL, width_px=2248, height_px=1686, distance_mm=500.0, lens=PHONE)
_FIRST_SPARSE = 1001
"""Seed of the first sound capture at full size; those of smaller seeds stay what they were."""
_SHARPER: dict[int, tuple[str, dict[str, Any]]] = {
    3001: ("3.8 MP", {"width_px": 2248, "height_px": 1686}),
    2001: ("1.4 MP", {"width_px": 1360, "height_px": 1020}),
}
"""Seed of the first captures with faults that are seen in 20 larger photos, and how large."""
_SPARSE_SHARES = (0.08, 0.11, 0.15)
"""Of the surface, that paint covers."""
_SIGMAS = {
    "fx": 0.2, "fy": 0.2, "cx": 0.5, "cy": 0.5, "k1": 1e-3, "k2": 3e-3, "p1": 1e-4, "p2": 1e-4,
}  # fmt: skip
"""Of a calibration: it is as far off the truth as these say."""
SUBJECTS = (*(one.value for one in LimbKind), "cylinder", *SHAPES)
_COUNTS = (8, 10, 12, 14, 16, 20, 30, 60)
_SHARES = (0.03, 0.07, 0.3, 0.25, 0.15, 0.12, 0.06, 0.02)
_FEWEST_OF_TWO_HEIGHTS = 20
_LONG_SIDE_PX = 1400
"""Of photographs, which come with 2000 and more. At 900 too few points of bare bone are found."""
_TRUE_OF = {Fault.STABILISER: "lens.own.principal_point", Fault.BREATHING: "lens.own.focal_length",
            Fault.ROLLING: "lens.own.rolling_shutter"}  # fmt: skip
_ZOOMED = ("lens.zoomed", "lens.photo.zoomed", "lens.own.focal_length")


@dataclass(frozen=True, kw_only=True)
class Case:
    """One capture, and what is true of it."""

    name: str
    family: Literal["sound", "real", "faults", "clinic"]
    row: str
    strength: str = ""
    made: CaptureOptions | None = None
    beside: CaptureOptions | None = None
    """Photos of another capture in the same room, in the same folder."""
    """None: photographs that lie in `photos`."""
    photos: tuple[Path, ...] = ()
    change: Callable[[Path], None] | None = None
    """What is done to the folder of photos."""
    lens: float | None = 1.0
    """Focal length of the camera file over the true one; None: no camera file."""
    board: Board | None = SCALE_BOARD.board
    """As it is stated."""
    true: tuple[str, ...] = ()
    """Codes, or how they begin, that are true of it: of a fault, those that tell it."""


class _EnoughSeen(Exception):
    """The first dense stage was reached."""


class _UntilDepth(Run):
    """Keeps what stages gave and stops before anything dense is done."""

    def __call__(self, stage: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        if stage is estimate_depth:
            raise _EnoughSeen
        product = super().__call__(stage, *args, **kwargs)
        self.products[stage.__name__] = product
        return product

    @property
    def products(self) -> dict[str, Any]:
        return self.__dict__.setdefault("kept", {})


def main() -> None:
    parser = asking(__doc__, keep="the captures")
    parser.add_argument("--family", choices=("sound", "real", "faults", "clinic"))
    parser.add_argument("--first", type=int, default=1, help="first seed")
    parser.add_argument("--count", type=int, default=1, help="seeds")
    parser.add_argument("--rows", nargs="*", help="these rows alone")
    parser.add_argument("--strengths", nargs="*", help="these strengths, or ways, alone")
    parser.add_argument("--photos", type=Path, help="folder of sets of photographs")
    parser.add_argument("--doors", nargs="*", choices=DOORS, default=list(DOORS))
    parser.add_argument("--surface", action="store_true", help="of faults that are not told")
    parser.add_argument("--minutes", type=float, default=1e9, help="stop after so long")
    parser.add_argument(
        "--join", type=Path, nargs="*", default=[], help="take in these results alone"
    )
    chosen = parser.parse_args()
    known = _read(chosen.out) if chosen.out.exists() else {}
    result: dict[str, Any] = {"captures": {}} | known
    for part in chosen.join:
        other = _read(part)
        captures = result["captures"] | other["captures"]
        result = result | other | {"captures": captures}
    if chosen.join:
        write(chosen.out, result)
    end = time.monotonic() + 60 * chosen.minutes
    cases = [] if chosen.join else _cases(chosen.family, chosen.first, chosen.count, chosen.photos)
    for case in cases:
        wanted = (not chosen.rows or case.row in chosen.rows) and (
            not chosen.strengths or case.strength in chosen.strengths
        )
        if case.name in result["captures"] or not wanted or time.monotonic() > end:
            continue
        result |= {"machine": machine()}
        found = tried(case, chosen.doors, chosen.keep, surface=chosen.surface)
        result["captures"][case.name] = found | {"commit": result["machine"]["commit"][:12]}
        sys.stderr.write(f"{case.name}: {in_short(found)}\n")
        write(chosen.out, result)
    write(chosen.out, result)


def _read(file: Path) -> dict[str, Any]:
    """Results; rows without a commit are of the file's own."""
    result: dict[str, Any] = json.loads(file.read_text())
    for one in result["captures"].values():
        one.setdefault("commit", result["machine"]["commit"][:12])
    return result


def _cases(family: str, first: int, count: int, photos: Path | None) -> Iterator[Case]:
    seeds = range(first, first + count)
    match family:
        case "sound":
            yield from (_sound(seed) for seed in seeds)
        case "clinic":
            yield from (case for seed in seeds for case in clinic_cases(seed))
        case "faults":
            yield from (case for seed in seeds for case in fault_cases(seed))
        case _:
            if photos is None:
                raise SystemExit("--photos is needed for photographs")
            yield from real_cases(photos)


def _sound(seed: int) -> Case:
    return sound_case(seed) if seed < _FIRST_SPARSE else sparse_case(seed)


def sound_case(seed: int) -> Case:
    """A capture without a fault of limb, board or photo: limb, camera and walk by its seed."""
    rng = np.random.default_rng((seed, 77))
    phone, calibrated = bool(rng.random() < 0.5), bool(rng.random() < 0.5)
    base = _PHONE if phone else _SMALL
    walk = str(rng.choice(["round", "half heights", "turntable"], p=[0.5, 0.3, 0.2]))
    photos = int(rng.choice(_COUNTS, p=_SHARES))
    subject = str(rng.choice(SUBJECTS))
    faults: list[Fault] = []
    if phone and rng.random() < 0.6:
        faults = [Fault.STABILISER, Fault.BREATHING, Fault.ROLLING, Fault.BLUR]
        faults += [Fault.PROCESSING, Fault.JPEG, Fault.LIGHT]
    elif not phone and rng.random() < 0.4:
        faults = [Fault.BREATHING, Fault.BLUR, Fault.LIGHT]
    gauge = GaugeCylinder() if subject == "cylinder" else None
    scan = shape_of(subject, rng) if subject in SHAPES else None
    options = replace(
        base,
        seed=seed,
        photos=max(photos, _FEWEST_OF_TWO_HEIGHTS) if walk == "half heights" else photos,
        kind=LimbKind.TRANSTIBIAL if gauge or scan else LimbKind(subject),
        gauge=gauge,
        scan=scan,
        distance_mm=base.distance_mm if scan is None else distance_for(scan, base.distance_mm),
        coverage=float(rng.choice([0.12, 0.3, 0.55])),
        rings=2 if walk == "half heights" else 1,
        turning=Turning() if walk == "turntable" else None,
    )
    camera = f"{'phone' if phone else 'DSLR'}{' with its faults' if faults else ''}"
    true = [_TRUE_OF[one] for one in faults if one in _TRUE_OF]
    return Case(
        name=f"sound {seed}",
        family="sound",
        row=f"{camera}, {'calibrated' if calibrated else 'no camera file'}",
        strength=f"{subject}, {walk}, {options.photos} photos",
        made=with_faults(options, faults),
        lens=1.0 if calibrated else None,
        true=(*true, *(("pairs.turned",) if walk == "turntable" else ())),
    )


def sparse_case(seed: int) -> Case:
    """A sound capture at full size that paint covers by 8 to 15 %: limb, foot, trunk in turn.

    The first three of each six are calibrated. Few points of paint lie far apart, and each is seen
    sharply: what small captures hide in their noise shows here.
    """
    number = seed - _FIRST_SPARSE
    rng = np.random.default_rng((seed, 79))
    subject = ("limb", "foot", "trunk")[number % 3]
    calibrated, phone = number % 6 < 3, bool(rng.random() < 0.5)
    base = _FULL_PHONE if phone else _FULL
    scan = None if subject == "limb" else shape_of("foot" if subject == "foot" else "trunk", rng)
    share = _SPARSE_SHARES[int(rng.integers(len(_SPARSE_SHARES)))]
    kind = list(LimbKind)[int(rng.integers(len(LimbKind)))]
    options = replace(
        base,
        seed=seed,
        kind=kind,
        scan=scan,
        distance_mm=base.distance_mm if scan is None else distance_for(scan, base.distance_mm),
        coverage=share,
    )
    shown = kind.value if scan is None else subject
    return Case(
        name=f"sound {seed}",
        family="sound",
        row=f"{'phone' if phone else 'DSLR'}, {'calibrated' if calibrated else 'no camera file'}",
        strength=f"{shown}, round, {options.photos} photos, {share:.0%} painted, 3.8 MP",
        made=options,
        lens=1.0 if calibrated else None,
    )


def real_cases(folder: Path) -> Iterator[Case]:
    """Photographs of rigid things, whole and as people pass them on."""
    for source in sorted(one for one in folder.iterdir() if (one / "images").is_dir()):
        photos = tuple(sorted((source / "images").iterdir()))
        true = ("pairs.turned",) if source.name == "flowerpot" else ()
        whole = Case(
            name=f"{source.name}, whole", family="real", row=source.name, photos=photos, lens=None,
            board=None, true=true,
        )  # fmt: skip
        half = len(photos) // 2
        second = replace(whole, photos=photos[::2])
        ways: dict[str, Case] = {
            "every second photo": replace(second, change=_resized(1.0)),
            "halved in size": replace(second, change=_resized(0.5)),
            "every other one halved in size": replace(second, change=_every_other_halved),
            "every other one cropped": replace(
                second, change=_every_other_cropped, true=(*true, "lens.cut_out")
            ),
            "EXIF dropped": replace(second, change=_without_exif),
            "by a messenger": replace(second, change=_by_messenger),
            "first half": replace(whole, photos=photos[:half], change=_resized(1.0)),
            "second half": replace(whole, photos=photos[half:], change=_resized(1.0)),
            "whole": replace(whole, change=_resized(1.0)),
        }
        for way, case in ways.items():
            yield replace(case, name=f"{source.name}, {way}", strength=way)


def fault_cases(seed: int) -> Iterator[Case]:
    """Every row of faults at three strengths: below, at and three times what matters."""
    sharper = next((one for first, one in _SHARPER.items() if seed >= first), None)
    for row, strengths in FAULTS.items():
        for strength, case in strengths.items():
            made, told = case.made, strength
            if made is not None:
                made = replace(made, seed=seed)
            if sharper is not None:
                size, of_photos = sharper
                told = f"{strength} at {size}"
                if made is not None:
                    made = replace(made, photos=20, mesh_step_mm=1.0, **of_photos)
            yield replace(
                case, name=f"{row}, {told}, seed {seed}", row=row, strength=told, made=made
            )


def clinic_cases(seed: int) -> Iterator[Case]:
    """Folders as clinics have them; of the same seed are the same room, board and walk."""
    base = replace(_PHONE, seed=seed, photos=14)
    tele = replace(PHONE, focal_mm=8.5, name="8.5 mm f/2.4")
    long = replace(base, lens=tele, distance_mm=850.0)
    printed = replace(base, kind=LimbKind.BULBOUS, paint=Paint.PRINT, photos=15)
    bare = {"lens": None}
    rows: dict[str, Case] = {
        "every other one smaller": _clinic(base, change=_every_other_smaller),
        "every other one cut": _clinic(base, "lens.cut_out", change=_every_other_cropped),
        "every other one cut, no camera file": _clinic(
            base, "lens.cut_out", change=_every_other_cropped, **bare
        ),
        "every other one cut, same shape": _clinic(base, "lens.cut_out", change=_every_other_cut),
        "every other one cut, same shape, no camera file": _clinic(
            base, "lens.cut_out", change=_every_other_cut, **bare
        ),
        "board half hidden": _clinic(base, change=_board_half_hidden),
        "wide and tele": _clinic(base, beside=long, change=_every_other_long, **bare),
        "wide and tele, no EXIF": _clinic(
            base,
            "lens.told_by_photos",
            beside=long,
            change=_every_other_long_without_exif,
            **bare,
        ),
        "no EXIF": _clinic(base, change=_without_exif, **bare),
        "by a messenger": _clinic(base, change=_by_messenger, **bare),
        "burst": _clinic(base, change=_burst),
        "frames of a film": _clinic(replace(base, filmed=True, photos=24), **bare),
        "patient on a stool": _clinic(
            replace(base, photos=16, turning=Turning(sway_mm=4.0)), "pairs.turned"
        ),
        "turntable in a still room": _clinic(
            replace(base, photos=16, turning=Turning(before=True)), "pairs.turned"
        ),
        "two casts beside one board": _clinic(base, "placing.two_limbs", beside=printed),
    }
    for row, case in rows.items():
        yield replace(case, name=f"{row}, seed {seed}", row=row)


def _clinic(made: CaptureOptions, *true: str, **more: Any) -> Case:
    return Case(name="", family="clinic", row="", made=made, true=true, **more)


def _moves(kind: MovementKind, *codes: str) -> dict[str, Case]:
    return {
        f"{mm:g} mm": _fault(replace(_PHONE, movement=Movement(kind=kind, shift_mm=mm)), *codes)
        for mm in (0.2, 0.25, 0.75, 8.0)
    }


def _fault(made: CaptureOptions, *true: str, **more: Any) -> Case:
    return Case(name="", family="faults", row="", made=made, true=true, **more)


def _camera_fault(fault: Fault, most: tuple[float, ...] = ()) -> dict[str, Case]:
    return {
        f"{times:g} x usual": _fault(with_faults(_PHONE, [fault], times), _TRUE_OF[fault])
        for times in (0.3, 1.0, 3.0, *most)
    }


def _zoomed(photos: slice, by: float) -> Callable[[Path], None]:
    """The middle of these photos, enlarged to their size."""

    def change(folder: Path) -> None:
        for file in _files(folder)[photos]:
            with Image.open(file) as photo:
                exif, (width, height) = photo.getexif(), photo.size
                left, top = (0.5 * side * (1 - 1 / by) for side in (width, height))
                box = left, top, width - left, height - top
                larger = photo.convert("RGB").resize(
                    (width, height), Image.Resampling.BICUBIC, box=box
                )
            larger.save(file, quality=95, exif=exif)

    return change


_SWAPPED = Board.charuco("5x7", 30.0, 22.0, "4X4_50")
AGAINST_BOARD = ("movement.unclear", "coach.moved", "board.moved", "board.photo")
"""The limb moved, by whichever course; the board's corners move against it, whichever of the two
moved: that is what these say."""
FAULTS: dict[str, dict[str, Case]] = {
    "limb steps": _moves(MovementKind.STEP, "movement.step", "movement.restless", *AGAINST_BOARD),
    "limb drifts": _moves(
        MovementKind.DRIFT, "movement.drift", "movement.restless", *AGAINST_BOARD
    ),
    "limb sways": _moves(MovementKind.SWAY, "movement.restless", *AGAINST_BOARD),
    "limb bends": _moves(MovementKind.BEND, "movement.shape.bent", "coach.bent"),
    "board pushed": _moves(MovementKind.PUSHED_BOARD, "board."),
    "stabiliser": _camera_fault(Fault.STABILISER, (5.0, 10.0)),  # 1.25 and 2.5 % of the width
    "refocusing": _camera_fault(Fault.BREATHING, (10.0,)),  # 0.4 %: three times is what matters
    "rolling shutter": _camera_fault(Fault.ROLLING),
    "one photo zoomed": {
        f"{by:.1%}": _fault(_PHONE, *_ZOOMED, change=_zoomed(slice(4, 5), 1 + by))
        for by in (0.003, 0.01, 0.05)
    },
    "half of the photos zoomed": {
        f"{by:.1%}": _fault(_PHONE, *_ZOOMED, change=_zoomed(slice(6, None), 1 + by))
        for by in (0.003, 0.01, 0.05)
    },
    "camera file off in focal length": {
        f"{by:.1%}": _fault(_PHONE, "lens.foreign", lens=1 + by) for by in (0.003, 0.01, 0.05)
    },
    "board bent": {
        f"{times:g} x usual": _fault(with_faults(_PHONE, [Fault.BENT], times), "board.")
        for times in (0.5, 1.0, 3.0)
    },
    "board stretched": {
        f"{times * 0.2:g} %": _fault(with_faults(_PHONE, [Fault.STRETCHED], times), "board.")
        for times in (0.5, 1.0, 3.0)
    },
    "board stands while the limb turns": {
        "whole turn": _fault(
            replace(_SMALL, photos=16, turning=Turning(board_turns=False)), "board.", "pairs.turned"
        )
    },
    "cast turned over": {
        "board stays": _fault(
            replace(_SMALL, photos=24, turning=TurnedOver()),
            "placing.",
            "coach.turned_over",
            "coach.board_tipped",
            "board.photo.tipped",
        )
    },
    "board given with columns and rows swapped": {
        "5 x 7 for 7 x 5": _fault(_PHONE, "board.", board=_SWAPPED)
    },
    "board of another ratio of marker and square": {
        f"markers of {mm:g} mm for 22": _fault(
            _PHONE, "board.", board=Board.charuco("7x5", 30.0, mm, "4X4_50")
        )
        for mm in (21.8, 21.0, 18.0)
    },
    "photos blurred by the hand": {
        "3 photos": _fault(replace(_PHONE, photos=14, shaken=(3, 8, 11)), "placing.", "photo.")
    },
}


def tried(
    case: Case, asked: Sequence[str] = DOORS, keep: Path | None = None, *, surface: bool = False
) -> dict[str, Any]:
    """The capture made, checked, and reconstructed up to its first dense stage.

    Args:
        surface: Whether the surface is made where `reconstruct` does not tell a fault.
    """
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        images, given = _given(case, folder)
        if case.change is not None:
            case.change(images)
        if keep is not None:
            shutil.copytree(images, keep / case.name.replace(", ", "_").replace(" ", "-"))
        doors = {
            "check": lambda: _checked(images, given, case.board),
            "reconstruct": lambda: _reconstructed(images, given, case.board),
        }
        found = {door: _timed(answer, case) for door, answer in doors.items() if door in asked}
        row: dict[str, Any] = {"family": case.family, "row": case.row, "strength": case.strength}
        row |= found
        if surface and "reconstruct" in found and outcome(row, "reconstruct") in UNTOLD:
            row["surface"] = _surface(images, given, case.board)
    return row


def _surface(
    images: Path, given: tuple[Calibration, ...], board: Board | None
) -> dict[str, float | None]:
    """Within how many mm 95 % of the surface lies from the truth, and is stated to lie."""
    made = reconstruct(Capture(sources=(images,), calibrations=given, board=board))
    held = Evidence(
        photos=made.photos,
        cameras=made.cameras,
        detections=made.detections,
        metric=made.metric,
        mesh=made.mesh,
    )
    figures = assess(held, read_truth(images.parent, held, "surface")).figures
    stated, true = figures.expected, figures.truth
    assert true is not None
    known = None if np.isnan(stated.p95_mm) else round(stated.p95_mm, 4)
    return {"true_p95_mm": round(true.p95_mm, 4), "stated_p95_mm": known}


@dataclass(frozen=True)
class _Said:
    """What one door says of a capture."""

    findings: tuple[Finding, ...]
    aside: tuple[str, ...]
    """Photos without a place, or left out."""
    refused: str = ""
    go: bool = False


def _given(case: Case, folder: Path) -> tuple[Path, tuple[Calibration, ...]]:
    """Photos and camera file of a case."""
    if case.made is None:
        images = folder / "images"
        images.mkdir()
        for photo in case.photos:
            shutil.copyfile(photo, images / photo.name)
        return images, ()
    make_capture(folder / "capture", case.made)
    if case.beside is not None:
        make_capture(folder / "beside", case.beside)
        for photo in _files(folder / "beside" / "images"):
            shutil.copyfile(photo, folder / "capture" / "images" / f"Z{photo.name}")
    given = () if case.lens is None else (_calibration(folder / "capture", case.lens),)
    return folder / "capture" / "images", given


def _calibration(source: Path, focal: float) -> Calibration:
    """The true lens as a calibration knows it, its focal length multiplied by `focal`."""
    camera = _camera_of(json.loads((source / "truth" / "cameras.json").read_text()))
    sigmas = np.array([_SIGMAS.get(name, 0.0) for name in PARAMETERS])
    off = np.random.default_rng(int(1000 * camera.fx)).normal(0.0, 1.0, len(sigmas)) * sigmas
    off[1] = off[0]  # pixels are square
    packed = camera.packed + off
    packed[:2] *= focal
    return Calibration(
        camera=camera.with_parameters(packed), covariance=np.diag(sigmas**2), source="board"
    )


def _camera_of(told: dict[str, Any]) -> Camera:
    """The lens in the truth of a capture."""
    lens = told["intrinsics"] | told["distortion"]
    size = {"width_px": lens.pop("width"), "height_px": lens.pop("height")}
    return Camera(**size, **lens)


def _checked(images: Path, given: Sequence[Calibration], board: Board | None) -> _Said:
    found = check_sources([images], given, board, Run())
    remarks = [one for photo in found.photos for one in photo.remarks]
    return _Said(
        (*found.findings, *found.notes, *remarks),
        (*(one.name for one in found.photos if not one.placed), *(k.name for k in found.set_aside)),
        go=found.go,
    )


def _reconstructed(images: Path, given: tuple[Calibration, ...], board: Board | None) -> _Said:
    run, refused = _UntilDepth(), list[Finding]()
    try:
        reconstruct(Capture(sources=(images,), calibrations=given, board=board), run=run)
    except _EnoughSeen:
        pass
    except LimbgramError as refusal:
        refused.append(refusal.finding)
    products = run.products
    photos, metric = products["read_photos"], products.get("to_millimetres")
    aside = [*photos.set_aside]
    said = [*refused]
    unplaced: list[str] = []
    if metric is not None:
        scene = metric.scene
        cameras = products.get("without_files", products["cameras_for"])
        aside += metric.scale.set_aside
        if scene.movement is not None:
            said.append(movement_found(scene.movement, scene.names, "mm"))
        if scene.bending is not None:
            lens = lens_doubt(scene, cameras)
            said.append(bending_found(scene.bending, scene.names, "mm", lens))
        said += lenses_told(scene, cameras, photos)
        for one in scene.verdicts:
            said += [finding for finding in (one.reason, one.remark) if finding is not None]
        unplaced = [one.name for one in scene.verdicts if not one.placed]
        said += products["find_still"].notes
        if "board_of_object" in products and products.get("find_poses") is not None:
            said += products["find_poses"].names(photos)
    return _Said(
        (*said, *(one.reason for one in aside)),
        (*unplaced, *(one.name for one in photos.set_aside)),
        refused=refused[0].code if refused else "",
        go=not refused,
    )


def _timed(answer: Callable[[], _Said], case: Case) -> dict[str, Any]:
    start = time.process_time()
    try:
        said = answer()
    except LimbgramError as refusal:
        said = _Said((refusal.finding,), (), refusal.finding.code)
    except Exception as fault:  # a capture that crashes is a result, and the others go on
        said = _Said((), (), f"crashed: {type(fault).__name__}: {fault}")
    codes = sorted({code for one in said.findings for code in _codes(one)})
    blaming = [code for code in codes if _blamed(code) and code not in UNDECIDED]
    return {
        "go": said.go,
        "told": [code for code in codes if code.startswith(case.true)] if case.true else [],
        "accused": [code for code in blaming if not case.true or not code.startswith(case.true)],
        "aside": list(said.aside),
        "refused": said.refused,
        "said": codes,
        "sentences": [str(one) for one in said.findings],
        "cpu_s": round(time.process_time() - start, 1),
    }


def _codes(finding: Finding) -> Iterator[str]:
    """Its own code and those of the findings that are its reasons."""
    yield finding.code
    for value in finding.values.values():
        for one in value if isinstance(value, tuple) else (value,):
            if isinstance(one, Finding):
                yield from _codes(one)


def _blamed(code: str) -> str:
    """What a code blames; nothing of most."""
    return next((what for what, starts in BLAMES.items() if code.startswith(starts)), "")


def _files(folder: Path) -> list[Path]:
    return sorted(folder.iterdir())


def _stored(
    file: Path,
    change: Callable[[Image.Image], Image.Image],
    *,
    quality: int = 92,
    keep_exif: bool = True,
) -> None:
    """A photo changed and stored again, smaller first where it is a large photograph."""
    with Image.open(file) as photo:
        exif = photo.getexif() if keep_exif else Image.Exif()
        picture = photo.convert("RGB")
    shrink = min(1.0, _LONG_SIDE_PX / max(picture.size))
    picture = _smaller(picture, shrink)
    change(picture).save(file, quality=quality, exif=exif)


def _smaller(picture: Image.Image, factor: float) -> Image.Image:
    if factor == 1.0:
        return picture
    width, height = (round(factor * side) for side in picture.size)
    return picture.resize((width, height), Image.Resampling.LANCZOS)


def _resized(factor: float) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        for file in _files(folder):
            _stored(file, lambda picture: _smaller(picture, factor))

    return change


def _every_other_halved(folder: Path) -> None:
    for number, file in enumerate(_files(folder)):
        _stored(file, lambda picture: _smaller(picture, 0.5 if number % 2 else 1.0))  # noqa: B023


def _every_other_cropped(folder: Path) -> None:
    """Off its middle, as people cut out what matters."""

    def cut(picture: Image.Image) -> Image.Image:
        width, height = picture.size
        return picture.crop((width // 10, height // 12, width - width // 20, height - height // 8))

    for number, file in enumerate(_files(folder)):
        _stored(file, cut if number % 2 else lambda picture: picture)


def _every_other_cut(folder: Path) -> None:
    """Off its middle, with the sides' ratio of the whole."""

    def cut(picture: Image.Image) -> Image.Image:
        width, height = picture.size
        left, top = width // 20, height // 8
        return picture.crop((left, top, left + 4 * width // 5, top + 4 * height // 5))

    for file in _files(folder)[1::2]:
        _stored(file, cut)


def _board_half_hidden(folder: Path) -> None:
    """A sheet lies over the half of the board that is farther from the limb in all photos."""
    truth = folder.parent / "truth"
    told = json.loads((truth / "cameras.json").read_text())
    board = json.loads((truth / "board.json").read_text())["scene_board"]
    camera = _camera_of(told)
    wide, high = (board["square_mm"] * board[f"squares_{side}"] for side in "xy")
    sheet = np.array([(0.45 * wide, -9, 0), (wide + 9, -9, 0), (wide + 9, high + 9, 0)])
    corners = np.concatenate([sheet, [(0.45 * wide, high + 9.0, 0.0)]])
    in_world = corners @ np.array(board["R"]).T + np.array(board["t"])
    for photo in told["images"]:
        view = View(photo["name"], camera, Rigid(np.array(photo["R"]), np.array(photo["t"])))
        file = folder / photo["name"]
        with Image.open(file) as picture:
            exif, before = picture.getexif(), picture.convert("RGB")
        after = before.copy()
        ImageDraw.Draw(after).polygon([(x, y) for x, y in view.project(in_world)], (150, 60, 40))
        with Image.open(truth / "masks" / f"{file.stem}.png") as limb:
            Image.composite(before, after, limb.convert("L")).save(file, quality=93, exif=exif)


def _every_other_smaller(folder: Path) -> None:
    for file in _files(folder)[1::2]:
        _stored(file, lambda picture: _smaller(picture, 0.7))


def _every_other_long(folder: Path) -> None:
    """Of two captures from the same places every third photo of the second, else the first's."""
    files = _files(folder)
    first, second = files[: len(files) // 2], files[len(files) // 2 :]
    for number, (one, other) in enumerate(zip(first, second, strict=True)):
        (one if number % 3 == 1 else other).unlink()


def _every_other_long_without_exif(folder: Path) -> None:
    _every_other_long(folder)
    _without_exif(folder)


def _burst(folder: Path) -> None:
    """Every third photo three times: the hand turned by 0.2 degrees, and the noise is another."""
    camera = _camera_of(json.loads((folder.parent / "truth" / "cameras.json").read_text()))
    for number, file in enumerate(_files(folder)[::3]):
        for again in (1, 2):
            with Image.open(file) as photo:
                exif, pixels = photo.getexif(), np.asarray(photo.convert("RGB"))
            rng = np.random.default_rng((number, again))
            turn = Rotation.from_rotvec(rng.normal(0.0, np.radians(0.2), 3)).as_matrix()
            moved = camera.matrix @ turn @ np.linalg.inv(camera.matrix)
            turned = cv2.warpPerspective(
                pixels, moved, pixels.shape[1::-1], flags=cv2.INTER_LANCZOS4,
                borderMode=cv2.BORDER_REFLECT,
            )  # fmt: skip
            noisy = turned + rng.normal(0.0, 2.0, pixels.shape)
            picture = Image.fromarray(np.clip(noisy, 0, 255).astype(np.uint8))
            picture.save(file.with_stem(f"{file.stem}_{again}"), quality=93, exif=exif)


def _without_exif(folder: Path) -> None:
    for file in _files(folder):
        _stored(file, lambda picture: picture, keep_exif=False)


def _by_messenger(folder: Path) -> None:
    for file in _files(folder):
        _stored(file, lambda picture: picture, keep_exif=False, quality=70)


if __name__ == "__main__":
    main()
