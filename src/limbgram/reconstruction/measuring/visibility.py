"""Visibility of vertices in photos, and the angle of incidence: ray casting against the mesh.

In      a mesh and placed views.
Out     per vertex and photo the cosine of the incidence angle, 0 where it is not seen.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from jaxtyping import Float32, Int32, Int64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import View
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh

_LIFT = 0.5
"""A ray starts this many edge lengths above its vertex, so that it misses its own triangles."""
_MARGIN_PX = 4.0
"""What lies nearer than this to a photo's border is out of frame."""
_BLOCK = 16384
"""Vertices looked at a time: what is known of all photos is ten times what is kept of it."""


def incidence_cosines(
    mesh: Mesh, views: Sequence[View], max_incidence_deg: float, step: int = 1
) -> Float32[np.ndarray, "n k"]:
    """Cosine between normal and ray by vertex and view; 0 where hidden, out of frame or steeper.

    step: looks at every step-th vertex only.
    """
    asked = np.arange(0, len(mesh), step)
    return np.concatenate(list(incidences(mesh, views, max_incidence_deg, asked)))


def incidences(
    mesh: Mesh,
    views: Sequence[View],
    max_incidence_deg: float,
    asked: Int64[np.ndarray, " m"] | None = None,
) -> Iterator[Float32[np.ndarray, "b k"]]:
    """The same of all vertices, or of those asked, some at a time: memory may not hold them all."""
    vertices, normals = mesh.vertices_mm, mesh.vertex_normals()
    if asked is not None:
        vertices, normals = vertices[asked], normals[asked]
    scene = EmbreeScene()
    TriangleMesh(scene, mesh.vertices_mm.astype(np.float32), mesh.faces)
    origins = (vertices + _LIFT * typical_edge_mm(mesh) * normals).astype(np.float32)
    lowest = float(np.cos(np.radians(max_incidence_deg)))
    for start in range(0, max(len(vertices), 1), _BLOCK):
        block = slice(start, start + _BLOCK)
        yield _cosines(scene, vertices[block], normals[block], origins[block], views, lowest)


def _cosines(
    scene: Any,  # embreex has no stubs
    vertices: Points3,
    normals: Points3,
    origins: Float32[np.ndarray, "b 3"],
    views: Sequence[View],
    lowest: float,
) -> Float32[np.ndarray, "b k"]:
    cosines = np.zeros((len(vertices), len(views)), np.float32)
    cosine, rays = np.empty(len(vertices)), np.empty((len(vertices), 3), np.float32)
    for k, view in enumerate(views):
        _look(vertices, normals, np.asarray(view.centre_in_world, np.float64), cosine, rays)
        facing = np.flatnonzero(cosine > lowest)
        facing = facing[view.shows(vertices[facing], _MARGIN_PX)]
        if not len(facing):
            continue
        hit = scene.run(origins[facing], rays[facing], query="OCCLUDED")
        seen = facing[np.asarray(hit) < 0]
        cosines[seen, k] = cosine[seen]
    return cosines


@njit(cache=True, nogil=True)
def _look(
    vertices: np.ndarray,
    normals: np.ndarray,
    centre: np.ndarray,
    cosine: np.ndarray,
    rays: np.ndarray,
):
    """Fill the rays to a camera and their cosines with the normals."""
    ray = np.empty(3)
    for n in range(len(vertices)):
        length2 = 0.0
        for k in range(3):
            ray[k] = centre[k] - vertices[n, k]
            length2 += ray[k] * ray[k]
        per_length = 1.0 / math.sqrt(length2)
        total = 0.0
        for k in range(3):
            ray[k] *= per_length
            rays[n, k] = ray[k]
            total += ray[k] * normals[n, k]
        cosine[n] = total


def best_views(cosines: Float32[np.ndarray, "n k"], count: int) -> Int32[np.ndarray, "n c"]:
    """The `count` most frontal views of each vertex, best first; -1 where there are fewer."""
    count = min(count, cosines.shape[1])
    order = np.argsort(-cosines, axis=1, kind="stable")[:, :count].astype(np.int32)
    return np.where(np.take_along_axis(cosines, order, 1) > 0, order, np.int32(-1))


def typical_edge_mm(mesh: Mesh) -> float:
    """Median edge length."""
    first, second = mesh.vertices_mm[mesh.faces[:, 0]], mesh.vertices_mm[mesh.faces[:, 1]]
    return float(np.median(np.linalg.norm(first - second, axis=1)))
