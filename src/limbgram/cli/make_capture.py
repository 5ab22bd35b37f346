"""`limbgram make-capture`: photographs of a synthetic limb, with their truth."""

from pathlib import Path
from typing import Annotated, Any

import typer

from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, answered, spoken
from limbgram.cli.request_options import asking
from limbgram.core.run import Run
from limbgram.findings import as_json as tree_of_finding
from limbgram.services.make_capture import MakeRequest, make
from limbgram.synthetic.props.bent import BentShape
from limbgram.synthetic.props.scan import Scan


@answered
@asking
def make_capture_command(
    folder: Annotated[Path, typer.Argument(help="New folder for the capture.")],
    ask: MakeRequest,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,
) -> Reply:
    """Make photos of a painted limb, photos of a calibration board, and the exact truth.

    FOLDER gets images/, calibration/ and truth/: the surface, where every photo was taken from,
    and notes of all that was chosen here. The same options give the same bytes. Score a
    reconstruction of it by `limbgram accuracy CASE --truth FOLDER`.
    """
    with display(as_json) as screen:
        made = make(folder, ask, Run(listener=screen.listen))
    capture, scan = made.capture, made.scan
    about = tuple(f"Of the scan, {spoken(note)}." for note in scan.notes) if scan else ()
    return Reply(
        (
            *about,
            f"{len(capture.photos)} photos of the limb and "
            f"{len(capture.calibration_photos)} of the calibration board are in {folder}.",
        ),
        {"folder": str(folder), "photos": len(capture.photos), **_told(scan)},
    )


def _told(scan: Scan | BentShape | None) -> dict[str, Any]:
    if scan is None:
        return {}
    return {
        "scan": {
            "sha256": scan.sha256,
            "height_mm": scan.height_mm,
            "notes": [tree_of_finding(note) for note in scan.notes],
        }
    }
