"""Topology of triangle lists: edges, boundary loops, components, non-manifold places.

A half-edge is one side of a face: half-edge 3 f + k runs from corner k of face f to the next.
"""

from collections import deque
from dataclasses import dataclass, replace
from functools import cached_property
from threading import Lock

import numpy as np
from jaxtyping import Bool, Int32, Int64, Integer

from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh, crosses

_INSERTION_SORTED = 32
"""Length of the runs that are sorted by insertion, and merged if there are several."""


@dataclass(frozen=True)
class Neighbours:
    """Vertex adjacency in compressed sparse row form, neighbours in rising order."""

    starts: Int32[np.ndarray, " n"]
    """Neighbours of vertex v are vertices[starts[v]:starts[v + 1]]."""
    vertices: Int32[np.ndarray, " k"]
    edges: Int64[np.ndarray, " k"]
    """The edge to each neighbour."""


@dataclass(frozen=True)
class Edges:
    """Undirected edges of a triangle list, ends in rising order."""

    ends: Int32[np.ndarray, "e 2"]
    of_half_edge: Int64[np.ndarray, " h"]
    """Edge of each half-edge."""
    uses: Int64[np.ndarray, " e"]
    """Number of faces at each edge: 1 on a boundary, 2 inside a manifold."""
    half_edges: Int64[np.ndarray, " h"]
    """Half-edges sorted by edge; those of one edge in rising order."""

    def faces(self) -> Int32[np.ndarray, "e 2"]:
        """The two faces at each edge, lower first; -1 where there is none."""
        return self._faces

    @cached_property
    def open_half_edges(self) -> Int64[np.ndarray, " b"]:
        """Half-edges without a face on their other side, in rising order."""
        return _frozen(np.flatnonzero(self.uses[self.of_half_edge] == 1))

    @cached_property
    def neighbours(self) -> Neighbours:
        """Adjacency of the vertices up to the last that has a face."""
        count = int(self.ends.max(initial=-1)) + 1
        starts, vertices, edges = _neighbours(self.ends, count)
        return Neighbours(_frozen(starts), _frozen(vertices), _frozen(edges))

    @cached_property
    def _faces(self) -> Int32[np.ndarray, "e 2"]:
        order = self.half_edges
        first = np.cumsum(self.uses) - self.uses
        sides = np.full((len(self.ends), 2), -1, np.int32)
        sides[:, 0] = order[first] // 3
        inner = self.uses >= 2
        sides[inner, 1] = order[first[inner] + 1] // 3
        return _frozen(sides)


_KEPT: "deque[tuple[Faces, Edges]]" = deque(maxlen=2)
"""The face arrays asked for last, with their edges; for 250,000 faces they take 40 MB."""
_LOCK = Lock()


def half_edges(faces: Faces) -> Int32[np.ndarray, "h 2"]:
    """Tail and head vertex of every half-edge."""
    return np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)


def find_edges(faces: Faces) -> Edges:
    """The edges of a triangle list, cached for the lists asked for last.

    The cache compares contents, since an array may have been changed in place.
    """
    with _LOCK:
        for known in _KEPT:
            if known[0].dtype == faces.dtype and np.array_equal(known[0], faces):
                return known[1]
    edges = _edges_of(faces)
    with _LOCK:
        _KEPT.append((faces.copy(), edges))
    return edges


def _edges_of(faces: Faces) -> Edges:
    tails, heads = half_edges(faces).T
    pairs = number_pairs(np.minimum(tails, heads), np.maximum(tails, heads))
    first = pairs.order[pairs.starts[:-1]]
    low, high = np.minimum(tails[first], heads[first]), np.maximum(tails[first], heads[first])
    edges = Edges(np.column_stack([low, high]), pairs.number, np.diff(pairs.starts), pairs.order)
    for part in (edges.ends, edges.of_half_edge, edges.uses, edges.half_edges):
        _frozen(part)
    return edges


def _frozen(part: np.ndarray) -> np.ndarray:
    """The array, made read-only, as the cache shares it."""
    part.flags.writeable = False
    return part


