"""One projection with all its derivatives: the kernel of triangulation and adjustment.

A view is a row of `View.packed`: rotation (9), translation (3), lens (10). The derivative by the
pose is for x_camera = exp(w) (R x_world) + t + d, with w a small rotation vector in the camera's
frame and d a shift: six numbers (w, d).
"""

import numpy as np
from jaxtyping import Float64
from numba import njit

POSE_SIZE = 6
LENS_SIZE = 10


@njit(cache=True, nogil=True)
def project_and_differentiate(
    view: np.ndarray,
    point: np.ndarray,
    xy: np.ndarray,
    by_point: np.ndarray,
    by_pose: np.ndarray,
    by_lens: np.ndarray,
) -> float:
    """Fill pixel `xy` (2) and its derivatives by point (2, 3), pose (2, 6) and lens (2, 10).

    Returns the depth; where it is not positive nothing else is filled.
    """
    rx = view[0] * point[0] + view[1] * point[1] + view[2] * point[2]
    ry = view[3] * point[0] + view[4] * point[1] + view[5] * point[2]
    rz = view[6] * point[0] + view[7] * point[1] + view[8] * point[2]
    depth = rz + view[11]
    if not depth > 0.0:
        return depth
    x, y = (rx + view[9]) / depth, (ry + view[10]) / depth
    fx, fy, cx, cy, skew = view[12], view[13], view[14], view[15], view[16]
    k1, k2, p1, p2, k3 = view[17], view[18], view[19], view[20], view[21]

    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3))
    xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    xy[0] = fx * xd + skew * yd + cx
    xy[1] = fy * yd + cy

    xd_x = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
    xd_y = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
    yd_y = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
    u_x, u_y = fx * xd_x + skew * xd_y, fx * xd_y + skew * yd_y
    v_x, v_y = fy * xd_y, fy * yd_y

    for row in range(2):
        a = (u_x if row == 0 else v_x) / depth
        b = (u_y if row == 0 else v_y) / depth
        c = -(a * x + b * y)
        for k in range(3):
            by_point[row, k] = a * view[k] + b * view[3 + k] + c * view[6 + k]
        by_pose[row, 0] = c * ry - b * rz
        by_pose[row, 1] = a * rz - c * rx
        by_pose[row, 2] = b * rx - a * ry
        by_pose[row, 3] = a
        by_pose[row, 4] = b
        by_pose[row, 5] = c

    by_lens[0, 0], by_lens[1, 0] = xd, 0.0
    by_lens[0, 1], by_lens[1, 1] = 0.0, yd
    by_lens[0, 2], by_lens[1, 2] = 1.0, 0.0
    by_lens[0, 3], by_lens[1, 3] = 0.0, 1.0
    by_lens[0, 4], by_lens[1, 4] = yd, 0.0
    _by_distortion(by_lens, 5, x * r2, y * r2, fx, fy, skew)
    _by_distortion(by_lens, 6, x * r2 * r2, y * r2 * r2, fx, fy, skew)
    _by_distortion(by_lens, 7, 2.0 * x * y, r2 + 2.0 * y * y, fx, fy, skew)
    _by_distortion(by_lens, 8, r2 + 2.0 * x * x, 2.0 * x * y, fx, fy, skew)
    _by_distortion(by_lens, 9, x * r2 * r2 * r2, y * r2 * r2 * r2, fx, fy, skew)
    return depth


@njit(cache=True, nogil=True)
def differentiate_all(
    view: np.ndarray,
    points: np.ndarray,
    by_point: np.ndarray,
    by_pose: np.ndarray,
    by_lens: np.ndarray,
) -> None:
    """Fill the derivatives of every point's pixel: (n, 2, 3), (n, 2, 6) and (n, 2, 10)."""
    xy = np.empty(2)
    for k in range(len(points)):
        project_and_differentiate(view, points[k], xy, by_point[k], by_pose[k], by_lens[k])


@njit(cache=True, nogil=True, inline="always")
def _by_distortion(
    by_lens: np.ndarray, column: int, dx: float, dy: float, fx: float, fy: float, skew: float
) -> None:
    """Write how pixels move when distorted coordinates move by (dx, dy)."""
    by_lens[0, column] = fx * dx + skew * dy
    by_lens[1, column] = fy * dy


def turned(
    view: Float64[np.ndarray, "22"], step: Float64[np.ndarray, "6"]
) -> Float64[np.ndarray, "22"]:
    """The view after the pose step (w, d); the rotation stays orthogonal to rounding."""
    from_axis = np.zeros((3, 3))
    angle = float(np.linalg.norm(step[:3]))
    wx, wy, wz = step[:3] if angle == 0.0 else step[:3] / angle
    from_axis[:] = [[0.0, -wz, wy], [wz, 0.0, -wx], [-wy, wx, 0.0]]
    small = np.eye(3) + np.sin(angle) * from_axis
    small += (1.0 - np.cos(angle)) * (from_axis @ from_axis)
    moved = view.copy()
    moved[:9] = (small @ view[:9].reshape(3, 3)).ravel()
    moved[9:12] += step[3:]
    return moved
