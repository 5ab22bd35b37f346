"""Crossings: self-intersections of a mesh, as pairs of triangles, found by a tree of boxes.

Triangles that share an edge cannot cross unless they lie on each other; such folds show in the
angle between neighbours and are not looked for here. Touching is not crossing.
"""

import numpy as np
from jaxtyping import Bool, Int64

from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.kernels import njit
from limbgram.core.mesh.closest_point import LEAF, TriangleTree
from limbgram.core.run import in_parallel, worker_count

_MANY, _TASKS = 20_000, 4
"""Triangles above which they are shared out among the processors, and tasks for each: some parts of
a surface have more neighbours than others."""
_TASK_NODES = 64
"""Nodes of the tree level whose pairs are the tasks."""
_TOUCH = 1e-9
"""Depth and length below which triangles only touch, as a share of their size."""


def find_crossings(
    vertices_mm: Points3, faces: Faces, concerned: Bool[np.ndarray, " f"] | None = None
) -> Int64[np.ndarray, "k 2"]:
    """Pairs of faces that pass through each other, the lower index first, in rising order.

    The tree is traversed against itself: two nodes whose boxes are disjoint, or below which no
    face is concerned, are skipped with all pairs under them.

    Args:
        concerned: Only pairs with one of these faces; None: all pairs.
    """
    if not len(faces) or (concerned is not None and not concerned.any()):
        return np.empty((0, 2), np.int64)
    tree = TriangleTree.of(vertices_mm, faces)
    corners = np.ascontiguousarray(faces[tree.order])
    asked = np.ones(len(faces), np.bool_) if concerned is None else concerned[tree.order]
    leaves = len(tree.boxes) // 2
    has_asked = _nodes_with_asked(asked, leaves)
    triangle_boxes = _boxes_of(tree.triangles)
    normals = _unit_normals(tree.triangles)
    first = min(_TASK_NODES, leaves)
    surface = tree.triangles, tree.boxes, triangle_boxes, normals, corners, asked, has_asked

    def crossings_under(nodes: Int64[np.ndarray, " m"]) -> Int64[np.ndarray, "k 2"]:
        pairs = np.empty((max(64, 2 * len(nodes)), 2), np.int64)
        count = _cross(*surface, nodes, 2 * first, pairs)
        if count > len(pairs):
            pairs = np.empty((count, 2), np.int64)
            _cross(*surface, nodes, 2 * first, pairs)
        return pairs[:count]

    nodes = np.arange(first, 2 * first)
    tasks = _TASKS * worker_count() if np.count_nonzero(asked) > _MANY else 1
    found = np.concatenate(in_parallel(crossings_under, np.array_split(nodes, min(tasks, first))))
    pairs = np.sort(tree.order[found], axis=1)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


