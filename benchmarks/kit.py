"""The capture kit: sheets measured back, corners of coded marks, the printed sock.

    python benchmarks/kit.py --keep FOLDER -o benchmarks/results/kit.json
    python benchmarks/kit.py --only corners -o benchmarks/results/kit.json

Sheets are rasterised by pdfium and every mark and ruler is measured; marks are rendered flat and on
a cylinder of 50 mm and measured by our edge fit and by OpenCV's own refinement; the generator
photographs one limb in dabs of paint, in the printed pattern and in a plain sock, and whole runs
are compared with the truth; stickers on a limb go all the way to named landmarks. `--only` replaces
one part of an earlier result. The pictures of docs/clinic/kit.md are made of
the same sheets and photos.
"""

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pypdfium2
from PIL import Image

from captures import LIMBGRAM, one_set, read_poses
from harness import asking, found_before, machine, made_on, write
from limbgram.cases.scoring import LEAST_PHOTOS, read_truth_mesh
from limbgram.core.errors import LimbgramError
from limbgram.core.geometry.frames import Rigid, fit_similarity
from limbgram.core.geometry.lens import Camera
from limbgram.core.geometry.triangulation import triangulate
from limbgram.formats.reading import read_limb
from limbgram.formats.sheets.kinds import KINDS, SheetOptions
from limbgram.formats.sheets.page import PageName, Sheet
from limbgram.reconstruction.features.detection import detect
from limbgram.reconstruction.matching.matching import match
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.targets.marks import marks_in
from limbgram.report.alignment import Truth as Surface
from limbgram.report.alignment import align_by_surface, measured_samples
from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.mark_photo import MarkShot, photograph_mark
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.props.paint import Paint
from limbgram.synthetic.props.stickers import SockSticker
from limbgram.synthetic.truth import Truth, stage_truth

Result = dict[str, Any]
DPI = 300
PARTS = ("sheets", "corners", "sock", "stickers", "pictures")
GUIDE = Path(__file__).resolve().parents[1] / "docs" / "clinic"
CAMERA = Camera(
    width_px=1500,
    height_px=1000,
    fx=3500.0,
    fy=3500.0,
    cx=752.0,
    cy=497.0,
    k1=-0.085,
    k2=0.06,
    p1=0.0004,
    p2=-0.0003,
)
SHOTS = {
    "flat, square on": {"tilt_deg": 3.0},
    "flat, to 50 deg": {},
    "flat, to 50 deg, blur 1 px": {"blur_px": 1.0},
    "flat, to 50 deg, blur 2 px": {"blur_px": 2.0},
    "flat, to 50 deg, noise x 4": {"noise": 4.0},
    "flat, to 50 deg, mark of 8 mm": {"side_mm": 8.0},
    "cylinder 50 mm": {"radius_mm": 50.0},
    "cylinder 50 mm, blur 1 px": {"radius_mm": 50.0, "blur_px": 1.0},
    "cylinder 50 mm, blur 2 px": {"radius_mm": 50.0, "blur_px": 2.0},
    "cylinder 50 mm, noise x 4": {"radius_mm": 50.0, "noise": 4.0},
}
SOCKS = {"dabs": Paint.DABS, "print": Paint.PRINT, "plain": Paint.NONE}
SEED = 57
STUCK = tuple(
    SockSticker(mark_id=40 + k, around=around, height=height, twist_deg=25.0 * k)
    for k, (around, height) in enumerate(
        [(0.1, 0.35), (0.35, 0.5), (0.6, 0.3), (0.85, 0.6), (0.2, 0.75)]
    )
)
_RIGHT_PX = 2.0
_NEAR_MM = 15.0


