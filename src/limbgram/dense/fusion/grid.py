"""A grid over points, so that neighbours are found without looking at all of them (compiled).

Points are sorted by the cube they lie in; a hash table tells where each cube's points start.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Float64, Int64
from numba import njit

_MULTIPLIER = 0x9E3779B1
_AXIS_BITS = 21
"""Cubes along each axis are counted with this many bits."""


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Points in the order of their cubes."""

    order: Int64[np.ndarray, " n"]
    """Index of each sorted point in the original order."""
    low_mm: Float64[np.ndarray, "3"]
    cell_mm: float
    keys: Int64[np.ndarray, " slots"]
    """Hash table: key of a cube, -1 for an empty slot."""
    spans: Int64[np.ndarray, "slots 2"]
    """First sorted point of the cube and one past the last."""


def grid_of(points_mm: Float32[np.ndarray, "n 3"], cell_mm: float) -> Grid:
    """Sort points into cubes of `cell_mm`."""
    low = points_mm.min(0).astype(float) - cell_mm
    cells = np.floor((points_mm - low) / cell_mm).astype(np.int64)
    key_of = (cells[:, 0] << 2 * _AXIS_BITS) | (cells[:, 1] << _AXIS_BITS) | cells[:, 2]
    order = np.argsort(key_of, kind="stable")
    unique, first, count = np.unique(key_of[order], return_index=True, return_counts=True)
    slots = 1 << int(np.ceil(np.log2(2 * len(unique) + 1)))
    keys = np.full(slots, -1, np.int64)
    spans = np.zeros((slots, 2), np.int64)
    _fill(unique, first.astype(np.int64), count.astype(np.int64), keys, spans)
    return Grid(order=order, low_mm=low, cell_mm=cell_mm, keys=keys, spans=spans)


@njit(inline="always")
def span_of(keys, spans, i, j, k):
    """Sorted points of cube (i, j, k): first and one past the last."""
    key = (i << 2 * _AXIS_BITS) | (j << _AXIS_BITS) | k
    slot = _slot_of(key, len(keys))
    while keys[slot] != key and keys[slot] >= 0:
        slot = (slot + 1) & (len(keys) - 1)
    if keys[slot] < 0:
        return 0, 0
    return spans[slot, 0], spans[slot, 1]


@njit(inline="always")
def _slot_of(key, slots):
    mixed = (key ^ (key >> 29)) * _MULTIPLIER
    return (mixed ^ (mixed >> 17)) & (slots - 1)


@njit(cache=True, nogil=True)
def _fill(unique, first, count, keys, spans):
    for k in range(len(unique)):
        slot = _slot_of(unique[k], len(keys))
        while keys[slot] >= 0:
            slot = (slot + 1) & (len(keys) - 1)
        keys[slot] = unique[k]
        spans[slot, 0] = first[k]
        spans[slot, 1] = first[k] + count[k]


@njit(cache=True, nogil=True)
def thin(points, order, low, cell, keys, spans, spacing):
    """Poisson-disk thinning: of `points` (in the grid's order), visited in `order`, those that are
    kept lie at least `spacing` (at most one cell) apart, and no dropped one has room for itself."""
    blocked = np.zeros(len(points), np.bool_)
    kept = np.zeros(len(points), np.bool_)
    for p in order:
        if blocked[p]:
            continue
        kept[p] = True
        i = int((points[p, 0] - low[0]) / cell)
        j = int((points[p, 1] - low[1]) / cell)
        k = int((points[p, 2] - low[2]) / cell)
        for di in range(-1, 2):
            for dj in range(-1, 2):
                for dk in range(-1, 2):
                    first, last = span_of(keys, spans, i + di, j + dj, k + dk)
                    for q in range(first, last):
                        x = points[q, 0] - points[p, 0]
                        y = points[q, 1] - points[p, 1]
                        z = points[q, 2] - points[p, 2]
                        if x * x + y * y + z * z < spacing * spacing:
                            blocked[q] = True
    return kept
