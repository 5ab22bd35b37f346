"""The thin plate: bending energy that regularises the surface where its vertices are uncertain.

Cotangent Laplacian (Pinkall and Polthier 1993). The bending energy acts on the whole surface, not
on the correction, so that noise does not stay from round to round. Folds are let be: the edge of a
thin part is no noise.

Sparse systems are solved by conjugate gradients (Hestenes and Stiefel 1952) with diagonal
preconditioning, compiled: one pass over the matrix a step, one thread, the same bytes on every run.
How the surface bends round each vertex is a quadric fitted over two rings by least squares.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh

_TOLERANCE = 1e-3
_MOST_STEPS = 200
_TOGETHER = 4
"""Right sides that are solved in one pass over the system."""


def solve(
    system: sp.csr_matrix, right: Float64[np.ndarray, " n"], start: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, " n"]:
    """Solution of a positive definite system, to a thousandth of the right side."""
    solution = np.array(start, np.float64)
    _iterate(
        system.data,
        system.indices.astype(np.int32),
        system.indptr.astype(np.int32),
        1.0 / system.diagonal().astype(np.float64),
        np.ascontiguousarray(right, np.float64),
        solution,
        _TOLERANCE,
        _MOST_STEPS,
    )
    return solution


def solve_all(
    system: sp.csr_matrix, rights: Sequence[Float64[np.ndarray, " n"]]
) -> list[Float64[np.ndarray, " n"]]:
    """The solutions of several right sides, each as `solve` has it, to the byte.

    Four are solved together, which reads the system once: less than half the time.
    """
    diagonal = system.diagonal().astype(np.float64)
    indices, starts = system.indices.astype(np.int32), system.indptr.astype(np.int32)
    found: list[Float64[np.ndarray, " n"]] = []
    for first in range(0, len(rights), _TOGETHER):
        some = rights[first : first + _TOGETHER]
        columns = np.zeros((len(diagonal), _TOGETHER))
        columns[:, : len(some)] = np.column_stack(some)
        answers = columns / diagonal[:, None]
        _iterate_four(
            system.data, indices, starts, 1.0 / diagonal, columns, answers, _TOLERANCE, _MOST_STEPS
        )
        found += [np.ascontiguousarray(answers[:, k]) for k in range(len(some))]
    return found


@njit(cache=True, nogil=True)
def _iterate(
    data: np.ndarray,
    indices: np.ndarray,
    starts: np.ndarray,
    preconditioner: np.ndarray,
    right: np.ndarray,
    solution: np.ndarray,
    tolerance: float,
    steps: int,
):
    count = len(right)
    residual, direction, image = np.empty(count), np.empty(count), np.empty(count)
    size = 0.0
    energy = 0.0
    for i in range(count):
        total = 0.0
        for k in range(starts[i], starts[i + 1]):
            total += data[k] * solution[indices[k]]
        residual[i] = right[i] - total
        direction[i] = preconditioner[i] * residual[i]
        energy += residual[i] * direction[i]
        size += right[i] * right[i]
    goal = tolerance * tolerance * size
    for _ in range(steps):
        left = 0.0
        for i in range(count):
            left += residual[i] * residual[i]
        if left <= goal:
            return
        curvature = 0.0
        for i in range(count):
            total = 0.0
            for k in range(starts[i], starts[i + 1]):
                total += data[k] * direction[indices[k]]
            image[i] = total
            curvature += total * direction[i]
        step = energy / curvature
        renewed = 0.0
        for i in range(count):
            solution[i] += step * direction[i]
            residual[i] -= step * image[i]
            renewed += preconditioner[i] * residual[i] * residual[i]
        ratio = renewed / energy
        energy = renewed
        for i in range(count):
            direction[i] = preconditioner[i] * residual[i] + ratio * direction[i]


@njit(cache=True, nogil=True)
def _iterate_four(
    data: np.ndarray,
    indices: np.ndarray,
    starts: np.ndarray,
    preconditioner: np.ndarray,
    right: np.ndarray,
    solution: np.ndarray,
    tolerance: float,
    steps: int,
):
    """As `_iterate`, for the four columns of `right`; what is solved moves no more."""
    count = len(right)
    residual, direction, image = np.empty((count, 4)), np.empty((count, 4)), np.empty((count, 4))
    size, energy, renewed = np.zeros(4), np.zeros(4), np.zeros(4)
    left, curvature, step, ratio = np.zeros(4), np.zeros(4), np.zeros(4), np.zeros(4)
    _times_four(data, indices, starts, solution, image)
    for i in range(count):
        for k in range(4):
            residual[i, k] = right[i, k] - image[i, k]
            direction[i, k] = preconditioner[i] * residual[i, k]
            energy[k] += residual[i, k] * direction[i, k]
            size[k] += right[i, k] * right[i, k]
    for _ in range(steps):
        _dots_of_four(residual, residual, left)
        _times_four(data, indices, starts, direction, image)
        _dots_of_four(image, direction, curvature)
        busy = False
        for k in range(4):
            step[k] = renewed[k] = 0.0
            if left[k] > tolerance * tolerance * size[k]:
                step[k], busy = energy[k] / curvature[k], True
        if not busy:
            return
        for i in range(count):
            for k in range(4):
                solution[i, k] += step[k] * direction[i, k]
                residual[i, k] -= step[k] * image[i, k]
                renewed[k] += preconditioner[i] * residual[i, k] * residual[i, k]
        for k in range(4):
            ratio[k] = 0.0 if step[k] == 0.0 else renewed[k] / energy[k]
            energy[k] = renewed[k]
        for i in range(count):
            for k in range(4):
                direction[i, k] = preconditioner[i] * residual[i, k] + ratio[k] * direction[i, k]


@njit(cache=True, nogil=True)
def _times_four(
    data: np.ndarray,
    indices: np.ndarray,
    starts: np.ndarray,
    columns: np.ndarray,
    product: np.ndarray,
):
    """Fill the product of the system with four columns."""
    for i in range(len(columns)):
        first = second = third = fourth = 0.0
        for k in range(starts[i], starts[i + 1]):
            value, row = data[k], columns[indices[k]]
            first += value * row[0]
            second += value * row[1]
            third += value * row[2]
            fourth += value * row[3]
        product[i, 0], product[i, 1], product[i, 2], product[i, 3] = first, second, third, fourth


@njit(cache=True, nogil=True)
def _dots_of_four(one: np.ndarray, other: np.ndarray, dots: np.ndarray):
    """Fill the products of four columns with four others, added up row by row."""
    first = second = third = fourth = 0.0
    for i in range(len(one)):
        first += one[i, 0] * other[i, 0]
        second += one[i, 1] * other[i, 1]
        third += one[i, 2] * other[i, 2]
        fourth += one[i, 3] * other[i, 3]
    dots[0], dots[1], dots[2], dots[3] = first, second, third, fourth


_LEAST_COTANGENT, _MOST_COTANGENT = 0.05, 5.0
_RIM_WEIGHT = 8.0
"""How strongly a rim vertex moves with its neighbours, in weights of a usual vertex."""
_FOLD = 0.25
"""Twice the mean curvature times the plate's length from which the surface is a fold."""
_FOLD_RINGS, _LOOSE_RINGS = 2, 3
"""Rings over which a fold is averaged, and round rims and fills that have none: nothing there
tells a fold from an error."""


