"""The coach against what came of it: expected sigma, coverage and GO, on captures not tuned on.

    python benchmarks/coach.py --keep FOLDER --first 8000 -o benchmarks/results/coach.json

Every seed draws a limb, its paint, relief, walk round, lens, distance, noise and blur, and of every
third capture some neighbouring photos are left out. `check` and `plan` say what to expect; then
the photos are reconstructed by the command line and sigma and surface compared, in all and cell
by cell of the check's proxy. What lies in FOLDER is not made again; seeds that OUT holds are left
as they are, each with the commit that made it. `--plan-again` plans all captures of OUT anew, which
takes their board photos alone: the plan's column is then that of the commit that stands above the
table. `--timing PHOTOS CAMERA` checks a folder of photos once
whole and once photo by photo, and keeps the seconds.
"""

import argparse
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from captures import JUDGED, timed
from harness import asking, found_before, machine, made_on, table, write
from limbgram.capture.answer import CaptureCheck
from limbgram.capture.camera_positions import Stand
from limbgram.capture.plan import (
    LimbForm,
    PlannedCamera,
    Sock,
    board_edge_px,
    form_of,
    showing_of_sock,
)
from limbgram.capture.prediction import predict
from limbgram.cases.capture_check import CaptureWatch, check_sources
from limbgram.cases.stage_cache import read_product
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.run import Run
from limbgram.findings import told
from limbgram.formats.camera import read_camera
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.photographer import Lens, camera_of
from limbgram.synthetic.props.board import SCALE_BOARD
from limbgram.synthetic.props.limb import LimbKind, Relief
from limbgram.synthetic.props.paint import Paint

Result = dict[str, Any]
LIMBGRAM = str(Path(sys.executable).with_name("limbgram"))
FORMS = {
    LimbKind.TRANSTIBIAL: LimbForm.LOWER_LEG,
    LimbKind.TRANSFEMORAL: LimbForm.THIGH,
    LimbKind.BULBOUS: LimbForm.LOWER_LEG,
}
HEIGHTS_DEG = (28.0, 50.0, 40.0)
"""Of the generator's rings, from the lowest."""
NEAR_MM = 15.0
"""A cell with no surface within this has none."""
WITHIN = 0.3
FEWEST_EXPLAINED = 10


MOVED = re.compile("limb moved|limb bent|lie otherwise|lie elsewhere|lay elsewhere")


