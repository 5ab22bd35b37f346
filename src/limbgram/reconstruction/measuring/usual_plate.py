"""Usual plate: how much it attenuates surface and noise, and whether it is too stiff.

In      the surface as the usual plate measured it, what the photos see of it and the equations.
Out     what that plate takes, by which relief and noise are told whichever plate measures in the
        end; equations with a plate that fits.
Method  A plate with the response H fits where relief and noise have the same energy in (1 - H) H x:
        there, what a softer plate adds of noise is what it gives back of relief. The ratio of the
        two falls about as the stiffness does (relief whose height grows with the power 0.7 of its
        length: as the power 0.85 of it). The plate is never made stiffer: where little is painted,
        what photos get wrong alike is not told from relief.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float64

from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.disagreement import (
    PAINTED,
    PROBES,
    Pool,
    pulls_of,
    times_unseen,
    usual_square,
)
from limbgram.reconstruction.measuring.measurement_pass import JointEquations, SeenSurface
from limbgram.reconstruction.measuring.thin_plate import bending_of, curvature_of, solve_all

_SURELY = 1.26
"""Ratio of relief to noise from which the plate is softened: six photos whose errors are as alike
as 0.2 (0.05 to 0.2 were found, 0.14 is taken) have 1.26 times the noise."""


@dataclass(frozen=True, kw_only=True)
class ByUsualPlate:
    """What the usual plate, whose response is H, measured (x with its noise) and takes of it."""

    surface: Mesh
    taken: Float64[np.ndarray, " n"]
    """(1 - H) of the surface, mm."""
    again: Float64[np.ndarray, " n"]
    """H (1 - H) of it."""
    probes: list[Float64[np.ndarray, " n"]]
    """What sums of the photos' pulls move the surface by."""
    kept: list[Float64[np.ndarray, " n"]]
    """H of those."""


def by_usual_plate(mesh: Mesh, seen: SeenSurface, equations: JointEquations) -> ByUsualPlate:
    """What the usual plate makes of the surface that it measured with these equations."""
    bending = bending_of(seen.thin_plate, equations.stiffness)
    system = sp.csr_matrix(equations.held + bending @ seen.thin_plate.laplacian)
    flattening = bending @ curvature_of(mesh, seen.thin_plate, equations.length_mm)
    taken, *probes = solve_all(system, [flattening, *pulls_of(mesh, seen, equations)])
    again, *kept = solve_all(system, [equations.held @ one for one in (taken, *probes)])
    return ByUsualPlate(surface=mesh, taken=taken, again=again, probes=probes, kept=kept)


def softened(seen: SeenSurface, equations: JointEquations, usual: ByUsualPlate) -> JointEquations:
    """The equations with a plate as stiff as fits a surface which they have measured; no stiffer
    than the usual one."""
    ratio = relief_over_noise(seen, equations, usual)
    if ratio <= _SURELY:
        return equations
    share = _SURELY / ratio
    return replace(equations, stiffness=share * equations.stiffness, stiffness_share=share)


def relief_over_noise(seen: SeenSurface, equations: JointEquations, usual: ByUsualPlate) -> float:
    """Energy of relief over that of noise in (1 - H) H x, where paint shows it; 0 of nothing."""
    told = Pool.of(seen.thin_plate, equations.photos).among(equations.signal > PAINTED).counted
    alone = np.sqrt(times_unseen(equations.photos)[told])
    noise = sum(
        usual_square(alone * (probe - kept)[told])
        for probe, kept in zip(usual.probes, usual.kept, strict=True)
    )
    return usual_square(usual.taken[told]) * PROBES / noise - 1 if noise > 0 else 0.0
