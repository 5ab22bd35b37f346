"""`limbgram make-capture`: photographs of a synthetic limb, with their truth."""

from collections.abc import Iterable
from enum import Enum
from pathlib import Path
from typing import Annotated, Any

import typer

from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, answered
from limbgram.cli.shapes import READ
from limbgram.core.errors import OptionsError
from limbgram.core.run import Run
from limbgram.findings import as_json, told
from limbgram.formats.units import mm_per_unit_of
from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.movement import Movement, MovementKind
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.photographer import Lens
from limbgram.synthetic.props.details import SkinDetails
from limbgram.synthetic.props.gauges import BallBar, Gauge, GaugeCylinder
from limbgram.synthetic.props.limb import LimbKind, Relief
from limbgram.synthetic.props.paint import Paint, scattered_spots
from limbgram.synthetic.props.scan import Scan, distance_for, read_scan
from limbgram.synthetic.turning import TurnedOver, Turning
from limbgram.synthetic.usual import PHONE, Fault, with_faults


class Turned(Enum):
    """How a limb can be turned, as a user names it."""

    TURNTABLE = "turntable"
    STOOL = "stool"
    OVER = "over"


class GaugeName(Enum):
    """Gauges, as a user names them."""

    BALL_BAR = "ball-bar"
    CYLINDER = "cylinder"


class Detail(Enum):
    """What stands out of a skin, as a user names it."""

    KNIT = "knit"
    VEINS = "veins"
    SCARS = "scars"
    WRINKLES = "wrinkles"


_GAUGES: dict[GaugeName, Gauge] = {
    GaugeName.BALL_BAR: BallBar(),
    GaugeName.CYLINDER: GaugeCylinder(),
}
_USUAL = SkinDetails(knit_mm=0.1, veins_mm=0.7, scars_mm=0.7, wrinkles_mm=1.0)
_GAUGE_FROM_MM = 1400.0
_PHONE_FROM_MM = 500.0
_SWAY_MM = 6.0
"""How far a patient on a stool leans to and fro."""


_OBJECT, _SKIN, _CAMERA = "What stands there", "Paint and skin", "Camera and walk"
_WRONG = "What goes wrong"