@njit(cache=True, nogil=True)
def _neighbours(ends: np.ndarray, count: int):
    """Neighbours as in `Neighbours`; rising, because edges are sorted by lower, then upper end."""
    starts = np.zeros(count + 1, np.int32)
    for e in range(len(ends)):
        starts[ends[e, 0] + 1] += 1
        if ends[e, 0] != ends[e, 1]:
            starts[ends[e, 1] + 1] += 1
    for vertex in range(count):
        starts[vertex + 1] += starts[vertex]
    vertices = np.empty(starts[count], np.int32)
    edges = np.empty(starts[count], np.int64)
    slot = starts[:count].copy()
    for e in range(len(ends)):
        for own, other in ((ends[e, 0], ends[e, 1]), (ends[e, 1], ends[e, 0])):
            vertices[slot[own]], edges[slot[own]] = other, e
            slot[own] += 1
            if own == other:
                break
    return starts, vertices, edges


@dataclass(frozen=True)
class Pairs:
    """Unique pairs of integers, in rising order."""

    number: Int64[np.ndarray, " n"]
    """Index of each given pair among the unique ones."""
    order: Int64[np.ndarray, " n"]
    """Stable sort order of the given pairs."""
    starts: Int64[np.ndarray, " k"]
    """Pairs equal to unique pair k are order[starts[k]:starts[k + 1]]."""


def number_pairs(
    one: Int32[np.ndarray, " n"] | Int64[np.ndarray, " n"], two: Int32[np.ndarray, " n"]
) -> Pairs:
    """Unique pairs, as np.unique with inverse, but by counting sort."""
    counts = np.bincount(one)
    starts = np.cumsum(counts) - counts
    first, second = (np.ascontiguousarray(numbers, np.int64) for numbers in (one, two))
    return Pairs(*_numbered(first, second, starts))


@njit(cache=True, nogil=True)
def _numbered(one: np.ndarray, two: np.ndarray, slots: np.ndarray):
    """Counting sort by the first integer, then a sort by the second in each bucket."""
    count = len(one)
    order, seconds = np.empty(count, np.int64), np.empty(count, np.int64)
    for i in range(count):
        slot = slots[one[i]]
        order[slot], seconds[slot] = i, two[i]
        slots[one[i]] = slot + 1
    number, starts = np.empty(count, np.int64), np.empty(count + 1, np.int64)
    found = begin = 0
    for end in slots:  # each slot now ends its bucket
        _sort_bucket(seconds[begin:end], order[begin:end])
        for at in range(begin, end):
            if at == begin or seconds[at] != seconds[at - 1]:
                starts[found] = at
                found += 1
            number[order[at]] = found - 1
        begin = end
    starts[found] = count
    return number, order, starts[: found + 1].copy()


@njit(cache=True, nogil=True)
def _sort_bucket(keys: np.ndarray, order: np.ndarray):
    """Stable sort of keys, and of `order` with them.

    By hand: numba takes 4 s to compile its argsort and indexed copies.
    """
    count = len(keys)
    for begin in range(0, count, _INSERTION_SORTED):
        for i in range(begin + 1, min(begin + _INSERTION_SORTED, count)):
            key, item, at = keys[i], order[i], i
            while at > begin and keys[at - 1] > key:
                keys[at], order[at] = keys[at - 1], order[at - 1]
                at -= 1
            keys[at], order[at] = key, item
    if count > _INSERTION_SORTED:
        _merge_runs(keys, order)


@njit(cache=True, nogil=True)
def _merge_runs(keys: np.ndarray, order: np.ndarray):
    """Merge sorted runs of `_INSERTION_SORTED` two by two until one is left."""
    count, width = len(keys), _INSERTION_SORTED
    old_keys, old_order = np.empty(count, np.int64), np.empty(count, np.int64)
    while width < count:
        for i in range(count):
            old_keys[i], old_order[i] = keys[i], order[i]
        for begin in range(0, count, 2 * width):
            middle, end = min(begin + width, count), min(begin + 2 * width, count)
            left, right = begin, middle
            for at in range(begin, end):
                if right == end or (left < middle and old_keys[left] <= old_keys[right]):
                    keys[at], order[at] = old_keys[left], old_order[left]
                    left += 1
                else:
                    keys[at], order[at] = old_keys[right], old_order[right]
                    right += 1
        width *= 2


