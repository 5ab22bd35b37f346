"""The usual plate: what it takes off surface and noise, and whether it is stiffer than fits.

In      the measured surface, what the photos see of it and the equations of its last round.
Out     what the usual plate takes, by which relief and noise are told however soft the plate was
        that measured; equations with a plate that fits.
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
    """The surface x and sums of the photos' pulls, as the usual plate with its response H has them.

    A softer plate leaves more of both; the usual one takes that off again.
    """

    surface: Mesh
    taken: Float64[np.ndarray, " n"]
    """(1 - H) of the surface, mm."""
    again: Float64[np.ndarray, " n"]
    """H (1 - H) of it."""
    probes: list[Float64[np.ndarray, " n"]]
    """What sums of pulls move the surface by."""
    kept: list[Float64[np.ndarray, " n"]]
    """H of those."""


def by_usual_plate(mesh: Mesh, seen: SeenSurface, equations: JointEquations) -> ByUsualPlate:
    """What the usual plate makes of the surface that these equations measured."""
    share, thin_plate = equations.stiffness_share, seen.thin_plate
    bending = bending_of(thin_plate, equations.stiffness / share)
    system = sp.csr_matrix(equations.held + bending @ thin_plate.laplacian)
    flattening = bending @ curvature_of(mesh, thin_plate, equations.length_mm)
    taken, *probes = solve_all(system, [flattening, *pulls_of(mesh, seen, equations)])
    surface = mesh
    if share < 1:
        more = (1 - share) * taken
        surface = mesh.with_vertices(mesh.vertices_mm - more[:, None] * seen.axes[:, 2])
        (left,) = solve_all(system, [equations.held @ more])
        taken = taken - more + left
    again, *kept = solve_all(system, [equations.held @ one for one in (taken, *probes)])
    return ByUsualPlate(surface=surface, taken=taken, again=again, probes=probes, kept=kept)


def softened(mesh: Mesh, seen: SeenSurface, equations: JointEquations) -> JointEquations:
    """The equations with the plate that fits a surface which they have measured; never stiffer."""
    ratio = relief_over_noise(mesh, seen, equations)
    if ratio <= _SURELY:
        return equations
    share = _SURELY / ratio
    return replace(equations, stiffness=share * equations.stiffness, stiffness_share=share)


def relief_over_noise(mesh: Mesh, seen: SeenSurface, equations: JointEquations) -> float:
    """Energy of relief over that of noise in (1 - H) H x, where paint shows it; 0 of nothing."""
    told = Pool.of(seen.thin_plate, equations.photos).among(equations.signal > PAINTED).counted
    found = by_usual_plate(mesh, seen, equations)
    alone = np.sqrt(times_unseen(equations.photos)[told])
    noise = sum(
        usual_square(alone * (probe - kept)[told])
        for probe, kept in zip(found.probes, found.kept, strict=True)
    )
    return usual_square(found.taken[told]) * PROBES / noise - 1 if noise > 0 else 0.0
