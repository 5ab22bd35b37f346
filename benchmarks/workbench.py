"""The shape workbench on real shapes: seconds, volume kept by smoothing, sections, exports.

python benchmarks/workbench.py SHAPES [-o benchmarks/results/workbench.md]

SHAPES holds ampscan/, openlimb_TT/, homebrew_socket/ and find_template_foot/. Run it on a quiet
machine: a busy one takes longer in seconds of the processor, too.
"""

import compileall
import hashlib
import tempfile
import time
from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

import limbgram
from commands import Rows, Tried, done, run
from harness import asking, machine, made_on, table
from limbgram.core.errors import LimbgramError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import volume_mm3
from limbgram.findings import told
from limbgram.formats.limb_file import write_limb
from limbgram.formats.reading import read_limb
from limbgram.workbench.edits.regions import roughness_mm
from limbgram.workbench.edits.smoothing import Smoothing
from limbgram.workbench.limb import Limb, LimbFrame
from limbgram.workbench.measures.measuring import LimbMeasureOptions, measure_limb

PLANES = 240
SHAPES = {
    "ampscan/stl_file.stl": 1.0,
    "ampscan/stl_file_2.stl": 1.0,
    "ampscan/Example.AOP": 1.0,
    "ampscan/stl_file.aop": 1.0,
    "ampscan/stl_file_2.aop": 1.0,
    "openlimb_TT/Full Size Mean_Limb_Shape.stl": 1.0,
    "openlimb_TT/Full Size Mean_Skin_Shape.stl": 1.0,
    "openlimb_TT/Mean_Skin_Shape.stl": 383.0,
    "openlimb_TT/102m.stl": 383.0,
    "openlimb_TT/102p.stl": 383.0,
    "openlimb_TT/1m20.stl": 383.0,
    "openlimb_TT/1p20.stl": 383.0,
    "find_template_foot/template.obj": 1000.0,
    "homebrew_socket/socket.STL": 1.0,
}
"""Millimetres in one unit of each file."""
EDITS = {
    "load": ["at=patellar tendon", "depth_mm=4", "falloff_mm=20"],
    "relieve": ["at=fibula head", "depth_mm=4", "falloff_mm=20"],
    "reduction": ["heights_mm=[30,150]", "per_cent=[1,3]", "of=girth"],
    "offset": ["distance_mm=1"],
    "smoothing": ["passes=20"],
    "plane-cut": ["height_mm=200"],
    "wall": ["thickness_mm=3", "least_mm=0.01"],
    "mirror": ["confirmed_side=left"],
}
REFINED = {
    "ampscan/stl_file.stl": "ampscan.ply",
    "openlimb_TT/Full Size Mean_Skin_Shape.stl": "openlimb.ply",
}


def main() -> None:
    parser = asking(__doc__, Path(__file__).parent / "results" / "workbench.md")
    parser.add_argument("shapes", type=Path)
    stated = parser.parse_args()
    parts = [
        "# The shape workbench on real shapes",
        f"{made_on(machine())}. Made by `python benchmarks/workbench.py SHAPES`.",
    ]
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        scan, other = (refined(stated.shapes / name, work / out) for name, out in REFINED.items())
        for part in chain(
            smoothed(stated.shapes),
            sections(stated.shapes),
            replays(scan, work),
            replays(other, work),
            commands(scan, work),
        ):
            parts.append(part)
            stated.out.write_text("\n\n".join(parts) + "\n")


def refined(path: Path, out: Path) -> Path:
    """A limb of over 200,000 triangles: each edge halved twice by Loop's rule."""
    coarse = read_limb(path).mesh
    fine = trimesh.Trimesh(coarse.vertices_mm, coarse.faces, process=False).subdivide_loop(2)
    mesh = Mesh(vertices_mm=np.asarray(fine.vertices), faces=fine.faces.astype(np.int32))
    return write_limb(Limb(mesh=mesh), out)


