"""Neighbours: means over the vertices that share an edge, and directions that follow from them."""

import numpy as np
from jaxtyping import Bool, Float64
from scipy.sparse import csr_array

from limbgram.geometry.arrays import Points3
from limbgram.shape.edits.marking.places import corner_shares
from limbgram.surface.closest import TriangleTree
from limbgram.surface.mesh import Mesh, unit
from limbgram.surface.topology import boundary_half_edges, find_edges

_LEAST_EDGE = 0.1
"""Edges shorter than this share of the median count as so long: they may not rule their ends."""


def averaging(mesh: Mesh) -> csr_array:
    """Takes values at vertices to the mean over each vertex's neighbours, the near ones more."""
    ends = find_edges(mesh.faces).ends
    lengths = np.linalg.norm(mesh.vertices_mm[ends[:, 0]] - mesh.vertices_mm[ends[:, 1]], axis=1)
    weights = 1 / np.maximum(lengths, _LEAST_EDGE * float(np.median(lengths)))
    half = csr_array((weights, (ends[:, 0], ends[:, 1])), shape=(len(mesh), len(mesh)))
    mean = csr_array(half + half.T)
    total = np.asarray(mean.sum(1)).ravel()
    mean.data /= np.repeat(np.maximum(total, 1e-30), np.diff(mean.indptr))
    return mean


def calm_normals(mesh: Mesh, rounds: int = 8) -> Points3:
    """Unit outward normals of the surface without its wrinkles."""
    mean = averaging(mesh)
    normals = mesh.vertex_normals()
    for _ in range(rounds):
        normals = 0.5 * (normals + mean @ normals)
    return unit(normals)


def calm_normals_on(refined: Mesh, mesh: Mesh) -> Points3:
    """Normals of a mesh at the vertices of what refinement made of it.

    They turn evenly over each old triangle; the refined mesh's own would turn all at its creases.
    """
    normals = calm_normals(mesh)
    added = refined.vertices_mm[len(mesh) :]
    if not len(added):
        return normals
    closest = TriangleTree.of(mesh.vertices_mm, mesh.faces).closest(added)
    corners = mesh.faces[closest.faces]
    shares = corner_shares(mesh.vertices_mm[corners], closest.points_mm)
    between = unit(np.einsum("nk,nkc->nc", shares, normals[corners]))
    return np.concatenate([normals, between])


def at_brim(mesh: Mesh) -> Bool[np.ndarray, " n"]:
    """Vertices on an open edge."""
    marked = np.zeros(len(mesh), np.bool_)
    marked[boundary_half_edges(mesh.faces)] = True
    return marked


def roughness_mm(mesh: Mesh) -> float:
    """How far vertices stand out from their neighbours, beyond what the shape's bend explains.

    Root mean square along the normal, of vertices away from the brim.
    """
    mean = averaging(mesh)
    towards = mean @ mesh.vertices_mm - mesh.vertices_mm
    out: Float64[np.ndarray, " n"] = (towards * mesh.vertex_normals()).sum(1)
    beyond = out - mean @ out
    inner = ~at_brim(mesh)
    return float(np.sqrt(np.mean(beyond[inner] ** 2))) if inner.any() else 0.0
