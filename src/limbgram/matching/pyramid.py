"""Pyramid: a photo's luma at full, half, quarter and eighth size in one flat array for kernels.

A level is the 2 x 2 mean of the one before, a last odd row or column left out, so that pixel
centres are kept: x_level = (x + 0.5) / 2^level - 0.5. Windows are sampled with the cubic B-spline,
which is smooth to the second derivative and smooths both photos alike.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numba as nb
import numpy as np
from jaxtyping import Int64, UInt8

from limbgram.geometry.arrays import GreyImage

LEVELS = 4
RADIUS = 6
"""Windows are squares of 2 RADIUS + 1 samples."""
SAMPLES = (2 * RADIUS + 1) ** 2
_SIDE = 2 * RADIUS + 1


@dataclass(frozen=True)
class Pyramid:
    """All levels one after the other; per level where it starts, its height and its width."""

    pixels: UInt8[np.ndarray, " p"]
    layout: Int64[np.ndarray, "levels 3"]


def build_pyramid(luma: GreyImage) -> Pyramid:
    levels: list[GreyImage] = [np.ascontiguousarray(luma)]
    while len(levels) < LEVELS and min(levels[-1].shape) >= 2:
        levels.append(_halved(levels[-1]))
    return Pyramid(np.concatenate([level.ravel() for level in levels]), _layout(levels))


@nb.njit(cache=True, nogil=True)
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


@nb.njit(cache=True, nogil=True)
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


@nb.njit(cache=True, nogil=True, inline="always")
def _weights(t: float) -> tuple[float, float, float, float]:
    s = 1 - t
    return (
        s * s * s / 6,
        2 / 3 - t * t * (2 - t) / 2,
        2 / 3 - s * s * (2 - s) / 2,
        t * t * t / 6,
    )


@nb.njit(cache=True, nogil=True, inline="always")
def _slope_weights(t: float) -> tuple[float, float, float, float]:
    s = 1 - t
    return -s * s / 2, -2 * t + 1.5 * t * t, 2 * s - 1.5 * s * s, t * t / 2


def _halved(luma: GreyImage) -> GreyImage:
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
