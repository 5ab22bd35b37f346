"""From photos to a device, against the truth: feet with shanks, and a trunk.

    python benchmarks/device_photos.py DATA -o benchmarks/results/device_photos.json

A limb of exact landmarks (limbs.py) is painted, photographed by the project's own generator (upside
down, on the end where it is cut) and reconstructed once. Two feet also have a magenta mark painted
on each landmark: the marks are found in the photos, and those that are not are laid on by hand; the
angles by them, with their intervals, are held against those of the truth. The landmarks are laid on
the surface with a stated error along it, drawn by 40 seeds; the angles of each draw are held
against the truth likewise, and by how much each landmark turns them is told. With landmarks without
error: lengths and girths; a joint turned as the workbench does it, against the same turn of the
truth about the true axis, away from the band, and what of that the turn itself adds. At last a
device is made of the first draw through the program's service, and its 3MF read back: the
thickness, measured from the positive, against what was asked; PrusaSlicer. What stands in OUT is
kept, and captures under --keep too, so that a run that was stopped goes on.
"""

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from devices import sliced, slicer
from harness import asking, machine, made_on, table, write
from intervals import names_placed, truth_of
from limbgram.core.errors import LimbgramError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh, dots, unit
from limbgram.core.mesh.topology import boundary_loops
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.formats.limb_file import write_limb
from limbgram.formats.reading import read_mesh, read_shape
from limbgram.reconstruction.calibration.board import calibrate
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.pipeline import Capture, reconstruct
from limbgram.report.alignment import (
    align_by_cameras,
    align_by_surface,
    measured_samples,
    signed_mm,
)
from limbgram.services.make_device import MakeDeviceRequest, make
from limbgram.synthetic import (
    MAGENTA,
    BentShape,
    CaptureOptions,
    SockSpot,
    distance_for,
    make_capture,
    places_mm,
    stage_truth,
)
from limbgram.synthetic.props.board import CALIBRATION_BOARD, SCALE_BOARD
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.fill import Fill
from limbgram.workbench.edits.repose import JointTurn, Repose
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame
from limbgram.workbench.marks import PaintedMark, find_painted_marks
from limbgram.workbench.measures.sheet import SheetOptions, measuring_sheet
from limbgram.workbench.recipe.file import encode_recipe
from limbgram.workbench.recipe.recipe import Entry, Recipe
from limbs import body_of, ten_of, trunk_of

DRAWS = 40
PLACED_MM: Final = (0.5, 2.0)
"""Stated errors of landmarks: a small mark that was painted on the skin, and a click."""
MARK_OFF_MM = 2.0
"""A mark found farther than this from a landmark is not its mark."""
WITHIN_DEG = 0.5
WITHIN_MM = 0.3
THICKNESS_MM = 0.05
SHARE = 0.95
ELEVATIONS_DEG: Final = (28.0, 50.0, 2.0)
"""Of the rings of photos. The last looks level: nothing else sees the back of a foot that is held
up, nor the armpits of a trunk."""
UPSIDE_DOWN = np.diag([1.0, -1.0, -1.0])


@dataclass(frozen=True, kw_only=True)
class Case:
    """What is photographed, and what is made of it."""

    name: str
    kind: str
    seed: int
    tilt_deg: float
    """By which the toes are raised, so that no side looks away from all photos."""
    pole: str
    """Landmark at which the rings of the chart close; empty: the highest place."""
    turn: Repose
    device: str
    values: tuple[tuple[str, float], ...]
    mark_mm: float | None = None
    """Diameter of the marks that are painted on its landmarks; None: it has none."""


_UNMARKED: Final = (
    Case(
        name="foot of the child",
        kind="foot",
        seed=81_001,
        tilt_deg=12.0,
        pole="second toe",
        turn=Repose(joint="ankle", by_deg=6.0),
        device="solid-afo",
        values=(("wall_mm", 4.0), ("wall_lateral_mm", 22.0), ("wall_medial_mm", 25.0)),
    ),
    Case(
        name="foot of the woman, x 0.75",
        kind="foot",
        seed=81_002,
        tilt_deg=12.0,
        pole="second toe",
        turn=Repose(joint="ankle", by_deg=-6.0),
        device="posterior-leaf-spring",
        values=(
            ("wall_mm", 4.0),
            ("wall_lateral_mm", 22.0),
            ("wall_medial_mm", 25.0),
            ("spring_height_mm", 21.0),
            ("spring_width_mm", 24.0),
        ),
    ),
    Case(
        name="trunk of the child, x 0.65",
        kind="torso",
        seed=81_003,
        tilt_deg=0.0,
        pole="",
        turn=Repose(joint="side bend", by_deg=5.0, band_mm=60.0),
        device="tlso-front",
        values=(("wall_mm", 4.0), ("waist_strap_mm", 25.0)),  # as narrow as the trunk is small
    ),
)

