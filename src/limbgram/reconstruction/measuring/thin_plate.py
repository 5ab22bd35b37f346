"""Thin plate: bending energy that regularises the surface where its vertices are uncertain.

The Laplacian has cotangent weights (Pinkall and Polthier 1993). The bending energy acts on the
whole surface, not on the correction, so that noise does not remain from round to round. Folds are
not smoothed: the edge of a thin part is no noise.

Conjugate gradients (Hestenes and Stiefel 1952) with a diagonal preconditioner solve the sparse
systems, compiled: one pass over the matrix per iteration, one thread, the same bytes on every run.
The curvature at each vertex is that of a quadric fitted to its 2-ring by least squares.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_vertices

_TOLERANCE = 1e-3
_MAX_ITERATIONS = 200
_COLUMNS = 4
"""Right-hand sides that are solved in one pass over the system."""
_INDEX = np.uint32
"""Type of indices in compiled loops: signed ones may count from the end, and are checked for it."""


def solve(
    system: sp.csr_matrix, right: Float64[np.ndarray, " n"], start: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, " n"]:
    """Solution of a positive definite system, to a thousandth of the right-hand side."""
    solution = np.array(start, np.float64)
    _conjugate_gradients(
        system.data,
        system.indices.astype(_INDEX),
        system.indptr.astype(_INDEX),
        1.0 / system.diagonal().astype(np.float64),
        np.ascontiguousarray(right, np.float64),
        solution,
        _TOLERANCE,
        _MAX_ITERATIONS,
    )
    return solution


def solve_all(
    system: sp.csr_matrix, rights: Sequence[Float64[np.ndarray, " n"]]
) -> list[Float64[np.ndarray, " n"]]:
    """Solutions of several right-hand sides, bit-identical to `solve` from right / diagonal.

    Four are solved together and read the system once, which halves the time; one alone is solved
    alone.
    """
    diagonal = system.diagonal().astype(np.float64)
    indices, starts = system.indices.astype(_INDEX), system.indptr.astype(_INDEX)
    found: list[Float64[np.ndarray, " n"]] = []
    for first in range(0, len(rights), _COLUMNS):
        batch = rights[first : first + _COLUMNS]
        if len(batch) == 1:
            found.append(solve(system, batch[0], batch[0] / diagonal))
            continue
        columns = np.zeros((len(diagonal), _COLUMNS))
        columns[:, : len(batch)] = np.column_stack(batch)
        solutions = columns / diagonal[:, None]
        _conjugate_gradients_four(
            system.data,
            indices,
            starts,
            1.0 / diagonal,
            columns,
            solutions,
            _TOLERANCE,
            _MAX_ITERATIONS,
        )
        found += [np.ascontiguousarray(solutions[:, k]) for k in range(len(batch))]
    return found


@njit(cache=True, nogil=True)
def _conjugate_gradients(
    data: np.ndarray,
    indices: np.ndarray,
    starts: np.ndarray,
    preconditioner: np.ndarray,
    right: np.ndarray,
    solution: np.ndarray,
    tolerance: float,
    steps: int,
):
    """Conjugate gradients on one right-hand side; fills `solution`, which holds the start."""
    count = len(right)
    residual, direction, product = np.empty(count), np.empty(count), np.empty(count)
    right_norm2 = 0.0
    energy = 0.0
    for i in range(count):
        total = 0.0
        for k in range(starts[i], starts[i + 1]):
            total += data[k] * solution[indices[k]]
        residual[i] = right[i] - total
        direction[i] = preconditioner[i] * residual[i]
        energy += residual[i] * direction[i]
        right_norm2 += right[i] * right[i]
    goal = tolerance * tolerance * right_norm2
    for _ in range(steps):
        residual_norm2 = 0.0
        for i in range(count):
            residual_norm2 += residual[i] * residual[i]
        if residual_norm2 <= goal:
            return
        curvature = 0.0
        for i in range(count):
            total = 0.0
            for k in range(starts[i], starts[i + 1]):
                total += data[k] * direction[indices[k]]
            product[i] = total
            curvature += total * direction[i]
        step = energy / curvature
        new_energy = 0.0
        for i in range(count):
            solution[i] += step * direction[i]
            residual[i] -= step * product[i]
            new_energy += preconditioner[i] * residual[i] * residual[i]
        ratio = new_energy / energy
        energy = new_energy
        for i in range(count):
            direction[i] = preconditioner[i] * residual[i] + ratio * direction[i]


@njit(cache=True, nogil=True)
def _conjugate_gradients_four(
    data: np.ndarray,
    indices: np.ndarray,
    starts: np.ndarray,
    preconditioner: np.ndarray,
    right: np.ndarray,
    solution: np.ndarray,
    tolerance: float,
    steps: int,
):
    """`_conjugate_gradients` for the four columns of `right`; solved columns no longer change."""
    count = len(right)
    residual, direction, product = np.empty((count, 4)), np.empty((count, 4)), np.empty((count, 4))
    right_norm2, energy, new_energy = np.zeros(4), np.zeros(4), np.zeros(4)
    residual_norm2, curvature, step, ratio = np.zeros(4), np.zeros(4), np.zeros(4), np.zeros(4)
    _multiply_four(data, indices, starts, solution, product)
    for i in range(count):
        for k in range(4):
            residual[i, k] = right[i, k] - product[i, k]
            direction[i, k] = preconditioner[i] * residual[i, k]
            energy[k] += residual[i, k] * direction[i, k]
            right_norm2[k] += right[i, k] * right[i, k]
    for _ in range(steps):
        _dot_four(residual, residual, residual_norm2)
        _multiply_four(data, indices, starts, direction, product)
        _dot_four(product, direction, curvature)
        running = False
        for k in range(4):
            step[k] = new_energy[k] = 0.0
            if residual_norm2[k] > tolerance * tolerance * right_norm2[k]:
                step[k], running = energy[k] / curvature[k], True
        if not running:
            return
        for i in range(count):
            for k in range(4):
                solution[i, k] += step[k] * direction[i, k]
                residual[i, k] -= step[k] * product[i, k]
                new_energy[k] += preconditioner[i] * residual[i, k] * residual[i, k]
        for k in range(4):
            ratio[k] = 0.0 if step[k] == 0.0 else new_energy[k] / energy[k]
            energy[k] = new_energy[k]
        for i in range(count):
            for k in range(4):
                direction[i, k] = preconditioner[i] * residual[i, k] + ratio[k] * direction[i, k]


@njit(cache=True, nogil=True)
def _multiply_four(
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
def _dot_four(one: np.ndarray, other: np.ndarray, dots: np.ndarray):
    """Fill the dot products of four columns with four others, summed row by row."""
    first = second = third = fourth = 0.0
    for i in range(len(one)):
        first += one[i, 0] * other[i, 0]
        second += one[i, 1] * other[i, 1]
        third += one[i, 2] * other[i, 2]
        fourth += one[i, 3] * other[i, 3]
    dots[0], dots[1], dots[2], dots[3] = first, second, third, fourth


_MIN_COTANGENT, _MAX_COTANGENT = 0.05, 5.0
_RIM_WEIGHT = 8.0
"""Weight that couples a rim vertex to its neighbours, in median vertex weights."""
_FOLD_CURVATURE = 0.25
"""Twice the mean curvature times the plate's length at which a fold is smoothed half as much."""
_FOLD_RINGS, _FOLD_FREE_RINGS = 2, 3
"""Rings over which the curvature of folds is averaged, and rings round rims and fills where no
folds are assumed: nothing there distinguishes a fold from an error."""


