"""Which photo sees which vertex, and how squarely: ray casting against the mesh itself.

In      a mesh and placed views.
Out     per vertex and photo the cosine of the incidence angle, 0 where it is not seen.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from jaxtyping import Float32, Int32

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import View
from limbgram.core.mesh.mesh import Mesh

_LIFT = 0.5
"""A ray starts this many edge lengths above its vertex, so that it misses its own triangles."""
_BLOCK = 16384
"""Vertices looked at a time: what is known of all photos is ten times what is kept of it."""


def incidence_cosines(
    mesh: Mesh, views: Sequence[View], max_incidence_deg: float, step: int = 1
) -> Float32[np.ndarray, "n k"]:
    """Cosine between normal and ray by vertex and view; 0 where hidden, out of frame or steeper.

    step: looks at every step-th vertex only.
    """
    return np.concatenate(list(incidences(mesh, views, max_incidence_deg, step)))


def incidences(
    mesh: Mesh, views: Sequence[View], max_incidence_deg: float, step: int = 1
) -> Iterator[Float32[np.ndarray, "b k"]]:
    """The same, some vertices at a time: those of all together may not fit into memory."""
    vertices, normals = mesh.vertices_mm[::step], mesh.vertex_normals()[::step]
    scene = EmbreeScene()
    TriangleMesh(scene, mesh.vertices_mm[mesh.faces].astype(np.float32))
    lift_mm = _LIFT * typical_edge_mm(mesh)
    lowest = np.cos(np.radians(max_incidence_deg))
    for start in range(0, max(len(vertices), 1), _BLOCK):
        block = slice(start, start + _BLOCK)
        yield _cosines(scene, vertices[block], normals[block], views, lift_mm, lowest)


def _cosines(
    scene: Any,  # embreex has no stubs
    vertices: Points3,
    normals: Points3,
    views: Sequence[View],
    lift_mm: float,
    lowest: float,
) -> Float32[np.ndarray, "b k"]:
    cosines = np.zeros((len(vertices), len(views)), np.float32)
    for k, view in enumerate(views):
        rays = view.centre_in_world - vertices
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        cosine = np.einsum("ij,ij->i", rays, normals)
        facing = np.flatnonzero(cosine > lowest)
        facing = facing[view.camera.contains(view.project(vertices[facing]), margin_px=4)]
        if not len(facing):
            continue
        origins = (vertices[facing] + lift_mm * normals[facing]).astype(np.float32)
        hit = scene.run(origins, rays[facing].astype(np.float32), query="INTERSECT")
        seen = facing[np.asarray(hit) < 0]
        cosines[seen, k] = cosine[seen]
    return cosines


def best_views(cosines: Float32[np.ndarray, "n k"], count: int) -> Int32[np.ndarray, "n c"]:
    """The `count` most frontal views of each vertex, best first; -1 where there are fewer."""
    count = min(count, cosines.shape[1])
    order = np.argsort(-cosines, axis=1, kind="stable")[:, :count].astype(np.int32)
    return np.where(np.take_along_axis(cosines, order, 1) > 0, order, np.int32(-1))


def typical_edge_mm(mesh: Mesh) -> float:
    """Median edge length."""
    first, second = mesh.vertices_mm[mesh.faces[:, 0]], mesh.vertices_mm[mesh.faces[:, 1]]
    return float(np.median(np.linalg.norm(first - second, axis=1)))
