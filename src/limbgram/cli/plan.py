"""`limbgram plan`: how to photograph a limb so that its surface becomes as sure as is asked."""

from pathlib import Path
from typing import Annotated

import typer

from limbgram.capture.camera_positions import Stand
from limbgram.capture.plan import CapturePlan
from limbgram.cli.replies import Reply, answered, spoken
from limbgram.cli.request_options import asking
from limbgram.core.errors import printable
from limbgram.core.files import write_bytes
from limbgram.core.typed import tree_of
from limbgram.report.drawings.coverage import plan_picture
from limbgram.services.plan import PlanRequest, plan


@answered
@asking
def plan_command(
    ask: PlanRequest,
    picture: Annotated[
        Path | None,
        typer.Option(help="Write a picture (PNG): the ring from above and the expected interval."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,  # noqa: ARG001
) -> Reply:
    """Plan a capture: number of photos, heights, distance, aperture, size of the paint.

    The fewest photos are looked for that reach the sigma all round, with the formula that
    `limbgram check` uses. How sharp the photos will be follows from the board photos of the camera
    file; without one, a good lens and a still hand are taken. A sigma that cannot
    be reached is refused, with what would reach it.

    Example: limbgram plan --sigma 0.05 --distance 900 --focal 35 --sensor 22.3 --pixels 6000x4000
    """
    found = plan(ask)
    lines = (spoken(found.summary), *(f"  {spoken(one)}" for one in found.steps))
    if picture is not None:
        write_bytes(picture, _picture(found))
        lines = (*lines, f"Picture: {printable(str(picture))}")
    return Reply(lines, tree_of(found), "green")


def _picture(found: CapturePlan) -> bytes:
    stands = [
        Stand(azimuth_deg=turn, elevation_deg=ring.elevation_deg, distance=found.distance_mm)
        for ring in found.rings
        for turn in ring.azimuths_deg
    ]
    title = f"Plan: {found.photos} photos from {found.distance_mm:.0f} mm"
    return plan_picture(title, stands, found.coverage).tobytes()
