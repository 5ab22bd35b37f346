"""`limbgram align`: landmarks, side and axes of a shape, kept beside it."""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from jaxtyping import UInt8

from limbgram.cli.replies import Reply, answered
from limbgram.cli.shapes import (
    READ,
    UnitOption,
    asks_for_marks,
    colour_of,
    direction,
    landmarks_of,
    pair_of,
    shape_of,
    sticker_names,
)
from limbgram.core.errors import OptionsError, with_full_stop
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.interval import Interval, explained, plus_minus
from limbgram.findings import note
from limbgram.formats.limb_file import write_limb_file
from limbgram.formats.reading import ShapeFile
from limbgram.formats.sidecar import limb_file_beside
from limbgram.workbench.bodies import outside_of
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.frame.landmarks import NAMES, LandmarkName, frame_of, with_landmarks
from limbgram.workbench.frame.names import LANGUAGES, NAMES_IN
from limbgram.workbench.limb import Landmark, Limb

_FIT = "fit"
_SHOWN_AT_MOST = 12
_MOST_SHARED = 0.4


class SideName(StrEnum):
    """Side of the patient."""

    LEFT = "left"
    RIGHT = "right"
    NONE = "none"


class KindName(StrEnum):
    """Kind of limb, for the names of its landmarks."""

    TRANSTIBIAL = "transtibial"
    TRANSFEMORAL = "transfemoral"
    FOOT = "foot"
    TORSO = "torso"


@answered
def align_command(
    shape: Annotated[
        Path | None,
        typer.Argument(help=f"The shape: {READ}.", show_default=False),
    ] = None,
    side: Annotated[
        SideName | None, typer.Option(help="Side of the patient: never guessed. none for a torso.")
    ] = None,
    kind: Annotated[
        KindName | None,
        typer.Option(help="What the names of the landmarks mean; kept with the shape."),
    ] = None,
    landmark: Annotated[
        list[str] | None,
        typer.Option(
            help="NAME=X,Y,Z in mm in the frame of the shape, or NAME=#2 for a painted mark. "
            "Repeat it; it is moved to the nearest place on the surface."
        ),
    ] = None,
    axis: Annotated[
        str | None,
        typer.Option(
            help="Long axis, pointing proximally: +z; or fit.",
            show_default="an AOP's own axis and origin, else fit",
        ),
    ] = None,
    proximal: Annotated[
        str | None,
        typer.Option(help="Roughly towards the body, if nothing else tells, or for a foot: +z."),
    ] = None,
    anterior: Annotated[
        str | None,
        typer.Option(
            help="Roughly forwards, instead of landmarks or an AOP's own: +y or 0.2,-1,0."
        ),
    ] = None,
    plumb: Annotated[
        str | None,
        typer.Option(help="UPPER:LOWER landmarks to lie one above the other in the side view."),
    ] = None,
    flexion: Annotated[
        float,
        typer.Option(help="Turn further, -120 to 120 degrees; positive takes the top backwards."),
    ] = 0.0,
    marks: Annotated[
        bool, typer.Option("--marks", help="Only list the painted marks that are seen.")
    ] = False,
    photos: Annotated[
        Path | None,
        typer.Option(
            metavar="CASE",
            help="Look for painted marks in the photos of the case that made the shape.",
            show_default="in the shape's own colours",
        ),
    ] = None,
    stickers: Annotated[
        Path | None,
        typer.Option(
            help='Names of coded stickers, a JSON file such as {"12": "fibula head"}: with '
            "--photos each is the landmark of its name."
        ),
    ] = None,
    colour: Annotated[
        str | None,
        typer.Option(
            help="Colour of the painted marks: magenta, or red,green,blue from 0 to 255.",
            show_default="any that the sock's paint does not have",
        ),
    ] = None,
    names: Annotated[
        bool, typer.Option("--names", help="Only list the landmark names of --kind.")
    ] = False,
    unit: UnitOption = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,  # noqa: ARG001
) -> Reply:
    """Give a shape its axes: +Z proximal, +Y anterior, +X the patient's right, origin distal.

    The shape's file stays as it is; landmarks, side and axes are kept in NAME.limb.json beside it.
    """
    if names:
        return _names(kind)
    if shape is None:
        raise OptionsError("options.align.no_shape", ending=READ)
    read = shape_of(shape, unit)
    limb = read.limb
    wanted = marks or asks_for_marks(landmark or [])
    if stickers is not None and photos is None:
        raise OptionsError("options.align.stickers_without_photos")
    if not wanted and ((photos is not None and stickers is None) or colour is not None):
        raise OptionsError("options.align.photos_for_marks")
    seen = _marks_seen(limb, photos, colour) if wanted else None
    if marks and seen is not None:
        return seen.reply
    if side is None:
        raise OptionsError("options.align.side")
    options = AlignOptions(
        side=side.value,
        kind=None if kind is None else kind.value,
        axis=None if axis == _FIT else direction(axis, "--axis"),
        fit_anew=axis == _FIT,
        proximal=direction(proximal, "--proximal"),
        anterior=direction(anterior, "--anterior"),
        plumb=None if plumb is None else pair_of(plumb, "--plumb"),
        flexion_deg=flexion,
        declared=read.declared,
    )
    named = landmarks_of(landmark or [], () if seen is None else seen.places_mm)
    if stickers is not None and photos is not None:
        named = (*named, *_sticker_landmarks(limb, photos, sticker_names(stickers)))
    aligned = align(with_landmarks(limb, named), options)
    return _kept(aligned, shape, read)


