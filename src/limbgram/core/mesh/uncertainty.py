"""Uncertainty: propagates the errors of vertices to a measure of the surface.

A measure has the gradient g_i with respect to vertex i along its outward normal. Three kinds of
error: shared by all vertices (scale, cameras), fully correlated; local ones, whose correlation at
a distance d is exp(-(d / correlation length)^2); and those of filled patches, each fully
correlated. The extent of a surface is no smooth measure: if its extreme vertex errs, or a patch
beside it bulges, another vertex is extreme (`extra_extremum_variance_mm2`).
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64, Int32, Int64, Integer
from scipy.spatial import KDTree
from scipy.special import ndtri

from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import components_among, find_edges
from limbgram.core.mesh.tree_cache import ByMesh

_MOST_EXACT = 4000
"""Vertices up to which every pair is summed; beyond, the correlated area is used instead."""
_CUTOFF = 2.5
"""Correlation lengths beyond which vertices count as independent: exp(-6.25)."""
_RIM_MM = 10.0
"""Distance from the rim of a filled patch within which the surface's curvature is measured."""
_EDGES = 100
"""Edges within that distance that suffice; of a fine mesh only a sample is used."""
_DRAWS, _SEED = 4000, 33
_MOST_SIGMAS = 4.0
"""Largest draw."""
_NODES = np.linspace(-_MOST_SIGMAS, _MOST_SIGMAS, 161)
"""Draws, in sigmas, for which a piece's extent is computed; it is interpolated between them."""
_SIGMAS_95 = float(ndtri(0.975))


def propagate(mesh: Mesh, gradient: Float64[np.ndarray, " n"]) -> float | None:
    """Standard deviation of a measure; None if the mesh carries no sigmas.

    gradient: change of the measure per millimetre of each vertex along its outward normal.
    """
    if mesh.sigma_mm is None:
        return None
    known = np.isfinite(mesh.sigma_mm)
    variance = _local_variance(mesh, np.where(known, gradient, 0.0))
    if mesh.shared_mm is not None:
        variance += float(np.sum((gradient @ mesh.shared_mm.astype(np.float64)) ** 2))
    if np.any(gradient[~known]):
        fills = _fills(mesh)
        contributions = (gradient * fills.sigma_mm)[~known]
        variance += float(np.sum(np.bincount(fills.patch, contributions) ** 2))
    return math.sqrt(variance)


def filled_sigma_mm(mesh: Mesh, filled: Bool[np.ndarray, " n"]) -> Float64[np.ndarray, " n"]:
    """Standard deviation of each filled vertex along its normal; 0 elsewhere.

    At a distance d from the rim of a patch of half width h, the true surface may lie off by
    k (h d - d^2 / 2), where k is the sigma of its curvature: the curvature of the measured surface
    near the rim, at most that of a hemisphere over the patch (1 / h), at least that of the whole
    surface (1 / mean distance of its tangent planes from its centroid).
    """
    return _fills_among(mesh, filled).sigma_mm


def extra_extremum_variance_mm2(
    mesh: Mesh,
    extent_mm: Float64[np.ndarray, " k"],
    vertices: Integer[np.ndarray, "k c"],
    weights: Float64[np.ndarray, "k c"],
) -> float:
    """Variance of the largest of several extents, less that of the largest one by itself.

    By Monte Carlo: the surface errs in fully correlated pieces, filled patches and measured
    neighbourhoods one correlation length wide; each draw moves all of them and takes the maximum.
    As a piece can come forward but not hold others back, draws are one-sided: the variance is that
    of the normal distribution with the same 95 % range about the undisturbed maximum. It is
    negative if other points keep the maximum from falling as far as its own point may.

    vertices: between which each point lies; weights: change of its extent per millimetre of each.
    """
    if mesh.sigma_mm is None:
        return 0.0
    filled = ~np.isfinite(mesh.sigma_mm)
    spread = np.sqrt(_local_square(mesh, np.arange(len(mesh))))
    if filled.any():
        spread[filled] = _fills(mesh).sigma_mm[filled]
    sigma = (weights * spread[vertices]).sum(1)
    most = np.abs(sigma) * _MOST_SIGMAS
    extreme = int(extent_mm.argmax())
    candidates = np.flatnonzero(extent_mm + most >= (extent_mm - most).max())
    candidates = candidates[np.argsort(-extent_mm[candidates], kind="stable")]
    draws = np.full(_DRAWS, -np.inf)
    random = np.random.default_rng(_SEED)
    normal = ndtri((np.arange(_DRAWS) + 0.5) / _DRAWS)
    for piece in _pieces(mesh, vertices[candidates], filled):
        points = candidates[piece]
        at_nodes = (extent_mm[points, None] + sigma[points, None] * _NODES).max(0)
        np.maximum(draws, np.interp(random.permutation(normal), _NODES, at_nodes), out=draws)
    off = np.quantile(np.abs(draws - extent_mm[extreme]), 0.95) / _SIGMAS_95
    return float(off) ** 2 - float(sigma[extreme]) ** 2


def _pieces(
    mesh: Mesh, vertices: Integer[np.ndarray, "k c"], filled: Bool[np.ndarray, " n"]
) -> list[Int64[np.ndarray, " p"]]:
    """Points that err as one: those of a patch, and measured ones round the first not yet taken."""
    patch = np.full(len(mesh), -1)
    if filled.any():
        patch[filled] = _fills(mesh).patch
    of_point = patch[vertices].max(1)
    found = [np.flatnonzero(of_point == one) for one in np.unique(of_point) if one >= 0]
    left = of_point < 0
    points = mesh.vertices_mm[vertices[:, 0]]
    while left.any():
        at = points[int(left.argmax())]
        taken = left & (((points - at) ** 2).sum(1) <= (mesh.correlation_mm or 0.0) ** 2)
        found.append(np.flatnonzero(taken))
        left &= ~taken
    return found


