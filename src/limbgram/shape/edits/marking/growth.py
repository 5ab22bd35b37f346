"""Growth: surface that an edit adds; it counts as filled, for nothing measured it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Int32, Int64
from scipy.spatial import KDTree

from limbgram.errors import EditError
from limbgram.geometry.arrays import Faces, Points3
from limbgram.surface.mesh import Mesh
from limbgram.surface.repair.filling import fill_holes


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


def with_closed(mesh: Mesh, holes: Sequence[Int32[np.ndarray, " l"]], *, bent: bool = True) -> Mesh:
    """The mesh with holes closed, each a loop of its vertices; no vertex of it moves.

    Args:
        bent: Whether the filling goes on as the surface does; else it spans the hole as a drum.
    """
    if not holes:
        return mesh
    first = len(mesh)
    closed = fill_holes(mesh.vertices_mm, mesh.faces, list(holes), bent=bent)
    if not np.array_equal(closed.vertices_mm[:first], mesh.vertices_mm):
        raise EditError("The filling would have moved what was measured.")
    places = closed.vertices_mm[first:]
    rim = np.concatenate(holes).astype(np.int64)
    nearest = np.asarray(KDTree(mesh.vertices_mm[rim]).query(places)[1])
    return with_added(replace(mesh, faces=mesh.faces[:0]), places, rim[nearest], closed.faces)
