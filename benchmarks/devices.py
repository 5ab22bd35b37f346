"""Devices: every kind on ten limbs, and from photos to a device, against the truth.

    python benchmarks/devices.py limbs DATA -o benchmarks/results/device_limbs.json
    python benchmarks/devices.py pictures DATA

`limbs`: each device of the presets on the ten limbs of its kind (limbs.py), printed. Counted is
what came of it: one closed solid without crossings (the program's own proof), its thickness against
what was asked, and whether PrusaSlicer reads the 3MF as manifold and slices it without a repair; or
the refusal, with its place. Measures are the usual ones, scaled with the body within their ranges,
but for the wall, the distances of a trunk's slots from edges, and what yields to a slender limb.
What stands in OUT already is kept, with its commit, so that a run that was stopped goes on; --again
NAME makes a device anew.

`pictures`: orthoses.png and sockets.png of docs/clinic, each device on the first limb of its kind,
printed in one thickness, from its side and from its front.
"""

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import textwrap
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

import matplotlib
import numpy as np
from matplotlib import pyplot as plt

from harness import described, machine, made_on, table, write
from limbgram.core.errors import LimbgramError
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.threemf import Told, write_3mf
from limbgram.report.drawings.shading import Frame, looking_along, shade_all
from limbgram.services.make_device import bed_from
from limbgram.workbench.devices.device import Device, devices
from limbgram.workbench.devices.making import Order, make_device
from limbgram.workbench.devices.presets.straps import CALF_STRAP, OPENING_STRAPS
from limbs import Subject, ten_of

CLINIC = Path(__file__).resolve().parents[1] / "docs" / "clinic"
PICTURES: Final = {"orthoses": ("foot", "torso"), "sockets": ("transtibial", "transfemoral")}
COLUMNS: Final = 5
SIDE_PX: Final = 420
WALL_MM = {"foot": 5.0, "torso": 5.0}
"""Printed, and thicker than usual: a coarser grid takes a third of the time of the usual wall's."""
GIVEN: Final = {"ramus_deg": 30.0, "skeletal_ml_mm": 140.0}
"""What nobody may guess."""
OFF_MM = 0.05
SLICED = ("--export-gcode", "--bed-shape", "0x0,800x0,800x800,0x800", "--center", "400,400",
          "--max-print-height", "1200", "--layer-height", "1.6", "--first-layer-height", "1.6",
          "--nozzle-diameter", "2.0", "--perimeters", "1", "--fill-density", "0%",
          "--top-solid-layers", "0", "--bottom-solid-layers", "0",
          "--skirts", "0", "--loglevel", "2")  # fmt: skip
"""Thick layers without filling, in half of the time: what is asked is whether it can be sliced."""


def main() -> None:
    parser = described(__doc__)
    modes = parser.add_subparsers(dest="mode", required=True)
    on_limbs = modes.add_parser("limbs")
    on_limbs.add_argument("--again", nargs="*", default=[], help="make these devices anew")
    on_limbs.add_argument("--only", nargs="*", default=[], help="these devices alone")
    on_limbs.add_argument("--keep", type=Path, help="keep the 3MF files here")
    on_limbs.add_argument("data", type=Path)
    on_limbs.add_argument("-o", "--out", type=Path, required=True)
    drawn = modes.add_parser("pictures")
    drawn.add_argument("data", type=Path)
    drawn.add_argument("--to", type=Path, default=CLINIC, help="folder of the pictures")
    chosen = parser.parse_args()
    if chosen.mode == "limbs":
        limbs(chosen)
    else:
        pictures(chosen.data, chosen.to)


def limbs(chosen: argparse.Namespace) -> None:
    """Every device on ten limbs."""
    result: dict[str, Any] = {"machine": machine(), "slicer": slicer(), "rows": {}}
    if chosen.out.exists():
        result["rows"] = json.loads(chosen.out.read_text())["rows"]
    rows: dict[str, Any] = result["rows"]
    known = [one for one in devices().values() if not chosen.only or one.name in chosen.only]
    kinds = dict.fromkeys(one.kind for one in known)
    for subjects in zip(*(ten_of(kind, chosen.data) for kind in kinds), strict=True):
        for kind, subject in zip(kinds, subjects, strict=True):
            due = [
                one
                for one in known
                if one.kind == kind
                and (f"{one.name} / {subject.name}" not in rows or one.name in chosen.again)
            ]
            limb = subject.make() if due else None
            for device in due:
                row = _made(device, limb, subject, chosen.keep)
                row["commit"] = result["machine"]["commit"]
                rows[f"{device.name} / {subject.name}"] = row
                sys.stderr.write(f"{device.name} / {subject.name}: {_cell(row)} {row['cpu_s']}\n")
                write(chosen.out, result)


