"""Refinement: near-equilateral triangles of one size on the same surface.

In      a manifold Mesh.
Out     a Mesh of the asked edge length; its boundary curve stays where it was.
Method  Split, collapse, flip, smooth along the surface, return to it (Botsch, Kobbelt 2004). A pass
        works on tables made before it and touches no face or vertex twice, so it stays valid
        without rebuilding them on the way. Twins: half-edge 3 f + k runs from corner k of face f to
        the next corner; twins[h] is the half-edge on its other side, or -1 on the boundary.
Fails   SurfaceError: the mesh is not a manifold.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int32, Int64
from numba import njit

from limbgram.core.errors import SurfaceError
from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.closest import TriangleTree
from limbgram.core.mesh.mesh import Mesh, crosses, unit
from limbgram.core.mesh.topology import half_edges, is_edge_manifold, taking_vertices
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

    def fixed(self) -> np.ndarray:
        """Vertices that must stay: at frozen faces and on the boundary."""
        stays = np.zeros(len(self.vertices), np.bool_)
        stays[self.faces[self.frozen]] = True
        stays[half_edges(self.faces)[find_twins(self.faces) < 0]] = True
        return stays


def find_twins(faces: Faces) -> Int64[np.ndarray, " h"]:
    twins = np.full(faces.size, -1, np.int64)
    _pair_up(faces, int(faces.max(initial=-1)) + 1, twins)
    return twins


@njit(cache=True, nogil=True)
def _pair_up(faces: np.ndarray, count: int, twins: np.ndarray):
    """Half-edges of the same two vertices, by a counting sort of their lower vertex.

    A sort of all pairs of numbers took half of the time of evening out a mesh.
    """
    starts = np.zeros(count + 1, np.int64)
    for h in range(twins.shape[0]):
        starts[1 + min(faces[h // 3, h % 3], faces[h // 3, (h + 1) % 3])] += 1
    for v in range(count):
        starts[v + 1] += starts[v]
    ends = starts[:count].copy()
    edges = np.empty((twins.shape[0], 2), np.int64)
    for h in range(twins.shape[0]):
        a, b = faces[h // 3, h % 3], faces[h // 3, (h + 1) % 3]
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
    ends, twins = half_edges(faces), find_twins(faces)
    split = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1) > longest
    split &= ~np.repeat(frozen, 3)
    split &= split[twins] | (twins < 0)
    owner = np.flatnonzero(split & ((twins < 0) | (np.arange(len(ends)) < twins)))
    middle = np.full(len(ends), -1, np.int64)
    middle[owner] = len(vertices) + np.arange(len(owner))
    inner = owner[twins[owner] >= 0]
    middle[twins[inner]] = middle[inner]
    vertices = np.concatenate([vertices, vertices[ends[owner]].mean(1)])
    made = _subdivide(vertices, faces[~frozen], middle.reshape(-1, 3)[~frozen])
    return Triangles(
        vertices,
        np.concatenate([faces[frozen], made]),
        np.arange(frozen.sum() + len(made)) < frozen.sum(),
        np.concatenate([origin, origin[ends[owner, 0]]]),
    )


def _subdivide(
    vertices: Points3, faces: Faces, middle: Int64[np.ndarray, "f 3"]
) -> Int32[np.ndarray, "parts 3"]:
    """Faces by the pattern of their split edges; middle[f, k] is on the edge from corner k."""
    count = (middle >= 0).sum(1)
    parts = [faces[count == 0]]
    for marks in (1, 2, 3):
        chosen = count == marks
        # Turn each face so that its split edges come first.
        turn = (
            np.argmax(middle[chosen] >= 0, axis=1)
            if marks == 1
            else (np.argmin(middle[chosen], axis=1) + 1) % 3
        )
        columns = (turn[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(faces[chosen], columns, 1).T
        ab, bc, ca = np.take_along_axis(middle[chosen], columns, 1).T
        if marks == 1:
            parts += [np.column_stack([a, ab, c]), np.column_stack([ab, b, c])]
        elif marks == 2:
            across = _apart(vertices, a, bc) < _apart(vertices, ab, c)
            parts += [
                np.column_stack([ab, b, bc]),
                np.column_stack([a, ab, np.where(across, bc, c)]),
                np.column_stack([np.where(across, a, ab), bc, c]),
            ]
        else:
            parts += [
                np.column_stack(corners)
                for corners in ([a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca])
            ]
    return np.concatenate(parts).astype(np.int32)


def _apart(vertices: Points3, a: np.ndarray, b: np.ndarray) -> Float64[np.ndarray, " e"]:
    return np.linalg.norm(vertices[a] - vertices[b], axis=1)


def collapse_short(mesh: Triangles, shortest: float, longest: float) -> Triangles:
    """Contract edges shorter than `shortest` where the mesh stays a manifold and unfolded.

    No edge grows beyond `longest`.
    """
    vertices, faces = mesh.vertices.copy(), mesh.faces
    ends, twins = half_edges(faces), find_twins(faces)
    lengths = _apart(vertices, ends[:, 0], ends[:, 1])
    short = np.flatnonzero((lengths < shortest) & (twins > np.arange(len(ends))))
    short = short[np.argsort(lengths[short], kind="stable")]
    goes_to = np.arange(len(vertices), dtype=np.int32)
    starts, corners = corners_by_vertex(faces, len(vertices))
    _collapse(vertices, faces, starts, corners, ends[short], mesh.fixed(), longest**2, goes_to)
    moved = goes_to[faces]
    whole = (moved != np.roll(moved, 1, axis=1)).all(1)
    used, compact = np.unique(moved[whole], return_inverse=True)
    compact = compact.reshape(-1, 3).astype(np.int32)
    return Triangles(vertices[used], compact, mesh.frozen[whole], mesh.origin[used])


def corners_by_vertex(faces: Faces, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Corners (3 f + k) at vertex v are corners[starts[v]:starts[v + 1]]."""
    flat = faces.ravel()
    starts = np.concatenate([[0], np.cumsum(np.bincount(flat, minlength=count))])
    corners = np.empty(flat.size, np.int64)
    _sort_corners(flat, starts[:-1].copy(), corners)
    return starts, corners


