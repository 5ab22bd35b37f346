"""Crossings: pairs of triangles of one mesh that pass through each other, found by a tree of boxes.

Triangles that share an edge cannot cross unless they lie on each other; such folds show in the
angle between neighbours and are not looked for here. Touching is not crossing.
"""

import numpy as np
from jaxtyping import Bool, Int64
from numba import njit

from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.closest import TriangleTree
from limbgram.core.run import in_parallel, worker_count

_MANY, _PARTS = 20_000, 4
"""Triangles from which they are shared out among the processors, and shares of each: the first
triangles have more to look at than the last."""
_LEAF = 4
"""Triangles in a leaf of the tree."""
_TOUCH = 1e-9
"""Depth and length below which triangles only touch, as a share of their size."""


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
    done_after = _done_after(asked, len(tree.boxes) // 2)

    def cross(part: Int64[np.ndarray, " m"]) -> Int64[np.ndarray, "k 2"]:
        room = np.empty((max(64, len(part) // 8), 2), np.int64)
        count = _cross(tree.triangles, tree.boxes, corners, asked, done_after, part, room)
        if count > len(room):
            room = np.empty((count, 2), np.int64)
            _cross(tree.triangles, tree.boxes, corners, asked, done_after, part, room)
        return room[:count]

    turn = np.flatnonzero(asked)
    parts = _PARTS * worker_count() if len(turn) > _MANY else 1
    found = np.concatenate(in_parallel(cross, np.array_split(turn, parts)))
    pairs = np.sort(tree.order[found], axis=1)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def _done_after(asked: Bool[np.ndarray, " f"], leaves: int) -> Int64[np.ndarray, " k"]:
    """The triangle of the tree's order after which nothing under a node is looked at again.

    Each asked pair comes up at its lower triangle; one that was not asked is looked at always.
    """
    after = np.full(2 * leaves, -1)
    number = np.where(asked, np.arange(len(asked)), len(asked))
    starts = np.arange(0, len(asked), _LEAF)
    after[leaves : leaves + len(starts)] = np.maximum.reduceat(number, starts)
    while leaves > 1:
        below = after[leaves : 2 * leaves]
        leaves //= 2
        after[leaves : 2 * leaves] = np.maximum(below[::2], below[1::2])
    return after


@njit(cache=True, nogil=True)
def _cross(
    triangles: np.ndarray,
    boxes: np.ndarray,
    corners: np.ndarray,
    asked: np.ndarray,
    done_after: np.ndarray,
    turn: np.ndarray,
    found: np.ndarray,
):
    """Fill in crossing pairs of the triangles whose `turn` it is, as far as there is room; returns
    how many there are."""
    leaves = boxes.shape[0] // 2
    stack = np.empty(64, np.int64)
    own = np.empty(6)
    work = (np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3))
    count = 0
    for t in turn:
        for axis in range(3):
            a, b, c = triangles[t, 0, axis], triangles[t, 1, axis], triangles[t, 2, axis]
            own[axis], own[axis + 3] = min(a, b, c), max(a, b, c)
        stack[0] = 1
        depth = 1
        while depth > 0:
            depth -= 1
            node = stack[depth]
            if done_after[node] <= t or _apart(own, boxes[node]):
                continue
            if node < leaves:
                stack[depth], stack[depth + 1] = 2 * node, 2 * node + 1
                depth += 2
                continue
            first = (node - leaves) * _LEAF
            for other in range(first, min(first + _LEAF, triangles.shape[0])):
                if (asked[other] and other <= t) or _clear(own, triangles[other]):
                    continue
                if _pass_through(triangles, corners, t, other, work):
                    if count < found.shape[0]:
                        found[count, 0], found[count, 1] = t, other
                    count += 1
    return count


@njit(cache=True, nogil=True)
def _apart(one: np.ndarray, two: np.ndarray):
    gap = -np.inf
    for axis in range(3):
        gap = max(gap, one[axis] - two[axis + 3], two[axis] - one[axis + 3])
    return gap > 0


@njit(cache=True, nogil=True)
def _clear(box: np.ndarray, triangle: np.ndarray):
    """Whether a triangle lies beside a box."""
    for axis in range(3):
        a, b, c = triangle[0, axis], triangle[1, axis], triangle[2, axis]
        if min(a, b, c) > box[axis + 3] or max(a, b, c) < box[axis]:
            return True
    return False


@njit(cache=True, nogil=True)
def _pass_through(
    triangles: np.ndarray, corners: np.ndarray, one: int, two: int, work: tuple[np.ndarray, ...]
):
    """Whether two triangles share more than they touch in (Moeller 1997); `work` is written on.

    Each must have corners on both sides of the other's plane, and the pieces of the planes' common
    line that they cover must overlap. A shared corner counts as lying in both planes.
    """
    shared = 0
    for i in range(3):
        for j in range(3):
            shared += corners[one, i] == corners[two, j]
    if shared >= 2:
        return False
    size = 0.0
    for axis in range(3):
        low, high = np.inf, -np.inf
        for k in range(3):
            a, b = triangles[one, k, axis], triangles[two, k, axis]
            low, high = min(low, a, b), max(high, a, b)
        size = max(size, high - low)
    least = _TOUCH * size
    normal_one, normal_two, heights_one, heights_two, along = work
    _unit_normal(triangles, two, normal_two)
    if not _straddles(triangles, corners, one, two, normal_two, least, heights_one):
        return False
    _unit_normal(triangles, one, normal_one)
    if not _straddles(triangles, corners, two, one, normal_one, least, heights_two):
        return False
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        along[axis] = normal_one[i] * normal_two[j] - normal_one[j] * normal_two[i]
    length = np.sqrt(along[0] ** 2 + along[1] ** 2 + along[2] ** 2)
    if length == 0.0:
        return False
    for axis in range(3):
        along[axis] /= length
    low_one, high_one = _covered(triangles[one], triangles[one, 0], along, heights_one)
    low_two, high_two = _covered(triangles[two], triangles[one, 0], along, heights_two)
    return min(high_one, high_two) - max(low_one, low_two) > least


@njit(cache=True, nogil=True)
def _unit_normal(triangles: np.ndarray, t: int, normal: np.ndarray):
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        normal[axis] = (triangles[t, 1, i] - triangles[t, 0, i]) * (
            triangles[t, 2, j] - triangles[t, 0, j]
        ) - (triangles[t, 1, j] - triangles[t, 0, j]) * (triangles[t, 2, i] - triangles[t, 0, i])
    length = max(np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2), 1e-300)
    for axis in range(3):
        normal[axis] /= length


@njit(cache=True, nogil=True)
def _straddles(
    triangles: np.ndarray,
    corners: np.ndarray,
    t: int,
    other: int,
    normal: np.ndarray,
    least: float,
    heights: np.ndarray,
):
    """Fill in the heights of corners above the other's plane; whether they lie to both sides."""
    above = below = False
    for k in range(3):
        height = 0.0
        for axis in range(3):
            height += normal[axis] * (triangles[t, k, axis] - triangles[other, 0, axis])
        for j in range(3):
            if corners[t, k] == corners[other, j]:
                height = 0.0
        if abs(height) <= least:
            height = 0.0
        heights[k] = height
        above = above or height > 0
        below = below or height < 0
    return above and below


@njit(cache=True, nogil=True)
def _covered(triangle: np.ndarray, origin: np.ndarray, along: np.ndarray, heights: np.ndarray):
    """The piece of a line in the plane of height 0 that a triangle covers."""
    low, high = np.inf, -np.inf
    for k in range(3):
        n = (k + 1) % 3
        here = ahead = 0.0
        for axis in range(3):
            here += along[axis] * (triangle[k, axis] - origin[axis])
            ahead += along[axis] * (triangle[n, axis] - origin[axis])
        if heights[k] == 0.0:
            low, high = min(low, here), max(high, here)
        if heights[k] * heights[n] < 0:
            at = here + (ahead - here) * heights[k] / (heights[k] - heights[n])
            low, high = min(low, at), max(high, at)
    return low, high