def commands(scan: Path, work: Path) -> Iterator[str]:
    """Seconds of every command, and what the exports say of themselves."""
    mesh = read_limb(scan).mesh
    compileall.compile_dir(Path(limbgram.__file__).parent, quiet=1)
    tried = Tried()
    tried("list of commands", ["--help"])
    tried("start alone: help of measure", ["measure", "--help"])
    tried("align", aligning(scan, mesh))
    tried("measure, 25 levels", ["measure", str(scan)])
    tried("measure, sock of 2 mm off", ["measure", str(scan), "--sock", "2"])
    fit = ["--fit", str(work / "fitted.ply")]
    tried("measure, fit to tape", ["measure", str(scan), *readings(scan), *fit])
    for kind, values in EDITS.items():
        recipe = str(work / f"{kind}.toml")
        done("edit", "new", recipe, "--for", str(scan))
        done("edit", "add", recipe, kind, *values)
        out = str(work / f"{kind}.ply")
        tried(f"edit: {kind}", ["edit", "apply", str(scan), recipe, "-o", out])
    after, recipe = str(work / "reduction.ply"), str(work / "reduction.toml")
    tried("compare, as is", ["compare", str(scan), after, "--align", "as-is"])
    tried("compare, ICP", ["compare", str(scan), after])
    learned = str(work / "learned.json")
    tried("template learn", ["template", "learn", str(scan), after, "-o", learned])
    apply = ["template", "apply", str(scan), learned, "-o", str(work / "applied.ply")]
    tried("template apply", apply)
    told: dict[str, Any] = {}
    for kind in ("stl", "ply", "obj", "glb", "dxf", "aop", "gcode"):
        confirmed = ["--side", "right"] if kind in ("aop", "gcode") else []
        out = str(work / f"out-{kind}.{kind}")
        told[kind] = tried(
            f"export: {kind}", ["export", str(scan), "--to", kind, "-o", out, *confirmed]
        )
    tried("report", ["report", str(scan), "-o", str(work / "record")])
    both = ["--against", str(scan), "--recipe", recipe, "-o", str(work / "record-of-edit")]
    tried("report, comparison and recipe", ["report", after, *both])
    yield f"## Seconds on {len(mesh.faces):,} triangles"
    yield (
        "Whole command: a new process, with its start and the reading of the shape. In a running "
        "process: the same once more where it has run before. CPU: of the processor, all threads. "
        "What an installation compiles (bytecode, kernels) is compiled."
    )
    heads = ("command", "whole: CPU", "wall", "running: CPU", "wall", "exit")
    yield table(heads, tried.rows)
    yield from (f"**{name}** answered: {text}" for name, text in tried.refused)
    yield "## What the exports cost"
    yield table(("format", "figure", "value"), list(costs(told)))


def aligning(scan: Path, mesh: Mesh) -> list[str]:
    """The command that aligns the limb, with four landmarks on its surface."""
    low, high = (float(f(mesh.vertices_mm[:, 2])) for f in (np.min, np.max))
    x0, y0 = mesh.vertices_mm[:, :2].mean(0)
    wanted = {
        "tibial tubercle": (x0, y0 + 60, (low + high) / 2),
        "patellar tendon": (x0, y0 + 60, (low + 2 * high) / 3),
        "fibula head": (x0 + 50, y0, (low + high) / 2),
        "tibia end": (x0, y0 + 30, low + 20),
    }
    stated = ["align", str(scan), "--side", "right", "--axis", "+z", "--anterior", "+y"]
    for name, place in wanted.items():
        x, y, z = mesh.vertices_mm[np.linalg.norm(mesh.vertices_mm - place, axis=1).argmin()]
        stated += ["--landmark", f"{name}={x},{y},{z}"]
    return stated


def costs(told: dict[str, Any]) -> Iterator[Sequence[str]]:
    wanted = {
        "aop": ("max_mm", "rms_mm", "volume_change", "girth_change_mm"),
        "gcode": ("gouge_mm", "scallop_mm", "left_mm", "left_share", "rapid_hits", "minutes"),
    }
    for kind, names in wanted.items():
        yield from ((kind, name, f"{told[kind].get(name, float('nan')):.5g}") for name in names)


