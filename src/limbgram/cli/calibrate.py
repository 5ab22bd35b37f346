"""`limbgram calibrate`: photos of a board to a camera file."""

from pathlib import Path
from typing import Annotated

import typer

from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, answered, language
from limbgram.cli.request_options import asking
from limbgram.core.errors import OptionsError
from limbgram.core.files import require_folder
from limbgram.core.run import Run
from limbgram.core.typed import tree_of
from limbgram.formats.camera import require_camera_place
from limbgram.report.calibration import calibration_summary, calibration_text
from limbgram.services.calibrate import CalibrateRequest, calibrate_photos, save_calibration


@answered
@asking
def calibrate_command(
    photos: Annotated[list[Path], typer.Argument(help="Photos of the board, or folders of them.")],
    ask: CalibrateRequest,
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
    for path in (out, *(() if report is None else (report,))):
        require_folder(path.parent)
    with display(as_json) as screen:
        result = calibrate_photos(photos, ask.pattern(), Run(listener=screen.listen))
    save_calibration(result, out, report)
    return Reply(
        (calibration_text(result, language()), f"Written: {out}"),
        {"camera": str(out), **tree_of(calibration_summary(result))},
    )


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