@answered
def make_capture_command(
    folder: Annotated[Path, typer.Argument(help="New folder for the capture.")],
    seed: Annotated[int, typer.Option(min=0, help="Another seed, another limb and walk.")] = 11,
    kind: Annotated[
        LimbKind, typer.Option("--kind", help="Which limb of ours.", rich_help_panel=_OBJECT)
    ] = LimbKind.TRANSTIBIAL,
    shape: Annotated[
        Path | None,
        typer.Option(
            help="A scan of a limb that is painted and photographed instead of one of ours: "
            f"{READ}. It stands with its closed end up, and the camera goes as far off as it "
            "takes to fill the photos. What is photographed is the truth, in truth/mesh.ply.",
            rich_help_panel=_OBJECT,
        ),
    ] = None,
    unit: Annotated[
        str | None,
        typer.Option(
            help="Unit of the scan's file: mm, cm, m, inch, or so many mm.",
            rich_help_panel=_OBJECT,
        ),
    ] = None,
    gauge: Annotated[
        GaugeName | None,
        typer.Option(
            help="A painted gauge instead of a limb, from 1.4 m; truth/artefact.json is its "
            "artefact file for `limbgram verify-setup`.",
            rich_help_panel=_OBJECT,
        ),
    ] = None,
    paint: Annotated[
        Paint,
        typer.Option(
            help="dabs: fabric paint on a white sock. print: a sock with a printed pattern.",
            rich_help_panel=_SKIN,
        ),
    ] = Paint.DABS,
    coverage: Annotated[
        float,
        typer.Option(
            help="Share of the sock that dabs hide, 0 to 0.9; 0 is a plain sock.",
            rich_help_panel=_SKIN,
        ),
    ] = 0.55,
    bare: Annotated[
        float,
        typer.Option(
            help="Share of the dabs that are left out in patches, 0 to below 1.",
            rich_help_panel=_SKIN,
        ),
    ] = 0.0,
    uneven: Annotated[
        float,
        typer.Option(
            help="Share of the dabs that are left out on one side of the limb, fewer and fewer "
            "towards the other side, 0 to 1.",
            rich_help_panel=_SKIN,
        ),
    ] = 0.0,
    marks: Annotated[
        int,
        typer.Option(
            min=0,
            max=12,
            help="Round magenta marks painted at known places.",
            rich_help_panel=_SKIN,
        ),
    ] = 0,
    relief: Annotated[
        float,
        typer.Option(
            help="Height of the fine relief, root mean square, mm, 0 to 2; 0 is smooth.",
            rich_help_panel=_SKIN,
        ),
    ] = Relief.rms_mm,
    detail: Annotated[
        list[Detail] | None,
        typer.Option(
            help="What stands out of the skin besides, of usual height: the knit of the sock "
            "(0.1 mm), veins (0.7), scars (0.7), wrinkles (1.0). Give it several times for "
            "several. A capture with knit takes longer.",
            rich_help_panel=_SKIN,
        ),
    ] = None,
    photos: Annotated[
        int, typer.Option(min=4, max=60, help="Photos of the limb.", rich_help_panel=_CAMERA)
    ] = 15,
    rings: Annotated[
        int, typer.Option(min=1, max=3, help="Heights of the walk round.", rich_help_panel=_CAMERA)
    ] = 1,
    width: Annotated[
        int, typer.Option(min=300, max=6000, help="Photo width, pixels.", rich_help_panel=_CAMERA)
    ] = 1500,
    phone: Annotated[
        bool,
        typer.Option(
            "--phone",
            help="A phone's main camera from 0.5 m, 4:3, instead of 50 mm from 1.5 m.",
            rich_help_panel=_CAMERA,
        ),
    ] = False,
    turned: Annotated[
        Turned | None,
        typer.Option(
            help="turntable: the camera stands still, in a patterned room, and limb and board "
            "turn. stool: the same, of a patient who sways. over: a cast that stands for the "
            "first half of the photos and lies for the others. Else the camera walks round.",
            rich_help_panel=_CAMERA,
        ),
    ] = None,
    movement: Annotated[
        MovementKind | None,
        typer.Option(
            help="What moves between the photos: the limb in a step, in a slow drift ...",
            rich_help_panel=_WRONG,
        ),
    ] = None,
    movement_mm: Annotated[
        float,
        typer.Option(
            help="How far it moves, mm, 0 to 30, with --movement.", rich_help_panel=_WRONG
        ),
    ] = 8.0,
    fault: Annotated[
        list[Fault] | None,
        typer.Option(
            help="A fault of real captures at its usual strength, which truth/notes.json and "
            "cameras.json record. Give it several times for several.",
            rich_help_panel=_WRONG,
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,
) -> Reply:
    """Make photos of a painted limb, photos of a calibration board, and the exact truth.

    FOLDER gets images/, calibration/ and truth/: the surface, where every photo was taken from,
    and notes of all that was chosen here. The same options give the same bytes. Score a
    reconstruction of it by `limbgram accuracy CASE --truth FOLDER`.
    """
    if phone and gauge is not None:
        raise OptionsError("options.make.gauge_by_phone")
    if shape is not None and gauge is not None:
        raise OptionsError("options.make.shape_and_gauge")
    if unit is not None and shape is None:
        raise OptionsError("options.make.unit_without_shape")
    scan = (
        None if shape is None else read_scan(shape, None if unit is None else mm_per_unit_of(unit))
    )
    details = _details(detail or ())
    options = CaptureOptions(
        kind=kind,
        scan=scan,
        gauge=None if gauge is None else _GAUGES[gauge],
        seed=seed,
        paint=paint,
        coverage=coverage,
        bare=bare,
        uneven=uneven,
        spots=scattered_spots(marks),
        relief=Relief(rms_mm=relief),
        details=details,
        mesh_step_mm=min(CaptureOptions.mesh_step_mm, details.coarsest_step_mm),
        photos=photos,
        rings=rings,
        width_px=width,
        height_px=round(width * (3 / 4 if phone else 2 / 3)),
        turning=_turning(turned),
        lens=PHONE if phone else Lens(),
        distance_mm=_distance_mm(phone, gauge, scan),
        movement=None if movement is None else Movement(kind=movement, shift_mm=movement_mm),
    )
    options = with_faults(options, fault or ())
    with display(as_json) as screen:
        capture = Run(listener=screen.listen)(make_capture, folder, options)
    about = tuple(f"Of the scan, {told(note)}." for note in scan.notes) if scan else ()
    return Reply(
        (
            *about,
            f"{len(capture.photos)} photos of the limb and "
            f"{len(capture.calibration_photos)} of the calibration board are in {folder}.",
        ),
        {"folder": str(folder), "photos": len(capture.photos), **_told(scan)},
    )


def _details(asked: Iterable[Detail]) -> SkinDetails:
    """Those that are asked for, of usual height."""
    kinds = set(asked)
    return SkinDetails(
        knit_mm=_USUAL.knit_mm * (Detail.KNIT in kinds),
        veins_mm=_USUAL.veins_mm * (Detail.VEINS in kinds),
        scars_mm=_USUAL.scars_mm * (Detail.SCARS in kinds),
        wrinkles_mm=_USUAL.wrinkles_mm * (Detail.WRINKLES in kinds),
    )


def _told(scan: Scan | None) -> dict[str, Any]:
    if scan is None:
        return {}
    return {
        "scan": {
            "sha256": scan.sha256,
            "height_mm": scan.height_mm,
            "notes": [as_json(note) for note in scan.notes],
        }
    }


def _distance_mm(phone: bool, gauge: GaugeName | None, scan: Scan | None) -> float:
    usual_mm = _PHONE_FROM_MM if phone else CaptureOptions.distance_mm
    if scan is not None:
        return distance_for(scan, usual_mm)
    return usual_mm if gauge is None else _GAUGE_FROM_MM


def _turning(named: Turned | None) -> Turning | TurnedOver | None:
    match named:
        case None:
            return None
        case Turned.TURNTABLE:
            return Turning()
        case Turned.STOOL:
            return Turning(sway_mm=_SWAY_MM)
        case Turned.OVER:
            return TurnedOver()