@njit(cache=True, nogil=True)
def _sort_corners(vertex_of: np.ndarray, place: np.ndarray, corners: np.ndarray):
    """Corners in the order of their vertices, each vertex's in their own."""
    for corner in range(vertex_of.shape[0]):
        corners[place[vertex_of[corner]]] = corner
        place[vertex_of[corner]] += 1


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


def flip_to_delaunay(mesh: Triangles) -> Triangles:
    """Turn edges whose two opposite angles exceed 180 degrees together."""
    faces = mesh.faces.copy()
    starts, corners = corners_by_vertex(faces, len(mesh.vertices))
    _flip(mesh.vertices, faces, find_twins(faces), starts, corners, mesh.frozen.copy())
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


def smooth_along(mesh: Triangles) -> Triangles:
    """Move vertices half way to the mean of their neighbours, within the tangent plane."""
    vertices, faces = mesh.vertices, mesh.faces
    across = crosses(vertices, faces)
    tails, heads = half_edges(faces).T
    count = np.maximum(np.bincount(tails, minlength=len(vertices)), 1)
    means, normals = np.empty_like(vertices), np.empty_like(vertices)
    for axis in range(3):
        means[:, axis] = np.bincount(tails, vertices[heads, axis], len(vertices)) / count
        normals[:, axis] = np.bincount(faces.ravel(), np.repeat(across[:, axis], 3), len(vertices))
    normals = unit(normals)
    step = means - vertices
    step -= (step * normals).sum(1, keepdims=True) * normals
    return mesh._replace(vertices=vertices + np.where(mesh.fixed()[:, None], 0.0, 0.5 * step))


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
