"""Creases: the error from relief along folds that the thin plate has smoothed away.

In      the measured surface, what the reference plate removes from it and where paint shows it.
Out     by vertex, two shared sources of error, in quadrature. A section along a valley is wrong by
        the sum of what is lost in it, which exceeds what errors with a correlation length of two
        plate lengths add up to.
Method  The lost relief runs along folds as (1 - H)^2 H x does, which is observed. Theory gives its
        height but not its phase across the fold: a valley loses its depth, and the slopes beside it
        lose steepness. So what is observed is one source, and its quadrature across the folds the
        other. Detail is averaged along the folds, which suppresses noise and isotropic relief, and
        counts by the share of such energies that chance does not explain.
"""

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float64
from scipy.special import ndtr

from limbgram.core.mesh.mesh import Mesh, summed
from limbgram.reconstruction.measuring.anisotropic_plate import (
    dirichlet_matrix,
    hat_gradients,
    pooled_structure_tensors,
    structure_tensors,
)
from limbgram.reconstruction.measuring.disagreement import (
    DETAIL_RINGS,
    MIN_PAINTED_SIGNAL,
    MIN_TEXTURED_SIGNAL,
    NOISE_RINGS,
    Pool,
)
from limbgram.reconstruction.measuring.measurement_pass import JointEquations, ObservedSurface
from limbgram.reconstruction.measuring.reference_plate import ReferencePlateFit
from limbgram.reconstruction.measuring.thin_plate import solve

_SMOOTHING_LENGTHS = 5.0
"""Lengths of the plate over which detail is averaged along folds: 10 mm with pixels of 0.7 mm."""
_LOST_PER_OBSERVED = 42.0
"""Energy of folds that the reference plate lost over the observed one. Theory for folds like
|sin|^0.75 that lie 5 to 15 mm apart: 31, 41, 43 and 64 for plates of 1.5, 2, 2.2 and 2.5 mm."""
_STIFFNESS_EXPONENT = 0.5
"""Power with which this grows with the stiffness across folds over the reference one. Theory for
0.5, 0.36, 0.18 and 0.05: 0.81, 0.66, 0.48 and 0.19 of the energy; this power: 0.71, 0.6, 0.42
and 0.22."""
_MAX_OVER_POOLED = 3.0
"""Detail that exceeds the RMS of its neighbourhood by more than this factor is an outlier."""
_NULL_LOG_SIGMA = 0.58
"""Standard deviation of the logarithm of the energy along folds, over its median, where there are
no folds: on sheets of noise, or of isotropic relief, 75, 90, 95 and 99 % of the vertices lie below
1.47, 2.1, 2.6 and 4.0, as a log-normal distribution predicts (1.48, 2.1, 2.6, 3.9)."""


def lost_creases_mm(
    mesh: Mesh, observed: ObservedSurface, equations: JointEquations, reference: ReferencePlateFit
) -> Float64[np.ndarray, "n 2"]:
    """Standard deviations, along the normal, of the two sources of error from lost creases."""
    pool = Pool.of(observed.thin_plate, equations.photo_count)
    painted = pool.restricted_to(equations.signal > MIN_PAINTED_SIGNAL)
    areas = sp.diags(observed.thin_plate.area_mm2)
    tensors = structure_tensors(mesh, reference.removed)
    tensors = pooled_structure_tensors(mesh, tensors, pool, DETAIL_RINGS)
    steepest = _sign_aligned(np.linalg.eigh(tensors)[1][:, :, 2])
    along = np.cross(mesh.vertex_normals(), steepest)
    along /= np.maximum(np.linalg.norm(along, axis=1), np.finfo(float).tiny)[:, None]
    # Tensors average the corners' directions regardless of sign.
    direction_tensors = np.einsum("fki,fkj->fij", along[mesh.faces], along[mesh.faces]) / 3
    smoothing_mm = _SMOOTHING_LENGTHS * equations.length_mm
    system = areas + smoothing_mm**2 * dirichlet_matrix(mesh, direction_tensors)
    detail = np.where(pool.counted, reference.removed - reference.removed_smoothed, 0.0)
    along_folds = solve(sp.csr_matrix(system), areas @ detail, detail)
    energy = painted.energy(along_folds**2, DETAIL_RINGS)
    typical_energy = float(np.median(energy[painted.counted])) if painted.counted.any() else np.inf
    energy_ratio = energy / max(typical_energy, np.finfo(float).tiny)
    textured = pool.counted & (pool.mean(equations.signal, DETAIL_RINGS) > MIN_TEXTURED_SIGNAL)
    share = np.where(textured, _true_discovery_share(energy_ratio, painted.counted), 0.0)
    limit = _MAX_OVER_POOLED * np.sqrt(pool.energy(detail**2, DETAIL_RINGS))
    sources = np.column_stack([detail, _quadrature(mesh, observed, detail, steepest, pool)])
    sources = np.clip(sources, -limit[:, None], limit[:, None])
    stiffness_across = equations.stiffness_share * equations.cross_grain_factor**2
    lost_per_observed = _LOST_PER_OBSERVED * stiffness_across**_STIFFNESS_EXPONENT
    return np.sqrt(lost_per_observed * share / 2)[:, None] * sources


def _true_discovery_share(
    energy_ratio: Float64[np.ndarray, " n"], counted: Bool[np.ndarray, " n"]
) -> Float64[np.ndarray, " n"]:
    """Share of the vertices with at least each energy ratio that chance does not explain.

    One minus the tail area false discovery rate (Efron 2007, Annals of Statistics 35:1351-1377).
    """
    null_tail = ndtr(-np.log(np.maximum(energy_ratio, np.finfo(float).tiny)) / _NULL_LOG_SIGMA)
    known = np.sort(energy_ratio[counted])
    observed_tail = 1 - np.searchsorted(known, energy_ratio, side="left") / max(len(known), 1)
    return np.clip(1 - null_tail / np.maximum(observed_tail, 1 / max(len(known), 1)), 0.0, 1.0)


def _quadrature(
    mesh: Mesh,
    observed: ObservedSurface,
    detail: Float64[np.ndarray, " n"],
    steepest: Float64[np.ndarray, "n 3"],
    pool: Pool,
) -> Float64[np.ndarray, " n"]:
    """The detail shifted by a quarter wave: its slope across the folds, of the same energy."""
    slopes = np.einsum("fk,fkd->fd", detail[mesh.faces], hat_gradients(mesh))
    doubled = np.linalg.norm(mesh.face_normals(), axis=1)
    slopes = summed(slopes * doubled[:, None] / 6, mesh.faces, len(mesh))
    across = np.einsum("ni,ni->n", slopes, steepest) / observed.thin_plate.area_mm2
    across = np.where(pool.counted, across, 0.0)
    slope_energy = np.maximum(pool.energy(across**2, NOISE_RINGS), np.finfo(float).tiny)
    return across * np.sqrt(pool.energy(detail**2, NOISE_RINGS) / slope_energy)


def _sign_aligned(directions: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, "n 3"]:
    """Directions with signs that agree with their main direction."""
    main = np.linalg.eigh(directions.T @ directions)[1][:, 2]
    return np.where(directions @ main < 0, -1.0, 1.0)[:, None] * directions
