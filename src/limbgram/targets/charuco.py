"""ChArUco boards: the inner corners whose markers are seen, to about a pixel, with their ids."""

from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Int32

from limbgram.geometry.arrays import GreyImage, Points2
from limbgram.targets.board import Board


class FoundCorners(NamedTuple):
    """Corners as they were found, not yet fitted or checked."""

    ids: Int32[np.ndarray, " n"]
    xy_px: Points2
    markers: int
    """Markers of the board that were read."""


def find_charuco(luma: GreyImage, board: Board) -> FoundCorners:
    """Inner corners of the board that lie between markers that were read."""
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    interpolation = cv2.aruco.CharucoParameters()
    interpolation.minMarkers = 1
    detector = cv2.aruco.CharucoDetector(board.opencv(), interpolation, parameters)
    corners, ids, _, marker_ids = detector.detectBoard(luma)
    ids = _rows(ids).astype(np.int32).ravel()
    order = np.argsort(ids, kind="stable")
    return FoundCorners(ids[order], _rows(corners).reshape(-1, 2)[order], len(_rows(marker_ids)))


def _rows(found: object) -> np.ndarray:
    """OpenCV's array, or an empty one for its None."""
    return np.zeros(0) if found is None else np.asarray(found, float)
