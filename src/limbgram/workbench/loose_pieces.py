"""Loose pieces: loose scraps of surface that lie on the skin, and the small holes under them.

In      a Mesh in millimetres, edge- and vertex-manifold.
Out     the Mesh without them, and how many of what were taken away.
Method  a scrap is an open piece that lies within reach of a larger one all over. A hole under one
        is closed by triangles between its own vertices, so that no vertex moves and none is added.

A triangle that was torn off the skin leaves two open edges where the surface is whole: nothing
encloses a volume there any more, an opening seems to lie at the closed end, and a wall over both
would cut through itself.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64, Int32, Int64
from scipy.spatial import KDTree

from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    boundary_loops,
    face_components,
    find_edges,
    is_edge_manifold,
    is_vertex_manifold,
    with_faces,
)
from limbgram.findings import Finding, note
from limbgram.reconstruction.surface.cleaning import drop_degenerate_and_duplicate
from limbgram.reconstruction.surface.holes import edge_table, loop_triangles

TINY_SHARE = 3e-4
"""Of the largest piece's area, below which a scrap is taken away unasked: 30 mm2 on a leg. Those of
four limbs of a public shape model have 0.2e-4 to 1.3e-4 each."""
_FARTHEST_MM = 3.0
"""A scrap lies nearer than an edge of the skin's triangles, for finer there is no skin; and never
farther than this, however coarse these are. (The same limbs' scraps: up to 2.1 mm at edges of 3.)
"""
_MOST_CORNERS = 12
"""Of a hole under a scrap: the hole of three neighbouring triangles has 5 to 7."""


@dataclass(frozen=True)
class ScrapsRemoved:
    """A mesh without its loose scraps, and what was removed."""

    mesh: Mesh
    scraps: int = 0
    triangles: int = 0
    area_mm2: float = 0.0
    off_mm: float = 0.0
    """The farthest that a corner of them lay from the skin."""
    holes: int = 0
    """Closed under them."""

    def findings(self) -> tuple[Finding, ...]:
        """Findings about the scraps removed; none where there were none."""
        if not self.scraps:
            return ()
        return (
            note(
                "limb.scraps",
                count=self.scraps,
                triangles=self.triangles,
                area_mm2=self.area_mm2,
                off_mm=self.off_mm,
                holes=self.holes,
            ),
        )


def without_scraps(mesh: Mesh) -> ScrapsRemoved:
    """The mesh without the tiny scraps that lie on its skin, as every file is read."""
    pieces = open_pieces(mesh)
    if pieces is None:
        return ScrapsRemoved(mesh)
    return without_pieces(mesh, pieces, pieces.area_mm2 <= TINY_SHARE * pieces.area_mm2.max())


@dataclass(frozen=True)
class Pieces:
    """A mesh of several pieces."""

    of_face: Int32[np.ndarray, " f"]
    of_vertex: Int64[np.ndarray, " n"]
    area_mm2: Float64[np.ndarray, " p"]
    loose: Bool[np.ndarray, " p"]
    """Open ones beside the largest."""


def open_pieces(mesh: Mesh) -> Pieces | None:
    """The pieces of a mesh; None if all is one, or nothing is both open and beside the largest."""
    of_face = face_components(mesh.faces)
    if not of_face.max(initial=0):
        return None
    area_mm2 = np.bincount(of_face, np.linalg.norm(mesh.face_normals(), axis=1) / 2)
    of_vertex = np.zeros(len(mesh), np.int64)
    of_vertex[mesh.faces.ravel()] = np.repeat(of_face, 3)
    loose = np.zeros(len(area_mm2), np.bool_)
    loose[of_vertex[boundary_half_edges(mesh.faces)[:, 0]]] = True
    loose[area_mm2.argmax()] = False
    return Pieces(of_face, of_vertex, area_mm2, loose) if loose.any() else None


def without_pieces(
    mesh: Mesh, pieces: Pieces, asked: Bool[np.ndarray, " p"], reach_mm: float | None = None
) -> ScrapsRemoved:
    """The mesh without those loose pieces, of those asked for, that lie on the rest of it.

    Args:
        reach_mm: How far from the rest their corners may lie; None: an edge of its triangles.
    """
    small = asked & pieces.loose
    if not small.any():
        return ScrapsRemoved(mesh)
    of_small = small[pieces.of_face]
    skin = with_faces(mesh, mesh.faces[~of_small])
    usual_mm = min(_usual_edge_mm(skin), _FARTHEST_MM)
    reach = usual_mm if reach_mm is None else reach_mm
    ids = np.flatnonzero(small[pieces.of_vertex])
    tree = TriangleTree.of(skin.vertices_mm, skin.faces)
    farthest = np.zeros(len(small))
    np.maximum.at(farthest, pieces.of_vertex[ids], tree.closest(mesh.vertices_mm[ids]).distances_mm)
    gone = small & (farthest <= reach)
    if not gone.any():
        return ScrapsRemoved(mesh)
    faces = gone[pieces.of_face]
    rest = with_faces(mesh, mesh.faces[~faces])
    places = mesh.vertices_mm[mesh.faces[faces]]
    under = np.concatenate([places.reshape(-1, 3), places.mean(1)])
    closed = _with_holes_closed_near(rest, under, usual_mm)
    return ScrapsRemoved(
        mesh=closed.mesh,
        scraps=int(gone.sum()),
        triangles=int(faces.sum()),
        area_mm2=float(pieces.area_mm2[gone].sum()),
        off_mm=float(farthest[gone].max()),
        holes=closed.holes,
    )


def _usual_edge_mm(mesh: Mesh) -> float:
    ends = find_edges(mesh.faces).ends
    lengths = np.linalg.norm(mesh.vertices_mm[ends[:, 0]] - mesh.vertices_mm[ends[:, 1]], axis=1)
    return float(np.median(lengths))


@dataclass(frozen=True)
class _ClosedHoles:
    mesh: Mesh
    holes: int


def _with_holes_closed_near(mesh: Mesh, places_mm: Points3, reach_mm: float) -> _ClosedHoles:
    """The mesh with the small holes closed all of whose vertices lie by what was taken away."""
    near = KDTree(places_mm)
    holes = 0
    for loop in boundary_loops(mesh.faces):
        if len(loop) > _MOST_CORNERS:
            continue
        if float(np.max(near.query(mesh.vertices_mm[loop])[0])) > reach_mm:
            continue
        faces = _with_hole_closed(mesh, loop)
        if faces is not None:
            mesh, holes = replace(mesh, faces=faces), holes + 1
    return _ClosedHoles(with_faces(mesh, mesh.faces), holes) if holes else _ClosedHoles(mesh, 0)


def _with_hole_closed(mesh: Mesh, loop: Int32[np.ndarray, " l"]) -> Faces | None:
    """The faces with a hole closed by triangles on its own vertices; None where none are sound.

    Two holes that meet in a point are one loop, which has that point twice: the vertex was doubled
    there, and is one again.
    """
    places, first, kind = np.unique(
        mesh.vertices_mm[loop], axis=0, return_index=True, return_inverse=True
    )
    same = np.arange(len(mesh), dtype=np.int32)
    same[loop] = loop[first[kind]]
    faces = same[mesh.faces]
    edges, rings = edge_table(mesh.vertices_mm, faces), _simple_rings(same[loop].tolist())
    made = [loop_triangles(mesh.vertices_mm, edges, ring) for ring in rings if len(ring) > 2]
    sound = [part for part in made if part is not None]
    if len(places) < 3 or len(sound) < len(rings):
        return None
    closed = np.concatenate([faces, *sound]).astype(np.int32)
    fits = is_edge_manifold(closed) and is_vertex_manifold(closed)
    flat = len(drop_degenerate_and_duplicate(mesh.vertices_mm, closed)) < len(closed)
    return closed if fits and not flat else None


def _simple_rings(loop: list[int]) -> list[Int32[np.ndarray, " l"]]:
    """A loop split into rings where it revisits a vertex."""
    rings: list[Int32[np.ndarray, " l"]] = []
    path: list[int] = []
    for vertex in loop:
        if vertex in path:
            at = path.index(vertex)
            rings.append(np.array(path[at:], np.int32))
            path = path[:at]
        path.append(vertex)
    return [*rings, np.array(path, np.int32)]
