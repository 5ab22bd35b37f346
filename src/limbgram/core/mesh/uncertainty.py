"""Uncertainty: the sigma of a figure taken from a surface, from the sigmas of its vertices.

A figure changes by g_i for a millimetre of vertex i along its outward normal. Three kinds of
error: shared by all vertices (scale, cameras), which add up with their signs and never average
out; local ones, alike by exp(-(d / reach)^2) at two vertices d apart; and those of filled
patches, each of which is wrong as one piece. How far a surface reaches is no such figure: where its
foremost vertex errs, or a patch beside it bulges, another one is foremost.
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64, Int64, Integer
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree
from scipy.special import ndtri

from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import find_edges
from limbgram.core.mesh.tree_cache import ByMesh

_MOST_EXACT = 4000
"""Vertices up to which every pair is counted; beyond, a figure is even enough for areas."""
_REACHES = 2.5
"""Pairs further apart than this many reaches are independent: they correlate by exp(-6.25)."""
_NEAR_MM = 10.0
"""As far from the rim of a filled patch it matters how the measured surface bends."""
_EDGES = 100
"""So many edges within that tell it; of a fine mesh not all are asked."""
_DRAWS, _SEED = 4000, 33
_MOST_SIGMAS = 4.0
"""No draw goes further."""
_SLOTS = np.linspace(-_MOST_SIGMAS, _MOST_SIGMAS, 161)
"""Where the reach of a piece is asked, in its sigmas: between them it is nearly straight."""
_REACH_95 = float(ndtri(0.975))


def propagate(mesh: Mesh, gradient: Float64[np.ndarray, " n"]) -> float | None:
    """Standard deviation of a figure; None where the mesh carries no sigmas.

    gradient: change of the figure for one millimetre of each vertex along its outward normal.
    """
    if mesh.sigma_mm is None:
        return None
    known = np.isfinite(mesh.sigma_mm)
    variance = _local_variance(mesh, np.where(known, gradient, 0.0))
    if mesh.shared_mm is not None:
        variance += float(np.sum((gradient @ mesh.shared_mm.astype(np.float64)) ** 2))
    if np.any(gradient[~known]):
        fills = _fills(mesh)
        pulls = (gradient * fills.sigma_mm)[~known]
        variance += float(np.sum(np.bincount(fills.patch, pulls) ** 2))  # each as one piece
    return math.sqrt(variance)


def filled_sigma_mm(mesh: Mesh, filled: Bool[np.ndarray, " n"]) -> Float64[np.ndarray, " n"]:
    """One standard deviation of each filled vertex along its normal; 0 elsewhere.

    A patch goes on with the bend of its rim. The true surface may bend more or less, by about as
    much as the measured surface bends near by, as at toes, no more than a half ball over the patch
    (k = 1 / h), and no less than the whole surface does
    (k = 1 / mean distance of its tangent planes from its middle): at a distance d from the rim of a
    patch of half width h it is k (h d - d^2 / 2) away.
    """
    return _fills_among(mesh, filled).sigma_mm


def beyond_foremost_mm2(
    mesh: Mesh,
    reach_mm: Float64[np.ndarray, " k"],
    vertices: Integer[np.ndarray, "k c"],
    weights: Float64[np.ndarray, "k c"],
) -> float:
    """Variance of how far places of a surface reach, beyond what the foremost has by itself.

    The surface errs in pieces, each as one: filled patches, and measured neighbourhoods as wide as
    errors are alike. Each draw moves all pieces and asks which place is foremost then. As a patch
    that lies behind can come forward but not hold others back, the draws lie on one side. The
    variance is that of a normal error, 95 % of which lie as near to the surface's own reach as of
    the draws; below nothing where others keep the reach from falling as the foremost place may.

    vertices: between which each place lies; weights: change of its reach for a millimetre of each.
    """
    if mesh.sigma_mm is None:
        return 0.0
    filled = ~np.isfinite(mesh.sigma_mm)
    spread = np.sqrt(_local_square(mesh, np.arange(len(mesh))))
    if filled.any():
        spread[filled] = _fills(mesh).sigma_mm[filled]
    slopes = (weights * spread[vertices]).sum(1)
    most = np.abs(slopes) * _MOST_SIGMAS
    foremost = int(reach_mm.argmax())
    near = np.flatnonzero(reach_mm + most >= (reach_mm - most).max())
    near = near[np.argsort(-reach_mm[near], kind="stable")]
    draws = np.full(_DRAWS, -np.inf)
    random = np.random.default_rng(_SEED)
    shares = ndtri((np.arange(_DRAWS) + 0.5) / _DRAWS)
    for piece in _pieces(mesh, vertices[near], filled):
        places = near[piece]
        by_slot = (reach_mm[places, None] + slopes[places, None] * _SLOTS).max(0)
        np.maximum(draws, np.interp(random.permutation(shares), _SLOTS, by_slot), out=draws)
    off = np.quantile(np.abs(draws - reach_mm[foremost]), 0.95) / _REACH_95
    return float(off) ** 2 - float(slopes[foremost]) ** 2


def _pieces(
    mesh: Mesh, vertices: Integer[np.ndarray, "k c"], filled: Bool[np.ndarray, " n"]
) -> list[Int64[np.ndarray, " p"]]:
    """Places that err as one: of one patch, and measured ones round the first that none has yet."""
    patch = np.full(len(mesh), -1)
    if filled.any():
        patch[filled] = _fills(mesh).patch
    of_place = patch[vertices].max(1)
    found = [np.flatnonzero(of_place == one) for one in np.unique(of_place) if one >= 0]
    left = of_place < 0
    points = mesh.vertices_mm[vertices[:, 0]]
    while left.any():
        at = points[int(left.argmax())]
        taken = left & (((points - at) ** 2).sum(1) <= (mesh.correlation_mm or 0.0) ** 2)
        found.append(np.flatnonzero(taken))
        left &= ~taken
    return found


def _local_variance(mesh: Mesh, gradient: Float64[np.ndarray, " n"]) -> float:
    """Of what neighbours have in common and no more."""
    touched = np.flatnonzero(gradient)
    if not len(touched) or mesh.sigma_mm is None:
        return 0.0
    pulls = gradient[touched] * np.sqrt(_local_square(mesh, touched))
    reach = mesh.correlation_mm or 0.0
    if reach == 0.0:
        return float(pulls @ pulls)
    if len(touched) > _MOST_EXACT:
        alike = math.pi * reach**2 / np.maximum(mesh.vertex_areas_mm2()[touched], 1e-12)
        return float(pulls**2 @ np.maximum(alike, 1.0))
    tree = KDTree(mesh.vertices_mm[touched])
    pairs: Int64[np.ndarray, "p 2"] = tree.query_pairs(_REACHES * reach, output_type="ndarray")
    apart = mesh.vertices_mm[touched][pairs[:, 0]] - mesh.vertices_mm[touched][pairs[:, 1]]
    alike = np.exp(-np.einsum("ij,ij->i", apart, apart) / reach**2)
    both = 2 * float(np.sum(alike * pulls[pairs[:, 0]] * pulls[pairs[:, 1]]))
    return max(float(pulls @ pulls) + both, 0.0)


def _local_square(mesh: Mesh, touched: Int64[np.ndarray, " k"]) -> Float64[np.ndarray, " k"]:
    """Variance of vertices less what they share with all."""
    if mesh.sigma_mm is None:
        return np.zeros(len(touched))
    square = mesh.sigma_mm[touched].astype(np.float64) ** 2
    if mesh.shared_mm is not None:
        square -= np.sum(mesh.shared_mm[touched].astype(np.float64) ** 2, axis=1)
    return np.maximum(square, 0.0)


class _Fills(NamedTuple):
    sigma_mm: Float64[np.ndarray, " n"]
    """Of each filled vertex; 0 elsewhere."""
    patch: Int64[np.ndarray, " k"]
    """Of each filled vertex."""


def _fills_among(mesh: Mesh, filled: Bool[np.ndarray, " n"]) -> _Fills:
    sigma = np.zeros(len(mesh))
    if not filled.any():
        return _Fills(sigma, np.zeros(0, np.int64))
    patch, of_vertex = _patches(mesh, filled)
    if filled.all():
        return _Fills(sigma, of_vertex)
    distance, nearest = KDTree(mesh.vertices_mm[~filled]).query(mesh.vertices_mm[filled])
    half = np.zeros(patch)
    np.maximum.at(half, of_vertex, distance)
    normals = mesh.vertex_normals()
    near = _bend_near(mesh, normals, filled, np.flatnonzero(~filled)[nearest])
    most = 1 / np.maximum(half, 1e-12)[of_vertex]
    bend = np.maximum(np.minimum(near, most), _bend(mesh, normals))
    bulge = (half[of_vertex] * distance - distance**2 / 2) * bend
    rim = np.zeros(len(distance))
    if mesh.sigma_mm is not None:
        rim = mesh.sigma_mm[~filled][nearest].astype(np.float64)
    sigma[filled] = np.hypot(bulge, rim)
    return _Fills(sigma, of_vertex)


def _fills_of(mesh: Mesh) -> _Fills:
    """Of a mesh that carries sigmas: those without one are filled."""
    assert mesh.sigma_mm is not None
    return _fills_among(mesh, ~np.isfinite(mesh.sigma_mm))


_fills = ByMesh(_fills_of)
"""Every figure that crosses a fill asks for them."""


def _patches(mesh: Mesh, filled: Bool[np.ndarray, " n"]) -> tuple[int, Int64[np.ndarray, " k"]]:
    """Number of connected filled patches, and the patch of every filled vertex."""
    faces = mesh.faces[filled[mesh.faces].any(axis=1)]
    ends = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    ends = ends[filled[ends].all(axis=1)]
    number = np.cumsum(filled) - 1
    links = coo_array(
        (np.ones(len(ends)), (number[ends[:, 0]], number[ends[:, 1]])),
        shape=(int(filled.sum()), int(filled.sum())),
    )
    count, of_vertex = connected_components(links, directed=False)
    return int(count), of_vertex.astype(np.int64)


def _bend(mesh: Mesh, normals: Points3) -> float:
    """Typical curvature of the surface, 1/mm."""
    areas = mesh.vertex_areas_mm2()
    middle = areas @ mesh.vertices_mm / areas.sum()
    distance = np.einsum("ij,ij->i", mesh.vertices_mm - middle, normals)
    return float(areas.sum() / max(float(areas @ np.abs(distance)), 1e-12))


def _bend_near(
    mesh: Mesh,
    normals: Points3,
    filled: Bool[np.ndarray, " n"],
    vertices: Int64[np.ndarray, " k"],
) -> Float64[np.ndarray, " k"]:
    """RMS of the curvatures along the measured edges round each of these vertices, 1/mm."""
    ends = find_edges(mesh.faces).ends
    ends = ends[~filled[ends].any(axis=1)]
    near_by = np.pi * _NEAR_MM**2 * len(ends) / max(mesh.area_mm2(), 1e-12)
    ends = ends[:: max(1, int(near_by / _EDGES))]
    way = mesh.vertices_mm[ends[:, 1]] - mesh.vertices_mm[ends[:, 0]]
    turned = ((normals[ends[:, 1]] - normals[ends[:, 0]]) * way).sum(axis=1)
    square = (turned / np.maximum((way**2).sum(axis=1), 1e-12)) ** 2
    rim, at = np.unique(vertices, return_inverse=True)
    middles = KDTree(mesh.vertices_mm[ends].mean(axis=1))
    pairs = KDTree(mesh.vertices_mm[rim]).sparse_distance_matrix(
        middles, _NEAR_MM, output_type="coo_matrix"
    )
    count = np.maximum(np.bincount(pairs.row, minlength=len(rim)), 1)
    return np.sqrt(np.bincount(pairs.row, square[pairs.col], len(rim)) / count)[at]
