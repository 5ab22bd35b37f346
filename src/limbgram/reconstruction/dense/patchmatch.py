"""PatchMatch: the best plane at each pixel, by propagation and random search (compiled).

In      a reference and its packed sources at one pyramid level, and the places, the pixels whose
        plane is sought: every pixel, or every second one of every second row.
Out     inverse depth, its two slopes, and the score (mean of the better half of the
        correlations, so that sources in which the spot is hidden do not count).
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
from typing import NamedTuple

import numpy as np

from limbgram.core.kernels import njit

f4, i4, u4 = np.float32, np.int32, np.uint32

Reference = tuple[np.ndarray, int, int, np.ndarray, np.ndarray]
"""Of the reference: grey values, width, pixels from place to place, weights of samples by grey
difference and by distance."""
Sources = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, int]
"""Packed words, their table, homographies A and b, and how many of the best correlations count."""


class RandomSearch(NamedTuple):
    """Size of the random changes of one sweep, and their random numbers."""

    w_step: float
    """Of inverse depth."""
    tilt_step: float
    """Of the slopes, as the tangent of the surface's tilt."""
    seed: int


LANES = 128
SIDE = 6
SAMPLES = SIDE * SIDE
REACH_PX = 5
"""A window is 6 x 6 samples, two pixels apart: from -5 to +5."""
LEAST_VARIANCE = 2.0
"""Grey levels squared; a window of less variance shows nothing that can be compared."""
MOST_SOURCES = 6

PIXEL_X, PIXEL_Y, GREY, MEAN, VARIANCE = 0, LANES, 2 * LANES, 3 * LANES, 4 * LANES
W0, GX, GY, IN_RANGE = 5 * LANES, 6 * LANES, 7 * LANES, 8 * LANES
"""The hypothesis under test; IN_RANGE is 1 where its depth is allowed."""
SOURCE_X, SOURCE_Y, DU_DX, DU_DY, DV_DX, DV_DY, INSIDE = (k * LANES for k in range(9, 16))
"""Centre of the window in the source and the derivative of the homography there; INSIDE is 1 where
the whole window lies in the source."""
SUM, SUM_SQUARE, SUM_PRODUCT, FRACTION_X, FRACTION_Y = (k * LANES for k in range(16, 21))
FIRST, SECOND, THIRD = 21 * LANES, 22 * LANES, 23 * LANES
"""The three best correlations of this hypothesis."""
BEST_SCORE, BEST_W0, BEST_GX, BEST_GY = (k * LANES for k in range(24, 28))
CORRELATION, AT_DEPTH, BELOW, ABOVE = (k * LANES for k in range(28, 32))
SOURCE_WEIGHT = 32 * LANES
"""MOST_SOURCES rows: weight of each source in the sub-pixel refinement."""
WEIGHT = (32 + MOST_SOURCES) * LANES
CONTRAST = WEIGHT + SAMPLES * LANES
"""SAMPLES rows each: weights (sum 1) and weight times grey minus mean of the reference."""
SCRATCH = CONTRAST + SAMPLES * LANES


def grey_weights(sigma_grey: float) -> np.ndarray:
    """Weights of samples by their grey difference from the centre, 0 to 255."""
    return np.exp(-0.5 * (np.arange(256) / sigma_grey) ** 2).astype(np.float32)


def distance_weights(sigma_px: float) -> np.ndarray:
    """Weights of the SAMPLES samples by their distance from the centre."""
    offset = np.arange(SIDE) * 2.0 - REACH_PX
    squared = offset[:, None] ** 2 + offset**2
    return np.exp(-0.5 * squared / sigma_px**2).astype(np.float32).ravel()


def window_second_moment_px2(by_distance: np.ndarray) -> float:
    """Mean squared distance of a window's samples from its centre, in one direction."""
    offset = np.tile(np.arange(SIDE) * 2.0 - REACH_PX, SIDE)
    return float((by_distance * offset**2).sum() / by_distance.sum())


