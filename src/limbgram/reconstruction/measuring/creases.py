"""Creases: restores relief along folds that the thin plate has smoothed away.

In      the measured surface, what the usual plate takes of it and where paint shows it.
Out     by vertex, two sources of error that all vertices share, a quarter of a wave apart. A level
        that runs along a valley is wrong by the sum of what is lost in it, which errors that are
        alike over two lengths of the plate alone do not tell.
Method  What is lost lies along folds as (1 - H)^2 H x does, which is seen; how high it is follows
        from theory, where along the fold's profile does not: a valley loses its depth, and the
        slopes beside it lose what makes them steep. So what is seen is one source, and the same
        turned by a quarter of a wave across the folds the other. Only what stands out counts,
        averaged along its folds, which leaves little of noise and of relief that runs all ways; and
        of places that stand out, as many as chance alone does not let stand out so far.
"""

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float64
from scipy.special import ndtr

from limbgram.core.mesh.mesh import Mesh, summed
from limbgram.reconstruction.measuring.disagreement import (
    DETAIL_RINGS,
    NOISE_RINGS,
    PAINTED,
    SHOWN,
    Pool,
)
from limbgram.reconstruction.measuring.grain import (
    integrated_slopes,
    pooled_products,
    products_of_slopes,
    slopes_of_hats,
)
from limbgram.reconstruction.measuring.measurement_pass import JointEquations, SeenSurface
from limbgram.reconstruction.measuring.thin_plate import solve
from limbgram.reconstruction.measuring.usual_plate import ByUsualPlate

_ALONG_LENGTHS = 5.0
"""Lengths of the plate over which it is averaged along a fold: 10 mm where pixels are 0.7 mm."""
_LOST_PER_SEEN = 42.0
"""Energy that the usual plate lost of folds over that of what is seen of them. Theory, folds like
|sin|^0.75 that lie 5 to 15 mm apart: 31, 41, 43 and 64 for plates of 1.5, 2, 2.2 and 2.5 mm."""
_BY_SHARE = 0.5
"""Power of the share of the usual stiffness across the folds that this goes with. Theory for shares
of 0.5, 0.36, 0.18 and 0.05: 0.81, 0.66, 0.48 and 0.19 of the energy; this power: 0.71, 0.6, 0.42
and 0.22."""
_MOST = 3.0
"""What stands out further over its neighbourhood is an oddity of the mesh."""
_BY_CHANCE = 0.58
"""Standard deviation of the logarithm of the energy along folds over that of the median place where
there are none: on sheets of noise, or of relief of all ways, 75, 90, 95 and 99 % of the places lie
below 1.47, 2.1, 2.6 and 4.0, which a log-normal distribution says too (1.48, 2.1, 2.6, 3.9)."""


def lost_creases_mm(
    mesh: Mesh, seen: SeenSurface, equations: JointEquations, usual: ByUsualPlate
) -> Float64[np.ndarray, "n 2"]:
    """What creases lost along the normal: two sources, one standard deviation of each."""
    pool = Pool.of(seen.thin_plate, equations.photos)
    painted = pool.among(equations.signal > PAINTED)
    areas = sp.diags(seen.thin_plate.area_mm2)
    products = pooled_products(mesh, products_of_slopes(mesh, usual.taken), pool, DETAIL_RINGS)
    steepest = _one_sided(np.linalg.eigh(products)[1][:, :, 2])
    along = np.cross(mesh.vertex_normals(), steepest)
    along /= np.maximum(np.linalg.norm(along, axis=1), np.finfo(float).tiny)[:, None]
    # the mean of the corners' directions without their signs
    ways = np.einsum("fki,fkj->fij", along[mesh.faces], along[mesh.faces]) / 3
    system = areas + (_ALONG_LENGTHS * equations.length_mm) ** 2 * integrated_slopes(mesh, ways)
    lifted = np.where(pool.counted, usual.taken - usual.again, 0.0)
    of_folds = solve(sp.csr_matrix(system), areas @ lifted, lifted)
    energy = painted.energy(of_folds**2, DETAIL_RINGS)
    everywhere = float(np.median(energy[painted.counted])) if painted.counted.any() else np.inf
    stands_out = energy / max(everywhere, np.finfo(float).tiny)
    shown = pool.counted & (pool.mean(equations.signal, DETAIL_RINGS) > SHOWN)
    share = np.where(shown, _folded_share(stands_out, painted.counted), 0.0)
    most = _MOST * np.sqrt(pool.energy(lifted**2, DETAIL_RINGS))
    waves = np.column_stack([lifted, _turned(mesh, seen, lifted, steepest, pool)])
    waves = np.clip(waves, -most[:, None], most[:, None])
    per_seen = _LOST_PER_SEEN * (equations.stiffness_share * equations.across**2) ** _BY_SHARE
    return np.sqrt(per_seen * share / 2)[:, None] * waves


def _folded_share(
    stands_out: Float64[np.ndarray, " n"], counted: Bool[np.ndarray, " n"]
) -> Float64[np.ndarray, " n"]:
    """Of the places that stand out as far as each, the share that chance does not explain.

    One less the tail area false discovery rate (Efron 2007, Annals of Statistics 35:1351-1377).
    """
    by_chance = ndtr(-np.log(np.maximum(stands_out, np.finfo(float).tiny)) / _BY_CHANCE)
    known = np.sort(stands_out[counted])
    found = 1 - np.searchsorted(known, stands_out, side="left") / max(len(known), 1)
    return np.clip(1 - by_chance / np.maximum(found, 1 / max(len(known), 1)), 0.0, 1.0)


def _turned(
    mesh: Mesh,
    seen: SeenSurface,
    lifted: Float64[np.ndarray, " n"],
    steepest: Float64[np.ndarray, "n 3"],
    pool: Pool,
) -> Float64[np.ndarray, " n"]:
    """A quarter of a wave on: the slope across the folds, as high as the waves themselves."""
    slopes = np.einsum("fk,fkd->fd", lifted[mesh.faces], slopes_of_hats(mesh))
    doubled = np.linalg.norm(mesh.face_normals(), axis=1)
    slopes = summed(slopes * doubled[:, None] / 6, mesh.faces, len(mesh))
    across = np.einsum("ni,ni->n", slopes, steepest) / seen.thin_plate.area_mm2
    across = np.where(pool.counted, across, 0.0)
    steep = np.maximum(pool.energy(across**2, NOISE_RINGS), np.finfo(float).tiny)
    return across * np.sqrt(pool.energy(lifted**2, NOISE_RINGS) / steep)


def _one_sided(ways: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, "n 3"]:
    """Directions with the signs that make them look the way most of them do."""
    main = np.linalg.eigh(ways.T @ ways)[1][:, 2]
    return np.where(ways @ main < 0, -1.0, 1.0)[:, None] * ways
