"""Sampling: projection, interpolation and multi-photo windows, shared by the measuring kernels."""

import math
from typing import NamedTuple

import numpy as np

from limbgram.core.geometry.lens import distorted_in
from limbgram.core.kernels import njit
from limbgram.reconstruction.measuring.imagery import Imagery

f4 = np.float32

MARGIN_PX = 3.0
"""Samples stay this far inside a crop: the reach of the cubic B-spline and a little more."""

HALF_WIDTH = 4
SAMPLES = (2 * HALF_WIDTH + 1) ** 2
"""Samples of a window: 9 x 9, one step apart."""
_STRIDE = 96
"""Length of a row of the buffer: one number per sample, padded."""
_U, _V, _FRACTION_X, _FRACTION_Y, _PIXEL_X, _PIXEL_Y, _GREY, _CHANGE = range(8)
_COEFFICIENTS = 8
"""Rows of a window's buffer: the samples' position in the window, their fraction of a pixel, their
pixel, the results, and the 16 coefficients round each."""

_POWER_ITERATIONS = 12
_MIN_CORRELATION = 0.5
"""A photo whose window correlates less with the common texture is left out."""
_TEXTURE_OVER_NOISE = 4.0
"""Power of texture over that of noise from which photos must show it: twice the amplitude. With
textureless photos left in, RMS in burnt-out paint grew from 0.0176 to 0.0255 mm."""


class Patches(NamedTuple):
    """A small patch of the surface round each of n vertices, bent by a quadric."""

    vertices_mm: np.ndarray
    """(n, 3)"""
    axes: np.ndarray
    """(n, 3, 3): two tangents and the normal, rows."""
    quadric: np.ndarray
    """(n, 3): height = (q0 u^2 + 2 q1 u v + q2 v^2) / 2 over the tangents, 1/mm."""
    step_mm: np.ndarray
    """(n,): distance of neighbouring samples."""

    def rows(self, chosen: slice) -> "Patches":
        """Some of the patches, as views."""
        return Patches(*(one[chosen] for one in self))


class Windows(NamedTuple):
    """The windows of one patch in up to c photos: a thread's working memory, filled again for each.

    Its first rows are those of the photos that are used.
    """

    value: np.ndarray
    """(c, SAMPLES) float32: grey levels less their weighted mean."""
    slope: np.ndarray
    """(c, SAMPLES) float32: their change per millimetre of offset along the normal."""
    mean: np.ndarray
    """(c,): weighted mean grey level."""
    photo_of: np.ndarray
    """(c,): index of the photo."""
    gram: np.ndarray
    """(c, c): weighted products of the windows."""
    gains: np.ndarray
    """(c,): leading unit eigenvector of the Gram matrix."""
    next_gains: np.ndarray
    """(c,): those of the next power iteration."""
    weights: np.ndarray
    """(SAMPLES,) float32: Gaussian, sum 1."""
    buffer: np.ndarray
    """One array for all numbers of the samples, so that loops over them are vectorised: the
    compiler does not vectorise loops over two arrays, which might overlap."""


@njit(inline="always")
def project(view: np.ndarray, x: float, y: float, z: float) -> tuple[float, ...]:
    """Pixel (u, v) of a world point through the exact lens, and d(u, v)/d(x, y, z) as 6 numbers.

    `view` is View.packed. It returns numbers, not arrays, and is inlined: the measuring kernels
    project each sample, and their compiler may reorder the sums (fastmath).
    """
    a = view[0] * x + view[1] * y + view[2] * z + view[9]
    b = view[3] * x + view[4] * y + view[5] * z + view[10]
    c = view[6] * x + view[7] * y + view[8] * z + view[11]
    per_depth = 1.0 / c
    p, q = a * per_depth, b * per_depth
    fx, fy, cx, cy, skew = view[12], view[13], view[14], view[15], view[16]
    pd, qd, pp, pq, qq = distorted_in(view, p, q)
    u, v = fx * pd + skew * qd + cx, fy * qd + cy
    up, uq = fx * pp + skew * pq, fx * pq + skew * qq
    vp, vq = fy * pq, fy * qq
    ux = (up * (view[0] - p * view[6]) + uq * (view[3] - q * view[6])) * per_depth
    uy = (up * (view[1] - p * view[7]) + uq * (view[4] - q * view[7])) * per_depth
    uz = (up * (view[2] - p * view[8]) + uq * (view[5] - q * view[8])) * per_depth
    vx = (vp * (view[0] - p * view[6]) + vq * (view[3] - q * view[6])) * per_depth
    vy = (vp * (view[1] - p * view[7]) + vq * (view[4] - q * view[7])) * per_depth
    vz = (vp * (view[2] - p * view[8]) + vq * (view[5] - q * view[8])) * per_depth
    return u, v, c, ux, uy, uz, vx, vy, vz


