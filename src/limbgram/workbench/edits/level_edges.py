"""Level edges: keeps open edges in their planes while the surface is offset.

In      a Mesh, its planes, and the displacement of each vertex.
Out     displacements that leave the edges in their planes.
Method  A vertex slides along the surface, so that it stays as far from where it was as it was to
        be: on the edge until it is in the plane, farther in less and less, down to nothing.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    boundary_loops,
    edge_lengths,
    find_edges,
)
from limbgram.reconstruction.surface.holes import loop_area
from limbgram.workbench.edits.regions import smooth_normals

FLAT_MM = 0.01
"""Edges that leave a plane by no more lie in it: of what was cut by one, files in 32 bits and cuts
through vertices leave less."""
_SLIDE_DEPTH = 4.0
"""Depth to which vertices slide, as a multiple of the farthest slide on the edge: each comes at
most a quarter nearer to the edge than its neighbour, so that none passes another."""
_FREE_SINE, _HELD_SINE = np.sin(np.radians([55.0, 62.0]))
"""Sines of the angle between surface and plane up to which an edge is free, and from which it is
held: a wall that ends in a more oblique plane would end in an acute lip."""


@dataclass(frozen=True)
class Plane:
    """The plane of the points p with normal . p = level_mm."""

    normal: Float64[np.ndarray, "3"]
    level_mm: float

    @classmethod
    def of_loop(cls, mesh: Mesh, loop: Int64[np.ndarray, " l"]) -> "Plane | None":
        """The plane of an open edge; None where it lies in none."""
        points = mesh.vertices_mm[loop]
        (normal,) = unit(loop_area(points)[None])
        plane = cls(normal, float((points @ normal).mean()))
        return plane if normal.any() and plane.holds(points).all() else None

    def above_mm(self, points_mm: Float64[np.ndarray, "k 3"]) -> Float64[np.ndarray, " k"]:
        """Signed distance of places from the plane, positive on the normal's side."""
        return np.einsum("ij,j->i", points_mm, self.normal) - self.level_mm

    def holds(self, points_mm: Float64[np.ndarray, "k 3"]) -> Bool[np.ndarray, " k"]:
        """Which places lie in the plane."""
        return np.abs(self.above_mm(points_mm)) <= FLAT_MM


def open_edge_planes(mesh: Mesh) -> tuple[Plane, ...]:
    """The planes in which whole open edges of a mesh lie."""
    loops = (loop.astype(np.int64) for loop in boundary_loops(mesh.faces))
    return tuple(plane for loop in loops if (plane := Plane.of_loop(mesh, loop)) is not None)


def with_edges_in_planes(mesh: Mesh, planes: tuple[Plane, ...], moves: Points3) -> Points3:
    """The moves, changed so that open edges that lie in a plane stay in it.

    Args:
        planes: Those of the untrimmed surface, of which this one may be a part.
    """
    border = np.unique(boundary_half_edges(mesh.faces)).astype(np.int64)
    for plane in planes:
        edge = border[plane.holds(mesh.vertices_mm[border])]
        if len(edge):
            moves = _with_edge_in_plane(mesh, plane, edge, moves)
    return moves


def plane_hold(plane: Plane, normals: Points3) -> Float64[np.ndarray, " n"]:
    """How firmly an edge is held in a plane, by the surface's normals: 0 where it is free, 1 where
    it stays."""
    sines = np.sqrt(np.maximum(1 - np.einsum("ij,j->i", normals, plane.normal) ** 2, 0.0))
    return np.clip((sines - _FREE_SINE) / (_HELD_SINE - _FREE_SINE), 0.0, 1.0)


def _with_edge_in_plane(
    mesh: Mesh, plane: Plane, edge: Int64[np.ndarray, " e"], moves: Points3
) -> Points3:
    rise_mm = np.einsum("ij,j->i", moves, plane.normal)
    depth_mm = _SLIDE_DEPTH * float(np.abs(rise_mm[edge]).max())
    if not depth_mm > 0:
        return moves
    ends = find_edges(mesh.faces).ends
    sizes_mm = edge_lengths(mesh.vertices_mm, ends)
    links = csr_array((sizes_mm, (ends[:, 0], ends[:, 1])), shape=(len(mesh), len(mesh)))
    away_mm = dijkstra(links, directed=False, indices=edge, min_only=True, limit=2 * depth_mm)
    inside_mm = np.abs(plane.above_mm(mesh.vertices_mm))
    share = np.where(np.isfinite(away_mm), np.clip(1 - inside_mm / depth_mm, 0.0, 1.0), 0.0)
    share[edge] = 1.0
    normals = smooth_normals(mesh)
    along = plane.normal - np.einsum("ij,j->i", normals, plane.normal)[:, None] * normals
    rises = np.einsum("ij,ij->i", along, along)  # of a step of it: the sine of the angle, squared
    held = plane_hold(plane, normals)
    step = -held * share * rise_mm / np.maximum(rises, _FREE_SINE**2)
    return moves + step[:, None] * along
