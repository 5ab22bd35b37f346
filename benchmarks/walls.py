"""Walls over reconstructed scans: closed or not, how thin, what crosses, how level the brim is.

    python benchmarks/captures.py DATA --sets limb_ring15 limb_sparse15 foot_ring24 --keep CASES ...
    python benchmarks/walls.py CASES -o benchmarks/results/walls.json

CASES holds the finished cases of the rendered sets. SHAPES says which of their surfaces are used,
as they are or cut level; each is given a wall of every thickness, outward and inward, by the edit
as a recipe does it. Said of each: why it was refused, or whether it is watertight, its volume, its
least thickness from skin to skin (as the edit tells it) and by rays that know no skins, pairs of
faces that pass through each other, and between which heights the brim lies that was cut level. What
stands in OUT already is kept, so that a run that was stopped goes on; every wall names the commit
that it was made at.
Nothing here is random; the surfaces are those of the sets' own seeds.
"""

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from harness import asking, found_before, machine, made_on, table, write
from limbgram.core.errors import EditError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.mesh import unit
from limbgram.core.mesh.topology import enclosed_by
from limbgram.findings import told
from limbgram.formats.reading import read_limb
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.plane_cut import PlaneCut
from limbgram.workbench.edits.regions import moved_by
from limbgram.workbench.edits.thickness import wall_thickness
from limbgram.workbench.edits.wall import Wall
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame

