"""PatchMatch: the best plane at each pixel, by propagation and random search (compiled).

In      a packed reference and its sources at one pyramid level, the places to solve: every pixel,
        or every second one of every second row.
Out     inverse depth, its two slopes, and the score (mean of the better half of the
        correlations, so that photos in which the spot is hidden do not count).
Method  Places of a chessboard's two colours in turn; each asks the better of two neighbours in
        four directions, then tries random changes (Barnes et al. 2009; Galliani et al. 2015).
        At the end a parabola through three correlations gives the sub-pixel place. Every place
        reads the other colour only, and random numbers are hashes of place and turn: the result
        does not depend on the order of work.
        Hypothesis: inverse depth w0 of the pixel and its change per pixel, gx and gy. With m =
        (gx, gy, .) the plane's homography into another photo is A + b m^T; within the window it is
        replaced by its derivative at the centre.
        Score: weighted normalised correlation; weights fall with distance and with grey difference
        from the centre pixel, so that a window does not look across a silhouette.
        Speed: each step is a short loop over LANES pixels, so that one processor instruction serves
        several of them. All scratch lies in one flat array at constant offsets (rows of LANES
        numbers), or the compiler cannot prove that the rows do not overlap and falls back to one
        pixel at a time. Pictures are packed: a 32-bit word holds a pixel and its right, lower and
        lower right neighbour, one load a sample.
"""

import math

import numpy as np

from limbgram.core.kernels import njit

f4, i4, u4 = np.float32, np.int32, np.uint32

Picture = tuple[np.ndarray, int, int, np.ndarray, np.ndarray]
"""Grey values, width, pixels from place to place, weights by grey difference and by distance."""
Sources = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, int]
"""Packed words, their table, homographies A and b, and how many correlations count."""

LANES = 128
SIDE = 6
SAMPLES = SIDE * SIDE
REACH_PX = 5
"""A window is 6 x 6 samples, two pixels apart: from -5 to +5."""
LEAST_VARIANCE = 2.0
"""Grey levels squared; a window of less variance shows nothing that can be compared."""
MOST_SOURCES = 6

PIXEL_X, PIXEL_Y, GREY, MEAN, VARIANCE = 0, LANES, 2 * LANES, 3 * LANES, 4 * LANES
W0, GX, GY, ALIVE = 5 * LANES, 6 * LANES, 7 * LANES, 8 * LANES
"""The hypothesis under test; ALIVE is 1 where its depth is allowed."""
CENTRE_X, CENTRE_Y, XX, XY, YX, YY, WHOLE = (k * LANES for k in range(9, 16))
"""Where the window falls in the other photo; WHOLE is 1 where all of it lies inside."""
SUM, SUM_SQUARE, SUM_PRODUCT, PART_X, PART_Y = (k * LANES for k in range(16, 21))
FIRST, SECOND, THIRD = 21 * LANES, 22 * LANES, 23 * LANES
"""The three best correlations of this hypothesis."""
BEST_SCORE, BEST_W, BEST_X, BEST_Y = (k * LANES for k in range(24, 28))
CORRELATION, WEIGHTED, BELOW, ABOVE = (k * LANES for k in range(28, 32))
TRUST = 32 * LANES
"""MOST_SOURCES rows: weight of each source in the last sub-pixel step."""
WEIGHT = (32 + MOST_SOURCES) * LANES
CONTRAST = WEIGHT + SAMPLES * LANES
"""SAMPLES rows each: weights (sum 1) and weight times grey minus mean of the reference."""
SCRATCH = CONTRAST + SAMPLES * LANES


def grey_weights(sigma_grey: float) -> np.ndarray:
    """Weight of a sample by its grey difference from the centre, 0 to 255."""
    return np.exp(-0.5 * (np.arange(256) / sigma_grey) ** 2).astype(np.float32)


