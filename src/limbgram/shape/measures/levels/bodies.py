"""Bodies: what lies inside another body, such as bones inside the skin, is not measured with it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int32

from limbgram.geometry.arrays import Faces, Vector3
from limbgram.surface.mesh import Mesh
from limbgram.surface.topology import face_components, with_faces

_MOST_TESTED = 64
"""Pieces of a shape that are held against each other, the largest first; the rest are scraps."""


@dataclass(frozen=True)
class Outside:
    """A shape without the bodies inside its bodies."""

    mesh: Mesh
    bodies_left_out: int


def outer_bodies(mesh: Mesh) -> Outside:
    """The mesh without pieces that lie inside another one and face the same way.

    The walls of hollows face the other way, and stay.
    """
    pieces = face_components(mesh.faces)
    if not pieces.max(initial=0):
        return Outside(mesh, 0)
    order = np.argsort(-np.bincount(pieces), kind="stable")[:_MOST_TESTED]
    inner = [piece for piece in order if _is_inside_another(mesh, pieces, order, int(piece))]
    kept = ~np.isin(pieces, inner)
    return Outside(with_faces(mesh, mesh.faces[kept]), len(inner)) if inner else Outside(mesh, 0)


def _is_inside_another(
    mesh: Mesh, pieces: Int32[np.ndarray, " f"], others: np.ndarray, piece: int
) -> bool:
    own = mesh.faces[pieces == piece]
    if _signed_volume(mesh, own) <= 0:
        return False
    corners = mesh.vertices_mm[np.unique(own)]
    for other in others:
        if other == piece:
            continue
        faces = mesh.faces[pieces == other]
        around = mesh.vertices_mm[np.unique(faces)]
        within: Bool[np.ndarray, " 3"] = (corners.min(0) >= around.min(0)) & (
            corners.max(0) <= around.max(0)
        )
        if within.all() and _winding(mesh, faces, corners.mean(0)) > 0.5:
            return True
    return False


def _signed_volume(mesh: Mesh, faces: Faces) -> float:
    a, b, c = (mesh.vertices_mm[faces[:, k]] - mesh.vertices_mm[faces[0, 0]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)))


def _winding(mesh: Mesh, faces: Faces, place_mm: Vector3) -> float:
    """How often a surface goes round a place: solid angles (Van Oosterom and Strackee 1983)."""
    a, b, c = (mesh.vertices_mm[faces[:, k]] - place_mm for k in range(3))
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    over = np.einsum("ij,ij->i", a, np.cross(b, c))
    under = la * lb * lc + lc * (a * b).sum(1) + la * (b * c).sum(1) + lb * (c * a).sum(1)
    return float(np.arctan2(over, under).sum() / (2 * np.pi))
