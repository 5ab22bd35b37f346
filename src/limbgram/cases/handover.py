"""Handover: files for machines and programs, written from a case, with what was read back of each.

In      the work on an aligned case, a kind of file, and the side as somebody confirms it now.
Out     WORK/files/NAME, its limb file where it is a shape, NAME.mirror.png drawn of what was read
        back, and NAME.json: figures, hashes, who may take it for what. NAME has the hash of the
        shape and of all that was asked for: a file is never written over by another one.
Method  The same steps as `limbgram edit apply` and `limbgram export`, through the same files, so
        the bytes are the same.
Fails   as they do: not aligned, another side, a surface that folds, a shape that the format cannot
        hold, no room.
"""

from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal

from limbgram.cases.bench import MAKING, Bench, Work, digits_of
from limbgram.cases.fingerprint import file_sha256
from limbgram.cases.record import write_json
from limbgram.core.errors import CarveError, CaseError
from limbgram.core.files import json_of, read_content, write_bytes
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import volume_mm3
from limbgram.core.typed import Mismatch, Strictness, tree_of, value_of
from limbgram.findings import told
from limbgram.formats.aop.writing import AopOptions, write_aop
from limbgram.formats.dxf import curves_of, write_triangles
from limbgram.formats.gate import admit
from limbgram.formats.gcode.control import Control
from limbgram.formats.gcode.writing import write_gcode
from limbgram.formats.limb_file import write_limb
from limbgram.formats.reading import read_shape
from limbgram.report.drawings.drawing import png
from limbgram.report.drawings.mirrorcheck import mirror_check
from limbgram.workbench.bodies import left_out, without_loose
from limbgram.workbench.carving.setup import CarveOptions
from limbgram.workbench.limb import Landmark, Limb, Side

FileKind = Literal["stl", "ply", "obj", "glb", "dxf", "aop", "gcode"]
_SECTIONS_MM = 10.0
_LARGEST = 4_000_000
_AS_WRITTEN = Strictness(pass_over_unknown=True)


@dataclass(frozen=True, kw_only=True)
class HandoverOptions:
    """What the receiver expects."""

    kind: FileKind
    side: Side
    """As it is confirmed now, not as it was kept."""
    signed_by: str = ""
    """Who takes the shape of a red capture for good, and why."""
    aop: AopOptions = field(default_factory=AopOptions)
    sections_mm: float = _SECTIONS_MM
    """Of a DXF."""
    carving: CarveOptions = field(default_factory=CarveOptions)
    control: Control = field(default_factory=Control)


@dataclass(frozen=True, kw_only=True)
class HandedOver:
    """A file that was written, and what was read back of it."""

    name: str
    kind: FileKind
    made: str
    """Date and time, UTC."""
    bytes: int
    sha256: str
    side: Side
    unit: str
    scan_sha256: str
    recipe_sha256: str = ""
    """Of the recipe's file; empty in what was written before this was kept."""
    recipe_edits: int
    shape: str = ""
    """Name of the shape after the recipe, from which it was made; empty where that is the scan, and
    in what was written before this was kept."""
    lines: tuple[str, ...]
    """What was read back, in sentences."""
    surface_within_mm: float | None = None
    """Largest distance between the shape and the file."""
    girth_change_mm: float | None = None
    volume_change: float | None = None
    """Share."""
    minutes: float | None = None
    """Of cutting."""
    doubt: str = ""
    signed_by: str = ""
    notes: tuple[str, ...] = ()


def hand_over(bench: Bench, work: Work, options: HandoverOptions) -> HandedOver:
    """Write a file and prove it; the one that was written before, where it is the same.

    Args:
        work: A recipe without edits hands over the scan itself.

    Raises:
        CarveError: a red capture that nobody signed for; not aligned, or another side.
    """
    with MAKING.of(bench.root):
        return _handed_over(bench, work, options)


def _handed_over(bench: Bench, work: Work, options: HandoverOptions) -> HandedOver:
    edits = len(work.done.ledger.lines)
    rectified = bench.rectified(work.done.limb) if edits else None
    read = work.scan if rectified is None else read_shape(rectified)
    if read.limb.doubt and not options.signed_by.strip():
        raise CarveError(
            f"Not written: {read.limb.doubt}. If it is meant all the same, somebody has to say "
            "who takes it on, and why."
        )
    limb = admit(read.limb, options.side)
    bench.made(bench.files)
    letter = {"left": "-L", "right": "-R", "none": ""}[options.side]
    suffix = "nc" if options.kind == "gcode" else options.kind
    digits = digits_of(read.limb, options, version("limbgram"))
    name = f"{bench.case.case_id}{letter}-{digits}.{suffix}"
    path = bench.files / name
    known = _read(bench.files / f"{name}.json")
    if known is not None and path.is_file() and file_sha256(path) == known.sha256:
        return known
    written = _written(limb, path, options)
    picture = mirror_check(written.shown, written.marks, options.side, name)
    write_bytes(bench.files / f"{name}.mirror.png", png(picture.figure).tobytes())
    handed = HandedOver(
        name=name,
        kind=options.kind,
        made=datetime.now(UTC).isoformat(timespec="seconds"),
        bytes=path.stat().st_size,
        sha256=file_sha256(path),
        side=options.side,
        unit="m" if options.kind == "glb" else "mm",
        scan_sha256=work.scan.sha256,
        recipe_sha256=work.recipe_sha256,
        recipe_edits=edits,
        shape="" if rectified is None else rectified.name,
        doubt=read.limb.doubt,
        signed_by=options.signed_by.strip(),
        notes=tuple(dict.fromkeys((*work.done.limb.notes, *limb.notes))),
        **written.figures,
    )
    write_json(bench.files / f"{name}.json", tree_of(handed))
    return handed


