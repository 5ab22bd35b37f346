"""Creases: what the plate takes off folds with sharp valleys, which is alike all along them.

In      the measured surface, what the usual plate takes of it and where paint shows it.
Out     by vertex, one standard deviation of what is lost, with its sign: a source of error that
        all vertices share. A level that runs along a valley is wrong by the sum of it, which
        errors that are alike over two lengths of the plate alone do not tell.
Method  (1 - H)^2 H of the surface is averaged along its folds: solved with its slopes along them
        held, which leaves little of noise and of relief that goes all ways. What the median place
        has of its energy is taken off, so that only what stands out counts for a crease.
"""

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float64

from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.disagreement import DETAIL_RINGS, PAINTED, Pool
from limbgram.reconstruction.measuring.measurement_pass import JointEquations, SeenSurface
from limbgram.reconstruction.measuring.thin_plate import solve
from limbgram.reconstruction.measuring.usual_plate import ByUsualPlate

_ALONG_LENGTHS = 5.0
"""Lengths of the plate over which it is averaged along a fold: 10 mm where pixels are 0.7 mm."""
_LOST_PER_SEEN = 14.0
"""Depth that a sharp valley lost over what is seen of it so. Theory, a plate of 2 mm, folds like
|sin|^0.75: 9 where they lie 10 to 15 mm apart, 20 at 7 mm."""
_BY_SHARE = 0.25
"""Power of the plate's share of the usual stiffness that this goes with: half of the energy's."""
_MOST = 3.0
"""What stands out further over its neighbourhood is an oddity of the mesh."""
_SHOWN = 0.5
"""Signal near by from which paint shows a crease: more texture than noise holds the surface."""


def lost_creases_mm(
    mesh: Mesh, seen: SeenSurface, equations: JointEquations, usual: ByUsualPlate
) -> Float64[np.ndarray, " n"]:
    """What creases lost along the normal, one standard deviation, outward where they are ridges."""
    pool = Pool.of(seen.thin_plate, equations.photos)
    painted = pool.among(equations.signal > PAINTED)
    areas = sp.diags(seen.thin_plate.area_mm2)
    slopes = slopes_along_folds(mesh, usual.taken, pool)
    system = sp.csr_matrix(areas + (_ALONG_LENGTHS * equations.length_mm) ** 2 * slopes)
    of_folds = np.where(pool.counted, usual.taken - usual.again, 0.0)
    of_folds = solve(system, areas @ of_folds, of_folds)
    energy = painted.energy(of_folds**2, DETAIL_RINGS)
    everywhere = float(np.median(energy[painted.counted])) if painted.counted.any() else np.inf
    standing_out = 1 - everywhere / np.maximum(energy, np.finfo(float).tiny)
    shown = pool.counted & (pool.mean(equations.signal, DETAIL_RINGS) > _SHOWN)
    share = np.where(shown, np.sqrt(np.maximum(standing_out, 0.0)), 0.0)
    of_folds = np.clip(of_folds, -_MOST * np.sqrt(energy), _MOST * np.sqrt(energy))
    return _LOST_PER_SEEN * equations.stiffness_share**_BY_SHARE * share * of_folds


def slopes_along_folds(mesh: Mesh, lift: Float64[np.ndarray, " n"], pool: Pool) -> sp.csr_matrix:
    """(n, n) x'Kx: squared slope of x along the folds of `lift`, integrated over the surface."""
    hats, doubled = slopes_of_hats(mesh), np.linalg.norm(mesh.face_normals(), axis=1)
    steepest = np.linalg.eigh(products_of_slopes(mesh, lift, pool, DETAIL_RINGS))[1][:, :, 2]
    along = np.cross(mesh.vertex_normals(), steepest)
    along /= np.maximum(np.linalg.norm(along, axis=1), np.finfo(float).tiny)[:, None]
    # the mean of the corners' directions without their signs
    ways = np.einsum("fki,fkj->fij", along[mesh.faces], along[mesh.faces]) / 3
    blocks = np.einsum("fkd,fde,fle,f->fkl", hats, ways, hats, doubled / 2)
    rows, columns = np.repeat(mesh.faces, 3, axis=1).ravel(), np.tile(mesh.faces, (1, 3)).ravel()
    return sp.csr_matrix((blocks.ravel(), (rows, columns)), (len(mesh), len(mesh)))


def products_of_slopes(
    mesh: Mesh, lift: Float64[np.ndarray, " n"], pool: Pool, rings: int
) -> Float64[np.ndarray, "n 3 3"]:
    """Of the surface lifted by that, pooled: their largest eigenvector runs across folds."""
    doubled = np.linalg.norm(mesh.face_normals(), axis=1)
    slopes = np.einsum("fk,fkd->fd", lift[mesh.faces], slopes_of_hats(mesh))
    spread = np.einsum("fi,fj,f->fij", slopes, slopes, doubled).reshape(-1, 9)
    corner = mesh.faces.ravel()
    of_vertex = (np.bincount(corner, np.repeat(part, 3), len(mesh)) for part in spread.T)
    pooled = np.column_stack([pool.mean(one * pool.counted, rings) for one in of_vertex])
    return pooled.reshape(-1, 3, 3)


def slopes_of_hats(mesh: Mesh) -> Float64[np.ndarray, "f 3 3"]:
    """On each face, the slope of what is 1 at a corner and 0 at the two others; 1/mm."""
    normals = mesh.face_normals()
    corners = mesh.vertices_mm[mesh.faces]
    opposite = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    doubled = np.linalg.norm(normals, axis=1)
    over = np.maximum(doubled, np.finfo(float).tiny)[:, None, None] ** 2
    return np.cross(normals[:, None], opposite) / over
