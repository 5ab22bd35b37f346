"""Isosurface: the surface on which values on a grid are zero.

Method  marching tetrahedra: each cube of the grid is six tetrahedra round its diagonal
        (Freudenthal 1942). The surface is a manifold without self-intersections, and closed if the
        values are negative on the grid's border.
"""

from itertools import permutations

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.mesh.mesh import Mesh

_NEAREST = 0.15
"""A vertex keeps this share of its edge from either end, to avoid slivers; it may so lie off the
level by this share of a cell."""
_PAIRS = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))


def level_surface(values: Float64[np.ndarray, "x y z"], origin_mm: Vector3, step_mm: float) -> Mesh:
    """The surface on which the values are zero, its normals away from those above zero."""
    above = (values > 0).ravel()
    corner = np.arange(values.size).reshape(values.shape)
    stride = np.array([values.shape[1] * values.shape[2], values.shape[2], 1])
    firsts = corner[:-1, :-1, :-1].ravel()
    axis_orders = list(permutations(range(3)))  # one tetrahedron for each
    offsets = [np.concatenate([[0], np.cumsum(stride[list(axes)])]) for axes in axis_orders]
    cube = np.array([above[firsts + offset] for offset in np.unique(np.concatenate(offsets))])
    firsts = firsts[cube.any(0) & ~cube.all(0)]
    cut: list[Int64[np.ndarray, "k 3 2"]] = []
    for axes, of_tetrahedron in zip(axis_orders, offsets, strict=True):
        corners = firsts[:, None] + of_tetrahedron
        case = above[corners] @ (1 << np.arange(4))
        even = np.linalg.det(np.eye(3)[list(axes)]) > 0
        for number, faces in enumerate(_CASES):
            chosen = corners[case == number]
            outward = faces if even else [face[::-1] for face in faces]
            cut.extend(chosen[:, np.array(face)] for face in outward)
    ends = np.sort(np.concatenate(cut).reshape(-1, 2), axis=1)
    keys, vertex_idx = np.unique(ends[:, 0] * values.size + ends[:, 1], return_inverse=True)
    low, high = keys // values.size, keys % values.size
    at_low, at_high = values.ravel()[low], values.ravel()[high]
    fraction = np.clip(at_low / (at_low - at_high), _NEAREST, 1 - _NEAREST)[:, None]
    vertices = (1 - fraction) * _grid_points(low, values.shape)
    vertices += fraction * _grid_points(high, values.shape)
    faces = vertex_idx.reshape(-1, 3).astype(np.int32)
    return Mesh(vertices_mm=origin_mm + step_mm * vertices, faces=faces)


def _grid_points(corners: Int64[np.ndarray, " k"], shape: tuple[int, ...]) -> Points3:
    return np.stack(np.unravel_index(corners, shape), axis=1).astype(np.float64)


def _cases() -> list[list[list[tuple[int, int]]]]:
    """Triangles of the cut by case (bit k: corner k is above); their corners are named by edges."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1]], np.float64)
    cases: list[list[list[tuple[int, int]]]] = []
    for number in range(16):
        above = [k for k in range(4) if number >> k & 1]
        below = [k for k in range(4) if k not in above]
        edges = [pair for pair in _PAIRS if (pair[0] in above) != (pair[1] in above)]
        if len(edges) == 4:  # in order round it: neighbours share a corner
            edges = [
                (above[0], below[0]),
                (above[0], below[1]),
                (above[1], below[1]),
                (above[1], below[0]),
            ]
        faces = [[edges[0], edges[k], edges[k + 1]] for k in range(1, len(edges) - 1)]
        for face in faces:
            a, b, c = (corners[list(edge)].mean(0) for edge in face)
            away = corners[below].mean(0) - corners[above].mean(0)
            if np.cross(b - a, c - a) @ away < 0:
                face.reverse()
        cases.append(faces)
    return cases


_CASES = _cases()