@njit(inline="always", fastmath=True)
def interpolate(coefficients: np.ndarray, start: int, width: int, x: float, y: float):
    """Value, d/dx and d/dy of the cubic B-spline at crop pixel (x, y)."""
    column, row = int(x), int(y)
    t, s = f4(x - column), f4(y - row)
    third, half, sixth = f4(2 / 3), f4(0.5), f4(1 / 6)
    t1, s1 = f4(1) - t, f4(1) - s
    a0, a3 = t1 * t1 * t1 * sixth, t * t * t * sixth
    a1 = third + t * t * (half * t - f4(1))
    a2 = f4(1) - a0 - a1 - a3
    d0, d3 = -t1 * t1 * half, t * t * half
    d1 = t * (f4(1.5) * t - f4(2))
    d2 = -d0 - d1 - d3
    b0, b3 = s1 * s1 * s1 * sixth, s * s * s * sixth
    b1 = third + s * s * (half * s - f4(1))
    b2 = f4(1) - b0 - b1 - b3
    e0, e3 = -s1 * s1 * half, s * s * half
    e1 = s * (f4(1.5) * s - f4(2))
    e2 = -e0 - e1 - e3
    value, along_x, along_y = f4(0), f4(0), f4(0)
    at = start + (row - 1) * width + column - 1
    for k in range(4):
        c0, c1 = coefficients[at], coefficients[at + 1]
        c2, c3 = coefficients[at + 2], coefficients[at + 3]
        line = a0 * c0 + a1 * c1 + a2 * c2 + a3 * c3
        slope = d0 * c0 + d1 * c1 + d2 * c2 + d3 * c3
        b = b0 if k == 0 else b1 if k == 1 else b2 if k == 2 else b3
        e = e0 if k == 0 else e1 if k == 1 else e2 if k == 2 else e3
        value += b * line
        along_y += e * line
        along_x += b * slope
        at += width
    return value, along_x, along_y


@njit(fastmath=True, cache=True, forceinline=True)
def window_weights():
    """Gaussian weights of a window's samples, sum 1."""
    weights = np.empty(SAMPLES, np.float32)
    side = 2 * HALF_WIDTH + 1
    for k in range(SAMPLES):
        u, v = k % side - HALF_WIDTH, k // side - HALF_WIDTH
        weights[k] = math.exp(-0.5 * (u * u + v * v) / (0.75 * HALF_WIDTH) ** 2)
    return weights / weights.sum()


@njit(cache=True, forceinline=True)
def empty_windows(most: int):
    """Windows of up to `most` photos."""
    side = 2 * HALF_WIDTH + 1
    buffer = np.zeros((_COEFFICIENTS + 16) * _STRIDE, np.float32)
    for k in range(SAMPLES):
        buffer[_U * _STRIDE + k] = k % side - HALF_WIDTH
        buffer[_V * _STRIDE + k] = k // side - HALF_WIDTH
    return Windows(
        np.empty((most, SAMPLES), np.float32),
        np.empty((most, SAMPLES), np.float32),
        np.empty(most),
        np.empty(most, np.int64),
        np.empty((most, most)),
        np.empty(most),
        np.empty(most),
        window_weights(),
        buffer,
    )


