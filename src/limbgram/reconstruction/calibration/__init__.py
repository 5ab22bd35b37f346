"""Calibration: the cameras' lenses with their uncertainty, from a board or from EXIF.

In      photos of a board (`calibrate`), or the photos of a case and the calibrations at hand
        (`cameras_for`).
Out     a BoardCalibration; Cameras, one Calibration for each camera group of a PhotoSet.
"""

from limbgram.reconstruction.calibration.board import (
    BoardCalibration,
    CalibrationOptions,
    PhotoFit,
    calibrate,
    calibrate_detections,
)
from limbgram.reconstruction.calibration.cameras import (
    Calibration,
    Cameras,
    cameras_for,
    contradicting_exif,
    foreign_camera,
    from_exif,
)
from limbgram.reconstruction.calibration.screening import Estimate
from limbgram.reconstruction.calibration.verdicts import Coverage

__all__ = [
    "BoardCalibration",
    "Calibration",
    "CalibrationOptions",
    "Cameras",
    "Coverage",
    "Estimate",
    "PhotoFit",
    "calibrate",
    "calibrate_detections",
    "cameras_for",
    "contradicting_exif",
    "foreign_camera",
    "from_exif",
]
