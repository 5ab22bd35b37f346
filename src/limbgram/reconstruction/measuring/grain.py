"""Grain: the direction of relief, and an anisotropic plate that is stiffer along it than across.

In      a measured surface and what the usual plate takes of it.
Out     the equations with a plate that follows the grain: folds that lie side by side keep their
        valleys, and as much noise is held back as before.
Method  A plate is the prior of relief that runs all ways. Relief whose squared slope is more across
        folds than along them runs all ways once it is stretched along its steepest direction, and
        the plate stretched back has a Laplacian div(A grad), A being the inverse of the relief's
        products of slopes, scaled to the determinant 1. Those are taken of (1 - H) H x and pooled.
        Noise, which runs all ways, is in them: the less relief stands out of it, the less the plate
        leans. So it does where no paint shows the relief: there it is taken to run all ways.
"""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float64

from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.disagreement import NOISE_RINGS, SHOWN, Pool
from limbgram.reconstruction.measuring.measurement_pass import JointEquations, SeenSurface
from limbgram.reconstruction.measuring.thin_plate import ThinPlate
from limbgram.reconstruction.measuring.usual_plate import ByUsualPlate

_MOST_STEEPER = 16.0
"""Squared slope across over that along, at most: a plate may not give way altogether."""


def grained(seen: SeenSurface, equations: JointEquations, usual: ByUsualPlate) -> JointEquations:
    """The equations with a plate that follows the grain of what the usual one measured."""
    mesh = usual.surface
    pool = Pool.of(seen.thin_plate, equations.photos).among(equations.signal > SHOWN)
    products = products_of_slopes(mesh, usual.taken)
    relief = pooled_products(mesh, products, pool, NOISE_RINGS)
    flat, painted = seen.axes[:, :2], pool.shares[NOISE_RINGS]
    relief = np.einsum("nai,nij,nbj->nab", flat, relief, flat)
    usually = np.einsum("naa->", relief) / max(float(painted.sum()), 1.0) / 2
    relief += ((1 - painted) * usually)[:, None, None] * np.eye(2)
    squares, ways = np.linalg.eigh(relief)
    most = np.maximum(squares[:, 1], 0.0)
    least = np.clip(squares[:, 0], most / _MOST_STEEPER, None)
    across = np.where(most > 0, np.sqrt(least / np.maximum(most, np.finfo(float).tiny)), 1.0)
    steepest = np.einsum("na,nai->ni", ways[:, :, 1], flat)
    return replace(
        equations,
        plate=replace(seen.thin_plate, laplacian=_leaning(mesh, seen.thin_plate, steepest, across)),
        across=across,
    )


def _leaning(
    mesh: Mesh,
    thin_plate: ThinPlate,
    steepest: Float64[np.ndarray, "n 3"],
    across: Float64[np.ndarray, " n"],
) -> sp.csr_matrix:
    """(n, n) div(A grad), 1/mm^2: A has `across` along the steepest way and its inverse beside."""
    beside = np.cross(mesh.vertex_normals(), steepest)
    beside /= np.maximum(np.linalg.norm(beside, axis=1), np.finfo(float).tiny)[:, None]
    lean = np.einsum("n,ni,nj->nij", across, steepest, steepest)
    lean += np.einsum("n,ni,nj->nij", 1 / across, beside, beside)
    slopes = integrated_slopes(mesh, lean[mesh.faces].mean(axis=1))
    return sp.csr_matrix(sp.diags(-1 / thin_plate.area_mm2) @ slopes)


def integrated_slopes(mesh: Mesh, lean: Float64[np.ndarray, "f 3 3"]) -> sp.csr_matrix:
    """(n, n) x'Kx: (grad x)' A (grad x) integrated over the surface, A being `lean` of a face."""
    hats, doubled = slopes_of_hats(mesh), np.linalg.norm(mesh.face_normals(), axis=1)
    blocks = np.einsum("fkd,fde,fle,f->fkl", hats, lean, hats, doubled / 2)
    rows, columns = np.repeat(mesh.faces, 3, axis=1).ravel(), np.tile(mesh.faces, (1, 3)).ravel()
    return sp.csr_matrix((blocks.ravel(), (rows, columns)), (len(mesh), len(mesh)))


def products_of_slopes(mesh: Mesh, lift: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, "f 3 3"]:
    """Of each face of the surface lifted by that."""
    slopes = np.einsum("fk,fkd->fd", lift[mesh.faces], slopes_of_hats(mesh))
    return np.einsum("fi,fj->fij", slopes, slopes)


def pooled_products(
    mesh: Mesh, products: Float64[np.ndarray, "f 3 3"], pool: Pool, rings: int
) -> Float64[np.ndarray, "n 3 3"]:
    """Summed over so many rings of what is counted, by area: the largest eigenvector runs across
    folds."""
    doubled = np.linalg.norm(mesh.face_normals(), axis=1)
    columns = np.repeat((products * doubled[:, None, None]).reshape(-1, 9), 3, axis=0)
    corner = mesh.faces.ravel()
    of_vertex = np.column_stack([np.bincount(corner, one, len(mesh)) for one in columns.T])
    return pool.mean(of_vertex * pool.counted[:, None], rings).reshape(-1, 3, 3)


def slopes_of_hats(mesh: Mesh) -> Float64[np.ndarray, "f 3 3"]:
    """On each face, the slope of what is 1 at a corner and 0 at the two others; 1/mm."""
    normals = mesh.face_normals()
    corners = mesh.vertices_mm[mesh.faces]
    opposite = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    doubled = np.linalg.norm(normals, axis=1)
    over = np.maximum(doubled, np.finfo(float).tiny)[:, None, None] ** 2
    return np.cross(normals[:, None], opposite) / over