@njit(fastmath=True, cache=True, forceinline=True)
def sample_windows(
    imagery: Imagery,
    seen_by: np.ndarray,
    patches: Patches,
    p: int,
    state: np.ndarray,
    least_variance: float,
    windows: Windows,
):
    """Fill the windows of patch `p`, moved by `state` (offset and two slopes), and their slopes.

    Returns the number of photos with a whole, textured window, and the mean pixels per mm.
    """
    coefficients, crops, factor, views = imagery
    weights, buffer = windows.weights, windows.buffer
    vertex, axes, quadric = patches.vertices_mm[p], patches.axes[p], patches.quadric[p]
    step = patches.step_mm[p]
    shift = 0.5 * factor - 0.5
    used = 0
    px_per_mm = 0.0
    x = vertex[0] + state[0] * axes[2, 0]
    y = vertex[1] + state[0] * axes[2, 1]
    z = vertex[2] + state[0] * axes[2, 2]
    bend = 0.5 * step * step
    highest = (
        bend * HALF_WIDTH * HALF_WIDTH * (abs(quadric[0]) + 2 * abs(quadric[1]) + abs(quadric[2]))
    )
    q0, q1, q2 = f4(bend * quadric[0]), f4(2 * bend * quadric[1]), f4(bend * quadric[2])
    for photo in seen_by:
        if photo < 0:
            break
        u, v, depth, ux, uy, uz, vx, vy, vz = project(views[photo], x, y, z)
        if not depth > 0:
            continue
        start, width, height = crops[photo, 0], crops[photo, 3], crops[photo, 4]
        cx, cy = u * factor + shift - crops[photo, 1], v * factor + shift - crops[photo, 2]
        nx = (ux * axes[2, 0] + uy * axes[2, 1] + uz * axes[2, 2]) * factor
        ny = (vx * axes[2, 0] + vy * axes[2, 1] + vz * axes[2, 2]) * factor
        ax = ((ux * axes[0, 0] + uy * axes[0, 1] + uz * axes[0, 2]) * factor + state[1] * nx) * step
        ay = ((vx * axes[0, 0] + vy * axes[0, 1] + vz * axes[0, 2]) * factor + state[1] * ny) * step
        bx = ((ux * axes[1, 0] + uy * axes[1, 1] + uz * axes[1, 2]) * factor + state[2] * nx) * step
        by = ((vx * axes[1, 0] + vy * axes[1, 1] + vz * axes[1, 2]) * factor + state[2] * ny) * step
        reach_x = HALF_WIDTH * (abs(ax) + abs(bx)) + highest * abs(nx) + MARGIN_PX
        reach_y = HALF_WIDTH * (abs(ay) + abs(by)) + highest * abs(ny) + MARGIN_PX
        if not (
            cx > reach_x and cy > reach_y and cx + reach_x < width - 1 and cy + reach_y < height - 1
        ):
            continue
        # Positions start before the window and are positive, so that truncation is the floor.
        left, top = int(cx) - int(reach_x), int(cy) - int(reach_y)
        x0, y0, fx, fy = f4(cx - left), f4(cy - top), f4(nx), f4(ny)
        axf, ayf, bxf, byf = f4(ax), f4(ay), f4(bx), f4(by)
        for k in range(SAMPLES):
            i, j = buffer[_U * _STRIDE + k], buffer[_V * _STRIDE + k]
            lift = q0 * i * i + q1 * i * j + q2 * j * j
            right, down = x0 + axf * i + bxf * j + fx * lift, y0 + ayf * i + byf * j + fy * lift
            column, line = f4(np.int32(right)), f4(np.int32(down))
            buffer[_FRACTION_X * _STRIDE + k], buffer[_FRACTION_Y * _STRIDE + k] = (
                right - column,
                down - line,
            )
            buffer[_PIXEL_X * _STRIDE + k], buffer[_PIXEL_Y * _STRIDE + k] = column, line
        _fetch_coefficients(coefficients, start + (top - 1) * width + left - 1, width, buffer)
        _interpolate_all(buffer, fx, fy)
        level = f4(0)
        for k in range(SAMPLES):
            level += weights[k] * buffer[_GREY * _STRIDE + k]
        variance = f4(0)
        for k in range(SAMPLES):
            grey = buffer[_GREY * _STRIDE + k] - level
            variance += weights[k] * grey * grey
        if variance < least_variance:
            continue
        for k in range(SAMPLES):
            windows.value[used, k] = buffer[_GREY * _STRIDE + k] - level
            windows.slope[used, k] = buffer[_CHANGE * _STRIDE + k]
        windows.mean[used] = level
        windows.photo_of[used] = photo
        used += 1
        px_per_mm += math.sqrt(nx * nx + ny * ny)
    return used, px_per_mm / max(used, 1)


@njit(fastmath=True, cache=True, forceinline=True)
def _fetch_coefficients(coefficients: np.ndarray, first: int, width: int, buffer: np.ndarray):
    """Fill the 4 x 4 coefficients round each sample; `first` is the index of pixel (0, 0)."""
    for k in range(SAMPLES):
        at = (
            first
            + np.int64(buffer[_PIXEL_Y * _STRIDE + k]) * width
            + np.int64(buffer[_PIXEL_X * _STRIDE + k])
        )
        for row in range(4):
            for column in range(4):
                c = coefficients[np.uint64(at + row * width + column)]
                buffer[(_COEFFICIENTS + 4 * row + column) * _STRIDE + k] = c


