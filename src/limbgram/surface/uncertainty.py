"""Uncertainty: the sigma of a figure taken from a surface, from the sigmas of its vertices."""

import math

import numpy as np
from jaxtyping import Float64

from limbgram.surface.mesh import Mesh


def propagate(mesh: Mesh, gradient: Float64[np.ndarray, " n"]) -> float | None:
    """Standard deviation of a figure; None where the mesh carries no sigmas.

    gradient: change of the figure for one millimetre of each vertex along its outward normal.
    Errors that all vertices share add up; the rest is taken as independent beyond
    `correlation_mm`.
    """
    if mesh.sigma_mm is None:
        return None
    touched = np.flatnonzero(gradient)
    local_mm = np.nan_to_num(mesh.sigma_mm[touched].astype(np.float64))
    return math.sqrt(float(np.sum((gradient[touched] * local_mm) ** 2)))
