"""`limbgram calibrate`: photos of a board to a camera file."""

from pathlib import Path
from typing import Annotated

import typer

from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, answered
from limbgram.core.errors import OptionsError
from limbgram.core.files import written_whole
from limbgram.core.run import Run
from limbgram.core.typed import tree_of
from limbgram.formats.camera import require_camera_place, write_camera
from limbgram.reconstruction.calibration.board import BoardCalibration, calibrate
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.targets.board import Board
from limbgram.report.calibration import calibration_picture, calibration_summary, calibration_text
from limbgram.services.captures import names_board_file, parse_board


@answered
def calibrate_command(
    photos: Annotated[list[Path], typer.Argument(help="Photos of the board, or folders of them.")],
    board: Annotated[
        str,
        typer.Option(
            help="Inner corners of the checkerboard, such as 14x10; or a ChArUco board as "
            "charuco:SQUARES:SQUARE_MM:MARKER_MM:DICTIONARY, such as charuco:7x5:30:22:4X4_50; or "
            "the board file of `limbgram print`."
        ),
    ],
    square: Annotated[
        float | None, typer.Option(help="Side of one square of the checkerboard, mm.")
    ] = None,
    out: Annotated[Path, typer.Option("-o", "--out", help="Camera file to write.")] = Path(
        "camera.json"
    ),
    report: Annotated[
        Path | None, typer.Option(help="Write a picture of residuals and coverage (PNG).")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,
) -> Reply:
    """Find the lens of a camera from photos of a flat board at different angles.

    Take 10 to 20 photos with the zoom and focus that you will use for limbs: tilt the board
    20 to 45 degrees in all directions, and let it reach every corner of the picture.
    """
    require_camera_place(out)
    _require_no_photo(report, photos)
    with display(as_json) as screen:
        result = calibrate_from(photos, as_board(board, square), Run(listener=screen.listen))
    save_calibration(result, out, report)
    return Reply(
        (calibration_text(result), f"Written: {out}"),
        {"camera": str(out), **tree_of(calibration_summary(result))},
    )


def calibrate_from(photos: list[Path], board: Board, run: Run) -> BoardCalibration:
    """Read photos of a board and calibrate their camera."""
    return run(calibrate, run(read_photos, photos), board)


def save_calibration(result: BoardCalibration, out: Path, report: Path | None) -> None:
    """Write the camera file, and the picture if it is wanted."""
    provenance = {"board": str(result.board), "photos": str(len(result.photos))}
    out.parent.mkdir(parents=True, exist_ok=True)
    write_camera(out, result.calibration, provenance)
    if report is not None:
        report.parent.mkdir(parents=True, exist_ok=True)
        with written_whole(report) as beside:
            beside.write_bytes(calibration_picture(result))


def _require_no_photo(report: Path | None, photos: list[Path]) -> None:
    """Refuse a picture that would take the place of a photo, or be taken for one the next time."""
    if report is None:
        return
    if report.suffix.lower() != ".png":
        raise OptionsError("options.no_picture_name", name=report.name)
    folders = {photo.resolve() for photo in photos if photo.is_dir()}
    if report.resolve() in {photo.resolve() for photo in photos} or (
        report.parent.resolve() in folders
    ):
        raise OptionsError("options.picture_among_photos", path=str(report))


def as_board(text: str, square_mm: float | None) -> Board:
    """The board that --board and --square name."""
    if ":" in text or names_board_file(text):
        return parse_board(text)
    if square_mm is None:
        raise OptionsError("options.square_missing")
    return Board.checkerboard(text, square_mm)
