"""Fineness: edges split where an edit needs finer triangles; the surface itself stays as it is."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.core.mesh.mesh import Mesh, lengths, longest_sides_mm
from limbgram.core.mesh.topology import Edges, find_edges

_MOST_ROUNDS = 16
_ALONG = 8.0
"""Edges along what fades, at least."""
_FINEST_MM = 0.4
Under = Callable[[Mesh], Bool[np.ndarray, " f"]]
"""Tells which faces of a mesh must be fine."""


def edge_along_mm(length_mm: float) -> float:
    """Edges by which what fades over a length looks smooth."""
    return max(length_mm / _ALONG, _FINEST_MM)


@dataclass(frozen=True)
class Division:
    """A mesh with split edges; the old vertices come first, as they were."""

    mesh: Mesh
    parents: Int64[np.ndarray, " f"]
    """Face of the old mesh that each face is a part of."""


def refine_where(mesh: Mesh, chosen: Bool[np.ndarray, " f"], edge_mm: float) -> Mesh:
    """Halve edges of the chosen faces, and of what they become, until none is longer."""
    for _ in range(_MOST_ROUNDS):
        division = _halved(mesh, chosen, edge_mm)
        if division is None:
            break
        mesh, chosen = division.mesh, chosen[division.parents]
    return mesh


def refine_under(mesh: Mesh, under: Under, edge_mm: float) -> Mesh:
    """Halve edges of the faces that `under` finds, asked anew each time, until none is longer."""
    for _ in range(_MOST_ROUNDS):
        division = _halved(mesh, under(mesh), edge_mm)
        if division is None:
            break
        mesh = division.mesh
    return mesh


def _halved(mesh: Mesh, chosen: Bool[np.ndarray, " f"], edge_mm: float) -> Division | None:
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
    return divide(mesh, edges, split, np.full(len(long_mm), 0.5))


def divide(
    mesh: Mesh,
    edges: Edges,
    split: Bool[np.ndarray, " e"],
    shares: Float64[np.ndarray, " e"],
) -> Division:
    """Split edges at a share of the way between their ends; each face becomes one to four."""
    made = np.flatnonzero(split)
    middle = np.full(len(split), -1, np.int64)
    middle[made] = len(mesh) + np.arange(len(made))
    grown = _with_points_on_edges(mesh, edges.ends[made].astype(np.int64), shares[made])
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
        pieces = _pieces(grown, corners, middles, marks)
        parts.append(pieces.reshape(-1, 3))
        parents.append(np.repeat(rows, marks + 1))
    faces = np.concatenate(parts).astype(np.int32)
    return Division(replace(grown, faces=faces), np.concatenate(parents))


def _pieces(
    mesh: Mesh, corners: Int64[np.ndarray, "k 3"], middles: Int64[np.ndarray, "k 3"], marks: int
) -> Int64[np.ndarray, "k p 3"]:
    """The parts of faces with so many split edges."""
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


def _with_points_on_edges(
    mesh: Mesh, ends: Int64[np.ndarray, "k 2"], shares: Float64[np.ndarray, " k"]
) -> Mesh:
    """The mesh with more vertices, each between two; all that is known is blended."""
    first, second = mesh.vertices_mm[ends[:, 0]], mesh.vertices_mm[ends[:, 1]]
    known = mesh.of_vertices(
        lambda one, values: np.concatenate([values, one.between(values, ends, shares)])
    )
    places = first + shares[:, None] * (second - first)
    return replace(mesh, vertices_mm=np.concatenate([mesh.vertices_mm, places]), **known)
