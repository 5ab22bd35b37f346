"""Epipolar distances of matches, and triangulation of points from placed photos.

The Sampson distance: x2^T F x1 = 0 is a quadric through the space of matches (x1, y1, x2, y2). The
distance of a match to its tangent is the Sampson distance (Sampson 1982; Hartley and Zisserman,
section 11.4.3).

Triangulation: points from their images, with their covariance. The linear method (DLT) starts;
Gauss-Newton on the distances in pixels finishes, through the whole lens model. Points that cannot
be had (fewer than two rays, parallel rays, behind a camera) come out as NaN.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int32

from limbgram.core.geometry.arrays import Matrix3, Points2, Points3
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE, View, project_and_differentiate
from limbgram.core.kernels import njit
from limbgram.core.solvers import invert_symmetric

_STEPS = 8
"""Gauss-Newton steps."""
_NEWTON_STEPS = 3
"""Steps towards a match that fits the epipolar constraint."""


def sampson_px(
    fundamental: Matrix3, xy_first: Points2, xy_second: Points2
) -> Float64[np.ndarray, " n"]:
    """Signed Sampson distances; squared they approximate d(x, x^)^2 + d(x', x'^)^2."""
    error, gradient = _error_and_gradient(fundamental, xy_first, xy_second)
    return error / _gradient_norm(gradient)


def sampson_jacobian(
    fundamental: Matrix3, xy_first: Points2, xy_second: Points2
) -> Float64[np.ndarray, "n 9"]:
    """Derivatives of the signed Sampson distances with respect to F, row-major."""
    ones = np.ones((len(xy_first), 1))
    first, second = np.hstack([xy_first, ones]), np.hstack([xy_second, ones])
    line_in_second, line_in_first = first @ fundamental.T, second @ fundamental
    error = np.einsum("ni,ni->n", second, line_in_second)
    norm2 = (line_in_second[:, :2] ** 2).sum(1) + (line_in_first[:, :2] ** 2).sum(1)
    norm2 = np.maximum(norm2, np.finfo(float).tiny)
    half_norm2_by_matrix = np.zeros((len(first), 3, 3))
    half_norm2_by_matrix[:, :2] += line_in_second[:, :2, None] * first[:, None, :]
    half_norm2_by_matrix[:, :, :2] += second[:, :, None] * line_in_first[:, None, :2]
    numerator = second[:, :, None] * first[:, None, :]
    numerator -= half_norm2_by_matrix * (error / norm2)[:, None, None]
    return numerator.reshape(-1, 9) / np.sqrt(norm2)[:, None]


def nearest_matches(
    fundamental: Matrix3, xy_first: Points2, xy_second: Points2
) -> Float64[np.ndarray, "n 4"]:
    """Matches corrected onto the epipolar constraint: the maximum-likelihood x^ and x'^.

    Newton steps towards the foot of the perpendicular on the quadric: each step linearises at
    the last estimate but measures from the given match (Kanatani et al. 2008). Two steps reach
    Hartley and Sturm's global optimum to rounding for matches within a few pixels.
    """
    given = np.concatenate([xy_first, xy_second], axis=1)
    nearest = given
    for _ in range(_NEWTON_STEPS):
        error, gradient = _error_and_gradient(fundamental, nearest[:, :2], nearest[:, 2:])
        residual = error + np.einsum("ij,ij->i", gradient, given - nearest)
        nearest = given - gradient * (residual / _gradient_norm(gradient) ** 2)[:, None]
    return nearest


def _error_and_gradient(
    fundamental: Matrix3, xy_first: Points2, xy_second: Points2
) -> tuple[Float64[np.ndarray, " n"], Float64[np.ndarray, "n 4"]]:
    line_in_second = xy_first @ fundamental[:, :2].T + fundamental[:, 2]
    line_in_first = xy_second @ fundamental[:2] + fundamental[2]
    error = np.einsum("ij,ij->i", xy_second, line_in_second[:, :2]) + line_in_second[:, 2]
    return error, np.concatenate([line_in_first[:, :2], line_in_second[:, :2]], axis=1)


def _gradient_norm(gradient: Float64[np.ndarray, "n 4"]) -> Float64[np.ndarray, " n"]:
    """Kept above zero, which it is where both points are epipoles."""
    return np.maximum(np.linalg.norm(gradient, axis=1), np.sqrt(np.finfo(float).tiny))


@dataclass(frozen=True)
class Triangulated:
    """Triangulated points with their covariance; NaN where there is none."""

    points_in_world: Points3
    covariance: Float64[np.ndarray, "n 3 3"]
    """For measurements with a standard deviation of 1 px in x and in y, and exact cameras."""
    rms_px: Float64[np.ndarray, " n"]
    """Root mean square distance between measured and projected pixels."""


def triangulate(
    views: Sequence[View],
    view_idx: Int32[np.ndarray, " m"],
    point_idx: Int32[np.ndarray, " m"],
    xy_px: Float64[np.ndarray, "m 2"],
    count: int,
) -> Triangulated:
    """Each of `count` points from all its measurements: view view_idx[k] saw it at xy_px[k]."""
    start = triangulate_linear(views, view_idx, point_idx, xy_px, count)
    order = np.argsort(point_idx, kind="stable")
    bounds = np.searchsorted(point_idx[order], np.arange(count + 1))
    packed = np.array([view.packed for view in views])
    points, covariance, rms = start.copy(), np.full((count, 3, 3), np.nan), np.full(count, np.nan)
    _refine(packed, view_idx[order], bounds, xy_px[order], points, covariance, rms)
    return Triangulated(points, covariance, rms)


def triangulate_linear(
    views: Sequence[View],
    view_idx: Int32[np.ndarray, " m"],
    point_idx: Int32[np.ndarray, " m"],
    xy_px: Float64[np.ndarray, "m 2"],
    count: int,
) -> Points3:
    """The linear method (DLT): least squares of x (p3 X) - p1 X and y (p3 X) - p2 X."""
    centres = np.array([view.centre_in_world for view in views])
    centroid = centres.mean(0)
    size = float(np.abs(centres - centroid).max()) or 1.0
    normal = np.zeros((count, 16))
    for idx, view in enumerate(views):
        rows = np.flatnonzero(view_idx == idx)
        pose = view.camera_from_world
        shifted = (pose.rotation @ centroid + pose.translation) / size
        projection = np.column_stack([pose.rotation, shifted])
        ideal = view.camera.normalize(xy_px[rows])
        for axis in range(2):
            equation = ideal[:, axis, None] * projection[2] - projection[axis]
            products = (equation[:, :, None] * equation[:, None, :]).reshape(-1, 16)
            np.add.at(normal, point_idx[rows], products)
    homogeneous = np.linalg.eigh(normal.reshape(count, 4, 4))[1][:, :, 0]
    seen = np.bincount(point_idx, minlength=count) >= 2
    weight = np.where(seen & (np.abs(homogeneous[:, 3]) > 1e-12), homogeneous[:, 3], np.nan)
    return homogeneous[:, :3] / weight[:, None] * size + centroid


@njit(cache=True, nogil=True)
def _refine(
    views: np.ndarray,
    view_idx: np.ndarray,
    bounds: np.ndarray,
    xy_px: np.ndarray,
    points: np.ndarray,
    covariance: np.ndarray,
    rms: np.ndarray,
) -> None:
    """Gauss-Newton for each point; a step that ends behind a camera gives the point up."""
    xy, by_point = np.empty(2), np.empty((2, 3))
    by_pose, by_lens = np.empty((2, POSE_SIZE)), np.empty((2, LENS_SIZE))
    normal, gradient, inverse = np.empty((3, 3)), np.empty(3), np.empty((3, 3))
    for k in range(len(points)):
        for step in range(_STEPS + 1):
            normal[:], gradient[:], squares = 0.0, 0.0, 0.0
            for row in range(bounds[k], bounds[k + 1]):
                view = views[view_idx[row]]
                depth = project_and_differentiate(view, points[k], xy, by_point, by_pose, by_lens)
                if not depth > 0.0:
                    squares = np.nan
                    break
                for axis in range(2):
                    residual = xy_px[row, axis] - xy[axis]
                    squares += residual * residual
                    for i in range(3):
                        gradient[i] += by_point[axis, i] * residual
                        for j in range(3):
                            normal[i, j] += by_point[axis, i] * by_point[axis, j]
            if not (np.isfinite(squares) and invert_symmetric(normal, inverse)):
                points[k] = np.nan
                break
            if step == _STEPS:
                for i in range(3):  # a copy in one step would take 3 s to compile
                    for j in range(3):
                        covariance[k, i, j] = inverse[i, j]
                rms[k] = np.sqrt(squares / (bounds[k + 1] - bounds[k]))
                break
            for i in range(3):
                for j in range(3):
                    points[k, i] += inverse[i, j] * gradient[j]
