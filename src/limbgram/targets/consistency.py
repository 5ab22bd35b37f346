"""Consistency: which corners of one photo lie where a flat board seen by one lens can have them.

In      corner ids and pixels of one photo.
Out     for each corner its distance from a robustly fitted model of the whole board.
Method  homography followed by two terms of radial distortion about the picture's centre, ten
        unknowns, Cauchy weights. The lens need not be known, and no corner is trusted.
"""

import cv2
import numpy as np
from jaxtyping import Float64
from scipy.optimize import least_squares

from limbgram.geometry.arrays import Points2

_FOR_LENS = 12
"""Corners from which the two distortion terms are fitted too."""


def board_residuals_px(
    board_xy: Points2, xy_px: Points2, size_px: tuple[int, int]
) -> Float64[np.ndarray, "n 2"]:
    """Found minus modelled corners; NaN where fewer than five corners leave nothing to check.

    Args:
        board_xy: The corners on the plate, in any unit.
        size_px: Width and height of the photo.
    """
    if len(xy_px) < 5:
        return np.full(xy_px.shape, np.nan)
    centre = 0.5 * (np.array(size_px) - 1.0)
    unit_px = 0.5 * float(np.hypot(*size_px))
    plate = (board_xy - board_xy.mean(axis=0)) / max(float(np.ptp(board_xy)), 1e-9)
    seen = (xy_px - centre) / unit_px
    start, _ = cv2.findHomography(plate, seen, cv2.LMEDS)
    if start is None or abs(start[2, 2]) < 1e-9:
        return np.full(xy_px.shape, np.nan)
    first = (start / start[2, 2]).ravel()[:8]
    if len(xy_px) >= _FOR_LENS:
        first = np.concatenate([first, [0.0, 0.0]])

    def misses(unknowns: np.ndarray) -> np.ndarray:
        return (_board_image(unknowns, plate) - seen).ravel()

    fit = least_squares(misses, first, loss="cauchy", f_scale=0.3 / unit_px, x_scale="jac")
    return -misses(fit.x).reshape(-1, 2) * unit_px


def _board_image(unknowns: np.ndarray, plate: Points2) -> Points2:
    """Distorted image of the plate, in half diagonals from the picture's centre."""
    rows = np.append(unknowns[:8], 1.0).reshape(3, 3)
    mapped = plate @ rows[:, :2].T + rows[:, 2]
    ideal = mapped[:, :2] / np.where(np.abs(mapped[:, 2:]) < 1e-9, 1e-9, mapped[:, 2:])
    if len(unknowns) == 8:
        return ideal
    r2 = (ideal**2).sum(axis=1, keepdims=True)
    return ideal * (1.0 + r2 * (unknowns[8] + r2 * unknowns[9]))
