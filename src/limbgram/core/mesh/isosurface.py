"""Isosurface: the surface on which values on a grid are zero.

Method  each cube of the grid is six tetrahedra round its diagonal (Freudenthal 1942), and each of
        these is cut straight: the surface is closed where the values are negative at the grid's
        border, is a manifold and does not pass through itself.
"""

from itertools import permutations

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.mesh.mesh import Mesh

_NEAREST = 0.15
"""A place on an edge keeps this share of it from either end: nearer ones make slivers. It leaves
the level by so much of a cell at most."""
_PAIRS = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))


def level_surface(values: Float64[np.ndarray, "x y z"], origin_mm: Vector3, step_mm: float) -> Mesh:
    """Round the places with values above zero, its faces looking away from them."""
    above = (values > 0).ravel()
    corner = np.arange(values.size).reshape(values.shape)
    stride = np.array([values.shape[1] * values.shape[2], values.shape[2], 1])
    firsts = corner[:-1, :-1, :-1].ravel()
    ways = [np.concatenate([[0], np.cumsum(stride[list(way)])]) for way in permutations(range(3))]
    cube = np.array([above[firsts + step] for step in np.unique(np.concatenate(ways))])
    firsts = firsts[cube.any(0) & ~cube.all(0)]
    cut: list[Int64[np.ndarray, "k 3 2"]] = []
    for way, steps in zip(permutations(range(3)), ways, strict=True):
        corners = firsts[:, None] + steps
        case = above[corners] @ (1 << np.arange(4))
        even = np.linalg.det(np.eye(3)[list(way)]) > 0
        for number, faces in enumerate(_CASES):
            chosen = corners[case == number]
            turned = faces if even else [face[::-1] for face in faces]
            cut.extend(chosen[:, np.array(face)] for face in turned)
    ends = np.sort(np.concatenate(cut).reshape(-1, 2), axis=1)
    keys, numbers = np.unique(ends[:, 0] * values.size + ends[:, 1], return_inverse=True)
    low, high = keys // values.size, keys % values.size
    one, two = values.ravel()[low], values.ravel()[high]
    share = np.clip(one / (one - two), _NEAREST, 1 - _NEAREST)[:, None]
    places = (1 - share) * _places(low, values.shape) + share * _places(high, values.shape)
    faces = numbers.reshape(-1, 3).astype(np.int32)
    return Mesh(vertices_mm=origin_mm + step_mm * places, faces=faces)


def _places(corners: Int64[np.ndarray, " k"], shape: tuple[int, ...]) -> Points3:
    return np.stack(np.unravel_index(corners, shape), axis=1).astype(np.float64)


def _cases() -> list[list[list[tuple[int, int]]]]:
    """For each choice of the corners of a tetrahedron that are above: the triangles of the cut,
    their corners named by the edges that they lie on."""
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
