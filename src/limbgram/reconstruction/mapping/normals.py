"""Normal equations of bundle adjustment with every point eliminated: the compiled part.

Unknowns: six numbers a photo (rotation and shift, see geometry.projection), then ten lens
parameters a camera, then three a point. Observations are sorted by point. With measurement
errors of one pixel and Cauchy weights, the kernels build the equations that remain for photos
and lenses after each point's own three were solved, and afterwards the points' steps.

One thread, one order of summation: the same input gives the same bytes.
"""

import numpy as np
from numba import njit

from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE, project_and_differentiate
from limbgram.core.solvers import invert_symmetric

BEHIND_COST = 1e12
"""Cost of an observation whose point is behind its camera."""


@njit(cache=True, nogil=True)
def robust_cost(
    views: np.ndarray,
    photo_idx: np.ndarray,
    bounds: np.ndarray,
    xy_px: np.ndarray,
    points: np.ndarray,
    cauchy_px: float,
) -> float:
    """Sum over observations of c^2 log(1 + r^2 / c^2), c being `cauchy_px`."""
    xy, by_point = np.empty(2), np.empty((2, 3))
    by_pose, by_lens = np.empty((2, POSE_SIZE)), np.empty((2, LENS_SIZE))
    square, cost = cauchy_px * cauchy_px, 0.0
    for k in range(len(points)):
        for row in range(bounds[k], bounds[k + 1]):
            view = views[photo_idx[row]]
            depth = project_and_differentiate(view, points[k], xy, by_point, by_pose, by_lens)
            if depth > 0.0:
                dx, dy = xy_px[row, 0] - xy[0], xy_px[row, 1] - xy[1]
                cost += square * np.log(1.0 + (dx * dx + dy * dy) / square)
            else:
                cost += BEHIND_COST
    return cost


@njit(cache=True, nogil=True)
def _point_equations(
    views: np.ndarray,
    photo_idx: np.ndarray,
    first: int,
    last: int,
    xy_px: np.ndarray,
    point: np.ndarray,
    cauchy_px: float,
    residual: np.ndarray,
    by_all: np.ndarray,
    by_point: np.ndarray,
    own: np.ndarray,
    right: np.ndarray,
) -> None:
    """Fill the weighted residuals and derivatives of one point's observations.

    `by_all` (rows, 2, 16): pose, then lens; `own` (3, 3) and `right` (3): the point's equations.
    """
    xy, by_pose, by_lens = np.empty(2), np.empty((2, POSE_SIZE)), np.empty((2, LENS_SIZE))
    own[:], right[:] = 0.0, 0.0
    for row in range(first, last):
        n = row - first
        view = views[photo_idx[row]]
        depth = project_and_differentiate(view, point, xy, by_point[n], by_pose, by_lens)
        if not depth > 0.0:
            residual[n], by_all[n], by_point[n] = 0.0, 0.0, 0.0
            continue
        dx, dy = xy_px[row, 0] - xy[0], xy_px[row, 1] - xy[1]
        root = np.sqrt(1.0 / (1.0 + (dx * dx + dy * dy) / (cauchy_px * cauchy_px)))
        residual[n, 0], residual[n, 1] = root * dx, root * dy
        for axis in range(2):
            for i in range(POSE_SIZE):
                by_all[n, axis, i] = root * by_pose[axis, i]
            for i in range(LENS_SIZE):
                by_all[n, axis, POSE_SIZE + i] = root * by_lens[axis, i]
            for i in range(3):
                by_point[n, axis, i] *= root
            for i in range(3):
                right[i] += by_point[n, axis, i] * residual[n, axis]
                for j in range(3):
                    own[i, j] += by_point[n, axis, i] * by_point[n, axis, j]