def _local_variance(mesh: Mesh, gradient: Float64[np.ndarray, " n"]) -> float:
    """Variance from local errors, which correlate over `correlation_mm`."""
    touched = np.flatnonzero(gradient)
    if not len(touched) or mesh.sigma_mm is None:
        return 0.0
    contributions = gradient[touched] * np.sqrt(_local_square(mesh, touched))
    length_mm = mesh.correlation_mm or 0.0
    if length_mm == 0.0:
        return float(contributions @ contributions)
    if len(touched) > _MOST_EXACT:
        correlated = math.pi * length_mm**2 / np.maximum(mesh.vertex_areas_mm2()[touched], 1e-12)
        return float(contributions**2 @ np.maximum(correlated, 1.0))
    tree = KDTree(mesh.vertices_mm[touched])
    pairs: Int64[np.ndarray, "p 2"] = tree.query_pairs(_CUTOFF * length_mm, output_type="ndarray")
    one, two = pairs.T
    apart = mesh.vertices_mm[touched][one] - mesh.vertices_mm[touched][two]
    correlation = np.exp(-np.einsum("ij,ij->i", apart, apart) / length_mm**2)
    covariances = 2 * float(np.sum(correlation * contributions[one] * contributions[two]))
    return max(float(contributions @ contributions) + covariances, 0.0)


def _local_square(mesh: Mesh, touched: Int64[np.ndarray, " k"]) -> Float64[np.ndarray, " k"]:
    """Variance of vertices less the shared errors."""
    if mesh.sigma_mm is None:
        return np.zeros(len(touched))
    square = mesh.sigma_mm[touched].astype(np.float64) ** 2
    if mesh.shared_mm is not None:
        square -= np.sum(mesh.shared_mm[touched].astype(np.float64) ** 2, axis=1)
    return np.maximum(square, 0.0)


class _Fills(NamedTuple):
    sigma_mm: Float64[np.ndarray, " n"]
    """Of each filled vertex; 0 elsewhere."""
    patch: Int32[np.ndarray, " k"]
    """Patch of each filled vertex."""


def _fills_among(mesh: Mesh, filled: Bool[np.ndarray, " n"]) -> _Fills:
    sigma = np.zeros(len(mesh))
    if not filled.any():
        return _Fills(sigma, np.zeros(0, np.int32))
    patch = components_among(filled, find_edges(mesh.faces).ends)
    if filled.all():
        return _Fills(sigma, patch)
    distance, nearest = KDTree(mesh.vertices_mm[~filled]).query(mesh.vertices_mm[filled])
    half_width = np.zeros(int(patch.max()) + 1)
    np.maximum.at(half_width, patch, distance)
    normals = mesh.vertex_normals()
    near_rim = _curvature_near(mesh, normals, filled, np.flatnonzero(~filled)[nearest])
    hemisphere = 1 / np.maximum(half_width, 1e-12)[patch]
    curvature = np.maximum(np.minimum(near_rim, hemisphere), _mean_curvature(mesh, normals))
    bulge = (half_width[patch] * distance - distance**2 / 2) * curvature
    rim_sigma = np.zeros(len(distance))
    if mesh.sigma_mm is not None:
        rim_sigma = mesh.sigma_mm[~filled][nearest].astype(np.float64)
    sigma[filled] = np.hypot(bulge, rim_sigma)
    return _Fills(sigma, patch)


def _fills_of(mesh: Mesh) -> _Fills:
    """The fills of a mesh with sigmas: the vertices without one."""
    assert mesh.sigma_mm is not None
    return _fills_among(mesh, ~np.isfinite(mesh.sigma_mm))


_fills = ByMesh(_fills_of)
"""Kept, as every measure that crosses a fill needs them."""


def _mean_curvature(mesh: Mesh, normals: Points3) -> float:
    """Typical curvature of the whole surface, 1/mm: of a sphere, 1 / radius."""
    areas = mesh.vertex_areas_mm2()
    centroid = areas @ mesh.vertices_mm / areas.sum()
    distance = np.einsum("ij,ij->i", mesh.vertices_mm - centroid, normals)
    return float(areas.sum() / max(float(areas @ np.abs(distance)), 1e-12))


def _curvature_near(
    mesh: Mesh,
    normals: Points3,
    filled: Bool[np.ndarray, " n"],
    vertices: Int64[np.ndarray, " k"],
) -> Float64[np.ndarray, " k"]:
    """RMS of the curvatures along the measured edges round each of these vertices, 1/mm."""
    ends = find_edges(mesh.faces).ends
    ends = ends[~filled[ends].any(axis=1)]
    expected = np.pi * _RIM_MM**2 * len(ends) / max(mesh.area_mm2(), 1e-12)
    ends = ends[:: max(1, int(expected / _EDGES))]
    edge = mesh.vertices_mm[ends[:, 1]] - mesh.vertices_mm[ends[:, 0]]
    normal_change = ((normals[ends[:, 1]] - normals[ends[:, 0]]) * edge).sum(axis=1)
    square = (normal_change / np.maximum((edge**2).sum(axis=1), 1e-12)) ** 2
    rim, at = np.unique(vertices, return_inverse=True)
    midpoints = KDTree(mesh.vertices_mm[ends].mean(axis=1))
    pairs = KDTree(mesh.vertices_mm[rim]).sparse_distance_matrix(
        midpoints, _RIM_MM, output_type="coo_matrix"
    )
    count = np.maximum(np.bincount(pairs.row, minlength=len(rim)), 1)
    return np.sqrt(np.bincount(pairs.row, square[pairs.col], len(rim)) / count)[at]
