"""Make a capture: photographs of a synthetic limb, a scan or a gauge, with their truth.

In      what stands there, its paint and skin, the camera's walk, what goes wrong.
Out     a folder of images, calibration and truth; Made: its photos, and the scan if it was one.
Fails   what cannot stand together, or be made.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final, Literal

from limbgram.core.errors import OptionsError
from limbgram.core.request_fields import Panel, Within
from limbgram.core.run import Run
from limbgram.formats.units import mm_per_unit_of
from limbgram.synthetic.capture import Capture, make_capture
from limbgram.synthetic.movement import Movement, MovementKind
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.photographer import Lens
from limbgram.synthetic.props.bent import BentShape
from limbgram.synthetic.props.details import SkinDetails
from limbgram.synthetic.props.gauges import BallBar, Gauge, GaugeCylinder
from limbgram.synthetic.props.limb import LimbKind, Relief
from limbgram.synthetic.props.paint import Paint, scattered_spots
from limbgram.synthetic.props.scan import Scan, distance_for, read_scan
from limbgram.synthetic.turned_limb import TurnedOver, Turning
from limbgram.synthetic.usual_faults import PHONE, Fault, with_faults

GaugeName = Literal["ball-bar", "cylinder"]
Detail = Literal["knit", "veins", "scars", "wrinkles"]
Turned = Literal["turntable", "stool", "over"]

_OBJECT, _SKIN = Panel("What stands there"), Panel("Paint and skin")
_CAMERA, _WRONG = Panel("Camera and walk"), Panel("What goes wrong")


@dataclass(frozen=True, kw_only=True)
class MakeRequest:
    """Which limb, how it is painted, how it is photographed, and what goes wrong."""

    seed: Annotated[int, Within(0, 2**63 - 1)] = CaptureOptions.seed
    """Another seed, another limb and walk."""
    kind: Annotated[LimbKind, _OBJECT] = CaptureOptions.kind
    """Which limb of ours."""
    shape: Annotated[Path | None, _OBJECT] = None
    """A scan of a limb that is painted and photographed instead of one of ours: STL, PLY or another
    kind of file that `limbgram measure` reads. It stands with its closed end up, a foot with its
    shank upside down, and the camera goes as far off as it takes to fill the photos. What is
    photographed is the truth, in truth/mesh.ply."""
    unit: Annotated[str | None, _OBJECT] = None
    """Unit of the scan's file: mm, cm, m, inch, or so many mm."""
    gauge: Annotated[GaugeName | None, _OBJECT] = None
    """A painted gauge instead of a limb, from 1.4 m; truth/artefact.json is its artefact file for
    `limbgram verify-setup`."""
    paint: Annotated[Paint, _SKIN] = CaptureOptions.paint
    """dabs: fabric paint on a white sock. print: a sock with a printed pattern."""
    coverage: Annotated[float, _SKIN] = CaptureOptions.coverage
    """Share of the sock that dabs hide, 0 to 0.9; 0 is a plain sock."""
    bare: Annotated[float, _SKIN] = CaptureOptions.bare
    """Share of the dabs that are left out in patches, 0 to below 1."""
    uneven: Annotated[float, _SKIN] = CaptureOptions.uneven
    """Share of the dabs that are left out on one side of the limb, fewer and fewer towards the
    other side, 0 to 1."""
    marks: Annotated[int, Within(0, 12), _SKIN] = 0
    """Round magenta marks painted at known places."""
    relief: Annotated[float, _SKIN] = Relief.rms_mm
    """Height of the fine relief, root mean square, mm, 0 to 2; 0 is smooth."""
    detail: Annotated[tuple[Detail, ...], _SKIN] = ()
    """Details of the skin, each of its usual height: the knit of the sock (0.1 mm), veins
    (0.7), scars (0.7), wrinkles (1.0). A capture with knit takes longer."""
    photos: Annotated[int, Within(4, 60), _CAMERA] = CaptureOptions.photos
    """Photos of the limb."""
    rings: Annotated[int, Within(1, 3), _CAMERA] = CaptureOptions.rings
    """Heights of the walk round."""
    width: Annotated[int, Within(300, 6000), _CAMERA] = CaptureOptions.width_px
    """Photo width, pixels."""
    phone: Annotated[bool, _CAMERA] = False
    """A phone's main camera from 0.5 m, 4:3, instead of 50 mm from 1.5 m."""
    turned: Annotated[Turned | None, _CAMERA] = None
    """turntable: the camera stands still, in a patterned room, and limb and board turn. stool: the
    same, of a patient who sways. over: a cast that stands for the first half of the photos and lies
    for the others. Else the camera walks round."""
    movement: Annotated[MovementKind | None, _WRONG] = None
    """What moves: the limb once at half time, evenly, at random in each photo, or by leaning over
    in the second half; or the board, pushed at half time."""
    movement_mm: Annotated[float, _WRONG] = Movement.shift_mm
    """How far it moves, mm, 0 to 30, with --movement."""
    fault: Annotated[tuple[Fault, ...], _WRONG] = ()
    """A fault of real captures at its usual strength, which truth/notes.json and cameras.json
    record."""

    def options(self, scan: Scan | BentShape | None) -> CaptureOptions:
        """The options of the capture maker.

        Raises:
            OptionsError: there can be no such capture.
        """
        details = _details_of_usual_height(self.detail)
        options = CaptureOptions(
            kind=self.kind,
            scan=scan,
            gauge=None if self.gauge is None else _GAUGES[self.gauge],
            seed=self.seed,
            paint=self.paint,
            coverage=self.coverage,
            bare=self.bare,
            uneven=self.uneven,
            spots=scattered_spots(self.marks),
            relief=Relief(rms_mm=self.relief),
            details=details,
            mesh_step_mm=min(CaptureOptions.mesh_step_mm, details.coarsest_step_mm),
            photos=self.photos,
            rings=self.rings,
            width_px=self.width,
            height_px=round(self.width * (3 / 4 if self.phone else 2 / 3)),
            turning=None if self.turned is None else _TURNED[self.turned],
            lens=PHONE if self.phone else Lens(),
            distance_mm=self._distance_mm(scan),
            movement=None
            if self.movement is None
            else Movement(kind=self.movement, shift_mm=self.movement_mm),
        )
        return with_faults(options, self.fault)

    def scan(self) -> Scan | BentShape | None:
        """The shape that is photographed, if it is one from a file.

        Raises:
            OptionsError: what was asked for cannot stand together.
            ShapeFileError: the file cannot be read.
        """
        if self.phone and self.gauge is not None:
            raise OptionsError("options.make.gauge_by_phone")
        if self.shape is None:
            if self.unit is not None:
                raise OptionsError("options.make.unit_without_shape")
            return None
        if self.gauge is not None:
            raise OptionsError("options.make.shape_and_gauge")
        return read_scan(self.shape, None if self.unit is None else mm_per_unit_of(self.unit))

    def _distance_mm(self, scan: Scan | BentShape | None) -> float:
        usual_mm = _PHONE_FROM_MM if self.phone else CaptureOptions.distance_mm
        if scan is not None:
            return distance_for(scan, usual_mm)
        return usual_mm if self.gauge is None else _GAUGE_FROM_MM