def main() -> None:
    parser = asking(__doc__, keep="captures and cases")
    parser.add_argument("--first", type=int, default=7000, help="first seed")
    parser.add_argument("--count", type=int, default=18)
    parser.add_argument("--plan-again", action="store_true")
    parser.add_argument("--timing", nargs=2, metavar=("PHOTOS", "CAMERA"), type=Path)
    parser.add_argument("--growing", nargs=2, type=Path, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.growing:
        sys.stdout.write(json.dumps(growing(*chosen.growing)))
        return
    results: Result = found_before(chosen.out, {})
    results |= {"machine": machine()}
    captures: Result = results.setdefault("captures", {})
    with tempfile.TemporaryDirectory() as scratch:
        if chosen.timing:
            results["timing"] = timing(*chosen.timing)
            write(chosen.out, results)
            return
        if chosen.plan_again:
            for seed, line in captures.items():
                plan_again(int(seed), line, Path(scratch) / seed)
                write(chosen.out, results)
            return
        for seed in range(chosen.first, chosen.first + chosen.count):
            if str(seed) in captures:
                continue
            found = one(seed, (chosen.keep or Path(scratch)) / str(seed))
            captures[str(seed)] = found | {"commit": results["machine"]["commit"][:12]}
            sys.stderr.write(f"{seed}: {json.dumps(captures[str(seed)])[:300]}\n")
            write(chosen.out, results)


def options_of(seed: int) -> CaptureOptions:
    """A small capture drawn by its seed."""
    random = np.random.default_rng((seed, 1400))
    photos = int(random.integers(9, 21))
    rings = 2 if photos >= 15 and random.random() < 0.6 else 1
    distance_mm, field_mm = float(random.uniform(600, 1800)), float(random.uniform(400, 520))
    width_px = int(random.integers(600, 1150))
    focal_mm = round(distance_mm * Lens().sensor_width_mm * 2 / 3 / field_mm, 1)
    return CaptureOptions(
        kind=list(LimbKind)[int(random.integers(3))],
        seed=seed,
        paint=Paint.PRINT if random.random() < 0.3 else Paint.DABS,
        coverage=float(random.uniform(0.3, 0.65)),
        photos=photos,
        rings=rings,
        distance_mm=distance_mm,
        width_px=width_px,
        height_px=width_px * 2 // 3,
        lens=Lens(focal_mm=focal_mm, name=f"{focal_mm:g} mm"),
        calibration_photos=8,
        noise=float(random.uniform(0.5, 3)),
        blur_px=float(random.uniform(0.35, 0.9)),
        jpeg_quality=int(random.integers(86, 97)),
        relief=Relief(rms_mm=float(random.uniform(0.12, 0.28))),
        mesh_step_mm=1.0,
        samples=3,
    )


def one(seed: int, folder: Path) -> Result:
    """One capture: what was expected, and what came."""
    options = options_of(seed)
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "capture").exists():
        make_capture(folder / "capture", options)
    camera = calibrated(folder)
    photos = kept_photos(seed, folder / "capture" / "images")
    start, start_cpu = time.perf_counter(), time.process_time()
    check = check_sources(photos, [read_camera(camera)], SCALE_BOARD.board, Run())
    result: Result = {
        "limb": options.kind.value,
        "paint": options.paint.value,
        "photos": len(photos),
        "left_out": options.photos - len(photos),
        "rings": options.rings,
        "go": check.go,
        "headline": told(check.headline),
        "check_s": round(time.perf_counter() - start, 1),
        "check_cpu_s": round(time.process_time() - start_cpu, 1),
        "findings": [told(one) for one in check.findings],
        "said_to_move": any(MOVED.search(told(one)) for one in (*check.findings, *check.notes)),
        "plan_sigma_mm": planned_sigma_mm(options, read_camera(camera).edge_px)
        if len(photos) == options.photos
        else None,
    }
    run = folder / "run.json"
    if not run.exists():
        command = [LIMBGRAM, "reconstruct", *map(str, photos), "--camera", str(camera)]
        run.write_text(json.dumps(timed([*command, "-o", str(folder / "case"), "--json"])))
    done = json.loads(run.read_text())
    result |= {"exit_code": done["exit_code"], "message": done["message"]}
    if done["exit_code"] in JUDGED:
        said = json.loads((folder / "case" / "accuracy.json").read_text())
        result |= {"light": said["light"], "verdict": said["headline"]["sentence"]}
        result["movement"] = next(
            (one["finding"]["sentence"] for one in said["criteria"] if one["key"] == "movement"),
            None,
        )
    if result["exit_code"] in JUDGED and check.coverage is not None:
        result |= compared(check, surface_of(folder / "case"))
    return result


def calibrated(folder: Path) -> Path:
    """The camera file of a capture's board photos."""
    camera = folder / "camera.json"
    if not camera.exists():
        boards = str(folder / "capture" / "calibration")
        board = ["--board", "14x10", "--square", "10", "-o", str(camera)]
        subprocess.run([LIMBGRAM, "calibrate", boards, *board], check=False, capture_output=True)
    return camera


def plan_again(seed: int, line: Result, folder: Path) -> None:
    """What is planned for a capture today: by the edges of board photos, as `calibrate` does."""
    if line["plan_sigma_mm"] is None:
        return
    boards = replace(options_of(seed), photos=3, rings=1, calibration_photos=3)
    make_capture(folder / "capture", boards)
    widths = [
        photo.sharpness for photo in read_photos((folder / "capture" / "calibration",)).photos
    ]
    line["plan_sigma_mm"] = planned_sigma_mm(options_of(seed), float(np.median(widths)))
    shutil.rmtree(folder)


def kept_photos(seed: int, folder: Path) -> list[Path]:
    """Of every third capture some neighbours are left out."""
    photos = sorted(folder.iterdir())
    if seed % 3 != 2:
        return photos
    random = np.random.default_rng((seed, 5))
    count, first = int(random.integers(2, 6)), int(random.integers(len(photos)))
    left = {photos[(first + k) % len(photos)] for k in range(count)}
    return [photo for photo in photos if photo not in left]


def planned_sigma_mm(options: CaptureOptions, edge_px: float | None) -> float:
    """By the plan's formula and forms, and what is known before the walk: the camera and the sock.

    The rings are those that the photographer means to walk.
    """
    limb = form_of(FORMS[options.kind])
    camera = camera_of(options.lens, options.width_px, options.height_px, options.distance_mm)
    shares = np.array([1.0, 0.6, 0.6])[: options.rings]
    counts = np.rint(shares / shares.sum() * options.photos).astype(int)
    views = [
        Stand(
            azimuth_deg=360.0 * k / count, elevation_deg=height, distance=options.distance_mm
        ).view(camera, limb.middle, 0.0)
        for count, height in zip(counts, HEIGHTS_DEG)
        for k in range(count)
    ]
    known = PlannedCamera(camera=camera, edge_px=edge_px)
    sock = Sock.PRINTED if options.paint is Paint.PRINT else Sock.PAINTED
    showing = showing_of_sock(len(limb.mesh), len(views), board_edge_px(known), sock)
    return predict(limb, views, showing).middle_sigma_mm(limb)


