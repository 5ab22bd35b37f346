"""Export: a shape for printers, CAD programs and carvers, and what was read back of each file.

In      a shape as read; the request of one kind of file; for a carver the side, confirmed now.
Out     the file, proved by reading it back; Exported: what was read, in findings and figures.
Fails   not aligned, another side, a surface that folds, a shape that the format cannot hold.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import numpy as np

from limbgram.core.errors import OptionsError
from limbgram.core.files import write_bytes
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import angle_between_deg
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.notebook import brief
from limbgram.core.request_fields import Flag, Usual, Within
from limbgram.core.spreadsheet import Decimal, Table, csv_of, xlsx_of
from limbgram.findings import Finding, doubt, note
from limbgram.findings.tell import Language
from limbgram.formats.aop.cost import AopReport
from limbgram.formats.aop.profiles import Profile
from limbgram.formats.aop.writing import AopOptions, LineEnd, SourceGrid, write_aop
from limbgram.formats.curves import Curves, curves_of
from limbgram.formats.dxf import write_drawing
from limbgram.formats.dxf_r12 import write_polyface_dxf, write_triangles
from limbgram.formats.export_checks import admit, sure_in_limb_frame
from limbgram.formats.gcode.control import Coolant, DialectName, FeedMode, RotaryWord, Winding
from limbgram.formats.gcode.machine import Machine, read_machine, require_place, write_machine
from limbgram.formats.gcode.writing import GcodeReport, write_gcode
from limbgram.formats.limb_file import write_limb
from limbgram.formats.reading import ShapeFile
from limbgram.formats.table import FORMATS, format_of
from limbgram.workbench.bodies import (
    OuterShape,
    SeparateBody,
    kept_findings,
    left_out_findings,
    without_loose,
)
from limbgram.workbench.carving.mapping import MapOptions
from limbgram.workbench.carving.setup import FAST, LIMITS, CarveOptions
from limbgram.workbench.edits.thickness import wall_thickness
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, Side

_IN_LIMB = "in_limb_mm"
_MAP = MapOptions()
_CARVE = CarveOptions()


@dataclass(frozen=True, kw_only=True)
class Triangles:
    """A mesh, for printers and other programs."""


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """A drawing of surface, sections, trimline, centreline and landmarks, for CAD programs."""

    spacing_mm: Annotated[float, Within(0.5, 200), Flag("spacing")] = 10.0
    """Between slices or sections, mm."""
    r12: bool = False
    """Release 12, as carvers and old programs take it: single faces, sections and trimline."""
    polyface: bool = False
    """Release 12 with joined meshes in place of single faces."""


@dataclass(frozen=True, kw_only=True)
class Aop:
    """A radius map, as carvers and programs of the trade take it."""

    spokes: Annotated[int | None, Within(8, 3600), Usual(_MAP.spokes)] = None
    """Radii round a slice; without it an AOP's own spokes and slices."""
    spacing_mm: Annotated[
        float | None, Within(0.1, 50), Usual(_MAP.spacing_mm), Flag("spacing")
    ] = None
    """Between slices or sections, mm."""
    distal_slices: Annotated[int | None, Within(0, 100), Usual(_MAP.distal_slices)] = None
    """More slices at the rounded tip."""
    from_mm: float | None = None
    """Height of the first slice in the limb; not with --axis fit."""
    to_mm: float | None = None
    """Height of the last slice; not with --axis fit."""
    axis: Literal["limb", "fit"] | None = None
    """The limb's own axis, or one fitted so that radii are single; this from end to end, without
    --from-mm and --to-mm."""
    profile: Profile = "mm"
    """The program whose dialect of AOP is written."""
    line_end: LineEnd = "lf"
    """End of lines."""
    list_spokes: bool = False
    """Write the angle of each spoke, not their spacing."""
    even_slices: bool = False
    """Write the spacing of the slices, not the height of each."""

    def options(self, source_grid: SourceGrid | None) -> AopOptions:
        """The options of the writer; an AOP keeps its own grid if nothing else is asked for."""
        asked = {name: getattr(self, name) for name in _OF_MAP}
        given = {name: value for name, value in asked.items() if value is not None}
        usual = AopOptions()
        return AopOptions(
            map=replace(usual.map, **given),
            source_grid=None if given or self.axis else source_grid,
            axis=self.axis or usual.axis,
            profile=self.profile,
            line_end=self.line_end,
            spokes_listed=self.list_spokes,
            slices_listed=not self.even_slices,
        )