@njit(cache=True, nogil=True)
def reduce_equations(
    views: np.ndarray,
    lens_idx: np.ndarray,
    photo_idx: np.ndarray,
    bounds: np.ndarray,
    xy_px: np.ndarray,
    points: np.ndarray,
    cauchy_px: float,
    damping: float,
    normal: np.ndarray,
    right: np.ndarray,
    diagonal: np.ndarray,
) -> None:
    """Fill the reduced normal matrix, its right side, and the diagonal before the reduction.

    The diagonal, what photos and lenses have by themselves, is what damping scales.
    """
    longest = longest_track(bounds)
    residual, by_point = np.empty((longest, 2)), np.empty((longest, 2, 3))
    by_all = np.empty((longest, 2, POSE_SIZE + LENS_SIZE))
    own, own_right, inverse = np.empty((3, 3)), np.empty(3), np.empty((3, 3))
    lenses = normal.shape[0] - POSE_SIZE * len(views)
    columns = np.empty((longest, POSE_SIZE + LENS_SIZE), np.int64)
    most = min(lenses, LENS_SIZE * longest)
    touched = np.empty(POSE_SIZE * longest + most, np.int64)
    place = np.full(lenses // LENS_SIZE, -1, np.int64)
    cross, solved = np.empty((len(touched), 3)), np.empty((len(touched), 3))
    normal[:], right[:], diagonal[:] = 0.0, 0.0, 0.0
    for k in range(len(points)):
        first, last = bounds[k], bounds[k + 1]
        count = last - first
        _point_equations(
            views, photo_idx, first, last, xy_px, points[k], cauchy_px,
            residual, by_all, by_point, own, own_right,
        )  # fmt: skip
        for i in range(3):
            own[i, i] *= 1.0 + damping
        if not invert_symmetric(own, inverse):
            continue
        for n in range(count):
            photo = photo_idx[first + n]
            for i in range(POSE_SIZE):
                columns[n, i] = POSE_SIZE * photo + i
            for i in range(LENS_SIZE):
                columns[n, POSE_SIZE + i] = POSE_SIZE * len(views) + LENS_SIZE * lens_idx[photo] + i
        _add_observations(count, by_all, residual, columns, normal, right, diagonal)
        numbers = _cross_products(
            count, lenses, by_all, by_point, columns, normal.shape[0], place, touched, cross
        )
        _subtract_point(numbers, touched, cross, inverse, own_right, solved, normal, right)


@njit(cache=True, nogil=True)
def longest_track(bounds: np.ndarray) -> int:
    """Most observations that any point has."""
    longest = 0
    for k in range(len(bounds) - 1):
        longest = max(longest, bounds[k + 1] - bounds[k])
    return longest


@njit(cache=True, nogil=True)
def _add_observations(
    count: int,
    by_all: np.ndarray,
    residual: np.ndarray,
    columns: np.ndarray,
    normal: np.ndarray,
    right: np.ndarray,
    diagonal: np.ndarray,
) -> None:
    for n in range(count):
        for axis in range(2):
            for i in range(columns.shape[1]):
                slope, a = by_all[n, axis, i], columns[n, i]
                right[a] += slope * residual[n, axis]
                diagonal[a] += slope * slope
                for j in range(columns.shape[1]):
                    normal[a, columns[n, j]] += slope * by_all[n, axis, j]


@njit(cache=True, nogil=True)
def _cross_products(
    count: int,
    lenses: int,
    by_all: np.ndarray,
    by_point: np.ndarray,
    columns: np.ndarray,
    size: int,
    place: np.ndarray,
    touched: np.ndarray,
    cross: np.ndarray,
) -> int:
    """Fill the products of each touched unknown's derivatives with the point's; their number.

    Only lenses of photos that see the point are touched. `place` (a lens) is -1 before and after.
    """
    poses, used = POSE_SIZE * count, 0
    for n in range(count):
        for i in range(POSE_SIZE):
            a = POSE_SIZE * n + i
            touched[a], cross[a] = columns[n, i], 0.0
        lens = (columns[n, POSE_SIZE] - (size - lenses)) // LENS_SIZE
        if place[lens] < 0:
            place[lens] = poses + LENS_SIZE * used
            used += 1
            for i in range(LENS_SIZE):
                touched[place[lens] + i] = columns[n, POSE_SIZE + i]
                cross[place[lens] + i] = 0.0
        for i in range(columns.shape[1]):
            a = POSE_SIZE * n + i if i < POSE_SIZE else place[lens] + i - POSE_SIZE
            for j in range(3):
                cross[a, j] += by_all[n, 0, i] * by_point[n, 0, j]
                cross[a, j] += by_all[n, 1, i] * by_point[n, 1, j]
    for n in range(count):
        place[(columns[n, POSE_SIZE] - (size - lenses)) // LENS_SIZE] = -1
    return poses + LENS_SIZE * used


@njit(cache=True, nogil=True)
def _subtract_point(
    count: int,
    touched: np.ndarray,
    cross: np.ndarray,
    inverse: np.ndarray,
    own_right: np.ndarray,
    solved: np.ndarray,
    normal: np.ndarray,
    right: np.ndarray,
) -> None:
    """Take off W V^-1 W^T, what the point's own freedom explains."""
    for a in range(count):
        for j in range(3):
            solved[a, j] = (
                cross[a, 0] * inverse[0, j]
                + cross[a, 1] * inverse[1, j]
                + cross[a, 2] * inverse[2, j]
            )
    for a in range(count):
        s0, s1, s2 = solved[a, 0], solved[a, 1], solved[a, 2]
        right[touched[a]] -= s0 * own_right[0] + s1 * own_right[1] + s2 * own_right[2]
        row = normal[touched[a]]
        for b in range(count):
            row[touched[b]] -= s0 * cross[b, 0] + s1 * cross[b, 1] + s2 * cross[b, 2]


@njit(cache=True, nogil=True)
def point_steps(
    views: np.ndarray,
    lens_idx: np.ndarray,
    photo_idx: np.ndarray,
    bounds: np.ndarray,
    xy_px: np.ndarray,
    points: np.ndarray,
    cauchy_px: float,
    damping: float,
    camera_step: np.ndarray,
    steps: np.ndarray,
) -> None:
    """Fill the points' steps, given those of photos and lenses."""
    longest = longest_track(bounds)
    residual, by_point = np.empty((longest, 2)), np.empty((longest, 2, 3))
    by_all = np.empty((longest, 2, POSE_SIZE + LENS_SIZE))
    own, right, inverse = np.empty((3, 3)), np.empty(3), np.empty((3, 3))
    for k in range(len(points)):
        first, last = bounds[k], bounds[k + 1]
        _point_equations(
            views, photo_idx, first, last, xy_px, points[k], cauchy_px,
            residual, by_all, by_point, own, right,
        )  # fmt: skip
        for row in range(first, last):
            n, pose = row - first, POSE_SIZE * photo_idx[row]
            lens = POSE_SIZE * len(views) + LENS_SIZE * lens_idx[photo_idx[row]]
            for axis in range(2):
                moved = 0.0
                for i in range(POSE_SIZE):
                    moved += by_all[n, axis, i] * camera_step[pose + i]
                for i in range(LENS_SIZE):
                    moved += by_all[n, axis, POSE_SIZE + i] * camera_step[lens + i]
                for i in range(3):
                    right[i] -= by_point[n, axis, i] * moved
        for i in range(3):
            own[i, i] *= 1.0 + damping
        steps[k] = 0.0
        if invert_symmetric(own, inverse):
            for i in range(3):
                for j in range(3):
                    steps[k, i] += inverse[i, j] * right[j]