CASES: Final = (
    *_UNMARKED,
    replace(_UNMARKED[0], name=f"{_UNMARKED[0].name}, marked", mark_mm=6.0),
    replace(_UNMARKED[1], name=f"{_UNMARKED[1].name}, marked", mark_mm=8.0),
)


def main() -> None:
    parser = asking(__doc__, keep="captures, surfaces and devices")
    parser.add_argument("data", type=Path)
    parser.add_argument("--only", nargs="*", type=int, help="these cases, from 0")
    parser.add_argument("--photos", type=int, default=32)
    parser.add_argument("--width", type=int, default=3000, help="of a photo, in pixels")
    chosen = parser.parse_args()
    result: dict[str, Any] = {"machine": machine(), "slicer": slicer(), "cases": {}}
    if chosen.out.exists():
        result["cases"] = json.loads(chosen.out.read_text())["cases"]
    with tempfile.TemporaryDirectory() as scratch:
        for number, case in enumerate(CASES):
            name = f"{case.name}, {chosen.width} px"
            if (chosen.only and number not in chosen.only) or name in result["cases"]:
                continue
            folder = (chosen.keep or Path(scratch)) / f"case{number}, {chosen.width} px"
            folder.mkdir(parents=True, exist_ok=True)
            start = time.process_time()
            found = one(case, chosen, folder)
            found["cpu_s"] = round(time.process_time() - start)
            found["commit"] = result["machine"]["commit"]
            result["cases"][name] = found
            write(chosen.out, result)
            sys.stderr.write(f"{name}: {json.dumps(found)[:2000]}\n")


def one(case: Case, chosen: argparse.Namespace, folder: Path) -> dict[str, Any]:
    """One limb, from photos to device."""
    stood = _stood(_limb(case, chosen.data), case)
    options = CaptureOptions(
        scan=stood.shape,
        seed=case.seed,
        photos=chosen.photos,
        rings=len(ELEVATIONS_DEG),
        elevations_deg=ELEVATIONS_DEG,
        width_px=chosen.width,
        height_px=chosen.width * 2 // 3,
        distance_mm=distance_for(stood.shape, CaptureOptions.distance_mm),
        calibration_photos=10,
        mesh_step_mm=1.2,
        samples=2,
    )
    skin = stage_truth(options).limb
    lift = np.array([0.0, 0.0, skin.base_mm])
    true_mesh = skin.mesh
    places = {name: place + lift for name, place in stood.places.items()}
    nearest = tree_on(true_mesh).closest(np.stack([*places.values()]))
    true = dict(zip(places, nearest.points_mm, strict=True))
    if case.mark_mm is not None:
        options = replace(
            options,
            spots=tuple(
                SockSpot(near_mm=tuple(place.tolist()), diameter_mm=case.mark_mm)
                for place in places.values()
            ),
        )
        true = dict(zip(places, places_mm(skin, options.spots), strict=True))
    try:
        surface = _reconstructed(options, folder)
    except LimbgramError as refusal:
        return {"refused": str(refusal)}
    mesh, found = surface.mesh, surface.figures
    exact = _limb_of(case, true_mesh, true, None, stood.limb_from_world(lift))
    measured = _limb_of(case, mesh, surface.laid(true), 1e-3, stood.limb_from_world(lift))
    found["landmarks_off_mm"] = surface.off_mm(true)
    if case.mark_mm is not None:
        found["marked"] = _marked(exact, surface, true)
    found["measures"] = _measures(exact, measured)
    found["angles"] = {f"{sigma:g} mm": _angles(exact, surface, true, sigma) for sigma in PLACED_MM}
    found["by_landmark"] = _by_landmark(exact)
    found["turned"] = _turned(case, exact, measured)
    found["device"] = _device(case, measured, folder)
    return found