_OF_MAP = ("spokes", "spacing_mm", "distal_slices", "from_mm", "to_mm")


@dataclass(frozen=True, kw_only=True)
class Gcode:
    """A program for a four-axis carver; what is not given is as in the machine file, else usual."""

    machine: Path | None = None
    """Machine file; what is typed goes over it."""
    preset: Literal["fine", "fast"] = "fine"
    """Fine, or fast: a 19 mm tool and ridges of 0.15 mm."""
    to_mm: float | None = None
    """Height at which carving stops."""
    tool_diameter_mm: Annotated[
        float | None,
        Within(*LIMITS["tool_diameter_mm"]),
        Usual(_CARVE.tool_diameter_mm),
        Flag("tool"),
    ] = None
    """Diameter of the ball end, mm."""
    tool_reach_mm: Annotated[float | None, Flag("reach")] = None
    """Tool's tip to holder, mm."""
    blank_diameter_mm: Annotated[float | None, Flag("blank")] = None
    """Diameter of the blank, mm."""
    blank_length_mm: Annotated[float | None, Flag("blank-length")] = None
    """Length of the blank, mm."""
    spigot_mm: Annotated[float | None, Flag("spigot")] = None
    """Radius of the stub left for a tailstock, mm."""
    mandrel_diameter_mm: Annotated[float | None, Flag("mandrel")] = None
    """Diameter of a bar through the blank, mm."""
    scallop_mm: Annotated[float | None, Flag("scallop")] = None
    """Height of ridges, mm."""
    rough_depth_mm: Annotated[float | None, Flag("rough-depth")] = None
    """Depth of a roughing layer, mm."""
    feed_mm_min: Annotated[float | None, Flag("feed")] = None
    """Feed over the surface, mm/min."""
    plunge_mm_min: Annotated[float | None, Flag("plunge")] = None
    """Feed into the blank, mm/min."""
    turn_deg_min: Annotated[float | None, Flag("turn-rate")] = None
    """Fastest turn of the rotary axis, degrees/min."""
    spindle_rpm: Annotated[int | None, Flag("spindle")] = None
    """Speed of the spindle, turns a minute; 0 leaves it to the operator."""
    pattern: Literal["helix", "rings"] | None = None
    """Path of the finishing pass."""
    a_turns: Literal["tool", "work"] | None = None
    """What turns counter-clockwise, seen from proximal, as A grows."""
    dialect: DialectName | None = None
    """The control that reads the program."""
    winding: Winding | None = None
    """Unwind turns back in time; reset takes turns off by G92; rollover writes places within one
    turn, as the control must be set; continuous winds on."""
    a_limit_deg: Annotated[float | None, Flag("a-limit")] = None
    """How far A may turn to either side, degrees."""
    feed: Annotated[FeedMode | None, Flag("feed-mode")] = None
    """Inverse time (G93), or per minute; without it as the dialect does."""
    rotary_word: RotaryWord | None = None
    """Letter of the axis that turns about X; without it A, for grbl Y, as stock Grbl has no A."""
    tool_number: int | None = None
    """Tool that T, M6 and G43 call; 0 for no call."""
    spindle_start_s: Annotated[float | None, Flag("spindle-start")] = None
    """Seconds to wait for the spindle."""
    coolant: Coolant | None = None
    """Mist by M7, flood by M8, or none."""
    program_number: int | None = None
    """O number for fanuc."""
    write_machine: Path | None = None
    """Write these settings as a machine file (.toml)."""

    def set_up(self) -> Machine:
        """What was given, over the preset, over the machine file, over what is usual.

        The preset takes the larger tool only where neither names one.
        """
        kept = Machine() if self.machine is None else read_machine(self.machine)
        fast = dict(FAST) if self.preset == "fast" else {}
        if kept.names_tool:
            fast.pop("tool_diameter_mm", None)
        return Machine(
            control=replace(kept.control, **self._given_of(kept.control)),
            carving=replace(kept.carving, **{**fast, **self._given_of(kept.carving)}),
        )

    def _given_of(self, options: Any) -> dict[str, Any]:
        names = {one.name for one in fields(options)} & {one.name for one in fields(self)}
        asked = {name: getattr(self, name) for name in names - {"to_mm"}}
        return {name: value for name, value in asked.items() if value is not None}


