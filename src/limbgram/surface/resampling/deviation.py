"""Deviation: how far two surfaces lie apart, both ways."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.geometry.arrays import Points3
from limbgram.surface.closest import TriangleTree
from limbgram.surface.mesh import Mesh
from limbgram.surface.topology import find_edges


@dataclass(frozen=True, kw_only=True)
class Deviation:
    """Distances between two surfaces, taken at vertices, edge middles and face middles."""

    max_mm: float
    """Largest, either way."""
    rms_mm: float
    """Larger of the two ways' root mean squares, weighted by area."""


def measure_deviation(first: Mesh, second: Mesh) -> Deviation:
    """How far each of two surfaces is from the other."""
    ways = [_one_way(first, second), _one_way(second, first)]
    return Deviation(max_mm=max(way.max_mm for way in ways), rms_mm=max(way.rms_mm for way in ways))


def _one_way(source: Mesh, target: Mesh) -> Deviation:
    tree = TriangleTree.of(target.vertices_mm, target.faces)
    edges = find_edges(source.faces)
    at_corners = tree.closest(source.vertices_mm).distances_mm[source.faces]
    at_edges = tree.closest(source.vertices_mm[edges.ends].mean(1)).distances_mm
    at_faces = tree.closest(_middles(source)).distances_mm
    areas = np.linalg.norm(source.face_normals(), axis=1)
    # Quadrature over a triangle, exact for cubics: 1/20, 2/15 and 9/20 of the area.
    squares = (
        (at_corners**2).sum(1) / 20
        + (at_edges**2)[edges.of_half_edge.reshape(-1, 3)].sum(1) * (2 / 15)
        + at_faces**2 * (9 / 20)
    )
    return Deviation(
        max_mm=float(max(at_corners.max(), at_edges.max(), at_faces.max())),
        rms_mm=float(np.sqrt((squares * areas).sum() / areas.sum())),
    )


def _middles(mesh: Mesh) -> Float64[np.ndarray, "f 3"]:
    corners: Points3 = mesh.vertices_mm[mesh.faces]
    return corners.mean(1)
