"""Remeshing: near-equilateral triangles of one size on the same surface.

In      a manifold Mesh.
Out     a Mesh of the asked edge length; its boundary curve stays where it was.
Method  Split, collapse, flip, smooth along the surface, return to it (Botsch, Kobbelt 2004). A pass
        works on tables made before it and touches no face or vertex twice, so it stays valid
        without rebuilding them on the way. Twins: half-edge 3 f + k runs from corner k of face f to
        the next corner; twins[h] is the half-edge on its other side, or -1 on the boundary.
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
from limbgram.core.mesh.topology import corners_by_vertex, is_edge_manifold, taking_vertices
from limbgram.core.run import track


class Triangles(NamedTuple):
    """A mesh being worked on.

    Frozen faces and their vertices stay as they are. `origin` is each vertex's number in the
    mesh that the work began with; of a new vertex, the number of one it was made from.
    """

    vertices: np.ndarray
    faces: np.ndarray
    frozen: np.ndarray
    origin: np.ndarray

    def fixed(self, twins: Int64[np.ndarray, " h"]) -> np.ndarray:
        """Vertices that must stay: at frozen faces and on the boundary."""
        stays = np.zeros(len(self.vertices), np.bool_)
        _hold(self.faces, twins, self.frozen, stays)
        return stays


@njit(cache=True, nogil=True)
def _hold(faces: np.ndarray, twins: np.ndarray, frozen: np.ndarray, stays: np.ndarray):
    for f in range(len(faces)):
        for k in range(3):
            if frozen[f] or twins[3 * f + k] < 0:
                stays[faces[f, k]] = stays[faces[f, (k + 1) % 3]] = True


def find_twins(faces: Faces) -> Int64[np.ndarray, " h"]:
    twins = np.full(faces.size, -1, np.int64)
    _pair_up(faces, int(faces.max(initial=-1)) + 1, twins)
    return twins


@njit(cache=True, nogil=True)
def _pair_up(faces: np.ndarray, count: int, twins: np.ndarray):
    """Half-edges of the same two vertices, by a counting sort of their lower vertex.

    A sort of all pairs of numbers took half of the time of evening out a mesh.
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