@dataclass(frozen=True, kw_only=True)
class LandmarkBook:
    """Names and places of the landmarks, as a workbook."""


@dataclass(frozen=True, kw_only=True)
class Landmarks:
    """The same as text."""

    decimal: Decimal = "point"
    """Decimal sign; with a comma semicolons part the columns."""


Export = Triangles | Drawing | Aop | Gcode | LandmarkBook | Landmarks
EXPORTS: Final[dict[str, type[Export]]] = {
    **{one.name: Triangles for one in FORMATS if one.write is not None},
    "dxf": Drawing,
    "aop": Aop,
    "gcode": Gcode,
    "xlsx": LandmarkBook,
    "csv": Landmarks,
}
"""The request of each kind of file that is written; all doors offer these."""
USED_FOR: Final[dict[str, Mapping[Language, str]]] = {
    **{one.name: one.used_for for one in FORMATS},
    "gcode": {"en": "own four-axis carver", "de": "eigene Vierachsfräse"},
    "xlsx": {
        "en": "landmarks, for a spreadsheet",
        "de": "Landmarken, für Tabellenprogramme",
    },
    "csv": {"en": "landmarks as text", "de": "Landmarken als Text"},
}
"""Who takes each, in a few words for people."""
EVERYDAY: Final = ("aop", "gcode", "stl", "dxf")
"""What is asked for most, in the order in which people are offered it."""
FOR_CARVERS: Final = frozenset({"aop", "gcode"})
"""Kinds for machines that cannot ask: aligned, and the side confirmed."""
_LETTERS: dict[Side, str] = {"left": "-L", "right": "-R", "none": ""}


@dataclass(frozen=True, kw_only=True)
class Exported:
    """A file that was written, and what was read back of it."""

    path: Path
    limb: Limb
    """What was written, in its frame."""
    unit: Literal["mm", "m"]
    said: tuple[Finding, ...]
    """What was read back, and what to know of it."""
    figures: Mapping[str, Any]
    """The same in numbers, as JSON holds them."""
    shown: Mesh
    """What the file holds, in the limb frame."""
    marks: tuple[Landmark, ...]
    surface_within_mm: float | None = None
    """Largest distance between the shape and the file."""
    girth_change_mm: float | None = None
    volume_change: float | None = None
    """Share."""
    minutes: float | None = None
    """Of cutting."""

    __repr__ = brief

    @property
    def side(self) -> Side:
        return self.limb.side


def file_name(stem: str, kind: str, side: Side, digits: str = "") -> str:
    """What a file is called: a limb's side stands in its name, and of what it was made if asked."""
    made_of = digits and f"-{digits}"
    return f"{stem}{_LETTERS[side]}{made_of}.{'nc' if kind == 'gcode' else kind}"