def surface_of(case: Path) -> Mesh:
    folder = case / "stages" / "measure"
    key = json.loads((folder / "stage.json").read_text())["key"]
    found, _ = read_product(folder, key, Mesh, case)
    assert isinstance(found, Mesh)
    return found


def compared(check: CaptureCheck, mesh: Mesh) -> Result:
    """Expected over obtained: half of the surface, and the cells of the check's proxy."""
    coverage = check.coverage
    assert coverage is not None
    assert mesh.sigma_mm is not None
    sigma, area = mesh.sigma_mm.astype(float), mesh.vertex_areas_mm2()
    measured = np.isfinite(sigma)
    order = np.argsort(sigma[measured])
    summed = np.cumsum(area[measured][order])
    obtained = float(sigma[measured][order][np.searchsorted(summed, summed[-1] / 2)])
    places = np.array(coverage.places).reshape(-1, 3)
    expected = numbers(coverage.sigma_mm)
    seen = numbers(coverage.photos)
    far, found = KDTree(mesh.vertices_mm).query(places, k=60)
    near = np.asarray(found)
    there = (far[:, 0] < NEAR_MM) & (measured[near].mean(axis=1) > 0.5)
    own = np.array(
        [np.median(sigma[k][measured[k]]) if ok else np.nan for k, ok in zip(near, there)]
    )
    known = np.isfinite(seen)
    both = known & there & np.isfinite(expected)
    return {
        "expected_sigma_mm": coverage.sigma_middle_mm,
        "sigma_mm": obtained,
        "cells": int(both.sum()),
        "cells_within": float(np.mean(np.abs(expected[both] / own[both] - 1) <= WITHIN)),
        "expected_measured": float(np.mean(seen[known] >= 2)),
        "measured": float(np.mean(there[known])),
    }


def numbers(rows: Sequence[Sequence[float | int | None]]) -> np.ndarray:
    flat = [value for row in rows for value in row]
    return np.array([math.nan if value is None else float(value) for value in flat])


