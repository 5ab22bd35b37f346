"""Plan: how a limb is to be photographed, from what people know of limb and camera.

In      the sigma that is asked for, a camera file or what a data sheet tells, the limb's form.
Out     a CapturePlan.
Fails   a camera that is told twice or by half; PlanError as `capture.plan` says.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from limbgram.capture.plan import (
    CapturePlan,
    LimbForm,
    PlannedCamera,
    Sock,
    form_of,
    plain_limb,
    plan_capture,
)
from limbgram.capture.proxy import LimbProxy
from limbgram.core.errors import OptionsError, printable
from limbgram.core.request_fields import Flag
from limbgram.formats.camera import read_camera


@dataclass(frozen=True, kw_only=True)
class PlanRequest:
    """How sure the surface is to be, and with what it is photographed."""

    sigma_mm: Annotated[float, Flag("sigma")]
    """One standard deviation, mm, that nine tenths of the surface reach."""
    distance_mm: Annotated[float | None, Flag("distance")] = None
    """From the camera to the limb's middle, mm; without it the nearest at which the limb fits into
    the picture."""
    limb: LimbForm = LimbForm.LOWER_LEG
    """Rough form of the limb."""
    diameter_mm: Annotated[float | None, Flag("diameter")] = None
    """Diameter of the limb, mm, in place of --limb; give --length too."""
    length_mm: Annotated[float | None, Flag("length")] = None
    """Length of the limb, mm; give --diameter too."""
    camera: Path | None = None
    """Camera file of `limbgram calibrate`."""
    focal_mm: Annotated[float | None, Flag("focal")] = None
    """Focal length, mm, if no --camera."""
    sensor_mm: Annotated[float | None, Flag("sensor")] = None
    """Width of the sensor, mm: 36 full frame, 23.5 APS-C, 6 to 10 phones."""
    pixels: str | None = None
    """Size of a photo, such as 6000x4000, if no --camera."""
    aperture: float | None = None
    """F-number, where it cannot be chosen, as in a phone."""
    sock: Sock = Sock.PAINTED
    """Painted by hand, or printed with the pattern of `print sock`."""

    def with_camera(self) -> PlannedCamera:
        """The camera of the file, or of what a data sheet tells.

        Raises:
            OptionsError: it is told twice, or by half.
        """
        if self.camera is not None:
            if self.focal_mm is not None or self.pixels is not None:
                raise OptionsError("options.plan.camera_tells")
            known = read_camera(self.camera)
            return PlannedCamera(
                camera=known.camera,
                sensor_width_mm=self.sensor_mm,
                aperture=self.aperture,
                edge_px=known.edge_px,
            )
        if self.focal_mm is None or self.sensor_mm is None or self.pixels is None:
            raise OptionsError("options.plan.no_camera")
        sides = self.pixels.lower().split("x")
        if len(sides) != 2 or not all(side.isdecimal() for side in sides):
            raise OptionsError("options.plan.pixels", pixels=printable(self.pixels))
        width_px, height_px = map(int, sides)
        return PlannedCamera.of(self.focal_mm, self.sensor_mm, width_px, height_px, self.aperture)

    def of_limb(self) -> LimbProxy:
        """The limb's rough form.

        Raises:
            OptionsError: its size is told by half.
        """
        if self.diameter_mm is None and self.length_mm is None:
            return form_of(self.limb)
        if self.diameter_mm is None or self.length_mm is None:
            raise OptionsError("options.plan.diameter_and_length")
        return plain_limb(self.diameter_mm, self.length_mm)


def plan(ask: PlanRequest) -> CapturePlan:
    """The fewest photos that reach the sigma all round.

    Raises:
        OptionsError: camera or limb are told twice, or by half.
        PlanError: the limb does not fit into the picture, or no number of photos reaches the sigma.
    """
    return plan_capture(ask.sigma_mm, ask.with_camera(), ask.of_limb(), ask.distance_mm, ask.sock)