def main() -> None:
    parser = asking(__doc__, keep="captures and cases")
    parser.add_argument("--only", choices=PARTS, help="one part; the others stay as they are")
    parser.add_argument("--shots", type=int, default=40, help="marks of each kind")
    parser.add_argument("--photos", type=int, default=12, help="of the socks' captures")
    chosen = parser.parse_args()
    results: Result = found_before(chosen.out, {})
    results["machine"] = machine()
    with tempfile.TemporaryDirectory() as scratch:
        folder = chosen.keep or Path(scratch)
        for part in PARTS if chosen.only is None else (chosen.only,):
            sys.stderr.write(f"{part}\n")
            if part == "sheets":
                results[part] = sheets()
            elif part == "corners":
                results[part] = corners(chosen.shots)
            elif part == "sock":
                results[part] = socks(folder, chosen.photos)
            elif part == "stickers":
                results[part] = stickers(folder, chosen.photos)
            else:
                pictures(folder)
            write(chosen.out, results)


def sheets() -> Result:
    """Largest error of the marks' middles, and of the ruler, for each kind and page."""
    found: Result = {}
    pages: tuple[PageName, ...] = ("a4", "letter")
    for kind in KINDS:
        for page in pages:
            sheet = kind.draw(page, SheetOptions(pixel_mm=0.5))
            found[f"{kind.name.value}, {page}"] = _measured(sheet)
    return found


def _measured(sheet: Sheet) -> Result:
    expected = {one.mark_id: (one.x_mm, one.y_mm) for plate in sheet.plates for one in plate.marks}
    off: list[float] = []
    document = pypdfium2.PdfDocument(sheet.pdf)
    first = document[0].render(scale=DPI / 72, grayscale=True).to_numpy().squeeze()
    step = np.array([sheet.width_mm, sheet.height_mm]) / first.shape[::-1]
    for k in range(len(document) if expected else 0):
        picture = document[k].render(scale=DPI / 72, grayscale=True).to_numpy().squeeze()
        for mark in marks_in(cv2.GaussianBlur(picture, (0, 0), 0.8)):
            if mark.fit is not None:
                place = (mark.fit.centre_px + 0.5) * step
                off += np.abs(place - expected.pop(mark.mark_id)).tolist()
    if sheet.board is not None:
        off += _board_errors_mm(sheet, first, step)
    return {
        "ruler_mm": sheet.ruler_mm,
        "ruler_error_mm": round(_ruler_mm(first, sheet.ruler_mm, step[0]) - sheet.ruler_mm, 4),
        "places": len(off) // 2,
        "not_found": len(expected),
        "worst_mm": round(max(off), 4) if off else None,
    }


def _board_errors_mm(sheet: Sheet, picture: np.ndarray, step: np.ndarray) -> list[float]:
    """Inner corners by OpenCV's refinement, whose windows hold nothing but a crossing."""
    board = sheet.board
    if board is None:
        return []
    exact = board.corners_mm[:, :2] + (12.0, 21.0)
    start = np.ascontiguousarray(exact / step - 0.5, np.float32).reshape(-1, 1, 2)
    enough = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 100, 1e-4)
    found = cv2.cornerSubPix(picture, start, (23, 23), (-1, -1), enough).reshape(-1, 2)
    return np.abs((found + 0.5) * step - exact).ravel().tolist()


def _ruler_mm(picture: np.ndarray, length_mm: float, step_mm: float) -> float:
    """From the first stroke's middle to the last's, in the lowest row that shows all strokes."""
    for row in range(picture.shape[0] - 1, 0, -1):
        dark = 255.0 - picture[row]
        marked = np.flatnonzero(dark > 12)
        groups = np.split(marked, np.flatnonzero(np.diff(marked) > 1) + 1)
        if len(groups) == length_mm + 1:
            middles = [np.average(group, weights=dark[group]) for group in groups]
            if np.ptp(np.diff(middles)) * step_mm < 0.15:
                return float(middles[-1] - middles[0]) * step_mm
    return float("nan")


def corners(count: int) -> Result:
    """RMS of corners and middles, ours and OpenCV's, over random poses."""
    return {name: _corners_of(settings, count) for name, settings in SHOTS.items()}


