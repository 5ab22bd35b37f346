"""Calibrate: photos of a flat board to the lens of their camera, and the camera file of it.

In      photos, and the board that they show.
Out     a BoardCalibration; on disk a camera file that says what it was made from.
Fails   words that are no board; photos that do not tell the lens.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from limbgram.core.errors import OptionsError
from limbgram.core.files import written_whole
from limbgram.core.request_fields import Flag
from limbgram.core.run import Run
from limbgram.formats.camera import write_camera
from limbgram.reconstruction.calibration.board import BoardCalibration, calibrate
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.targets.board import Board
from limbgram.report.calibration import calibration_picture
from limbgram.services.parse_capture import names_board_file, parse_board


@dataclass(frozen=True, kw_only=True)
class CalibrateRequest:
    """The board that the photos show."""

    board: str
    """Inner corners of the checkerboard, such as 14x10; or a ChArUco board as
    charuco:SQUARES:SQUARE_MM:MARKER_MM:DICTIONARY, such as charuco:7x5:30:22:4X4_50; or the board
    file of `limbgram print`."""
    square_mm: Annotated[float | None, Flag("square")] = None
    """Side of one square of the checkerboard, mm."""

    def pattern(self) -> Board:
        """The board of these words.

        Raises:
            OptionsError: they are none.
        """
        if ":" in self.board or names_board_file(self.board):
            return parse_board(self.board)
        if self.square_mm is None:
            raise OptionsError("options.square_missing")
        return Board.checkerboard(self.board, self.square_mm)


def calibrate_photos(photos: Sequence[Path], board: Board, run: Run) -> BoardCalibration:
    """Read photos of a board and calibrate their camera.

    Raises:
        PhotoError: there are none.
        CalibrationError: they do not tell the lens.
    """
    return run(calibrate, run(read_photos, photos), board)


def write_lens(path: Path, found: BoardCalibration) -> None:
    """Keep the lens as a camera file that says what it was made from."""
    provenance = {"board": str(found.board), "photos": str(len(found.photos))}
    write_camera(path, found.calibration, provenance)


def save_calibration(found: BoardCalibration, out: Path, report: Path | None) -> None:
    """Write the camera file, and the picture of residuals and coverage if it is wanted."""
    out.parent.mkdir(parents=True, exist_ok=True)
    write_lens(out, found)
    if report is not None:
        report.parent.mkdir(parents=True, exist_ok=True)
        with written_whole(report) as beside:
            beside.write_bytes(calibration_picture(found))
