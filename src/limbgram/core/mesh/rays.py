"""Rays: whether segments intersect a mesh."""

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.kernels import njit
from limbgram.core.mesh.closest_point import LEAF, TriangleTree

_SLACK = 1e-6
"""In barycentric coordinates: a ray through an edge meets both faces, and slips between none."""


def intersects_any(
    tree: TriangleTree, starts_mm: Points3, segments_mm: Float64[np.ndarray, "n 3"]
) -> Bool[np.ndarray, " n"]:
    """Whether each segment, from its start, meets a triangle (Möller and Trumbore 1997)."""
    hit = np.zeros(len(starts_mm), np.bool_)
    _intersect(tree.triangles, tree.boxes, starts_mm, segments_mm, hit)
    return hit


@njit(cache=True, nogil=True)
def _intersect(
    triangles: np.ndarray,
    boxes: np.ndarray,
    starts: np.ndarray,
    segments: np.ndarray,
    hit: np.ndarray,
):
    leaves = boxes.shape[0] // 2
    stack = np.empty(64, np.int64)
    for i in range(len(starts)):
        stack[0] = 1
        depth = 1
        while depth > 0 and not hit[i]:
            depth -= 1
            node = stack[depth]
            if not _enters_box(boxes[node], starts[i], segments[i]):
                continue
            if node < leaves:
                stack[depth], stack[depth + 1] = 2 * node, 2 * node + 1
                depth += 2
                continue
            first = (node - leaves) * LEAF
            for t in range(first, min(first + LEAF, len(triangles))):
                if _crosses_triangle(triangles[t], starts[i], segments[i]):
                    hit[i] = True
                    break


@njit(cache=True, nogil=True)
def _enters_box(box: np.ndarray, start: np.ndarray, segment: np.ndarray):
    near, far = 0.0, 1.0
    for axis in range(3):
        low, high = box[axis] - start[axis], box[axis + 3] - start[axis]
        if segment[axis] == 0.0:
            if low > 0.0 or high < 0.0:
                return False
            continue
        low, high = low / segment[axis], high / segment[axis]
        near, far = max(near, min(low, high)), min(far, max(low, high))
    return near <= far + _SLACK


@njit(cache=True, nogil=True)
def _crosses_triangle(triangle: np.ndarray, start: np.ndarray, segment: np.ndarray):
    ax, ay, az = triangle[0, 0], triangle[0, 1], triangle[0, 2]
    ux, uy, uz = triangle[1, 0] - ax, triangle[1, 1] - ay, triangle[1, 2] - az
    vx, vy, vz = triangle[2, 0] - ax, triangle[2, 1] - ay, triangle[2, 2] - az
    sx, sy, sz = start[0] - ax, start[1] - ay, start[2] - az
    wx, wy, wz = segment[0], segment[1], segment[2]
    px, py, pz = wy * vz - wz * vy, wz * vx - wx * vz, wx * vy - wy * vx
    determinant = ux * px + uy * py + uz * pz
    if determinant == 0.0:
        return False
    qx, qy, qz = sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux
    u = (sx * px + sy * py + sz * pz) / determinant
    v = (wx * qx + wy * qy + wz * qz) / determinant
    if u < -_SLACK or v < -_SLACK or u + v > 1.0 + _SLACK:
        return False
    return 0.0 <= (vx * qx + vy * qy + vz * qz) / determinant <= 1.0