@dataclass(frozen=True, kw_only=True)
class ThinPlate:
    """Operators of one mesh."""

    laplacian: sp.csr_matrix
    """(n, n), 1/mm^2: mean curvature normal times two."""
    area_mm2: Float64[np.ndarray, " n"]
    """A third of the area of the faces round each vertex."""
    neighbours: sp.csr_matrix
    """(n, n) 1 where two vertices share an edge."""
    is_boundary: np.ndarray
    fold: Float64[np.ndarray, " n"]
    """Twice the mean curvature, 1/mm, averaged over rings: folds stay, noise cancels out."""


def thin_plate_of(mesh: Mesh) -> ThinPlate:
    """Laplacian, areas and adjacency of a mesh."""
    vertices, faces = mesh.vertices_mm, mesh.faces
    count = len(vertices)
    rows: list[np.ndarray] = []
    columns: list[np.ndarray] = []
    weights: list[np.ndarray] = []
    doubled = np.linalg.norm(mesh.face_normals(), axis=1)
    area = np.bincount(faces.ravel(), np.repeat(doubled / 6, 3), count)
    for corner in range(3):
        i, j, k = (faces[:, (corner + turn) % 3] for turn in range(3))
        to_i, to_j = vertices[i] - vertices[k], vertices[j] - vertices[k]
        cotangent = np.einsum("ij,ij->i", to_i, to_j) / np.maximum(doubled, 1e-12)
        half = 0.5 * np.clip(cotangent, _LEAST_COTANGENT, _MOST_COTANGENT)
        rows += [i, j]
        columns += [j, i]
        weights += [half, half]
    area = np.maximum(area, 0.02 * np.median(area))
    graph = sp.csr_matrix(
        (np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns))), (count, count)
    )
    laplacian = sp.diags(1 / area) @ (graph - sp.diags(np.asarray(graph.sum(1)).ravel()))
    laplacian, neighbours = sp.csr_matrix(laplacian), _pattern(graph)
    is_boundary = _on_boundary(faces, count)
    loose = is_boundary if mesh.filled is None else is_boundary | mesh.filled
    bend = np.einsum("ij,ij->i", mesh.vertex_normals(), laplacian @ vertices)
    return ThinPlate(
        laplacian=laplacian,
        area_mm2=area,
        neighbours=neighbours,
        is_boundary=is_boundary,
        fold=_fold(bend, area, neighbours, loose),
    )