def timing(photos: Path, camera: Path) -> Result:
    """Seconds of a whole check, and of each photo that comes to a folder, by the command."""
    whole = timed([LIMBGRAM, "check", str(photos), "--camera", str(camera), "--json"])
    told = subprocess.run(
        [sys.executable, __file__, "--growing", str(photos), str(camera), "-o", "-"],
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    load = os.getloadavg()[0]
    return {"whole": whole, "each": json.loads(told.stdout), "load": round(load, 1)}


def growing(photos: Path, camera: Path) -> list[Result]:
    """What each photo after the first costs that comes to a folder."""
    each: list[Result] = []
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        with CaptureWatch([read_camera(camera)], SCALE_BOARD.board) as watch:
            for number, file in enumerate(sorted(photos.iterdir()), start=1):
                (folder / file.name).symlink_to(file.resolve())
                start, start_cpu = time.perf_counter(), time.process_time()
                if number >= 2:
                    found = watch.check([folder], Run())
                    wall_s, cpu_s = time.perf_counter() - start, time.process_time() - start_cpu
                    each.append(
                        {"go": found.go, "wall_s": round(wall_s, 1), "cpu_s": round(cpu_s, 1)}
                    )
    return each


def page(results: Result) -> str:
    lines: list[Result] = list(results["captures"].values())
    done = [line for line in lines if "sigma_mm" in line]
    planned = [line for line in done if line["plan_sigma_mm"] is not None]

    def within(part: Sequence[Result], name: str, limit: float = WITHIN) -> str:
        held = sum(abs(line[name] / line["sigma_mm"] - 1) <= limit for line in part)
        return f"{held} of {len(part)}"

    cells = sum(line["cells"] for line in done)
    inside = sum(line["cells_within"] * line["cells"] for line in done)
    went = [line for line in lines if line["go"]]
    bad = [line for line in went if line["exit_code"] != 0]
    whole = [line for line in lines if line["exit_code"] == 0 and line["left_out"] == 0]
    held_back = [line for line in whole if not line["go"]]
    green = [line for line in lines if line.get("light") == "green"]
    green_back = [line for line in green if not line["go"]]
    looked = [line["movement"] for line in done if line.get("movement")]
    still = sum("kept still" in sentence for sentence in looked)
    unknown = sum("not known" in sentence for sentence in looked)
    said = [
        "# What the coach expects, and what came",
        made_on(results["machine"]),
        f"{len(lines)} captures, {len(done)} reconstructed. Expected sigma of half the surface "
        f"within 30 %: check {within(done, 'expected_sigma_mm')}, plan "
        f"{within(planned, 'plan_sigma_mm')}; of {cells} cells {inside / max(cells, 1):.0%}. "
        + explained(results["captures"]),
        f"GO said {len(went)} times; {len(bad)} of these were red or refused afterwards. "
        f"{len(whole)} captures with all their photos became green or amber; {len(held_back)} of "
        f"these were held back. Of {len(green)} whose light is known to be green, with all their "
        f"photos or not, {len(green_back)} were held back.",
        f"No limb moved. Of {len(looked)} that were looked at for movement, {still} were said to "
        f"have kept still, of {unknown} nothing was said, and "
        f"{len(looked) - still - unknown} were said to have moved.",
    ]
    said.append(_by_capture(results["captures"]))
    wrong = [seed for seed, line in sorted(results["captures"].items())
             if line in bad or line in held_back or line in green_back]  # fmt: skip
    said += [f"Seed {seed}: {results['captures'][seed]['headline']}" for seed in wrong]
    if "timing" in results:
        said.append(_timing(results["timing"]))
    return "\n\n".join(said) + "\n"


def _by_capture(captures: Result) -> str:
    heads = ("seed", "limb", "paint", "photos", "left out", "answer", "came", "sigma mm", "check",
             "plan", "cells", "seen expected", "measured", "CPU s", "commit")  # fmt: skip
    rows: list[list[str]] = []
    for seed, line in sorted(captures.items()):
        came = {0: "good", 7: "red"}.get(line["exit_code"], "refused")
        row = [seed, line["limb"], line["paint"], str(line["photos"]), str(line["left_out"])]
        row += ["GO" if line["go"] else "not yet", came]
        if "sigma_mm" in line:
            plan = line["plan_sigma_mm"]
            row += [
                f"{line['sigma_mm']:.4f}",
                f"{line['expected_sigma_mm'] / line['sigma_mm']:.2f}",
                "" if plan is None else f"{plan / line['sigma_mm']:.2f}",
                f"{line['cells_within']:.0%}",
                f"{line['expected_measured']:.1%}",
                f"{line['measured']:.1%}",
            ]
        else:
            row += [""] * 6
        cpu_s = f"{line['check_cpu_s']:.0f}" if "check_cpu_s" in line else ""
        rows.append([*row, cpu_s, line["commit"]])
    return table(heads, rows)


def _timing(time_s: Result) -> str:
    whole, each = time_s["whole"], time_s["each"]
    wall_s = ", ".join(f"{one['wall_s']:g}" for one in each)
    cpu_s = ", ".join(f"{one['cpu_s']:g}" for one in each)
    return (
        f"A whole check of {len(each) + 1} photos took {whole['cpu_s']} CPU s, "
        f"{whole['wall_s']} s on the clock at load {time_s['load']}. Photo by photo, from the "
        f"second on: {cpu_s} CPU s; {wall_s} s on the clock."
    )


def explained(captures: Result) -> str:
    """How the expected sigma of `check` over what came goes with relief and number of photos."""
    known = [
        (options_of(int(seed)).relief.rms_mm, line["photos"], ratio)
        for seed, line in captures.items()
        if line["exit_code"] == 0
        and (ratio := line.get("expected_sigma_mm", math.nan) / line.get("sigma_mm", math.nan)) > 0
    ]
    if len(known) < FEWEST_EXPLAINED:
        return ""
    relief, photos, ratios = np.log(np.array(known)).T
    terms = np.column_stack([np.ones(len(known)), relief, photos])
    powers = np.linalg.lstsq(terms, ratios, rcond=None)[0]
    left = float(np.std(ratios - terms @ powers))
    return (
        f"Check's expected over obtained sigma of the {len(known)} good ones spreads by "
        f"{np.std(ratios):.0%}. It goes with the height of the relief to the power "
        f"{powers[1]:.2f}, which no photo shows beforehand, and with the number of photos to the "
        f"power {powers[2]:.2f}; {left:.0%} are left."
    )


if __name__ == "__main__":
    main()
