"""Where a blurred photo shows a round surface: not quite where it is.

A pixel mixes what lies round it. On a convex surface seen at a slant it reaches further towards
the contour than away from it, so that paint is shown nearer to the limb's middle than it lies;
photos from both sides then meet below the surface. To second order (Taylor's expansion of the
surface under a pixel) every photo sees a point of the surface displaced along its normal by

    1/2 (blur pixel)^2 (H + q(r, r) / cos^2)

H being the sum of the principal curvatures, r the ray's part along the surface, q the curvature
along it and cos the cosine of incidence: inwards on convex surfaces, outwards in hollows.
"""

import numpy as np
from jaxtyping import Float32, Float64

from limbgram.geometry.arrays import Points3

_BLUR_PX = 0.6
"""Standard deviation of a pixel's reach: its own square (0.29) and half a pixel of lens and
demosaicing."""
_LEAST_COSINE = 0.2
_MOST_PX = 0.1
"""Larger displacements are those of folds and oddities, where the expansion does not hold."""


def apparent_lift_mm(
    vertices_mm: Points3,
    axes: Float64[np.ndarray, "n 3 3"],
    quadric: Float64[np.ndarray, "n 3"],
    views: Float64[np.ndarray, "k 22"],
) -> Float32[np.ndarray, "n k"]:
    """How far above its place, along its normal, each photo shows each vertex.

    Args:
        axes: two tangents and the normal of each vertex, rows.
        quadric: curvature (uu, uv, vv) along the tangents, 1/mm; negative where convex.
        views: `View.packed` of each photo.
    """
    lift = np.zeros((len(vertices_mm), len(views)), np.float32)
    uu, uv, vv = quadric.T
    for k, view in enumerate(views):
        rotation, translation = view[:9].reshape(3, 3), view[9:12]
        rays = -rotation.T @ translation - vertices_mm
        pixel_mm = np.abs(rays @ rotation[2]) / np.sqrt(view[12] * view[13])
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        u, v, cosine = np.einsum("nij,nj->in", axes, rays)
        slanted = (uu * u * u + 2 * uv * u * v + vv * v * v) / np.maximum(
            cosine, _LEAST_COSINE
        ) ** 2
        moved_mm = 0.5 * (_BLUR_PX * pixel_mm) ** 2 * (uu + vv + slanted)
        lift[:, k] = np.clip(moved_mm, -_MOST_PX * pixel_mm, _MOST_PX * pixel_mm)
    return lift
