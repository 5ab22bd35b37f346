"""PatchMatch: the best plane for every pixel of a photo, found by asking neighbours (compiled).

In      a packed reference and its sources at one pyramid level, the pixels to solve.
Out     inverse depth, its two slopes, and the score (mean of the better half of the
        correlations, so that photos in which the spot is hidden do not count).
Method  pixels of a chessboard's two colours in turn; each asks the better of two neighbours in
        four directions, then tries random changes (Barnes et al. 2009; Galliani et al. 2015).
        At the end a parabola through three correlations gives the sub-pixel place.

Every pixel reads the other colour only, and random numbers are hashes of pixel and turn: the
result does not depend on the order of work.
"""

import numpy as np
from numba import njit

from limbgram.dense.stereo.lanes import (
    ABOVE,
    ALIVE,
    BELOW,
    BEST_SCORE,
    BEST_W,
    BEST_X,
    BEST_Y,
    CORRELATION,
    FIRST,
    GX,
    GY,
    LANES,
    SCRATCH,
    SECOND,
    THIRD,
    TRUST,
    W0,
    WEIGHTED,
    correlate,
    f4,
    i4,
    look_at,
    u4,
)

TURNS = 3
"""Random changes a pixel tries in one sweep: both, slopes only, depth only."""
_FAR_PX = 5
"""The second neighbour in each direction is this far away; windows reach as far."""


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def start(pixels, w_range, focal_px, seed, state):
    """Random depths within the range (uniform in inverse depth) and random slopes."""
    low, high = f4(w_range[0]), f4(w_range[1])
    for pixel in pixels:
        w0 = low + (high - low) * _random(pixel, seed, 0)
        tilt = w0 / f4(focal_px)
        state[0, pixel] = w0
        state[1, pixel] = (f4(2) * _random(pixel, seed, 1) - f4(1)) * tilt
        state[2, pixel] = (f4(2) * _random(pixel, seed, 2) - f4(1)) * tilt


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def rate(picture, sources, pixels, w_range, state, score):
    """Score the planes that the pixels have now."""
    grey, width, by_grey, by_distance = picture
    t, index, word = _scratch()
    for first in range(0, len(pixels), LANES):
        block = pixels[first : first + LANES]
        look_at(grey, width, block, len(block), by_grey, by_distance, t, index)
        for lane in range(LANES):
            pixel = block[min(lane, len(block) - 1)]
            t[W0 + lane] = state[0, pixel]
            t[GX + lane] = state[1, pixel]
            t[GY + lane] = state[2, pixel]
            t[BEST_SCORE + lane] = f4(-2)
        _try(sources, w_range, t, index, word)
        for lane in range(len(block)):
            score[block[lane]] = t[BEST_SCORE + lane]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def sweep(picture, sources, pixels, w_range, focal_px, w_step, tilt_step, seed, state, score):
    """Improve the planes of one colour's pixels.

    w_step     size of random changes of inverse depth
    tilt_step  size of random changes of the slopes (tangent of the surface's tilt)
    """
    grey, width, by_grey, by_distance = picture
    t, index, word = _scratch()
    for first in range(0, len(pixels), LANES):
        block = pixels[first : first + LANES]
        look_at(grey, width, block, len(block), by_grey, by_distance, t, index)
        for lane in range(LANES):
            pixel = block[min(lane, len(block) - 1)]
            t[BEST_SCORE + lane] = score[pixel]
            t[BEST_W + lane] = state[0, pixel]
            t[BEST_X + lane] = state[1, pixel]
            t[BEST_Y + lane] = state[2, pixel]
        for side in range(4):
            dx, dy = i4(1 - side) * i4(side % 2 == 0), i4(2 - side) * i4(side % 2 == 1)
            _ask_neighbour(block, width, dx, dy, state, score, t)
            _try(sources, w_range, t, index, word)
        for turn in range(TURNS):
            _change(
                block,
                f4(focal_px),
                f4(w_step) * f4(turn != 1),
                f4(tilt_step) * f4(turn != 2),
                seed,
                turn,
                t,
            )
            _try(sources, w_range, t, index, word)
        for lane in range(len(block)):
            pixel = block[lane]
            score[pixel] = t[BEST_SCORE + lane]
            state[0, pixel] = t[BEST_W + lane]
            state[1, pixel] = t[BEST_X + lane]
            state[2, pixel] = t[BEST_Y + lane]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def polish(picture, sources, pixels, w_range, w_step, least, state, score):
    """Move each depth to the top of the parabola through three correlations, w_step apart.

    All photos that correlate better than `least` take part, by how much they do. The score
    becomes their mean correlation; -1 where none does.
    """
    grey, width, by_grey, by_distance = picture
    words, table, a, b, _ = sources
    t, index, word = _scratch()
    for first in range(0, len(pixels), LANES):
        block = pixels[first : first + LANES]
        look_at(grey, width, block, len(block), by_grey, by_distance, t, index)
        for step in range(3):
            away = f4(w_step) * f4(0 if step == 0 else 2 * step - 3)
            into = WEIGHTED if step == 0 else BELOW if step == 1 else ABOVE
            for lane in range(LANES):
                pixel = block[min(lane, len(block) - 1)]
                t[W0 + lane] = state[0, pixel] + away
                t[GX + lane] = state[1, pixel]
                t[GY + lane] = state[2, pixel]
                t[ALIVE + lane] = f4(1)
                t[into + lane] = f4(0)
            if step == 0:
                for lane in range(LANES):
                    t[FIRST + lane] = f4(1e-6)
            for s in range(len(table)):
                correlate(
                    words[table[s, 0] :], table[s, 1], table[s, 2], a[s], b[s], t, index, word
                )
                trust = TRUST + s * LANES
                for lane in range(LANES):
                    value = t[CORRELATION + lane]
                    if step == 0:
                        t[trust + lane] = max(value - f4(least), f4(0))
                        t[FIRST + lane] += t[trust + lane]
                    t[into + lane] += t[trust + lane] * value
        for lane in range(len(block)):
            pixel = block[lane]
            below, here, above = t[BELOW + lane], t[WEIGHTED + lane], t[ABOVE + lane]
            bend = f4(2) * here - below - above
            shift = f4(0.5) * (above - below) / max(bend, f4(1e-6))
            moved = state[0, pixel] + f4(w_step) * min(max(shift, f4(-1)), f4(1))
            state[0, pixel] = min(max(moved, f4(w_range[0])), f4(w_range[1]))
            score[pixel] = here / t[FIRST + lane] if t[FIRST + lane] > f4(2e-6) else f4(-1)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _try(sources, w_range, t, index, word):
    """Score the hypothesis in W0, GX, GY; where it is better it becomes the best."""
    words, table, a, b, kept = sources
    for lane in range(LANES):
        allowed = (t[W0 + lane] >= f4(w_range[0])) & (t[W0 + lane] <= f4(w_range[1]))
        t[ALIVE + lane] = f4(1) if allowed else f4(0)
        t[FIRST + lane] = f4(-1)
        t[SECOND + lane] = f4(-1)
        t[THIRD + lane] = f4(-1)
    for s in range(len(table)):
        correlate(words[table[s, 0] :], table[s, 1], table[s, 2], a[s], b[s], t, index, word)
        for lane in range(LANES):
            value = t[CORRELATION + lane]
            first, second, third = t[FIRST + lane], t[SECOND + lane], t[THIRD + lane]
            rest = min(first, value)
            t[FIRST + lane] = max(first, value)
            t[SECOND + lane] = max(second, rest)
            t[THIRD + lane] = max(third, min(second, rest))
    second_counts, third_counts = f4(kept > 1), f4(kept > 2)
    share = f4(1) / f4(kept)
    for lane in range(LANES):
        mean = share * (
            t[FIRST + lane] + second_counts * t[SECOND + lane] + third_counts * t[THIRD + lane]
        )
        better = (mean > t[BEST_SCORE + lane]) & (t[ALIVE + lane] > f4(0))
        t[BEST_SCORE + lane] = mean if better else t[BEST_SCORE + lane]
        t[BEST_W + lane] = t[W0 + lane] if better else t[BEST_W + lane]
        t[BEST_X + lane] = t[GX + lane] if better else t[BEST_X + lane]
        t[BEST_Y + lane] = t[GY + lane] if better else t[BEST_Y + lane]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _ask_neighbour(block, width, dx, dy, state, score, t):
    """The plane of the better of a near and a far neighbour, continued to the pixel itself."""
    for lane in range(LANES):
        pixel = block[min(lane, len(block) - 1)]
        near = pixel + dy * width + dx
        far = pixel + i4(_FAR_PX) * (dy * width + dx)
        further = score[far] > score[near]
        asked = far if further else near
        steps = f4(_FAR_PX) if further else f4(1)
        gx, gy = state[1, asked], state[2, asked]
        t[GX + lane] = gx
        t[GY + lane] = gy
        t[W0 + lane] = state[0, asked] - steps * (gx * f4(dx) + gy * f4(dy))


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _change(block, focal_px, w_step, tilt_step, seed, turn, t):
    """A random change of the best plane so far."""
    for lane in range(LANES):
        pixel = block[min(lane, len(block) - 1)]
        w0 = t[BEST_W + lane] + w_step * (f4(2) * _random(pixel, seed, 3 * turn) - f4(1))
        tilt = w0 / focal_px
        t[W0 + lane] = w0
        t[GX + lane] = t[BEST_X + lane] + tilt * tilt_step * (
            f4(2) * _random(pixel, seed, 3 * turn + 1) - f4(1)
        )
        t[GY + lane] = t[BEST_Y + lane] + tilt * tilt_step * (
            f4(2) * _random(pixel, seed, 3 * turn + 2) - f4(1)
        )


@njit(inline="always")
def _random(pixel, seed, k):
    """Uniform in [0, 1): an integer hash."""
    h = u4(pixel) * u4(747796405) + u4(seed) * u4(2891336453) + u4(k) * u4(277803737)
    h = u4(u4(h ^ (h >> u4(16))) * u4(0x7FEB352D))
    h = u4(u4(h ^ (h >> u4(15))) * u4(0x846CA68B))
    h = u4(h ^ (h >> u4(16)))
    return f4(h >> u4(8)) * f4(1.0 / 16777216.0)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _scratch():
    return np.zeros(SCRATCH, np.float32), np.zeros(LANES, np.int32), np.zeros(LANES, np.uint32)
