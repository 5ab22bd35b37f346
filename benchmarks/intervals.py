"""How often a stated 95 % interval holds: many small synthetic captures, each another limb.

    python benchmarks/intervals.py intervals.jsonl --count 100 --jobs 16

Every capture gets its own limb, paint, walk, noise and lens calibration from its seed, is
reconstructed from nothing, laid on its truth without changing size, and measured: girths (along
the contour, and of a taut tape; both smoothed over 5 mm, of surface and truth alike) and areas at
five heights, the volume between the outer two, and those of the slices between neighbours;
vertices, and what was filled, against the truth. One line of JSON a capture; seeds that are in the
file already are not run again. The last line printed says how many of all intervals held, and how
many missed on either side.

`--setting` photographs another sort of limb or more sharply (SETTINGS). `--keep FOLDER` keeps the
photos and every stage of each case: figures told anew are then a matter of seconds a capture.

    python benchmarks/intervals.py a.jsonl b.jsonl --joined intervals_smoothed.json

puts runs made so side by side into one table, and into a JSON file.
"""

import json
import math
import multiprocessing
import os
import sys
import tempfile
import time
from collections.abc import Generator, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from harness import described, machine, made_on, table
from limbgram.cases.folder import CaseFolder
from limbgram.cases.scoring import LEAST_PHOTOS, read_truth_mesh
from limbgram.cases.stage_cache import CachingRun
from limbgram.core.errors import LimbgramError
from limbgram.core.interval import COVER
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.uncertainty import filled_sigma_mm
from limbgram.reconstruction.calibration.board import calibrate
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.pipeline import Capture, Reconstruction, reconstruct
from limbgram.report.alignment import (
    Truth,
    align_by_cameras,
    align_by_surface,
    measured_samples,
    signed_mm,
)
from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.props.board import CALIBRATION_BOARD, SCALE_BOARD
from limbgram.synthetic.props.details import SkinDetails
from limbgram.synthetic.props.limb import LimbKind, Relief
from limbgram.synthetic.props.scan import distance_for, read_scan
from limbgram.synthetic.truth import stage_truth
from limbgram.workbench.measures.levels import (
    Refused,
    Sigmas,
    Volumes,
    area_mm2,
    contour_mm,
    levels_at,
    tape_mm,
)

SHARES = (0.2, 0.35, 0.5, 0.65, 0.8)
"""Heights of the girths, as shares of the seen height."""
MEASURED = {"contour": contour_mm, "tape": tape_mm, "area": area_mm2}
KINDS = (*MEASURED, "volume", "slice")
"""What is measured: at each height, between the outer two, and between neighbours."""
SETTINGS: dict[str, dict[str, Any]] = {
    "usual": {},
    "smooth": {"relief": Relief(rms_mm=0.0)},
    "rough": {"relief": Relief(rms_mm=0.5)},
    "fine": {"relief": Relief(rms_mm=0.1, finest_mm=2.5), "mesh_step_mm": 0.6},
    "sharp": {
        "width_px": 1920,
        "height_px": 1280,
        "blur_px": 0.35,
        "noise": 0.5,
        "mesh_step_mm": 0.6,
    },
    "sparse": {"coverage": 0.08},
    "bare": {"coverage": 0.05},
    "patchy": {"coverage": 0.5, "bare": 0.5},
    "wrinkled": {"coverage": 0.15, "relief": Relief(rms_mm=0.15, finest_mm=3.0, growth=0.2)},
    "shapes": {},
    "skin": {
        "details": SkinDetails(
            knit_mm=0.1, knit_period_mm=2.0, veins_mm=0.7, scars_mm=0.7, wrinkles_mm=1.0
        ),
        "mesh_step_mm": 0.5,
    },
}
"""What a setting changes of the usual small capture: no relief, 2.5 times as much, relief that goes
on to waves of 2.5 mm, photos of twice the resolution; a tenth or a thirtieth of the sock painted;
half of the paint left out in patches; little paint on relief as high at 3 mm as at 40; a scan
of somebody else's limb, drawn by the seed, with paint from dense to little (SCANS); knit, veins,
scars and wrinkles on ours."""
SCANS: tuple[tuple[str, float | None], ...] = (
    ("ampscan/Example.AOP", None),
    ("ampscan/stl_file.stl", None),
    ("ampscan/stl_file_2.stl", None),
    ("openlimb_TT/102m.stl", 383.0),
    ("openlimb_TT/102p.stl", 383.0),
    ("openlimb_TT/1m20.stl", 383.0),
    ("openlimb_TT/1p20.stl", 383.0),
    ("openlimb_TT/Full Size Mean_Skin_Shape.stl", None),
)
"""Scans under $LIMBGRAM_DATA/shapes, and the mm of one unit where the file does not say it: the
public model of transtibial limbs is one tibia long, which is 383 mm in its own full size."""
LITTLE_PAINT = ("sparse", "bare", "patchy", "wrinkled")
"""Settings photographed by 16 to 20 photos, as the guide for photographers asks; the others by 10
to 12, a photo each 30 to 36 degrees, which join only where paint is everywhere."""


