"""Triangulating a hole's loop with its own vertices (Barequet and Sharir 1995; Liepa 2003)."""

import numpy as np
from jaxtyping import Bool, Int32
from numba import njit

from limbgram.geometry.arrays import Faces, Points3

_MOST_CORNERS = 250
"""Larger loops lose their sharpest corners first: the search costs the cube of the number."""


def triangulate(loop: Points3, taken: Bool[np.ndarray, "l l"]) -> Faces | None:
    """Triangles of small area and gentle folds that close a loop, as indices into it.

    The loop runs along the half-edges of the faces round the hole; the new faces run against it.
    `taken[i, j]` forbids a chord: the mesh already has that edge. None: no allowed answer.
    """
    ears, rest = _cut_ears(loop, taken, max(len(loop) - _MOST_CORNERS, 0))
    ring = np.ascontiguousarray(loop[rest])
    split = np.full((len(rest), len(rest)), -1, np.int32)
    if not _least_area(ring, np.ascontiguousarray(taken[np.ix_(rest, rest)]), split):
        return None
    faces = ears
    waiting = [(0, len(rest) - 1)]
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        middle = int(split[first, last])
        faces.append((rest[first], rest[last], rest[middle]))
        waiting += [(first, middle), (middle, last)]
    return np.array(faces, np.int32).reshape(-1, 3)


def _cut_ears(
    loop: Points3, taken: Bool[np.ndarray, "l l"], count: int
) -> tuple[list[tuple[int, int, int]], Int32[np.ndarray, " r"]]:
    """Cut `count` corners, smallest angle first, no two neighbours in one round."""
    rest = np.arange(len(loop), dtype=np.int32)
    ears: list[tuple[int, int, int]] = []
    while count > 0:
        before, after = np.roll(rest, 1), np.roll(rest, -1)
        u, v = loop[before] - loop[rest], loop[after] - loop[rest]
        cosine = (u * v).sum(1) / np.maximum(
            np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1), 1e-30
        )
        cosine[taken[before, after]] = -2
        sharper = (cosine > np.roll(cosine, 1)) & (cosine >= np.roll(cosine, -1)) & (cosine > -2)
        chosen = np.flatnonzero(sharper)
        chosen = chosen[np.argsort(-cosine[chosen], kind="stable")][: max(1, min(count, 40))]
        if not len(chosen):
            break
        for k in chosen:
            ears.append((int(rest[k]), int(before[k]), int(after[k])))
            taken[before[k], after[k]] = taken[after[k], before[k]] = True
        rest = np.delete(rest, chosen)
        count -= len(chosen)
    return ears, rest


@njit(cache=True, nogil=True)
def _least_area(ring, taken, split):
    """Fill split[i, j]: third corner of the triangle on chord i..j; False where none is allowed.

    Weight of a triangulation: its area, each triangle's raised by its thinness, so that of two
    answers of the same area the one of rounder triangles wins.
    """
    n = ring.shape[0]
    weight = np.zeros((n, n))
    for span in range(2, n):
        for i in range(n - span):
            j = i + span
            weight[i, j] = np.inf
            if taken[i, j] and not (i == 0 and j == n - 1):
                continue
            for m in range(i + 1, j):
                below = weight[i, m] + weight[m, j]
                if below >= weight[i, j]:
                    continue
                total = below + _cost(ring[i], ring[m], ring[j])
                if total < weight[i, j]:
                    weight[i, j] = total
                    split[i, j] = m
    return np.isfinite(weight[0, n - 1])


@njit(cache=True, nogil=True)
def _cost(a, b, c):
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    wx, wy, wz = c[0] - b[0], c[1] - b[1], c[2] - b[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    area = 0.5 * np.sqrt(nx * nx + ny * ny + nz * nz)
    edges2 = ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz + wx * wx + wy * wy + wz * wz
    return area + 1e-3 * edges2
