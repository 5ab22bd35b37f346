"""Cameras: calibrations that a clinic keeps, each with the board photos that it was made from.

SHELF/cameras/ID/camera.json      the camera file (see `formats.camera`), once it is calibrated
SHELF/cameras/ID/certificate.png  residuals and coverage
SHELF/cameras/ID/received/        photos of the board
SHELF/cameras/ID/label.json       name, day, what became of the last calibration
"""

import shutil
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from limbgram.cases.case_record import read_kept, utc_now, write_json
from limbgram.cases.shelf_ids import LONGEST_NAME, is_id, new_id
from limbgram.core.errors import (
    CalibrationError,
    CaseError,
    LimbgramError,
    MissingError,
    OptionsError,
    PhotoError,
    disk_finding,
    in_words,
    printable,
)
from limbgram.core.files import write_bytes, written_whole
from limbgram.core.run import Run
from limbgram.core.typed import tree_of
from limbgram.findings import Finding, fault, note
from limbgram.formats.camera import parse_camera, read_camera
from limbgram.reconstruction.calibration.board import BoardCalibration
from limbgram.reconstruction.calibration.cameras import (
    Calibration,
    cameras_for,
    contradicting_exif,
)
from limbgram.reconstruction.photos.reading import PhotoOptions, read_photos
from limbgram.reconstruction.targets.board import Board
from limbgram.report.calibration import calibration_picture
from limbgram.services.calibrate import calibrate_photos, write_lens

_PHOTOS_CHECKED = 12
"""Photos of a capture whose headers tell whether the camera is theirs; the run looks at all."""

_INTERRUPTED = fault("camera.interrupted")

CameraState = Literal["empty", "calibrating", "refused", "ready"]


@dataclass(frozen=True, kw_only=True)
class CameraLabel:
    """Name of a camera and the state of its calibration."""

    name: str
    made: str
    """Date and time, UTC."""
    calibrated: str = ""
    """Date and time of its calibration, UTC; empty before."""
    state: CameraState = "empty"
    finding: Finding | None = None
    """Why the last calibration was refused, or what it found."""
    message: str = ""
    """The same in a file of an earlier version, in its own words."""

    @property
    def as_calibrating(self) -> "CameraLabel":
        """The label during a calibration."""
        return replace(self, state="calibrating", finding=None, message="")

    @property
    def told(self) -> Finding | None:
        """What became of the last calibration, whichever version wrote it down."""
        return self.finding or (in_words(self.message) if self.message else None)


@dataclass(frozen=True)
class KeptCamera:
    """One camera."""

    camera_id: str
    folder: Path

    @property
    def file(self) -> Path:
        return self.folder / "camera.json"

    @property
    def certificate(self) -> Path:
        return self.folder / "certificate.png"

    @property
    def received(self) -> Path:
        return self.folder / "received"

    @property
    def label(self) -> CameraLabel:
        """Its name and the state of its calibration.

        Raises:
            CaseError: the label file is there and cannot be read.
        """
        kept = read_kept(self.label_file, CameraLabel, "camera")
        return CameraLabel(name=self.camera_id, made="") if kept is None else kept

    @property
    def label_file(self) -> Path:
        return self.folder / "label.json"

    def relabel(self, label: CameraLabel) -> None:
        if not label.name.strip() or len(label.name) > LONGEST_NAME:
            raise OptionsError("camera.name_length", most=LONGEST_NAME)
        if printable(label.name, keep="") != label.name:
            raise OptionsError("camera.name_not_shown")
        write_json(self.label_file, tree_of(label))

    @property
    def interrupted(self) -> CameraLabel:
        """The label of a camera whose calibration was ended before it finished."""
        state: CameraState = "ready" if self.file.is_file() else "empty"
        return replace(self.label, state=state, finding=_INTERRUPTED, message="")

    def calibration(self) -> Calibration | None:
        """Its lens; None before it is calibrated."""
        return read_camera(self.file) if self.file.is_file() else None

    def calibrate(self, board: Board, run: Run) -> None:
        """Calibrate the lens by the received photos of the board; the label tells the result.

        Raises:
            LimbgramError: the photos do not tell the lens; an earlier calibration stays.
        """
        self.relabel(self.label.as_calibrating)
        try:
            if not self.received.is_dir():
                raise CalibrationError("camera.no_board_photos")
            found = calibrate_photos([self.received], board, run)
            picture, result = calibration_picture(found), _calibration_result(found)
            self.certificate.unlink(missing_ok=True)  # it never stands beside another lens
            write_lens(self.file, found)
            write_bytes(self.certificate, picture)
        except (LimbgramError, OSError) as error:
            state: CameraState = "ready" if self.file.is_file() else "refused"
            reason = disk_finding(error) if isinstance(error, OSError) else error.finding
            self.relabel(replace(self.label, state=state, finding=reason, message=""))
            raise
        self.relabel(replace(self.label, state="ready", calibrated=utc_now(), finding=result))

    def take_file(self, content: bytes, name: str) -> None:
        """Take a camera file that was made elsewhere, where it has this name.

        Raises:
            CaseError: it is no camera file; the lens before stays.
        """
        parse_camera(content, Path(name))  # before it has a name here, which nobody knows

        def check(written: Path) -> None:
            read_camera(written)
            self.certificate.unlink(missing_ok=True)  # it never stands beside another lens

        with written_whole(self.file, check) as beside:
            beside.write_bytes(content)
        ready = replace(self.label, state="ready", calibrated=utc_now(), finding=None, message="")
        self.relabel(ready)