def main() -> None:
    parser = described(__doc__)
    parser.add_argument("out", type=Path, nargs="+", help="JSON lines; what is there is kept")
    parser.add_argument(
        "--joined", type=Path, help="run nothing; put what is there into this .json"
    )
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--first", type=int, default=1000, help="first seed")
    parser.add_argument("--setting", choices=SETTINGS, default="usual")
    parser.add_argument("--jobs", type=int, default=1, help="captures at a time, a process each")
    parser.add_argument("--keep", type=Path, help="keep photos and stages of every case here")
    chosen = parser.parse_args()
    if chosen.joined:
        found = [line for path in chosen.out for line in lines_of(path)]
        counted = {
            "machine": machine(),
            "settings": counts_of(found),
            "vertices": spreads_of(found),
            "captures": found,
        }
        chosen.joined.write_text(json.dumps(counted, indent=1) + "\n")
        return
    (out,) = chosen.out
    done = {line["seed"] for line in lines_of(out) if line["setting"] == chosen.setting}
    seeds = [seed for seed in range(chosen.first, chosen.first + chosen.count) if seed not in done]
    for line in run_all(partial(one, setting=chosen.setting, keep=chosen.keep), seeds, chosen.jobs):
        with out.open("a") as stream:
            stream.write(json.dumps(line) + "\n")
        sys.stderr.write(f"{line['seed']}: {line.get('refused') or told([line])}\n")
    sys.stdout.write(told(lines_of(out)) + "\n")


def run_all(
    task: "partial[dict[str, Any]]", seeds: list[int], jobs: int
) -> Iterator[dict[str, Any]]:
    """Every seed's line as it comes, so many processes at a time."""
    if jobs == 1:
        yield from map(task, seeds)
        return
    for name in ("NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # the processes share the cores, not their threads
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=fresh) as pool:
        for done in as_completed([pool.submit(task, seed) for seed in seeds]):
            yield done.result()


def options_of(seed: int, setting: str) -> CaptureOptions:
    """A small capture, drawn by its seed."""
    random = np.random.default_rng((seed, 77))
    width = int(random.choice([780, 864, 960]))
    usual = CaptureOptions(
        kind=list(LimbKind)[int(random.integers(len(LimbKind)))],
        seed=seed,
        coverage=float(random.uniform(0.45, 0.65)),
        photos=int(random.integers(10, 13)),
        distance_mm=1400.0,
        width_px=width,
        height_px=width * 2 // 3,
        calibration_photos=8,
        noise=float(random.uniform(0.5, 2.0)),
        jpeg_quality=int(random.integers(88, 97)),
        mesh_step_mm=1.0,
    )
    if setting == "shapes":
        return _scanned(usual, random)
    little_paint = int(random.integers(16, 21)) if setting in LITTLE_PAINT else usual.photos
    return replace(usual, photos=little_paint, **SETTINGS[setting])


def _scanned(usual: CaptureOptions, random: np.random.Generator) -> CaptureOptions:
    """The same of a scan: 16 to 20 photos of it, from as far as fills them."""
    name, mm_per_unit = SCANS[int(random.integers(len(SCANS)))]
    scan = read_scan(Path(os.environ["LIMBGRAM_DATA"]) / "shapes" / name, mm_per_unit)
    return replace(
        usual,
        scan=scan,
        coverage=float(random.uniform(0.15, 0.65)),
        bare=float(random.choice([0.0, 0.0, 0.3])),
        photos=int(random.integers(16, 21)),
        distance_mm=distance_for(scan, usual.distance_mm),
    )


