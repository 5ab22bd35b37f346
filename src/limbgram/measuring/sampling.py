"""Compiled pieces that every measuring kernel uses: projection with its Jacobian, interpolation."""

import numpy as np
from numba import njit

f4 = np.float32

MARGIN_PX = 3.0
"""Samples stay this far inside a crop: the reach of the cubic B-spline and a little more."""


@njit(inline="always")
def project(view, x, y, z):
    """Pixel (u, v) of a world point through the exact lens, and d(u, v)/d(x, y, z) as 6 numbers.

    `view` is View.packed; formulas as in geometry.camera.Camera.
    """
    a = view[0] * x + view[1] * y + view[2] * z + view[9]
    b = view[3] * x + view[4] * y + view[5] * z + view[10]
    c = view[6] * x + view[7] * y + view[8] * z + view[11]
    per_depth = 1.0 / c
    p, q = a * per_depth, b * per_depth
    fx, fy, cx, cy, skew = view[12], view[13], view[14], view[15], view[16]
    k1, k2, p1, p2, k3 = view[17], view[18], view[19], view[20], view[21]
    r2 = p * p + q * q
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2 * (k1 + r2 * (2 * k2 + 3 * k3 * r2))
    pd = p * radial + 2 * p1 * p * q + p2 * (r2 + 2 * p * p)
    qd = q * radial + p1 * (r2 + 2 * q * q) + 2 * p2 * p * q
    pp = radial + p * p * slope + 2 * p1 * q + 6 * p2 * p
    pq = p * q * slope + 2 * p1 * p + 2 * p2 * q
    qq = radial + q * q * slope + 6 * p1 * q + 2 * p2 * p
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
def interpolate(coefficients, start, width, x, y):
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
