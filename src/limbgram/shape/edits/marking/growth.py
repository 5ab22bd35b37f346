"""Growth: surface that an edit adds; it counts as filled, for nothing measured it."""

from dataclasses import replace

import numpy as np
from jaxtyping import Int64

from limbgram.geometry.arrays import Faces, Points3
from limbgram.surface.mesh import Mesh


def with_added(mesh: Mesh, places_mm: Points3, like: Int64[np.ndarray, " k"], faces: Faces) -> Mesh:
    """The mesh with more vertices and faces.

    Args:
        like: For each new vertex, an old one whose colour it takes.
        faces: Of old and new vertices; new ones count on from the old.
    """

    def longer(values: np.ndarray | None, added: np.ndarray | float | bool) -> np.ndarray | None:
        if values is None:
            return None
        new = np.broadcast_to(np.asarray(added, values.dtype), (len(like), *values.shape[1:]))
        return np.concatenate([values, new])

    filled = np.zeros(len(mesh), np.bool_) if mesh.filled is None else mesh.filled
    return replace(
        mesh,
        vertices_mm=np.concatenate([mesh.vertices_mm, places_mm]),
        faces=np.concatenate([mesh.faces, faces]).astype(np.int32),
        colours=None if mesh.colours is None else longer(mesh.colours, mesh.colours[like]),
        filled=longer(filled, True),
        sigma_mm=longer(mesh.sigma_mm, np.nan),
        shared_mm=longer(mesh.shared_mm, 0.0),
        lost_length=longer(mesh.lost_length, 0.0),
    )