def one(seed: int, setting: str, keep: Path | None) -> dict[str, Any]:
    """One capture from nothing to its figures."""
    start = time.process_time()
    options = options_of(seed, setting)
    kind = options.kind.value if options.scan is None else f"scan {options.scan.sha256[:8]}"
    line: dict[str, Any] = {"seed": seed, "setting": setting, "kind": kind}
    with folder_of(seed, setting, keep) as folder:
        photos = folder / "capture"
        if not photos.exists():
            make_capture(photos, options)
        made = time.process_time()
        try:
            lens = calibrate(read_photos([photos / "calibration"]), CALIBRATION_BOARD.board)
            result = reconstruct(
                Capture(
                    sources=(photos / "images",),
                    calibrations=(lens.calibration,),
                    board=SCALE_BOARD.board,
                ),
                run=None if keep is None else CachingRun(case=CaseFolder(folder / "case")),
            )
            views = {view.name: view for view in stage_truth(options).views}
            placed = [views[name].centre_in_world for name in names_placed(result.metric.scene)]
            line |= figures(result, truth_of(photos / "truth", np.array(placed)))
        except LimbgramError as refusal:
            line["refused"] = str(refusal)
        except np.linalg.LinAlgError as fault:  # no refusal but a fault, and counted as such
            line["refused"] = f"fault: {fault}"
    return line | {"cpu_s": [round(made - start, 1), round(time.process_time() - made, 1)]}


@contextmanager
def folder_of(seed: int, setting: str, keep: Path | None) -> Generator[Path]:
    """Where photos and stages lie: for good, or for as long as they are worked on."""
    if keep is None:
        with tempfile.TemporaryDirectory() as scratch:
            yield Path(scratch)
    else:
        folder = keep / f"{setting}-{seed}"
        folder.mkdir(parents=True, exist_ok=True)
        yield folder


def names_placed(scene: Scene) -> tuple[str, ...]:
    return tuple(scene.names[photo] for photo in scene.placed)


def truth_of(folder: Path, centres_mm: np.ndarray) -> Truth:
    vertices, faces = read_truth_mesh(folder / "mesh.ply")
    return Truth(
        vertices_mm=vertices["xyz"].astype(float),
        faces=faces,
        seen=(vertices["ncam"] >= LEAST_PHOTOS) & (vertices["cap"] == 0),
        centres_mm=centres_mm,
    )


def figures(result: Reconstruction, truth: Truth) -> dict[str, Any]:
    """Value, sigma and truth of every figure, and error over sigma of the vertices."""
    mesh = result.mesh
    centres = np.array([view.centre_in_world for view in result.metric.scene.views])
    samples = mesh.vertices_mm[measured_samples(mesh)]
    fit = align_by_surface(samples, truth, align_by_cameras(centres, truth))
    placed = mesh.with_vertices(fit.truth_from_world.apply(mesh.vertices_mm))
    true = Mesh(vertices_mm=truth.vertices_mm, faces=truth.faces)
    seen = truth.vertices_mm[truth.seen, 2]
    low, high = float(np.quantile(seen, 0.02)), float(np.quantile(seen, 0.98))
    heights = [low + share * (high - low) for share in SHARES]
    ours, theirs = Sigmas.of(placed), Sigmas.of(true)
    found: list[dict[str, Any]] = []
    for one, other in zip(levels_at(placed, heights), levels_at(true, heights), strict=True):
        if isinstance(one, Refused) or isinstance(other, Refused):
            continue
        for kind, measure in MEASURED.items():
            figure = ours.figure(one, measure(one))
            found.append(_figure(kind, figure.value, figure.sigma, measure(other).value))
    of_ours, of_theirs = Volumes.of(ours), Volumes.of(theirs)
    spans = [("volume", heights[0], heights[-1])]
    spans += [("slice", low, high) for low, high in pairwise(heights)]
    for kind, low, high in spans:
        try:
            volume = of_ours.between(low, high)
            whole = of_theirs.between(low, high).value
        except LimbgramError:  # open between the heights: no volume
            continue
        found.append(_figure(kind, volume.value, volume.sigma, whole))
    off_mm, near = signed_mm(placed.vertices_mm, truth)
    sigma_mm = np.full(len(mesh), np.nan) if mesh.sigma_mm is None else mesh.sigma_mm
    filled = ~np.isfinite(sigma_mm)
    known = near & ~filled
    ratio = off_mm[known] / sigma_mm[known]
    in_fills = off_mm[near & filled] / filled_sigma_mm(mesh, filled)[near & filled]
    return {
        "figures": found,
        "vertices": len(mesh),
        "filled": float(np.mean(filled)),
        "in_fills": rms_of(in_fills),
        "beyond_in_fills": float(np.mean(np.abs(in_fills) > COVER)) if len(in_fills) else None,
        "rms_mm": float(np.sqrt(np.mean(off_mm[known] ** 2))),
        "mean_mm": float(np.mean(off_mm[known])),
        "scale_error": fit.scale_error,
        "spread": 1.4826 * float(np.median(np.abs(ratio))),
        "within_one": float(np.quantile(np.abs(ratio), 0.6827)),
        "tenths": [
            1.4826 * float(np.median(np.abs(ratio[part])))
            for part in np.array_split(np.argsort(sigma_mm[known], kind="stable"), 10)
        ],
    }