def _corners_of(settings: dict[str, float], count: int) -> Result:
    ours: list[np.ndarray] = []
    theirs: list[np.ndarray] = []
    middles: list[np.ndarray] = []
    lost = 0
    for shot in _shots(settings, count):
        photo = photograph_mark(shot)
        seen = _opencv_corners(photo.luma, shot.mark_id)
        found = [one for one in marks_in(photo.luma, camera=CAMERA) if one.mark_id == shot.mark_id]
        if seen is None or not found or found[0].fit is None or found[0].doubt:
            lost += 1
            continue
        fit = found[0].fit
        ours.append(fit.corners_px - photo.corners_px)
        theirs.append(seen - photo.corners_px)
        middles.append(fit.centre_px - photo.centre_px)
    return {
        "marks": count,
        "not_measured": lost,
        "ours_rms_px": _rms(ours),
        "ours_worst_px": round(float(np.abs(ours).max()), 4),
        "opencv_rms_px": _rms(theirs),
        "middle_rms_px": _rms(middles) if "radius_mm" not in settings else None,
    }


def _shots(settings: dict[str, float], count: int) -> Iterable[MarkShot]:
    most_deg = settings.get("tilt_deg", 50.0)
    more: Any = {name: value for name, value in settings.items() if name != "tilt_deg"}
    for k in range(count):
        rng = np.random.default_rng((k, 30))
        tilt, around = np.radians(rng.uniform(0, most_deg)), rng.uniform(0, 2 * np.pi)
        axis = np.array([np.cos(around), np.sin(around), 0.0])
        turn = np.array([0.0, 0.0, rng.uniform(0, 2 * np.pi)])
        pose = Rigid.from_rotation_vector(tilt * axis, np.zeros(3)) @ (
            Rigid.from_rotation_vector(turn, np.zeros(3))
        )
        far = rng.uniform(700, 1100)
        place = far * np.array([rng.uniform(-0.17, 0.17), rng.uniform(-0.11, 0.11), 1.0])
        shot = MarkShot(
            camera=CAMERA,
            camera_from_mark=Rigid(pose.rotation, place),
            mark_id=int(rng.integers(0, 587)),
            twist_deg=float(rng.uniform(0, 90)),
            seed=k,
        )
        yield replace(shot, **more)


def _opencv_corners(luma: np.ndarray, mark_id: int) -> np.ndarray | None:
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    codes = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36H11)
    found, ids, _ = cv2.aruco.ArucoDetector(codes, parameters).detectMarkers(luma)
    labels = [] if ids is None else np.asarray(ids).ravel().tolist()
    return np.reshape(found[labels.index(mark_id)], (4, 2)) if mark_id in labels else None


def _rms(off: list[np.ndarray]) -> float:
    return round(float(np.sqrt(np.mean(np.square(off)))), 4)


def socks(folder: Path, photos: int) -> Result:
    """Right matches on the limb, and a whole run against the truth, for each sock."""
    found: Result = {}
    for name, paint in SOCKS.items():
        options = CaptureOptions(
            paint=paint,
            photos=photos,
            width_px=1200,
            height_px=800,
            seed=SEED,
            calibration_photos=10,
        )
        source = folder / f"sock_{name}"
        if not source.exists():
            folder.mkdir(parents=True, exist_ok=True)
            make_capture(source, options)
        found[name] = _matches(source, stage_truth(options))
        case = folder / f"sock_{name}_case"
        if not case.exists():
            found[name] |= _run(one_set(source, case, None))
    return found