@dataclass(frozen=True)
class _Stood:
    """A limb as it stands to be photographed."""

    shape: BentShape
    places: dict[str, np.ndarray]
    turn: np.ndarray
    start_mm: np.ndarray

    def limb_from_world(self, lift: np.ndarray) -> Rigid:
        """Back to the limb frame that it was cut out in."""
        return Rigid(self.turn.T.copy(), self.turn.T @ (self.start_mm - lift))


def _limb(case: Case, data: Path) -> Limb:
    if case.kind == "torso":
        size = 0.65
        limb = trunk_of(body_of(data, "child"), body_of(data, "adult_male"))
        return _scaled(limb, size)
    wanted = "child, right" if case.seed == CASES[0].seed else "adult_female, right"
    limb = next(one for one in ten_of("foot", data) if one.name == wanted).make()
    return limb if "x" not in case.name.split() else _scaled(limb, 0.75)


def _scaled(limb: Limb, size: float) -> Limb:
    marks = tuple(replace(one, position_mm=size * one.position_mm) for one in limb.landmarks)
    return replace(limb.with_mesh(limb.mesh.with_vertices(size * limb.mesh.vertices_mm)),
                   landmarks=marks)  # fmt: skip


def _stood(limb: Limb, case: Case) -> _Stood:
    """Upside down or upright, cut level, on the origin."""
    tilt = Rigid.from_rotation_vector(np.array([-np.radians(case.tilt_deg), 0, 0]), np.zeros(3))
    turn = tilt.rotation @ UPSIDE_DOWN if case.kind == "foot" else np.eye(3)
    mesh = limb.mesh.with_vertices(limb.mesh.vertices_mm @ turn.T)
    loops = boundary_loops(mesh.faces)
    rim = min(loops, key=lambda loop: float(mesh.vertices_mm[loop, 2].mean()))
    low = float(mesh.vertices_mm[rim, 2].max()) + 0.5
    mesh = keep_positive(mesh, mesh.vertices_mm[:, 2] - low).mesh
    if len(loops) > 1:
        mesh = _closed_above(mesh, low)
    rim = boundary_loops(mesh.faces)[0]
    start = np.array([*mesh.vertices_mm[rim, :2].mean(0), low])
    mesh = mesh.with_vertices(mesh.vertices_mm - start)
    places = {one.name: turn @ one.position_mm - start for one in limb.landmarks}
    highest = mesh.vertices_mm[:, 2].max()
    aim = places[case.pole] if case.pole else np.array([0.0, 0.0, highest])
    shape = BentShape(
        sha256=case.name,
        side="right" if case.kind == "foot" else "none",
        mesh=Mesh(vertices_mm=mesh.vertices_mm, faces=mesh.faces),
        pole=int(np.linalg.norm(mesh.vertices_mm - aim, axis=1).argmin()),
    )
    return _Stood(shape, places, turn, start)


def _closed_above(mesh: Mesh, low: float) -> Mesh:
    """Without its openings but the lowest."""
    filled = do_edit(Limb(mesh=mesh), Fill(brim=True)).mesh
    return keep_positive(filled, filled.vertices_mm[:, 2] - low - 0.5).mesh


