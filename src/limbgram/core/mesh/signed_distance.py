"""Signed distance: how far places lie from a surface, and on which side of it.

The side follows from the angle-weighted normal of the face, edge or corner that is nearest
(Baerentzen and Aanaes 2005); the normal of one face alone is wrong beyond sharp edges. A face
without area, as along an edge that has a vertex on one side alone, has no normal: each of its sides
joins the faces beyond it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.closest_point import TriangleTree, nearest_shares
from limbgram.core.mesh.mesh import crosses, dots, unit
from limbgram.core.mesh.topology import Edges, find_edges

_AT_EDGE = 1e-9
"""A corner's share under which a place counts as on the edge across, and the height of a face over
its longest side, in shares of that, under which it has no area."""
_MOST_FLAT = 64
"""Faces without area, one beside the other, through which is looked."""


@dataclass(frozen=True, kw_only=True)
class Signed:
    """For each query: its nearest place on the surface, and the side on which it lies."""

    points_mm: Points3
    """The nearest places."""
    signed_mm: Float64[np.ndarray, " n"]
    """Distance of the query, positive outside the surface."""
    faces: Int64[np.ndarray, " n"]
    shares: Float64[np.ndarray, "n 3"]
    """Weights of the face's corners at the nearest place."""
    normals: Points3
    """Unit and outward, of the face, edge or corner that is nearest: what told the side."""
    at_brim: Bool[np.ndarray, " n"]
    """True where the nearest place lies on an open edge."""


@dataclass(frozen=True)
class SignedSurface:
    """Triangles, counter-clockwise seen from outside, made ready to be asked on which side places
    lie. What an answer needs is made when it is first asked for.
    """

    vertices_mm: Points3
    faces: Faces

    @cached_property
    def tree(self) -> TriangleTree:
        """The tree alone, for who asks for nearest places only.

        Raises:
            ValueError: there is no face.
        """
        return TriangleTree.of(self.vertices_mm, self.faces)

    @cached_property
    def flat_normals(self) -> Float64[np.ndarray, "f 3"]:
        """Unit normals of the faces."""
        return unit(crosses(self.vertices_mm, self.faces))

    def signed(self, points_mm: Points3) -> Signed:
        """Where places lie."""
        closest = self.tree.closest(points_mm)
        faces = self.faces[closest.faces]
        shares = nearest_shares(self.vertices_mm[faces], points_mm)
        none = shares < _AT_EDGE
        on_corner, on_edge = none.sum(1) == 2, none.sum(1) == 1
        corner = np.take_along_axis(faces, shares.argmax(1)[:, None], 1)[:, 0]
        across = (none.argmax(1) + 1) % 3  # corner k lies across half-edge k + 1
        edge = self._edges.of_half_edge[3 * closest.faces + across]
        flat = self._flat[closest.faces] & ~on_corner
        edge[flat & ~on_edge] = self._longest_edges[closest.faces[flat & ~on_edge]]
        on_edge |= flat
        normals = self.flat_normals[closest.faces]
        normals[on_edge] = self._edge_normals[edge[on_edge]]
        normals[on_corner] = self._corner_normals[corner[on_corner]]
        beyond = dots(points_mm - closest.points_mm, normals)
        open_edges = self._edges.uses == 1
        return Signed(
            points_mm=closest.points_mm,
            signed_mm=np.where(beyond < 0, -1.0, 1.0) * closest.distances_mm,
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
        """Each face's normal, from each of its sides.

        From the longest side of a face without area it is that of the faces beyond the others; from
        the others it is that of the face beyond the longest. Such faces may lie beside each other.
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
            seen = normals[beyond] * (shares > 0)
            told = np.stack([unit((shares * seen)[:, 1:].sum(1)), seen[:, 0], seen[:, 0]], axis=1)
            if np.array_equal(told, normals[sides]):
                break
            normals[sides] = told
        return normals.reshape(-1, 3, 3)

    @cached_property
    def _across(self) -> Int64[np.ndarray, " h"]:
        """The half-edge on the other side of each; -1 where there is none, or are several."""
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
        """Each face's normal, weighted by its angle at the vertex."""
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
