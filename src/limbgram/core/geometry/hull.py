"""Convex hull of points in a plane, by monotone chains (Andrew 1979), compiled.

Qhull, which knows any dimension, takes twenty times as long for the outline of a limb.
"""

import numpy as np
from jaxtyping import Int64
from scipy.spatial import ConvexHull

from limbgram.core.geometry.arrays import Points2
from limbgram.core.kernels import njit

_LEAST_AREA = 1e-9
"""Of the perimeter squared; a flatter hull is left to Qhull, which says what is wrong with it."""


def convex_hull(points_mm: Points2) -> Int64[np.ndarray, " k"]:
    """Indices of the points at the hull's corners, counter-clockwise.

    Raises:
        QhullError: the points lie on a line.
        ValueError: there are no points, or some are not finite.
    """
    if len(points_mm) > 2 and np.isfinite(points_mm).all():
        order = np.lexsort((points_mm[:, 1], points_mm[:, 0]))
        corners = _monotone_chains(np.ascontiguousarray(points_mm, np.float64), order)
        ring = points_mm[corners] - points_mm[corners[0]]
        after = np.roll(ring, -1, axis=0)
        area_mm2 = (ring[:, 0] * after[:, 1] - after[:, 0] * ring[:, 1]).sum() / 2
        if area_mm2 > _LEAST_AREA * np.linalg.norm(after - ring, axis=1).sum() ** 2:
            return corners
    return ConvexHull(points_mm).vertices.astype(np.int64)


@njit(cache=True, nogil=True)
def _monotone_chains(points: np.ndarray, order: np.ndarray):
    """The lower chain and then the upper one, from points sorted by x and then by y."""
    count = len(order)
    corners = np.empty(2 * count, np.int64)
    kept = 0
    for chain in range(2):
        least = kept + 1
        for k in range(count):
            at = order[k] if chain == 0 else order[count - 1 - k]
            x, y = points[at, 0], points[at, 1]
            while kept > least:
                a, b = corners[kept - 2], corners[kept - 1]
                along_x, along_y = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
                if along_x * (y - points[a, 1]) - along_y * (x - points[a, 0]) > 0:
                    break
                kept -= 1
            corners[kept] = at
            kept += 1
        kept -= 1  # the last point of a chain is the first one of the other
    return corners[:kept].copy()
