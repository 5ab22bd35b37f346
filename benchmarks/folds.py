"""Folds: places where a surface folds over or through itself, before they are laid back and after.

    python benchmarks/folds.py -o benchmarks/results/folds.json

Small synthetic captures of the kinds that fold most: little paint, paint in patches, knit and
wrinkles, a thin fin on the limb, and a pot with a rim (KINDS says how many of each). Each is
reconstructed from nothing, and its surface measured a second time with folds let be. Counted are
faces turned against those round them, points, edges bent by more than 120 degrees, crossings, and
faces where the surface is no manifold: of the surface as it would have been, of the surface as it
is, and of its STL as it is read back; and both surfaces are laid on the truth. What stands in OUT
already is kept, so that a run that was stopped goes on.
"""

import json
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, ParamSpec, TypeVar
from unittest.mock import patch

import numpy as np

from harness import asking, machine, made_on, table, write
from intervals import SETTINGS, names_placed, options_of, truth_of
from limbgram.core.errors import LimbgramError
from limbgram.core.mesh.folds import Unfolded, find_branching, find_folds
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.run import Run
from limbgram.formats.reading import read_mesh
from limbgram.formats.stl import write_stl
from limbgram.reconstruction.calibration.board import calibrate
from limbgram.reconstruction.measuring.measurement import measure
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
from limbgram.synthetic.props.scan import distance_for, read_scan
from limbgram.synthetic.truth import stage_truth

P = ParamSpec("P")
T = TypeVar("T")

KINDS = {"sparse": 6, "patchy": 4, "knit": 3, "fin": 4, "pot": 3}
"""Captures of each kind."""
FIRST_SEED = 73_000
POT_MM = ((58, 0), (58, 9), (52, 14), (40, 130), (36, 134), (0, 137))
"""Radius and height of the pot's outline, upside down: rim, step, wall, bottom."""
COUNTED = ("turned", "points", "bent", "crossing", "branching")