@njit(fastmath=True, cache=True, forceinline=True)
def _interpolate_all(buffer: np.ndarray, nx: np.float32, ny: np.float32):
    """Fill grey values of a window's samples, and their change along (nx, ny), as `interpolate`."""
    third, half, sixth, one = f4(2 / 3), f4(0.5), f4(1 / 6), f4(1)
    for k in range(SAMPLES):
        t, s = buffer[_FRACTION_X * _STRIDE + k], buffer[_FRACTION_Y * _STRIDE + k]
        t1, s1 = one - t, one - s
        a0, a3 = t1 * t1 * t1 * sixth, t * t * t * sixth
        a1 = third + t * t * (half * t - one)
        a2 = one - a0 - a1 - a3
        d0, d3 = -t1 * t1 * half, t * t * half
        d1 = t * (f4(1.5) * t - f4(2))
        d2 = -d0 - d1 - d3
        b0, b3 = s1 * s1 * s1 * sixth, s * s * s * sixth
        b1 = third + s * s * (half * s - one)
        b2 = one - b0 - b1 - b3
        e0, e3 = -s1 * s1 * half, s * s * half
        e1 = s * (f4(1.5) * s - f4(2))
        e2 = -e0 - e1 - e3
        grey, along_x, along_y = f4(0), f4(0), f4(0)
        for column in range(4):
            c0, c1 = (
                buffer[(_COEFFICIENTS + column) * _STRIDE + k],
                buffer[(_COEFFICIENTS + 4 + column) * _STRIDE + k],
            )
            c2, c3 = (
                buffer[(_COEFFICIENTS + 8 + column) * _STRIDE + k],
                buffer[(_COEFFICIENTS + 12 + column) * _STRIDE + k],
            )
            down = b0 * c0 + b1 * c1 + b2 * c2 + b3 * c3
            a = a0 if column == 0 else a1 if column == 1 else a2 if column == 2 else a3
            d = d0 if column == 0 else d1 if column == 1 else d2 if column == 2 else d3
            grey += a * down
            along_x += d * down
            along_y += a * (e0 * c0 + e1 * c1 + e2 * c2 + e3 * c3)
        buffer[_GREY * _STRIDE + k] = grey
        buffer[_CHANGE * _STRIDE + k] = along_x * nx + along_y * ny


@njit(fastmath=True, cache=True, forceinline=True)
def fill_gram(windows: Windows, used: int):
    """Fill the Gram matrix."""
    value, weights, gram = windows.value, windows.weights, windows.gram
    for i in range(used):
        for j in range(i + 1):
            product = f4(0)
            for k in range(SAMPLES):
                product += weights[k] * value[i, k] * value[j, k]
            gram[i, j] = product
            gram[j, i] = product


@njit(fastmath=True, cache=True, forceinline=True)
def leading_gains(windows: Windows, used: int):
    """Fill the gains by power iteration; False unless all are positive."""
    gram, gains, next_gains = windows.gram, windows.gains, windows.next_gains
    for i in range(used):
        gains[i] = math.sqrt(gram[i, i])
    for _ in range(_POWER_ITERATIONS):
        length = 0.0
        for i in range(used):
            row = 0.0
            for j in range(used):
                row += gram[i, j] * gains[j]
            next_gains[i] = row
            length += row * row
        length = 1.0 / math.sqrt(length)
        for i in range(used):
            gains[i] = next_gains[i] * length
    all_positive = True
    for i in range(used):
        all_positive = all_positive and gains[i] > 0.02
    return all_positive


@njit(fastmath=True, cache=True, forceinline=True)
def drop_inconsistent_photos(windows: Windows, used: int, noise: float):
    """Drop, one by one, the photos whose windows are inconsistent with the others': a highlight, a
    shadow's edge, an object before the limb.

    Differences up to `noise`, grey levels squared, are consistent: otherwise bare skin would keep
    the two photos whose noise correlates by chance, and those keep the surface from moving. A photo
    without contrast where the others show texture, as in burnt-out paint, is inconsistent.

    The rows are compacted and the gains filled. Returns the number of photos that remain; 0 if half
    of them or more would go, or the last two are inconsistent.
    """
    value, slope, gram, gains = windows.value, windows.slope, windows.gram, windows.gains
    mean, photo_of = windows.mean, windows.photo_of
    initial = used
    while True:
        all_positive = leading_gains(windows, used)
        energy = 0.0
        for i in range(used):
            for j in range(used):
                energy += gains[i] * gram[i, j] * gains[j]
        worst, lowest, textured = -1, _MIN_CORRELATION, 0
        for i in range(used):
            textured += gram[i, i] >= noise
            textureless = gram[i, i] < noise and energy > _TEXTURE_OVER_NOISE * used * noise
            if gram[i, i] - gains[i] * gains[i] * energy < noise and not textureless:
                continue
            correlation = gains[i] * math.sqrt(energy / max(gram[i, i], 1e-9))
            if correlation < lowest:
                worst, lowest = i, correlation
        if textured == 1:  # a single photo with contrast shows no common texture
            worst = np.argmax(gains[:used])
        if worst < 0 or used < 3:
            return used if all_positive or (worst < 0 and noise > 0) else 0
        used -= 1
        if 2 * used <= initial:
            return 0
        mean[worst], photo_of[worst] = mean[used], photo_of[used]
        for k in range(SAMPLES):
            value[worst, k], slope[worst, k] = value[used, k], slope[used, k]
        for j in range(used):
            gram[worst, j] = gram[used, j]
            gram[j, worst] = gram[j, used]
        gram[worst, worst] = gram[used, used]
