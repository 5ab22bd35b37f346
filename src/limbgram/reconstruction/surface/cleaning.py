"""Cleaning: removes faces that are degenerate, duplicate, folded or non-manifold, and ragged rims.

In      vertices and faces; to trim rims, a mesh and its doubtful vertices.
Out     the faces that remain; the mesh without the doubtful vertices along its openings.
"""

import numpy as np
from jaxtyping import Bool, Float64, Int32, Int64

from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.mesh import Mesh, crosses, unit
from limbgram.core.mesh.topology import (
    boundary_vertices,
    broken_half_edges,
    corner_fans,
    edge_lengths,
    face_components,
    find_edges,
    number_pairs,
    with_faces,
)

_FewerFaces = Int32[np.ndarray, "kept 3"]

_MAX_ROUNDS = 50
_FOLD_COSINE = -0.2
"""Neighbouring faces whose normals differ by more than 101 degrees make a fold."""
_SPIKE_RATIO = 1.5
"""A spike's distance from the middle of its 1-ring, in the ring's mean edge length."""

_LONG_EDGE_RATIO = 3.0
"""Faces with an edge of more than so many median ones span gaps between the points."""
_TONGUE_ROUNDS = 5
"""Rounds of removing long faces at openings; more would consume parts of sparse points."""


def drop_degenerate_and_duplicate(vertices: Points3, faces: Faces) -> _FewerFaces:
    """Faces without the degenerate ones and without duplicates."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    along, across, area = b - a, c - a, crosses(vertices, faces)
    edge2, side2, area2 = (np.einsum("ij,ij->i", row, row) for row in (along, across, area))
    flat = np.sqrt(area2) <= 1e-9 * np.maximum(edge2, side2)
    faces = faces[~flat] if flat.any() else faces
    low, middle, high = np.sort(faces, axis=1).T
    triples = number_pairs(number_pairs(low, middle).number, high)
    firsts = triples.order[triples.starts[:-1]]
    return faces if len(firsts) == len(faces) else faces[np.sort(firsts)]


def make_manifold(faces: Faces) -> _FewerFaces:
    """The faces left once every edge has at most two faces and every vertex one fan.

    At a vertex of several fans the largest stays.
    """
    for _ in range(_MAX_ROUNDS):
        broken = broken_half_edges(faces).reshape(-1, 3).any(1)
        if not broken.any():
            broken = _outside_largest_fan(faces)
        if not broken.any():
            return faces
        faces = faces[~broken]
    return faces[:0]


def drop_folds(vertices: Points3, faces: Faces) -> _FewerFaces:
    """The faces without those at sharp folds and at spikes."""
    normals = face_normals(vertices, faces)
    sides = find_edges(faces).faces()
    sides = sides[sides[:, 1] >= 0]
    folded = (normals[sides[:, 0]] * normals[sides[:, 1]]).sum(1) < _FOLD_COSINE
    at_spike = _spikes(vertices, faces)[faces].any(1)
    at_fold = np.zeros(len(faces), np.bool_)
    at_fold[sides[folded]] = True
    return faces[~(at_spike | at_fold)]


def drop_tongues(vertices: Points3, faces: Faces) -> _FewerFaces:
    """The faces without long ones at the openings."""
    edges = find_edges(faces)
    lengths = edge_lengths(vertices, edges.ends)
    longest = lengths[edges.of_half_edge].reshape(-1, 3).max(1)
    long = longest > _LONG_EDGE_RATIO * np.median(lengths)
    for _ in range(_TONGUE_ROUNDS):
        dropped = long & (_boundary_edge_counts(faces) >= 1)
        faces, long = faces[~dropped], long[~dropped]
    return faces


def drop_dangling(faces: Faces) -> _FewerFaces:
    """The faces without those that share at most one edge with others."""
    dropped = _boundary_edge_counts(faces) >= 2
    while dropped.any():
        faces = faces[~dropped]
        dropped = _boundary_edge_counts(faces) >= 2
    return faces


def largest_manifold(vertices: Points3, faces: Faces) -> _FewerFaces:
    """The faces of the largest component, made manifold."""
    count = -1
    while count != len(faces):
        count = len(faces)
        faces = make_manifold(faces)
        faces = largest_component(vertices, faces) if len(faces) else faces
    return faces


def largest_component(vertices: Points3, faces: Faces) -> _FewerFaces:
    """The faces of the component with the largest area."""
    labels = face_components(faces)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    areas = np.bincount(labels, np.linalg.norm(np.cross(b - a, c - a), axis=1))
    return faces[labels == areas.argmax()]


def face_normals(vertices: Points3, faces: Faces) -> Float64[np.ndarray, "f 3"]:
    """Unit normals of the faces."""
    return unit(crosses(vertices, faces))


def cut_back(mesh: Mesh, doubtful: Bool[np.ndarray, " n"], rings: int) -> Mesh:
    """The mesh without the doubtful vertices along its openings, at most `rings` rows of them.

    A doubtful vertex inside the surface stays, so that no hole opens there.
    """
    faces = mesh.faces
    for _ in range(rings):
        dropped = boundary_vertices(faces, len(mesh)) & doubtful
        if not dropped.any():
            break
        faces = faces[~dropped[faces].any(axis=1)]
    return with_faces(mesh, largest_manifold(mesh.vertices_mm, faces))


def _outside_largest_fan(faces: Faces) -> Bool[np.ndarray, " f"]:
    """Faces that belong to a vertex's fan other than its largest."""
    fans = corner_fans(faces).ravel()
    vertices = faces.ravel()
    size = np.bincount(fans)
    # Fans are sorted by vertex, then by size: the last one of a vertex is its largest.
    first_corner = np.unique(fans, return_index=True)[1]
    of_vertex = vertices[first_corner]
    order = np.lexsort((size, of_vertex))
    not_largest = np.zeros(len(size), np.bool_)
    not_largest[order[:-1]] = of_vertex[order[:-1]] == of_vertex[order[1:]]
    return np.asarray(not_largest[fans].reshape(-1, 3).any(1))


def _spikes(vertices: Points3, faces: Faces) -> Bool[np.ndarray, " n"]:
    """Vertices that stand far out of their 1-rings."""
    corners = faces.ravel()
    ahead, behind = np.roll(faces, -1, axis=1).ravel(), np.roll(faces, 1, axis=1).ravel()
    count = np.maximum(np.bincount(corners, minlength=len(vertices)), 1)
    ring_edge = np.linalg.norm(vertices[ahead] - vertices[behind], axis=1)
    mean_ring_edge = np.bincount(corners, ring_edge, len(vertices)) / count
    midpoint_sums = np.column_stack(
        [
            np.bincount(corners, (vertices[ahead, k] + vertices[behind, k]) / 2, len(vertices))
            for k in range(3)
        ]
    )
    distance = np.linalg.norm(vertices - midpoint_sums / count[:, None], axis=1)
    return distance > _SPIKE_RATIO * mean_ring_edge


def _boundary_edge_counts(faces: Faces) -> Int64[np.ndarray, " f"]:
    """Number of boundary edges of each face."""
    edges = find_edges(faces)
    return (edges.uses[edges.of_half_edge] == 1).reshape(-1, 3).sum(1)
