"""Booleans: one solid without another, by manifold3d, whose results are manifolds by construction.

In      two closed Meshes without open edges.
Out     the first one without what the second one holds; each face knows of which it is a part.
Fails   ValueError: one of them is no solid.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int64
from manifold3d import Error, Manifold, Mesh64

from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.mesh import Mesh


@dataclass(frozen=True, kw_only=True)
class Difference:
    """What is left of a solid."""

    vertices_mm: Points3
    faces: Faces
    of_one: Int64[np.ndarray, " f"]
    """The face of the first solid that each is a part of; -1 for those of the second one."""


def without(one: Mesh, other: Mesh) -> Difference:
    """The first solid without the second. Faces of the first that the second one does not meet
    are as they were, and all of its vertices that are left stand where they stood.

    Raises:
        ValueError: one of them is no solid.
    """
    first = int(Manifold.reserve_ids(2))
    left = (_solid(one, first) - _solid(other, first + 1)).to_mesh64()
    places = np.asarray(left.vert_properties)[:, :3].astype(np.float64)
    faces = np.asarray(left.tri_verts).astype(np.int32).reshape(-1, 3)
    of_one = np.full(len(faces), -1, np.int64)
    stops = np.asarray(left.run_index) // 3
    for solid, start, stop in zip(left.run_original_id, stops[:-1], stops[1:], strict=True):
        if solid == first:
            of_one[start:stop] = np.asarray(left.face_id)[start:stop]
    order = np.lexsort((*faces.T, of_one))
    return Difference(vertices_mm=places, faces=faces[order], of_one=of_one[order])


def _solid(mesh: Mesh, number: int) -> Manifold:
    """The same for the library; each face has its own name, so that none are made one."""
    count = len(mesh.faces)
    given = Mesh64(
        vert_properties=np.ascontiguousarray(mesh.vertices_mm, np.float64),
        tri_verts=np.ascontiguousarray(mesh.faces, np.uint64),
        run_original_id=np.array([number], np.uint32),
        run_index=np.array([0, 3 * count], np.uint64),
        face_id=np.arange(count, dtype=np.uint64),
    )
    solid = Manifold(given)
    if solid.status() != Error.NoError:
        raise ValueError(f"no solid: {solid.status().name}")
    return solid