@njit(cache=True, nogil=True)
def _nodes_with_asked(asked: np.ndarray, leaves: int):
    """Which nodes of the tree have a triangle under them that was asked for."""
    has_asked = np.zeros(2 * leaves, np.bool_)
    for t in range(len(asked)):
        if asked[t]:
            has_asked[leaves + t // LEAF] = True
    for node in range(leaves - 1, 0, -1):
        has_asked[node] = has_asked[2 * node] or has_asked[2 * node + 1]
    return has_asked


@njit(cache=True, nogil=True)
def _boxes_of(triangles: np.ndarray):
    """Bounding box of each triangle."""
    boxes = np.empty((len(triangles), 6))
    for t in range(len(triangles)):
        for axis in range(3):
            a, b, c = triangles[t, 0, axis], triangles[t, 1, axis], triangles[t, 2, axis]
            boxes[t, axis], boxes[t, axis + 3] = min(a, b, c), max(a, b, c)
    return boxes


@njit(cache=True, nogil=True)
def _unit_normals(triangles: np.ndarray):
    """Unit normal of each triangle."""
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
    triangle_boxes: np.ndarray,
    normals: np.ndarray,
    corners: np.ndarray,
    asked: np.ndarray,
    has_asked: np.ndarray,
    nodes: np.ndarray,
    end: int,
    found: np.ndarray,
):
    """Fill in crossing pairs under these nodes, each with itself and with the nodes after it.

    Nodes end at `end`, where their level does. Returns the number of pairs, which may exceed the
    length of `found`.
    """
    leaves = boxes.shape[0] // 2
    ones, twos = np.empty(256, np.int64), np.empty(256, np.int64)
    work = (np.empty(3), np.empty(3), np.empty(3))
    count = 0
    for start in nodes:
        for partner in range(start, end):
            ones[0], twos[0] = start, partner
            depth = 1
            while depth > 0:
                depth -= 1
                one, two = ones[depth], twos[depth]
                if not (has_asked[one] or has_asked[two]):
                    continue
                if one != two and _disjoint(boxes, one, boxes, two):
                    continue
                if one < leaves:
                    for i in range(2):
                        for j in range(i if one == two else 0, 2):
                            ones[depth], twos[depth] = 2 * one + i, 2 * two + j
                            depth += 1
                    continue
                first, other_first = (one - leaves) * LEAF, (two - leaves) * LEAF
                for t in range(first, min(first + LEAF, triangles.shape[0])):
                    if one != two and _disjoint(triangle_boxes, t, boxes, two):
                        continue
                    after = t + 1 if one == two else other_first
                    for other in range(after, min(other_first + LEAF, triangles.shape[0])):
                        if not (asked[t] or asked[other]):
                            continue
                        if _disjoint(triangle_boxes, t, triangle_boxes, other):
                            continue
                        least = _TOUCH * _size(triangle_boxes, t, other)
                        if _on_one_side(triangles, normals, t, other, least):
                            continue
                        if _on_one_side(triangles, normals, other, t, least):
                            continue
                        a, b = (t, other) if asked[t] else (other, t)
                        if _intersect(triangles, normals, corners, a, b, least, work):
                            if count < found.shape[0]:
                                found[count, 0], found[count, 1] = a, b
                            count += 1
    return count


@njit(cache=True, nogil=True)
def _disjoint(ones: np.ndarray, one: int, twos: np.ndarray, two: int):
    """Whether two boxes are disjoint; branch-free, as branches would be mispredicted."""
    x = max(ones[one, 0] - twos[two, 3], twos[two, 0] - ones[one, 3])
    y = max(ones[one, 1] - twos[two, 4], twos[two, 1] - ones[one, 4])
    z = max(ones[one, 2] - twos[two, 5], twos[two, 2] - ones[one, 5])
    return max(x, y, z) > 0


@njit(cache=True, nogil=True)
def _size(triangle_boxes: np.ndarray, one: int, two: int):
    """The longest side of the box round two triangles."""
    size = 0.0
    for axis in range(3):
        high = max(triangle_boxes[one, axis + 3], triangle_boxes[two, axis + 3])
        size = max(size, high - min(triangle_boxes[one, axis], triangle_boxes[two, axis]))
    return size


@njit(cache=True, nogil=True)
def _on_one_side(triangles: np.ndarray, normals: np.ndarray, t: int, other: int, least: float):
    """Whether a triangle lies on one side of another's plane, which rules out most neighbours.

    Shared corners are not treated apart: rounding then rules out fewer, never wrong ones.
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
def _intersect(
    triangles: np.ndarray,
    normals: np.ndarray,
    corners: np.ndarray,
    one: int,
    two: int,
    least: float,
    work: tuple[np.ndarray, ...],
):
    """Whether two triangles intersect in more than a touch (Moeller 1997); `work` is scratch.

    Each must have corners on both sides of the other's plane, and their intervals on the planes'
    common line must overlap. A shared corner counts as lying in both planes.
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
    low_one, high_one = _interval_on_line(triangles[one], triangles[one, 0], along, heights_one)
    low_two, high_two = _interval_on_line(triangles[two], triangles[one, 0], along, heights_two)
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
    """Whether corners lie on both sides of the other's plane; fills in their heights above it."""
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
def _interval_on_line(
    triangle: np.ndarray, origin: np.ndarray, along: np.ndarray, heights: np.ndarray
):
    """Interval of the line through `origin` that a triangle covers where its height is 0."""
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
