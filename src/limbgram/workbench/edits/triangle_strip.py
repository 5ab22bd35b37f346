"""Triangle strip: joins two parallel loops, such as the outlines of a wall's two skins."""

import numpy as np
from jaxtyping import Float64, Int64
from scipy.spatial import KDTree

from limbgram.core.geometry.arrays import Points3
from limbgram.core.kernels import njit


def strip(first_loop: Points3, second_loop: Float64[np.ndarray, "m 3"]) -> Int64[np.ndarray, "k 3"]:
    """Triangles between two loops of the same direction, with the least sum of squared widths.

    Numbered on from the first loop to the second (Fuchs, Kedem, Uselton 1977).
    """
    away, nearest = KDTree(second_loop).query(first_loop)
    first = int(np.argmin(away))
    one = np.roll(np.arange(len(first_loop)), -first)
    two = np.roll(np.arange(len(second_loop)), -int(np.asarray(nearest)[first]))
    one, two = np.append(one, one[0]), np.append(two, two[0])
    steps = _strip_steps(first_loop[one], second_loop[two])
    i = np.concatenate([[0], np.cumsum(steps == 0)])
    j = np.concatenate([[0], np.cumsum(steps == 1)])
    a, b, offset = one[i], two[j], len(first_loop)
    on_one = np.column_stack([a[1:], a[:-1], b[:-1] + offset])
    on_two = np.column_stack([b[:-1] + offset, b[1:] + offset, a[:-1]])
    return np.where((steps == 0)[:, None], on_one, on_two)


@njit(cache=True, nogil=True)
def _strip_steps(first_loop: np.ndarray, second_loop: np.ndarray):
    """Steps from the first pair of places to the last: 0 along the first loop, else 1."""
    n, m = len(first_loop), len(second_loop)
    cost = np.empty(m)
    came = np.empty((n, m), np.int8)
    for i in range(n):
        for j in range(m):
            least = 0.0
            came[i, j] = 0
            if i > 0:
                least = cost[j]
            if j > 0 and (i == 0 or cost[j - 1] < least):
                least = cost[j - 1]
                came[i, j] = 1
            across = 0.0
            for axis in range(3):
                across += (first_loop[i, axis] - second_loop[j, axis]) ** 2
            cost[j] = least + across
    steps = np.empty(n + m - 2, np.int8)
    i, j = n - 1, m - 1
    for k in range(n + m - 3, -1, -1):
        steps[k] = came[i, j]
        if came[i, j] == 0:
            i -= 1
        else:
            j -= 1
    return steps