def _kept(limb: Limb, shape: Path, read: ShapeFile) -> Reply:
    """Write the limb file, and say where the limb lies now."""
    written = write_limb_file(limb, shape, mm_per_unit=read.mm_per_unit, sha256=read.sha256)
    frame = frame_of(limb)
    motion = frame.limb_from_mesh
    limb = outside_of(limb)
    size = np.ptp(motion.apply(limb.mesh.vertices_mm), axis=0)
    places = {mark.name: motion.apply(mark.position_mm[None])[0] for mark in limb.landmarks}
    lines = [
        *(f"Note: {with_full_stop(note)}" for note in limb.notes),
        f"Side: {frame.side}. {size[2]:.1f} mm along the axis, {size[0]:.1f} mm from side to "
        f"side, {size[1]:.1f} mm from front to back.",
        *(
            f"  {name:<28} right {x:7.1f}   anterior {y:7.1f}   proximal {z:7.1f} mm"
            for name, (x, y, z) in places.items()
        ),
        f"Written: {written}",
    ]
    content: dict[str, Any] = {
        "side": frame.side,
        "limb_from_mesh": {
            "rotation": motion.rotation.tolist(),
            "translation_mm": motion.translation.tolist(),
        },
        "size_mm": size.tolist(),
        "landmarks": [
            {"name": name, "in_limb_mm": place.tolist()} for name, place in places.items()
        ],
        "kind": limb.kind,
        "notes": list(limb.notes),
        "written": str(limb_file_beside(shape)),
    }
    return Reply(tuple(lines), content)


def _names(kind: KindName | None) -> Reply:
    chosen = {name: rows for name, rows in NAMES.items() if kind is None or name == kind.value}
    lines = [line for name, rows in chosen.items() for line in (f"{name}:", *map(_line, rows))]
    content = {
        name: [
            {
                "name": row.name,
                "facing": row.facing,
                "level": row.level,
                "names": {language: NAMES_IN[language][row.name] for language in LANGUAGES},
            }
            for row in rows
        ]
        for name, rows in chosen.items()
    }
    return Reply(tuple(lines), content)


def _line(row: LandmarkName) -> str:
    """A place, the side on which it lies, and its name in the other languages."""
    others = ", ".join(NAMES_IN[language][row.name][0] for language in LANGUAGES[1:])
    return f"  {row.name:<32}{row.facing:<11}{others}"


@dataclass(frozen=True)
class _Seen:
    """Marks in the order of their numbers, and a reply that lists them."""

    places_mm: tuple[Vector3, ...]
    reply: Reply


def _marks_seen(limb: Limb, case: Path | None, colour: str | None) -> _Seen:
    """The marks on a shape: from the photos of its case if there is one, else from its colours."""
    wanted = colour_of(colour)
    return _on_shape(limb, wanted) if case is None else _in_photos(limb, case, wanted)