def export(
    read: ShapeFile, ask: Export, path: Path, side: Side | None = None, picture: Path | None = None
) -> Exported:
    """Write a shape for another program or machine, read the file back, and compare.

    Args:
        path: Its ending says the kind of a mesh.
        side: Of the patient, as somebody confirms it now; files for carvers demand it.
        picture: Where the mirror check is drawn: what the file holds, to be held against the
            patient.

    Raises:
        OptionsError: nobody confirmed the side, or an option cannot be.
        CarveError: not aligned, another side, or a shape that the format cannot hold.
        FoldedShapeError: the surface branches, or folds where that cannot be laid back.
    """
    match ask:
        case Aop():
            source_grid = _source_grid(read)
            exported = _aop(admit(read.limb, side), path, ask.options(source_grid))
        case Gcode():
            machine = ask.set_up()
            _require_apart(ask, path)
            exported = _gcode(admit(read.limb, side), path, ask, machine)
        case Drawing():
            exported = _drawing(_with_confirmed_side(read.limb, side), path, ask)
        case LandmarkBook() | Landmarks():
            exported = _landmarks(_with_confirmed_side(read.limb, side), path, ask)
        case Triangles():
            exported = _triangles(_with_confirmed_side(read.limb, side), path)
    return exported if picture is None else _with_picture(exported, picture)


def _with_confirmed_side(limb: Limb, side: Side | None) -> Limb:
    """The limb, with its side compared with the confirmed one, if any."""
    return sure_in_limb_frame(limb) if side is None else admit(limb, side)


def _with_picture(exported: Exported, picture: Path) -> Exported:
    """Draw the mirror check; what draws takes longer to import than a mesh to write."""
    from limbgram.report.drawings.drawing import png
    from limbgram.report.drawings.mirror_check import mirror_check

    drawing = mirror_check(exported.shown, exported.marks, exported.side, exported.path.name)
    write_bytes(picture, png(drawing.figure).tobytes())
    return replace(
        exported,
        said=(*exported.said, note("exported.mirror_check", path=str(picture))),
        figures={**exported.figures, "mirror_check": str(picture)},
    )


def _source_grid(read: ShapeFile) -> SourceGrid | None:
    """Spokes, slices and axis of an AOP, as long as its axes are the limb's still."""
    now, declared = read.limb.known_limb_from_mesh, read.declared
    if read.grid is None or now is None or declared is None:
        return None
    own = declared.limb_from_mesh
    same = np.array_equal(own.rotation, now.rotation) and np.array_equal(
        own.translation, now.translation
    )
    return SourceGrid(grid=read.grid, limb_from_file=own) if same else None


def _aop(limb: AlignedLimb, path: Path, options: AopOptions) -> Exported:
    report = write_aop(limb, path, options)
    worst = report.worst_girth
    return Exported(
        path=path,
        limb=limb,
        unit="mm",
        said=_aop_findings(report, path, options),
        figures=_aop_figures(report, options),
        shown=report.held.radius_map.surface(),
        marks=report.held.landmarks,
        surface_within_mm=report.above_cap_max_mm,
        girth_change_mm=None if worst is None else worst.change_mm,
        volume_change=report.volume_change,
    )


def _aop_findings(report: AopReport, path: Path, options: AopOptions) -> tuple[Finding, ...]:
    mapped = report.mapped
    return (
        note(
            "exported.aop.written",
            path=str(path),
            spokes=report.spokes,
            slices=report.slices,
            height_mm=report.height_mm,
            profile=options.profile,
        ),
        *((note("exported.aop.own_grid"),) if options.source_grid is not None else ()),
        *_fitted_axis(report),
        *_format_costs(report),
        *left_out_findings(report.bodies_left_out, report.loose, frame="limb"),
        note(
            "exported.aop.cut",
            distal_mm=mapped.distal_cut_mm,
            proximal_mm=mapped.proximal_cut_mm,
            mended=mapped.rays_mended,
            rays=mapped.rays,
        ),
    )


