"""Geodesics: the shortest way over a surface between two places.

Method  Dijkstra over the edges finds a rough way; pulled taut on the surface it tells which faces
        to cross; unfolded into a plane these give the way exactly, and where it bends round a
        vertex whose other side is shorter, it is led round the other side (Xin and Wang 2007).
        The result is exact for the triangles: no way near it is shorter. A quite different way
        could be missed where it is shorter by less than a few per cent.
Fails   MeasureError: no surface joins the two places.

Lengths between two landmarks: along the limb's axis, straight, and over the surface.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.mesh.closest import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import Edges, find_edges
from limbgram.core.mesh.uncertainty import propagate
from limbgram.workbench.measures.levels import Figure, Sigmas
from limbgram.workbench.measures.straightening import Net, straighten

_FIRST_REACH = 1.6
"""The way is first looked for among faces that a way so much longer than straight could touch."""
_PULLS = ((6, 50), (12, 50), (24, 40), (48, 40), (96, 30))
"""Points of the rough way while it is pulled taut, and how often: coarse first."""
_BAND = 12
"""Edge lengths to either side of it among which the faces to cross are chosen."""


def shortest_path(mesh: Mesh, start_mm: Vector3, end_mm: Vector3) -> Points3:
    """The shortest polyline on the surface; both ends are first moved to the nearest place on it.

    Every piece lies in one triangle. `length_mm` gives its length.

    Raises:
        MeasureError: no surface joins the two places.
    """
    tree = TriangleTree.of(mesh.vertices_mm, mesh.faces)
    closest = tree.closest(np.stack([start_mm, end_mm]).astype(np.float64))
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
        kept = np.flatnonzero(near)
        start, end = (int(face) for face in np.searchsorted(kept, [first, last]))
        part = _Part.of(mesh, kept, _Ends(start, end, places_mm))
        found = part.shortest(tree)
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


@dataclass(frozen=True)
class _Ends:
    """Faces and places where the way starts and ends."""

    start: int
    end: int
    places_mm: Float64[np.ndarray, "2 3"]


@dataclass(frozen=True)
class _Part:
    """The part of a surface where a way is looked for."""

    net: Net
    ends: _Ends
    edge_ends: Int64[np.ndarray, "e 2"]

    @classmethod
    def of(cls, mesh: Mesh, kept: Int64[np.ndarray, " k"], ends: _Ends) -> "_Part":
        faces = mesh.faces[kept]
        edges = find_edges(faces)
        of_face = edges.of_half_edge.reshape(-1, 3)
        net = Net(mesh.vertices_mm, faces, of_face, _neighbours(edges))
        return cls(net, ends, edges.ends.astype(np.int64))

    def shortest(self, tree: TriangleTree) -> Points3 | None:
        """The shortest path inside the part; None where it does not join the places."""
        vertices = self.net.vertices_mm
        start, end = (self.net.faces[face] for face in (self.ends.start, self.ends.end))
        ways = vertices[self.edge_ends]
        sides = np.linalg.norm(ways[:, 0] - ways[:, 1], axis=1)
        route = _route(vertices, self.edge_ends, (start, end), self.ends.places_mm, sides)
        if route is None:
            return None
        rough = np.concatenate([self.ends.places_mm[:1], vertices[route], self.ends.places_mm[1:]])
        taut = _pulled_taut(tree, rough)
        strip = self._strip_along(taut) if length_mm(taut) < length_mm(rough) else None
        strip = strip or self._strip_along(rough)
        first_mm, last_mm = self.ends.places_mm
        return None if strip is None else straighten(self.net, strip, first_mm, last_mm)

    def _strip_along(self, way_mm: Points3) -> list[int] | None:
        """Neighbouring faces from start to end, near a way: Dijkstra over edge middles."""
        middles = self.net.vertices_mm[self.edge_ends].mean(1)
        sides = self.net.vertices_mm[self.edge_ends[self.net.edges]]
        of_face = self.net.edges
        size_mm = float(np.median(np.linalg.norm(sides[:, :, 0] - sides[:, :, 1], axis=2)))
        dense = _resampled(way_mm, 2 + int(2 * length_mm(way_mm) / size_mm))
        off = KDTree(dense).query(middles, distance_upper_bound=_BAND * size_mm)[0] / size_mm
        pairs = np.concatenate([of_face[:, [0, 1]], of_face[:, [1, 2]], of_face[:, [2, 0]]])
        pairs = pairs[np.isfinite(off[pairs]).all(1)]
        lengths = np.linalg.norm(middles[pairs[:, 0]] - middles[pairs[:, 1]], axis=1)
        steps = lengths * (1 + off[pairs].sum(1) ** 2)
        ends = of_face[self.ends.start], of_face[self.ends.end]
        crossed = _route(middles, pairs, ends, self.ends.places_mm, steps)
        if crossed is None:
            return None
        return [self.ends.start, *_faces_between(of_face, crossed), self.ends.end]


def _route(
    nodes_mm: Points3,
    pairs: Int64[np.ndarray, "p 2"],
    ends: tuple[np.ndarray, np.ndarray],
    places_mm: Float64[np.ndarray, "2 3"],
    steps: Float64[np.ndarray, " p"],
) -> Int64[np.ndarray, " k"] | None:
    """Nodes on the shortest way through a graph between two places, each joined to some nodes."""
    count = len(nodes_mm)
    links = [np.column_stack([end, [count + k] * len(end)]) for k, end in enumerate(ends)]
    reach = [np.linalg.norm(nodes_mm[end] - at, axis=1) for end, at in zip(ends, places_mm)]
    arcs = np.concatenate([pairs, *links])
    costs = np.maximum(np.concatenate((steps, *reach)), 1e-300)
    graph = coo_array((costs, (arcs[:, 0], arcs[:, 1])), shape=(count + 2, count + 2)).tocsr()
    far, before = dijkstra(graph, directed=False, indices=count, return_predecessors=True)
    if not np.isfinite(far[count + 1]):
        return None
    nodes = [count + 1]
    while nodes[-1] != count:
        nodes.append(int(before[nodes[-1]]))
    return np.array(nodes[-2:0:-1])


def _pulled_taut(tree: TriangleTree, rough_mm: Points3) -> Float64[np.ndarray, "pulled 3"]:
    """The way shortened on the surface, to within about a triangle."""
    way = rough_mm
    for count, times in _PULLS:
        way = _resampled(way, count)
        for _ in range(times):
            way[1:-1] = tree.closest((way[:-2] + 2 * way[1:-1] + way[2:]) / 4).points_mm
    return way


def _resampled(way_mm: Points3, count: int) -> Float64[np.ndarray, "count 3"]:
    """Points at equal distances along a polyline."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way_mm, axis=0), axis=1))])
    wanted = np.linspace(0, along[-1], count)
    return np.column_stack([np.interp(wanted, along, way_mm[:, axis]) for axis in range(3)])


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


