"""Remeshing: near-equilateral triangles of one size on the same surface.

In      a manifold Mesh.
Out     a Mesh of the requested edge length; its boundary curve stays in place.
Method  Split, collapse, flip, smooth tangentially, project back (Botsch, Kobbelt 2004). A pass uses
        tables made before it and changes no face or vertex twice, so they stay valid during the
        pass. Half-edge 3 f + k runs from corner k of face f to the next corner; twins[h] is the
        opposite half-edge, or -1 on the boundary.
Fails   SurfaceError: the mesh is not a manifold.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Int64

from limbgram.core.errors import SurfaceError
from limbgram.core.geometry.arrays import Faces
from limbgram.core.kernels import njit
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import corners_by_vertex, is_edge_manifold, select_vertices
from limbgram.core.run import track


class WorkingMesh(NamedTuple):
    """A mesh during remeshing.

    Frozen faces and their vertices stay as they are. `origin` is each vertex's number in the
    initial mesh; of a new vertex, the number of one it was made from.
    """

    vertices: np.ndarray
    faces: np.ndarray
    frozen: np.ndarray
    origin: np.ndarray

    def of_frozen_faces(self) -> np.ndarray:
        """Vertices of frozen faces."""
        found = np.zeros(len(self.vertices), np.bool_)
        found[self.faces[self.frozen]] = True
        return found

    def fixed(self, twins: Int64[np.ndarray, " h"]) -> np.ndarray:
        """Vertices that may not move: those of frozen faces and of the boundary."""
        is_fixed = np.zeros(len(self.vertices), np.bool_)
        _mark_fixed(self.faces, twins, self.frozen, is_fixed)
        return is_fixed


@njit(cache=True, nogil=True)
def _mark_fixed(faces: np.ndarray, twins: np.ndarray, frozen: np.ndarray, is_fixed: np.ndarray):
    """Mark the ends of boundary edges and the vertices of frozen faces."""
    for f in range(len(faces)):
        for k in range(3):
            if frozen[f] or twins[3 * f + k] < 0:
                is_fixed[faces[f, k]] = is_fixed[faces[f, (k + 1) % 3]] = True


def find_twins(faces: Faces) -> Int64[np.ndarray, " h"]:
    """The opposite half-edge of each half-edge; -1 on the boundary."""
    twins = np.full(faces.size, -1, np.int64)
    _fill_twins(faces, int(faces.max(initial=-1)) + 1, twins)
    return twins


@njit(cache=True, nogil=True)
def _fill_twins(faces: np.ndarray, count: int, twins: np.ndarray):
    """Fill `twins`, by a counting sort of the half-edges by their lower vertex.

    Sorting all pairs of vertex numbers took half of the time of remeshing.
    """
    starts = np.zeros(count + 1, np.int32)
    for f in range(len(faces)):
        for k in range(3):
            starts[1 + min(faces[f, k], faces[f, (k + 1) % 3])] += 1
    for v in range(count):
        starts[v + 1] += starts[v]
    ends = starts[:count].copy()
    edges = np.empty((twins.shape[0], 2), np.int32)
    for f in range(len(faces)):
        for k in range(3):
            h = 3 * f + k
            a, b = faces[f, k], faces[f, (k + 1) % 3]
            low, high = min(a, b), max(a, b)
            for e in range(ends[low] - 1, starts[low] - 1, -1):
                if edges[e, 1] == high:
                    twins[h] = edges[e, 0]
                    if twins[edges[e, 0]] < 0:
                        twins[edges[e, 0]] = h
                    break
            edges[ends[low], 0], edges[ends[low], 1] = h, high
            ends[low] += 1


def split_long(mesh: WorkingMesh, longest: float) -> WorkingMesh:
    """The mesh with every edge longer than `longest` halved; its faces become two to four."""
    vertices, faces, frozen, origin = mesh
    midpoint = np.full(faces.size, -1, np.int64)
    half_edges = _number_midpoints(vertices, faces, frozen, find_twins(faces), longest**2, midpoint)
    face, corner = half_edges // 3, half_edges % 3
    tails, heads = faces[face, corner], faces[face, (corner + 1) % 3]
    vertices = np.concatenate([vertices, 0.5 * (vertices[tails] + vertices[heads])])
    origin = np.concatenate([origin, origin[tails]])
    return WorkingMesh(vertices, *_subdivide(vertices, faces, frozen, midpoint), origin)


@njit(cache=True, nogil=True)
def _number_midpoints(
    vertices: np.ndarray,
    faces: np.ndarray,
    frozen: np.ndarray,
    twins: np.ndarray,
    longest2: float,
    midpoint: np.ndarray,
):
    """Fill the numbers of the midpoints of long edges; returns one half-edge of each edge."""
    half_edges = np.empty(len(twins), np.int64)
    found = 0
    for h in range(len(twins)):
        g = twins[h]
        if (0 <= g < h) or frozen[h // 3] or (g >= 0 and frozen[g // 3]):
            continue
        a, b = faces[h // 3, h % 3], faces[h // 3, (h + 1) % 3]
        if _distance2(vertices[a], vertices[b]) > longest2:
            midpoint[h] = len(vertices) + found
            if g >= 0:
                midpoint[g] = midpoint[h]
            half_edges[found] = h
            found += 1
    return half_edges[:found].copy()


@njit(cache=True, nogil=True)
def _subdivide(vertices: np.ndarray, faces: np.ndarray, frozen: np.ndarray, midpoint: np.ndarray):
    """Faces subdivided by the pattern of their split edges, and whether they are frozen."""
    total = len(faces) + np.sum(midpoint >= 0)
    parts, parts_frozen = np.empty((total, 3), np.int32), np.empty(total, np.bool_)
    at = 0
    for f in range(len(faces)):
        count, turn = 0, 0
        for k in range(3):
            if midpoint[3 * f + k] >= 0:
                count += 1
        # Turn the face so that its split edges come first.
        for k in range(3):
            if count == 1 and midpoint[3 * f + k] >= 0:
                turn = k
            if count == 2 and midpoint[3 * f + k] < 0:
                turn = (k + 1) % 3
        second, third = (turn + 1) % 3, (turn + 2) % 3
        a, b, c = faces[f, turn], faces[f, second], faces[f, third]
        ab, bc, ca = midpoint[3 * f + turn], midpoint[3 * f + second], midpoint[3 * f + third]
        parts_frozen[at : at + count + 1] = frozen[f]
        if count == 0:
            at = _write_face(parts, at, a, b, c)
        elif count == 1:
            at = _write_face(parts, at, a, ab, c)
            at = _write_face(parts, at, ab, b, c)
        elif count == 2:
            shorter = _distance2(vertices[a], vertices[bc]) < _distance2(vertices[ab], vertices[c])
            at = _write_face(parts, at, ab, b, bc)
            at = _write_face(parts, at, a, ab, bc if shorter else c)
            at = _write_face(parts, at, a if shorter else ab, bc, c)
        else:
            at = _write_face(parts, at, a, ab, ca)
            at = _write_face(parts, at, ab, b, bc)
            at = _write_face(parts, at, ca, bc, c)
            at = _write_face(parts, at, ab, bc, ca)
    return parts, parts_frozen


@njit(cache=True, nogil=True)
def _write_face(parts: np.ndarray, at: int, a: int, b: int, c: int):
    """Write a face; returns the next free row."""
    parts[at, 0], parts[at, 1], parts[at, 2] = a, b, c
    return at + 1


@njit(cache=True, nogil=True)
def _distance2(p: np.ndarray, q: np.ndarray):
    """Squared distance of two points."""
    return (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 + (p[2] - q[2]) ** 2


def collapse_short(mesh: WorkingMesh, shortest: float, longest: float) -> WorkingMesh:
    """The mesh with edges shorter than `shortest` collapsed where it stays manifold and unfolded.

    No edge grows beyond `longest`.
    """
    vertices, faces = mesh.vertices.copy(), mesh.faces
    twins = find_twins(faces)
    short, lengths2 = _short_edges(vertices, faces, twins, shortest**2)
    edges = short[np.argsort(lengths2, kind="stable")]
    merged_into = np.arange(len(vertices), dtype=np.int32)
    starts, corners = corners_by_vertex(faces, len(vertices))
    _collapse(vertices, faces, starts, corners, edges, mesh.fixed(twins), longest**2, merged_into)
    faces, kept, used = _compacted(faces, merged_into)
    return WorkingMesh(vertices[used], faces, mesh.frozen[kept], mesh.origin[used])


@njit(cache=True, nogil=True)
def _short_edges(vertices: np.ndarray, faces: np.ndarray, twins: np.ndarray, shortest2: float):
    """Ends and squared lengths of the interior edges shorter than the root of `shortest2`."""
    ends, lengths2 = np.empty((len(twins), 2), np.int32), np.empty(len(twins))
    found = 0
    for h in range(len(twins)):
        if twins[h] > h:
            a, b = faces[h // 3, h % 3], faces[h // 3, (h + 1) % 3]
            length2 = _distance2(vertices[a], vertices[b])
            if length2 < shortest2:
                ends[found, 0], ends[found, 1], lengths2[found] = a, b, length2
                found += 1
    return ends[:found].copy(), lengths2[:found].copy()


@njit(cache=True, nogil=True)
def _compacted(faces: np.ndarray, merged_into: np.ndarray):
    """Faces left after the merges, on vertices numbered without gaps; which faces and vertices
    these were.
    """
    number = np.full(len(merged_into), -1, np.int32)
    kept = np.zeros(len(faces), np.bool_)
    count = 0
    for f in range(len(faces)):
        a, b, c = merged_into[faces[f, 0]], merged_into[faces[f, 1]], merged_into[faces[f, 2]]
        if a != b and b != c and c != a:
            kept[f] = True
            count += 1
            number[a] = number[b] = number[c] = 0
    used = np.flatnonzero(number == 0)
    number[used] = np.arange(len(used))
    left = np.empty((count, 3), np.int32)
    at = 0
    for f in range(len(faces)):
        if kept[f]:
            for k in range(3):
                left[at, k] = number[merged_into[faces[f, k]]]
            at += 1
    return left, kept, used


@njit(cache=True, nogil=True)
def _collapse(
    vertices: np.ndarray,
    faces: np.ndarray,
    starts: np.ndarray,
    corners: np.ndarray,
    edges: np.ndarray,
    fixed: np.ndarray,
    longest2: float,
    merged_into: np.ndarray,
):
    """Collapse valid edges, shortest first: moves vertices and fills `merged_into`."""
    locked = np.zeros(vertices.shape[0], np.bool_)
    seen = np.full(vertices.shape[0], -1, np.int64)
    position = np.empty(3)
    for e in range(edges.shape[0]):
        u, v = edges[e, 0], edges[e, 1]
        if fixed[v]:
            u, v = v, u
        if locked[u] or locked[v] or fixed[v]:
            continue
        for k in range(3):
            position[k] = vertices[u, k] if fixed[u] else 0.5 * (vertices[u, k] + vertices[v, k])
        valid = _keeps_shape(vertices, faces, starts, corners, u, v, position, longest2)
        valid = valid and _keeps_shape(vertices, faces, starts, corners, v, u, position, longest2)
        if not valid or _count_common_neighbours(faces, starts, corners, u, v, e, seen) != 2:
            continue
        merged_into[v] = u
        for k in range(3):
            vertices[u, k] = position[k]
        for end in (u, v):
            for s in range(starts[end], starts[end + 1]):
                for k in range(3):
                    locked[faces[corners[s] // 3, k]] = True


@njit(cache=True, nogil=True)
def _keeps_shape(
    vertices: np.ndarray,
    faces: np.ndarray,
    starts: np.ndarray,
    corners: np.ndarray,
    moving: int,
    other: float,
    position: np.ndarray,
    longest2: float,
):
    """Whether the faces at `moving` without `other` stay unfolded and small after the move."""
    old, new = np.empty(3), np.empty(3)
    for s in range(starts[moving], starts[moving + 1]):
        face, corner = corners[s] // 3, corners[s] % 3
        b, c = faces[face, (corner + 1) % 3], faces[face, (corner + 2) % 3]
        if b == other or c == other:
            continue
        _area_vector(vertices[moving], vertices[b], vertices[c], old)
        _area_vector(position, vertices[b], vertices[c], new)
        if _dot(old, new) < 0.5 * np.sqrt(_dot(old, old) * _dot(new, new)):
            return False
        reach2 = 0.0
        for k in range(3):
            reach2 += (vertices[b, k] - position[k]) ** 2
        if reach2 > longest2:
            return False
    return True


@njit(cache=True, nogil=True)
def _count_common_neighbours(
    faces: np.ndarray,
    starts: np.ndarray,
    corners: np.ndarray,
    u: int,
    v: int,
    edge_number: float,
    seen: np.ndarray,
):
    """Number of neighbours that u and v share: 2 where the link condition holds."""
    for s in range(starts[u], starts[u + 1]):
        for k in range(3):
            seen[faces[corners[s] // 3, k]] = 2 * edge_number
    count = 0
    for s in range(starts[v], starts[v + 1]):
        for k in range(3):
            w = faces[corners[s] // 3, k]
            if w != u and w != v and seen[w] == 2 * edge_number:
                seen[w] = 2 * edge_number + 1
                count += 1
    return count


def flip_to_delaunay(mesh: WorkingMesh, twins: Int64[np.ndarray, " h"]) -> WorkingMesh:
    """The mesh with those edges flipped whose two opposite angles exceed 180 degrees together."""
    faces = mesh.faces.copy()
    starts, corners = corners_by_vertex(faces, len(mesh.vertices))
    _flip_edges(mesh.vertices, faces, twins, starts, corners, mesh.frozen.copy())
    return mesh._replace(faces=faces)


@njit(cache=True, nogil=True)
def _flip_edges(
    vertices: np.ndarray,
    faces: np.ndarray,
    twins: np.ndarray,
    starts: np.ndarray,
    corners: np.ndarray,
    touched: np.ndarray,
):
    """Flip edges that are not Delaunay in `faces`."""
    got_edge = np.zeros(vertices.shape[0], np.bool_)
    original = faces.copy()
    upper, lower, outward = np.empty(3), np.empty(3), np.empty(3)
    for h in range(twins.shape[0]):
        g = twins[h]
        if g < h or touched[h // 3] or touched[g // 3]:
            continue
        a, b = faces[h // 3, h % 3], faces[h // 3, (h + 1) % 3]
        c, d = faces[h // 3, (h + 2) % 3], faces[g // 3, (g + 2) % 3]
        if c == d or (got_edge[c] and got_edge[d]):
            continue
        pa, pb, pc, pd = vertices[a], vertices[b], vertices[c], vertices[d]
        _area_vector(pc, pa, pb, upper)
        _area_vector(pd, pb, pa, lower)
        size_up, size_low = np.sqrt(_dot(upper, upper)), np.sqrt(_dot(lower, lower))
        facing_up = facing_low = 0.0
        for k in range(3):
            facing_up += (pa[k] - pc[k]) * (pb[k] - pc[k])
            facing_low += (pa[k] - pd[k]) * (pb[k] - pd[k])
            outward[k] = upper[k] + lower[k]
        # This is the sum of the two angles' cotangents, times both areas.
        if facing_up * size_low + facing_low * size_up >= -1e-9 * size_up * size_low:
            continue
        _area_vector(pc, pa, pd, upper)
        _area_vector(pc, pd, pb, lower)
        if _dot(upper, outward) <= 0 or _dot(lower, outward) <= 0:
            continue
        joined = False
        for s in range(starts[c], starts[c + 1]):
            for k in range(3):
                joined |= original[corners[s] // 3, k] == d
        if joined:
            continue
        faces[h // 3, 0], faces[h // 3, 1], faces[h // 3, 2] = c, a, d
        faces[g // 3, 0], faces[g // 3, 1], faces[g // 3, 2] = d, b, c
        touched[h // 3] = touched[g // 3] = True
        got_edge[c] = got_edge[d] = True


@njit(cache=True, nogil=True)
def _area_vector(p: np.ndarray, q: np.ndarray, r: np.ndarray, out: np.ndarray):
    """Fill twice the area vector of a triangle."""
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        out[k] = (q[i] - p[i]) * (r[j] - p[j]) - (q[j] - p[j]) * (r[i] - p[i])


@njit(cache=True, nogil=True)
def _dot(p: np.ndarray, q: np.ndarray):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


def smooth_along(mesh: WorkingMesh, fixed: np.ndarray) -> WorkingMesh:
    """The mesh with its vertices moved half way to the mean of their 1-rings, tangentially."""
    return mesh._replace(vertices=_smoothed(mesh.vertices, mesh.faces, fixed))


@njit(cache=True, nogil=True)
def _smoothed(vertices: np.ndarray, faces: np.ndarray, fixed: np.ndarray):
    """Positions after one step of tangential smoothing."""
    count = len(vertices)
    sums, normals, valence = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count)
    area_vector = np.empty(3)
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        _area_vector(vertices[a], vertices[b], vertices[c], area_vector)
        for tail, head in ((a, b), (b, c), (c, a)):
            valence[tail] += 1
            for k in range(3):
                sums[tail, k] += vertices[head, k]
                normals[tail, k] += area_vector[k]
    moved = vertices.copy()
    for v in range(count):
        if fixed[v] or valence[v] == 0:
            continue
        normal2 = max(_dot(normals[v], normals[v]), 1e-60)
        off_plane = 0.0
        for k in range(3):
            off_plane += (sums[v, k] / valence[v] - vertices[v, k]) * normals[v, k] / normal2
        for k in range(3):
            step = sums[v, k] / valence[v] - vertices[v, k] - off_plane * normals[v, k]
            moved[v, k] += 0.5 * step
    return moved


_ROUNDS = 4
_PROJECTION_ROUNDS = (1, 3)
"""Rounds after which vertices are projected back to the surface. Tangential steps hardly leave it,
and the search for the closest points takes half of the time."""


def refine(mesh: Mesh, edge_mm: float) -> Mesh:
    """The surface remeshed to even triangles with edges of about `edge_mm`.

    Colours, filled marks and sigmas come from the nearest vertex of the given mesh.
    """
    if not is_edge_manifold(mesh.faces):
        raise SurfaceError("surface.not_manifold")
    tree = TriangleTree.of(mesh.vertices_mm, mesh.faces)
    work = WorkingMesh(
        mesh.vertices_mm, mesh.faces, np.zeros(len(mesh.faces), np.bool_), np.arange(len(mesh))
    )
    on_face = np.zeros(len(mesh), np.int64)
    for number in track(range(_ROUNDS)):
        work, fixed = _remesh_round(work, edge_mm)
        if number in _PROJECTION_ROUNDS:
            nearest = tree.closest(work.vertices)
            work.vertices[~fixed] = nearest.points_mm[~fixed]
            on_face = nearest.faces
    result = select_vertices(mesh, _nearest_corners(mesh, on_face, work.vertices))
    return replace(result, vertices_mm=work.vertices, faces=work.faces)


def remesh_once(work: WorkingMesh, edge: float) -> WorkingMesh:
    """The mesh after one round of remeshing towards this edge length."""
    return _remesh_round(work, edge)[0]


def _remesh_round(work: WorkingMesh, edge: float) -> tuple[WorkingMesh, np.ndarray]:
    """The mesh after one round of remeshing, and which vertices were fixed."""
    work = split_long(work, 4 / 3 * edge)
    for _ in range(2):
        work = collapse_short(work, 4 / 5 * edge, 4 / 3 * edge)
    twins = find_twins(work.faces)
    fixed = work.fixed(twins)
    work = flip_to_delaunay(work, twins)
    work = flip_to_delaunay(work, find_twins(work.faces))
    return smooth_along(work, fixed), fixed


def _nearest_corners(mesh: Mesh, on_face: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Vertex of the mesh nearest to each place, among the corners of its face."""
    corners = mesh.faces[on_face]
    distance = np.linalg.norm(mesh.vertices_mm[corners] - places[:, None], axis=2)
    return np.take_along_axis(corners, distance.argmin(1)[:, None], 1)[:, 0]