def rms_of(ratios: np.ndarray) -> float | None:
    """Root mean square; None of nothing."""
    return float(np.sqrt(np.mean(ratios**2))) if len(ratios) else None


def _figure(kind: str, value: float, sigma: float | None, true: float) -> dict[str, Any]:
    return {"kind": kind, "value": value, "sigma": sigma, "true": true}


def lines_of(path: Path) -> list[dict[str, Any]]:
    if not path.exists():
        return []
    return [json.loads(line) for line in path.read_text().splitlines() if line]


def told(lines: list[dict[str, Any]]) -> str:
    """How many intervals held, by kind, and how the errors over their sigmas scatter."""
    parts = [f"{len(lines)} captures, {sum('refused' in line for line in lines)} refused"]
    for kind in KINDS:
        ratios = ratios_of(lines, kind)
        if not ratios:
            continue
        short, long = missed(ratios)
        held = len(ratios) - short - long
        rms = math.sqrt(sum(ratio**2 for ratio in ratios) / len(ratios))
        mean = sum(ratios) / len(ratios)
        parts.append(
            f"{kind}: {held} of {len(ratios)} hold ({held / len(ratios):.1%}), {short} state too "
            f"little, {long} too much, "
            f"error over sigma RMS {rms:.2f}, mean {mean:+z.2f}"
        )
    spreads = [line["spread"] for line in lines if "spread" in line]
    if spreads:
        parts.append(f"vertices {np.median(spreads):.2f} ({min(spreads):.2f}-{max(spreads):.2f})")
    tenths = [line["tenths"] for line in lines if "tenths" in line]
    if tenths:
        by_tenth = np.median(tenths, axis=0)
        parts.append(f"tenths of sigma {by_tenth.min():.2f} to {by_tenth.max():.2f}")
    return "; ".join(parts)


def counts_of(lines: list[dict[str, Any]]) -> dict[str, dict[str, dict[str, float]]]:
    """How many intervals of each kind held, by setting."""
    found: dict[str, dict[str, dict[str, float]]] = {}
    for setting in dict.fromkeys(line["setting"] for line in lines):
        own = [line for line in lines if line["setting"] == setting]
        for kind in KINDS:
            ratios = ratios_of(own, kind)
            if not ratios:
                continue
            short, long = missed(ratios)
            found.setdefault(setting, {})[kind] = {
                "captures": len(own),
                "figures": len(ratios),
                "too_little": short,
                "too_much": long,
                "mean_error_over_sigma": float(np.mean(ratios)),
                "rms_error_over_sigma": float(np.sqrt(np.mean(np.square(ratios)))),
            }
    return found