@dataclass(frozen=True, kw_only=True)
class Length:
    """How far it is from one landmark to another, mm."""

    start: str
    end: str
    along_axis: Figure
    """Positive if the end lies more proximal."""
    straight: Figure
    over_surface: Figure
    path_in_limb_mm: Points3
    """The way over the surface."""


@dataclass(frozen=True)
class Place:
    """A landmark in the limb frame."""

    name: str
    in_limb_mm: Vector3


def length_between(sigmas: Sigmas, start: Place, end: Place) -> Length:
    """All lengths between two places on a mesh in the limb frame.

    Raises:
        MeasureError: no surface joins the two.
    """
    ends = np.stack([start.in_limb_mm, end.in_limb_mm])
    rise = float(ends[1, 2] - ends[0, 2])
    upwards = np.array([[0.0, 0, -1], [0, 0, 1]])
    path = shortest_path(sigmas.mesh, ends[0], ends[1])
    return Length(
        start=start.name,
        end=end.name,
        along_axis=_figure(sigmas, rise, ends, upwards),
        straight=_figure(sigmas, length_mm(ends), ends, _slopes(ends)),
        over_surface=_figure(sigmas, length_mm(path), path, _slopes(path)),
        path_in_limb_mm=path,
    )


def _slopes(path_mm: Points3) -> Points3:
    """Change of a polyline's length for a millimetre of each of its points."""
    steps = np.diff(path_mm, axis=0)
    along = steps / np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-300)
    slopes = np.zeros_like(path_mm)
    slopes[1:] += along
    slopes[:-1] -= along
    return slopes


def _figure(sigmas: Sigmas, value: float, places_mm: Points3, slopes: Points3) -> Figure:
    if sigmas.mesh.sigma_mm is None:
        return Figure(value, None)
    return Figure(value, propagate(sigmas.mesh, vertex_gradient(sigmas, places_mm, slopes)))


def vertex_gradient(
    sigmas: Sigmas, places_mm: Points3, slopes: Points3
) -> Float64[np.ndarray, " vertices"]:
    """Change for a millimetre of each vertex along its normal; places ride on their triangles."""
    mesh = sigmas.mesh
    closest = TriangleTree.of(mesh.vertices_mm, mesh.faces).closest(places_mm)
    ids = mesh.faces[closest.faces]
    a, b, c = (mesh.vertices_mm[ids[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    size = np.maximum((normal**2).sum(1), 1e-300)
    at = closest.points_mm
    shares = np.column_stack(
        [
            (np.cross(c - b, at - b) * normal).sum(1) / size,
            (np.cross(a - c, at - c) * normal).sum(1) / size,
            (np.cross(b - a, at - a) * normal).sum(1) / size,
        ]
    )
    total = np.zeros(len(mesh.vertices_mm))
    for k in range(3):
        change = shares[:, k] * (sigmas.normals[ids[:, k]] * slopes).sum(1)
        total += np.bincount(ids[:, k], change, len(total))
    return total
