"""Refinement: edges split where an edit needs finer triangles, on the unchanged surface."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.core.geometry.arrays import Vector3
from limbgram.core.mesh.mesh import Mesh, lengths, longest_sides_mm
from limbgram.core.mesh.topology import Edges, find_edges

_MOST_ROUNDS = 16
_EDGES_PER_FALLOFF = 8.0
"""Least number of edges along a falloff."""
_FINEST_MM = 0.4
FaceSelector = Callable[[Mesh], Bool[np.ndarray, " f"]]
"""Selects the faces of a mesh that must be fine."""


def edge_for_falloff_mm(length_mm: float) -> float:
    """Edge length with which a falloff over a length looks smooth."""
    return max(length_mm / _EDGES_PER_FALLOFF, _FINEST_MM)


def faces_near(mesh: Mesh, point_mm: Vector3, reach_mm: float) -> Bool[np.ndarray, " f"]:
    """The faces that may come within reach of a point, however large they are."""
    corners = mesh.vertices_mm[mesh.faces]
    middle = corners.mean(1)
    size = np.linalg.norm(corners - middle[:, None], axis=2).max(1)
    return np.linalg.norm(middle - point_mm, axis=1) < reach_mm + size


@dataclass(frozen=True)
class SplitMesh:
    """A mesh with split edges; the old vertices come first, unchanged."""

    mesh: Mesh
    parents: Int64[np.ndarray, " f"]
    """Face of the old mesh that each face is a part of."""


def refine_where(mesh: Mesh, chosen: Bool[np.ndarray, " f"], edge_mm: float) -> Mesh:
    """Halve edges of the chosen faces, and of their parts, until none is longer."""
    for _ in range(_MOST_ROUNDS):
        division = _one_halving(mesh, chosen, edge_mm)
        if division is None:
            break
        mesh, chosen = division.mesh, chosen[division.parents]
    return mesh


def refine_selected(mesh: Mesh, select: FaceSelector, edge_mm: float) -> Mesh:
    """Halve edges of the faces that `select` finds in each round, until none is longer."""
    for _ in range(_MOST_ROUNDS):
        division = _one_halving(mesh, select(mesh), edge_mm)
        if division is None:
            break
        mesh = division.mesh
    return mesh


def _one_halving(mesh: Mesh, chosen: Bool[np.ndarray, " f"], edge_mm: float) -> SplitMesh | None:
    """One round of halving; None where no edge is too long.

    With a face's edge its longest edge is split too, so that no triangle becomes thin.
    """
    if longest_sides_mm(mesh.vertices_mm, mesh.faces[chosen]).max(initial=0.0) <= edge_mm:
        return None
    edges = find_edges(mesh.faces)
    ends = mesh.vertices_mm[edges.ends]
    long_mm = lengths(ends[:, 0] - ends[:, 1])
    face_edges = edges.of_half_edge.reshape(-1, 3)
    split = np.zeros(len(long_mm), np.bool_)
    split[face_edges[chosen]] = True
    split &= long_mm > edge_mm
    longest = np.take_along_axis(face_edges, long_mm[face_edges].argmax(1)[:, None], 1)[:, 0]
    while True:
        more = longest[split[face_edges].any(1)]
        if split[more].all():
            break
        split[more] = True
    return split_edges(mesh, edges, split, np.full(len(long_mm), 0.5))


def split_edges(
    mesh: Mesh,
    edges: Edges,
    split: Bool[np.ndarray, " e"],
    shares: Float64[np.ndarray, " e"],
) -> SplitMesh:
    """Split edges at a share of their length; each face becomes one to four."""
    made = np.flatnonzero(split)
    middle = np.full(len(split), -1, np.int64)
    middle[made] = len(mesh) + np.arange(len(made))
    grown = _with_edge_points(mesh, edges.ends[made].astype(np.int64), shares[made])
    on_face = middle[edges.of_half_edge].reshape(-1, 3)
    count = (on_face >= 0).sum(1)
    parts: list[np.ndarray] = [mesh.faces[count == 0].astype(np.int64)]
    parents: list[np.ndarray] = [np.flatnonzero(count == 0)]
    for marks in (1, 2, 3):
        rows = np.flatnonzero(count == marks)
        # Turned so that a single split edge, or a single whole one, comes first.
        turn = np.argmax((on_face[rows] >= 0) == (marks == 1), axis=1) if marks < 3 else 0 * rows
        order = (turn[:, None] + np.arange(3)) % 3
        corners = np.take_along_axis(mesh.faces[rows].astype(np.int64), order, 1)
        middles = np.take_along_axis(on_face[rows], order, 1)
        pieces = _parts_of_faces(grown, corners, middles, marks)
        parts.append(pieces.reshape(-1, 3))
        parents.append(np.repeat(rows, marks + 1))
    faces = np.concatenate(parts).astype(np.int32)
    return SplitMesh(replace(grown, faces=faces), np.concatenate(parents))


def _parts_of_faces(
    mesh: Mesh, corners: Int64[np.ndarray, "k 3"], middles: Int64[np.ndarray, "k 3"], marks: int
) -> Int64[np.ndarray, "k p 3"]:
    """The parts of faces that have one, two or three split edges."""
    a, b, c = corners.T
    ab, bc, ca = middles.T
    if marks == 1:
        faces = [a, ab, c, ab, b, c]
    elif marks == 2:
        # The quadrilateral a, b, bc, ca is split along its shorter diagonal.
        places = mesh.vertices_mm
        one = np.linalg.norm(places[a] - places[bc], axis=1)
        short = one <= np.linalg.norm(places[b] - places[ca], axis=1)
        third, last = np.where(short, bc, ca), np.where(short, a, b)
        faces = [bc, c, ca, a, b, third, last, bc, ca]
    else:
        faces = [a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca]
    return np.stack(faces, axis=1).reshape(len(a), marks + 1, 3)


def _with_edge_points(
    mesh: Mesh, ends: Int64[np.ndarray, "k 2"], shares: Float64[np.ndarray, " k"]
) -> Mesh:
    """The mesh with a vertex added on each edge; per-vertex values are interpolated."""
    first, second = mesh.vertices_mm[ends[:, 0]], mesh.vertices_mm[ends[:, 1]]
    known = mesh.of_vertices(
        lambda one, values: np.concatenate([values, one.between(values, ends, shares)])
    )
    places = first + shares[:, None] * (second - first)
    return replace(mesh, vertices_mm=np.concatenate([mesh.vertices_mm, places]), **known)