def is_edge_manifold(faces: Faces) -> bool:
    """No edge has more than two faces, and neighbours agree on what is outside."""
    return not broken_half_edges(faces).any()


def broken_half_edges(faces: Faces) -> Bool[np.ndarray, " h"]:
    """Half-edges at edges of more than two faces, or of two that disagree on what is outside."""
    edges = find_edges(faces)
    forward = half_edges(faces)[:, 0] == edges.ends[edges.of_half_edge, 0]
    forward_uses = np.bincount(edges.of_half_edge, forward, len(edges.ends))
    broken = (edges.uses > 2) | ((edges.uses == 2) & (forward_uses != 1))
    return broken[edges.of_half_edge]


def boundary_half_edges(faces: Faces) -> Int32[np.ndarray, "b 2"]:
    """Half-edges without a face on their other side."""
    border = find_edges(faces).open_half_edges
    face, corner = border // 3, border % 3
    return np.column_stack([faces[face, corner], faces[face, (corner + 1) % 3]])


def boundary_vertices(faces: Faces, count: int) -> Bool[np.ndarray, " n"]:
    """Which of `count` vertices lie on a boundary."""
    at_boundary = np.zeros(count, np.bool_)
    at_boundary[boundary_half_edges(faces).ravel()] = True
    return at_boundary


def dilated(chosen: Bool[np.ndarray, " n"], faces: Faces, rings: int) -> Bool[np.ndarray, " n"]:
    """The chosen vertices and this many rings of neighbours round them."""
    grown = chosen.copy()
    for _ in range(rings):
        grown[faces[faces_touching(grown, faces)]] = True
    return grown


def boundary_loops(faces: Faces) -> list[Int32[np.ndarray, " l"]]:
    """Vertices round every opening, along the faces' own half-edges.

    The faces must be edge-manifold and vertex-manifold, so that one boundary half-edge leaves
    every boundary vertex.
    """
    border = boundary_half_edges(faces)
    next_vertex = dict(zip(border[:, 0].tolist(), border[:, 1].tolist(), strict=True))
    loops: list[Int32[np.ndarray, " l"]] = []
    while next_vertex:
        start, vertex = next_vertex.popitem()
        loop = [start]
        while vertex != start:
            loop.append(vertex)
            vertex = next_vertex.pop(vertex)
        loops.append(np.array(loop, np.int32))
    return sorted(loops, key=lambda loop: (-len(loop), int(loop.min())))


def face_components(faces: Faces) -> Int32[np.ndarray, " f"]:
    """Label of each face's edge-connected component."""
    sides = find_edges(faces).faces()
    return components(sides[sides[:, 1] >= 0], len(faces))


def largest_piece(mesh: Mesh) -> tuple[Mesh, int]:
    """The connected component of the largest area, and how many others there are."""
    component = face_components(mesh.faces)
    areas = np.bincount(component, np.linalg.norm(mesh.face_normals(), axis=1))
    return with_faces(mesh, mesh.faces[component == np.argmax(areas)]), len(areas) - 1


def corner_fans(faces: Faces) -> Int32[np.ndarray, "f 3"]:
    """Label of the fan that each corner belongs to: one fan is one manifold vertex.

    Two corners at one vertex share a fan if a walk across edges at that vertex joins them.
    The faces must be edge-manifold.
    """
    edges = find_edges(faces)
    order = edges.half_edges
    first = (np.cumsum(edges.uses) - edges.uses)[edges.uses == 2]
    one, two = order[first], order[first + 1]
    # Half-edge h of corner h meets its opposite, whose tail is the next corner's vertex.
    links = np.concatenate(
        [np.column_stack([one, _next_corner(two)]), np.column_stack([_next_corner(one), two])]
    )
    return components(links, 3 * len(faces)).reshape(-1, 3)


