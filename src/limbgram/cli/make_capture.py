"""`limbgram make-capture`: photographs of a synthetic limb, with their truth."""

from enum import Enum
from pathlib import Path
from typing import Annotated, Any

import typer

from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, answered
from limbgram.cli.shapes import UnitOption
from limbgram.core.errors import OptionsError
from limbgram.core.run import Run
from limbgram.formats.units import mm_per_unit_of
from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.movement import Movement, MovementKind
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.photographer import Lens
from limbgram.synthetic.props.gauges import BallBar, Gauge, GaugeCylinder
from limbgram.synthetic.props.paint import scattered_spots
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


_GAUGES: dict[GaugeName, Gauge] = {
    GaugeName.BALL_BAR: BallBar(),
    GaugeName.CYLINDER: GaugeCylinder(),
}
_GAUGE_FROM_MM = 1400.0
_PHONE_FROM_MM = 500.0
_SWAY_MM = 6.0
"""How far a patient on a stool leans to and fro."""


@answered
def make_capture_command(
    folder: Annotated[Path, typer.Argument(help="New folder for the capture.")],
    photos: Annotated[int, typer.Option(min=4, max=60, help="Photos of the limb.")] = 15,
    rings: Annotated[int, typer.Option(min=1, max=3, help="Heights of the walk round.")] = 1,
    width: Annotated[int, typer.Option(min=300, max=6000, help="Photo width, pixels.")] = 1500,
    seed: Annotated[int, typer.Option(min=0, help="Another seed, another limb and walk.")] = 11,
    coverage: Annotated[
        float, typer.Option(help="Share of the sock that paint hides; 0 is a plain sock.")
    ] = 0.55,
    marks: Annotated[
        int, typer.Option(min=0, max=12, help="Round magenta marks painted at known places.")
    ] = 0,
    shape: Annotated[
        Path | None,
        typer.Option(
            help="A scan of a limb (STL, OBJ, PLY, AOP ...) that is painted and photographed "
            "instead of a limb of ours. It stands with its closed end up, and the camera goes as "
            "far off as it takes to fill the photos.",
        ),
    ] = None,
    unit: UnitOption = None,
    gauge: Annotated[
        GaugeName | None,
        typer.Option(
            help="A painted gauge instead of a limb, from 1.4 m; truth/artefact.json is its "
            "artefact file for `limbgram verify-setup`."
        ),
    ] = None,
    movement: Annotated[
        MovementKind | None,
        typer.Option(help="What moves between the photos: the limb in a step, in a slow drift ..."),
    ] = None,
    movement_mm: Annotated[
        float, typer.Option(help="How far it moves, mm, 0 to 30, with --movement.")
    ] = 8.0,
    turned: Annotated[
        Turned | None,
        typer.Option(
            help="turntable: the camera stands still, in a patterned room, and limb and board "
            "turn. stool: the same, of a patient who sways. over: a cast that stands for the "
            "first half of the photos and lies for the others. Else the camera walks round."
        ),
    ] = None,
    phone: Annotated[
        bool,
        typer.Option(
            "--phone", help="A phone's main camera from 0.5 m, 4:3, instead of 50 mm from 1.5 m."
        ),
    ] = False,
    fault: Annotated[
        list[Fault] | None,
        typer.Option(
            help="A fault of real captures at its usual strength, which truth/notes.json and "
            "cameras.json record. Give it several times for several."
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,
) -> Reply:
    """Make photos of a synthetic painted limb, calibration photos, and the exact truth."""
    if phone and gauge is not None:
        raise OptionsError("Gauges are photographed from 1.4 m. Leave out --phone or --gauge.")
    if shape is not None and gauge is not None:
        raise OptionsError("A scan or a gauge can stand there. Leave out --shape or --gauge.")
    if unit is not None and shape is None:
        raise OptionsError("--unit is the unit of a scan's file. Give the file by --shape.")
    scan = (
        None if shape is None else read_scan(shape, None if unit is None else mm_per_unit_of(unit))
    )
    options = CaptureOptions(
        photos=photos,
        rings=rings,
        width_px=width,
        height_px=round(width * (3 / 4 if phone else 2 / 3)),
        seed=seed,
        coverage=coverage,
        spots=scattered_spots(marks),
        turning=_turning(turned),
        scan=scan,
        gauge=None if gauge is None else _GAUGES[gauge],
        lens=PHONE if phone else Lens(),
        distance_mm=_distance_mm(phone, gauge, scan),
        movement=None if movement is None else Movement(kind=movement, shift_mm=movement_mm),
    )
    options = with_faults(options, fault or ())
    with display(as_json) as screen:
        capture = Run(listener=screen.listen)(make_capture, folder, options)
    about = tuple(f"Of the scan, {note}." for note in scan.notes) if scan else ()
    return Reply(
        (
            *about,
            f"{len(capture.photos)} photos of the limb and "
            f"{len(capture.calibration_photos)} of the calibration board are in {folder}.",
        ),
        {"folder": str(folder), "photos": len(capture.photos), **_told(scan)},
    )


def _told(scan: Scan | None) -> dict[str, Any]:
    if scan is None:
        return {}
    return {"scan": {"sha256": scan.sha256, "height_mm": scan.height_mm, "notes": [*scan.notes]}}


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
