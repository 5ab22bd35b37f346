"""Edge overshoot: pulls back lips, poorly measured surface that stands out past sharp edges.

In      the measured mesh with its sigmas.
Out     the mesh with the vertices of lips on the tangent planes of the surface measured round them,
        marked `filled` and without a sigma; the same mesh where there are none.
Method  At the sharp edge of a cut, depth maps reach past the edge, and a closed surface follows
        them. A vertex stands out if it is poorly measured and lies well outside the tangent planes
        at a quarter of the well measured vertices round it; it moves back along their mean normal.
        A connected group of such vertices is a lip if the surface folds outwards in it, more
        sharply than its triangles can resolve; a bulge that was measured roughly stays.
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
from limbgram.core.mesh.topology import edge_lengths, find_edges

_WELL_MEASURED_RATIO = 2.5
"""A vertex is well measured up to this many times the median sigma of the surface."""
_SEARCH_RADIUS_EDGES = 8.0
"""Radius of a vertex's neighbourhood, in edges."""
_MIN_NEIGHBOURS = 12
"""Well measured vertices in that neighbourhood; with fewer, the vertex stays."""
_MIN_OUTSIDE_SHARE = 0.25
"""Share of them outside whose tangent planes the vertex must lie: at the edge of a cut about two
fifths of the neighbours belong to the cut; few tangent planes of a hollow are so far away."""
_OUTSIDE_EDGES = 0.25
"""Distance, in edges, from a tangent plane from which a vertex counts as outside it."""
_MAX_MOVE_EDGES = 3.0
"""Largest move in edges; a group that stands out further is no lip."""
_ROUNDS = 4
_FOLD_DEG = 60.0
"""Angle between adjacent faces from which the surface is folded. On a foot of 66,000 vertices 3
belong to a group with such an outward fold, on a shank none, round a cast's cut 69."""
_SMOOTHING_ROUNDS = 10
"""Rounds of tangential smoothing of the moved vertices."""


def without_overshoot(mesh: Mesh) -> Mesh:
    """The mesh with its lips pulled back and marked as filled."""
    if mesh.sigma_mm is None or not np.isfinite(mesh.sigma_mm).any():
        return mesh
    sigma_mm = mesh.sigma_mm.astype(np.float64)
    well_measured = np.nan_to_num(sigma_mm, nan=np.inf) <= _WELL_MEASURED_RATIO * float(
        np.nanmedian(sigma_mm)
    )
    ends = find_edges(mesh.faces).ends
    start, end = ends.T
    edge_mm = float(np.median(edge_lengths(mesh.vertices_mm, ends)))
    pulled, normals = _pulled_inside(mesh, well_measured, edge_mm)
    off_mm = np.linalg.norm(pulled - mesh.vertices_mm, axis=1)
    adjacency = sparse.csr_array((np.ones(len(start)), (start, end)), (len(mesh), len(mesh)))
    adjacency = sparse.csr_array(adjacency + adjacency.T)
    lips = _lips(adjacency, off_mm, _at_outward_folds(mesh), _MAX_MOVE_EDGES * edge_mm)
    if not lips.any():
        return mesh
    vertices = np.where(lips[:, None], pulled, mesh.vertices_mm)
    vertices = _smoothed_tangentially(vertices, adjacency, np.flatnonzero(lips), normals)
    filled = lips | ~mesh.measured
    return replace(
        mesh.with_vertices(vertices),
        filled=filled,
        sigma_mm=np.where(lips, np.float32(np.nan), mesh.sigma_mm),
    )


def _pulled_inside(
    mesh: Mesh, well_measured: Bool[np.ndarray, " n"], edge_mm: float
) -> tuple[Points3, Float64[np.ndarray, "n 3"]]:
    """Vertices moved inside the tangent planes round them, and the normals they moved along."""
    vertices = mesh.vertices_mm.copy()
    normals = mesh.vertex_normals()
    directions = normals.copy()
    places, place_normals = vertices[well_measured], normals[well_measured]
    if not len(places):
        return vertices, directions
    tree = KDTree(places)
    remaining = np.flatnonzero(~well_measured)
    for _ in range(_ROUNDS):
        still_outside: list[int] = []
        for vertex in remaining.tolist():
            neighbours = tree.query_ball_point(
                vertices[vertex], _SEARCH_RADIUS_EDGES * edge_mm, return_sorted=True
            )
            if len(neighbours) < _MIN_NEIGHBOURS:
                continue
            off_mm = ((vertices[vertex] - places[neighbours]) * place_normals[neighbours]).sum(1)
            outside = off_mm > _OUTSIDE_EDGES * edge_mm
            if outside.mean() < _MIN_OUTSIDE_SHARE:
                continue
            directions[vertex] = unit(place_normals[neighbours][outside].mean(0)[None])[0]
            vertices[vertex] -= float(np.median(off_mm[outside])) * directions[vertex]
            still_outside.append(vertex)
        remaining = np.array(still_outside, np.int64)
    return vertices, directions


def _lips(
    adjacency: sparse.csr_array,
    off_mm: Float64[np.ndarray, " n"],
    folded: Bool[np.ndarray, " n"],
    max_move_mm: float,
) -> Bool[np.ndarray, " n"]:
    """Vertices of the moved groups that contain a fold and did not move far."""
    moved = np.flatnonzero(off_mm > 0)
    lips = np.zeros(len(off_mm), np.bool_)
    if not len(moved):
        return lips
    label = csgraph.connected_components(adjacency[moved][:, moved], directed=False)[1]
    count = int(label.max()) + 1
    folds = np.bincount(label, folded[moved], count) > 0
    too_far = np.bincount(label, off_mm[moved] > max_move_mm, count) > 0
    lips[moved] = (folds & ~too_far)[label]
    return lips


def _at_outward_folds(mesh: Mesh) -> Bool[np.ndarray, " n"]:
    """Vertices of edges at which the surface folds outwards."""
    edges = find_edges(mesh.faces)
    inner = edges.uses == 2
    ends, (one, other) = edges.ends[inner], edges.faces()[inner].T
    normals = unit(mesh.face_normals())
    middles = mesh.vertices_mm[mesh.faces].mean(1)
    sharp = (normals[one] * normals[other]).sum(1) < np.cos(np.radians(_FOLD_DEG))
    outwards = ((middles[other] - middles[one]) * normals[one]).sum(1) < 0
    folded = np.zeros(len(mesh), np.bool_)
    folded[ends[sharp & outwards]] = True
    return folded


def _smoothed_tangentially(
    vertices: Points3,
    adjacency: sparse.csr_array,
    moved: Int64[np.ndarray, " k"],
    normals: Float64[np.ndarray, "n 3"],
) -> Points3:
    """Vertices with the moved ones smoothed tangentially towards the mean of their 1-rings."""
    vertices = vertices.copy()
    mean = adjacency[moved]
    counts = np.asarray(mean.sum(1)).ravel()
    for _ in range(_SMOOTHING_ROUNDS):
        shift = (mean @ vertices) / counts[:, None] - vertices[moved]
        shift -= (shift * normals[moved]).sum(1, keepdims=True) * normals[moved]
        vertices[moved] += 0.5 * shift
    return vertices