class Twice(Run):
    """A run that measures each surface a second time, folds let be; `let_be` is the first one's."""

    let_be: Mesh | None = None

    def __call__(self, stage: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        if stage is measure and self.let_be is None:
            with (
                patch("limbgram.reconstruction.measuring.measurement.unfolded", _let_be),
                patch("limbgram.reconstruction.surface.brim.unfolded", _let_be),
            ):
                mesh = super().__call__(stage, *args, **kwargs)
            self.let_be = mesh if isinstance(mesh, Mesh) else None
        return super().__call__(stage, *args, **kwargs)


def _let_be(mesh: Mesh) -> Unfolded:
    return Unfolded(mesh=mesh, vertices=0, farthest_mm=0.0, left=find_folds(mesh))


def main() -> None:
    parser = asking(__doc__)
    parser.add_argument("--kinds", nargs="*", default=list(KINDS), choices=KINDS)
    chosen = parser.parse_args()
    out: Path = chosen.out
    kept: dict[str, Any] = json.loads(out.read_text())["captures"] if out.exists() else {}
    for name, options in captures(chosen.kinds):
        if name not in kept:
            kept[name] = one(options)
            found = {"machine": machine(), "captures": kept}
            write(out, found)
            sys.stderr.write(f"{name}: {kept[name]}\n")


def captures(kinds: list[str]) -> Iterator[tuple[str, CaptureOptions]]:
    """Name and options of each capture."""
    for kind in kinds:
        for number in range(KINDS[kind]):
            seed = FIRST_SEED + 100 * list(KINDS).index(kind) + number
            yield f"{kind} {seed}", options_for(kind, seed)


def options_for(kind: str, seed: int) -> CaptureOptions:
    """A small capture of this kind."""
    if kind in SETTINGS:
        return options_of(seed, kind)
    usual = options_of(seed, "usual")
    if kind == "knit":
        details = SkinDetails(knit_mm=0.1, knit_period_mm=2.0, wrinkles_mm=1.0)
        return replace(usual, details=details, coverage=0.2, photos=16, mesh_step_mm=0.5)
    if kind == "fin":
        return replace(usual, fin_mm=float(np.random.default_rng(seed).uniform(2, 6)), photos=14)
    with tempfile.TemporaryDirectory() as scratch:
        scan = read_scan(write_stl(pot(seed), Path(scratch) / "pot.stl", "mm"))
    distance_mm = distance_for(scan, usual.distance_mm)
    return replace(usual, scan=scan, coverage=0.35, photos=16, distance_mm=distance_mm)


def pot(seed: int) -> Mesh:
    """A pot upside down, each a little wider or higher than the last."""
    random = np.random.default_rng(seed)
    outline = np.array(POT_MM, np.float64) * random.uniform(0.85, 1.1, 2)
    steps = np.linalg.norm(np.diff(outline, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    places = np.linspace(0, along[-1], 120)[:-1]
    radii, heights = (np.interp(places, along, outline[:, k]) for k in range(2))
    turn = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    rings = np.stack(
        [
            np.outer(radii, np.cos(turn)),
            np.outer(radii, np.sin(turn)),
            np.repeat(heights[:, None], len(turn), axis=1),
        ],
        axis=-1,
    ).reshape(-1, 3)
    row, column = np.divmod(np.arange((len(places) - 1) * len(turn)), len(turn))
    beside = (column + 1) % len(turn)
    a, b = row * len(turn) + column, row * len(turn) + beside
    c, d = a + len(turn), b + len(turn)
    last, top = (len(places) - 1) * len(turn), len(rings)
    ends = np.arange(len(turn))
    cap = np.column_stack([last + ends, last + (ends + 1) % len(turn), np.full(len(turn), top)])
    faces = np.concatenate([np.column_stack([a, b, d]), np.column_stack([a, d, c]), cap])
    vertices = np.concatenate([rings, [[0.0, 0.0, outline[-1, 1]]]])
    return Mesh(vertices_mm=vertices, faces=faces.astype(np.int32))


def one(options: CaptureOptions) -> dict[str, Any]:
    """One capture from nothing to what was counted."""
    start = time.process_time()
    with tempfile.TemporaryDirectory() as scratch:
        photos = Path(scratch) / "capture"
        make_capture(photos, options)
        lens = calibrate(read_photos([photos / "calibration"]), CALIBRATION_BOARD.board)
        run = Twice()
        try:
            done = reconstruct(
                Capture(
                    sources=(photos / "images",),
                    calibrations=(lens.calibration,),
                    board=SCALE_BOARD.board,
                ),
                run=run,
            )
        except LimbgramError as refusal:
            return {"refused": str(refusal)}
        assert run.let_be is not None
        views = {view.name: view for view in stage_truth(options).views}
        centres = [views[name].centre_in_world for name in names_placed(done.metric.scene)]
        truth = truth_of(photos / "truth", np.array(centres))
        read = read_mesh(write_stl(done.mesh, Path(scratch) / "surface.stl", "mm"), 1.0)
        found = {
            "triangles": len(done.mesh.faces),
            "filled_share": done.mesh.filled_share(),
            "laid_back": 0 if done.mesh.repairs is None else done.mesh.repairs.laid_back,
            "let_be": counts(run.let_be),
            "after": counts(done.mesh),
            "stl": counts(read),
            "rms_mm": {
                "let_be": rms_mm(run.let_be, done, truth),
                "after": rms_mm(done.mesh, done, truth),
            },
        }
    return found | {"cpu_s": round(time.process_time() - start, 1)}


def counts(mesh: Mesh) -> dict[str, int]:
    """Folds of a surface by kind."""
    folds = find_folds(mesh)
    found = (folds.flipped, folds.spikes, folds.bent, folds.crossing, find_branching(mesh.faces))
    return {name: len(places) for name, places in zip(COUNTED, found, strict=True)}


def rms_mm(mesh: Mesh, done: Reconstruction, truth: Truth) -> float:
    """Distance of the measured surface from the truth, laid on it without changing size."""
    centres = np.array([view.centre_in_world for view in done.metric.scene.views])
    samples = mesh.vertices_mm[measured_samples(mesh)]
    fit = align_by_surface(samples, truth, align_by_cameras(centres, truth))
    measured = mesh.measured
    placed = fit.truth_from_world.apply(mesh.vertices_mm[measured])
    away_mm, seen = signed_mm(placed, truth)
    return float(np.sqrt(np.mean(away_mm[seen] ** 2)))


def page(found: dict[str, Any]) -> str:
    """The counts as a table."""
    rows: list[list[str]] = []
    for name, line in found["captures"].items():
        if "refused" in line:
            rows.append([name, *["refused"] * 7])
            continue
        let_be, after, stl = (line[key] for key in ("let_be", "after", "stl"))
        rows.append(
            [
                name,
                *(str(let_be[key]) for key in COUNTED[:4]),
                str(sum(after.values())),
                str(sum(stl.values())),
                f"{line['rms_mm']['let_be']:.4f}, {line['rms_mm']['after']:.4f}",
            ]
        )
    head = ["capture", *COUNTED[:4], "all, laid back", "in the STL", "RMS mm before, after"]
    return (
        "# Folds of surfaces, let be and laid back\n\n"
        "Faces turned against those round them, points, edges bent by more than 120 degrees and "
        "crossings of surfaces as they were measured; then all of them, and faces where the "
        "surface is no manifold, once folds are laid back, and in the STL as it is read.\n\n"
        f"{table(head, rows)}\n{made_on(found['machine'])}\n"
    )


if __name__ == "__main__":
    main()
