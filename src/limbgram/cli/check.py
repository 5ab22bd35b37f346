"""`limbgram check`: is a capture good, or which photos are missing."""

from pathlib import Path
from typing import Annotated

import typer

from limbgram.cases.checking import check_sources
from limbgram.cli.captures import DEFAULT_BOARD, parse_board
from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, answered
from limbgram.core.errors import printable
from limbgram.core.files import write_bytes
from limbgram.core.run import Run
from limbgram.core.typed import tree_of
from limbgram.formats.camera import read_camera
from limbgram.report.drawings.coverage import coverage_picture


@answered
def check_command(
    photos: Annotated[
        list[Path], typer.Argument(help="Photos of the limb, folders of them, or a video.")
    ],
    camera: Annotated[
        list[Path] | None, typer.Option(help="Camera file of `limbgram calibrate`.")
    ] = None,
    board: Annotated[
        str | None,
        typer.Option(
            help="Scale board in the scene, or the board file of `limbgram print`.",
            show_default=DEFAULT_BOARD,
        ),
    ] = None,
    no_board: Annotated[bool, typer.Option("--no-board", help="Look for no scale board.")] = False,
    picture: Annotated[
        Path | None,
        typer.Option(
            help="Write a picture (PNG): where the photos stand, where to add some, and the "
            "expected interval on the unrolled limb."
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,
) -> Reply:
    """Say within a minute whether a capture is good, or which photos to add and from where.

    GO ends with exit code 0, anything else with 7. What is checked: sharpness and exposure on the
    limb, whether the photos join all round, the scale board, whether every side is seen by enough
    photos, and how sure the surface will be there. Photos to add are named by the hour at which to
    stand, seen from above with the first photo at 12, and by the height of the camera.
    """
    calibrations = tuple(read_camera(file) for file in camera or ())
    with display(as_json) as screen:
        found = check_sources(
            photos,
            calibrations,
            None if no_board else parse_board(board or DEFAULT_BOARD),
            Run(listener=screen.listen),
        )
    notes = [f"  {one.name}: {text}" for one in found.photos for text in one.remarks]
    lines = (
        found.headline,
        *(f"  {text}" for text in (*found.findings[1:], *found.notes)),
        *notes,
    )
    if picture is not None:
        write_bytes(picture, coverage_picture(found).tobytes())
        lines = (*lines, f"Picture: {printable(str(picture))}")
    return Reply(lines, tree_of(found), "green" if found.go else "red")
