"""Signed distance: how far places lie from a surface, and on which side of it.

The side follows from the angle-weighted normal of the face, edge or corner that is nearest
(Baerentzen and Aanaes 2005); the normal of one face alone is wrong beyond sharp edges.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.closest import TriangleTree, nearest_shares
from limbgram.core.mesh.mesh import crosses, dots, unit
from limbgram.core.mesh.topology import Edges, find_edges

_AT_EDGE = 1e-9
"""A corner's share under which a place counts as on the edge across."""


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
    def _edge_normals(self) -> Float64[np.ndarray, "e 3"]:
        of_edge, count = self._edges.of_half_edge, len(self._edges.ends)
        flat = np.repeat(self.flat_normals, 3, axis=0)
        return unit(np.stack([np.bincount(of_edge, one, count) for one in flat.T], axis=1))

    @cached_property
    def _corner_normals(self) -> Points3:
        """Each face's normal, weighted by its angle at the vertex."""
        corners, count = self.vertices_mm[self.faces], len(self.vertices_mm)
        total = np.zeros((count, 3))
        for k in range(3):
            one = unit(corners[:, (k + 1) % 3] - corners[:, k])
            two = unit(corners[:, (k + 2) % 3] - corners[:, k])
            angles = np.arctan2(np.linalg.norm(np.cross(one, two), axis=1), dots(one, two))
            weighted = angles[:, None] * self.flat_normals
            at = self.faces[:, k]
            total += np.stack([np.bincount(at, part, count) for part in weighted.T], axis=1)
        return unit(total)
