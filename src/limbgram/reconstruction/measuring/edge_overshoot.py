"""Edge overshoot (lips): surface that stands out past sharp edges unmeasured is laid back.

In      the measured mesh with its sigmas.
Out     the mesh with such vertices laid back on the surface that was measured round them, marked
        `filled` and without a sigma; the same mesh where there are none.
Method  At the sharp edge of a cut depth maps reach past the edge, and a closed surface follows
        them. A vertex stands out if it is poorly measured and a quarter of the well measured
        surface round it has it well outside its tangent planes; it goes back along their mean
        normal. A group of such vertices is a lip if the surface folds outwards in it, more sharply
        than its triangles can show; a bulge that was measured roughly is left as it is.
Fails   never.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import KDTree

from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.core.mesh.topology import find_edges

_WELL = 2.5
"""A vertex is well measured up to this many times the middle sigma of the surface."""
_REACH = 8.0
"""Edges within which the surface round a vertex is asked."""
_FEWEST = 12
"""Well measured vertices within that reach, or the vertex stays."""
_QUORUM = 0.25
"""Share of them that must have the vertex outside: a cut has about two fifths of what lies round
its edge; of a hollow, whose tangent planes cut off what lies beside it, few are so far off."""
_OUTSIDE = 0.25
"""Edges beyond a tangent plane that count as outside it."""
_FARTHEST = 3.0
"""Edges that a vertex is laid back at most; a group that stands out further is no lip."""
_ROUNDS = 4
_FOLD_DEG = 60.0
"""Angle between neighbouring faces from which the surface is folded. In a foot of 66,000 vertices
3 belong to a group with such a fold outwards, in a shank none, round a cast's cut 69."""
_EVEN_ROUNDS = 10
"""Of moving what was laid back along the surface, so that its triangles become even."""


def without_overshoot(mesh: Mesh) -> Mesh:
    """The mesh with its lips laid back, marked as filled in."""
    if mesh.sigma_mm is None or not np.isfinite(mesh.sigma_mm).any():
        return mesh
    sigma_mm = mesh.sigma_mm.astype(np.float64)
    well = np.nan_to_num(sigma_mm, nan=np.inf) <= _WELL * float(np.nanmedian(sigma_mm))
    start, end = find_edges(mesh.faces).ends.T
    edge_mm = float(
        np.median(np.linalg.norm(mesh.vertices_mm[start] - mesh.vertices_mm[end], axis=1))
    )
    laid, normals = _laid_back(mesh, well, edge_mm)
    off_mm = np.linalg.norm(laid - mesh.vertices_mm, axis=1)
    near = sparse.csr_array((np.ones(len(start)), (start, end)), (len(mesh), len(mesh)))
    near = sparse.csr_array(near + near.T)
    lips = _lips(near, off_mm, _folded(mesh), _FARTHEST * edge_mm)
    if not lips.any():
        return mesh
    vertices = np.where(lips[:, None], laid, mesh.vertices_mm)
    vertices = _evened(vertices, near, np.flatnonzero(lips), normals)
    filled = lips if mesh.filled is None else mesh.filled | lips
    return replace(
        mesh.with_vertices(vertices),
        filled=filled,
        sigma_mm=np.where(lips, np.float32(np.nan), mesh.sigma_mm),
    )


def _laid_back(
    mesh: Mesh, well: Bool[np.ndarray, " n"], edge_mm: float
) -> tuple[Points3, Float64[np.ndarray, "n 3"]]:
    """Every vertex inside the tangent planes round it, and the normals it was moved along."""
    vertices = mesh.vertices_mm.copy()
    normals = mesh.vertex_normals()
    along = normals.copy()
    places, upright = vertices[well], normals[well]
    if not len(places):
        return vertices, along
    tree = KDTree(places)
    left = np.flatnonzero(~well)
    for _ in range(_ROUNDS):
        still_out: list[int] = []
        for vertex in left.tolist():
            round_it = tree.query_ball_point(vertices[vertex], _REACH * edge_mm, return_sorted=True)
            if len(round_it) < _FEWEST:
                continue
            off_mm = ((vertices[vertex] - places[round_it]) * upright[round_it]).sum(1)
            outside = off_mm > _OUTSIDE * edge_mm
            if outside.mean() < _QUORUM:
                continue
            along[vertex] = unit(upright[round_it][outside].mean(0)[None])[0]
            vertices[vertex] -= float(np.median(off_mm[outside])) * along[vertex]
            still_out.append(vertex)
        left = np.array(still_out, np.int64)
    return vertices, along


def _lips(
    near: sparse.csr_array,
    off_mm: Float64[np.ndarray, " n"],
    folded: Bool[np.ndarray, " n"],
    farthest_mm: float,
) -> Bool[np.ndarray, " n"]:
    """The groups of moved vertices that hold a fold and moved a little way only."""
    moved = np.flatnonzero(off_mm > 0)
    lips = np.zeros(len(off_mm), np.bool_)
    if not len(moved):
        return lips
    label = csgraph.connected_components(near[moved][:, moved], directed=False)[1]
    count = int(label.max()) + 1
    folds = np.bincount(label, folded[moved], count) > 0
    too_far = np.bincount(label, off_mm[moved] > farthest_mm, count) > 0
    lips[moved] = (folds & ~too_far)[label]
    return lips


def _folded(mesh: Mesh) -> Bool[np.ndarray, " n"]:
    """Vertices at an edge over which the surface folds outwards."""
    edges = find_edges(mesh.faces)
    inner = edges.uses == 2
    ends, (one, other) = edges.ends[inner], edges.faces()[inner].T
    normals = unit(mesh.face_normals())
    middles = mesh.vertices_mm[mesh.faces].mean(1)
    turned = (normals[one] * normals[other]).sum(1) < np.cos(np.radians(_FOLD_DEG))
    outwards = ((middles[other] - middles[one]) * normals[one]).sum(1) < 0
    folded = np.zeros(len(mesh), np.bool_)
    folded[ends[turned & outwards]] = True
    return folded


def _evened(
    vertices: Points3,
    near: sparse.csr_array,
    moved: Int64[np.ndarray, " k"],
    normals: Float64[np.ndarray, "n 3"],
) -> Points3:
    """The moved vertices shifted to the middle of their neighbours, along the surface alone."""
    vertices = vertices.copy()
    mean = near[moved]
    counts = np.asarray(mean.sum(1)).ravel()
    for _ in range(_EVEN_ROUNDS):
        shift = (mean @ vertices) / counts[:, None] - vertices[moved]
        shift -= (shift * normals[moved]).sum(1, keepdims=True) * normals[moved]
        vertices[moved] += 0.5 * shift
    return vertices
