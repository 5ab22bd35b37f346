"""Geodesics: the shortest way over a surface between two places.

Method  Dijkstra over the middles of edges finds the faces that the way runs through; unfolded into
        a plane they give the way exactly, and where it bends round a corner whose other side is
        shorter, it is led round the other side (Xin and Wang 2007). The result is exact for the
        triangles: no way near it is shorter. A quite different way that is shorter by a few per
        cent could be missed only where two are nearly equal.
Fails   MeasureError: no surface joins the two places.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from limbgram.errors import MeasureError
from limbgram.geometry.arrays import Points3, Vector3
from limbgram.shape.measures.straightening import Net, straighten
from limbgram.surface.closest import TriangleTree
from limbgram.surface.mesh import Mesh
from limbgram.surface.topology import Edges, find_edges

_FIRST_REACH = 1.6
"""The way is first looked for among faces that a way so much longer than straight could touch."""


def shortest_path(mesh: Mesh, start_mm: Vector3, end_mm: Vector3) -> Points3:
    """The shortest polyline on the surface; both ends are first moved to the nearest place on it.

    Every piece lies in one triangle. `length_mm` gives its length.

    Raises:
        MeasureError: no surface joins the two places.
    """
    ends_mm = np.stack([start_mm, end_mm]).astype(np.float64)
    closest = TriangleTree.of(mesh.vertices_mm, mesh.faces).closest(ends_mm)
    first, last = (int(face) for face in closest.faces)
    places_mm = closest.points_mm
    if first == last:
        return places_mm.copy()
    apart_mm = float(np.linalg.norm(places_mm[1] - places_mm[0]))
    detours_mm = _shortest_detours_mm(mesh, places_mm)
    reach_mm = max(_FIRST_REACH * apart_mm, float(detours_mm[[first, last]].max()))
    while True:
        near = detours_mm <= reach_mm
        near[[first, last]] = True
        found = _path_within(mesh, np.flatnonzero(near), first, last, places_mm)
        if found is not None and (near.all() or length_mm(found) <= reach_mm):
            return found
        if near.all():
            raise MeasureError(
                "No surface joins the two places: they lie on separate pieces of the shape. "
                "Choose both on one piece, or repair the shape so that its pieces are joined."
            )
        reach_mm *= 2


def length_mm(path_mm: Points3) -> float:
    """Length of a polyline."""
    return float(np.linalg.norm(np.diff(path_mm, axis=0), axis=1).sum())


def _shortest_detours_mm(
    mesh: Mesh, places_mm: Float64[np.ndarray, "2 3"]
) -> Float64[np.ndarray, " f"]:
    """Per face: no way between the places that touches the face is shorter than this."""
    detours = np.linalg.norm(mesh.vertices_mm[:, None] - places_mm, axis=2).sum(1)
    corners = mesh.vertices_mm[mesh.faces]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(1)
    return detours[mesh.faces].min(1) - 2 * sides


def _path_within(
    mesh: Mesh,
    kept: Int64[np.ndarray, " k"],
    first: int,
    last: int,
    places_mm: Float64[np.ndarray, "2 3"],
) -> Points3 | None:
    """The shortest path inside the kept faces; None where they do not join the places."""
    faces = mesh.faces[kept]
    start, end = (int(face) for face in np.searchsorted(kept, [first, last]))
    edges = find_edges(faces)
    strip = _strip(mesh.vertices_mm, edges, _Ends(start, end, places_mm))
    if strip is None:
        return None
    net = Net(mesh.vertices_mm, faces, edges.of_half_edge.reshape(-1, 3), _neighbours(edges))
    return straighten(net, strip, places_mm[0], places_mm[1])


@dataclass(frozen=True)
class _Ends:
    """Faces and places where the way starts and ends."""

    start: int
    end: int
    places_mm: Float64[np.ndarray, "2 3"]


def _strip(vertices_mm: Points3, edges: Edges, ends: _Ends) -> list[int] | None:
    """Neighbouring faces from start to end: Dijkstra over edge middles."""
    middles = vertices_mm[edges.ends].mean(1)
    of_face = edges.of_half_edge.reshape(-1, 3)
    pairs = np.concatenate([of_face[:, [0, 1]], of_face[:, [1, 2]], of_face[:, [2, 0]]])
    steps = np.linalg.norm(middles[pairs[:, 0]] - middles[pairs[:, 1]], axis=1)
    # Two more nodes: the start and the end, joined to the edges of their faces.
    count = len(middles)
    for node, face, place in (
        (count, ends.start, ends.places_mm[0]),
        (count + 1, ends.end, ends.places_mm[1]),
    ):
        pairs = np.concatenate([pairs, np.column_stack([of_face[face], [node] * 3])])
        steps = np.concatenate([steps, np.linalg.norm(middles[of_face[face]] - place, axis=1)])
    graph = coo_array(
        (np.maximum(steps, 1e-300), (pairs[:, 0], pairs[:, 1])), shape=(count + 2, count + 2)
    )
    distances, before = dijkstra(
        graph.tocsr(), directed=False, indices=count, return_predecessors=True
    )
    if not np.isfinite(distances[count + 1]):
        return None
    nodes = [count + 1]
    while nodes[-1] != count:
        nodes.append(int(before[nodes[-1]]))
    crossed = np.array(nodes[-2:0:-1])
    return [ends.start, *_faces_between(of_face, crossed), ends.end]


def _faces_between(
    of_face: Int64[np.ndarray, "f 3"], crossed: Int64[np.ndarray, " k"]
) -> list[int]:
    """The face between each crossed edge and the next."""
    order = np.argsort(of_face, axis=None, kind="stable")
    sorted_edges = of_face.reshape(-1)[order]
    firsts = np.searchsorted(sorted_edges, crossed)
    lasts = np.searchsorted(sorted_edges, crossed, side="right")
    sides = [set((order[a:b] // 3).tolist()) for a, b in zip(firsts, lasts, strict=True)]
    return [min(one & two) for one, two in pairwise(sides)]


def _neighbours(edges: Edges) -> Int64[np.ndarray, "f 3"]:
    """Face across each side of each face; -1 where there is none or more than one."""
    sides = edges.faces().astype(np.int64)
    single: Bool[np.ndarray, " e"] = edges.uses == 2
    own = np.arange(len(edges.of_half_edge)) // 3
    pair = sides[edges.of_half_edge]
    other = np.where(pair[:, 0] == own, pair[:, 1], pair[:, 0])
    return np.where(single[edges.of_half_edge], other, -1).reshape(-1, 3)