def spreads_of(lines: list[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """How errors of vertices over their sigmas scatter, by setting."""
    found: dict[str, dict[str, Any]] = {}
    for setting in dict.fromkeys(line["setting"] for line in lines):
        own = [line for line in lines if line["setting"] == setting]
        measured = [line for line in own if "spread" in line]
        if not measured:
            continue
        spreads = [line["spread"] for line in measured]
        fills = [line for line in measured if line.get("beyond_in_fills") is not None]
        within = [1 - line["beyond_in_fills"] for line in fills]
        found[setting] = {
            "captures": len(own),
            "refused": len(own) - len(measured),
            "median_spread": float(np.median(spreads)),
            "least_spread": min(spreads),
            "most_spread": max(spreads),
            "tenths": np.median([line["tenths"] for line in measured], axis=0).tolist(),
            "captures_with_fills": len(fills),
            "fills_within": float(np.mean(within)) if within else None,
        }
    return found


def missed(ratios: list[float]) -> tuple[int, int]:
    """How many figures state too little, and too much: the truth lies beyond their interval."""
    return sum(one < -COVER for one in ratios), sum(one > COVER for one in ratios)


def page(results: dict[str, Any]) -> str:
    """The machine, all intervals together, and one row a capture."""
    lines: list[dict[str, Any]] = results["captures"]
    parts = [
        "# Do stated 95 % intervals hold?",
        f"{made_on(results['machine'])}. Error over sigma by capture; girths: the mean of five "
        "levels.",
        _vertices_table(lines),
        *(
            f"{setting}: {told([line for line in lines if line['setting'] == setting])}."
            for setting in dict.fromkeys(line["setting"] for line in lines)
        ),
    ]
    heads = (
        "seed",
        "setting",
        "limb",
        "contour held",
        "mean",
        "tape held",
        "mean",
        "area held",
        "volume",
        "slices held",
        "RMS mm",
        "spread",
        "by tenths of sigma",
        "filled",
        "beyond 95 % in fills",
    )
    rows: list[list[str]] = []
    for line in sorted(lines, key=lambda one: (one["setting"], one["seed"])):
        kind = line["kind"]
        if "refused" in line:
            reason = f"refused: {line['refused'][:80]}"
            rows.append(
                [f"{line['seed']}", line["setting"], kind, reason, *[""] * (len(heads) - 4)]
            )
            continue
        cells = [f"{line['seed']}", line["setting"], kind]
        for name in ("contour", "tape"):
            ratios = ratios_of([line], name)
            if not ratios:
                cells += ["open", ""]
                continue
            cells += [
                f"{len(ratios) - sum(missed(ratios))} of {len(ratios)}",
                f"{np.mean(ratios):+z.2f}",
            ]
        volume = ratios_of([line], "volume")
        cells += [held_of([line], "area"), f"{volume[0]:+z.2f}" if volume else "open"]
        cells += [held_of([line], "slice")]
        tenths = line.get("tenths", [math.nan])
        cells += [f"{line['rms_mm']:.3f}", f"{line['spread']:.2f}"]
        cells += [f"{min(tenths):.2f} to {max(tenths):.2f}", f"{line['filled']:.1%}"]
        beyond = line.get("beyond_in_fills")
        cells += ["" if beyond is None else f"{beyond:.1%}"]
        rows.append(cells)
    return "\n\n".join([*parts, table(heads, rows)]) + "\n"


def _vertices_table(lines: list[dict[str, Any]]) -> str:
    """Vertices of each setting: how their errors over their sigmas spread."""
    heads = ("captures", "refused", "spread", "least", "most", "by tenths of sigma")
    rows = [
        [
            f"{setting}, {one['captures']}",
            f"{one['refused']}",
            *(f"{one[key]:.2f}" for key in ("median_spread", "least_spread", "most_spread")),
            " ".join(f"{tenth:.2f}" for tenth in one["tenths"]),
        ]
        for setting, one in spreads_of(lines).items()
    ]
    return table(heads, rows)


def held_of(lines: list[dict[str, Any]], kind: str) -> str:
    """How many intervals of one kind hold."""
    ratios = ratios_of(lines, kind)
    return f"{len(ratios) - sum(missed(ratios))} of {len(ratios)}" if ratios else "open"


def ratios_of(lines: list[dict[str, Any]], kind: str) -> list[float]:
    """Error over sigma of all figures of one kind."""
    found = [one for line in lines for one in line.get("figures", ()) if one["kind"] == kind]
    return [(one["value"] - one["true"]) / one["sigma"] for one in found]


if __name__ == "__main__":
    main()
