"""Checkerboards: all inner corners of the board to about a pixel.

Measured on eight sets of board photos: OpenCV's classic detector finds all boards that its
sector-based one (SB) finds, but for a few, in a thirtieth of the time; where it fails SB is asked.
Either only gives the start of the sub-pixel fit (`targets.corners`).
"""

import cv2
import numpy as np

from limbgram.geometry.arrays import GreyImage, Points2
from limbgram.targets.board import Board

_LONG_SIDE_PX = 1600
_CLASSIC = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE


def find_checkerboard(luma: GreyImage, board: Board) -> Points2 | None:
    """Inner corners row by row, or None where the whole board is not seen.

    Photos larger than the detectors like are searched in a reduced copy first.
    """
    small, factor = reduced(luma, _LONG_SIDE_PX)
    found = _classic(small, board.inner)
    if found is None:
        found = _sector_based(small, board.inner)
    if found is None and factor < 1.0:
        found, factor = _classic(luma, board.inner), 1.0
    if found is None:
        return None
    return _from_top_left((found + 0.5) / factor - 0.5, board.inner)


def likely_inner(luma: GreyImage, board: Board) -> tuple[int, int] | None:
    """Another number of inner corners that does fit the photo, to explain a failure.

    Tried are the mistakes people make: squares counted for corners, or one row missed.
    """
    small, _ = reduced(luma, _LONG_SIDE_PX)
    across, down = board.inner
    for inner in [
        (across - 1, down - 1),
        (across + 1, down + 1),
        (across - 1, down),
        (across, down - 1),
        (across + 1, down),
        (across, down + 1),
    ]:
        if min(inner) > 2 and _classic(small, inner, cv2.CALIB_CB_FAST_CHECK) is not None:
            return inner
    return None


def reduced(luma: GreyImage, long_side_px: int) -> tuple[GreyImage, float]:
    """A copy no longer than asked, and its scale (x_small = (x + 0.5) * scale - 0.5)."""
    factor = long_side_px / max(luma.shape)
    if factor >= 1.0:
        return luma, 1.0
    size = (round(luma.shape[1] * factor), round(luma.shape[0] * factor))
    small = cv2.resize(luma, size, interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.uint8), factor


def _classic(luma: GreyImage, inner: tuple[int, int], more_flags: int = 0) -> Points2 | None:
    found, corners = cv2.findChessboardCorners(luma, inner, flags=_CLASSIC | more_flags)
    return np.asarray(corners, float).reshape(-1, 2) if found else None


def _sector_based(luma: GreyImage, inner: tuple[int, int]) -> Points2 | None:
    found, corners = cv2.findChessboardCornersSB(luma, inner, flags=cv2.CALIB_CB_EXHAUSTIVE)
    return np.asarray(corners, float).reshape(-1, 2) if found else None


def _from_top_left(xy_px: Points2, inner: tuple[int, int]) -> Points2:
    """Order the corners so that the board's z points away from the camera.

    Seen from the front, x to y must turn clockwise in the picture (its y points down); a
    detector that reads the board mirrored is corrected by reversing its rows. Half a turn is
    left open where the print allows it.
    """
    grid = xy_px.reshape(inner[1], inner[0], 2)
    along_x = grid[:, -1] - grid[:, 0]
    along_y = grid[-1] - grid[0]
    turn = np.cross(np.append(along_x.mean(axis=0), 0.0), np.append(along_y.mean(axis=0), 0.0))[2]
    if turn < 0:
        grid = grid[::-1]
    return np.ascontiguousarray(grid.reshape(-1, 2))
