"""Where matching finds a round surface that blurred photos show.

A pixel mixes what lies round it. On a convex surface seen at a slant it reaches further towards
the contour than away from it: to second order (Taylor's expansion of the surface under a pixel)
the mean of what it mixes lies as if the surface were displaced along its normal by

    1/2 (blur pixel)^2 (H + q(r, r) / cos^2)

H being the sum of the principal curvatures, r the ray's part along the surface, q the curvature
along it and cos the cosine of incidence: photos from both sides meet below a convex surface and
above a hollow. Least squares follow edges too, which blur leaves in place; simulated paint takes
a share of the displacement.
"""

import numpy as np
from jaxtyping import Float32, Float64, Int32

from limbgram.geometry.arrays import Points3

_BLUR_PX = 0.45
"""Standard deviation of a pixel's reach: its own square (0.29) and a third of a pixel of lens and
demosaicing; between sharp photos, which need less, and soft ones, which need more."""
_SHARE = 0.5
"""What matching takes of it. On a painted ball of 40 mm with pixels of 0.4 mm, what was left
without lift was 0.000, -0.002 and -0.012 mm at reaches of 0.29, 0.58 and 1.04 px: shares of 0, 0.3
and 0.55. Simulated dabs in two photos: 0.4 to 0.6."""
_LEAST_COSINE = 0.2
_MOST_PX = 0.1
"""Larger displacements are those of folds and oddities, where the expansion does not hold."""


def apparent_lift_mm(
    vertices_mm: Points3,
    axes: Float64[np.ndarray, "n 3 3"],
    quadric: Float64[np.ndarray, "n 3"],
    views: Float64[np.ndarray, "k 22"],
    seen_by: Int32[np.ndarray, "n c"],
) -> Float32[np.ndarray, "n c"]:
    """How far above its place, along its normal, each photo of `seen_by` shows each vertex.

    Args:
        axes: two tangents and the normal of each vertex, rows.
        quadric: curvature (uu, uv, vv) along the tangents, 1/mm; negative where convex.
        views: `View.packed` of each photo.
    """
    lift = np.zeros(seen_by.shape, np.float32)
    for photo, view in enumerate(views):
        at, slot = np.nonzero(seen_by == photo)
        rotation, translation = view[:9].reshape(3, 3), view[9:12]
        rays = -rotation.T @ translation - vertices_mm[at]
        pixel_mm = np.abs(rays @ rotation[2]) / np.sqrt(view[12] * view[13])
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        u, v, cosine = np.einsum("nij,nj->in", axes[at], rays)
        uu, uv, vv = quadric[at].T
        along_ray = uu * u * u + 2 * uv * u * v + vv * v * v
        bend = uu + vv + along_ray / np.maximum(cosine, _LEAST_COSINE) ** 2
        moved_mm = _SHARE * 0.5 * (_BLUR_PX * pixel_mm) ** 2 * bend
        lift[at, slot] = np.clip(moved_mm, -_MOST_PX * pixel_mm, _MOST_PX * pixel_mm)
    return lift