def _aop_figures(report: AopReport, options: AopOptions) -> dict[str, Any]:
    mapped, worst = report.mapped, report.worst_girth
    return {
        "side": report.held.frame.side,
        "profile": options.profile,
        "own_grid": options.source_grid is not None,
        "spokes": report.spokes,
        "slices": report.slices,
        "height_mm": report.height_mm,
        "max_mm": report.max_mm,
        "rms_mm": report.rms_mm,
        "volume_ml": report.volume_ml,
        "volume_change": report.volume_change,
        "girth_change": None if worst is None else report.girth_change,
        "girth_change_mm": None if worst is None else worst.change_mm,
        "girths": [
            {
                "height_mm": level.height_mm,
                "limb_mm": level.limb_mm,
                "file_mm": level.file_mm,
                "change_mm": level.change_mm,
            }
            for level in report.girths
        ],
        "above_cap_max_mm": report.above_cap_max_mm,
        "cap": None if report.cap is None else asdict(report.cap),
        "axis_from_limb": {
            "rotation": report.axis_from_limb.rotation.tolist(),
            "translation_mm": report.axis_from_limb.translation.tolist(),
        },
        "bodies_left_out": report.bodies_left_out,
        "loose_bodies": _places(report.loose, _IN_LIMB),
        "distal_cut_mm": mapped.distal_cut_mm,
        "proximal_cut_mm": mapped.proximal_cut_mm,
        "rays_mended": mapped.rays_mended,
    }


def _fitted_axis(report: AopReport) -> tuple[Finding, ...]:
    motion = report.axis_from_limb
    if not np.any(motion.translation) and np.array_equal(motion.rotation, np.eye(3)):
        return ()
    middle = np.array([0.0, 0.0, report.mapped.first_mm + report.height_mm / 2])
    right_mm, front_mm, _ = motion.inverse.apply(middle[None])[0].tolist()
    tilt_deg = angle_between_deg(motion.rotation, np.eye(3))
    return (note("exported.aop.axis", tilt_deg=tilt_deg, right_mm=right_mm, front_mm=front_mm),)


def _format_costs(report: AopReport) -> tuple[Finding, ...]:
    """The format's deviations above the rounded tip, and at it."""
    worst, cap = report.worst_girth, report.cap
    above_mm = None if cap is None else report.mapped.first_mm + cap.to_mm
    girths = (
        note("exported.aop.no_girths")
        if worst is None
        else note(
            "exported.aop.girths",
            share=report.girth_change,
            change_mm=worst.change_mm,
            girth_mm=worst.limb_mm,
            height_mm=worst.height_mm,
        )
    )
    within_mm = report.above_cap_max_mm
    at_tip = (
        ()
        if cap is None
        else (
            note(
                "exported.aop.tip",
                to_mm=cap.to_mm,
                within_mm=cap.max_mm,
                change_ml=cap.volume_change_ml,
            ),
        )
    )
    return (
        note("exported.aop.costs", above_mm=above_mm, within_mm=within_mm, girths=girths),
        *at_tip,
        note("exported.aop.in_all", rms_mm=report.rms_mm, share=report.volume_change),
    )


def _require_apart(ask: Gcode, path: Path) -> None:
    if ask.write_machine is not None:
        require_place(ask.write_machine)
    for other in (ask.machine, ask.write_machine):
        if other is not None and other.resolve() == path.resolve():
            raise OptionsError("exported.gcode.one_name", name=path.name)


def _gcode(limb: AlignedLimb, path: Path, ask: Gcode, machine: Machine) -> Exported:
    options = replace(machine.carving, to_mm=ask.to_mm)
    report = write_gcode(limb, path, options, machine.control)
    kept_as = None if ask.write_machine is None else write_machine(machine, ask.write_machine)
    check = report.check
    return Exported(
        path=path,
        limb=limb,
        unit="mm",
        said=(*_gcode_findings(report, machine, kept_as), *_outside_carved(limb)),
        figures=_gcode_figures(report, limb.side, machine, kept_as),
        shown=check.carved.surface(),
        marks=limb.landmarks,
        surface_within_mm=max(check.gouge_mm, check.left_mm),
        minutes=check.minutes,
    )