@dataclass(frozen=True)
class _Surface:
    """A reconstruction, in the truth's frame."""

    mesh: Mesh
    figures: dict[str, Any]
    marks: tuple[PaintedMark, ...]
    """Found in the photos."""

    def laid(self, true: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The true landmarks on the surface."""
        found = tree_on(self.mesh).closest(np.stack(list(true.values()))).points_mm
        return dict(zip(true, found, strict=True))

    def off_mm(self, true: dict[str, np.ndarray]) -> dict[str, float]:
        found = tree_on(self.mesh).closest(np.stack(list(true.values()))).distances_mm
        return {name: float(off) for name, off in zip(true, found, strict=True)}

    def drawn(
        self, true: dict[str, np.ndarray], sigma_mm: float, rng: np.random.Generator
    ) -> dict[str, np.ndarray]:
        """Landmarks with an error of this size in each direction along the surface."""
        places = np.stack(list(self.laid(true).values()))
        faces = tree_on(self.mesh).closest(places).faces
        normals = unit(self.mesh.vertex_normals()[self.mesh.faces[faces]].sum(1))
        error = rng.normal(0.0, sigma_mm, places.shape)
        error -= dots(error, normals)[:, None] * normals
        found = tree_on(self.mesh).closest(places + error).points_mm
        return dict(zip(true, found, strict=True))


def _reconstructed(options: CaptureOptions, folder: Path) -> _Surface:
    """The photos' surface, laid on the truth without changing size."""
    photos = folder / "capture"
    if not photos.exists():
        make_capture(photos, options)
    lens = calibrate(read_photos([photos / "calibration"]), CALIBRATION_BOARD.board)
    start = time.process_time()
    done = reconstruct(
        Capture(
            sources=(photos / "images",),
            calibrations=(lens.calibration,),
            board=SCALE_BOARD.board,
        )
    )
    views = {view.name: view for view in stage_truth(options).views}
    centres = np.array([views[name].centre_in_world for name in names_placed(done.metric.scene)])
    truth = truth_of(photos / "truth", centres)
    own = np.array([view.centre_in_world for view in done.metric.scene.views])
    samples = done.mesh.vertices_mm[measured_samples(done.mesh)]
    fit = align_by_surface(samples, truth, align_by_cameras(own, truth)).truth_from_world
    mesh = done.mesh.with_vertices(fit.apply(done.mesh.vertices_mm))
    measured = mesh.measured
    away_mm, seen = signed_mm(mesh.vertices_mm[measured], truth)
    write_limb(Limb(mesh=mesh), folder / "surface.ply")
    placed = [done.photos.photos[k] for k in done.metric.scene.placed]
    seen_marks = find_painted_marks(placed, done.metric.scene.views, done.mesh, MAGENTA)
    marks = tuple(
        replace(one, position_mm=fit.apply(one.position_mm[None])[0]) for one in seen_marks.marks
    )
    figures = {
        "photos": options.photos,
        "placed": len(centres),
        "width_px": options.width_px,
        "rms_mm": float(np.sqrt(np.mean(away_mm[seen] ** 2))),
        "p95_mm": float(np.quantile(np.abs(away_mm[seen]), 0.95)),
        "filled": float(1 - measured.mean()),
        "vertices": len(mesh),
        "reconstruct_cpu_s": round(time.process_time() - start),
    }
    return _Surface(mesh, figures, marks)


def _limb_of(
    case: Case, mesh: Mesh, places: dict[str, np.ndarray], sigma_mm: float | None, frame: Rigid
) -> Limb:
    return AlignedLimb(
        mesh=mesh,
        kind=case.kind,
        frame=LimbFrame(limb_from_mesh=frame, side="right" if case.kind == "foot" else "none"),
        landmarks=tuple(
            Landmark(name=name, position_mm=at, placed="painted", sigma_mm=sigma_mm)
            for name, at in places.items()
        ),
    )


def _measures(exact: Limb, measured: Limb) -> dict[str, Any]:
    """Lengths, girths and angles with landmarks without error."""
    names = tuple(
        one.name for one in exact.anatomy.kind.sheet if one.name.endswith(("_mm", "_deg"))
    )
    rows = [
        {row.name: row.figure for row in measuring_sheet(one, SheetOptions(only=names)).rows}
        for one in (exact, measured)
    ]
    found: dict[str, Any] = {}
    for name in names:
        true, own = rows[0].get(name), rows[1].get(name)
        if true is None:
            continue
        found[name] = (
            None
            if own is None
            else {"true": true.value, "off": own.value - true.value, "sigma": own.sigma}
        )
    return found


def _marked(exact: Limb, surface: _Surface, true: dict[str, np.ndarray]) -> dict[str, Any]:
    """How well the painted marks were found, and the angles by them.

    A mark that too few photos show is laid on the surface by hand, with the smaller stated error.
    """
    marks: list[Landmark] = []
    found: dict[str, Any] = {"missed": []}
    by_hand = surface.drawn(true, PLACED_MM[0], np.random.default_rng(33))
    for name, at in true.items():
        away = {float(np.linalg.norm(one.position_mm - at)): one for one in surface.marks}
        off_mm = min(away, default=np.inf)
        if off_mm > MARK_OFF_MM:
            found["missed"].append(name)
            marks.append(Landmark(name=name, position_mm=by_hand[name], sigma_mm=PLACED_MM[0]))
            continue
        mark = away[off_mm]
        found[name] = {"off_mm": off_mm, "sigma_mm": mark.sigma_mm, "photos": len(mark.photos)}
        marks.append(
            Landmark(
                name=name,
                position_mm=mark.position_mm,
                placed="painted",
                sigma_mm=mark.sigma_mm,
            )
        )
    names = tuple(one.name for one in exact.anatomy.kind.sheet if one.name.endswith("_deg"))
    limb = replace(exact.with_mesh(surface.mesh), landmarks=tuple(marks))
    own = {one.name: one.figure for one in measuring_sheet(limb, SheetOptions(only=names)).rows}
    angles: dict[str, Any] = {}
    for row in measuring_sheet(exact, SheetOptions(only=names)).rows:
        figure = own.get(row.name)
        if row.figure is None:
            continue
        if figure is None or figure.interval is None:
            angles[row.name] = None
            continue
        off = figure.value - row.figure.value
        angles[row.name] = {
            "off_deg": off,
            "sigma_deg": figure.sigma,
            "held": bool(-figure.interval.above <= off <= figure.interval.below),
        }
    return {"marks": found, "angles": angles}


def _angles(
    exact: Limb, surface: _Surface, true: dict[str, np.ndarray], sigma_mm: float
) -> dict[str, Any]:
    """Errors and intervals of the angles over the draws."""
    names = tuple(one.name for one in exact.anatomy.kind.sheet if one.name.endswith("_deg"))
    options = SheetOptions(only=names)
    rows = measuring_sheet(exact, options).rows
    truth = {row.name: row.figure.value for row in rows if row.figure is not None}
    known = [name for name in names if name in truth]
    off: dict[str, list[float]] = {name: [] for name in known}
    held: dict[str, list[bool]] = {name: [] for name in known}
    for seed in range(DRAWS):
        rng = np.random.default_rng((seed, 33, round(1000 * sigma_mm)))
        marks = tuple(
            Landmark(name=name, position_mm=at, placed="painted", sigma_mm=sigma_mm)
            for name, at in surface.drawn(true, sigma_mm, rng).items()
        )
        limb = replace(exact.with_mesh(surface.mesh), landmarks=marks)
        sheet = measuring_sheet(limb, replace(options, only=tuple(known)))
        for row in sheet.rows:
            if row.figure is None or row.figure.interval is None:
                continue
            error = row.figure.value - truth[row.name]
            off[row.name].append(error)
            held[row.name].append(
                bool(-row.figure.interval.above <= error <= row.figure.interval.below)
            )
    return {
        name: {
            "true_deg": truth[name],
            "draws": len(off[name]),
            "rms_deg": float(np.sqrt(np.mean(np.square(off[name])))),
            "within": float(np.mean(np.abs(off[name]) <= WITHIN_DEG)),
            "held": float(np.mean(held[name])),
        }
        for name in known
        if off[name]
    }


def _by_landmark(exact: Limb) -> dict[str, dict[str, float]]:
    """By how many degrees each angle of the truth changes for a millimetre of each landmark, in the
    direction along the surface in which it changes most."""
    names = tuple(one.name for one in exact.anatomy.kind.sheet if one.name.endswith("_deg"))
    found: dict[str, dict[str, float]] = {name: {} for name in names}
    for moved in exact.landmarks:
        marks = tuple(
            replace(one, sigma_mm=1.0 if one is moved else 0.0) for one in exact.landmarks
        )
        for row in measuring_sheet(replace(exact, landmarks=marks), SheetOptions(only=names)).rows:
            if row.placing_sigma:
                found[row.name][moved.name] = row.placing_sigma
    return {
        name: dict(sorted(slopes.items(), key=lambda one: -one[1]))
        for name, slopes in found.items()
    }


def _turned(case: Case, exact: Limb, measured: Limb) -> dict[str, Any]:
    """The turned surface against the truth, turned about its own axis; away from the band.

    `added` is what the turn itself adds: how far a measured vertex lies from where the truth's own
    turn takes it. The rest is what the surface was off before.
    """
    turn = replace(case.turn, beyond=True)
    there, own = do_edit(exact, turn), do_edit(measured, turn)
    plan, own_plan = (
        JointTurn.of(one.anatomy, turn.joint, turn.by_deg * one.anatomy.mirror_sign(), turn.band_mm)
        for one in (exact, measured)
    )
    shares = plan.shares(measured.mesh.vertices_mm)
    exactly_mm = plan.applied(measured.mesh.vertices_mm)
    added_mm = np.linalg.norm(own_plan.applied(measured.mesh.vertices_mm) - exactly_mm, axis=1)
    seen = measured.mesh.measured
    found: dict[str, Any] = {"joint": turn.joint, "by_deg": turn.by_deg}
    for name, part in (
        ("distal", shares >= 1 - 1e-9),
        ("proximal", shares <= 1e-9),
        ("band", (shares > 1e-9) & (shares < 1 - 1e-9)),
    ):
        chosen = seen & part
        away = tree_on(there.mesh).closest(own.mesh.vertices_mm[chosen]).distances_mm
        before = tree_on(exact.mesh).closest(measured.mesh.vertices_mm[chosen]).distances_mm
        found[name] = {
            "vertices": int(chosen.sum()),
            "within": float(np.mean(away <= WITHIN_MM)),
            "p99_mm": float(np.quantile(away, 0.99)),
            "largest_mm": float(away.max()),
            "p99_before_mm": float(np.quantile(before, 0.99)),
            "within_before": float(np.mean(before <= WITHIN_MM)),
            "added_p99_mm": float(np.quantile(added_mm[chosen], 0.99)),
            "added_largest_mm": float(added_mm[chosen].max()),
        }
    return found


def _device(case: Case, limb: Limb, folder: Path) -> dict[str, Any]:
    """Through the service, as files; read back."""
    shape = write_limb(limb, folder / "limb.ply")
    recipe = folder / "recipe.toml"
    recipe.write_bytes(encode_recipe(Recipe(name="", entries=(Entry(edit=case.turn),))))
    ask = MakeDeviceRequest(device=case.device, made="printed", values=case.values, recipe=recipe)
    try:
        made = make(read_shape(shape, 1.0), ask, folder / "device")
    except LimbgramError as refusal:
        return {"name": case.device, "refused": str(refusal)}
    written = next(one for one in made.written if one.suffix == ".3mf")
    solid = read_mesh(written, 1.0)
    preview = made.made.preview
    layout = preview.layout
    asked = dict(case.values)["wall_mm"]
    shift = made.made.solid.vertices_mm.min(0) - solid.vertices_mm.min(0)
    found = tree_on(layout.positive).closest(solid.vertices_mm + shift)
    corners = layout.positive.faces[found.faces]
    beyond = layout.beyond_mm[corners].max(1)
    thick = layout.thickness_mm[corners]
    wall = (beyond < -1.5 * asked) & (found.distances_mm > 0.7 * asked)
    wall &= np.ptp(thick, axis=1) < 1e-6
    wall &= np.abs(thick[:, 0] - asked) < 1e-6
    off = np.abs(found.distances_mm[wall] - asked)
    return {
        "name": case.device,
        "refused": None,
        "asked_mm": asked,
        "off_mm": made.made.wall.off_mm,
        "outer_vertices": int(wall.sum()),
        "outer_off_p99_mm": float(np.quantile(off, 0.99)),
        "triangles": len(solid.faces),
        "files": [one.name for one in made.written],
        **sliced(written, folder / "sliced.gcode"),
    }


def page(result: dict[str, Any]) -> str:
    """The figures for people."""
    cases: dict[str, Any] = result["cases"]
    parts = ["# From photos to a device", made_on(result["machine"])]
    good = {name: one for name, one in cases.items() if "refused" not in one}
    parts += [
        f"{name}: refused. {one['refused']}" for name, one in cases.items() if name not in good
    ]
    parts += [f"{case.name}: not run." for case in CASES if case.name not in cases]
    parts.append(
        table(
            ("limb", "photos placed", "RMS mm", "95 % mm", "CPU s", "commit"),
            [
                (name, f"{one['placed']} of {one['photos']}", f"{one['rms_mm']:.3f}",
                 f"{one['p95_mm']:.3f}", str(one["cpu_s"]), one["commit"][:12])
                for name, one in good.items()
            ],
        )
    )  # fmt: skip
    for name, one in good.items():
        measures = [*_angles_drawn(one), *_measures_drawn(one["measures"])]
        parts += [
            f"## {name}",
            *measures,
            _turned_drawn(one["turned"]),
            _device_drawn(one["device"]),
        ]
    return "\n\n".join(parts) + "\n"


def _angles_drawn(one: dict[str, Any]) -> Iterator[str]:
    """Angles with their intervals, and what they hang on."""
    for placed, angles in one["angles"].items():
        held = np.mean([row["held"] for row in angles.values()])
        within = np.mean([row["within"] for row in angles.values()])
        yield (
            f"Landmarks placed with {placed} along the surface, {DRAWS} draws: intervals of "
            f"95 % hold in {held:.1%}; within {WITHIN_DEG} degrees {within:.1%}."
        )
        yield table(
            ("angle", "true", "RMS of the error", f"within {WITHIN_DEG}", "held"),
            [
                (angle, f"{row['true_deg']:.2f}", f"{row['rms_deg']:.2f}",
                 f"{row['within']:.0%}", f"{row['held']:.1%}")
                for angle, row in angles.items()
            ],
        )  # fmt: skip
    yield table(
        ("angle", "landmarks that it hangs on most, degrees for a millimetre"),
        [
            (angle, ", ".join(f"{name} {by:.2f}" for name, by in [*slopes.items()][:4]))
            for angle, slopes in one["by_landmark"].items()
            if slopes
        ],
    )


def _measures_drawn(measures: dict[str, Any]) -> Iterator[str]:
    """Measures from landmarks without error, against the truth."""
    off = {key: row for key, row in measures.items() if row is not None}
    lost = [key for key, row in measures.items() if row is None]
    for ending, most, unit_is in (("_mm", WITHIN_MM, "mm"), ("_deg", WITHIN_DEG, "degrees")):
        own = [abs(row["off"]) for key, row in off.items() if key.endswith(ending)]
        yield (
            f"Landmarks without error: {sum(one <= most for one in own)} of {len(own)} "
            f"within {most} {unit_is}."
        )
    if lost:
        yield f"Not measured on the surface: {', '.join(lost)}."
    yield table(
        ("measure", "true", "error", "sigma"),
        [
            (key, f"{row['true']:.2f}", f"{row['off']:+.3f}",
             "" if row["sigma"] is None else f"{row['sigma']:.3f}")
            for key, row in off.items()
        ],
    )  # fmt: skip


def _turned_drawn(turned: dict[str, Any]) -> str:
    return (
        f"{turned['joint']} turned by {turned['by_deg']:g} degrees, against the truth turned: "
        + "; ".join(
            f"{part} {turned[part]['within']:.1%} within {WITHIN_MM} mm "
            f"({turned[part]['within_before']:.1%} before the turn), "
            f"{turned[part]['p99_mm']:.3f} mm in 99 % "
            f"({turned[part]['p99_before_mm']:.3f} before the turn), "
            f"{turned[part]['largest_mm']:.3f} at most; the turn adds "
            f"{turned[part]['added_p99_mm']:.3f} in 99 % and "
            f"{turned[part]['added_largest_mm']:.3f} at most"
            for part in ("distal", "proximal", "band")
        )
        + "."
    )


def _device_drawn(device: dict[str, Any]) -> str:
    if device["refused"]:
        return f"{device['name']}: refused. {device['refused']}"
    return (
        f"{device['name']}, printed, {device['asked_mm']:g} mm: off by "
        f"{device['off_mm']:.3f} mm in 99 of 100 places by its own proof, "
        f"{device['outer_off_p99_mm']:.3f} mm of the 3MF's outer side from the positive; "
        f"PrusaSlicer: manifold {'yes' if device['manifold'] else 'no'}, "
        f"{'repaired' if device['repaired'] else 'no repair'}, "
        f"{'sliced' if device['sliced'] else 'not sliced'}."
    )


if __name__ == "__main__":
    main()
