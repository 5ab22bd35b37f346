"""Corner refinement: a model of two crossing blurred edges is fitted to the grey values.

In      a photo, corners known to about a pixel, and the square's two sides there in pixels.
Out     the crossing point of each corner, its formal sigma, the blur of its edges, its misfit.
Method  I(p) = a + ax dx + ay dy + b erf(d1 / s sqrt 2) erf(d2 / s sqrt 2), where d1 and d2 are
        the distances to two lines through the corner; nine parameters by damped Gauss-Newton
        over a window that follows the board in perspective. A grey value curve (gamma) shifts
        opposite arms of an edge in opposite directions and so cancels in the crossing point.

The loop is compiled with the model, and ends by the corner's step: `core/optimisation` calls back
into Python, which costs more than a step of nine unknowns.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.core.geometry.arrays import GreyImage, Points2
from limbgram.core.kernels import njit
from limbgram.core.solvers import solve_positive

_PARAMETERS = 9
_BLUR, _CONTRAST, _MEAN = 4, 5, 6
"""Places among a corner's parameters: x, y, the two lines' angles, blur, contrast, mean and its two
slopes."""
_MAX_ITERATIONS = 30
_CONVERGED_PX = 1e-4
_MIN_PIXELS = 25
_FLAT_BLURS = 4.5
"""Blurs from an edge beyond which its profile is flat to 1e-5."""


@dataclass(frozen=True)
class CornerFits:
    """Fitted corners, row by row as they were given; NaN where the fit failed."""

    xy_px: Points2
    sigma_px: Float64[np.ndarray, " n"]
    blur_px: Float64[np.ndarray, " n"]
    contrast: Float64[np.ndarray, " n"]
    """Half the grey step between white and black squares, 0 to 127."""
    misfit: Float64[np.ndarray, " n"]
    """RMS of the grey residuals over the contrast."""


def fit_corners(
    luma: GreyImage, xy_px: Points2, sides_px: Float64[np.ndarray, "n 2 2"], reach: float
) -> CornerFits:
    """Refine corners to the crossing of their edges.

    Args:
        sides_px: For each corner, the square's side along the board's x (first row) and along
            its y (second row), in pixels.
        reach: Half the window's side as a fraction of a square.
    """
    fits = np.full((len(xy_px), 6), np.nan)
    _fit_corners(
        np.ascontiguousarray(luma),
        np.ascontiguousarray(xy_px, float),
        np.ascontiguousarray(sides_px, float),
        reach,
        fits,
    )
    return CornerFits(fits[:, :2].copy(), *(fits[:, column].copy() for column in range(2, 6)))


@njit(cache=True, nogil=True)
def _fit_corners(
    luma: GreyImage, xy: np.ndarray, sides: np.ndarray, reach: float, fits: np.ndarray
) -> None:  # pragma: no cover
    for corner in range(len(xy)):
        pixels = _window(luma, xy[corner], sides[corner], reach)
        if len(pixels) >= _MIN_PIXELS:
            _fit_corner(pixels, xy[corner], sides[corner], fits[corner])


@njit(cache=True, nogil=True)
def _window(
    luma: GreyImage, xy: np.ndarray, sides: np.ndarray, reach: float
) -> np.ndarray:  # pragma: no cover
    """Rows dx, dy, grey of the pixels within `reach` squares of a corner; none where cut off."""
    none = np.empty((0, 3))
    det = sides[0, 0] * sides[1, 1] - sides[0, 1] * sides[1, 0]
    half_width = reach * (abs(sides[0, 0]) + abs(sides[1, 0]))
    half_height = reach * (abs(sides[0, 1]) + abs(sides[1, 1]))
    if not (abs(det) > 1.0 and math.isfinite(xy[0] + xy[1] + half_width + half_height)):
        return none
    left, right = math.ceil(xy[0] - half_width), math.floor(xy[0] + half_width)
    top, bottom = math.ceil(xy[1] - half_height), math.floor(xy[1] + half_height)
    if left < 0 or top < 0 or right >= luma.shape[1] or bottom >= luma.shape[0]:
        return none
    pixels = np.empty(((right - left + 1) * (bottom - top + 1), 3))
    count = 0
    for y in range(top, bottom + 1):
        for x in range(left, right + 1):
            dx, dy = x - xy[0], y - xy[1]
            u = (dx * sides[1, 1] - dy * sides[1, 0]) / det
            v = (dy * sides[0, 0] - dx * sides[0, 1]) / det
            if abs(u) <= reach and abs(v) <= reach:
                pixels[count, 0], pixels[count, 1], pixels[count, 2] = dx, dy, luma[y, x]
                count += 1
    return pixels[:count]


@njit(cache=True, nogil=True)
def _fit_corner(
    pixels: np.ndarray, xy: np.ndarray, sides: np.ndarray, fit: np.ndarray
) -> None:  # pragma: no cover
    """Fit one corner by damped Gauss-Newton; `fit` stays as it is where that fails."""
    parameters = _initial_parameters(pixels, sides)
    cost, normal, rhs = _normal_equations(pixels, parameters)
    damping = 1e-3
    for _ in range(_MAX_ITERATIONS):
        step = _solve_damped(normal, rhs, damping)
        candidate = parameters + step
        new_cost, new_normal, new_rhs = _normal_equations(pixels, candidate)
        if new_cost < cost and 0.2 < candidate[_BLUR] < 30.0:
            parameters, cost, normal, rhs = candidate, new_cost, new_normal, new_rhs
            damping *= 0.2
            if abs(step[0]) + abs(step[1]) < _CONVERGED_PX:
                break
        else:
            damping *= 10.0
            if damping > 1e6:
                break
    variance = cost / max(1, len(pixels) - _PARAMETERS)
    coordinate_variance = 0.0
    for axis in range(2):
        unit = np.zeros(_PARAMETERS)
        unit[axis] = 1.0
        coordinate_variance += 0.5 * _solve_damped(normal, unit, 0.0)[axis]
    if (
        coordinate_variance > 0.0
        and math.isfinite(coordinate_variance)
        and abs(parameters[_CONTRAST]) > 0.0
    ):
        fit[0], fit[1] = xy[0] + parameters[0], xy[1] + parameters[1]
        fit[2] = math.sqrt(variance * coordinate_variance)
        fit[3] = parameters[_BLUR]
        fit[4] = abs(parameters[_CONTRAST])
        fit[5] = math.sqrt(variance) / abs(parameters[_CONTRAST])


@njit(cache=True, nogil=True)
def _initial_parameters(pixels: np.ndarray, sides: np.ndarray) -> np.ndarray:  # pragma: no cover
    """Parameters from the square's sides, and from the mean grey of like and unlike quadrants."""
    parameters = np.zeros(_PARAMETERS)
    parameters[2] = math.atan2(sides[0, 1], sides[0, 0])
    parameters[3] = math.atan2(sides[1, 1], sides[1, 0])
    parameters[_BLUR] = 1.2
    like_sum = unlike_sum = 0.0
    like_count = 0
    for row in pixels:
        first = row[1] * math.cos(parameters[2]) - row[0] * math.sin(parameters[2])
        second = row[1] * math.cos(parameters[3]) - row[0] * math.sin(parameters[3])
        if first * second > 0.0:
            like_sum += row[2]
            like_count += 1
        else:
            unlike_sum += row[2]
    like = like_sum / max(1, like_count)
    unlike = unlike_sum / max(1, len(pixels) - like_count)
    parameters[_CONTRAST], parameters[_MEAN] = 0.5 * (like - unlike), 0.5 * (like + unlike)
    return parameters