_GAUGES: Final[dict[GaugeName, Gauge]] = {"ball-bar": BallBar(), "cylinder": GaugeCylinder()}
_USUAL = SkinDetails(knit_mm=0.1, veins_mm=0.7, scars_mm=0.7, wrinkles_mm=1.0)
_GAUGE_FROM_MM = 1400.0
_PHONE_FROM_MM = 500.0
_SWAY_MM = 6.0
"""How far a patient on a stool leans to and fro."""
_TURNED: Final[dict[Turned, Turning | TurnedOver]] = {
    "turntable": Turning(),
    "stool": Turning(sway_mm=_SWAY_MM),
    "over": TurnedOver(),
}


@dataclass(frozen=True, kw_only=True)
class MadeCapture:
    """A capture that was made."""

    capture: Capture
    scan: Scan | BentShape | None
    """What was photographed, if it came from a file."""


def make(folder: Path, ask: MakeRequest, run: Run) -> MadeCapture:
    """Photos of a painted limb, photos of a calibration board, and the exact truth.

    Raises:
        OptionsError: what was asked for cannot be.
        ShapeFileError: the scan cannot be read.
    """
    scan = ask.scan()
    return MadeCapture(capture=run(make_capture, folder, ask.options(scan)), scan=scan)


def _details_of_usual_height(asked: Iterable[Detail]) -> SkinDetails:
    """The details that are asked for, with usual heights."""
    kinds = set(asked)
    return SkinDetails(
        knit_mm=_USUAL.knit_mm * ("knit" in kinds),
        veins_mm=_USUAL.veins_mm * ("veins" in kinds),
        scars_mm=_USUAL.scars_mm * ("scars" in kinds),
        wrinkles_mm=_USUAL.wrinkles_mm * ("wrinkles" in kinds),
    )