def split_long(mesh: Triangles, longest: float) -> Triangles:
    """Halve every edge longer than `longest`; faces with split edges become two to four."""
    vertices, faces, frozen, origin = mesh
    middle = np.full(faces.size, -1, np.int64)
    owners = _halve(vertices, faces, frozen, find_twins(faces), longest**2, middle)
    tails, heads = faces[owners // 3, owners % 3], faces[owners // 3, (owners + 1) % 3]
    vertices = np.concatenate([vertices, 0.5 * (vertices[tails] + vertices[heads])])
    origin = np.concatenate([origin, origin[tails]])
    return Triangles(vertices, *_subdivide(vertices, faces, frozen, middle), origin)


@njit(cache=True, nogil=True)
def _halve(
    vertices: np.ndarray,
    faces: np.ndarray,
    frozen: np.ndarray,
    twins: np.ndarray,
    longest2: float,
    middle: np.ndarray,
):
    """Number the middles of long edges in `middle`, by half-edge; one half-edge of each."""
    owners = np.empty(len(twins), np.int64)
    found = 0
    for h in range(len(twins)):
        g = twins[h]
        if (0 <= g < h) or frozen[h // 3] or (g >= 0 and frozen[g // 3]):
            continue
        a, b = faces[h // 3, h % 3], faces[h // 3, (h + 1) % 3]
        if _apart2(vertices[a], vertices[b]) > longest2:
            middle[h] = len(vertices) + found
            if g >= 0:
                middle[g] = middle[h]
            owners[found] = h
            found += 1
    return owners[:found].copy()


@njit(cache=True, nogil=True)
def _subdivide(vertices: np.ndarray, faces: np.ndarray, frozen: np.ndarray, middle: np.ndarray):
    """Faces by the pattern of their split edges, and whether they are frozen.

    The middle of half-edge 3 f + k lies on the edge from corner k.
    """
    total = len(faces) + np.sum(middle >= 0)
    parts, ice = np.empty((total, 3), np.int32), np.empty(total, np.bool_)
    at = 0
    for f in range(len(faces)):
        count, turn = 0, 0
        for k in range(3):
            if middle[3 * f + k] >= 0:
                count += 1
        # Turn the face so that its split edges come first.
        for k in range(3):
            if count == 1 and middle[3 * f + k] >= 0:
                turn = k
            if count == 2 and middle[3 * f + k] < 0:
                turn = (k + 1) % 3
        second, third = (turn + 1) % 3, (turn + 2) % 3
        a, b, c = faces[f, turn], faces[f, second], faces[f, third]
        ab, bc, ca = middle[3 * f + turn], middle[3 * f + second], middle[3 * f + third]
        ice[at : at + count + 1] = frozen[f]
        if count == 0:
            at = _put(parts, at, a, b, c)
        elif count == 1:
            at = _put(parts, at, a, ab, c)
            at = _put(parts, at, ab, b, c)
        elif count == 2:
            across = _apart2(vertices[a], vertices[bc]) < _apart2(vertices[ab], vertices[c])
            at = _put(parts, at, ab, b, bc)
            at = _put(parts, at, a, ab, bc if across else c)
            at = _put(parts, at, a if across else ab, bc, c)
        else:
            at = _put(parts, at, a, ab, ca)
            at = _put(parts, at, ab, b, bc)
            at = _put(parts, at, ca, bc, c)
            at = _put(parts, at, ab, bc, ca)
    return parts, ice


@njit(cache=True, nogil=True)
def _put(parts: np.ndarray, at: int, a: int, b: int, c: int):
    parts[at, 0], parts[at, 1], parts[at, 2] = a, b, c
    return at + 1


@njit(cache=True, nogil=True)
def _apart2(p: np.ndarray, q: np.ndarray):
    return (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 + (p[2] - q[2]) ** 2


def collapse_short(mesh: Triangles, shortest: float, longest: float) -> Triangles:
    """Contract edges shorter than `shortest` where the mesh stays a manifold and unfolded.

    No edge grows beyond `longest`.
    """
    vertices, faces = mesh.vertices.copy(), mesh.faces
    twins = find_twins(faces)
    short, lengths2 = _short_edges(vertices, faces, twins, shortest**2)
    edges = short[np.argsort(lengths2, kind="stable")]
    goes_to = np.arange(len(vertices), dtype=np.int32)
    starts, corners = corners_by_vertex(faces, len(vertices))
    _collapse(vertices, faces, starts, corners, edges, mesh.fixed(twins), longest**2, goes_to)
    faces, whole, used = _closed_up(faces, goes_to)
    return Triangles(vertices[used], faces, mesh.frozen[whole], mesh.origin[used])


@njit(cache=True, nogil=True)
def _short_edges(vertices: np.ndarray, faces: np.ndarray, twins: np.ndarray, shortest2: float):
    """Ends and squared lengths of the edges inside the mesh that are shorter."""
    ends, lengths2 = np.empty((len(twins), 2), np.int32), np.empty(len(twins))
    found = 0
    for h in range(len(twins)):
        if twins[h] > h:
            a, b = faces[h // 3, h % 3], faces[h // 3, (h + 1) % 3]
            length2 = _apart2(vertices[a], vertices[b])
            if length2 < shortest2:
                ends[found, 0], ends[found, 1], lengths2[found] = a, b, length2
                found += 1
    return ends[:found].copy(), lengths2[:found].copy()


@njit(cache=True, nogil=True)
def _closed_up(faces: np.ndarray, goes_to: np.ndarray):
    """Faces of three corners once vertices went to others, on vertices without gaps; which faces
    these were, and which vertices.
    """
    number = np.full(len(goes_to), -1, np.int32)
    whole = np.zeros(len(faces), np.bool_)
    count = 0
    for f in range(len(faces)):
        a, b, c = goes_to[faces[f, 0]], goes_to[faces[f, 1]], goes_to[faces[f, 2]]
        if a != b and b != c and c != a:
            whole[f] = True
            count += 1
            number[a] = number[b] = number[c] = 0
    used = np.flatnonzero(number == 0)
    number[used] = np.arange(len(used))
    left = np.empty((count, 3), np.int32)
    at = 0
    for f in range(len(faces)):
        if whole[f]:
            for k in range(3):
                left[at, k] = number[goes_to[faces[f, k]]]
            at += 1
    return left, whole, used


@njit(cache=True, nogil=True)
def _collapse(
    vertices: np.ndarray,
    faces: np.ndarray,
    starts: np.ndarray,
    corners: np.ndarray,
    edges: np.ndarray,
    fixed: np.ndarray,
    longest2: float,
    goes_to: np.ndarray,
):
    locked = np.zeros(vertices.shape[0], np.bool_)
    seen = np.full(vertices.shape[0], -1, np.int64)
    place = np.empty(3)
    for e in range(edges.shape[0]):
        u, v = edges[e, 0], edges[e, 1]
        if fixed[v]:
            u, v = v, u
        if locked[u] or locked[v] or fixed[v]:
            continue
        for k in range(3):
            place[k] = vertices[u, k] if fixed[u] else 0.5 * (vertices[u, k] + vertices[v, k])
        fits = _fits(vertices, faces, starts, corners, u, v, place, longest2)
        fits = fits and _fits(vertices, faces, starts, corners, v, u, place, longest2)
        if not fits or _common(faces, starts, corners, u, v, e, seen) != 2:
            continue
        goes_to[v] = u
        for k in range(3):
            vertices[u, k] = place[k]
        for end in (u, v):
            for s in range(starts[end], starts[end + 1]):
                for k in range(3):
                    locked[faces[corners[s] // 3, k]] = True


@njit(cache=True, nogil=True)
def _fits(
    vertices: np.ndarray,
    faces: np.ndarray,
    starts: np.ndarray,
    corners: np.ndarray,
    moving: int,
    other: float,
    place: np.ndarray,
    longest2: float,
):
    """Whether the faces at `moving`, without `other`, stay unfolded and short with it at place."""
    old, new = np.empty(3), np.empty(3)
    for s in range(starts[moving], starts[moving + 1]):
        face, corner = corners[s] // 3, corners[s] % 3
        b, c = faces[face, (corner + 1) % 3], faces[face, (corner + 2) % 3]
        if b == other or c == other:
            continue
        _across(vertices[moving], vertices[b], vertices[c], old)
        _across(place, vertices[b], vertices[c], new)
        if _dot(old, new) < 0.5 * np.sqrt(_dot(old, old) * _dot(new, new)):
            return False
        reach2 = 0.0
        for k in range(3):
            reach2 += (vertices[b, k] - place[k]) ** 2
        if reach2 > longest2:
            return False
    return True


@njit(cache=True, nogil=True)
def _common(
    faces: np.ndarray,
    starts: np.ndarray,
    corners: np.ndarray,
    u: int,
    v: int,
    stamp: float,
    seen: np.ndarray,
):
    """Number of vertices next to both u and v."""
    for s in range(starts[u], starts[u + 1]):
        for k in range(3):
            seen[faces[corners[s] // 3, k]] = 2 * stamp
    count = 0
    for s in range(starts[v], starts[v + 1]):
        for k in range(3):
            w = faces[corners[s] // 3, k]
            if w != u and w != v and seen[w] == 2 * stamp:
                seen[w] = 2 * stamp + 1
                count += 1
    return count


def flip_to_delaunay(mesh: Triangles, twins: Int64[np.ndarray, " h"]) -> Triangles:
    """Turn edges whose two opposite angles exceed 180 degrees together."""
    faces = mesh.faces.copy()
    starts, corners = corners_by_vertex(faces, len(mesh.vertices))
    _flip(mesh.vertices, faces, twins, starts, corners, mesh.frozen.copy())
    return mesh._replace(faces=faces)


@njit(cache=True, nogil=True)
def _flip(
    vertices: np.ndarray,
    faces: np.ndarray,
    twins: np.ndarray,
    starts: np.ndarray,
    corners: np.ndarray,
    touched: np.ndarray,
):
    gained = np.zeros(vertices.shape[0], np.bool_)
    original = faces.copy()
    upper, lower, outward = np.empty(3), np.empty(3), np.empty(3)
    for h in range(twins.shape[0]):
        g = twins[h]
        if g < h or touched[h // 3] or touched[g // 3]:
            continue
        a, b = faces[h // 3, h % 3], faces[h // 3, (h + 1) % 3]
        c, d = faces[h // 3, (h + 2) % 3], faces[g // 3, (g + 2) % 3]
        if c == d or (gained[c] and gained[d]):
            continue
        pa, pb, pc, pd = vertices[a], vertices[b], vertices[c], vertices[d]
        _across(pc, pa, pb, upper)
        _across(pd, pb, pa, lower)
        size_up, size_low = np.sqrt(_dot(upper, upper)), np.sqrt(_dot(lower, lower))
        facing_up = facing_low = 0.0
        for k in range(3):
            facing_up += (pa[k] - pc[k]) * (pb[k] - pc[k])
            facing_low += (pa[k] - pd[k]) * (pb[k] - pd[k])
            outward[k] = upper[k] + lower[k]
        # The sum of the two angles' cotangents, times both areas.
        if facing_up * size_low + facing_low * size_up >= -1e-9 * size_up * size_low:
            continue
        _across(pc, pa, pd, upper)
        _across(pc, pd, pb, lower)
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
        gained[c] = gained[d] = True


@njit(cache=True, nogil=True)
def _across(p: np.ndarray, q: np.ndarray, r: np.ndarray, out: np.ndarray):
    """Twice the area of a triangle, along its normal."""
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        out[k] = (q[i] - p[i]) * (r[j] - p[j]) - (q[j] - p[j]) * (r[i] - p[i])


@njit(cache=True, nogil=True)
def _dot(p: np.ndarray, q: np.ndarray):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


def smooth_along(mesh: Triangles, fixed: np.ndarray) -> Triangles:
    """Move vertices half way to the mean of their neighbours, within the tangent plane."""
    return mesh._replace(vertices=_smoothed(mesh.vertices, mesh.faces, fixed))


@njit(cache=True, nogil=True)
def _smoothed(vertices: np.ndarray, faces: np.ndarray, fixed: np.ndarray):
    count = len(vertices)
    sums, normals, heads = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count)
    across = np.empty(3)
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        _across(vertices[a], vertices[b], vertices[c], across)
        for tail, head in ((a, b), (b, c), (c, a)):
            heads[tail] += 1
            for k in range(3):
                sums[tail, k] += vertices[head, k]
                normals[tail, k] += across[k]
    moved = vertices.copy()
    for v in range(count):
        if fixed[v] or heads[v] == 0:
            continue
        normal2 = max(_dot(normals[v], normals[v]), 1e-60)
        out = 0.0
        for k in range(3):
            out += (sums[v, k] / heads[v] - vertices[v, k]) * normals[v, k] / normal2
        for k in range(3):
            step = sums[v, k] / heads[v] - vertices[v, k] - out * normals[v, k]
            moved[v, k] += 0.5 * step
    return moved


_ROUNDS = 4
_RETURNS = (1, 3)
"""Rounds after which the vertices return to the surface: along it they leave it by next to nothing,
and the search for the nearest place takes half of the time."""


def refine(mesh: Mesh, edge_mm: float) -> Mesh:
    """Even triangles with edges of about `edge_mm`, on the given surface.

    Colour, filled mark and sigma come from the nearest vertex of the given mesh.
    """
    if not is_edge_manifold(mesh.faces):
        raise SurfaceError("surface.not_manifold")
    tree = TriangleTree.of(mesh.vertices_mm, mesh.faces)
    work = Triangles(
        mesh.vertices_mm, mesh.faces, np.zeros(len(mesh.faces), np.bool_), np.arange(len(mesh))
    )
    on_face = np.zeros(len(mesh), np.int64)
    for number in track(range(_ROUNDS)):
        work, fixed = _evened_out(work, edge_mm)
        if number in _RETURNS:
            nearest = tree.closest(work.vertices)
            work.vertices[~fixed] = nearest.points_mm[~fixed]
            on_face = nearest.faces
    result = taking_vertices(mesh, _nearest_corners(mesh, on_face, work.vertices))
    return replace(result, vertices_mm=work.vertices, faces=work.faces)


def even_out(work: Triangles, edge: float) -> Triangles:
    """One round towards edges of one length."""
    return _evened_out(work, edge)[0]


def _evened_out(work: Triangles, edge: float) -> tuple[Triangles, np.ndarray]:
    """The same, and which vertices had to stay."""
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
    apart = np.linalg.norm(mesh.vertices_mm[corners] - places[:, None], axis=2)
    return np.take_along_axis(corners, apart.argmin(1)[:, None], 1)[:, 0]