def pictures(data: Path, folder: Path) -> None:
    """Each device from two sides, named; orthoses and sockets."""
    matplotlib.use("Agg")
    for name, kinds in PICTURES.items():
        shown = [one for one in devices().values() if one.kind in kinds]
        subjects = {kind: ten_of(kind, data)[0] for kind in kinds}
        rows = -(-len(shown) // COLUMNS)
        figure, places = plt.subplots(rows, COLUMNS, figsize=(12, 2.9 * rows), squeeze=False)
        for axes in places.flat:
            axes.set_axis_off()
        for axes, device in zip(places.flat, shown):
            subject = subjects[device.kind]
            order = Order(device=device.name, made="printed", values=_values(device, subject))
            axes.imshow(_from_two_sides(make_device(subject.make(), order).solid))
            axes.set_title(textwrap.fill(device.en, 28), y=-0.16, fontsize=9, color="#333333")
            sys.stderr.write(f"{device.name}\n")
        figure.tight_layout()
        figure.savefig(folder / f"{name}.png", dpi=100)
        plt.close(figure)


def _from_two_sides(solid: Mesh) -> np.ndarray:
    """Its lateral side and its front beside each other, at one scale, filling a square."""
    low, high = solid.vertices_mm.min(0), solid.vertices_mm.max(0)
    wide_mm = (high - low)[[1, 0]]
    share = wide_mm / wide_mm.sum()
    pixel_mm = 1.15 * max(float(wide_mm.sum()), float(high[2] - low[2])) / SIDE_PX
    frames = [
        Frame(
            picture_from_world=looking_along(azimuth_deg, 12.0),
            middle_mm=0.5 * (low + high),
            pixel_mm=pixel_mm,
            width_px=round(SIDE_PX * part),
            height_px=SIDE_PX,
        )
        for azimuth_deg, part in zip((0.0, 90.0), share, strict=True)
    ]
    return np.hstack(shade_all(solid, frames))


def _made(device: Device, limb: Any, subject: Subject, keep: Path | None) -> dict[str, Any]:
    start = time.process_time()
    row: dict[str, Any] = {
        "device": device.name,
        "kind": device.kind,
        "limb": subject.name,
        "refused": None,
    }
    values = _values(device, subject)
    try:
        made = make_device(limb, Order(device=device.name, made="printed", values=values))
    except LimbgramError as error:
        row |= {"refused": error.finding.code, "says": str(error)}
        row["cpu_s"] = round(time.process_time() - start, 1)
        return row
    row |= {
        "off_mm": made.wall.off_mm,
        "thinnest_mm": made.wall.thinnest_mm,
        "asked_mm": made.preview.thinnest_mm,
        "triangles": len(made.solid.faces),
        "cpu_s": round(time.process_time() - start, 1),
    }
    with tempfile.TemporaryDirectory() as scratch:
        stem = f"{device.name}_{subject.name}".replace(", ", "_").replace(" ", "_")
        folder = keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        told = Told(bed_from_mesh=bed_from(made.solid, "standing"))
        path = write_3mf(made.solid, folder / f"{stem}.3mf", "mm", told=told)
        row |= sliced(path, Path(scratch) / "sliced.gcode")
    return row


def _values(device: Device, subject: Subject) -> dict[str, float]:
    """Usual measures, scaled with the body within their ranges.

    What parts a trunk's slots from edges goes with the wall, which is not scaled: only the straps'
    widths are. What yields to a slender limb by itself is not given.
    """
    found: dict[str, float] = {}
    for one in device.measures("printed"):
        if one.name == "wall_mm" and device.kind in WALL_MM:
            found[one.name] = WALL_MM[device.kind]
        elif one.usual is None:
            found[one.name] = GIVEN[one.name]
        elif one.yields:
            continue
        elif one.name.endswith("_mm") and one in (
            *device.trim.measures,
            *CALF_STRAP,
            *(strap for strap in OPENING_STRAPS if strap.name.endswith("_strap_mm")),
        ):
            scaled = one.usual * subject.size
            found[one.name] = float(np.clip(scaled, one.within.least, one.within.most))
    return found


def slicer() -> str:
    """Name and version of PrusaSlicer, without which nothing is begun.

    Raises:
        SystemExit: it is not installed.
    """
    if shutil.which("prusa-slicer") is None:
        raise SystemExit("Every device is sliced: install prusa-slicer first.")
    said = subprocess.run(["prusa-slicer", "--help"], capture_output=True, text=True, check=False)
    named = (line for line in said.stdout.splitlines() if line.startswith("PrusaSlicer"))
    return next(named, "none")


def sliced(path: Path, gcode: Path) -> dict[str, Any]:
    """What PrusaSlicer says of a 3MF, and whether it slices it."""
    info = subprocess.run(
        ["prusa-slicer", "--info", str(path)], capture_output=True, text=True, check=False
    )
    done = subprocess.run(
        ["prusa-slicer", *SLICED, "-o", str(gcode), str(path)],
        capture_output=True,
        text=True,
        check=False,
    )
    said = info.stdout + done.stdout + done.stderr
    return {
        "manifold": "manifold = yes" in info.stdout,
        "parts": int(info.stdout.split("number_of_parts =")[1].split()[0]),
        "repaired": any(word in said.lower() for word in ("repair", "auto-repaired", "degenerate")),
        "sliced": done.returncode == 0 and gcode.exists() and gcode.stat().st_size > 10_000,
        "slicer_says": "" if done.returncode == 0 else said[-600:],
    }


def _cell(row: dict[str, Any]) -> str:
    if row["refused"]:
        return row["refused"]
    wrong = [
        *([] if row["manifold"] and row["parts"] == 1 else ["open"]),
        *(["repaired"] if row["repaired"] else []),
        *([] if row["sliced"] else ["not sliced"]),
        *([] if row["off_mm"] <= OFF_MM else ["off"]),
    ]
    return f"{row['off_mm']:.3f}" + (f" {', '.join(wrong)}" if wrong else "")


def page(result: dict[str, Any]) -> str:
    """Devices by limbs."""
    rows = list(result["rows"].values())
    commits = dict.fromkeys(row["commit"][:12] for row in rows)
    parts = [
        "# Every device on ten limbs",
        made_on(result["machine"]) + f"; {result['slicer']}; rows of commits {', '.join(commits)}",
        "A figure: one closed solid without crossings, read by PrusaSlicer as one manifold part "
        "and sliced without a repair; of 99 in 100 places of the wall, the largest difference "
        f"from the thickness that was asked, in mm (promised: {OFF_MM}). What was refused, and "
        "why, stands below.",
    ]
    for kind in dict.fromkeys(row["kind"] for row in rows):
        own = [row for row in rows if row["kind"] == kind]
        names = tuple(dict.fromkeys(row["device"] for row in own))
        body = [
            (limb, *(_of(own, name, limb) for name in names))
            for limb in dict.fromkeys(row["limb"] for row in own)
        ]
        parts += [f"## {kind}", table(("limb", *names), body)]
    good = [row for row in rows if not row["refused"]]
    whole = [row for row in good if _cell(row) == f"{row['off_mm']:.3f}"]
    parts.append(
        f"{len(rows)} orders of {10 * len(devices())}: {len(whole)} as promised, "
        f"{len(good) - len(whole)} made with a fault, {len(rows) - len(good)} refused."
    )
    parts.append("\n".join(_refusals(rows)))
    return "\n\n".join(filter(None, parts)) + "\n"


def _of(rows: Sequence[dict[str, Any]], name: str, limb: str) -> str:
    return next(
        (_cell(row) for row in rows if (row["device"], row["limb"]) == (name, limb)), "not run"
    )


def _refusals(rows: Sequence[dict[str, Any]]) -> Iterator[str]:
    for row in rows:
        if row["refused"]:
            yield f"- {row['device']}, {row['limb']}: {row['says']}"


if __name__ == "__main__":
    main()
