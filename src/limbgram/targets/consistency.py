"""Consistency: which corners of one photo lie where a flat board seen by one lens can have them.

In      corner ids and pixels of one photo.
Out     for each corner its distance from a robustly fitted model of the whole board.
Method  the pixels, freed of radial distortion by a division model of two terms about the
        picture's centre (Fitzgibbon 2001), map to the plate by a homography: ten unknowns,
        robust weights, first forgiving and then strict. The lens need not be known, it may be
        very wide, and no corner is trusted.
"""

import cv2
import numpy as np
from jaxtyping import Float64
from scipy.optimize import least_squares

from limbgram.geometry.arrays import Points2

_FOR_LENS = 12
"""Corners from which the two distortion terms are fitted too."""
_SCALES_PX = (10.0, 1.0, 0.3)
"""Misses beyond which a corner loses weight, from the first fit to the last."""


def board_residuals_px(
    board_squares: Points2,
    xy_px: Points2,
    sides_px: Float64[np.ndarray, "n 2 2"],
    size_px: tuple[int, int],
) -> Float64[np.ndarray, "n 2"]:
    """Modelled minus found corners; NaN where fewer than five corners leave nothing to check.

    Args:
        board_squares: The corners on the plate, in squares.
        sides_px: For each corner a square's two sides in pixels, one a row.
        size_px: Width and height of the photo.
    """
    if len(xy_px) < 5:
        return np.full(xy_px.shape, np.nan)
    centre = 0.5 * (np.array(size_px) - 1.0)
    seen = (xy_px - centre) / (0.5 * float(np.hypot(*size_px)))
    origin = board_squares.mean(axis=0)
    plate = board_squares - origin
    start = np.array(cv2.findHomography(seen, plate, cv2.LMEDS)[0], float)
    if start.shape != (3, 3) or abs(start[2, 2]) < 1e-9:
        return np.full(xy_px.shape, np.nan)
    unknowns = (start / start[2, 2]).ravel()[:8]
    if len(xy_px) >= _FOR_LENS:
        unknowns = np.concatenate([unknowns, [0.0, 0.0]])

    def misses_px(unknowns: np.ndarray) -> np.ndarray:
        off_squares = _on_plate(unknowns, seen) - plate
        return np.einsum("ni,nij->nj", off_squares, sides_px).ravel()

    for scale_px in _SCALES_PX:
        unknowns = least_squares(
            misses_px, unknowns, loss="cauchy", f_scale=scale_px, x_scale="jac"
        ).x
    return misses_px(unknowns).reshape(-1, 2)


def _on_plate(unknowns: np.ndarray, seen: Points2) -> Points2:
    """Places on the plate of pixels given in half diagonals from the picture's centre."""
    rows = np.append(unknowns[:8], 1.0).reshape(3, 3)
    weight = np.ones((len(seen), 1))
    if len(unknowns) > 8:
        r2 = (seen**2).sum(axis=1, keepdims=True)
        weight = 1.0 + r2 * (unknowns[8] + r2 * unknowns[9])
    mapped = seen @ rows[:, :2].T + weight * rows[:, 2]
    return mapped[:, :2] / np.where(np.abs(mapped[:, 2:]) < 1e-9, 1e-9, mapped[:, 2:])
