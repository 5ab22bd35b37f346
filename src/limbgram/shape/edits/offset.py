"""Offset: the surface moved along its normals so that its faces move by the distance.

In      a Mesh and a distance in mm, negative inwards.
Out     the Mesh with moved vertices; faces, colours, filled marks and sigmas as they were.
Method  each vertex goes where the planes of its faces meet once they have moved; directions that
        they leave open stay unused. On a plane, a cylinder and a sphere every face moves by the
        distance as far as its triangles follow the shape.
Fails   EditError: the surface would fold or cut through itself.
"""

import numpy as np

from limbgram.errors import EditError
from limbgram.geometry.arrays import Points3
from limbgram.shape.edits.guard import require_sound
from limbgram.surface.mesh import Mesh

_TIE = 1e-3
"""Weight of staying on the normal, as a share of the faces' own: decides where they leave open."""
_FARTHEST = 2.0
"""A vertex moves at most this many distances, so that sharp scraps do not shoot out."""


def offset(mesh: Mesh, distance_mm: float) -> Mesh:
    """Move every face by a distance along its outward normal.

    Raises:
        EditError: the surface would fold or cut through itself.
    """
    if not np.isfinite(distance_mm):
        raise EditError("An offset needs a distance in millimetres that is a number.")
    if distance_mm == 0.0:
        return mesh
    moved = mesh.with_vertices(mesh.vertices_mm + distance_mm * unit_offsets(mesh))
    what = f"The offset by {distance_mm:g} mm"
    turned = int(((mesh.face_normals() * moved.face_normals()).sum(1) < 0).sum())
    if turned:
        raise EditError(
            f"{what} was not done: it would turn {turned} triangles inside out, where the surface "
            "bends more tightly than that. Offset by less, or smooth the surface first."
        )
    require_sound(what, mesh, moved)
    return moved


def unit_offsets(mesh: Mesh) -> Points3:
    """Displacement of each vertex for an offset of 1 mm outwards.

    Least squares of n . x = 1 over the faces at the vertex, weighted by their angle there.
    """
    corners = mesh.vertices_mm[mesh.faces]
    weighted = mesh.face_normals()
    units = weighted / np.maximum(np.linalg.norm(weighted, axis=1, keepdims=True), 1e-30)
    count = len(mesh)
    normals = np.zeros((count, 3))
    products = np.zeros((count, 3, 3))
    for k in range(3):
        ahead = corners[:, (k + 1) % 3] - corners[:, k]
        back = corners[:, (k + 2) % 3] - corners[:, k]
        lengths = np.linalg.norm(ahead, axis=1) * np.linalg.norm(back, axis=1)
        cosine = (ahead * back).sum(1) / np.maximum(lengths, 1e-30)
        angle = np.arccos(np.clip(cosine, -1, 1))
        at = mesh.faces[:, k]
        for i in range(3):
            normals[:, i] += np.bincount(at, angle * units[:, i], count)
            for j in range(i, 3):
                products[:, i, j] += np.bincount(at, angle * units[:, i] * units[:, j], count)
    for i, j in ((0, 1), (0, 2), (1, 2)):
        products[:, j, i] = products[:, i, j]
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    along = normals / np.maximum(length, 1e-30)
    tie = _TIE * np.maximum(np.trace(products, axis1=1, axis2=2), 1e-30)
    system = products + tie[:, None, None] * np.eye(3)
    moves = np.linalg.solve(system, (normals + tie[:, None] * along)[:, :, None])[:, :, 0]
    far = np.linalg.norm(moves, axis=1, keepdims=True)
    return moves * np.minimum(1.0, _FARTHEST / np.maximum(far, 1e-30))