def _on_shape(limb: Limb, colour: tuple[int, int, int] | None) -> _Seen:
    from limbgram.workbench.frame.marks import MarkOptions, find_marks

    found = find_marks(limb.mesh, MarkOptions(colour=colour))
    lines = [
        f"#{number}: {mark.diameter_mm:4.1f} mm across, colour {_rgb(mark.colour)}, at "
        f"{_place(mark.position_mm)}"
        for number, mark in enumerate(found, 1)
    ]
    content = [
        {
            "number": number,
            "position_mm": mark.position_mm.tolist(),
            "colour": mark.colour.tolist(),
            "diameter_mm": mark.diameter_mm,
        }
        for number, mark in enumerate(found, 1)
    ]
    none = "No painted mark is seen: none is round, of one strong colour and size."
    return _Seen(
        tuple(mark.position_mm for mark in found),
        Reply(tuple(lines) or (none,), {"marks": content, "left_out": []}),
    )


def _in_photos(limb: Limb, case: Path, colour: tuple[int, int, int] | None) -> _Seen:
    from limbgram.cases.assessing import painted_marks_of
    from limbgram.cases.folder import CaseFolder
    from limbgram.workbench.marks.finding import PaintedOptions

    found = painted_marks_of(CaseFolder(case), limb.mesh, PaintedOptions(colour=colour))
    lines = [
        f"#{number}: {mark.diameter_mm:4.1f} mm across, colour {_rgb(mark.colour)}, at "
        f"{_place(mark.position_mm)} {plus_minus(Interval.of_sigma(mark.sigma_mm), 2)} mm, in "
        f"{len(mark.photos)} of {mark.looking} photos that look at it"
        for number, mark in enumerate(found.marks, 1)
    ]
    lines = lines or [
        "No mark is seen that several photos agree on. Say its colour with --colour; a mark is a "
        "round spot, 4 to 30 mm across, of a colour that the sock does not have."
    ]
    if found.marks and found.shared_share > _MOST_SHARED:
        lines.append(
            f"The sock has that colour too: {found.shared_share:.0%} of it lies outside round "
            "spots. Look at each place before you name it."
        )
    left_out = [
        f"Not offered: a spot of colour {_rgb(spot.colour)} at {_place(spot.position_mm)}: "
        f"{spot.reason}."
        for spot in found.left_out
    ]
    lines += left_out[:_SHOWN_AT_MOST]
    if len(left_out) > _SHOWN_AT_MOST:
        lines.append(f"... and {len(left_out) - _SHOWN_AT_MOST} more.")
    content: dict[str, Any] = {
        "shared_share": found.shared_share,
        "marks": [
            {
                "number": number,
                "position_mm": mark.position_mm.tolist(),
                "colour": mark.colour.tolist(),
                "diameter_mm": mark.diameter_mm,
                "spread_mm": mark.spread_mm,
                "sigma_mm": mark.sigma_mm,
                "photos": list(mark.photos),
                "photos_looking": mark.looking,
            }
            for number, mark in enumerate(found.marks, 1)
        ],
        "left_out": [
            {
                "position_mm": spot.position_mm.tolist(),
                "colour": spot.colour.tolist(),
                "reason": spot.reason,
            }
            for spot in found.left_out
        ],
    }
    return _Seen(tuple(mark.position_mm for mark in found.marks), Reply(explained(lines), content))


def _sticker_landmarks(limb: Limb, case: Path, names: dict[int, str]) -> tuple[Landmark, ...]:
    """The stickers that have a name, where the photos of the case put them.

    Raises:
        OptionsError: a named one has no place.
    """
    from limbgram.cases.assessing import stickers_of
    from limbgram.cases.folder import CaseFolder

    found = stickers_of(CaseFolder(case), limb.mesh)
    places = {one.mark_id: one.position_mm for one in found.placed}
    reasons = {one.mark_id: one.reason for one in found.lost}
    missing = [
        note("options.align.sticker_lost", number=number, name=name, reason=reasons.get(number))
        for number, name in names.items()
        if number not in places
    ]
    if missing:
        raise OptionsError(
            "options.align.stickers_lost", stickers=tuple(missing), seen=tuple(places) or None
        )
    return tuple(Landmark(name=name, position_mm=places[number]) for number, name in names.items())


def _rgb(colour: UInt8[np.ndarray, "3"]) -> tuple[int, ...]:
    return tuple(colour.tolist())


def _place(position_mm: Vector3) -> str:
    return ",".join(f"{value:.1f}" for value in position_mm)
