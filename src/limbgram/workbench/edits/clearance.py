"""Clearance: how far places are beyond a wall's thickness from the skin that it covers.

In      an open Mesh and the wall's thickness.
Out     how far places are beyond that distance, and places and triangles moved to it.
Method  The level of the distance on a grid has no folds and no crossings, however the skin bends:
        it bridges creases. Its vertices are then moved to the distance itself, and the chords of
        its triangles off what stands out of the skin.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64, Int32, Int64

from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.core.mesh.signed_distance import SignedSurface
from limbgram.core.mesh.topology import edge_lengths, find_edges
from limbgram.workbench.edits.fineness import refine_where

_CELL, _CELL_SHARE, _MOST_CELLS = 1.25, 0.5, 4e6
"""Size of a cell: in edges of a usual triangle, and as a share of the thickness at most; and how
many cells there are at most, which makes them larger."""
_NEARER, _FARTHER = -3.0, 4.0
"""Cells between which, beyond the level, distances have to be exact for its places to be."""
_MOVES, _EASINGS = 3, 2
"""Times that vertices are moved to the distance, and that chords are moved off what stands out."""
FINER, FINE_TO = 0.5, 4.0
"""Of a usual edge: edges near the open edge, and to how many cells from there. Round the open edge
the level bends as tightly as the wall is thick, and chords of it come nearer to the skin."""


@dataclass(frozen=True)
class Clearance:
    """A skin that is to become a wall."""

    mesh: Mesh
    thickness_mm: float

    @cached_property
    def surface(self) -> SignedSurface:
        return SignedSurface(self.mesh.vertices_mm, self.mesh.faces)

    @property
    def tree(self) -> TriangleTree:
        return self.surface.tree

    @cached_property
    def edge_mm(self) -> float:
        """Of a usual triangle."""
        ends = find_edges(self.mesh.faces).ends
        return float(np.median(edge_lengths(self.mesh.vertices_mm, ends)))

    @cached_property
    def cell_mm(self) -> float:
        wanted = min(_CELL * self.edge_mm, _CELL_SHARE * self.thickness_mm)
        box_mm3 = float(np.ptp(self.mesh.vertices_mm, axis=0).prod())
        return max(wanted, (box_mm3 / _MOST_CELLS) ** (1 / 3))

    def farther_mm(
        self, lowest_mm: Vector3, counts: Int64[np.ndarray, "3"]
    ) -> Float64[np.ndarray, "x y z"]:
        """How much farther than the thickness the nodes of a grid are from the skin: exact near
        that level, of the right sign elsewhere.

        Args:
            lowest_mm: The grid's first node; the skin lies within the grid.
        """
        from scipy.ndimage import distance_transform_edt  # a tenth of a second, for walls alone

        cell_mm = self.cell_mm
        bare = Mesh(vertices_mm=self.mesh.vertices_mm, faces=self.mesh.faces)
        fine = refine_where(bare, np.ones(len(bare.faces), np.bool_), 2 * cell_mm)
        nodes = np.rint((fine.vertices_mm - lowest_mm) / cell_mm).astype(np.int64)
        empty = np.ones(counts, np.bool_)
        empty[tuple(nodes.T)] = False
        # To the nearest node with a vertex: too near by 0.9 cells at most, too far by 2.1.
        values = cell_mm * np.asarray(distance_transform_edt(empty)) - self.thickness_mm
        near = (values > _NEARER * cell_mm) & (values < _FARTHER * cell_mm)
        points = lowest_mm + cell_mm * np.argwhere(near)
        values[near] = self.tree.closest(points).distances_mm - self.thickness_mm
        return values

    def settled(self, points_mm: Points3, faces: Int32[np.ndarray, "k 3"]) -> Points3:
        """Places moved straight to or from the nearest place of the skin, to the wall's thickness,
        and corners of faces of whose middles these are too near away from it by as much."""
        for _ in range(_MOVES):
            points_mm = self._at_distance(points_mm)
        for _ in range(_EASINGS):
            points_mm = self._off_chords(points_mm, faces)
        return points_mm

    def _at_distance(self, points_mm: Points3) -> Points3:
        nearest = self.tree.closest(points_mm)
        size = np.maximum(nearest.distances_mm, 1e-9)[:, None]
        return nearest.points_mm + (points_mm - nearest.points_mm) * self.thickness_mm / size

    def _off_chords(self, points_mm: Points3, faces: Int32[np.ndarray, "k 3"]) -> Points3:
        middles = points_mm[faces].mean(1)
        nearest = self.tree.closest(middles)
        lacking_mm = np.maximum(self.thickness_mm - nearest.distances_mm, 0.0)
        away = unit(middles - nearest.points_mm)
        most_mm, step = np.zeros(len(points_mm)), np.zeros_like(points_mm)
        for corner in range(3):
            np.maximum.at(most_mm, faces[:, corner], lacking_mm)
            np.add.at(step, faces[:, corner], lacking_mm[:, None] * away)
        return points_mm + most_mm[:, None] * unit(step)