def pack_neighbourhoods(grey: np.ndarray) -> np.ndarray:
    """Each pixel with its right, lower and lower right neighbour in one 32-bit word, flat."""
    edged = np.pad(grey, ((0, 1), (0, 1)), mode="edge").astype(np.uint32)
    words = edged[:-1, :-1] | edged[:-1, 1:] << 8 | edged[1:, :-1] << 16 | edged[1:, 1:] << 24
    return np.ascontiguousarray(words).ravel()


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def load_windows(reference: Reference, places: np.ndarray, lanes: np.ndarray, index: np.ndarray):
    """Load the reference's windows round at most LANES places; spare lanes repeat the last."""
    grey, width, step, by_grey, by_distance = reference
    count = len(places)
    across = width // step
    for lane in range(LANES):
        place = places[min(lane, count - 1)]
        column, row = step * (place % across), step * (place // across)
        pixel = row * width + column
        index[lane] = pixel
        lanes[PIXEL_X + lane] = f4(column)
        lanes[PIXEL_Y + lane] = f4(row)
        lanes[GREY + lane] = f4(grey[pixel])
        lanes[MEAN + lane] = f4(0)
        lanes[SUM + lane] = f4(0)
        lanes[VARIANCE + lane] = f4(0)
    for k in range(SAMPLES):
        offset = i4((2 * (k // SIDE) - REACH_PX) * width + 2 * (k % SIDE) - REACH_PX)
        distance_weight, weight, contrast = by_distance[k], WEIGHT + k * LANES, CONTRAST + k * LANES
        for lane in range(LANES):
            value = f4(grey[index[lane] + offset])
            sample_weight = distance_weight * by_grey[i4(abs(value - lanes[GREY + lane]))]
            lanes[contrast + lane] = value
            lanes[weight + lane] = sample_weight
            lanes[SUM + lane] += sample_weight
            lanes[MEAN + lane] += sample_weight * value
    for lane in range(LANES):
        lanes[SUM + lane] = f4(1) / lanes[SUM + lane]
        lanes[MEAN + lane] *= lanes[SUM + lane]
    for k in range(SAMPLES):
        weight, contrast = WEIGHT + k * LANES, CONTRAST + k * LANES
        for lane in range(LANES):
            sample_weight = lanes[weight + lane] * lanes[SUM + lane]
            deviation = lanes[contrast + lane] - lanes[MEAN + lane]
            lanes[weight + lane] = sample_weight
            lanes[contrast + lane] = sample_weight * deviation
            lanes[VARIANCE + lane] += sample_weight * deviation * deviation


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def correlate(
    words: np.ndarray,
    width: int,
    height: int,
    a: np.ndarray,
    b: np.ndarray,
    lanes: np.ndarray,
    index: np.ndarray,
    word: np.ndarray,
):
    """Normalised cross-correlation of each lane's window with one source, into CORRELATION.

    -1 where the window leaves the source or either window lacks texture.
    """
    _project_windows(width, height, a, b, lanes)
    _accumulate_sums(words, width, lanes, index, word)
    for lane in range(LANES):
        mean = lanes[SUM + lane]
        variance = lanes[SUM_SQUARE + lane] - mean * mean
        reference_variance = lanes[VARIANCE + lane]
        value = lanes[SUM_PRODUCT + lane] / math.sqrt(
            max(variance, f4(1)) * max(reference_variance, f4(1))
        )
        textured = (variance >= f4(LEAST_VARIANCE)) & (reference_variance >= f4(LEAST_VARIANCE))
        lanes[CORRELATION + lane] = value if textured & (lanes[INSIDE + lane] > f4(0)) else f4(-1)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _project_windows(width: int, height: int, a: np.ndarray, b: np.ndarray, lanes: np.ndarray):
    """Project each lane's window centre into a source, with the homography's derivative there."""
    right, bottom = f4(width - 3), f4(height - 3)
    for lane in range(LANES):
        x, y, w0 = lanes[PIXEL_X + lane], lanes[PIXEL_Y + lane], lanes[W0 + lane]
        gx, gy = lanes[GX + lane], lanes[GY + lane]
        depth = a[6] * x + a[7] * y + a[8] + b[2] * w0
        per_depth = f4(1) / depth
        u = (a[0] * x + a[1] * y + a[2] + b[0] * w0) * per_depth
        v = (a[3] * x + a[4] * y + a[5] + b[1] * w0) * per_depth
        dz_dx, dz_dy = a[6] + b[2] * gx, a[7] + b[2] * gy
        du_dx = (a[0] + b[0] * gx - u * dz_dx) * per_depth
        du_dy = (a[1] + b[0] * gy - u * dz_dy) * per_depth
        dv_dx = (a[3] + b[1] * gx - v * dz_dx) * per_depth
        dv_dy = (a[4] + b[1] * gy - v * dz_dy) * per_depth
        reach_x, reach_y = (
            f4(REACH_PX) * (abs(du_dx) + abs(du_dy)),
            f4(REACH_PX) * (abs(dv_dx) + abs(dv_dy)),
        )
        inside = (
            (depth > f4(1e-6))
            & (lanes[IN_RANGE + lane] > f4(0))
            & (u - reach_x > f4(1))
            & (v - reach_y > f4(1))
            & (u + reach_x < right)
            & (v + reach_y < bottom)
        )
        lanes[INSIDE + lane] = f4(1) if inside else f4(0)
        lanes[SOURCE_X + lane] = u if inside else f4(1)
        lanes[SOURCE_Y + lane] = v if inside else f4(1)
        lanes[DU_DX + lane] = du_dx if inside else f4(0)
        lanes[DU_DY + lane] = du_dy if inside else f4(0)
        lanes[DV_DX + lane] = dv_dx if inside else f4(0)
        lanes[DV_DY + lane] = dv_dy if inside else f4(0)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _accumulate_sums(
    words: np.ndarray, width: int, lanes: np.ndarray, index: np.ndarray, word: np.ndarray
):
    """Sum up the source's samples by weight, grey counted from the reference's mean."""
    for lane in range(LANES):
        lanes[SUM + lane] = f4(0)
        lanes[SUM_SQUARE + lane] = f4(0)
        lanes[SUM_PRODUCT + lane] = f4(0)
    for k in range(SAMPLES):
        dx, dy = f4(2 * (k % SIDE) - REACH_PX), f4(2 * (k // SIDE) - REACH_PX)
        weight, contrast = WEIGHT + k * LANES, CONTRAST + k * LANES
        for lane in range(LANES):
            x = lanes[SOURCE_X + lane] + lanes[DU_DX + lane] * dx + lanes[DU_DY + lane] * dy
            y = lanes[SOURCE_Y + lane] + lanes[DV_DX + lane] * dx + lanes[DV_DY + lane] * dy
            column, row = i4(x), i4(y)
            lanes[FRACTION_X + lane] = x - f4(column)
            lanes[FRACTION_Y + lane] = y - f4(row)
            index[lane] = i4(row * width + column)
        for lane in range(LANES):
            word[lane] = words[u4(index[lane])]
        for lane in range(LANES):
            four, fx, fy = word[lane], lanes[FRACTION_X + lane], lanes[FRACTION_Y + lane]
            upper = f4(i4(four & u4(255)))
            lower = f4(i4((four >> u4(16)) & u4(255)))
            upper += fx * (f4(i4((four >> u4(8)) & u4(255))) - upper)
            lower += fx * (f4(i4(four >> u4(24))) - lower)
            value = upper + fy * (lower - upper) - lanes[MEAN + lane]
            weighted = lanes[weight + lane] * value
            lanes[SUM + lane] += weighted
            lanes[SUM_SQUARE + lane] += weighted * value
            lanes[SUM_PRODUCT + lane] += lanes[contrast + lane] * value


PERTURBATIONS = 3
"""Random changes of a plane in one sweep: depth and slopes, slopes only, depth only."""
_FAR_PLACES = 5
"""The second neighbour in each direction is this many places away."""


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def initialise_planes(
    places: np.ndarray, w_range: np.ndarray, focal_px: float, seed: int, planes: np.ndarray
):
    """Set random planes: depths within the range, uniform in inverse depth, and random slopes."""
    low, high = f4(w_range[0]), f4(w_range[1])
    for place in places:
        w0 = low + (high - low) * _random(place, seed, 0)
        tilt = w0 / f4(focal_px)
        planes[0, place] = w0
        planes[1, place] = (f4(2) * _random(place, seed, 1) - f4(1)) * tilt
        planes[2, place] = (f4(2) * _random(place, seed, 2) - f4(1)) * tilt


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def score_planes(
    reference: Reference,
    sources: Sources,
    places: np.ndarray,
    w_range: np.ndarray,
    planes: np.ndarray,
    score: np.ndarray,
):
    """Score the planes that the places have."""
    lanes, index, word = _new_scratch()
    for first in range(0, len(places), LANES):
        block = places[first : first + LANES]
        load_windows(reference, block, lanes, index)
        for lane in range(LANES):
            place = block[min(lane, len(block) - 1)]
            lanes[W0 + lane] = planes[0, place]
            lanes[GX + lane] = planes[1, place]
            lanes[GY + lane] = planes[2, place]
            lanes[BEST_SCORE + lane] = f4(-2)
        _test_hypothesis(sources, w_range, lanes, index, word)
        for lane in range(len(block)):
            score[block[lane]] = lanes[BEST_SCORE + lane]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def sweep(
    reference: Reference,
    sources: Sources,
    places: np.ndarray,
    w_range: np.ndarray,
    focal_px: float,
    search: RandomSearch,
    planes: np.ndarray,
    score: np.ndarray,
):
    """Improve the planes of one colour's places by propagation and random search."""
    _, width, step, _, _ = reference
    lanes, index, word = _new_scratch()
    for first in range(0, len(places), LANES):
        block = places[first : first + LANES]
        load_windows(reference, block, lanes, index)
        for lane in range(LANES):
            place = block[min(lane, len(block) - 1)]
            lanes[BEST_SCORE + lane] = score[place]
            lanes[BEST_W0 + lane] = planes[0, place]
            lanes[BEST_GX + lane] = planes[1, place]
            lanes[BEST_GY + lane] = planes[2, place]
        for direction in range(4):
            dx = i4(1 - direction) * i4(direction % 2 == 0)
            dy = i4(2 - direction) * i4(direction % 2 == 1)
            _propagate(block, width // step, step, dx, dy, planes, score, lanes)
            _test_hypothesis(sources, w_range, lanes, index, word)
        for trial in range(PERTURBATIONS):
            _perturb(block, f4(focal_px), search, trial, lanes)
            _test_hypothesis(sources, w_range, lanes, index, word)
        for lane in range(len(block)):
            place = block[lane]
            score[place] = lanes[BEST_SCORE + lane]
            planes[0, place] = lanes[BEST_W0 + lane]
            planes[1, place] = lanes[BEST_GX + lane]
            planes[2, place] = lanes[BEST_GY + lane]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def refine_subpixel(
    reference: Reference,
    sources: Sources,
    places: np.ndarray,
    w_range: np.ndarray,
    w_step: float,
    least_correlation: float,
    planes: np.ndarray,
    score: np.ndarray,
):
    """Move each depth to the vertex of the parabola through three correlations, w_step apart.

    Sources that correlate better than `least_correlation` take part, weighted by the excess. The
    score becomes their weighted mean correlation; -1 where none takes part.
    """
    words, table, a, b, _ = sources
    lanes, index, word = _new_scratch()
    for first in range(0, len(places), LANES):
        block = places[first : first + LANES]
        load_windows(reference, block, lanes, index)
        for trial in range(3):
            offset = f4(w_step) * f4(0 if trial == 0 else 2 * trial - 3)
            row = AT_DEPTH if trial == 0 else BELOW if trial == 1 else ABOVE
            for lane in range(LANES):
                place = block[min(lane, len(block) - 1)]
                lanes[W0 + lane] = planes[0, place] + offset
                lanes[GX + lane] = planes[1, place]
                lanes[GY + lane] = planes[2, place]
                lanes[IN_RANGE + lane] = f4(1)
                lanes[row + lane] = f4(0)
            # FIRST is free here, and takes the sum of the sources' weights.
            if trial == 0:
                for lane in range(LANES):
                    lanes[FIRST + lane] = f4(1e-6)
            for s in range(len(table)):
                correlate(
                    words[table[s, 0] :], table[s, 1], table[s, 2], a[s], b[s], lanes, index, word
                )
                source_weight = SOURCE_WEIGHT + s * LANES
                for lane in range(LANES):
                    value = lanes[CORRELATION + lane]
                    if trial == 0:
                        lanes[source_weight + lane] = max(value - f4(least_correlation), f4(0))
                        lanes[FIRST + lane] += lanes[source_weight + lane]
                    lanes[row + lane] += lanes[source_weight + lane] * value
        for lane in range(len(block)):
            place = block[lane]
            below, middle, above = lanes[BELOW + lane], lanes[AT_DEPTH + lane], lanes[ABOVE + lane]
            curvature = f4(2) * middle - below - above
            shift = f4(0.5) * (above - below) / max(curvature, f4(1e-6))
            moved = planes[0, place] + f4(w_step) * min(max(shift, f4(-1)), f4(1))
            planes[0, place] = min(max(moved, f4(w_range[0])), f4(w_range[1]))
            score[place] = (
                middle / lanes[FIRST + lane] if lanes[FIRST + lane] > f4(2e-6) else f4(-1)
            )


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _test_hypothesis(
    sources: Sources, w_range: np.ndarray, lanes: np.ndarray, index: np.ndarray, word: np.ndarray
):
    """Score the hypothesis in W0, GX, GY and keep it where it is the best so far."""
    words, table, a, b, counted = sources
    for lane in range(LANES):
        allowed = (lanes[W0 + lane] >= f4(w_range[0])) & (lanes[W0 + lane] <= f4(w_range[1]))
        lanes[IN_RANGE + lane] = f4(1) if allowed else f4(0)
        lanes[FIRST + lane] = f4(-1)
        lanes[SECOND + lane] = f4(-1)
        lanes[THIRD + lane] = f4(-1)
    for s in range(len(table)):
        correlate(words[table[s, 0] :], table[s, 1], table[s, 2], a[s], b[s], lanes, index, word)
        for lane in range(LANES):
            value = lanes[CORRELATION + lane]
            first, second, third = lanes[FIRST + lane], lanes[SECOND + lane], lanes[THIRD + lane]
            rest = min(first, value)
            lanes[FIRST + lane] = max(first, value)
            lanes[SECOND + lane] = max(second, rest)
            lanes[THIRD + lane] = max(third, min(second, rest))
    second_counts, third_counts = f4(counted > 1), f4(counted > 2)
    share = f4(1) / f4(counted)
    for lane in range(LANES):
        mean = share * (
            lanes[FIRST + lane]
            + second_counts * lanes[SECOND + lane]
            + third_counts * lanes[THIRD + lane]
        )
        better = (mean > lanes[BEST_SCORE + lane]) & (lanes[IN_RANGE + lane] > f4(0))
        lanes[BEST_SCORE + lane] = mean if better else lanes[BEST_SCORE + lane]
        lanes[BEST_W0 + lane] = lanes[W0 + lane] if better else lanes[BEST_W0 + lane]
        lanes[BEST_GX + lane] = lanes[GX + lane] if better else lanes[BEST_GX + lane]
        lanes[BEST_GY + lane] = lanes[GY + lane] if better else lanes[BEST_GY + lane]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _propagate(
    block: np.ndarray,
    across: int,
    step: int,
    dx: int | np.int32,
    dy: int | np.int32,
    planes: np.ndarray,
    score: np.ndarray,
    lanes: np.ndarray,
):
    """Take the plane of the better of a near and a far neighbour, continued to the place itself."""
    for lane in range(LANES):
        place = block[min(lane, len(block) - 1)]
        near = place + dy * across + dx
        far = place + i4(_FAR_PLACES) * (dy * across + dx)
        far_is_better = score[far] > score[near]
        neighbour = far if far_is_better else near
        distance_px = f4(_FAR_PLACES * step) if far_is_better else f4(step)
        gx, gy = planes[1, neighbour], planes[2, neighbour]
        lanes[GX + lane] = gx
        lanes[GY + lane] = gy
        lanes[W0 + lane] = planes[0, neighbour] - distance_px * (gx * f4(dx) + gy * f4(dy))


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _perturb(
    block: np.ndarray,
    focal_px: float | np.float32,
    search: RandomSearch,
    trial: int,
    lanes: np.ndarray,
):
    """Change the best plane so far at random."""
    w_step, tilt_step = f4(search.w_step) * f4(trial != 1), f4(search.tilt_step) * f4(trial != 2)
    seed = search.seed
    for lane in range(LANES):
        place = block[min(lane, len(block) - 1)]
        w0 = lanes[BEST_W0 + lane] + w_step * (f4(2) * _random(place, seed, 3 * trial) - f4(1))
        tilt = w0 / focal_px
        lanes[W0 + lane] = w0
        lanes[GX + lane] = lanes[BEST_GX + lane] + tilt * tilt_step * (
            f4(2) * _random(place, seed, 3 * trial + 1) - f4(1)
        )
        lanes[GY + lane] = lanes[BEST_GY + lane] + tilt * tilt_step * (
            f4(2) * _random(place, seed, 3 * trial + 2) - f4(1)
        )


@njit(inline="always")
def _random(place: int, seed: int, draw: int):
    """Return a number uniform in [0, 1), by an integer hash."""
    h = u4(place) * u4(747796405) + u4(seed) * u4(2891336453) + u4(draw) * u4(277803737)
    h = u4(u4(h ^ (h >> u4(16))) * u4(0x7FEB352D))
    h = u4(u4(h ^ (h >> u4(15))) * u4(0x846CA68B))
    h = u4(h ^ (h >> u4(16)))
    return f4(h >> u4(8)) * f4(1.0 / 16777216.0)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _new_scratch():
    return np.zeros(SCRATCH, np.float32), np.zeros(LANES, np.int32), np.zeros(LANES, np.uint32)
