"""Counterparts: the nearest places on a surface for points near it, and the side they lie on."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64
from scipy.spatial import KDTree

from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.core.mesh.signed_distance import SignedSurface
from limbgram.core.mesh.topology import find_edges
from limbgram.core.mesh.tree_cache import signed_on

_BRIM_STEP_MM = 1.0


@dataclass(frozen=True, kw_only=True)
class Counterparts:
    """The nearest place on a surface for each query point, with side and normals."""

    points_mm: Points3
    signed_mm: Float64[np.ndarray, " n"]
    """Distance of the query, positive outside the surface."""
    flat_normals: Points3
    """Normals of the nearest triangles."""
    smooth_normals: Points3
    """Normals interpolated between the vertices' normals."""
    at_brim: Bool[np.ndarray, " n"]
    """True where the nearest place lies on an open edge, so that the query may have none."""
    measured: Bool[np.ndarray, " n"]
    """False on triangles that were filled in, or lie near the brim."""


@dataclass(frozen=True, kw_only=True)
class CounterpartSurface:
    """A surface prepared for queries of counterparts."""

    mesh: Mesh
    surface: SignedSurface
    smooth_normals: Points3
    measured: Bool[np.ndarray, " f"]

    @classmethod
    def of(cls, mesh: Mesh, brim_mm: float) -> "CounterpartSurface":
        """Prepare a mesh; a strip of width `brim_mm` along open edges counts as not measured."""
        return cls(
            mesh=mesh,
            surface=signed_on(mesh),
            smooth_normals=mesh.vertex_normals(),
            measured=measured_faces(mesh, brim_mm),
        )

    def counterparts(self, points_mm: Points3) -> Counterparts:
        found = self.surface.query(points_mm)
        smooth = self.smooth_normals[self.mesh.faces[found.faces]]
        return Counterparts(
            points_mm=found.points_mm,
            signed_mm=found.signed_mm,
            flat_normals=self.surface.flat_normals[found.faces],
            smooth_normals=unit(np.einsum("nk,nkc->nc", found.shares, smooth)),
            at_brim=found.at_brim,
            measured=self.measured[found.faces],
        )


def measured_vertices(mesh: Mesh, brim_mm: float) -> Bool[np.ndarray, " n"]:
    """False at vertices that were filled in, or lie within `brim_mm` of an open edge."""
    measured = mesh.measured
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
