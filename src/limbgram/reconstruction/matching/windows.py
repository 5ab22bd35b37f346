"""Window correlation: matches refined to sub-pixel accuracy, false ones dropped.

In      two photos' brightness, and matched keypoints.
Out     where each first keypoint lies in the second photo, and how well the windows correlate.
Method  The window round the first keypoint is compared with the second photo through a local affine
        map, which starts as the similarity between the two keypoints (their scales and
        orientations) and is improved by least-squares matching (Grün 1985), in its inverse
        compositional form (Baker and Matthews 2004): the normal matrix belongs to the first window
        and is computed once. Gain and offset are taken out by giving both windows zero mean and
        unit deviation.
        Windows are sampled with the cubic B-spline, which is smooth to the second derivative and
        smooths both photos alike, in the level of a pyramid that suits the keypoint's scale. A
        level is the 2 x 2 mean of the one before, a last odd row or column left out, so that pixel
        centres are kept: x_level = (x + 0.5) / 2^level - 0.5.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Float64, Int32, Int64, UInt8

from limbgram.core.geometry.arrays import GreyImage, Points2
from limbgram.core.kernels import njit
from limbgram.reconstruction.features.detection import Keypoints

LEVELS = 4
RADIUS = 6
"""Windows are squares of 2 RADIUS + 1 samples."""
SAMPLES = (2 * RADIUS + 1) ** 2
_SIDE = 2 * RADIUS + 1


@dataclass(frozen=True)
class Pyramid:
    """Image pyramid in one array; per level its offset, height and width."""

    pixels: UInt8[np.ndarray, " p"]
    layout: Int64[np.ndarray, "levels 3"]


def build_pyramid(luma: GreyImage) -> Pyramid:
    levels: list[GreyImage] = [np.ascontiguousarray(luma)]
    while len(levels) < LEVELS and min(levels[-1].shape) >= 2:
        levels.append(_halved(levels[-1]))
    return Pyramid(np.concatenate([level.ravel() for level in levels]), _layout(levels))


@njit(cache=True, nogil=True)
def sample_window(pixels: np.ndarray, x: float, y: float, window: np.ndarray) -> bool:
    """Luma and its slopes along x and y, pixel by pixel round a place; False outside."""
    height, width = pixels.shape
    if not (RADIUS + 1 <= x < width - RADIUS - 2 and RADIUS + 1 <= y < height - RADIUS - 2):
        return False
    left, top = int(x) - RADIUS - 1, int(y) - RADIUS - 1
    weights_x, weights_y = _weights(x - int(x)), _weights(y - int(y))
    slopes_x, slopes_y = _slope_weights(x - int(x)), _slope_weights(y - int(y))
    for row in range(_SIDE):
        for column in range(_SIDE):
            luma = across = down = 0.0
            for j in range(4):
                line = slope = 0.0
                for i in range(4):
                    value = float(pixels[top + row + j, left + column + i])
                    line += weights_x[i] * value
                    slope += slopes_x[i] * value
                luma += weights_y[j] * line
                across += weights_y[j] * slope
                down += slopes_y[j] * line
            sample = row * _SIDE + column
            window[0, sample], window[1, sample], window[2, sample] = luma, across, down
    return True


@njit(cache=True, nogil=True)
def sample_warped(pixels: np.ndarray, place: np.ndarray, values: np.ndarray) -> bool:
    """Luma of a window under an affine map (x, dx/du, dx/dv, y, dy/du, dy/dv); False outside."""
    height, width = pixels.shape
    reach_x = RADIUS * (abs(place[1]) + abs(place[2]))
    reach_y = RADIUS * (abs(place[4]) + abs(place[5]))
    if not (reach_x + 1 <= place[0] < width - 2 - reach_x):
        return False
    if not (reach_y + 1 <= place[3] < height - 2 - reach_y):
        return False
    for sample in range(SAMPLES):
        u, v = sample % _SIDE - RADIUS, sample // _SIDE - RADIUS
        x = place[0] + place[1] * u + place[2] * v
        y = place[3] + place[4] * u + place[5] * v
        column, row = int(x), int(y)
        x0, x1, x2, x3 = _weights(x - column)
        weights_y = _weights(y - row)
        luma = 0.0
        for j in range(4):
            line = pixels[row - 1 + j]
            luma += weights_y[j] * (
                x0 * line[column - 1]
                + x1 * line[column]
                + x2 * line[column + 1]
                + x3 * line[column + 2]
            )
        values[sample] = luma
    return True


@njit(cache=True, nogil=True, inline="always")
def _weights(t: float) -> tuple[float, float, float, float]:
    s = 1 - t
    return (
        s * s * s / 6,
        2 / 3 - t * t * (2 - t) / 2,
        2 / 3 - s * s * (2 - s) / 2,
        t * t * t / 6,
    )


@njit(cache=True, nogil=True, inline="always")
def _slope_weights(t: float) -> tuple[float, float, float, float]:
    s = 1 - t
    return -s * s / 2, -2 * t + 1.5 * t * t, 2 * s - 1.5 * s * s, t * t / 2


def _halved(luma: GreyImage) -> UInt8[np.ndarray, "half_h half_w"]:
    height_px, width_px = luma.shape[0] // 2, luma.shape[1] // 2
    even = luma[: 2 * height_px, : 2 * width_px]
    return cv2.resize(even, (width_px, height_px), interpolation=cv2.INTER_AREA).astype(
        np.uint8, copy=False
    )


def _layout(levels: Sequence[GreyImage]) -> Int64[np.ndarray, "levels 3"]:
    ends = np.cumsum([level.size for level in levels])
    return np.array(
        [
            (end - level.size, level.shape[0], level.shape[1])
            for level, end in zip(levels, ends, strict=True)
        ],
        np.int64,
    )


_SIGMA_AT_LEVEL_PX = 2.0
"""Scale, in pixels of a level, of the keypoints that it suits."""
_STEPS = 15
_STILL_PX = 0.005
_LEAST_CONTRAST = 2.0
"""Standard deviation of luma below which a window shows nothing."""
_RIDGE = 1e-3
_FINER = 2
"""Levels by which a second comparison of a converged window is finer."""
_AGREEMENT_WHEN_FINER = 0.9
"""Correlation from which that second comparison counts."""


@njit(cache=True, nogil=True)
def correlate_all(
    pixels_first: np.ndarray,
    layout_first: np.ndarray,
    pixels_second: np.ndarray,
    layout_second: np.ndarray,
    rows_first: np.ndarray,
    rows_second: np.ndarray,
    max_shift: float,
    result: np.ndarray,
) -> None:
    """Per match x, y and correlation; NaN where a window leaves the photo or does not converge.

    Rows are x, y, scale and angle (radians). A match is compared in the level that suits its
    scale, and large ones then in a finer level too.
    """
    scratch = np.empty((10, SAMPLES))
    for row in range(rows_first.shape[0]):
        x, y, sigma, angle = rows_first[row]
        x2, y2, sigma2, angle2 = rows_second[row]
        change = sigma2 / sigma
        cosine, sine = math.cos(angle2 - angle) * change, math.sin(angle2 - angle) * change
        place = np.array([x2, cosine, -sine, y2, sine, cosine])
        level = _level_for(sigma, layout_first.shape[0])
        correlation = np.nan
        for shown in (level, level - _FINER):
            level2 = _level_for(2.0**shown * change * _SIGMA_AT_LEVEL_PX, layout_second.shape[0])
            offset, height, width = layout_first[shown]
            first = pixels_first[offset : offset + height * width]
            offset2, height2, width2 = layout_second[level2]
            second = pixels_second[offset2 : offset2 + height2 * width2]
            attempt = place.copy()
            agreement = _compare(
                first.reshape(height, width),
                second.reshape(height2, width2),
                2.0**shown,
                2.0**level2,
                x,
                y,
                attempt,
                max_shift,
                scratch,
            )
            if math.isnan(correlation) or agreement >= _AGREEMENT_WHEN_FINER:
                place, correlation = attempt, agreement
            if level < _FINER or math.isnan(correlation):
                break
        result[row, 0], result[row, 1], result[row, 2] = place[0], place[3], correlation


@njit(cache=True, nogil=True)
def follow_all(
    pixels_first: np.ndarray,
    layout_first: np.ndarray,
    pixels_second: np.ndarray,
    layout_second: np.ndarray,
    xy_first: np.ndarray,
    expected: np.ndarray,
    max_shift: float,
    min_correlation: float,
    result: np.ndarray,
) -> None:
    """Per point x, y and correlation in the second photo, from where placed photos expect it.

    `expected` (n, 6) are affine maps as sample_warped takes them, in full-size pixels. A window of
    the second level catches the point, one of the first then measures it again, and the mean of
    the two counts: the large window has less noise, the small one less relief. NaN
    where one leaves its photo, does not converge or correlates too little.
    """
    scratch = np.empty((10, SAMPLES))
    place = np.empty(6)
    for row in range(xy_first.shape[0]):
        result[row] = np.nan
        for k in range(6):
            place[k] = expected[row, k]
        x, y = xy_first[row]
        turned = math.sqrt(abs(place[1] * place[5] - place[2] * place[4]))
        caught_x = caught_y = np.nan
        for upper in (1, 0):
            level = min(upper, layout_first.shape[0] - 1)
            level2 = _level_for(2.0**level * turned * _SIGMA_AT_LEVEL_PX, layout_second.shape[0])
            offset, height, width = layout_first[level]
            offset2, height2, width2 = layout_second[level2]
            agreement = _compare(
                pixels_first[offset : offset + height * width].reshape(height, width),
                pixels_second[offset2 : offset2 + height2 * width2].reshape(height2, width2),
                2.0**level,
                2.0**level2,
                x,
                y,
                place,
                max_shift,
                scratch,
            )
            if not agreement >= min_correlation:
                break
            if upper:
                caught_x, caught_y = place[0], place[3]
            else:
                result[row, 0] = 0.5 * (caught_x + place[0])
                result[row, 1] = 0.5 * (caught_y + place[3])
                result[row, 2] = agreement


@njit(cache=True, nogil=True)
def _compare(
    first: np.ndarray,
    second: np.ndarray,
    size: float,
    size2: float,
    x: float,
    y: float,
    place: np.ndarray,
    max_shift: float,
    scratch: np.ndarray,
) -> float:
    """Improve the affine map `place` (full-size pixels) in two levels; the correlation, or NaN."""
    window, slopes, other = scratch[:3], scratch[3:9], scratch[9]
    if not sample_window(first, (x + 0.5) / size - 0.5, (y + 0.5) / size - 0.5, window):
        return np.nan
    contrast = _normalize(window[0])
    if contrast < _LEAST_CONTRAST:
        return np.nan
    normal = _normal_matrix(window, contrast, slopes)
    place[0], place[3] = (place[0] + 0.5) / size2 - 0.5, (place[3] + 0.5) / size2 - 0.5
    for k in (1, 2, 4, 5):
        place[k] *= size / size2
    correlation = _gauss_newton(second, window[0], slopes, normal, place, other, max_shift)
    place[0], place[3] = (place[0] + 0.5) * size2 - 0.5, (place[3] + 0.5) * size2 - 0.5
    for k in (1, 2, 4, 5):
        place[k] *= size2 / size
    return correlation


@njit(cache=True, nogil=True)
def _level_for(sigma: float, levels: int) -> int:
    level = round(math.log2(sigma / _SIGMA_AT_LEVEL_PX))
    return min(max(level, 0), levels - 1)


@njit(cache=True, nogil=True)
def _gauss_newton(
    pixels: np.ndarray,
    window: np.ndarray,
    slopes: np.ndarray,
    inverse_normal: np.ndarray,
    place: np.ndarray,
    other: np.ndarray,
    max_shift: float,
) -> float:
    """Gauss-Newton on the six parameters in `place`, changed in place; the final correlation."""
    start_x, start_y = place[0], place[3]
    step = np.empty(6)
    pull = np.empty(6)
    for _ in range(_STEPS):
        if not sample_warped(pixels, place, other):
            return np.nan
        if _normalize(other) < _LEAST_CONTRAST:
            return np.nan
        p0 = p1 = p2 = p3 = p4 = p5 = 0.0  # six sums that need not wait for each other
        for sample in range(SAMPLES):
            difference = other[sample] - window[sample]
            p0 += slopes[0, sample] * difference
            p1 += slopes[1, sample] * difference
            p2 += slopes[2, sample] * difference
            p3 += slopes[3, sample] * difference
            p4 += slopes[4, sample] * difference
            p5 += slopes[5, sample] * difference
        pull[0], pull[1], pull[2], pull[3], pull[4], pull[5] = p0, p1, p2, p3, p4, p5
        for k in range(6):
            step[k] = 0.0
            for other_k in range(6):
                step[k] += inverse_normal[k, other_k] * pull[other_k]
        before_x, before_y = place[0], place[3]
        if not _undo(place, step):
            return np.nan
        if math.hypot(place[0] - start_x, place[3] - start_y) > max_shift:
            return np.nan
        if math.hypot(place[0] - before_x, place[3] - before_y) < _STILL_PX:
            break
    if not sample_warped(pixels, place, other):
        return np.nan
    if _normalize(other) < _LEAST_CONTRAST:
        return np.nan
    product = 0.0
    for sample in range(SAMPLES):
        product += window[sample] * other[sample]
    return product / SAMPLES


@njit(cache=True, nogil=True)
def _undo(place: np.ndarray, step: np.ndarray) -> bool:
    """Compose the map with the inverse of a small affine step; False where the map collapses."""
    a, b = 1 + step[1] / RADIUS, step[2] / RADIUS
    c, d = step[4] / RADIUS, 1 + step[5] / RADIUS
    determinant = a * d - b * c
    if not 0.25 < determinant < 4:
        return False
    ia, ib, ic, id_ = d / determinant, -b / determinant, -c / determinant, a / determinant
    shift_u = -(ia * step[0] + ib * step[3])
    shift_v = -(ic * step[0] + id_ * step[3])
    p1, p2, p4, p5 = place[1], place[2], place[4], place[5]
    place[0] += p1 * shift_u + p2 * shift_v
    place[3] += p4 * shift_u + p5 * shift_v
    place[1], place[2] = p1 * ia + p2 * ic, p1 * ib + p2 * id_
    place[4], place[5] = p4 * ia + p5 * ic, p4 * ib + p5 * id_
    area = abs(place[1] * place[5] - place[2] * place[4])
    return 0.1 < area < 10


@njit(cache=True, nogil=True)
def _normal_matrix(window: np.ndarray, contrast: float, slopes: np.ndarray) -> np.ndarray:
    """Fill the window's slopes by the six parameters; the inverse of their normal matrix."""
    s00 = s10 = s11 = s20 = s21 = s22 = s30 = s31 = s32 = s33 = 0.0
    s40 = s41 = s42 = s43 = s44 = s50 = s51 = s52 = s53 = s54 = s55 = 0.0
    for sample in range(SAMPLES):  # all sums at a time, as none needs to wait for another
        u = (sample % (2 * RADIUS + 1) - RADIUS) / RADIUS
        v = (sample // (2 * RADIUS + 1) - RADIUS) / RADIUS
        across, down = window[1, sample] / contrast, window[2, sample] / contrast
        a, b, c = across, across * u, across * v
        d, e, f = down, down * u, down * v
        slopes[0, sample], slopes[1, sample], slopes[2, sample] = a, b, c
        slopes[3, sample], slopes[4, sample], slopes[5, sample] = d, e, f
        s00, s10, s11 = s00 + a * a, s10 + b * a, s11 + b * b
        s20, s21, s22 = s20 + c * a, s21 + c * b, s22 + c * c
        s30, s31, s32, s33 = s30 + d * a, s31 + d * b, s32 + d * c, s33 + d * d
        s40, s41, s42, s43 = s40 + e * a, s41 + e * b, s42 + e * c, s43 + e * d
        s50, s51, s52, s53 = s50 + f * a, s51 + f * b, s52 + f * c, s53 + f * d
        s44, s54, s55 = s44 + e * e, s54 + f * e, s55 + f * f
    normal = np.empty((6, 6))
    normal[0, 0], normal[1, 1], normal[2, 2] = s00, s11, s22
    normal[3, 3], normal[4, 4], normal[5, 5] = s33, s44, s55
    normal[1, 0], normal[2, 0], normal[2, 1], normal[3, 0] = s10, s20, s21, s30
    normal[3, 1], normal[3, 2], normal[4, 0], normal[4, 1] = s31, s32, s40, s41
    normal[4, 2], normal[4, 3], normal[5, 0], normal[5, 1] = s42, s43, s50, s51
    normal[5, 2], normal[5, 3], normal[5, 4] = s52, s53, s54
    for i in range(6):
        for j in range(i):
            normal[j, i] = normal[i, j]
        normal[i, i] += _RIDGE
    return _inverse(normal)


@njit(cache=True, nogil=True)
def _normalize(values: np.ndarray) -> float:
    """Subtract the mean and divide by the standard deviation, which is returned."""
    mean = values.mean()
    deviation = 0.0
    for value in values:
        deviation += (value - mean) ** 2
    deviation = math.sqrt(deviation / values.size)
    if deviation > 0:
        for index in range(values.size):
            values[index] = (values[index] - mean) / deviation
    return deviation


@njit(cache=True, nogil=True)
def _inverse(matrix: np.ndarray) -> np.ndarray:
    """Inverse of a small positive definite matrix, which is destroyed (Gauss and Jordan)."""
    size = matrix.shape[0]
    inverse = np.eye(size)
    for pivot in range(size):
        scale = 1 / matrix[pivot, pivot]
        for k in range(size):
            matrix[pivot, k] *= scale
            inverse[pivot, k] *= scale
        for row in range(size):
            if row != pivot:
                factor = matrix[row, pivot]
                for k in range(size):
                    matrix[row, k] -= factor * matrix[pivot, k]
                    inverse[row, k] -= factor * inverse[pivot, k]
    return inverse


_MIN_CORRELATION = 0.8
"""Normalized cross-correlation after refinement."""
_MAX_SHIFT = 3.0
"""Farthest accepted move, in pixels of the level compared."""


@dataclass(frozen=True, kw_only=True)
class Correlated:
    """Refined places in the second photo, and which matches to keep."""

    xy_second_px: Float64[np.ndarray, "m 2"]
    correlation: Float32[np.ndarray, " m"]
    kept: Bool[np.ndarray, " m"]


def correlate(
    first: Pyramid,
    second: Pyramid,
    keypoints_first: Keypoints,
    keypoints_second: Keypoints,
    keypoint_idx: Int32[np.ndarray, "m 2"],
) -> Correlated:
    """Move the second point of each match to where its window agrees with the first's."""
    rows_first = _rows(keypoints_first, keypoint_idx[:, 0])
    rows_second = _rows(keypoints_second, keypoint_idx[:, 1])
    result = np.empty((len(keypoint_idx), 3))
    correlate_all(
        first.pixels,
        first.layout,
        second.pixels,
        second.layout,
        rows_first,
        rows_second,
        _MAX_SHIFT,
        result,
    )
    with np.errstate(invalid="ignore"):
        kept = result[:, 2] >= _MIN_CORRELATION
    return Correlated(
        xy_second_px=np.ascontiguousarray(result[:, :2]),
        correlation=result[:, 2].astype(np.float32),
        kept=kept,
    )


def follow(
    first: Pyramid,
    second: Pyramid,
    xy_first_px: Points2,
    expected: Float64[np.ndarray, "n 6"],
) -> Float64[np.ndarray, "n 3"]:
    """x, y and correlation of points of the first photo in the second; see follow_all."""
    result = np.empty((len(xy_first_px), 3))
    follow_all(
        first.pixels,
        first.layout,
        second.pixels,
        second.layout,
        np.ascontiguousarray(xy_first_px),
        np.ascontiguousarray(expected),
        _MAX_SHIFT,
        _MIN_CORRELATION,
        result,
    )
    return result


def _rows(keypoints: Keypoints, which: Int32[np.ndarray, " m"]) -> Float64[np.ndarray, "m 4"]:
    """x, y, scale, angle in radians."""
    return np.column_stack(
        [
            keypoints.xy_px[which],
            keypoints.scale_px[which],
            np.radians(keypoints.angle_deg[which]),
        ]
    ).astype(np.float64)