def distance_weights(sigma_px: float) -> np.ndarray:
    """Weight of the SAMPLES samples by their distance from the centre."""
    offset = np.arange(SIDE) * 2.0 - REACH_PX
    squared = offset[:, None] ** 2 + offset**2
    return np.exp(-0.5 * squared / sigma_px**2).astype(np.float32).ravel()


def window_px2(by_distance: np.ndarray) -> float:
    """Mean squared reach of a window in one direction."""
    offset = np.tile(np.arange(SIDE) * 2.0 - REACH_PX, SIDE)
    return float((by_distance * offset**2).sum() / by_distance.sum())


def packed(grey: np.ndarray) -> np.ndarray:
    """Each pixel with its right, lower and lower right neighbour in one 32-bit word, flat."""
    edged = np.pad(grey, ((0, 1), (0, 1)), mode="edge").astype(np.uint32)
    words = edged[:-1, :-1] | edged[:-1, 1:] << 8 | edged[1:, :-1] << 16 | edged[1:, 1:] << 24
    return np.ascontiguousarray(words).ravel()


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def look_at(
    grey: np.ndarray,
    width: int,
    step: int,
    places: np.ndarray,
    count: int,
    by_grey: np.ndarray,
    by_distance: np.ndarray,
    t: np.ndarray,
    index: np.ndarray,
):
    """Windows round the first `count` of `places` in the reference; spare lanes repeat the last."""
    across = width // step
    for lane in range(LANES):
        place = places[min(lane, count - 1)]
        column, row = step * (place % across), step * (place // across)
        pixel = row * width + column
        index[lane] = pixel
        t[PIXEL_X + lane] = f4(column)
        t[PIXEL_Y + lane] = f4(row)
        t[GREY + lane] = f4(grey[pixel])
        t[MEAN + lane] = f4(0)
        t[SUM + lane] = f4(0)
        t[VARIANCE + lane] = f4(0)
    for k in range(SAMPLES):
        away = i4((2 * (k // SIDE) - REACH_PX) * width + 2 * (k % SIDE) - REACH_PX)
        near, weight, contrast = by_distance[k], WEIGHT + k * LANES, CONTRAST + k * LANES
        for lane in range(LANES):
            value = f4(grey[index[lane] + away])
            share = near * by_grey[i4(abs(value - t[GREY + lane]))]
            t[contrast + lane] = value
            t[weight + lane] = share
            t[SUM + lane] += share
            t[MEAN + lane] += share * value
    for lane in range(LANES):
        t[SUM + lane] = f4(1) / t[SUM + lane]
        t[MEAN + lane] *= t[SUM + lane]
    for k in range(SAMPLES):
        weight, contrast = WEIGHT + k * LANES, CONTRAST + k * LANES
        for lane in range(LANES):
            share = t[weight + lane] * t[SUM + lane]
            above = t[contrast + lane] - t[MEAN + lane]
            t[weight + lane] = share
            t[contrast + lane] = share * above
            t[VARIANCE + lane] += share * above * above


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def correlate(
    words: np.ndarray,
    width: int,
    height: int,
    a: np.ndarray,
    b: np.ndarray,
    t: np.ndarray,
    index: np.ndarray,
    word: np.ndarray,
):
    """Correlation of each lane's hypothesis with one other photo, into CORRELATION (-1: none)."""
    _place(width, height, a, b, t)
    _accumulate(words, width, t, index, word)
    for lane in range(LANES):
        mean = t[SUM + lane]
        variance = t[SUM_SQUARE + lane] - mean * mean
        own = t[VARIANCE + lane]
        value = t[SUM_PRODUCT + lane] / math.sqrt(max(variance, f4(1)) * max(own, f4(1)))
        textured = (variance >= f4(LEAST_VARIANCE)) & (own >= f4(LEAST_VARIANCE))
        t[CORRELATION + lane] = value if textured & (t[WHOLE + lane] > f4(0)) else f4(-1)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _place(width: int, height: int, a: np.ndarray, b: np.ndarray, t: np.ndarray):
    """Window centre in the other photo and the derivative of the homography there."""
    right, bottom = f4(width - 3), f4(height - 3)
    for lane in range(LANES):
        x, y, w0 = t[PIXEL_X + lane], t[PIXEL_Y + lane], t[W0 + lane]
        gx, gy = t[GX + lane], t[GY + lane]
        depth = a[6] * x + a[7] * y + a[8] + b[2] * w0
        per_depth = f4(1) / depth
        u = (a[0] * x + a[1] * y + a[2] + b[0] * w0) * per_depth
        v = (a[3] * x + a[4] * y + a[5] + b[1] * w0) * per_depth
        zx, zy = a[6] + b[2] * gx, a[7] + b[2] * gy
        xx = (a[0] + b[0] * gx - u * zx) * per_depth
        xy = (a[1] + b[0] * gy - u * zy) * per_depth
        yx = (a[3] + b[1] * gx - v * zx) * per_depth
        yy = (a[4] + b[1] * gy - v * zy) * per_depth
        reach_x, reach_y = f4(REACH_PX) * (abs(xx) + abs(xy)), f4(REACH_PX) * (abs(yx) + abs(yy))
        whole = (
            (depth > f4(1e-6))
            & (t[ALIVE + lane] > f4(0))
            & (u - reach_x > f4(1))
            & (v - reach_y > f4(1))
            & (u + reach_x < right)
            & (v + reach_y < bottom)
        )
        t[WHOLE + lane] = f4(1) if whole else f4(0)
        t[CENTRE_X + lane] = u if whole else f4(1)
        t[CENTRE_Y + lane] = v if whole else f4(1)
        t[XX + lane] = xx if whole else f4(0)
        t[XY + lane] = xy if whole else f4(0)
        t[YX + lane] = yx if whole else f4(0)
        t[YY + lane] = yy if whole else f4(0)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _accumulate(words: np.ndarray, width: int, t: np.ndarray, index: np.ndarray, word: np.ndarray):
    """Weighted sums of the other photo's window, grey counted from the reference's mean."""
    for lane in range(LANES):
        t[SUM + lane] = f4(0)
        t[SUM_SQUARE + lane] = f4(0)
        t[SUM_PRODUCT + lane] = f4(0)
    for k in range(SAMPLES):
        dx, dy = f4(2 * (k % SIDE) - REACH_PX), f4(2 * (k // SIDE) - REACH_PX)
        weight, contrast = WEIGHT + k * LANES, CONTRAST + k * LANES
        for lane in range(LANES):
            x = t[CENTRE_X + lane] + t[XX + lane] * dx + t[XY + lane] * dy
            y = t[CENTRE_Y + lane] + t[YX + lane] * dx + t[YY + lane] * dy
            column, row = i4(x), i4(y)
            t[PART_X + lane] = x - f4(column)
            t[PART_Y + lane] = y - f4(row)
            index[lane] = i4(row * width + column)
        for lane in range(LANES):
            word[lane] = words[u4(index[lane])]
        for lane in range(LANES):
            four, fx, fy = word[lane], t[PART_X + lane], t[PART_Y + lane]
            upper = f4(i4(four & u4(255)))
            lower = f4(i4((four >> u4(16)) & u4(255)))
            upper += fx * (f4(i4((four >> u4(8)) & u4(255))) - upper)
            lower += fx * (f4(i4(four >> u4(24))) - lower)
            value = upper + fy * (lower - upper) - t[MEAN + lane]
            share = t[weight + lane] * value
            t[SUM + lane] += share
            t[SUM_SQUARE + lane] += share * value
            t[SUM_PRODUCT + lane] += t[contrast + lane] * value


TURNS = 3
"""Random changes a place tries in one sweep: both, slopes only, depth only."""
_FAR = 5
"""The second neighbour in each direction is this many places away."""


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def start(places: np.ndarray, w_range: np.ndarray, focal_px: float, seed: int, state: np.ndarray):
    """Random depths within the range (uniform in inverse depth) and random slopes."""
    low, high = f4(w_range[0]), f4(w_range[1])
    for place in places:
        w0 = low + (high - low) * _random(place, seed, 0)
        tilt = w0 / f4(focal_px)
        state[0, place] = w0
        state[1, place] = (f4(2) * _random(place, seed, 1) - f4(1)) * tilt
        state[2, place] = (f4(2) * _random(place, seed, 2) - f4(1)) * tilt


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def rate(
    picture: Picture,
    sources: Sources,
    places: np.ndarray,
    w_range: np.ndarray,
    state: np.ndarray,
    score: np.ndarray,
):
    """Score the planes that the places have now."""
    grey, width, step, by_grey, by_distance = picture
    t, index, word = _scratch()
    for first in range(0, len(places), LANES):
        block = places[first : first + LANES]
        look_at(grey, width, step, block, len(block), by_grey, by_distance, t, index)
        for lane in range(LANES):
            place = block[min(lane, len(block) - 1)]
            t[W0 + lane] = state[0, place]
            t[GX + lane] = state[1, place]
            t[GY + lane] = state[2, place]
            t[BEST_SCORE + lane] = f4(-2)
        _try(sources, w_range, t, index, word)
        for lane in range(len(block)):
            score[block[lane]] = t[BEST_SCORE + lane]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def sweep(
    picture: Picture,
    sources: Sources,
    places: np.ndarray,
    w_range: np.ndarray,
    focal_px: float,
    w_step: float,
    tilt_step: float,
    seed: int,
    state: np.ndarray,
    score: np.ndarray,
):
    """Improve the planes of one colour's places.

    w_step     size of random changes of inverse depth
    tilt_step  size of random changes of the slopes (tangent of the surface's tilt)
    """
    grey, width, step, by_grey, by_distance = picture
    t, index, word = _scratch()
    for first in range(0, len(places), LANES):
        block = places[first : first + LANES]
        look_at(grey, width, step, block, len(block), by_grey, by_distance, t, index)
        for lane in range(LANES):
            place = block[min(lane, len(block) - 1)]
            t[BEST_SCORE + lane] = score[place]
            t[BEST_W + lane] = state[0, place]
            t[BEST_X + lane] = state[1, place]
            t[BEST_Y + lane] = state[2, place]
        for side in range(4):
            dx, dy = i4(1 - side) * i4(side % 2 == 0), i4(2 - side) * i4(side % 2 == 1)
            _ask_neighbour(block, width // step, step, dx, dy, state, score, t)
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
            place = block[lane]
            score[place] = t[BEST_SCORE + lane]
            state[0, place] = t[BEST_W + lane]
            state[1, place] = t[BEST_X + lane]
            state[2, place] = t[BEST_Y + lane]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def polish(
    picture: Picture,
    sources: Sources,
    places: np.ndarray,
    w_range: np.ndarray,
    w_step: float,
    least: float,
    state: np.ndarray,
    score: np.ndarray,
):
    """Move each depth to the top of the parabola through three correlations, w_step apart.

    All photos that correlate better than `least` take part, by how much they do. The score
    becomes their mean correlation; -1 where none does.
    """
    grey, width, step, by_grey, by_distance = picture
    words, table, a, b, _ = sources
    t, index, word = _scratch()
    for first in range(0, len(places), LANES):
        block = places[first : first + LANES]
        look_at(grey, width, step, block, len(block), by_grey, by_distance, t, index)
        for trial in range(3):
            away = f4(w_step) * f4(0 if trial == 0 else 2 * trial - 3)
            into = WEIGHTED if trial == 0 else BELOW if trial == 1 else ABOVE
            for lane in range(LANES):
                place = block[min(lane, len(block) - 1)]
                t[W0 + lane] = state[0, place] + away
                t[GX + lane] = state[1, place]
                t[GY + lane] = state[2, place]
                t[ALIVE + lane] = f4(1)
                t[into + lane] = f4(0)
            if trial == 0:
                for lane in range(LANES):
                    t[FIRST + lane] = f4(1e-6)
            for s in range(len(table)):
                correlate(
                    words[table[s, 0] :], table[s, 1], table[s, 2], a[s], b[s], t, index, word
                )
                trust = TRUST + s * LANES
                for lane in range(LANES):
                    value = t[CORRELATION + lane]
                    if trial == 0:
                        t[trust + lane] = max(value - f4(least), f4(0))
                        t[FIRST + lane] += t[trust + lane]
                    t[into + lane] += t[trust + lane] * value
        for lane in range(len(block)):
            place = block[lane]
            below, here, above = t[BELOW + lane], t[WEIGHTED + lane], t[ABOVE + lane]
            bend = f4(2) * here - below - above
            shift = f4(0.5) * (above - below) / max(bend, f4(1e-6))
            moved = state[0, place] + f4(w_step) * min(max(shift, f4(-1)), f4(1))
            state[0, place] = min(max(moved, f4(w_range[0])), f4(w_range[1]))
            score[place] = here / t[FIRST + lane] if t[FIRST + lane] > f4(2e-6) else f4(-1)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _try(sources: Sources, w_range: np.ndarray, t: np.ndarray, index: np.ndarray, word: np.ndarray):
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
def _ask_neighbour(
    block: np.ndarray,
    across: int,
    step: int,
    dx: int | np.int32,
    dy: int | np.int32,
    state: np.ndarray,
    score: np.ndarray,
    t: np.ndarray,
):
    """The plane of the better of a near and a far neighbour, continued to the place itself."""
    for lane in range(LANES):
        place = block[min(lane, len(block) - 1)]
        near = place + dy * across + dx
        far = place + i4(_FAR) * (dy * across + dx)
        further = score[far] > score[near]
        asked = far if further else near
        pixels = f4(_FAR * step) if further else f4(step)
        gx, gy = state[1, asked], state[2, asked]
        t[GX + lane] = gx
        t[GY + lane] = gy
        t[W0 + lane] = state[0, asked] - pixels * (gx * f4(dx) + gy * f4(dy))


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _change(
    block: np.ndarray,
    focal_px: float | np.float32,
    w_step: float | np.float32,
    tilt_step: float | np.float32,
    seed: int,
    turn: int,
    t: np.ndarray,
):
    """A random change of the best plane so far."""
    for lane in range(LANES):
        place = block[min(lane, len(block) - 1)]
        w0 = t[BEST_W + lane] + w_step * (f4(2) * _random(place, seed, 3 * turn) - f4(1))
        tilt = w0 / focal_px
        t[W0 + lane] = w0
        t[GX + lane] = t[BEST_X + lane] + tilt * tilt_step * (
            f4(2) * _random(place, seed, 3 * turn + 1) - f4(1)
        )
        t[GY + lane] = t[BEST_Y + lane] + tilt * tilt_step * (
            f4(2) * _random(place, seed, 3 * turn + 2) - f4(1)
        )


@njit(inline="always")
def _random(place: int, seed: int, k: int):
    """Uniform in [0, 1): an integer hash."""
    h = u4(place) * u4(747796405) + u4(seed) * u4(2891336453) + u4(k) * u4(277803737)
    h = u4(u4(h ^ (h >> u4(16))) * u4(0x7FEB352D))
    h = u4(u4(h ^ (h >> u4(15))) * u4(0x846CA68B))
    h = u4(h ^ (h >> u4(16)))
    return f4(h >> u4(8)) * f4(1.0 / 16777216.0)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _scratch():
    return np.zeros(SCRATCH, np.float32), np.zeros(LANES, np.int32), np.zeros(LANES, np.uint32)
