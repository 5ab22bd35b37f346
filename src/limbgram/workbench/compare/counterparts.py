"""Counterparts: for places near a surface, where they belong on it and on which side they lie.

The side follows from the angle-weighted normal of the face, edge or corner that is nearest
(Baerentzen and Aanaes 2005); the normal of one face alone is wrong near sharp edges.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.spatial import KDTree

from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.closest import TriangleTree
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.core.mesh.topology import find_edges

_AT_EDGE = 1e-9
"""Barycentric weight under which a place counts as on the edge across."""
_BRIM_STEP_MM = 1.0


@dataclass(frozen=True, kw_only=True)
class Counterparts:
    """For each query: its nearest place on the surface."""

    points_mm: Points3
    signed_mm: Float64[np.ndarray, " n"]
    """Distance of the query, positive outside the surface."""
    flat_normals: Points3
    """Of the nearest triangle."""
    smooth_normals: Points3
    """Interpolated between the vertices' normals."""
    at_brim: Bool[np.ndarray, " n"]
    """True where the nearest place lies on an open edge, so that the query may have none."""
    measured: Bool[np.ndarray, " n"]
    """False on triangles that were filled in, or lie near the brim."""


@dataclass(frozen=True, kw_only=True)
class Ground:
    """A surface made ready to be asked for counterparts."""

    mesh: Mesh
    tree: TriangleTree
    flat_normals: Float64[np.ndarray, "f 3"]
    smooth_normals: Points3
    corner_normals: Points3
    """Angle-weighted, by vertex."""
    edge_of_half_edge: Int64[np.ndarray, " h"]
    edge_normals: Float64[np.ndarray, "e 3"]
    open_edges: Bool[np.ndarray, " e"]
    open_vertices: Bool[np.ndarray, " n"]
    measured: Bool[np.ndarray, " f"]

    @classmethod
    def of(cls, mesh: Mesh, brim_mm: float) -> "Ground":
        """brim_mm: width of the strip along open edges that counts as not measured."""
        edges = find_edges(mesh.faces)
        flat = unit(mesh.face_normals())
        edge_normals = np.zeros((len(edges.ends), 3))
        for axis in range(3):
            edge_normals[:, axis] = np.bincount(
                edges.of_half_edge, np.repeat(flat[:, axis], 3), len(edges.ends)
            )
        open_edges = edges.uses == 1
        open_vertices = np.zeros(len(mesh), bool)
        open_vertices[edges.ends[open_edges]] = True
        return cls(
            mesh=mesh,
            tree=TriangleTree.of(mesh.vertices_mm, mesh.faces),
            flat_normals=flat,
            smooth_normals=mesh.vertex_normals(),
            corner_normals=_corner_normals(mesh, flat),
            edge_of_half_edge=edges.of_half_edge,
            edge_normals=edge_normals,
            open_edges=open_edges,
            open_vertices=open_vertices,
            measured=measured_faces(mesh, brim_mm),
        )

    def counterparts(self, points_mm: Points3) -> Counterparts:
        closest = self.tree.closest(points_mm)
        faces = self.mesh.faces[closest.faces]
        weights = _barycentric(self.mesh.vertices_mm[faces], closest.points_mm)
        edges, at_corner = self.edge_of_half_edge.reshape(-1, 3)[closest.faces], weights.argmax(1)
        rows = np.arange(len(faces))
        zero = weights < _AT_EDGE
        on_corner, on_edge = zero.sum(1) == 2, zero.sum(1) == 1
        corner = faces[rows, at_corner]
        edge = edges[rows, (zero.argmax(1) + 1) % 3]  # corner k lies across half-edge k + 1
        side = self.flat_normals[closest.faces].copy()
        side[on_edge] = self.edge_normals[edge[on_edge]]
        side[on_corner] = self.corner_normals[corner[on_corner]]
        away = np.einsum("nc,nc->n", points_mm - closest.points_mm, side)
        return Counterparts(
            points_mm=closest.points_mm,
            signed_mm=np.where(away < 0, -1.0, 1.0) * closest.distances_mm,
            flat_normals=self.flat_normals[closest.faces],
            smooth_normals=unit(np.einsum("nk,nkc->nc", weights, self.smooth_normals[faces])),
            at_brim=(on_edge & self.open_edges[edge]) | (on_corner & self.open_vertices[corner]),
            measured=self.measured[closest.faces],
        )


def measured_vertices(mesh: Mesh, brim_mm: float) -> Bool[np.ndarray, " n"]:
    """False at vertices that were filled in, or lie within `brim_mm` of an open edge."""
    measured = np.ones(len(mesh), bool) if mesh.filled is None else ~mesh.filled
    brim = brim_points(mesh)
    if len(brim) and brim_mm > 0:
        within = float(np.nextafter(brim_mm, np.inf))
        away_mm = KDTree(brim).query(mesh.vertices_mm, distance_upper_bound=within)[0]
        measured = measured & np.isinf(away_mm)
    return measured


def measured_faces(mesh: Mesh, brim_mm: float) -> Bool[np.ndarray, " f"]:
    """True where all three corners are measured and away from the brim."""
    return np.asarray(measured_vertices(mesh, brim_mm)[mesh.faces].all(1))


def brim_points(mesh: Mesh) -> Points3:
    """Points at most a millimetre apart along all open edges."""
    edges = find_edges(mesh.faces)
    ends = mesh.vertices_mm[edges.ends[edges.uses == 1]]
    if not len(ends):
        return np.empty((0, 3))
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    pieces = np.maximum(np.ceil(lengths / _BRIM_STEP_MM), 1).astype(np.int64)
    edge = np.repeat(np.arange(len(ends)), pieces)
    share = (np.arange(len(edge)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[edge]
    return ends[edge, 0] + share[:, None] * (ends[edge, 1] - ends[edge, 0])


def _corner_normals(mesh: Mesh, flat: Float64[np.ndarray, "f 3"]) -> Points3:
    corners = mesh.vertices_mm[mesh.faces]
    normals = np.zeros_like(mesh.vertices_mm)
    for k in range(3):
        one = unit(corners[:, (k + 1) % 3] - corners[:, k])
        two = unit(corners[:, (k + 2) % 3] - corners[:, k])
        angle = np.arctan2(
            np.linalg.norm(np.cross(one, two), axis=1), np.einsum("fc,fc->f", one, two)
        )
        for axis in range(3):
            normals[:, axis] += np.bincount(
                mesh.faces[:, k], angle * flat[:, axis], len(mesh.vertices_mm)
            )
    return normals


def _barycentric(
    corners: Float64[np.ndarray, "n 3 3"], points: Points3
) -> Float64[np.ndarray, "n 3"]:
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    square = np.maximum(np.einsum("nc,nc->n", normal, normal), 1e-300)
    of_b = np.einsum("nc,nc->n", np.cross(points - a, c - a), normal) / square
    of_c = np.einsum("nc,nc->n", np.cross(b - a, points - a), normal) / square
    weights = np.clip(np.column_stack([1 - of_b - of_c, of_b, of_c]), 0, 1)
    return weights / np.maximum(weights.sum(1, keepdims=True), 1e-300)
