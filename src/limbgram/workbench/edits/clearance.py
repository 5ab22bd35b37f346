"""Clearance: the distance field round a skin, from which a wall of a given thickness is made.

In      an open Mesh and the wall's thickness.
Out     distances beyond that thickness, and points and triangles moved to it.
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
from limbgram.workbench.edits.refinement import refine_where

_CELL_EDGES, _CELL_SHARE, _MOST_CELLS = 1.25, 0.5, 4e6
"""Size of a cell: in median edges, and at most as a share of the thickness; and the greatest number
of cells, above which they become larger."""
_EXACT_FROM, _EXACT_TO = -3.0, 4.0
"""Distances are exact between so many cells on this side of the level and on the other."""
_MOVE_ROUNDS, _CHORD_ROUNDS = 3, 2
"""Rounds of moving vertices to the distance, and of moving chords clear of the skin."""
RIM_EDGE_SHARE, RIM_CELLS = 0.5, 4.0
"""Edge length near the open edge, as a share of the median edge, and to how many cells from there.
Round the open edge the level's radius is the thickness, and its chords come nearer to the skin."""


@dataclass(frozen=True)
class Clearance:
    """A skin that is to become a wall, with its distance field."""

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
        """The median edge length."""
        ends = find_edges(self.mesh.faces).ends
        return float(np.median(edge_lengths(self.mesh.vertices_mm, ends)))

    @cached_property
    def cell_mm(self) -> float:
        wanted = min(_CELL_EDGES * self.edge_mm, _CELL_SHARE * self.thickness_mm)
        box_mm3 = float(np.ptp(self.mesh.vertices_mm, axis=0).prod())
        return max(wanted, (box_mm3 / _MOST_CELLS) ** (1 / 3))

    def excess_mm(
        self, lowest_mm: Vector3, counts: Int64[np.ndarray, "3"]
    ) -> Float64[np.ndarray, "x y z"]:
        """Distance of a grid's nodes from the skin, less the thickness: exact near that level,
        of the right sign elsewhere.

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
        near = (values > _EXACT_FROM * cell_mm) & (values < _EXACT_TO * cell_mm)
        points = lowest_mm + cell_mm * np.argwhere(near)
        values[near] = self.tree.closest(points).distances_mm - self.thickness_mm
        return values

    def moved_to_thickness(self, points_mm: Points3, faces: Int32[np.ndarray, "k 3"]) -> Points3:
        """Points moved to the wall's thickness from the skin, and then away from it where the
        centres of their faces, or the middles of their edges, are too near."""
        for _ in range(_MOVE_ROUNDS):
            points_mm = self._moved_to_distance(points_mm)
        for _ in range(_CHORD_ROUNDS):
            points_mm = self._with_chords_clear(points_mm, faces)
        return points_mm

    def _moved_to_distance(self, points_mm: Points3) -> Points3:
        nearest = self.tree.closest(points_mm)
        size = np.maximum(nearest.distances_mm, 1e-9)[:, None]
        return nearest.points_mm + (points_mm - nearest.points_mm) * self.thickness_mm / size

    def _with_chords_clear(self, points_mm: Points3, faces: Int32[np.ndarray, "k 3"]) -> Points3:
        most_mm, step = np.zeros(len(points_mm)), np.zeros_like(points_mm)
        for chords in (faces, find_edges(faces).ends):
            middles = points_mm[chords].mean(1)
            nearest = self.tree.closest(middles)
            lacking_mm = np.maximum(self.thickness_mm - nearest.distances_mm, 0.0)
            away = unit(middles - nearest.points_mm)
            for corners in chords.T:
                np.maximum.at(most_mm, corners, lacking_mm)
                np.add.at(step, corners, lacking_mm[:, None] * away)
        return points_mm + most_mm[:, None] * unit(step)
