"""`limbgram plan`: how to photograph a limb so that its surface becomes as sure as is asked."""

from pathlib import Path
from typing import Annotated

import typer

from limbgram.capture.plan import (
    CapturePlan,
    LimbForm,
    PlannedCamera,
    PlanOptions,
    Sock,
    form_of,
    plain_limb,
    plan_capture,
)
from limbgram.capture.proxy import LimbProxy
from limbgram.capture.stands import Stand
from limbgram.cli.replies import Reply, answered
from limbgram.core.errors import OptionsError, printable
from limbgram.core.files import write_bytes
from limbgram.core.typed import tree_of
from limbgram.findings import told
from limbgram.formats.camera import read_camera
from limbgram.report.drawings.coverage import plan_picture


@answered
def plan_command(
    sigma: Annotated[
        float,
        typer.Option(help="One standard deviation, mm, that nine tenths of the surface reach."),
    ],
    distance: Annotated[
        float | None,
        typer.Option(
            help="From the camera to the limb's middle, mm.",
            show_default="the nearest at which the limb fits into the picture",
        ),
    ] = None,
    limb: Annotated[LimbForm, typer.Option(help="Rough form of the limb.")] = LimbForm.LOWER_LEG,
    diameter: Annotated[
        float | None, typer.Option(help="Of the limb, mm, instead of --limb; with --length.")
    ] = None,
    length: Annotated[float | None, typer.Option(help="Of the limb, mm; with --diameter.")] = None,
    camera: Annotated[
        Path | None, typer.Option(help="Camera file of `limbgram calibrate`.")
    ] = None,
    focal: Annotated[float | None, typer.Option(help="Focal length, mm, if no --camera.")] = None,
    sensor: Annotated[
        float | None,
        typer.Option(help="Width of the sensor, mm: 36 full frame, 23.5 APS-C, 6 to 10 phones."),
    ] = None,
    pixels: Annotated[
        str | None, typer.Option(help="Size of a photo, such as 6000x4000, if no --camera.")
    ] = None,
    aperture: Annotated[
        float | None, typer.Option(help="F-number, where it cannot be chosen, as in a phone.")
    ] = None,
    sock: Annotated[
        Sock, typer.Option(help="Painted by hand, or printed with the pattern of `print sock`.")
    ] = Sock.PAINTED,
    picture: Annotated[
        Path | None,
        typer.Option(help="Write a picture (PNG): the ring from above and the expected interval."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,  # noqa: ARG001
) -> Reply:
    """Say how many photos, from how high and how far, at which aperture, how large to paint.

    The fewest photos are looked for that reach the sigma all round, with the formula that
    `limbgram check` uses. How sharp the photos will be follows from the board photos of the camera
    file; without one, a good lens and a still hand are taken. What cannot be reached is refused
    with what would reach it.

    Example: limbgram plan --sigma 0.05 --distance 900 --focal 35 --sensor 22.3 --pixels 6000x4000
    """
    found = plan_capture(
        sigma,
        _camera(camera, focal, sensor, pixels, aperture),
        _limb(limb, diameter, length),
        distance,
        PlanOptions(sock=sock),
    )
    lines = (told(found.summary), *(f"  {told(one)}" for one in found.steps))
    if picture is not None:
        write_bytes(picture, _picture(found))
        lines = (*lines, f"Picture: {printable(str(picture))}")
    return Reply(lines, tree_of(found), "green")


def _camera(
    file: Path | None,
    focal_mm: float | None,
    sensor_mm: float | None,
    pixels: str | None,
    aperture: float | None,
) -> PlannedCamera:
    if file is not None:
        if focal_mm is not None or pixels is not None:
            raise OptionsError("options.plan.camera_tells")
        known = read_camera(file)
        return PlannedCamera(
            camera=known.camera,
            sensor_width_mm=sensor_mm,
            aperture=aperture,
            edge_px=known.edge_px,
        )
    if focal_mm is None or sensor_mm is None or pixels is None:
        raise OptionsError("options.plan.no_camera")
    sides = pixels.lower().split("x")
    if len(sides) != 2 or not all(side.isdecimal() for side in sides):
        raise OptionsError("options.plan.pixels", pixels=printable(pixels))
    return PlannedCamera.of(focal_mm, sensor_mm, int(sides[0]), int(sides[1]), aperture)


def _limb(form: LimbForm, diameter_mm: float | None, length_mm: float | None) -> LimbProxy:
    if diameter_mm is None and length_mm is None:
        return form_of(form)
    if diameter_mm is None or length_mm is None:
        raise OptionsError("options.plan.diameter_and_length")
    return plain_limb(diameter_mm, length_mm)


def _picture(plan: CapturePlan) -> bytes:
    stands = [
        Stand(azimuth_deg=turn, elevation_deg=ring.elevation_deg, distance=plan.distance_mm)
        for ring in plan.rings
        for turn in ring.azimuths_deg
    ]
    title = f"Plan: {plan.photos} photos from {plan.distance_mm:.0f} mm"
    return plan_picture(title, stands, plan.coverage).tobytes()