def _gcode_findings(
    report: GcodeReport, machine: Machine, kept_as: Path | None
) -> tuple[Finding, ...]:
    options, control = machine.carving, machine.control
    check, blank = report.check, report.toolpath.blank
    least_deg, most_deg = report.rotary_deg
    return (
        note(
            "exported.gcode.written",
            path=str(report.path),
            lines=report.lines,
            minutes=check.minutes,
        ),
        note(
            "exported.gcode.control",
            dialect=control.dialect,
            winding=control.winding,
            word=control.letter,
            least_deg=least_deg,
            most_deg=most_deg,
            inverse_time=control.inverse_time,
        ),
        *((note("exported.gcode.grbl", word=control.letter),) if control.dialect == "grbl" else ()),
        note(
            "exported.gcode.blank",
            diameter_mm=2 * blank.radius_mm,
            from_mm=blank.from_mm,
            chuck_mm=blank.to_mm + options.ball_mm,
            tool_mm=options.tool_diameter_mm,
            a_turns=options.a_turns,
        ),
        note(
            "exported.gcode.carved",
            gouge_mm=check.gouge_mm,
            scallop_mm=check.scallop_mm,
            left_mm=check.left_mm,
            left_share=check.left_share,
        ),
        report.standing,
        *left_out_findings(report.bodies_left_out, report.loose, frame="limb"),
        *(() if kept_as is None else (note("exported.gcode.machine", path=str(kept_as)),)),
    )


def _outside_carved(limb: AlignedLimb) -> tuple[Finding, ...]:
    """A doubt that of a wall only the outer skin is carved, which is no positive of its inside."""
    wall = wall_thickness(limb.mesh_in_limb)
    if wall is None:
        return ()
    return (doubt("exported.gcode.outside_of_wall", wall_mm=wall.median_mm),)


def _gcode_figures(
    report: GcodeReport, side: Side, machine: Machine, kept_as: Path | None
) -> dict[str, Any]:
    options, control = machine.carving, machine.control
    check, blank = report.check, report.toolpath.blank
    return {
        "side": side,
        "dialect": control.dialect,
        "winding": control.winding,
        "rotary_deg": list(report.rotary_deg),
        "machine": None if kept_as is None else str(kept_as),
        "shape_sha256": report.shape_sha256,
        "bodies_left_out": report.bodies_left_out,
        "loose_bodies": _places(report.loose, _IN_LIMB),
        "lines": report.lines,
        "minutes": check.minutes,
        "blank_diameter_mm": 2 * blank.radius_mm,
        "blank_from_mm": blank.from_mm,
        "blank_to_mm": blank.to_mm,
        "a_turns": options.a_turns,
        "gouge_mm": check.gouge_mm,
        "scallop_mm": check.scallop_mm,
        "left_mm": check.left_mm,
        "left_share": check.left_share,
        "last_row_mm": report.above.last_mm,
        "proximal_cut_mm": report.above.rise_mm,
        "proximal_cut_at": report.above.side,
        "proximal_cut_share": report.above.share,
        "rapid_hits": check.rapid_hits,
    }


def _drawing(limb: Limb, path: Path, ask: Drawing) -> Exported:
    found = without_loose(limb.mesh)
    if ask.polyface:
        report = write_polyface_dxf(found.mesh, path, spacing_mm=ask.spacing_mm)
        curves, meshes = report.curves, {"meshes": report.meshes}
        split = (note("exported.dxf.split", meshes=report.meshes),) if report.meshes > 1 else ()
    else:
        curves, meshes, split = curves_of(found.mesh, ask.spacing_mm), {}, ()
        if ask.r12:
            write_triangles(found.mesh, path, "mm", curves)
        else:
            write_drawing(found.mesh, path, "mm", curves, limb.landmarks)
            split = (note("exported.dxf.landmarks", landmarks=len(limb.landmarks)),)
    sections = len(curves.sections)
    said = (
        note("exported.dxf.written", path=str(path), sections=sections),
        *split,
        note("exported.dxf.freecad"),
        _trimline(curves),
        _axes_finding(limb),
        *_body_findings(found, limb),
    )
    figures = {"sections": sections, **meshes, **_body_figures(found, limb)}
    return Exported(
        path=path,
        limb=limb,
        unit="mm",
        said=said,
        figures=figures,
        shown=found.mesh,
        marks=limb.landmarks,
    )