def _fold(
    bend: Float64[np.ndarray, " n"],
    area: Float64[np.ndarray, " n"],
    neighbours: sp.csr_matrix,
    loose: np.ndarray,
) -> Float64[np.ndarray, " n"]:
    """Mean of the curvature over rings, by area; 0 near what is `loose`."""
    ring = neighbours + sp.eye(len(bend))
    total, mass, near = bend * area, area, loose.astype(np.float64)
    for _ in range(_FOLD_RINGS):
        total, mass = ring @ total, ring @ mass
    for _ in range(_LOOSE_RINGS):
        near = ring @ near
    return np.where(near > 0, 0.0, total / mass)


def smoothed_moves(
    mesh: Mesh,
    thin_plate: ThinPlate,
    weights: Float64[np.ndarray, " n"],
    data: sp.csr_matrix,
    right: Float64[np.ndarray, " n"],
    stiffness: Float64[np.ndarray, " n"],
    length_mm: float,
) -> Float64[np.ndarray, " n"]:
    """Moves along the normals that balance the data against bending.

    Minimises x'(data)x - 2 right'x + stiffness * (curvature after the move)^2. A rim, which has no
    bending of its own, moves as its neighbours do.

    Args:
        weights: how much is known of each vertex, 1/mm^2: what a rim is held by.
        data: (n, n) normal matrix of the measurements, 1/mm^2: the step's.
        right: its right side, 1/mm.
        stiffness: of a plate of this length (`stiffness_of`).
    """
    bending = bending_of(thin_plate, stiffness)
    system = (data + bending @ thin_plate.laplacian + _rim(thin_plate, weights)).tocsr()
    force = bending @ curvature_of(mesh, thin_plate, length_mm)
    return solve(system, right - force, right / np.maximum(weights, 1e-12))


def _rim(thin_plate: ThinPlate, weights: Float64[np.ndarray, " n"]) -> sp.csr_matrix:
    """(n, n) what draws the moves of rim vertices to the mean of their neighbours'."""
    rim = np.flatnonzero(thin_plate.is_boundary)
    beside = thin_plate.neighbours[rim]
    mean = sp.diags(1 / np.asarray(beside.sum(1)).ravel()) @ beside
    own = sp.csr_matrix((np.ones(len(rim)), (np.arange(len(rim)), rim)), beside.shape)
    apart = sp.csr_matrix(own - mean)
    return sp.csr_matrix(_RIM_WEIGHT * float(np.median(weights)) * (apart.T @ apart))


def stiffness_of(
    thin_plate: ThinPlate, density: float, length_mm: float
) -> Float64[np.ndarray, " n"]:
    """Of each vertex: length^4 * density * area, none at the rim.

    Where the data weigh `density` per area, 1/mm^4, the plate rules over distances shorter than
    `length_mm` and the data over longer ones.
    """
    return np.where(thin_plate.is_boundary, 0.0, length_mm**4 * density * thin_plate.area_mm2)