def handed_over(bench: Bench) -> tuple[HandedOver, ...]:
    """What was written so far, the newest first."""
    if not bench.files.is_dir():
        return ()
    found = (_read(path) for path in bench.files.glob("*.json"))
    there = (one for one in found if one is not None and (bench.files / one.name).is_file())
    return tuple(sorted(there, key=lambda one: one.made, reverse=True))


def handed(bench: Bench, name: str) -> HandedOver:
    """One file that was written.

    Raises:
        LookupError: there is none of that name.
    """
    found = next((one for one in handed_over(bench) if one.name == name), None)
    if found is None:
        raise LookupError("There is no such file.")
    return found


@dataclass(frozen=True)
class _Written:
    """A file, the shape that it holds as read back, and figures for HandedOver."""

    shown: Mesh
    marks: tuple[Landmark, ...]
    figures: dict[str, Any]


def _written(limb: Limb, path: Path, options: HandoverOptions) -> _Written:
    match options.kind:
        case "aop":
            return _aop(limb, path, options.aop)
        case "gcode":
            return _gcode(limb, path, options)
        case "dxf":
            return _dxf(limb, path, options.sections_mm)
        case _:
            return _mesh(limb, path)


def _mesh(limb: Limb, path: Path) -> _Written:
    found = without_loose(limb.mesh)
    write_limb(limb.with_mesh(found.mesh), path)
    back = read_shape(path).limb
    change = volume_mm3(back.mesh) / volume_mm3(found.mesh) - 1
    told = (
        f"Read back: {len(back.mesh.faces):,} triangles, the same surface; volume "
        f"{volume_mm3(back.mesh) / 1000:.1f} mL.",
        *(f"{one}." for one in left_out(len(found.loose), found.loose, frame="in the limb frame")),
    )
    figures = {"lines": told, "volume_change": change, "surface_within_mm": 0.0}
    return _Written(back.mesh, back.landmarks, figures)


def _dxf(limb: Limb, path: Path, sections_mm: float) -> _Written:
    found = without_loose(limb.mesh)
    curves = curves_of(found.mesh, sections_mm)
    write_triangles(found.mesh, path, "mm", curves)
    told = f"Read back: {len(found.mesh.faces):,} triangles and {len(curves.sections)} sections."
    return _Written(found.mesh, limb.landmarks, {"lines": (told,)})


def _aop(limb: Limb, path: Path, options: AopOptions) -> _Written:
    report = write_aop(limb, path, options)
    worst, cap = report.worst_girth, report.cap
    lines = [
        f"Read back: {report.spokes} spokes x {report.slices} slices, {report.height_mm:.1f} mm "
        f"high. Surface within {report.above_cap_max_mm:.2f} mm."
    ]
    if cap is not None:
        lines.append(
            f"The rounded tip is coarser: the lowest {cap.to_mm:.0f} mm lie within "
            f"{cap.max_mm:.2f} mm. More slices at the tip make it finer."
        )
    figures = {
        "lines": tuple(lines),
        "surface_within_mm": report.above_cap_max_mm,
        "girth_change_mm": None if worst is None else worst.change_mm,
        "volume_change": report.volume_change,
    }
    held = report.held
    return _Written(held.radius_map.surface(), held.landmarks, figures)


def _gcode(limb: Limb, path: Path, options: HandoverOptions) -> _Written:
    report = write_gcode(limb, path, options.carving, options.control)
    check, blank = report.check, report.toolpath.blank
    lines = (
        f"Carved by simulation from what was read back: {check.gouge_mm:.3f} mm into the shape at "
        f"most; ridges of {check.scallop_mm:.3f} mm.",
        f"Blank: diameter {2 * blank.radius_mm:.0f} mm. Tool: ball end "
        f"{options.carving.tool_diameter_mm:g} mm. About {check.minutes:.0f} min of cutting.",
        told(report.standing),
    )
    figures = {"lines": lines, "surface_within_mm": check.gouge_mm, "minutes": check.minutes}
    return _Written(check.carved.surface(), limb.landmarks, figures)


def _read(path: Path) -> HandedOver | None:
    try:
        tree = json_of(read_content(path, _LARGEST, CaseError))
        return value_of(tree, HandedOver, strictness=_AS_WRITTEN)
    except (CaseError, Mismatch, ValueError):
        return None
