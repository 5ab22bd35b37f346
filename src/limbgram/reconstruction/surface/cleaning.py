"""Cleaning: removes faces that are degenerate, doubled, folded or non-manifold; only holes remain.

Trimming: cut the ragged rim of an opening back to what was measured.

In      a mesh, and which of its vertices are in doubt.
Out     the mesh without the doubtful vertices along its openings.
"""

import numpy as np
from jaxtyping import Bool, Float64, Int32, Int64

from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.mesh import Mesh, crosses, unit
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    broken_half_edges,
    corner_fans,
    face_components,
    find_edges,
    number_pairs,
    with_faces,
)

_FewerFaces = Int32[np.ndarray, "kept 3"]

_MOST_ROUNDS = 50
_FOLD_COSINE = -0.2
"""Neighbouring faces whose normals differ by more than 101 degrees make a fold."""
_SPIKE_LINKS = 1.5
"""A spike stands out of the ring of its neighbours by more than so many of the ring's edges."""

_LONG_EDGES = 3.0
"""Faces with an edge of more than so many usual ones span what no point shows."""
_TONGUE_ROUNDS = 5
"""Rounds of taking long faces off an opening: a part of sparse points must not be eaten up."""


def drop_flat_and_double(vertices: Points3, faces: Faces) -> _FewerFaces:
    """Faces with three different corners and an area, each only once."""
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
    """Take faces away until every edge has two sides at most and every vertex one fan.

    At a vertex of several fans the largest stays.
    """
    for _ in range(_MOST_ROUNDS):
        broken = broken_half_edges(faces).reshape(-1, 3).any(1)
        if not broken.any():
            broken = _beside_the_largest_fan(faces)
        if not broken.any():
            return faces
        faces = faces[~broken]
    return faces[:0]


def drop_folds(vertices: Points3, faces: Faces) -> _FewerFaces:
    """Take away the faces at sharp folds and at spikes."""
    normals = face_normals(vertices, faces)
    sides = find_edges(faces).faces()
    sides = sides[sides[:, 1] >= 0]
    folded = (normals[sides[:, 0]] * normals[sides[:, 1]]).sum(1) < _FOLD_COSINE
    at_spike = _spikes(vertices, faces)[faces].any(1)
    at_fold = np.zeros(len(faces), np.bool_)
    at_fold[sides[folded]] = True
    return faces[~(at_spike | at_fold)]


def drop_tongues(vertices: Points3, faces: Faces) -> _FewerFaces:
    """Take long faces off the openings."""
    edges = find_edges(faces)
    lengths = np.linalg.norm(vertices[edges.ends[:, 0]] - vertices[edges.ends[:, 1]], axis=1)
    longest = lengths[edges.of_half_edge].reshape(-1, 3).max(1)
    long = longest > _LONG_EDGES * np.median(lengths)
    for _ in range(_TONGUE_ROUNDS):
        going = long & (_open_sides(faces) >= 1)
        faces, long = faces[~going], long[~going]
    return faces


def drop_dangling(faces: Faces) -> _FewerFaces:
    """Take away faces that hang on by one edge or less."""
    going = _open_sides(faces) >= 2
    while going.any():
        faces = faces[~going]
        going = _open_sides(faces) >= 2
    return faces


def largest_manifold(vertices: Points3, faces: Faces) -> _FewerFaces:
    """The largest piece, manifold."""
    count = -1
    while count != len(faces):
        count = len(faces)
        faces = make_manifold(faces)
        faces = largest_component(vertices, faces) if len(faces) else faces
    return faces


def largest_component(vertices: Points3, faces: Faces) -> _FewerFaces:
    """Faces of the component of the largest area."""
    labels = face_components(faces)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    areas = np.bincount(labels, np.linalg.norm(np.cross(b - a, c - a), axis=1))
    return faces[labels == areas.argmax()]


def face_normals(vertices: Points3, faces: Faces) -> Float64[np.ndarray, "f 3"]:
    """Unit normals."""
    return unit(crosses(vertices, faces))


def cut_back(mesh: Mesh, doubtful: Bool[np.ndarray, " n"], rings: int) -> Mesh:
    """Take doubtful vertices off the openings, at most `rings` rows of them.

    A doubtful vertex inside the surface stays: no hole opens there.
    """
    faces = mesh.faces
    for _ in range(rings):
        at_rim = np.zeros(len(mesh), bool)
        at_rim[boundary_half_edges(faces).ravel()] = True
        going = at_rim & doubtful
        if not going.any():
            break
        faces = faces[~going[faces].any(axis=1)]
    return with_faces(mesh, largest_manifold(mesh.vertices_mm, faces))


def _beside_the_largest_fan(faces: Faces) -> Bool[np.ndarray, " f"]:
    fans = corner_fans(faces).ravel()
    vertices = faces.ravel()
    size = np.bincount(fans)
    # Fans in order of vertex, then size: the last one of a vertex is its largest.
    first_corner = np.unique(fans, return_index=True)[1]
    of_vertex = vertices[first_corner]
    order = np.lexsort((size, of_vertex))
    lesser = np.zeros(len(size), np.bool_)
    lesser[order[:-1]] = of_vertex[order[:-1]] == of_vertex[order[1:]]
    return np.asarray(lesser[fans].reshape(-1, 3).any(1))


def _spikes(vertices: Points3, faces: Faces) -> Bool[np.ndarray, " n"]:
    """Vertices farther from the middle of their neighbours than the ring of these is wide."""
    corners = faces.ravel()
    ahead, behind = np.roll(faces, -1, axis=1).ravel(), np.roll(faces, 1, axis=1).ravel()
    count = np.maximum(np.bincount(corners, minlength=len(vertices)), 1)
    apart = np.linalg.norm(vertices[ahead] - vertices[behind], axis=1)
    link = np.bincount(corners, apart, len(vertices)) / count
    middles = np.column_stack(
        [
            np.bincount(corners, (vertices[ahead, k] + vertices[behind, k]) / 2, len(vertices))
            for k in range(3)
        ]
    )
    away = np.linalg.norm(vertices - middles / count[:, None], axis=1)
    return away > _SPIKE_LINKS * link


def _open_sides(faces: Faces) -> Int64[np.ndarray, " f"]:
    """Number of boundary edges of each face."""
    edges = find_edges(faces)
    return (edges.uses[edges.of_half_edge] == 1).reshape(-1, 3).sum(1)
