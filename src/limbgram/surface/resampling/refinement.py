"""Refinement: near-equilateral triangles of one size on the same surface.

In      a manifold Mesh.
Out     a Mesh of the asked edge length; its boundary curve stays where it was.
Method  split, collapse, flip, smooth along the surface, return to it (Botsch, Kobbelt 2004).
Fails   SurfaceError: the mesh is not a manifold.
"""

import numpy as np

from limbgram.errors import SurfaceError
from limbgram.run import track
from limbgram.surface.closest import TriangleTree
from limbgram.surface.mesh import Mesh
from limbgram.surface.resampling.passes import (
    Triangles,
    collapse_short,
    flip_to_delaunay,
    smooth_along,
    split_long,
)
from limbgram.surface.topology import is_edge_manifold, taking_vertices

_ROUNDS = 5


def refine(mesh: Mesh, edge_mm: float) -> Mesh:
    """Even triangles with edges of about `edge_mm`, on the given surface.

    Colour, filled mark and sigma come from the nearest vertex of the given mesh.
    """
    if not is_edge_manifold(mesh.faces):
        raise SurfaceError("Only a manifold mesh can be refined; repair it first.")
    tree = TriangleTree.of(mesh.vertices_mm, mesh.faces)
    work = Triangles(
        mesh.vertices_mm, mesh.faces, np.zeros(len(mesh.faces), np.bool_), np.arange(len(mesh))
    )
    for _ in track(range(_ROUNDS)):
        work = even_out(work, edge_mm)
        inside = ~work.fixed()
        work.vertices[inside] = tree.closest(work.vertices[inside]).points_mm
    nearest = _nearest_corners(mesh, tree, work.vertices)
    result = taking_vertices(mesh, nearest)
    return Mesh(
        vertices_mm=work.vertices,
        faces=work.faces,
        colours=result.colours,
        filled=result.filled,
        sigma_mm=result.sigma_mm,
        repairs=mesh.repairs,
    )


def even_out(work: Triangles, edge: float) -> Triangles:
    """One round towards edges of one length."""
    work = split_long(work, 4 / 3 * edge)
    for _ in range(2):
        work = collapse_short(work, 4 / 5 * edge, 4 / 3 * edge)
    for _ in range(2):
        work = flip_to_delaunay(work)
    return smooth_along(work)


def _nearest_corners(mesh: Mesh, tree: TriangleTree, places: np.ndarray) -> np.ndarray:
    """Vertex of the mesh nearest to each place, among the corners of the face nearest to it."""
    corners = mesh.faces[tree.closest(places).faces]
    apart = np.linalg.norm(mesh.vertices_mm[corners] - places[:, None], axis=2)
    return np.take_along_axis(corners, apart.argmin(1)[:, None], 1)[:, 0]
