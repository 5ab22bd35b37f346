"""Sample: a case that the program makes itself, to try everything out without a patient.

Photos of a synthetic limb with the scale board beside it, and a calibrated camera for them. The
shelf's folder `sample` keeps them, so that a second sample needs no rendering.
"""

import shutil
from pathlib import Path

from limbgram.cases.cameras import Cameras, KeptCamera
from limbgram.cases.shelf import Shelf, ShelvedCase
from limbgram.cases.uploads import Intake, secret_of
from limbgram.core.run import Run
from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.props.board import CALIBRATION_BOARD

SAMPLE = CaptureOptions(width_px=1200, height_px=800)
"""A walk round in one ring, as the demo's, at 1 MP: its shape is computed in a minute."""
_CAMERA = "Camera of the sample"
_NOTE = "A limb that never was, made by the program"


def begin_sample(shelf: Shelf) -> ShelvedCase:
    """An empty sample case, to be filled by `fill_sample`."""
    return shelf.new_case("transtibial", "left", _NOTE, sample=True)


def fill_sample(shelf: Shelf, case: ShelvedCase, run: Run) -> KeptCamera:
    """Render the photos, calibrate the camera, and put the photos into the case.

    Raises:
        CaseError: the photos cannot be written.
    """
    folder = shelf.root / "sample"
    if not folder.is_dir():
        run(make_capture, folder, SAMPLE)
    camera = _sample_camera(shelf, folder, run)
    _upload(folder / "images", Intake(case.received, secret_of(shelf.root)))
    return camera


def _sample_camera(shelf: Shelf, folder: Path, run: Run) -> KeptCamera:
    cameras = Cameras(shelf.cameras)
    known = (one for one in cameras.all() if one.label.name == _CAMERA and one.file.is_file())
    camera = next(known, None)
    if camera is None:
        camera = cameras.new_camera(_CAMERA)
        _upload(folder / "calibration", Intake(camera.received, secret_of(shelf.root)))
        camera.calibrate(CALIBRATION_BOARD.board, run)
    return camera


def _upload(folder: Path, intake: Intake) -> None:
    """Upload a folder's photos as a browser does."""
    for photo in sorted(folder.iterdir()):
        with photo.open("rb") as source, intake.begin(photo.name, 0, None) as target:
            shutil.copyfileobj(source, target)
        intake.finish(photo.name)
