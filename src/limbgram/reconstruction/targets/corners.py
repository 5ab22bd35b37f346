"""Sub-pixel corners: a model of two crossing blurred edges is fitted to the grey values.

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

_SIZE = 9
_STEPS = 30
_CONVERGED_PX = 1e-4
_MIN_PIXELS = 25
_FAR = 4.5
"""Blurs from an edge at which its profile is level to 1e-5."""


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
    """Move corners to the crossing of their edges.

    Args:
        sides_px: For each corner, the square's side along the board's x (first row) and along
            its y (second row), in pixels.
        reach: Half the window's side as a fraction of a square.
    """
    fits = np.full((len(xy_px), 6), np.nan)
    _fit_all(
        np.ascontiguousarray(luma),
        np.ascontiguousarray(xy_px, float),
        np.ascontiguousarray(sides_px, float),
        reach,
        fits,
    )
    return CornerFits(fits[:, :2].copy(), *(fits[:, column].copy() for column in range(2, 6)))


@njit(cache=True, nogil=True)
def _fit_all(
    luma: GreyImage, xy: np.ndarray, sides: np.ndarray, reach: float, fits: np.ndarray
) -> None:  # pragma: no cover
    for corner in range(len(xy)):
        pixels = _window(luma, xy[corner], sides[corner], reach)
        if len(pixels) >= _MIN_PIXELS:
            _fit_one(pixels, xy[corner], sides[corner], fits[corner])


@njit(cache=True, nogil=True)
def _window(
    luma: GreyImage, xy: np.ndarray, sides: np.ndarray, reach: float
) -> np.ndarray:  # pragma: no cover
    """Rows dx, dy, grey of the pixels within `reach` of a square; none where it is cut off."""
    none = np.empty((0, 3))
    det = sides[0, 0] * sides[1, 1] - sides[0, 1] * sides[1, 0]
    wide = reach * (abs(sides[0, 0]) + abs(sides[1, 0]))
    high = reach * (abs(sides[0, 1]) + abs(sides[1, 1]))
    if not (abs(det) > 1.0 and math.isfinite(xy[0] + xy[1] + wide + high)):
        return none
    left, right = math.ceil(xy[0] - wide), math.floor(xy[0] + wide)
    top, bottom = math.ceil(xy[1] - high), math.floor(xy[1] + high)
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
def _fit_one(
    pixels: np.ndarray, xy: np.ndarray, sides: np.ndarray, fit: np.ndarray
) -> None:  # pragma: no cover
    """Damped Gauss-Newton from a corner at (0, 0) of the window."""
    state = _start(pixels, sides)
    cost, normal, right = _linearize(pixels, state)
    damping = 1e-3
    for _ in range(_STEPS):
        step = _solve(normal, right, damping)
        tried = state + step
        new_cost, new_normal, new_right = _linearize(pixels, tried)
        if new_cost < cost and 0.2 < tried[4] < 30.0:
            state, cost, normal, right = tried, new_cost, new_normal, new_right
            damping *= 0.2
            if abs(step[0]) + abs(step[1]) < _CONVERGED_PX:
                break
        else:
            damping *= 10.0
            if damping > 1e6:
                break
    variance = cost / max(1, len(pixels) - _SIZE)
    spread = 0.0
    for axis in range(2):
        unit = np.zeros(_SIZE)
        unit[axis] = 1.0
        spread += 0.5 * _solve(normal, unit, 0.0)[axis]
    if spread > 0.0 and math.isfinite(spread) and abs(state[5]) > 0.0:
        fit[0], fit[1] = xy[0] + state[0], xy[1] + state[1]
        fit[2] = math.sqrt(variance * spread)
        fit[3] = state[4]
        fit[4] = abs(state[5])
        fit[5] = math.sqrt(variance) / abs(state[5])


@njit(cache=True, nogil=True)
def _start(pixels: np.ndarray, sides: np.ndarray) -> np.ndarray:  # pragma: no cover
    """x, y, the two lines' angles, blur, contrast, mean and its two slopes."""
    state = np.zeros(_SIZE)
    state[2] = math.atan2(sides[0, 1], sides[0, 0])
    state[3] = math.atan2(sides[1, 1], sides[1, 0])
    state[4] = 1.2
    one = two = 0.0
    ones = 0
    for row in pixels:
        first = row[1] * math.cos(state[2]) - row[0] * math.sin(state[2])
        second = row[1] * math.cos(state[3]) - row[0] * math.sin(state[3])
        if first * second > 0.0:
            one += row[2]
            ones += 1
        else:
            two += row[2]
    one, two = one / max(1, ones), two / max(1, len(pixels) - ones)
    state[5], state[6] = 0.5 * (one - two), 0.5 * (one + two)
    return state


@njit(cache=True, nogil=True)
def _linearize(
    pixels: np.ndarray, state: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:  # pragma: no cover
    """Sum of squared residuals, normal matrix and right side."""
    cost = 0.0
    normal = np.zeros((_SIZE, _SIZE))
    right = np.zeros(_SIZE)
    slope = np.empty(_SIZE)
    c1, s1 = math.cos(state[2]), math.sin(state[2])
    c2, s2 = math.cos(state[3]), math.sin(state[3])
    blur = max(state[4], 0.2)
    for row in pixels:
        dx, dy = row[0] - state[0], row[1] - state[1]
        e1, g1 = _edge(dy * c1 - dx * s1, blur)
        e2, g2 = _edge(dy * c2 - dx * s2, blur)
        slope[5] = e1 * e2
        slope[6], slope[7], slope[8] = 1.0, row[0], row[1]
        residual = row[2] - (state[5] * slope[5] + state[6] + state[7] * row[0] + state[8] * row[1])
        first = _SIZE - 4
        if g1 != 0.0 or g2 != 0.0:
            first = 0
            g1, g2 = g1 * e2 * state[5], g2 * e1 * state[5]
            slope[0] = g1 * s1 + g2 * s2
            slope[1] = -g1 * c1 - g2 * c2
            slope[2] = -g1 * (dy * s1 + dx * c1)
            slope[3] = -g2 * (dy * s2 + dx * c2)
            slope[4] = -(g1 * (dy * c1 - dx * s1) + g2 * (dy * c2 - dx * s2)) / blur
        cost += residual * residual
        for i in range(first, _SIZE):
            right[i] += slope[i] * residual
            for j in range(first, i + 1):
                normal[i, j] += slope[i] * slope[j]
    return cost, normal, right


@njit(cache=True, nogil=True)
def _edge(distance: float, blur: float) -> tuple[float, float]:  # pragma: no cover
    """An edge's profile between -1 and 1, and its slope (zero far away)."""
    if abs(distance) > _FAR * blur:
        return math.copysign(1.0, distance), 0.0
    scaled = distance / (blur * math.sqrt(2.0))
    return math.erf(scaled), math.sqrt(2.0 / math.pi) / blur * math.exp(-scaled * scaled)


@njit(cache=True, nogil=True)
def _solve(normal: np.ndarray, right: np.ndarray, damping: float) -> np.ndarray:  # pragma: no cover
    """(N + damping diag N)^-1 right; NaN where N is singular."""
    system = np.empty((_SIZE, _SIZE + 1))
    answer = np.empty(_SIZE)
    for i in range(_SIZE):
        for j in range(i):
            system[j, i] = normal[i, j]
        system[i, i] = normal[i, i] * (1.0 + damping)
        system[i, _SIZE] = right[i]
    if not solve_positive(system, 0.0, answer):
        answer[:] = math.nan
    return answer