def bending_of(thin_plate: ThinPlate, stiffness: Float64[np.ndarray, " n"]) -> sp.csr_matrix:
    """(n, n) force on each vertex by the curvature of the surface; see `stiffness_of`."""
    return sp.csr_matrix(thin_plate.laplacian.T @ sp.diags(stiffness))


def curvature_of(mesh: Mesh, thin_plate: ThinPlate, length_mm: float) -> Float64[np.ndarray, " n"]:
    """Twice the mean curvature along the normal that a plate of this length would take off, 1/mm.

    Negative where the surface is convex; next to nothing in folds.
    """
    bend = np.einsum("ij,ij->i", mesh.vertex_normals(), thin_plate.laplacian @ mesh.vertices_mm)
    return bend / (1 + (thin_plate.fold * length_mm / _FOLD) ** 4)


def tangent_axes(normals: Points3) -> Float64[np.ndarray, "n 3 3"]:
    """Two tangents and the normal of each vertex, rows, right-handed."""
    helper = np.where(np.abs(normals[:, 2:3]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(helper, normals)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normals, first), normals], axis=1)


def _pattern(matrix: sp.csr_matrix) -> sp.csr_matrix:
    """1 where the matrix has an entry."""
    return sp.csr_matrix(
        (np.ones_like(matrix.data), matrix.indices, matrix.indptr), shape=matrix.shape
    )


def _on_boundary(faces: np.ndarray, count: int) -> np.ndarray:
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    keys, uses = np.unique(edges[:, 0].astype(np.int64) * count + edges[:, 1], return_counts=True)
    single = keys[uses == 1]
    boundary = np.zeros(count, bool)
    boundary[single // count] = True
    boundary[single % count] = True
    return boundary


def quadrics(
    mesh: Mesh, thin_plate: ThinPlate, axes: Float64[np.ndarray, "n 3 3"]
) -> Float64[np.ndarray, "n 3"]:
    """Curvature (uu, uv, vv), 1/mm, of the least-squares quadric through each vertex's rings."""
    count = len(mesh)
    normal, right = np.zeros((count, 5, 5)), np.zeros((count, 5))
    _add_up(
        thin_plate.neighbours.indptr.astype(np.int32),
        thin_plate.neighbours.indices.astype(np.int32),
        mesh.vertices_mm,
        axes,
        normal,
        right,
    )
    diagonal = np.einsum("nii->ni", normal)
    diagonal *= 1.0 + 1e-4
    diagonal += 1e-9
    return np.ascontiguousarray(np.linalg.solve(normal, right[..., None])[:, 2:, 0])


@njit(cache=True, nogil=True)
def _add_up(
    starts: np.ndarray,
    others: np.ndarray,
    vertices: np.ndarray,
    axes: np.ndarray,
    normal: np.ndarray,
    right: np.ndarray,
):
    """Normal equations of slopes (2) and curvatures (3) over the neighbours' neighbours."""
    count = len(vertices)
    seen = np.full(count, -1, np.int32)
    terms = np.empty(5)
    for centre in range(count):
        seen[centre] = centre
        for near in range(starts[centre], starts[centre + 1]):
            ring = others[near]
            for far in range(starts[ring], starts[ring + 1]):
                other = others[far]
                if seen[other] == centre:
                    continue
                seen[other] = centre
                u = v = height = 0.0
                for k in range(3):
                    step = vertices[other, k] - vertices[centre, k]
                    u += axes[centre, 0, k] * step
                    v += axes[centre, 1, k] * step
                    height += axes[centre, 2, k] * step
                terms[0], terms[1] = u, v
                terms[2], terms[3], terms[4] = 0.5 * u * u, u * v, 0.5 * v * v
                for a in range(5):
                    right[centre, a] += terms[a] * height
                    for b in range(a, 5):
                        normal[centre, a, b] += terms[a] * terms[b]
        for a in range(5):
            for b in range(a):
                normal[centre, a, b] = normal[centre, b, a]
