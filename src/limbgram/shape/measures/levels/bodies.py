"""Bodies: what lies inside another body, such as bones inside the skin, is not measured with it."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Int64

from limbgram.geometry.arrays import Faces, Vector3
from limbgram.shape.limb import Limb
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
    sizes = np.bincount(pieces)
    largest = np.argsort(-sizes, kind="stable")[:_MOST_TESTED]
    by_piece = np.argsort(pieces, kind="stable")
    starts = np.cumsum(sizes) - sizes
    bodies = [_Body.of(mesh, by_piece[starts[k] : starts[k] + sizes[k]]) for k in largest]
    inner = [body for body in bodies if _is_inside_another(mesh, body, bodies)]
    if not inner:
        return Outside(mesh, 0)
    left_out = np.concatenate([body.face_ids for body in inner])
    return Outside(with_faces(mesh, np.delete(mesh.faces, left_out, axis=0)), len(inner))


def outside_of(limb: Limb, note: Callable[[int], str]) -> Limb:
    """The limb without the bodies inside it, and a note made of how many they were."""
    found = outer_bodies(limb.mesh)
    if not found.bodies_left_out:
        return limb
    return replace(limb, mesh=found.mesh, notes=(*limb.notes, note(found.bodies_left_out)))


def bodies_inside(count: int, place: str = "the limb", *, as_bones: bool = False) -> str:
    """How a sentence about them begins: `2 bodies inside the limb were`."""
    one, several = (", such as a bone,", ", such as bones,") if as_bones else ("", "")
    if count == 1:
        return f"1 body inside {place}{one} was"
    return f"{count} bodies inside {place}{several} were"


@dataclass(frozen=True)
class _Body:
    face_ids: Int64[np.ndarray, " k"]
    low_mm: Vector3
    high_mm: Vector3

    @classmethod
    def of(cls, mesh: Mesh, face_ids: Int64[np.ndarray, " k"]) -> "_Body":
        corners = mesh.vertices_mm[mesh.faces[face_ids].ravel()]
        return cls(face_ids, corners.min(0), corners.max(0))


def _is_inside_another(mesh: Mesh, body: _Body, others: list[_Body]) -> bool:
    own = mesh.faces[body.face_ids]
    if _signed_volume(mesh, own) <= 0:
        return False
    place_mm = mesh.vertices_mm[own[0, 0]]
    return any(
        (body.low_mm >= other.low_mm).all()
        and (body.high_mm <= other.high_mm).all()
        and _winding(mesh, mesh.faces[other.face_ids], place_mm) > 0.5
        for other in others
        if other is not body
    )


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
