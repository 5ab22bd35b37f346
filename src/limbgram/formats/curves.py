"""Curves: sections, trimline and centreline of a surface, for drawings."""

from dataclasses import dataclass

import numpy as np

from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.sections import Section, area_and_centroid, cut, heights_between
from limbgram.core.mesh.topology import boundary_loops, is_edge_manifold, is_vertex_manifold


@dataclass(frozen=True, kw_only=True)
class Curves:
    """Curves of a surface."""

    sections: tuple[Section, ...]
    """Across z at multiples of a spacing."""
    trimline: tuple[Points3, ...] | None
    """The surface's boundary loops, the longest first: the brim, and holes if there are any. None
    where the surface is not manifold: its open edges form no loops."""

    @property
    def centreline_mm(self) -> Points3:
        """The centroids of the largest closed section of each height, from below upwards."""
        found: dict[float, tuple[float, float, float]] = {}
        for section in self.sections:
            area, x, y = area_and_centroid(section.points_mm)
            if section.closed and area > found.get(section.offset_mm, (0.0, 0.0, 0.0))[0]:
                found[section.offset_mm] = area, x, y
        rows = [(x, y, height) for height, (_, x, y) in sorted(found.items())]
        return np.array(rows).reshape(-1, 3)


def curves_of(mesh: Mesh, spacing_mm: float) -> Curves:
    """Sections at multiples of the spacing, and the trimline."""
    manifold = is_edge_manifold(mesh.faces) and is_vertex_manifold(mesh.faces)
    loops = boundary_loops(mesh.faces) if manifold else ()
    return Curves(
        sections=cut(mesh, heights_between(mesh, spacing_mm).tolist()),
        trimline=tuple(mesh.vertices_mm[loop] for loop in loops) if manifold else None,
    )