def _trimline(curves: Curves) -> Finding:
    """What lies on the layer of the trimline, or why there is none."""
    loops = curves.trimline
    if not loops:
        return note("exported.dxf.no_trimline", joined=loops is not None)
    ahead = (np.roll(loop, -1, axis=0) - loop for loop in loops)
    lengths_mm = tuple(float(np.linalg.norm(step, axis=1).sum()) for step in ahead)
    return note("exported.dxf.trimline", lengths_mm=lengths_mm)


def _triangles(limb: Limb, path: Path) -> Exported:
    found = without_loose(limb.mesh)
    written = limb.with_mesh(found.mesh)
    kind = format_of(path)
    if kind is None or kind.write is None or kind.holds_limbs:
        write_limb(written, path)
    else:
        kind.write(found.mesh, path, "mm")  # no shape is read of it: it needs no limb file
    unit = "mm" if kind is None else kind.unit
    said = (
        note("exported.mesh.written", path=str(path), unit=unit),
        _axes_finding(limb),
        *_body_findings(found, limb),
    )
    return Exported(
        path=path,
        limb=limb,
        unit=unit,
        said=said,
        figures=_body_figures(found, limb),
        shown=found.mesh,
        marks=limb.landmarks,
        surface_within_mm=0.0,
        volume_change=0.0,
    )


def _landmarks(limb: Limb, path: Path, ask: LandmarkBook | Landmarks) -> Exported:
    if not limb.landmarks:
        raise OptionsError("exported.no_landmarks", name=limb.name)
    rows = tuple((mark.name, *_rounded_place(mark.position_mm)) for mark in limb.landmarks)
    table = Table(title="landmarks", columns=("name", "x_mm", "y_mm", "z_mm"), rows=rows)
    as_text = isinstance(ask, Landmarks)
    write_bytes(path, csv_of(table, ask.decimal).encode() if as_text else xlsx_of([table]))
    return Exported(
        path=path,
        limb=limb,
        unit="mm",
        said=(
            note("exported.landmarks.written", path=str(path), landmarks=len(rows)),
            _axes_finding(limb),
        ),
        figures={"landmarks": len(rows)},
        shown=limb.mesh,
        marks=limb.landmarks,
    )


def _rounded_place(place_mm: Vector3) -> list[float]:
    """A place rounded to a micrometre, without negative zeros."""
    return (np.round(place_mm, 3) + 0.0).tolist()


def _axes_finding(limb: Limb) -> Finding:
    return note("exported.axes" if isinstance(limb, AlignedLimb) else "exported.not_aligned")


def _body_findings(found: OuterShape, limb: Limb) -> tuple[Finding, ...]:
    """Findings of loose bodies that a printer would make, and of other bodies."""
    frame = "limb" if isinstance(limb, AlignedLimb) else "file"
    return (*left_out_findings(len(found.loose), found.loose, frame=frame), *kept_findings(found))


def _body_figures(found: OuterShape, limb: Limb) -> dict[str, Any]:
    key = _IN_LIMB if isinstance(limb, AlignedLimb) else "in_mesh_mm"
    return {
        "bodies_left_out": len(found.loose),
        "loose_bodies": _places(found.loose, key),
        "bodies_inside": found.inside,
    }


def _places(loose: tuple[SeparateBody, ...], key: str) -> list[dict[str, Any]]:
    return [{key: body.place_mm.tolist(), "size_mm": body.size_mm} for body in loose]
