"""Sigma: one standard deviation along the normal for every measured vertex.

The sum of local errors (noise, lost detail) and of shared ones (cameras, scale). It speaks of the
shape: where the surface as a whole lies in the world is not part of it.
"""

from dataclasses import replace

import numpy as np

from limbgram.measuring.rounds import JointEquations, Sight
from limbgram.measuring.uncertainty.local import local_errors
from limbgram.measuring.uncertainty.shared import shared_errors
from limbgram.scale.metric import MetricScene
from limbgram.surface.mesh import Mesh

SCALE, CAMERAS, OFFSET = "scale", "cameras and lens", "offset of the whole surface"
"""Sources of what all vertices share, as `Mesh.shared_sources` has them."""
_OFFSET_PX = 0.0045
"""How far the whole surface may lie in or out by the way photos are sampled, in pixels: volumes of
53 small captures (seeds 6000 to 7088) say -0.007 px for thighs, -0.003 for shanks and 0.003 for
bulbous limbs, and blur that is not known adds 0.002. Errors of 139 volumes (seeds 9000 to 11099)
were 0.92 of what 0.005 states."""


def with_sigma(mesh: Mesh, sight: Sight, equations: JointEquations, metric: MetricScene) -> Mesh:
    """The mesh with its sigmas; NaN at filled vertices."""
    local = local_errors(mesh, sight, equations)
    filled = np.zeros(len(mesh), bool) if mesh.filled is None else mesh.filled
    measured = ~filled & (equations.photos > 1)
    shared = shared_errors(mesh, sight.axes, sight.seen_by, measured, metric)
    modes_mm = np.column_stack([shared.modes_mm, _OFFSET_PX * sight.pixel_mm])
    cameras = modes_mm.shape[1] - 2
    variance = local.variance_mm2 + shared.rest_mm2 + (modes_mm**2).sum(1)
    return replace(
        mesh,
        sigma_mm=np.where(filled, np.nan, np.sqrt(variance)).astype(np.float32),
        shared_mm=modes_mm.astype(np.float32),
        shared_sources=(SCALE, *cameras * (CAMERAS,), OFFSET),
        correlation_mm=local.reach_mm,
        lost_length=local.lost_length.astype(np.float32),
    )