@dataclass(frozen=True)
class Cameras:
    """The cameras of a shelf."""

    root: Path

    def all(self) -> tuple[KeptCamera, ...]:
        if not self.root.is_dir():
            return ()
        found = sorted(path for path in self.root.iterdir() if is_id(path.name))
        return tuple(KeptCamera(path.name, path) for path in found)

    def camera(self, camera_id: str) -> KeptCamera:
        """One camera.

        Raises:
            LookupError: there is none of that id.
        """
        folder = self.root / camera_id
        if not is_id(camera_id) or not folder.is_dir():
            raise MissingError("camera.none")
        return KeptCamera(camera_id, folder)

    def new_camera(self, name: str) -> KeptCamera:
        """A camera that is not calibrated yet."""
        camera_id = new_id()
        folder = self.root / camera_id
        folder.mkdir(parents=True)
        made = KeptCamera(camera_id, folder)
        try:
            made.relabel(CameraLabel(name=name, made=utc_now()))
        except OptionsError:
            folder.rmdir()
            raise
        return made

    def remove(self, camera: KeptCamera) -> None:
        """Delete a camera with its photos."""
        shutil.rmtree(camera.folder)

    def settle(self) -> None:
        """Mark calibrations that an earlier run of the program left unfinished as interrupted."""
        for camera in self.all():
            with suppress(CaseError, OSError):  # one that cannot be read is told in the list
                if camera.label.state == "calibrating":
                    camera.relabel(camera.interrupted)


def camera_doubt(photos: Sequence[Path], given: Sequence[Calibration]) -> Finding | None:
    """Why photos cannot be of these cameras, by their size and headers; None where they can.

    A few of the photos, evenly spread, are checked: all files of their shots, of which one is used.
    """
    shots: dict[str, list[Path]] = {}
    for file in photos:
        shots.setdefault(file.stem.casefold(), []).append(file)
    step = max(1, -(-len(shots) // _PHOTOS_CHECKED))
    checked = [file for shot in [*shots.values()][::step] for file in shot]
    try:
        found = read_photos(checked, PhotoOptions(min_photos=1))
        return contradicting_exif(found, cameras_for(found, given))
    except CalibrationError as error:
        return error.finding
    except PhotoError:
        return None  # no photo can be read yet: nothing tells against the camera


def _calibration_result(found: BoardCalibration) -> Finding:
    """Residual and remarks of a calibration."""
    return note(
        "camera.calibrated",
        photos=len(found.photos),
        rms_px=found.calibration.rms_px,
        remarks=(
            *(
                note("camera.left_out", photo=one.name, reason=one.reason)
                for one in found.set_aside
            ),
            *found.doubts,
        ),
    )
