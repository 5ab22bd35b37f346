"""Ball Pivoting: a mesh whose vertices are the cloud's own points.

In      a Cloud: merged points with outward normals.
Out     a Mesh: edge-manifold, consistently oriented; it may have holes and islands (`repair`).
Method  Bernardini et al. 1999 with balls of rising radius; points nearer to each other than
        the noise lets a ball tell apart are thinned first.
Fails   SurfaceError: the points do not make a surface.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from limbgram.errors import SurfaceError
from limbgram.geometry.cloud import Cloud
from limbgram.run import track
from limbgram.surface.mesh import Mesh
from limbgram.surface.wrapping.grid import build_grid, in_cell_order, keep_apart
from limbgram.surface.wrapping.rolling import roll, start_front


@dataclass(frozen=True, kw_only=True)
class PivotOptions:
    """How the balls are chosen."""

    radii_in_spacings: tuple[float, ...] = (1.0, 1.5, 2.5, 4.0)
    """Radii of the balls, in typical distances between neighbours, rising."""
    closest_in_spacings: float = 0.5
    """Points nearer than this to one already taken are left out: they would make slivers."""


DEFAULTS = PivotOptions()
_FEWEST_POINTS = 50


def pivot(cloud: Cloud, options: PivotOptions = DEFAULTS) -> Mesh:
    """Roll balls over the points and join what they touch."""
    if len(cloud) < _FEWEST_POINTS:
        raise SurfaceError(
            f"{len(cloud)} points cannot make a surface. The photos probably show too little of "
            "the limb in common, or its skin is too plain: check the depth maps, paint the sock, "
            "take more photos."
        )
    spacing_mm = measure_spacing_mm(cloud)
    chosen = _thin(cloud, options.closest_in_spacings * spacing_mm)
    front = start_front(cloud.points_mm[chosen], cloud.normals[chosen])
    for radius in track([spacing_mm * r for r in options.radii_in_spacings]):
        roll(front, build_grid(front.points, 2 * radius), radius)
    faces = front.faces[: front.counts[0]]
    if not len(faces):
        raise SurfaceError(
            f"No ball found three of the {len(cloud)} points to rest on. Their normals are "
            "probably wrong or turned inwards."
        )
    used, compact = np.unique(faces, return_inverse=True)
    return Mesh(
        vertices_mm=front.points[used],
        faces=compact.reshape(-1, 3).astype(np.int32),
        colours=cloud.colours[chosen[used]],
    )


def measure_spacing_mm(cloud: Cloud) -> float:
    """Side of the square that one point covers, at the median point.

    Six neighbours lie within 1.08 sides in a triangular lattice, 1.41 in a square one and 1.38
    for points strewn at random.
    """
    sixth = KDTree(cloud.points_mm).query(cloud.points_mm[:: _every(cloud)], k=7)[0][:, 6]
    return float(np.median(sixth)) / 1.3


def _every(cloud: Cloud) -> int:
    return max(1, len(cloud) // 20_000)


def _thin(cloud: Cloud, distance_mm: float) -> np.ndarray:
    """Indices of points that keep a distance from each other, neighbours near in memory."""
    points = cloud.points_mm.astype(np.float64)
    order = in_cell_order(points, 4 * distance_mm)
    points = np.ascontiguousarray(points[order])
    return order[keep_apart(points, build_grid(points, distance_mm), distance_mm)]
