"""Sampling: places spread evenly over a surface, the same each time."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int64

from limbgram.geometry.arrays import Points3
from limbgram.surface.mesh import Mesh, unit

_STEPS = (0.7548776662466927, 0.5698402909980532)
"""Of the plane's evenly filling sequence (Roberts 2018): powers of 1 over the plastic number."""


@dataclass(frozen=True, kw_only=True)
class Samples:
    """Places on a surface, each standing for the same area."""

    points_mm: Points3
    normals: Points3
    """Unit, interpolated between the vertices' normals."""
    faces: Int64[np.ndarray, " n"]


def sample_evenly(mesh: Mesh, count: int) -> Samples:
    """`count` places in the order of the faces, by area."""
    areas = np.linalg.norm(mesh.face_normals(), axis=1)
    reach = np.cumsum(areas)
    places = (np.arange(count) + 0.5) / count * reach[-1]
    faces = np.minimum(np.searchsorted(reach, places), len(areas) - 1)
    u, v = ((0.5 + step * np.arange(count)) % 1.0 for step in _STEPS)
    beyond = u + v > 1
    u, v = np.where(beyond, 1 - u, u), np.where(beyond, 1 - v, v)
    weights = np.column_stack([1 - u - v, u, v])
    corners = mesh.faces[faces]
    normals = np.einsum("nk,nkc->nc", weights, mesh.vertex_normals()[corners])
    return Samples(
        points_mm=np.einsum("nk,nkc->nc", weights, mesh.vertices_mm[corners]),
        normals=unit(normals),
        faces=faces.astype(np.int64),
    )
