"""Crossings: pairs of triangles of one mesh that pass through each other, found by a tree of boxes.

Triangles that share an edge cannot cross unless they lie on each other; such folds show in the
angle between neighbours and are not looked for here. Touching is not crossing.
"""

import numpy as np
from jaxtyping import Bool, Int64

from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.kernels import njit
from limbgram.core.mesh.closest_point import LEAF, TriangleTree
from limbgram.core.run import in_parallel, worker_count

_MANY, _PARTS = 20_000, 4
"""Triangles from which they are shared out among the processors, and shares of each: some parts of
a surface have more near them than others."""
_SHARED_OUT = 64
"""Nodes of one level of the tree that are shared out, each with those after it."""
_TOUCH = 1e-9
"""Depth and length below which triangles only touch, as a share of their size."""


def find_crossings(
    vertices_mm: Points3, faces: Faces, concerned: Bool[np.ndarray, " f"] | None = None
) -> Int64[np.ndarray, "k 2"]:
    """Pairs of faces that pass through each other, the lower number first, in rising order.

    The tree is held against itself: two nodes whose boxes lie apart, or of which no face is
    concerned, are left at once with all pairs under them.

    Args:
        concerned: Only pairs with one of these faces; None asks for all pairs.
    """
    if not len(faces) or (concerned is not None and not concerned.any()):
        return np.empty((0, 2), np.int64)
    tree = TriangleTree.of(vertices_mm, faces)
    corners = np.ascontiguousarray(faces[tree.order])
    asked = np.ones(len(faces), np.bool_) if concerned is None else concerned[tree.order]
    leaves = len(tree.boxes) // 2
    busy = _with_asked(asked, leaves)
    own = _own_boxes(tree.triangles)
    normals = _unit_normals(tree.triangles)
    top = min(_SHARED_OUT, leaves)

    def cross(part: Int64[np.ndarray, " m"]) -> Int64[np.ndarray, "k 2"]:
        room = np.empty((max(64, 2 * len(part)), 2), np.int64)
        given = tree.triangles, tree.boxes, own, normals, corners, asked, busy, part, 2 * top
        count = _cross(*given, room)
        if count > len(room):
            room = np.empty((count, 2), np.int64)
            _cross(*given, room)
        return room[:count]

    turn = np.arange(top, 2 * top)
    parts = _PARTS * worker_count() if np.count_nonzero(asked) > _MANY else 1
    found = np.concatenate(in_parallel(cross, np.array_split(turn, min(parts, top))))
    pairs = np.sort(tree.order[found], axis=1)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