THICKNESSES_MM = (2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
SIDES = ("outward", "inward")
SHAPES: dict[str, tuple[str, float | None]] = {
    "limb_ring15, cut at 240 mm": ("limb_ring15", 240.0),
    "limb_sparse15, cut at 240 mm": ("limb_sparse15", 240.0),
    "foot_ring24, cut at 188 mm": ("foot_ring24", 188.0),
    "limb_ring15": ("limb_ring15", None),
    "limb_sparse15": ("limb_sparse15", None),
}
"""The set, and the height of the cut: above the distal end of a limb, above the floor of a foot."""
STANDING = ("foot_ring24",)
"""Sets whose distal end is down; the limbs stand on their brims."""
NEAR_MM = 3.0
"""A face of the brim looks along the axis and lies so near to the cut."""
SHORT_MM = 0.05
"""A wall may be so much thinner than asked; below, it is counted as short."""


def main() -> None:
    parser = asking(__doc__)
    parser.add_argument("cases", type=Path)
    parser.add_argument("--shapes", nargs="*", default=list(SHAPES), choices=SHAPES)
    parser.add_argument("--thicknesses", nargs="*", type=float, default=THICKNESSES_MM)
    parser.add_argument("--sides", nargs="*", default=list(SIDES), choices=SIDES)
    chosen = parser.parse_args()
    out: Path = chosen.out
    before: dict[str, Any] = found_before(out, {})
    kept: dict[str, Any] = before.get("walls", {})
    remarks = {"remarks": before["remarks"]} if "remarks" in before else {}
    here = machine()
    for name, shape, cut_mm, edit in walls(chosen, kept):
        kept[name] = one(shape, cut_mm, edit) | {"commit": here["commit"][:12]}
        found = {"machine": here, "walls": kept, **remarks}
        write(out, found)
        sys.stderr.write(f"{name}: {kept[name]}\n")


def walls(
    chosen: argparse.Namespace, kept: dict[str, Any]
) -> Iterator[tuple[str, Limb, float | None, Wall]]:
    """Each wall that is not there yet: its name, the shape, the height of its cut, and the edit."""
    for name in chosen.shapes:
        set_name, cut_mm = SHAPES[name]
        shape = scan(chosen.cases, set_name)
        if cut_mm is not None:
            shape = do_edit(shape, PlaneCut(height_mm=cut_mm))
        for side in chosen.sides:
            for thickness_mm in chosen.thicknesses:
                wall = f"{name}; {thickness_mm:g} mm {side}"
                if wall not in kept:
                    yield wall, shape, cut_mm, Wall(thickness_mm=thickness_mm, side=side)


def scan(cases: Path, set_name: str) -> Limb:
    """The surface of a case, upright with its distal end down, its heights from there; of a foot
    from the floor that it stood on."""
    limb = read_limb(cases / set_name / "case" / "deliverables" / "surface.ply")
    turn = np.eye(3) if set_name in STANDING else np.diag([1.0, -1.0, -1.0])
    points = moved_by(Rigid(turn, np.zeros(3)), limb.mesh.vertices_mm)
    middle = points.mean(0)
    lowest = 0.0 if set_name in STANDING else float(points[:, 2].min())
    motion = Rigid(turn, np.array([-middle[0], -middle[1], -lowest]))
    return AlignedLimb(mesh=limb.mesh, frame=LimbFrame(limb_from_mesh=motion, side="none"))


def one(shape: Limb, cut_mm: float | None, edit: Wall) -> dict[str, Any]:
    """What became of a wall."""
    began = time.process_time()
    try:
        made = do_edit(shape, edit)
    except EditError as refused:
        return {"refused": told(refused.finding), "cpu_s": time.process_time() - began}
    cpu_s = time.process_time() - began
    mesh = made.mesh
    holds = enclosed_by(mesh)
    (thickness,) = (one for one in made.notes if one.code == "edit.wall.thickness")
    by_rays = wall_thickness(mesh)
    return {
        "watertight": holds.watertight,
        "volume_ml": holds.volume_mm3 / 1000,
        "thinnest_mm": thickness.values["thinnest_mm"],
        "median_mm": thickness.values["median_mm"],
        "thinnest_by_rays_mm": None if by_rays is None else by_rays.thinnest_mm,
        "crossings": len(find_crossings(mesh.vertices_mm, mesh.faces)),
        "brim_mm": None if cut_mm is None else brim_mm(made, cut_mm),
        "told": [told(one) for one in made.notes if one.code != "edit.wall.thickness"],
        "triangles": len(mesh.faces),
        "cpu_s": cpu_s,
    }


def brim_mm(made: Limb, cut_mm: float) -> tuple[float, float]:
    """Lowest and highest place of the faces that look along the axis near the cut."""
    mesh = made.mesh.with_vertices(moved_by(made.frame.limb_from_mesh, made.mesh.vertices_mm))
    heights = mesh.vertices_mm[:, 2][mesh.faces]
    up = unit(mesh.face_normals())[:, 2] > np.sqrt(0.5)
    brim = up & (np.abs(heights - cut_mm).min(1) < NEAR_MM)
    return float(heights[brim].min()), float(heights[brim].max())


def page(found: dict[str, Any]) -> str:
    """The table."""
    done = found["walls"]
    made = [one for one in done.values() if "refused" not in one]
    short = [
        name
        for name, one in done.items()
        if "refused" not in one and one["thinnest_mm"] < asked_mm(name) - SHORT_MM
    ]
    rows = [(*row_heads(name), *cells(one)) for name, one in done.items()]
    refusals = [f"- {name}: {one['refused']}" for name, one in done.items() if "refused" in one]
    lacking = [
        f"{shape}; {thickness_mm:g} mm {side}"
        for shape in SHAPES
        for side in SIDES
        for thickness_mm in THICKNESSES_MM
        if f"{shape}; {thickness_mm:g} mm {side}" not in done
    ]
    heads = (
        "surface", "wall", "watertight", "volume mL", "thinnest mm", "by rays mm", "crossings",
        "brim mm", "left out or solid", "s of processor", "commit",
    )  # fmt: skip
    parts = [
        "# Walls over reconstructed scans",
        f"{len(done)} walls were asked for, {len(made)} made, "
        f"{sum(one['watertight'] for one in made)} of these watertight, "
        f"{len(short)} thinner than asked by more than {SHORT_MM:g} mm somewhere. Thinnest: from "
        "skin to skin, and by rays that know no skins: across a tongue that stands out between "
        "notches of a scan's ragged edge, they tell its width. The edit says where one is narrower "
        "than the wall is thick. Brim: lowest and highest place of what was cut level.",
        table(heads, rows),
        *(("Refused:", "\n".join(refusals)) if refusals else ()),
        *((f"Not run: {'; '.join(lacking)}.",) if lacking else ()),
        *found.get("remarks", ()),
        made_on(found["machine"]),
    ]
    return "\n\n".join(parts) + "\n"


def row_heads(name: str) -> tuple[str, str]:
    shape, wall = name.split("; ")
    return shape, wall


def asked_mm(name: str) -> float:
    return float(row_heads(name)[1].split()[0])


def cells(one: dict[str, Any]) -> tuple[str, ...]:
    if "refused" in one:
        return ("refused", "", "", "", "", "", "", f"{one['cpu_s']:.0f}", one["commit"])
    brim = one["brim_mm"]
    rays = one["thinnest_by_rays_mm"]
    return (
        "yes" if one["watertight"] else "NO",
        f"{one['volume_ml']:.1f}",
        f"{one['thinnest_mm']:.2f}",
        "-" if rays is None else f"{rays:.2f}",
        str(one["crossings"]),
        "-" if brim is None else f"{brim[0]:.3f} to {brim[1]:.3f}",
        "; ".join(one["told"]),
        f"{one['cpu_s']:.0f}",
        one["commit"],
    )


if __name__ == "__main__":
    main()