def _matches(source: Path, truth: Truth) -> Result:
    """Matches between photos, those on the limb, and those that true cameras and limb confirm."""
    photos = read_photos([source / "images"])
    features = detect(photos)
    inside = [
        np.asarray(Image.open(source / "truth" / "masks" / Path(one.name).with_suffix(".png")))
        for one in photos.photos
    ]
    on_limb = [
        int(mask[_at(points.xy_px)].sum())
        for mask, points in zip(inside, features.keypoints, strict=True)
    ]
    low, high = truth.limb.mesh.vertices_mm.min(0), truth.limb.mesh.vertices_mm.max(0)
    limb, right = 0, 0
    try:
        pairs = match(photos, features).pairs
    except LimbgramError:
        pairs = ()
    for pair in pairs:
        kept = inside[pair.first][_at(pair.xy_first_px)]
        first, second = pair.xy_first_px[kept], pair.xy_second_px[kept]
        views = [truth.views[pair.first], truth.views[pair.second]]
        count = len(first)
        limb += count
        met = triangulate(
            views,
            np.repeat(np.arange(2, dtype=np.int32), count),
            np.tile(np.arange(count, dtype=np.int32), 2),
            np.concatenate([first, second]),
            count,
        )
        near = (met.points_in_world > low - _NEAR_MM) & (met.points_in_world < high + _NEAR_MM)
        right += int((near.all(1) & (met.rms_px < _RIGHT_PX)).sum())
    return {
        "photos": len(photos.photos),
        "keypoints_on_limb_a_photo": round(float(np.mean(on_limb))),
        "matches_on_limb_a_photo": round(2 * limb / len(photos.photos)),
        "right_matches_a_photo": round(2 * right / len(photos.photos)),
    }