@njit(cache=True, nogil=True)
def _with_asked(asked: np.ndarray, leaves: int):
    """Which nodes of the tree have a triangle under them that was asked for."""
    busy = np.zeros(2 * leaves, np.bool_)
    for t in range(len(asked)):
        if asked[t]:
            busy[leaves + t // LEAF] = True
    for node in range(leaves - 1, 0, -1):
        busy[node] = busy[2 * node] or busy[2 * node + 1]
    return busy


@njit(cache=True, nogil=True)
def _own_boxes(triangles: np.ndarray):
    """The box of each triangle."""
    boxes = np.empty((len(triangles), 6))
    for t in range(len(triangles)):
        for axis in range(3):
            a, b, c = triangles[t, 0, axis], triangles[t, 1, axis], triangles[t, 2, axis]
            boxes[t, axis], boxes[t, axis + 3] = min(a, b, c), max(a, b, c)
    return boxes


@njit(cache=True, nogil=True)
def _unit_normals(triangles: np.ndarray):
    """The normal of each triangle at length 1."""
    normals = np.empty((len(triangles), 3))
    for t in range(len(triangles)):
        for axis in range(3):
            i, j = (axis + 1) % 3, (axis + 2) % 3
            normals[t, axis] = (triangles[t, 1, i] - triangles[t, 0, i]) * (
                triangles[t, 2, j] - triangles[t, 0, j]
            ) - (triangles[t, 1, j] - triangles[t, 0, j]) * (
                triangles[t, 2, i] - triangles[t, 0, i]
            )
        x, y, z = normals[t]
        length = max(np.sqrt(x**2 + y**2 + z**2), 1e-300)
        for axis in range(3):
            normals[t, axis] /= length
    return normals


@njit(cache=True, nogil=True)
def _cross(
    triangles: np.ndarray,
    boxes: np.ndarray,
    own: np.ndarray,
    normals: np.ndarray,
    corners: np.ndarray,
    asked: np.ndarray,
    busy: np.ndarray,
    turn: np.ndarray,
    end: int,
    found: np.ndarray,
):
    """Fill in crossing pairs under the nodes whose `turn` it is, each with itself and with those
    after it up to the `end` of its level, as far as there is room; returns how many there are."""
    leaves = boxes.shape[0] // 2
    ones, twos = np.empty(256, np.int64), np.empty(256, np.int64)
    work = (np.empty(3), np.empty(3), np.empty(3))
    count = 0
    for start in turn:
        for partner in range(start, end):
            ones[0], twos[0] = start, partner
            depth = 1
            while depth > 0:
                depth -= 1
                one, two = ones[depth], twos[depth]
                if not (busy[one] or busy[two]) or (one != two and _apart(boxes, one, boxes, two)):
                    continue
                if one < leaves:
                    for i in range(2):
                        for j in range(i if one == two else 0, 2):
                            ones[depth], twos[depth] = 2 * one + i, 2 * two + j
                            depth += 1
                    continue
                first, other_first = (one - leaves) * LEAF, (two - leaves) * LEAF
                for t in range(first, min(first + LEAF, triangles.shape[0])):
                    if one != two and _apart(own, t, boxes, two):
                        continue
                    after = t + 1 if one == two else other_first
                    for other in range(after, min(other_first + LEAF, triangles.shape[0])):
                        if not (asked[t] or asked[other]) or _apart(own, t, own, other):
                            continue
                        least = _TOUCH * _size(own, t, other)
                        if _beside(triangles, normals, t, other, least):
                            continue
                        if _beside(triangles, normals, other, t, least):
                            continue
                        a, b = (t, other) if asked[t] else (other, t)
                        if _pass_through(triangles, normals, corners, a, b, least, work):
                            if count < found.shape[0]:
                                found[count, 0], found[count, 1] = a, b
                            count += 1
    return count


@njit(cache=True, nogil=True)
def _apart(ones: np.ndarray, one: int, twos: np.ndarray, two: int):
    """Whether two boxes have room between them; without branches, which are seldom foreseen."""
    x = max(ones[one, 0] - twos[two, 3], twos[two, 0] - ones[one, 3])
    y = max(ones[one, 1] - twos[two, 4], twos[two, 1] - ones[one, 4])
    z = max(ones[one, 2] - twos[two, 5], twos[two, 2] - ones[one, 5])
    return max(x, y, z) > 0


@njit(cache=True, nogil=True)
def _size(own: np.ndarray, one: int, two: int):
    """The longest side of the box round two triangles."""
    size = 0.0
    for axis in range(3):
        high = max(own[one, axis + 3], own[two, axis + 3])
        size = max(size, high - min(own[one, axis], own[two, axis]))
    return size


@njit(cache=True, nogil=True)
def _beside(triangles: np.ndarray, normals: np.ndarray, t: int, other: int, least: float):
    """Whether no two corners of a triangle lie to both sides of another's plane.

    Most neighbours end here. Shared corners are not looked at: they only make it say so less often.
    """
    above = below = False
    for k in range(3):
        height = 0.0
        for axis in range(3):
            height += normals[other, axis] * (triangles[t, k, axis] - triangles[other, 0, axis])
        above = above or height > least
        below = below or height < -least
    return not (above and below)


@njit(cache=True, nogil=True)
def _pass_through(
    triangles: np.ndarray,
    normals: np.ndarray,
    corners: np.ndarray,
    one: int,
    two: int,
    least: float,
    work: tuple[np.ndarray, ...],
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
    normal_one, normal_two = normals[one], normals[two]
    heights_one, heights_two, along = work
    if not _straddles(triangles, corners, one, two, normal_two, least, heights_one):
        return False
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
