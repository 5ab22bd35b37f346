"""Crossings: pairs of triangles of one mesh that pass through each other, found by a tree of boxes.

Triangles that share an edge cannot cross unless they lie on each other; such folds show in the
angle between neighbours and are not looked for here. Touching is not crossing.
"""

import numpy as np
from jaxtyping import Bool, Int64
from numba import njit

from limbgram.geometry.arrays import Faces, Points3
from limbgram.surface.closest import TriangleTree

_LEAF = 4
"""Triangles in a leaf of the tree."""
_TOUCH = 1e-9
"""Depth below which triangles only touch, as a share of their size."""


def find_crossings(
    vertices_mm: Points3, faces: Faces, concerned: Bool[np.ndarray, " f"] | None = None
) -> Int64[np.ndarray, "k 2"]:
    """Pairs of faces that pass through each other, the lower number first, in rising order.

    Args:
        concerned: Only pairs with one of these faces; None asks for all pairs.
    """
    if not len(faces) or (concerned is not None and not concerned.any()):
        return np.empty((0, 2), np.int64)
    tree = TriangleTree.of(vertices_mm, faces)
    corners = np.ascontiguousarray(faces[tree.order])
    asked = np.ones(len(faces), np.bool_) if concerned is None else concerned[tree.order]
    room = np.empty((max(64, len(faces) // 8), 2), np.int64)
    count = _cross(tree.triangles, tree.boxes, corners, asked, room)
    if count > len(room):
        room = np.empty((count, 2), np.int64)
        _cross(tree.triangles, tree.boxes, corners, asked, room)
    pairs = np.sort(tree.order[room[:count]], axis=1)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


@njit(cache=True, nogil=True)
def _cross(triangles, boxes, corners, asked, found):
    """Fill in crossing pairs as far as there is room; returns how many there are."""
    leaves = boxes.shape[0] // 2
    stack = np.empty(64, np.int64)
    own = np.empty(6)
    count = 0
    for t in range(triangles.shape[0]):
        if not asked[t]:
            continue
        for axis in range(3):
            a, b, c = triangles[t, 0, axis], triangles[t, 1, axis], triangles[t, 2, axis]
            own[axis], own[axis + 3] = min(a, b, c), max(a, b, c)
        stack[0] = 1
        depth = 1
        while depth > 0:
            depth -= 1
            node = stack[depth]
            if _apart(own, boxes[node]):
                continue
            if node < leaves:
                stack[depth], stack[depth + 1] = 2 * node, 2 * node + 1
                depth += 2
                continue
            first = (node - leaves) * _LEAF
            for other in range(first, min(first + _LEAF, triangles.shape[0])):
                if asked[other] and other <= t:
                    continue
                if _pass_through(triangles[t], triangles[other], corners[t], corners[other]):
                    if count < found.shape[0]:
                        found[count, 0], found[count, 1] = t, other
                    count += 1
    return count


@njit(cache=True, nogil=True)
def _apart(one, two):
    gap = -np.inf
    for axis in range(3):
        gap = max(gap, one[axis] - two[axis + 3], two[axis] - one[axis + 3])
    return gap > 0


@njit(cache=True, nogil=True)
def _pass_through(one, two, corners_one, corners_two):
    """Whether an edge of either triangle pierces the other; edges at shared corners only touch."""
    shared = 0
    for i in range(3):
        for j in range(3):
            shared += corners_one[i] == corners_two[j]
    if shared >= 2:
        return False
    return _pierces(one, corners_one, two, corners_two) or _pierces(
        two, corners_two, one, corners_one
    )


@njit(cache=True, nogil=True)
def _pierces(edges, corners_edges, triangle, corners):
    a, b, c = triangle[0], triangle[1], triangle[2]
    for k in range(3):
        n = (k + 1) % 3
        touching = False
        for j in range(3):
            touching = touching or corners_edges[k] == corners[j] or corners_edges[n] == corners[j]
        if touching:
            continue
        p, q = edges[k], edges[n]
        size = 0.0
        for axis in range(3):
            low = min(a[axis], b[axis], c[axis], p[axis], q[axis])
            size = max(size, max(a[axis], b[axis], c[axis], p[axis], q[axis]) - low)
        least = _TOUCH * size * size * size
        over, under = _volume(a, b, c, p), _volume(a, b, c, q)
        if over * under >= 0 or min(abs(over), abs(under)) <= least:
            continue
        first, second, third = _volume(p, q, a, b), _volume(p, q, b, c), _volume(p, q, c, a)
        if min(first, second, third) > least or max(first, second, third) < -least:
            return True
    return False


@njit(cache=True, nogil=True)
def _volume(a, b, c, d):
    """Six times the signed volume of a tetrahedron."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    wx, wy, wz = d[0] - a[0], d[1] - a[1], d[2] - a[2]
    return ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx)