def is_vertex_manifold(faces: Faces) -> bool:
    """The faces at every vertex make one fan; the faces must be edge-manifold."""
    return bool(corner_fans(faces).max(initial=-1) + 1 == np.count_nonzero(_used(faces)))


def split_nonmanifold_vertices(mesh: Mesh) -> Mesh:
    """The mesh with each vertex at which several fans meet doubled, one for each fan."""
    if is_vertex_manifold(mesh.faces):
        return mesh
    fans = corner_fans(mesh.faces)
    first = np.unique(fans, return_index=True)[1]
    vertex_of_fan = mesh.faces.ravel()[first].astype(np.int64)
    return replace(select_vertices(mesh, vertex_of_fan), faces=fans)


def with_faces(mesh: Mesh, faces: Faces) -> Mesh:
    """The mesh with other faces on its vertices; vertices without a face are dropped."""
    used = _used(faces)
    compact = np.cumsum(used, dtype=np.int32) - np.int32(1)
    return replace(select_vertices(mesh, np.flatnonzero(used)), faces=compact[faces])


def select_vertices(mesh: Mesh, idx: Integer[np.ndarray, " k"]) -> Mesh:
    """The mesh with the vertices `idx` and their attributes; faces are not renumbered."""
    known = mesh.of_vertices(lambda _, values: values[idx])
    return replace(mesh, vertices_mm=mesh.vertices_mm[idx], **known)


def unmeasured_at(mesh: Mesh, chosen: Bool[np.ndarray, " n"]) -> Mesh:
    """The mesh with these vertices marked as unmeasured."""
    known = mesh.of_vertices(lambda one, values: one.at_unmeasured(values, chosen))
    return replace(mesh, **known | {"filled": chosen if mesh.filled is None else known["filled"]})


def touches_itself(mesh: Mesh, loop: Int32[np.ndarray, " l"]) -> bool:
    """Whether a loop of vertices passes through one point twice."""
    return len(np.unique(mesh.vertices_mm[loop], axis=0)) < len(loop)


def volume_mm3(mesh: Mesh) -> float:
    """Enclosed volume; each opening counts as closed by a cone from its own vertices' mean."""
    faces = mesh.faces
    border = boundary_half_edges(faces)
    centre = mesh.vertices_mm[border[:, 0]].mean(0) if len(border) else mesh.vertices_mm.mean(0)
    centred = mesh.vertices_mm - centre
    whole = float(np.einsum("ij,ij->", _first_corners(centred, faces), crosses(centred, faces))) / 6
    return whole + _cones_mm3(centred, border) if len(border) else whole


@dataclass(frozen=True, kw_only=True)
class Enclosed:
    """Enclosed volume, and whether the surface is watertight."""

    watertight: bool
    """See `is_watertight`."""
    open_edges: int
    volume_mm3: float
    """See `volume_mm3`."""


def enclosed_by(mesh: Mesh) -> Enclosed:
    """Enclosed volume of a surface, and whether it is watertight."""
    return Enclosed(
        watertight=is_watertight(mesh.faces),
        open_edges=len(boundary_half_edges(mesh.faces)),
        volume_mm3=volume_mm3(mesh),
    )


def is_watertight(faces: Faces) -> bool:
    """Whether there are faces, and every edge has two that agree on what is outside."""
    return bool(len(faces)) and not len(boundary_half_edges(faces)) and is_edge_manifold(faces)


def is_inside_out(mesh: Mesh) -> bool:
    """Whether normals point into the enclosed volume, as on the inner surface of a socket."""
    return volume_mm3(mesh) < 0


@njit(cache=True, nogil=True)
def _first_corners(vertices: np.ndarray, faces: np.ndarray):
    """Positions of each face's first corner."""
    found = np.empty((len(faces), 3))
    for f in range(len(faces)):
        for axis in range(3):
            found[f, axis] = vertices[faces[f, 0], axis]
    return found


