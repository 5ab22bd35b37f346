"""The Sampson distance: first-order distance of a match from epipolar geometry.

x2^T F x1 = 0 is a quadric through the space of matches (x1, y1, x2, y2). The distance of a match
to its tangent is the Sampson distance, and the foot of that perpendicular the corrected match
(Sampson 1982; Hartley and Zisserman, section 11.4.3 and eq. 12.5).
"""

import numpy as np
from jaxtyping import Float64

from limbgram.geometry.arrays import Matrix3, Points2


def sampson_px(
    fundamental: Matrix3, xy_first: Points2, xy_second: Points2
) -> Float64[np.ndarray, " n"]:
    """Signed distances of the matches; their squares approximate d(x, x^)^2 + d(x', x'^)^2."""
    error, gradient = _error_and_gradient(fundamental, xy_first, xy_second)
    return error / _length(gradient)


def sampson_corrected(
    fundamental: Matrix3, xy_first: Points2, xy_second: Points2
) -> Float64[np.ndarray, "n 4"]:
    """The matches (x1, y1, x2, y2) moved to first order onto the epipolar geometry."""
    error, gradient = _error_and_gradient(fundamental, xy_first, xy_second)
    step = gradient * (error / _length(gradient) ** 2)[:, None]
    return np.concatenate([xy_first, xy_second], axis=1) - step


def nearest_matches(
    fundamental: Matrix3, xy_first: Points2, xy_second: Points2, steps: int = 3
) -> Float64[np.ndarray, "n 4"]:
    """The nearest exact matches: the maximum-likelihood x^ and x'^.

    Newton steps towards the foot of the perpendicular on the quadric: each step linearises at
    the last estimate but measures from the given match (Kanatani et al. 2008). Two steps reach
    Hartley and Sturm's global optimum to rounding for matches within a few pixels.
    """
    given = np.concatenate([xy_first, xy_second], axis=1)
    nearest = given
    for _ in range(steps):
        error, gradient = _error_and_gradient(fundamental, nearest[:, :2], nearest[:, 2:])
        reach = error + np.einsum("ij,ij->i", gradient, given - nearest)
        nearest = given - gradient * (reach / _length(gradient) ** 2)[:, None]
    return nearest


def _error_and_gradient(
    fundamental: Matrix3, xy_first: Points2, xy_second: Points2
) -> tuple[Float64[np.ndarray, " n"], Float64[np.ndarray, "n 4"]]:
    line_in_second = xy_first @ fundamental[:, :2].T + fundamental[:, 2]
    line_in_first = xy_second @ fundamental[:2] + fundamental[2]
    error = np.einsum("ij,ij->i", xy_second, line_in_second[:, :2]) + line_in_second[:, 2]
    return error, np.concatenate([line_in_first[:, :2], line_in_second[:, :2]], axis=1)


def _length(gradient: Float64[np.ndarray, "n 4"]) -> Float64[np.ndarray, " n"]:
    """Nought at the epipoles; then the least length that can be squared."""
    return np.maximum(np.linalg.norm(gradient, axis=1), np.sqrt(np.finfo(float).tiny))