@dataclass(frozen=True, kw_only=True)
class ThinPlate:
    """Discrete operators of one mesh."""

    laplacian: sp.csr_matrix
    """(n, n), 1/mm^2; of the vertices it gives the mean curvature normal times two."""
    area_mm2: Float64[np.ndarray, " n"]
    """A third of the area of the faces round each vertex."""
    neighbours: sp.csr_matrix
    """(n, n) 1 where two vertices share an edge."""
    is_boundary: np.ndarray
    fold_curvature: Float64[np.ndarray, " n"]
    """Twice the mean curvature, 1/mm, averaged over rings: that of folds remains, noise cancels."""


def thin_plate_of(mesh: Mesh) -> ThinPlate:
    """The operators of a mesh: Laplacian, areas, adjacency and curvature of folds."""
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
        half = 0.5 * np.clip(cotangent, _MIN_COTANGENT, _MAX_COTANGENT)
        rows += [i, j]
        columns += [j, i]
        weights += [half, half]
    area = np.maximum(area, 0.02 * np.median(area))
    graph = sp.csr_matrix(
        (np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns))), (count, count)
    )
    laplacian = sp.diags(1 / area) @ (graph - sp.diags(np.asarray(graph.sum(1)).ravel()))
    laplacian, neighbours = sp.csr_matrix(laplacian), _adjacency(graph)
    is_boundary = boundary_vertices(faces, count)
    unreliable = is_boundary | ~mesh.measured
    curvature = np.einsum("ij,ij->i", mesh.vertex_normals(), laplacian @ vertices)
    return ThinPlate(
        laplacian=laplacian,
        area_mm2=area,
        neighbours=neighbours,
        is_boundary=is_boundary,
        fold_curvature=_fold_curvature(curvature, area, neighbours, unreliable),
    )


