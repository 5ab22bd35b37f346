"""Anisotropic plate: stiffer along the grain of the relief, its folds, than across it.

In      a measured surface and what the reference plate removes from it.
Out     the equations with a plate that follows the grain: parallel folds keep their valleys, and
        as much noise is suppressed as before.
Method  A thin plate is the prior of isotropic relief. Relief that is steeper across folds than
        along them becomes isotropic once it is stretched along its steepest direction; the plate
        stretched back has a Laplacian div(A grad), A being the inverse of the relief's structure
        tensor, scaled to the determinant 1. Structure tensors are those of (1 - H) H x, pooled.
        They include noise, which is isotropic: the less relief exceeds it, the less anisotropic the
        plate. Where no paint shows the relief, it is assumed to be isotropic.
"""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float64

from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.disagreement import MIN_TEXTURED_SIGNAL, NOISE_RINGS, Pool
from limbgram.reconstruction.measuring.measurement_pass import JointEquations, ObservedSurface
from limbgram.reconstruction.measuring.reference_plate import ReferencePlateFit
from limbgram.reconstruction.measuring.thin_plate import ThinPlate

_MAX_ANISOTROPY = 16.0
"""Squared slope across over that along, at most: the plate keeps some stiffness across folds."""


def with_anisotropic_plate(
    observed: ObservedSurface, equations: JointEquations, reference: ReferencePlateFit
) -> JointEquations:
    """The equations with a plate that follows the grain of the reference plate's surface."""
    mesh = reference.surface
    pool = Pool.of(observed.thin_plate, equations.photo_count).restricted_to(
        equations.signal > MIN_TEXTURED_SIGNAL
    )
    products = structure_tensors(mesh, reference.removed)
    tensors = pooled_structure_tensors(mesh, products, pool, NOISE_RINGS)
    tangents, painted = observed.axes[:, :2], pool.counted_shares[NOISE_RINGS]
    tensors = np.einsum("nai,nij,nbj->nab", tangents, tensors, tangents)
    mean_square_slope = np.einsum("naa->", tensors) / max(float(painted.sum()), 1.0) / 2
    tensors += ((1 - painted) * mean_square_slope)[:, None, None] * np.eye(2)
    eigenvalues, directions = np.linalg.eigh(tensors)
    largest = np.maximum(eigenvalues[:, 1], 0.0)
    smallest = np.clip(eigenvalues[:, 0], largest / _MAX_ANISOTROPY, None)
    ratio = smallest / np.maximum(largest, np.finfo(float).tiny)
    factor = np.where(largest > 0, np.sqrt(ratio), 1.0)
    steepest = np.einsum("na,nai->ni", directions[:, :, 1], tangents)
    laplacian = _anisotropic_laplacian(mesh, observed.thin_plate, steepest, factor)
    return replace(
        equations,
        plate=replace(observed.thin_plate, laplacian=laplacian),
        cross_grain_factor=factor,
    )


def _anisotropic_laplacian(
    mesh: Mesh,
    thin_plate: ThinPlate,
    steepest: Float64[np.ndarray, "n 3"],
    cross_grain_factor: Float64[np.ndarray, " n"],
) -> sp.csr_matrix:
    """(n, n) div(A grad), 1/mm^2: A has the factor across the folds and its inverse along them."""
    along = np.cross(mesh.vertex_normals(), steepest)
    along /= np.maximum(np.linalg.norm(along, axis=1), np.finfo(float).tiny)[:, None]
    tensor = np.einsum("n,ni,nj->nij", cross_grain_factor, steepest, steepest)
    tensor += np.einsum("n,ni,nj->nij", 1 / cross_grain_factor, along, along)
    matrix = dirichlet_matrix(mesh, tensor[mesh.faces].mean(axis=1))
    return sp.csr_matrix(sp.diags(-1 / thin_plate.area_mm2) @ matrix)


def dirichlet_matrix(mesh: Mesh, tensor: Float64[np.ndarray, "f 3 3"]) -> sp.csr_matrix:
    """(n, n) K of the energy x'Kx: (grad x)' A (grad x) integrated, A being each face's tensor."""
    gradients, doubled = hat_gradients(mesh), np.linalg.norm(mesh.face_normals(), axis=1)
    blocks = np.einsum("fkd,fde,fle,f->fkl", gradients, tensor, gradients, doubled / 2)
    rows, columns = np.repeat(mesh.faces, 3, axis=1).ravel(), np.tile(mesh.faces, (1, 3)).ravel()
    return sp.csr_matrix((blocks.ravel(), (rows, columns)), (len(mesh), len(mesh)))


def structure_tensors(mesh: Mesh, lift: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, "f 3 3"]:
    """Outer products of the gradient of `lift` on each face."""
    gradients = np.einsum("fk,fkd->fd", lift[mesh.faces], hat_gradients(mesh))
    return np.einsum("fi,fj->fij", gradients, gradients)


def pooled_structure_tensors(
    mesh: Mesh, products: Float64[np.ndarray, "f 3 3"], pool: Pool, rings: int
) -> Float64[np.ndarray, "n 3 3"]:
    """Area-weighted means over so many rings of counted vertices.

    The eigenvector of the largest eigenvalue runs across folds.
    """
    doubled = np.linalg.norm(mesh.face_normals(), axis=1)
    columns = np.repeat((products * doubled[:, None, None]).reshape(-1, 9), 3, axis=0)
    corner = mesh.faces.ravel()
    of_vertex = np.column_stack([np.bincount(corner, values, len(mesh)) for values in columns.T])
    return pool.mean(of_vertex * pool.counted[:, None], rings).reshape(-1, 3, 3)


def hat_gradients(mesh: Mesh) -> Float64[np.ndarray, "f 3 3"]:
    """Gradients of the linear hat functions of each face's corners, 1/mm."""
    normals = mesh.face_normals()
    corners = mesh.vertices_mm[mesh.faces]
    opposite = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    doubled = np.linalg.norm(normals, axis=1)
    doubled2 = np.maximum(doubled, np.finfo(float).tiny)[:, None, None] ** 2
    return np.cross(normals[:, None], opposite) / doubled2
