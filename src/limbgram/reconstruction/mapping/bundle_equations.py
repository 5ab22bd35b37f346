"""Normal equations of bundle adjustment, points eliminated by the Schur complement (compiled).

Unknowns: six numbers a photo (rotation and shift, see geometry.projection), then ten lens
parameters a camera, then three a point. Observations are sorted by point. With measurement
errors of one pixel and Cauchy weights, the kernels build the equations that remain for photos
and lenses after each point's own three were solved, and afterwards the points' steps.

One thread, one order of summation: the same input gives the same bytes.
"""

import numpy as np

from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE, project_and_differentiate
from limbgram.core.kernels import njit
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
    basis: np.ndarray,
    fields: np.ndarray,
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

    Damping scales that diagonal. `basis` (lenses, 10, q): change of the lens by each parameter of
    a photo's deviation; q is 0 where photos have none. `fields` (points, 3, f): displacement of
    the points by f further numbers of each photo (a deformation field).
    """
    longest, lenses = longest_track(bounds), basis.shape[0]
    more = basis.shape[2] + fields.shape[2]
    residual, by_point = np.empty((longest, 2)), np.empty((longest, 2, 3))
    by_all = np.empty((longest, 2, POSE_SIZE + LENS_SIZE))
    by_own = np.empty((longest, 2, more))
    own, own_right, inverse = np.empty((3, 3)), np.empty(3), np.empty((3, 3))
    most = (POSE_SIZE + more) * longest + LENS_SIZE * min(lenses, longest)
    touched, place = np.empty(most, np.int64), np.full(lenses, -1, np.int64)
    cross, parts = np.empty((3, most)), np.empty(most)
    normal[:], right[:], diagonal[:] = 0.0, 0.0, 0.0
    for k in range(len(points)):
        first, last = bounds[k], bounds[k + 1]
        _point_equations(
            views, photo_idx, first, last, xy_px, points[k], cauchy_px,
            residual, by_all, by_point, own, own_right,
        )  # fmt: skip
        for i in range(3):
            own[i, i] *= 1.0 + damping
        if not invert_symmetric(own, inverse):
            continue
        for row in range(first, last):
            n, lens = row - first, lens_idx[photo_idx[row]]
            _deviation_derivatives(by_all[n], basis[lens], by_point[n], fields[k], by_own[n])
        _add_observations(
            photo_idx[first:last], lens_idx, len(views), lenses, by_all, by_own, residual,
            normal, right, diagonal,
        )  # fmt: skip
        count = _cross_products(
            photo_idx[first:last], lens_idx, len(views), by_all, by_own, by_point, place,
            touched, cross,
        )  # fmt: skip
        _subtract_point(count, touched, cross, inverse, own_right, parts, normal, right)
    for a in range(len(normal)):
        for b in range(a):
            normal[a, b] = normal[b, a]


@njit(cache=True, nogil=True)
def longest_track(bounds: np.ndarray) -> int:
    """Length of the longest track."""
    longest = 0
    for k in range(len(bounds) - 1):
        longest = max(longest, bounds[k + 1] - bounds[k])
    return longest


@njit(cache=True, nogil=True)
def _deviation_derivatives(
    by_all: np.ndarray,
    basis: np.ndarray,
    by_point: np.ndarray,
    field: np.ndarray,
    by_own: np.ndarray,
) -> None:
    """Fill the derivatives by the lens deviation of a photo, and by its deformation field."""
    lens = basis.shape[1]
    by_own[:] = 0.0
    for axis in range(2):
        for j in range(lens):
            for i in range(LENS_SIZE):
                by_own[axis, j] += by_all[axis, POSE_SIZE + i] * basis[i, j]
        for j in range(field.shape[1]):
            for i in range(3):
                by_own[axis, lens + j] += by_point[axis, i] * field[i, j]


@njit(cache=True, nogil=True)
def _add_observations(
    photos: np.ndarray,
    lens_idx: np.ndarray,
    views: int,
    lenses: int,
    by_all: np.ndarray,
    by_own: np.ndarray,
    residual: np.ndarray,
    normal: np.ndarray,
    right: np.ndarray,
    diagonal: np.ndarray,
) -> None:
    """Add the observations of a point to the upper triangle of the normal matrix over photos and
    lenses."""
    more = by_own.shape[2]
    for n in range(len(photos)):
        pose = POSE_SIZE * photos[n]
        lens = POSE_SIZE * views + LENS_SIZE * lens_idx[photos[n]]
        own = POSE_SIZE * views + LENS_SIZE * lenses + more * photos[n]
        across, down, own_across, own_down = by_all[n, 0], by_all[n, 1], by_own[n, 0], by_own[n, 1]
        off_x, off_y = residual[n, 0], residual[n, 1]
        for i in range(POSE_SIZE + LENS_SIZE + more):
            if i < POSE_SIZE:
                a, p, q = pose + i, across[i], down[i]
                line = normal[a, pose : pose + POSE_SIZE]
                for j in range(POSE_SIZE):
                    line[j] = line[j] + p * across[j] + q * down[j]
            elif i < POSE_SIZE + LENS_SIZE:
                a, p, q = lens + i - POSE_SIZE, across[i], down[i]
            else:
                k = i - POSE_SIZE - LENS_SIZE
                a, p, q = own + k, own_across[k], own_down[k]
            if i < POSE_SIZE + LENS_SIZE:
                line = normal[a, lens : lens + LENS_SIZE]
                for j in range(LENS_SIZE):
                    line[j] = line[j] + p * across[POSE_SIZE + j] + q * down[POSE_SIZE + j]
            line = normal[a, own : own + more]
            for j in range(more):
                line[j] = line[j] + p * own_across[j] + q * own_down[j]
            right[a] = right[a] + p * off_x + q * off_y
            diagonal[a] = diagonal[a] + p * p + q * q


@njit(cache=True, nogil=True)
def _cross_products(
    photos: np.ndarray,
    lens_idx: np.ndarray,
    views: int,
    by_all: np.ndarray,
    by_own: np.ndarray,
    by_point: np.ndarray,
    place: np.ndarray,
    touched: np.ndarray,
    cross: np.ndarray,
) -> int:
    """Fill the cross block W of the touched unknowns with one point; returns their number.

    Poses, then the lenses of photos that see the point, then deviations of the photos.
    `place` (a lens) is -1 before and after.
    """
    count, more = len(photos), by_own.shape[2]
    own = POSE_SIZE * views + LENS_SIZE * len(place)
    lens_start = POSE_SIZE * count
    start = lens_start
    for n in range(count):
        lens = lens_idx[photos[n]]
        for i in range(POSE_SIZE):
            touched[POSE_SIZE * n + i] = POSE_SIZE * photos[n] + i
        if place[lens] < 0:
            place[lens] = start
            for i in range(LENS_SIZE):
                touched[start + i] = POSE_SIZE * views + LENS_SIZE * lens + i
                cross[0, start + i] = cross[1, start + i] = cross[2, start + i] = 0.0
            start += LENS_SIZE
    for n in range(count):
        lens = place[lens_idx[photos[n]]]
        for i in range(POSE_SIZE):
            for j in range(3):
                product = by_all[n, 0, i] * by_point[n, 0, j]
                cross[j, POSE_SIZE * n + i] = product + by_all[n, 1, i] * by_point[n, 1, j]
        for i in range(LENS_SIZE):
            for j in range(3):
                cross[j, lens + i] += by_all[n, 0, POSE_SIZE + i] * by_point[n, 0, j]
                cross[j, lens + i] += by_all[n, 1, POSE_SIZE + i] * by_point[n, 1, j]
        for i in range(more):
            touched[start + more * n + i] = own + more * photos[n] + i
            for j in range(3):
                product = by_own[n, 0, i] * by_point[n, 0, j]
                cross[j, start + more * n + i] = product + by_own[n, 1, i] * by_point[n, 1, j]
    for n in range(count):
        place[lens_idx[photos[n]]] = -1
    return start + more * count


@njit(cache=True, nogil=True)
def _subtract_point(
    count: int,
    touched: np.ndarray,
    cross: np.ndarray,
    inverse: np.ndarray,
    own_right: np.ndarray,
    parts: np.ndarray,
    normal: np.ndarray,
    right: np.ndarray,
) -> None:
    """Subtract W V^-1 W^T, the Schur complement's part of one point, in the upper triangle."""
    for a in range(count):
        s0, s1, s2 = cross[0, a], cross[1, a], cross[2, a]
        t0 = s0 * inverse[0, 0] + s1 * inverse[1, 0] + s2 * inverse[2, 0]
        t1 = s0 * inverse[0, 1] + s1 * inverse[1, 1] + s2 * inverse[2, 1]
        t2 = s0 * inverse[0, 2] + s1 * inverse[1, 2] + s2 * inverse[2, 2]
        row = touched[a]
        right[row] -= t0 * own_right[0] + t1 * own_right[1] + t2 * own_right[2]
        c0, c1, c2, part = cross[0, a:count], cross[1, a:count], cross[2, a:count], parts[a:count]
        for b in range(count - a):
            part[b] = t0 * c0[b] + t1 * c1[b] + t2 * c2[b]
        for b in range(a, count):
            column = touched[b]
            if row < column:
                normal[row, column] -= parts[b]
            elif column < row:  # a lens that a later photo was taken with
                normal[column, row] -= parts[b]
            else:  # a photo that shows the point twice meets itself twice
                normal[row, row] -= parts[b] if a == b else 2.0 * parts[b]


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