def _fold_curvature(
    curvature: Float64[np.ndarray, " n"],
    area: Float64[np.ndarray, " n"],
    neighbours: sp.csr_matrix,
    unreliable: np.ndarray,
) -> Float64[np.ndarray, " n"]:
    """Area-weighted mean of the curvature over rings; 0 near unreliable vertices."""
    ring = neighbours + sp.eye(len(curvature))
    total, area_sum, near = curvature * area, area, unreliable.astype(np.float64)
    for _ in range(_FOLD_RINGS):
        total, area_sum = ring @ total, ring @ area_sum
    for _ in range(_FOLD_FREE_RINGS):
        near = ring @ near
    return np.where(near > 0, 0.0, total / area_sum)


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
    bending energy of its own, moves as its neighbours do.

    Args:
        weights: information on each vertex, 1/mm^2; their median sets the coupling of rims.
        data: (n, n) normal matrix of the measurements, 1/mm^2.
        right: its right-hand side, 1/mm.
        stiffness: of a plate of this length (`stiffness_of`).
    """
    bending = bending_force(thin_plate, stiffness)
    system = (data + bending @ thin_plate.laplacian + _rim_coupling(thin_plate, weights)).tocsr()
    force = bending @ curvature_of(mesh, thin_plate, length_mm)
    return solve(system, right - force, right / np.maximum(weights, 1e-12))


def _rim_coupling(thin_plate: ThinPlate, weights: Float64[np.ndarray, " n"]) -> sp.csr_matrix:
    """(n, n) penalty on how far rim vertices' moves differ from the mean of their neighbours'."""
    rim = np.flatnonzero(thin_plate.is_boundary)
    rim_neighbours = thin_plate.neighbours[rim]
    mean = sp.diags(1 / np.asarray(rim_neighbours.sum(1)).ravel()) @ rim_neighbours
    selection = sp.csr_matrix((np.ones(len(rim)), (np.arange(len(rim)), rim)), rim_neighbours.shape)
    difference = sp.csr_matrix(selection - mean)
    return sp.csr_matrix(_RIM_WEIGHT * float(np.median(weights)) * (difference.T @ difference))


def stiffness_of(
    thin_plate: ThinPlate, density: float, length_mm: float
) -> Float64[np.ndarray, " n"]:
    """Stiffness at each vertex: length^4 * density * area, 0 at the rim.

    Where the data weigh `density` per area, 1/mm^4, the plate dominates at distances below
    `length_mm` and the data at longer ones.
    """
    return np.where(thin_plate.is_boundary, 0.0, length_mm**4 * density * thin_plate.area_mm2)


def bending_force(thin_plate: ThinPlate, stiffness: Float64[np.ndarray, " n"]) -> sp.csr_matrix:
    """(n, n) maps curvature to the bending force on each vertex; see `stiffness_of`."""
    return sp.csr_matrix(thin_plate.laplacian.T @ sp.diags(stiffness))


def bending_matrix(thin_plate: ThinPlate, stiffness: Float64[np.ndarray, " n"]) -> sp.csr_matrix:
    """(n, n) weighted bilaplacian: the matrix of the bending energy."""
    return bending_force(thin_plate, stiffness) @ thin_plate.laplacian


def curvature_of(mesh: Mesh, thin_plate: ThinPlate, length_mm: float) -> Float64[np.ndarray, " n"]:
    """Twice the mean curvature along the normal that a plate of this length smooths, 1/mm.

    It is negative where the surface is convex, and almost 0 in folds.
    """
    return _smoothed_part(_full_curvature(mesh, thin_plate), thin_plate, length_mm)


def _full_curvature(mesh: Mesh, thin_plate: ThinPlate) -> Float64[np.ndarray, " n"]:
    """Twice the mean curvature along the normal, 1/mm."""
    return np.einsum("ij,ij->i", mesh.vertex_normals(), thin_plate.laplacian @ mesh.vertices_mm)


def _smoothed_part(
    curvature: Float64[np.ndarray, " n"], thin_plate: ThinPlate, length_mm: float
) -> Float64[np.ndarray, " n"]:
    """What a plate of this length smooths of a curvature: all of it but that of folds."""
    return curvature / (1 + (thin_plate.fold_curvature * length_mm / _FOLD_CURVATURE) ** 4)


@dataclass(frozen=True, kw_only=True)
class PlainPlates:
    """Plates of any length on one surface under uniform data; what they share is computed once."""

    thin_plate: ThinPlate
    bending: sp.csr_matrix
    """Bending matrix of the plate of 1 mm."""
    curvature: Float64[np.ndarray, " n"]
    """Twice the mean curvature along the normal, 1/mm."""

    @classmethod
    def of(cls, mesh: Mesh, thin_plate: ThinPlate) -> "PlainPlates":
        """The plates on a mesh whose operators these are."""
        return cls(
            thin_plate=thin_plate,
            bending=bending_matrix(thin_plate, stiffness_of(thin_plate, 1.0, 1.0)),
            curvature=_full_curvature(mesh, thin_plate),
        )

    def removed(
        self, length_mm: float, heights: Sequence[Float64[np.ndarray, " n"]] = ()
    ) -> list[Float64[np.ndarray, " n"]]:
        """What the plate of that length removes from the surface, mm, and leaves of the heights."""
        thin_plate, area = self.thin_plate, self.thin_plate.area_mm2
        system = self.bending * length_mm**4
        system.setdiag(system.diagonal() + area)
        stiffness = stiffness_of(thin_plate, 1.0, length_mm)
        smoothed = _smoothed_part(self.curvature, thin_plate, length_mm)
        force = thin_plate.laplacian.T @ (stiffness * smoothed)
        return solve_all(system, [force, *(area * one for one in heights)])


def tangent_axes(normals: Points3) -> Float64[np.ndarray, "n 3 3"]:
    """Two tangents and the normal of each vertex as rows, right-handed."""
    helper = np.where(np.abs(normals[:, 2:3]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(helper, normals)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normals, first), normals], axis=1)


def _adjacency(matrix: sp.csr_matrix) -> sp.csr_matrix:
    """1 where the matrix stores an entry."""
    return sp.csr_matrix(
        (np.ones_like(matrix.data), matrix.indices, matrix.indptr), shape=matrix.shape
    )


def quadrics(
    mesh: Mesh, thin_plate: ThinPlate, axes: Float64[np.ndarray, "n 3 3"]
) -> Float64[np.ndarray, "n 3"]:
    """Curvature (uu, uv, vv), 1/mm, of the least-squares quadric of each vertex's 2-ring."""
    count = len(mesh)
    normal, right = np.zeros((count, 5, 5)), np.zeros((count, 5))
    _add_quadric_equations(
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
def _add_quadric_equations(
    starts: np.ndarray,
    neighbours: np.ndarray,
    vertices: np.ndarray,
    axes: np.ndarray,
    normal: np.ndarray,
    right: np.ndarray,
):
    """Fill the normal equations of slopes (2) and curvatures (3) over each vertex's 2-ring."""
    count = len(vertices)
    visited = np.full(count, -1, np.int32)
    terms = np.empty(5)
    for centre in range(count):
        visited[centre] = centre
        for near in range(starts[centre], starts[centre + 1]):
            ring = neighbours[near]
            for far in range(starts[ring], starts[ring + 1]):
                other = neighbours[far]
                if visited[other] == centre:
                    continue
                visited[other] = centre
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