def readings(scan: Path) -> list[str]:
    """Tape readings 1 % over the shape's own girths, at two heights."""
    heights = ("100", "200")
    told = done("measure", str(scan), *chain(*(("--height", height) for height in heights)))
    girths = [row["tape_mm"]["value"] * 1.01 for row in told["levels"]]
    pairs = zip(heights, girths, strict=True)
    return list(chain(*(("--tape", f"{height}={girth:.2f}") for height, girth in pairs)))


def replays(scan: Path, work: Path) -> Iterator[str]:
    """One recipe of several edits, replayed with one thread and with two."""
    mesh = read_limb(scan).mesh
    done(*aligning(scan, mesh))
    recipe = str(work / f"{scan.stem}-several.toml")
    done("edit", "new", recipe, "--for", str(scan))
    for kind in ("smoothing", "reduction", "load"):
        done("edit", "add", recipe, kind, *EDITS[kind])
    hashes: Rows = []
    for number, threads in enumerate(("1", "2", "2"), 1):
        out = work / f"{scan.stem}-replayed-{number}.ply"
        answer = run("edit", "apply", str(scan), recipe, "-o", str(out), threads=threads)
        if answer.returncode:
            raise SystemExit(f"The replay was refused: {answer.stderr}{answer.stdout}")
        hashes.append((str(number), threads, hashlib.sha256(out.read_bytes()).hexdigest()))
    same = len({row[2] for row in hashes}) == 1
    yield f"## Replay of a recipe of three edits: {scan.stem}, {len(mesh.faces):,} triangles"
    yield f"The files are {'the same, byte by byte' if same else 'DIFFERENT'}."
    yield table(("run", "threads", "SHA-256 of the result"), hashes)


def smoothed(folder: Path) -> Iterator[str]:
    """Twenty passes of smoothing: the volume they cost, and what they do to the surface."""
    rows: Rows = []
    for name, unit in SHAPES.items():
        limb = read_limb(folder / name, unit)
        try:
            calm = Smoothing(passes=20).apply(limb)
        except LimbgramError as error:
            rows.append((name, "-", "-", str(error).split(". ")[0]))
            continue
        change = volume_mm3(calm.mesh) / volume_mm3(limb.mesh) - 1
        rough = [roughness_mm(one.mesh) for one in (limb, calm)]
        rows.append((name, f"{change:+.2e}", f"{rough[0]:.4f} to {rough[1]:.4f}", ""))
    yield "## Twenty passes of smoothing"
    yield table(("shape", "volume, share", "roughness, mm", "refused"), rows)


def sections(folder: Path) -> Iterator[str]:
    """Planes from just above the lowest point to just below the highest one."""
    rows: Rows = []
    for name, unit in SHAPES.items():
        limb = read_limb(folder / name, unit)
        low, high = (float(f(limb.mesh.vertices_mm[:, 2])) for f in (np.min, np.max))
        up = Rigid(np.eye(3), np.array([0.0, 0.0, -low]))
        limb = limb.with_frame(LimbFrame(limb_from_mesh=up, side="none"))
        heights = tuple(np.linspace(0.01, high - low - 0.01, PLANES))
        start = time.process_time()
        found = measure_limb(limb, LimbMeasureOptions(heights_mm=heights)).rows
        spent = time.process_time() - start
        answers = [row for row in found if row.level is not None]
        refused = ["; ".join(map(told, row.reasons)) for row in found if row.level is None]
        silent = sum(not reason for reason in refused) + PLANES - len(found)
        reasons = "; ".join(sorted({reason.split(". ")[0].split(":")[0] for reason in refused}))
        rows.append((name, str(len(answers)), str(len(refused)), str(silent), f"{spent:.2f}",
                     reasons[:160]))  # fmt: skip
    yield f"## {PLANES} planes across each shape's own z"
    yield table(("shape", "answers", "named errors", "silent gaps", "s", "errors"), rows)


if __name__ == "__main__":
    main()