@njit(cache=True, nogil=True)
def edge_lengths(vertices: np.ndarray, ends: np.ndarray):
    """Length of each edge: np.linalg.norm to the last bit."""
    found = np.empty(len(ends))
    for e in range(len(ends)):
        one, two = ends[e, 0], ends[e, 1]
        x = vertices[one, 0] - vertices[two, 0]
        y = vertices[one, 1] - vertices[two, 1]
        z = vertices[one, 2] - vertices[two, 2]
        found[e] = np.sqrt(x * x + y * y + z * z)
    return found


def _cones_mm3(centred: Points3, border: Int32[np.ndarray, "b 2"]) -> float:
    """Volume under the cones that close the openings; 0 for one, whose apex is the origin."""
    used, ends = np.unique(border, return_inverse=True)
    ends = ends.reshape(-1, 2)
    loop = components(ends, len(used))
    if not loop.max():
        return 0.0
    counts = np.bincount(loop)
    apexes = np.column_stack([np.bincount(loop, axis) / counts for axis in centred[used].T])
    start, stop = centred[border[:, 0]], centred[border[:, 1]]
    return float(np.einsum("ij,ij->", stop, np.cross(start, apexes[loop[ends[:, 0]]]))) / 6


def _used(faces: Faces) -> Bool[np.ndarray, " n"]:
    """Whether each vertex, up to the last that has a face, has one."""
    return np.bincount(faces.ravel()) > 0


def _next_corner(corner: Int64[np.ndarray, " h"]) -> Int64[np.ndarray, " h"]:
    return np.where(corner % 3 == 2, corner - 2, corner + 1)


@njit(cache=True, nogil=True)
def faces_touching(marked: np.ndarray, faces: np.ndarray):
    """Mask of the faces with a marked vertex."""
    found = np.empty(len(faces), np.bool_)
    for f in range(len(faces)):
        found[f] = marked[faces[f, 0]] or marked[faces[f, 1]] or marked[faces[f, 2]]
    return found


def components(links: Integer[np.ndarray, "k 2"], count: int) -> Int32[np.ndarray, " n"]:
    """Connected component of each node of a graph, numbered in the order of their first nodes."""
    return _components(np.ascontiguousarray(links, np.int64), count)


def components_among(
    chosen: Bool[np.ndarray, " n"], links: Integer[np.ndarray, "k 2"]
) -> Int32[np.ndarray, " c"]:
    """`components` of the chosen nodes and the links between them, for the chosen nodes alone."""
    number = np.cumsum(chosen) - 1
    return components(number[links[chosen[links].all(axis=1)]], int(chosen.sum()))


@njit(cache=True, nogil=True)
def _components(links: np.ndarray, count: int):
    """Union-find."""
    root = np.arange(count)
    for k in range(len(links)):
        one, two = links[k, 0], links[k, 1]
        while root[one] != one:
            root[one] = root[root[one]]
            one = root[one]
        while root[two] != two:
            root[two] = root[root[two]]
            two = root[two]
        root[max(one, two)] = min(one, two)
    labels, found = np.empty(count, np.int32), 0
    for node in range(count):
        if root[node] == node:
            labels[node] = found
            found += 1
        else:
            labels[node] = labels[root[node]]
    return labels


def corners_by_vertex(faces: Faces, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Corners (3 f + k) at vertex v are corners[starts[v]:starts[v + 1]]."""
    flat = faces.ravel()
    starts = np.concatenate([[0], np.cumsum(np.bincount(flat, minlength=count))])
    corners = np.empty(flat.size, np.int64)
    _sort_corners(flat, starts[:-1].copy(), corners)
    return starts, corners


@njit(cache=True, nogil=True)
def _sort_corners(vertex_of: np.ndarray, slots: np.ndarray, corners: np.ndarray):
    """Stable counting sort of the corners by vertex."""
    for corner in range(vertex_of.shape[0]):
        corners[slots[vertex_of[corner]]] = corner
        slots[vertex_of[corner]] += 1
