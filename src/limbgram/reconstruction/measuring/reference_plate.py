"""Reference plate: how much it attenuates surface and noise, and whether it is too stiff.

In      the surface that the reference plate measured, what the photos see of it, the equations.
Out     what that plate removes, from which relief and noise are estimated whichever plate measures
        in the end; equations with a plate that fits.
Method  A plate with the response H fits where relief and noise have the same energy in (1 - H) H x:
        a softer plate then adds as much noise as it restores relief. The ratio of the two falls
        about as the stiffness does (for relief whose height grows with the power 0.7 of its length,
        as the power 0.85 of it). The plate is never made stiffer: where little is painted,
        correlated errors of the photos cannot be separated from relief.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float64

from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.disagreement import (
    MIN_PAINTED_SIGNAL,
    PROBES,
    Pool,
    error_over_disagreement,
    probe_right_sides,
    robust_mean_square,
)
from limbgram.reconstruction.measuring.measurement_pass import JointEquations, ObservedSurface
from limbgram.reconstruction.measuring.thin_plate import bending_force, curvature_of, solve_all

_SOFTEN_FROM_RATIO = 1.26
"""Ratio of relief to noise from which the plate is softened: six photos whose errors correlate by
0.2 (0.05 to 0.2 were found, 0.14 is assumed) have 1.26 times the noise."""


@dataclass(frozen=True, kw_only=True)
class ReferencePlateFit:
    """What the reference plate, of response H, measured (x with its noise) and removes from it."""

    surface: Mesh
    removed: Float64[np.ndarray, " n"]
    """(1 - H) of the surface, mm."""
    removed_smoothed: Float64[np.ndarray, " n"]
    """H (1 - H) of the surface, mm."""
    probes: list[Float64[np.ndarray, " n"]]
    """Solutions of the random-sign right-hand sides, mm."""
    smoothed_probes: list[Float64[np.ndarray, " n"]]
    """H of the probes."""


def fit_reference_plate(
    mesh: Mesh, observed: ObservedSurface, equations: JointEquations
) -> ReferencePlateFit:
    """The response of the reference plate on the surface that it measured with these equations."""
    bending = bending_force(observed.thin_plate, equations.stiffness)
    system = sp.csr_matrix(equations.texture_hessian + bending @ observed.thin_plate.laplacian)
    force = bending @ curvature_of(mesh, observed.thin_plate, equations.length_mm)
    removed, *probes = solve_all(system, [force, *probe_right_sides(mesh, observed, equations)])
    removed_smoothed, *smoothed_probes = solve_all(
        system, [equations.texture_hessian @ heights for heights in (removed, *probes)]
    )
    return ReferencePlateFit(
        surface=mesh,
        removed=removed,
        removed_smoothed=removed_smoothed,
        probes=probes,
        smoothed_probes=smoothed_probes,
    )


def with_softer_plate(
    observed: ObservedSurface, equations: JointEquations, reference: ReferencePlateFit
) -> JointEquations:
    """The equations with a plate that fits the surface, no stiffer than the reference plate."""
    ratio = relief_over_noise(observed, equations, reference)
    if ratio <= _SOFTEN_FROM_RATIO:
        return equations
    share = _SOFTEN_FROM_RATIO / ratio
    return replace(equations, stiffness=share * equations.stiffness, stiffness_share=share)


def relief_over_noise(
    observed: ObservedSurface, equations: JointEquations, reference: ReferencePlateFit
) -> float:
    """Energy of relief over that of noise in (1 - H) H x at painted vertices; 0 of none."""
    pool = Pool.of(observed.thin_plate, equations.photo_count)
    painted = pool.restricted_to(equations.signal > MIN_PAINTED_SIGNAL).counted
    error_factor = np.sqrt(error_over_disagreement(equations.photo_count)[painted])
    noise = sum(
        robust_mean_square(error_factor * (probe - smoothed)[painted])
        for probe, smoothed in zip(reference.probes, reference.smoothed_probes, strict=True)
    )
    return robust_mean_square(reference.removed[painted]) * PROBES / noise - 1 if noise > 0 else 0.0
