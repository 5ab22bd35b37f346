"""Nearest place on a triangle mesh: a tree of boxes over triangles in Morton order, compiled."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64
from numba import njit

from limbgram.geometry.arrays import Faces, Points3
from limbgram.run import in_parallel, worker_count

_MANY = 20_000
"""Queries from which they are shared out among the processors; none depends on another."""
_LEAF = 4
"""Triangles in a leaf."""
_ROOM, _ROOM_MM2 = 1 + 1e-9, 1e-12
"""A bound is raised by this share and this much, so that the nearest place lies below it."""
_SPREADING = ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249))
"""Steps that set two zeros between the ten bits of a number."""


@dataclass(frozen=True)
class Closest:
    """For each query: the nearest place on the mesh, its face, and how far it is."""

    points_mm: Float64[np.ndarray, "n 3"]
    faces: Int64[np.ndarray, " n"]
    distances_mm: Float64[np.ndarray, " n"]


@dataclass(frozen=True)
class TriangleTree:
    """Triangles sorted along a Morton curve under a complete binary tree of boxes.

    Node 1 is the root, node k has children 2 k and 2 k + 1; the last half are leaves.
    """

    triangles: Float64[np.ndarray, "f 3 3"]
    order: Int64[np.ndarray, " f"]
    boxes: Float64[np.ndarray, "k 6"]

    @classmethod
    def of(cls, vertices_mm: Points3, faces: Faces) -> "TriangleTree":
        corners = vertices_mm[faces]
        first, second, third = (corners[:, k] for k in range(3))
        order = np.argsort(_morton((first + second + third) / 3), kind="stable")
        low = np.minimum(np.minimum(first, second), third)[order]
        high = np.maximum(np.maximum(first, second), third)[order]
        leaves = 1 << max(0, (-(-len(faces) // _LEAF) - 1).bit_length())
        boxes = np.full((2 * leaves, 6), np.inf)
        boxes[:, 3:] = -np.inf
        starts = np.arange(0, len(faces), _LEAF)
        filled = slice(leaves, leaves + len(starts))
        boxes[filled, :3] = np.minimum.reduceat(low, starts)
        boxes[filled, 3:] = np.maximum.reduceat(high, starts)
        while leaves > 1:
            below = boxes[leaves : 2 * leaves]
            leaves //= 2
            boxes[leaves : 2 * leaves, :3] = np.minimum(below[::2, :3], below[1::2, :3])
            boxes[leaves : 2 * leaves, 3:] = np.maximum(below[::2, 3:], below[1::2, 3:])
        return cls(corners[order], order, boxes)

    def closest(self, points_mm: Points3) -> Closest:
        if not len(points_mm):
            return Closest(np.empty((0, 3)), np.empty(0, np.int64), np.empty(0))
        places = np.empty((len(points_mm), 3))
        found = np.empty(len(points_mm), np.int64)
        distances = np.empty(len(points_mm))
        queries = np.ascontiguousarray(points_mm, np.float64)
        turn = np.arange(len(queries))
        if np.isfinite(queries).all():
            turn = np.argsort(_morton(queries), kind="stable")  # neighbours walk the same boxes

        def search(part: Int64[np.ndarray, " m"]) -> None:
            _search(self.triangles, self.boxes, queries, part, places, found, distances)

        parts = worker_count() if len(turn) > _MANY else 1
        in_parallel(search, np.array_split(turn, parts))
        return Closest(places, self.order[found], distances)


def _morton(points: Points3) -> Int64[np.ndarray, " n"]:
    """Bits of the three coordinates, interleaved."""
    low, high = points.min(0), points.max(0)
    cells = ((points - low) / max(float((high - low).max()), 1e-30) * 1023).astype(np.int64)
    for step, kept in _SPREADING:
        cells = (cells | cells << step) & kept
    return cells[:, 0] | cells[:, 1] << 1 | cells[:, 2] << 2


@njit(cache=True, nogil=True)
def _search(triangles, boxes, queries, turn, places, found, distances):
    leaves = boxes.shape[0] // 2
    stack, away2 = np.empty(64, np.int64), np.empty(64)
    place = np.empty(3)
    last = 0
    for q in turn:
        point = queries[q]
        # The last query's triangle only bounds the search: what is found depends on no order.
        known = _nearest_on_triangle(triangles[last], point, place)
        bound = known * _ROOM + _ROOM_MM2 if known < np.inf else np.inf
        best = bound
        found[q] = last
        places[q] = place
        stack[0], away2[0] = 1, 0.0
        depth = 1
        while depth > 0:
            depth -= 1
            node = stack[depth]
            if away2[depth] >= best:
                continue
            if node >= leaves:
                first = (node - leaves) * _LEAF
                for t in range(first, min(first + _LEAF, triangles.shape[0])):
                    distance2 = _nearest_on_triangle(triangles[t], point, place)
                    if distance2 < best:
                        best = distance2
                        found[q] = t
                        for axis in range(3):
                            places[q, axis] = place[axis]
                continue
            near, far = 2 * node, 2 * node + 1
            near2, far2 = _box_distance2(boxes[near], point), _box_distance2(boxes[far], point)
            if far2 < near2:
                near, near2, far, far2 = far, far2, near, near2
            stack[depth], stack[depth + 1] = far, near
            away2[depth], away2[depth + 1] = far2, near2
            depth += 2
        last = found[q]
        distances[q] = np.sqrt(best if best < bound else known)


@njit(cache=True, nogil=True)
def _box_distance2(box, point):
    total = 0.0
    for axis in range(3):
        outside = max(box[axis] - point[axis], point[axis] - box[axis + 3], 0.0)
        total += outside * outside
    return total


@njit(cache=True, nogil=True)
def _nearest_on_triangle(triangle, point, place):
    """Squared distance to a triangle; fills in the nearest place (Ericson 2005, 5.1.5)."""
    a, b, c = triangle[0], triangle[1], triangle[2]
    d1 = d2 = d3 = d4 = d5 = d6 = 0.0
    for k in range(3):
        ab, ac = b[k] - a[k], c[k] - a[k]
        d1 += ab * (point[k] - a[k])
        d2 += ac * (point[k] - a[k])
        d3 += ab * (point[k] - b[k])
        d4 += ac * (point[k] - b[k])
        d5 += ab * (point[k] - c[k])
        d6 += ac * (point[k] - c[k])
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    v = w = 0.0
    if d1 <= 0 and d2 <= 0:
        pass
    elif d3 >= 0 and d4 <= d3:
        v = 1.0
    elif d6 >= 0 and d5 <= d6:
        w = 1.0
    elif vc <= 0 and d1 >= 0 and d3 <= 0:
        v = d1 / (d1 - d3)
    elif vb <= 0 and d2 >= 0 and d6 <= 0:
        w = d2 / (d2 - d6)
    elif va <= 0 and d4 - d3 >= 0 and d5 - d6 >= 0:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        v = 1 - w
    else:
        v, w = vb / (va + vb + vc), vc / (va + vb + vc)
    distance2 = 0.0
    for k in range(3):
        place[k] = a[k] + v * (b[k] - a[k]) + w * (c[k] - a[k])
        distance2 += (place[k] - point[k]) ** 2
    return distance2
