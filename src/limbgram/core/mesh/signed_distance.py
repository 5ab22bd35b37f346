"""Signed distance of points from a surface.

The sign follows from the angle-weighted pseudonormal of the nearest face, edge or vertex
(Baerentzen and Aanaes 2005); the normal of one face alone is wrong beyond sharp edges. A face
without area, as at a T-junction, has no normal: each of its sides takes that of the faces beyond.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.closest_point import TriangleTree, nearest_barycentric
from limbgram.core.mesh.mesh import crosses, dots, unit
from limbgram.core.mesh.topology import Edges, find_edges

_AT_EDGE = 1e-9
"""A barycentric coordinate below it is zero; so is the area of a face whose height is a smaller
share of its longest side."""
_MOST_FLAT = 64
"""Adjacent faces without area through which normals are carried."""


@dataclass(frozen=True, kw_only=True)
class SignedDistances:
    """For each query: the nearest point of the surface, and the signed distance."""

    points_mm: Points3
    """The nearest points."""
    signed_mm: Float64[np.ndarray, " n"]
    """Positive outside the surface."""
    faces: Int64[np.ndarray, " n"]
    shares: Float64[np.ndarray, "n 3"]
    """Barycentric coordinates of the nearest point in its face."""
    normals: Points3
    """Outward unit pseudonormals of the nearest face, edge or vertex."""
    at_brim: Bool[np.ndarray, " n"]
    """Whether the nearest point lies on an open edge."""


@dataclass(frozen=True)
class SignedSurface:
    """Triangles, counter-clockwise seen from outside; tree and pseudonormals are made lazily."""

    vertices_mm: Points3
    faces: Faces

    @cached_property
    def tree(self) -> TriangleTree:
        """Closest-point tree.

        Raises:
            ValueError: there is no face.
        """
        return TriangleTree.of(self.vertices_mm, self.faces)

    @cached_property
    def flat_normals(self) -> Float64[np.ndarray, "f 3"]:
        """Unit normals of the faces; zero without area."""
        return unit(crosses(self.vertices_mm, self.faces))

    def query(self, points_mm: Points3) -> SignedDistances:
        """Signed distances of points."""
        closest = self.tree.closest(points_mm)
        faces = self.faces[closest.faces]
        shares = nearest_barycentric(self.vertices_mm[faces], points_mm)
        zero = shares < _AT_EDGE
        on_corner, on_edge = zero.sum(1) == 2, zero.sum(1) == 1
        corner = np.take_along_axis(faces, shares.argmax(1)[:, None], 1)[:, 0]
        opposite = (zero.argmax(1) + 1) % 3  # corner k lies across half-edge k + 1
        edge = self._edges.of_half_edge[3 * closest.faces + opposite]
        flat = self._flat[closest.faces] & ~on_corner
        edge[flat & ~on_edge] = self._longest_edges[closest.faces[flat & ~on_edge]]
        on_edge |= flat
        normals = self.flat_normals[closest.faces]
        normals[on_edge] = self._edge_normals[edge[on_edge]]
        normals[on_corner] = self._corner_normals[corner[on_corner]]
        along_normal = dots(points_mm - closest.points_mm, normals)
        open_edges = self._edges.uses == 1
        return SignedDistances(
            points_mm=closest.points_mm,
            signed_mm=np.where(along_normal < 0, -1.0, 1.0) * closest.distances_mm,
            faces=closest.faces,
            shares=shares,
            normals=normals,
            at_brim=(on_edge & open_edges[edge]) | (on_corner & self._open_vertices[corner]),
        )

    @cached_property
    def _edges(self) -> Edges:
        return find_edges(self.faces)

    @cached_property
    def _open_vertices(self) -> Bool[np.ndarray, " n"]:
        found = np.zeros(len(self.vertices_mm), np.bool_)
        found[self._edges.ends[self._edges.uses == 1]] = True
        return found

    @cached_property
    def _sides_mm(self) -> Float64[np.ndarray, "f 3"]:
        corners = self.vertices_mm[self.faces]
        return np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)

    @cached_property
    def _flat(self) -> Bool[np.ndarray, " f"]:
        """Faces without area."""
        doubled = np.linalg.norm(crosses(self.vertices_mm, self.faces), axis=1)
        return doubled <= _AT_EDGE * self._sides_mm.max(1) ** 2

    @cached_property
    def _longest_edges(self) -> Int64[np.ndarray, " f"]:
        return self._edges.of_half_edge[3 * np.arange(len(self.faces)) + self._sides_mm.argmax(1)]

    @cached_property
    def _side_normals(self) -> Float64[np.ndarray, "f 3 3"]:
        """Each face's normal as its edges take it, by side.

        A face without area has on its longest side the normal of the faces beyond the other two,
        and on those the normal of the face beyond the longest. Such faces may be adjacent.
        """
        normals = np.repeat(self.flat_normals, 3, axis=0)
        flat = np.flatnonzero(self._flat)
        if not len(flat):
            return normals.reshape(-1, 3, 3)
        sides = 3 * flat[:, None] + (self._sides_mm[flat].argmax(1)[:, None] + np.arange(3)) % 3
        normals[sides] = 0.0
        beyond = self._across[sides]
        shares = np.where(beyond >= 0, self._sides_mm.ravel()[sides], 0.0)[..., None]
        for _ in range(min(len(flat), _MOST_FLAT)):
            behind = normals[beyond] * (shares > 0)
            two_sides = unit((shares * behind)[:, 1:].sum(1))
            after = np.stack([two_sides, behind[:, 0], behind[:, 0]], axis=1)
            if np.array_equal(after, normals[sides]):
                break
            normals[sides] = after
        return normals.reshape(-1, 3, 3)

    @cached_property
    def _across(self) -> Int64[np.ndarray, " h"]:
        """The opposite half-edge of each; -1 where there is none or several."""
        order, uses = self._edges.half_edges, self._edges.uses
        first = (np.cumsum(uses) - uses)[uses == 2]
        across = np.full(len(order), -1, np.int64)
        across[order[first]], across[order[first + 1]] = order[first + 1], order[first]
        return across

    @cached_property
    def _edge_normals(self) -> Float64[np.ndarray, "e 3"]:
        of_edge, count = self._edges.of_half_edge, len(self._edges.ends)
        sides = self._side_normals.reshape(-1, 3)
        return unit(np.stack([np.bincount(of_edge, one, count) for one in sides.T], axis=1))

    @cached_property
    def _corner_normals(self) -> Points3:
        """Vertex normals: face normals weighted by the angle at the vertex."""
        corners, count = self.vertices_mm[self.faces], len(self.vertices_mm)
        normals = self.flat_normals.copy()
        flat = np.flatnonzero(self._flat)  # has its angle across from the longest side
        normals[flat] = self._side_normals[flat, (self._sides_mm[flat].argmax(1) + 1) % 3]
        total = np.zeros((count, 3))
        for k in range(3):
            one = unit(corners[:, (k + 1) % 3] - corners[:, k])
            two = unit(corners[:, (k + 2) % 3] - corners[:, k])
            angles = np.arctan2(np.linalg.norm(np.cross(one, two), axis=1), dots(one, two))
            weighted = angles[:, None] * normals
            at = self.faces[:, k]
            total += np.stack([np.bincount(at, part, count) for part in weighted.T], axis=1)
        return unit(total)