def _at(xy_px: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    column, row = np.rint(xy_px).astype(int).T
    return row, column


def _run(result: Result) -> Result:
    truth = (result.get("accuracy") or {}).get("truth")
    found: Result = {
        "exit_code": result["reconstruct"]["exit_code"],
        "message": result["reconstruct"]["message"][-400:],
    }
    if truth is None:
        return found
    sigma = truth["sigma"] or {}
    return found | {
        "rms_mm": truth["rms_mm"],
        "p95_mm": truth["p95_mm"],
        "covered_0.25_mm": truth["covered"]["0.25 mm"],
        "error_over_sigma": sigma.get("robust_spread"),
        "median_sigma_mm": sigma.get("median_mm"),
        "scale_error": truth["scale_error"],
    }


def stickers(folder: Path, photos: int) -> Result:
    """Named stickers as landmarks, against their true places on the limb."""
    options = CaptureOptions(
        photos=photos, width_px=1200, height_px=800, distance_mm=1200.0, seed=44,
        calibration_photos=12, stickers=STUCK,
    )  # fmt: skip
    source, case = folder / "stickers", folder / "stickers_case"
    if not source.exists():
        folder.mkdir(parents=True, exist_ok=True)
        make_capture(source, options)
    found = {} if case.exists() else _run(one_set(source, case, None))
    surface = case / "case" / "deliverables" / "surface.ply"
    names = {str(one.mark_id): f"sticker {one.mark_id}" for one in STUCK}
    file = folder / "names.json"
    file.write_text(json.dumps(names))
    align = [LIMBGRAM, "align", str(surface), "--photos", str(case / "case")]
    align += ["--stickers", str(file), "--side", "left", "--anterior=+y"]
    done = subprocess.run(align, capture_output=True, text=True, check=False)
    if done.returncode:
        return found | {"exit_code": done.returncode, "message": done.stderr[-400:]}
    ours = read_poses(case / "case" / "deliverables" / "poses.json")
    theirs = read_poses(source / "truth" / "cameras.json")
    shared = sorted(ours.keys() & theirs.keys())
    by_cameras = fit_similarity(
        np.array([ours[name].centre for name in shared]),
        np.array([theirs[name].centre for name in shared]),
        with_scale=False,
    )
    limb = read_limb(surface)
    vertices, faces = read_truth_mesh(source / "truth" / "mesh.ply")
    truth = Surface(
        vertices_mm=vertices["xyz"].astype(float),
        faces=faces,
        seen=(vertices["ncam"] >= LEAST_PHOTOS) & (vertices["cap"] == 0),
        centres_mm=np.zeros((0, 3)),
    )
    # A landmark is a place on the limb: the limb is laid on its truth, not the cameras on theirs.
    start = Rigid(by_cameras.rotation, by_cameras.translation)
    points = limb.mesh.vertices_mm[measured_samples(limb.mesh)]
    truth_from_world = align_by_surface(points, truth, start).truth_from_world
    marks = {one.name: one.position_mm for one in limb.landmarks}
    notes = json.loads((source / "truth" / "notes.json").read_text())["stickers"]
    off = {
        names[str(one["mark_id"])]: round(
            float(
                np.linalg.norm(
                    truth_from_world.apply(marks[names[str(one["mark_id"])]][None])[0]
                    - one["place_mm"]
                )
            ),
            4,
        )
        for one in notes
    }
    return found | {"photos": photos, "off_mm": off, "worst_mm": max(off.values())}


def pictures(folder: Path) -> None:
    """All sheets side by side, and one limb in each sock where its photos are kept."""
    high, wide = 420, 420
    tiles: list[np.ndarray] = []
    for kind in KINDS:
        sheet = kind.draw("a4", SheetOptions(pixel_mm=0.5))
        page = pypdfium2.PdfDocument(sheet.pdf)[0]
        scale = 0.95 * min(high / page.get_height(), wide / page.get_width())
        drawn = np.asarray(page.render(scale=4 * scale).to_pil().convert("RGB"))
        drawn = cv2.resize(drawn, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
        tile = np.full((high, wide, 3), 205, np.uint8)
        top, left = (high - drawn.shape[0]) // 2, (wide - drawn.shape[1]) // 2
        tile[top : top + drawn.shape[0], left : left + drawn.shape[1]] = drawn
        tiles.append(tile)
    tiles += [np.full((high, wide, 3), 205, np.uint8)] * (-len(tiles) % 4)
    rows = [np.hstack(tiles[k : k + 4]) for k in range(0, len(tiles), 4)]
    Image.fromarray(np.vstack(rows)).save(GUIDE / "kit.png", optimize=True)
    shown = [
        np.asarray(Image.open(next(iter(sorted((folder / f"sock_{name}" / "images").iterdir())))))
        for name in SOCKS
        if (folder / f"sock_{name}").exists()
    ]
    if shown:
        cut = [one[:, one.shape[1] // 3 : -(one.shape[1] // 3)] for one in shown]
        Image.fromarray(np.hstack(cut)).save(GUIDE / "socks.jpg", quality=88)


def page(results: Result) -> str:
    parts = ["# kit", made_on(results["machine"])]
    if "sheets" in results:
        parts.append(
            "Sheets rasterised at 300 dots an inch and measured back, mm:\n\n"
            + _table(
                ("sheet", "places", "worst place", "ruler off"),
                [
                    (name, one["places"], one["worst_mm"], one["ruler_error_mm"])
                    for name, one in results["sheets"].items()
                ],
            )
        )
    if "corners" in results:
        heads = ("mark", "shots", "lost", "our corners", "worst", "OpenCV's corners", "our middles")
        parts.append(
            "Corners of rendered marks of 16 mm at 700 to 1100 mm (a pixel is 0.2 to 0.31 mm), "
            "RMS in px:\n\n"
            + _table(
                heads,
                [(name, *one.values()) for name, one in results["corners"].items()],
            )
        )
    if "sock" in results:
        keys = list(dict.fromkeys(key for one in results["sock"].values() for key in one))
        keys = [key for key in keys if key != "message"]
        parts.append(
            "One limb in three socks, the same photos (exit code 7: red, much of the limb is "
            "missing; 4: refused):\n\n"
            + _table(
                ("", *results["sock"]),
                [(key, *(one.get(key) for one in results["sock"].values())) for key in keys],
            )
        )
    if "stickers" in results and "off_mm" in results["stickers"]:
        off = results["stickers"]["off_mm"]
        parts.append(
            "Named stickers of 16 mm on a limb, from photos to landmarks, mm from their true "
            "places:\n\n" + _table(tuple(off), [tuple(off.values())])
        )
    return "\n\n".join(parts) + "\n"


def _table(heads: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    lines = ["| " + " | ".join(heads) + " |"]
    lines.append("|" + "---|" * (lines[0].count("|") - 1))
    lines += ["| " + " | ".join(map(_told, row)) + " |" for row in rows]
    return "\n".join(lines)


def _told(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    main()
