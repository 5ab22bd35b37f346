"""Distances over the surface, from a point or from a curve on it.

Method  fronts pass from triangle to triangle: circular ones from a point (Novotni and Klein 2002:
        the source is unfolded into each triangle's plane), straight ones from a curve (Kimmel
        and Sethian 1998); repeated until nothing changes. Exact on what can be unrolled.
"""

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.geometry.arrays import Faces, Points3, Vector3
from limbgram.surface.closest import TriangleTree
from limbgram.surface.mesh import Mesh

_MOST_ROUNDS = 5000
_SETTLED_MM = 1e-9


def distances_from_point(
    mesh: Mesh, point_mm: Vector3, limit_mm: float
) -> Float64[np.ndarray, " n"]:
    """Distance of each vertex from a point on the surface; infinite beyond the limit."""
    face = TriangleTree.of(mesh.vertices_mm, mesh.faces).closest(point_mm[None]).faces[0]
    straight = np.linalg.norm(mesh.vertices_mm - point_mm, axis=1)
    start = np.full(len(mesh), np.inf)
    touching = np.isin(mesh.faces, mesh.faces[face]).any(1)
    first = np.unique(mesh.faces[touching])
    start[first] = straight[first]
    return _spread(mesh, start, straight <= limit_mm, limit_mm, circular=True)


def distances_from(
    mesh: Mesh,
    start_mm: Float64[np.ndarray, " n"],
    allowed: Bool[np.ndarray, " n"],
    limit_mm: float,
) -> Float64[np.ndarray, " n"]:
    """Distance of each vertex from a curve, whose neighbours' distances are given.

    Args:
        start_mm: Known distances; infinite elsewhere.
        allowed: Vertices over which the way may lead.
    """
    return _spread(mesh, start_mm, allowed, limit_mm, circular=False)


def _spread(
    mesh: Mesh,
    start_mm: Float64[np.ndarray, " n"],
    allowed: Bool[np.ndarray, " n"],
    limit_mm: float,
    *,
    circular: bool,
) -> Float64[np.ndarray, " n"]:
    faces = mesh.faces[allowed[mesh.faces].all(1)].astype(np.int64)
    used, compact = np.unique(faces, return_inverse=True)
    compact = compact.reshape(-1, 3)
    triples = _Triples.of(mesh.vertices_mm[used], compact.astype(np.int32))
    distance = start_mm[used].copy()
    changed = np.isfinite(distance)
    for _ in range(_MOST_ROUNDS):
        busy = np.flatnonzero(changed[triples.a] | changed[triples.b])
        if not len(busy):
            break
        offered = triples.arrivals(busy, distance, circular=circular)
        better = distance.copy()
        np.minimum.at(better, triples.c[busy], offered)
        better[better > limit_mm] = np.inf
        changed = better < distance - _SETTLED_MM
        distance[changed] = better[changed]
    whole = start_mm.copy()
    whole[used] = distance
    return whole


class _Triples:
    """Every corner c of every face, seen across the edge from a to b."""

    def __init__(self, vertices: Points3, faces: Faces) -> None:
        self.a: Int64[np.ndarray, " t"] = np.concatenate([faces[:, k] for k in (0, 1, 2)])
        self.b: Int64[np.ndarray, " t"] = np.concatenate([faces[:, k] for k in (1, 2, 0)])
        self.c: Int64[np.ndarray, " t"] = np.concatenate([faces[:, k] for k in (2, 0, 1)])
        along = vertices[self.b] - vertices[self.a]
        to_c = vertices[self.c] - vertices[self.a]
        self.edge = np.maximum(np.linalg.norm(along, axis=1), 1e-12)
        self.c_along = (along * to_c).sum(1) / self.edge
        self.c_up = np.linalg.norm(np.cross(along, to_c), axis=1) / self.edge

    @classmethod
    def of(cls, vertices: Points3, faces: Faces) -> "_Triples":
        return cls(vertices, faces)

    def arrivals(
        self, rows: Int64[np.ndarray, " r"], distance: Float64[np.ndarray, " n"], *, circular: bool
    ) -> Float64[np.ndarray, " r"]:
        """When a front that reached a and b reaches c."""
        from_a, from_b = distance[self.a[rows]], distance[self.b[rows]]
        edge, x, y = self.edge[rows], self.c_along[rows], self.c_up[rows]
        round_edges = np.minimum(from_a + np.hypot(x, y), from_b + np.hypot(x - edge, y))
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            if circular:
                foot = (from_a**2 - from_b**2 + edge**2) / (2 * edge)
                below = np.sqrt(from_a**2 - foot**2)
                crossing = foot + (x - foot) * below / (below + y)
                through = np.hypot(x - foot, y + below)
            else:
                slope = (from_b - from_a) / edge
                rise = np.sqrt(1 - slope**2)
                crossing = x - y * slope / rise
                through = from_a + slope * x + rise * y
            passes = (crossing >= 0) & (crossing <= edge)
        return np.where(passes, through, round_edges)
