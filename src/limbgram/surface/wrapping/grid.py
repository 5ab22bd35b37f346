"""A hashed grid of points: what lies near a place, for compiled loops.

Cells fold into a table of buckets, so far outliers cost nothing; a bucket may hold points of
several cells, so every reader checks distances.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

_X, _Y, _Z = 73856093, 19349663, 83492791


class Grid(NamedTuple):
    """Points of bucket b are order[starts[b]:starts[b + 1]]."""

    low: np.ndarray
    cell: float
    starts: np.ndarray
    order: np.ndarray


def build_grid(points: np.ndarray, cell: float) -> Grid:
    low = points.min(0)
    buckets = 1 << max(4, int(len(points) - 1).bit_length())
    i, j, k = np.floor((points - low) / cell).astype(np.int64).T
    keys = ((i * _X) ^ (j * _Y) ^ (k * _Z)) & (buckets - 1)
    order = np.argsort(keys, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(keys, minlength=buckets))])
    return Grid(low, cell, starts.astype(np.int64), order)


@njit(cache=True, nogil=True)
def bucket_of(grid: Grid, i: int, j: int, k: int) -> int:
    return ((i * _X) ^ (j * _Y) ^ (k * _Z)) & (grid.starts.shape[0] - 2)


def in_cell_order(points: np.ndarray, cell: float) -> np.ndarray:
    """Indices that put neighbours in space near each other in memory, however they came."""
    i, j, k = np.floor((points - points.min(0)) / cell).astype(np.int64).T
    return np.lexsort((*points.T, i, j, k))


@njit(cache=True, nogil=True)
def keep_apart(points: np.ndarray, grid: Grid, distance: float) -> np.ndarray:
    """Greedy choice of points, in order, none nearer to a chosen one than `distance`.

    The grid's cell must not be smaller than the distance.
    """
    kept = np.zeros(points.shape[0], np.bool_)
    for p in range(points.shape[0]):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        ci = int(np.floor((x - grid.low[0]) / grid.cell))
        cj = int(np.floor((y - grid.low[1]) / grid.cell))
        ck = int(np.floor((z - grid.low[2]) / grid.cell))
        free = True
        for cell in range(27):
            b = bucket_of(grid, ci + cell // 9 - 1, cj + cell // 3 % 3 - 1, ck + cell % 3 - 1)
            for s in range(grid.starts[b], grid.starts[b + 1]):
                q = grid.order[s]
                if kept[q]:
                    dx, dy, dz = points[q, 0] - x, points[q, 1] - y, points[q, 2] - z
                    if dx * dx + dy * dy + dz * dz < distance * distance:
                        free = False
                        break
            if not free:
                break
        kept[p] = free
    return kept