@njit(cache=True, nogil=True)
def _normal_equations(
    pixels: np.ndarray, parameters: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:  # pragma: no cover
    """Sum of squared residuals, normal matrix (lower triangle) and right-hand side."""
    cost = 0.0
    normal = np.zeros((_PARAMETERS, _PARAMETERS))
    rhs = np.zeros(_PARAMETERS)
    derivative = np.empty(_PARAMETERS)
    c1, s1 = math.cos(parameters[2]), math.sin(parameters[2])
    c2, s2 = math.cos(parameters[3]), math.sin(parameters[3])
    blur = max(parameters[_BLUR], 0.2)
    for row in pixels:
        dx, dy = row[0] - parameters[0], row[1] - parameters[1]
        e1, g1 = _edge_profile(dy * c1 - dx * s1, blur)
        e2, g2 = _edge_profile(dy * c2 - dx * s2, blur)
        derivative[_CONTRAST] = e1 * e2
        derivative[_MEAN], derivative[7], derivative[8] = 1.0, row[0], row[1]
        residual = row[2] - (
            parameters[_CONTRAST] * derivative[_CONTRAST]
            + parameters[_MEAN]
            + parameters[7] * row[0]
            + parameters[8] * row[1]
        )
        first = _PARAMETERS - 4
        if g1 != 0.0 or g2 != 0.0:
            first = 0
            g1, g2 = g1 * e2 * parameters[_CONTRAST], g2 * e1 * parameters[_CONTRAST]
            derivative[0] = g1 * s1 + g2 * s2
            derivative[1] = -g1 * c1 - g2 * c2
            derivative[2] = -g1 * (dy * s1 + dx * c1)
            derivative[3] = -g2 * (dy * s2 + dx * c2)
            derivative[_BLUR] = -(g1 * (dy * c1 - dx * s1) + g2 * (dy * c2 - dx * s2)) / blur
        cost += residual * residual
        for i in range(first, _PARAMETERS):
            rhs[i] += derivative[i] * residual
            for j in range(first, i + 1):
                normal[i, j] += derivative[i] * derivative[j]
    return cost, normal, rhs


@njit(cache=True, nogil=True)
def _edge_profile(distance: float, blur: float) -> tuple[float, float]:  # pragma: no cover
    """An edge's profile between -1 and 1, and its slope (zero far away)."""
    if abs(distance) > _FLAT_BLURS * blur:
        return math.copysign(1.0, distance), 0.0
    scaled = distance / (blur * math.sqrt(2.0))
    return math.erf(scaled), math.sqrt(2.0 / math.pi) / blur * math.exp(-scaled * scaled)


@njit(cache=True, nogil=True)
def _solve_damped(
    normal: np.ndarray, rhs: np.ndarray, damping: float
) -> np.ndarray:  # pragma: no cover
    """Solution of (N + damping diag N) x = rhs; NaN where N is singular."""
    system = np.empty((_PARAMETERS, _PARAMETERS + 1))
    step = np.empty(_PARAMETERS)
    for i in range(_PARAMETERS):
        for j in range(i):
            system[j, i] = normal[i, j]
        system[i, i] = normal[i, i] * (1.0 + damping)
        system[i, _PARAMETERS] = rhs[i]
    if not solve_positive(system, 0.0, step):
        step[:] = math.nan
    return step
