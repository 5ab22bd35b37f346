"""Geometry of a ball on points, compiled: where it rests, which way it rolls."""

import numpy as np
from numba import njit

from limbgram.surface.wrapping.grid import Grid


@njit(cache=True, nogil=True)
def find_centre(points: np.ndarray, a: int, b: int, c: int, radius: float, out: np.ndarray) -> bool:
    """Centre of the ball on three points, on the outside of (a, b, c); False if none fits."""
    p, q, r = points[a], points[b], points[c]
    ux, uy, uz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    vx, vy, vz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    uu, vv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz
    nn = nx * nx + ny * ny + nz * nz
    if nn < 1e-12 * uu * vv:
        return False
    # Circumcentre from p: n x (v^2 u - u^2 v) ... / 2 n^2, then up along the normal.
    wx, wy, wz = vv * ux - uu * vx, vv * uy - uu * vy, vv * uz - uu * vz
    cx = (ny * wz - nz * wy) / (2 * nn)
    cy = (nz * wx - nx * wz) / (2 * nn)
    cz = (nx * wy - ny * wx) / (2 * nn)
    height2 = radius * radius - (cx * cx + cy * cy + cz * cz)
    if height2 < 0:
        return False
    lift = np.sqrt(height2 / nn)
    out[0], out[1], out[2] = p[0] + cx + lift * nx, p[1] + cy + lift * ny, p[2] + cz + lift * nz
    return True


@njit(cache=True, nogil=True)
def faces_outwards(points: np.ndarray, normals: np.ndarray, a: int, b: int, c: int) -> bool:
    """Whether a face looks the way of the normals measured at all its corners."""
    p, q, r = points[a], points[b], points[c]
    ux, uy, uz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    vx, vy, vz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    m = normals
    return (
        nx * m[a, 0] + ny * m[a, 1] + nz * m[a, 2] > 0
        and nx * m[b, 0] + ny * m[b, 1] + nz * m[b, 2] > 0
        and nx * m[c, 0] + ny * m[c, 1] + nz * m[c, 2] > 0
    )


@njit(cache=True, nogil=True)
def roll_angle(
    start: np.ndarray, centre: np.ndarray, middle: np.ndarray, axis: np.ndarray
) -> float:
    """Angle from one ball centre to the next round the edge, 0 to 2 pi, rolling forwards."""
    x, y, z = centre[0] - middle[0], centre[1] - middle[1], centre[2] - middle[2]
    cosine = start[0] * x + start[1] * y + start[2] * z
    sine = (
        axis[0] * (start[1] * z - start[2] * y)
        + axis[1] * (start[2] * x - start[0] * z)
        + axis[2] * (start[0] * y - start[1] * x)
    )
    angle = np.arctan2(sine, cosine)
    # Points on one sphere differ by rounding: just behind means touched at once.
    return angle + 2 * np.pi if angle < -1e-7 else max(angle, 0.0)


@njit(cache=True, nogil=True)
def cell_along(grid: Grid, value: float, axis: int) -> int:
    """Number of the cell along one axis."""
    return int(np.floor((value - grid.low[axis]) / grid.cell))


@njit(cache=True, nogil=True)
def apart2(points: np.ndarray, k: int, place: np.ndarray) -> float:
    """Squared distance of point k from a place."""
    x, y, z = points[k, 0] - place[0], points[k, 1] - place[1], points[k, 2] - place[2]
    return x * x + y * y + z * z
