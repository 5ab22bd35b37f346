"""Hollow: an inward wall that is nowhere thinner than asked: what is too narrow for it is solid.

In      an open Mesh and the wall's thickness.
Out     the wall: the given skin as it was, the skin of the hollow, and the rim between them.
Method  Openings are closed straight across. The hollow is what lies inside, farther from the given
        skin than the wall is thick: a level of the distance on a grid, its vertices moved to the
        distance itself. It ends at the openings; what is left of these is the rim. Hollows that
        reach no opening are left out.
Fails   EditError: no hollow is left, or it does not fit its openings.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from jaxtyping import Bool, Float64, Int32, Int64
from numba import njit
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.folds import find_bent
from limbgram.core.mesh.isosurface import level_surface
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.signed_distance import SignedSurface
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    boundary_loops,
    edge_lengths,
    face_components,
    find_edges,
    half_edges,
    is_vertex_manifold,
    volume_mm3,
    with_any,
    with_faces,
)
from limbgram.reconstruction.surface.holes import triangulate
from limbgram.reconstruction.surface.resampling import refine
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.edits.regions import with_closed

_CELL, _CELL_SHARE, _MOST_CELLS = 1.25, 0.5, 4e6
"""Size of a cell: in edges of a usual triangle, and as a share of the thickness at most; and how
many cells there are at most, which makes them larger."""
_MARGIN = 3.0
"""Cells by which what is looked at goes on beyond the openings."""
_GAP = 0.5
"""Cells between an opening and the skin of the hollow, across which the two are joined."""
_MOVES = 3
"""Times that the vertices of the hollow's skin are moved to the wall's thickness."""
_ACUTE_DEG = 120.0
"""Angle between the normals of neighbours from which a cap is laid anew."""
_FITTINGS, _MENDINGS = 5, 6
"""Times that openings without a hollow are closed, and that folds of caps are mended."""
Loop = Int32[np.ndarray, " _"]


@dataclass(frozen=True, kw_only=True)
class Hollowed:
    """A wall."""

    vertices_mm: Points3
    """Beside those of the given skin: of the hollow's skin, then of the rim."""
    hollow: int
    """How many are of the hollow's skin."""
    hollow_faces: Faces
    """Looking into the hollow; numbered on from the given skin's vertices."""
    rim_faces: Int32[np.ndarray, "r 3"]
    like: Int64[np.ndarray, " k"]
    """For each of the vertices the nearest one of the given skin."""
    left_out_mm3: float
    """Volume of hollows that reach no opening, and are solid."""


@dataclass(frozen=True)
class Hollowing:
    """A skin that is to become a wall."""

    mesh: Mesh
    thickness_mm: float

    @cached_property
    def tree(self) -> TriangleTree:
        return TriangleTree.of(self.mesh.vertices_mm, self.mesh.faces)

    @cached_property
    def edge_mm(self) -> float:
        return float(
            np.median(edge_lengths(self.mesh.vertices_mm, find_edges(self.mesh.faces).ends))
        )

    @cached_property
    def cell_mm(self) -> float:
        wanted = min(_CELL * self.edge_mm, _CELL_SHARE * self.thickness_mm)
        box_mm3 = float(np.ptp(self.mesh.vertices_mm, axis=0).prod())
        return max(wanted, (box_mm3 / _MOST_CELLS) ** (1 / 3))

    @cached_property
    def closed(self) -> Mesh:
        """With its openings closed straight across; its own faces come first."""
        closed = with_closed(self.mesh, boundary_loops(self.mesh.faces), bent=False)
        count, own = len(closed), self.mesh.faces
        new = ~np.isin(_names(closed.faces, count), _names(own, count))
        bare = Mesh(vertices_mm=closed.vertices_mm, faces=closed.faces)
        return _mended(bare, own, closed.faces[new])

    @cached_property
    def like(self) -> Int64[np.ndarray, " n"]:
        """For each vertex of the closed shape the nearest one of the skin."""
        added = self.closed.vertices_mm[len(self.mesh) :]
        nearest = KDTree(self.mesh.vertices_mm).query(added)[1]
        return np.concatenate([np.arange(len(self.mesh)), nearest]).astype(np.int64)

    @cached_property
    def whole(self) -> SignedSurface:
        return SignedSurface(self.closed.vertices_mm, self.closed.faces)

    @cached_property
    def _cap_faces(self) -> Faces:
        return self.closed.faces[len(self.mesh.faces) :]

    @cached_property
    def caps(self) -> Mesh:
        """What closes the openings alone; the brim's vertices come first."""
        return with_faces(self.closed, self._cap_faces)

    @cached_property
    def brim(self) -> Int64[np.ndarray, " b"]:
        """Vertices of the skin that are the first ones of its caps."""
        used = np.unique(self._cap_faces)
        return used[used < len(self.mesh)].astype(np.int64)

    @cached_property
    def cap_tree(self) -> TriangleTree:
        return TriangleTree.of(self.caps.vertices_mm, self.caps.faces)

    def depths_mm(self, points_mm: Points3) -> Float64[np.ndarray, " n"]:
        """How far places lie inside the openings; negative outside."""
        away_mm = self.cap_tree.closest(points_mm).distances_mm
        return np.where(self.whole.signed(points_mm).signed_mm < 0, away_mm, -away_mm)


def hollowed(shape: Hollowing) -> Hollowed:
    """The wall inside a skin.

    Raises:
        EditError: no hollow is left, or it does not fit its openings.
    """
    hollow = _Hollow.of(shape)
    beyond_mm = shape.tree.closest(shape.caps.vertices_mm).distances_mm - shape.thickness_mm
    for _ in range(_FITTINGS):
        if not len(hollow.mesh.faces):
            break
        rim = keep_positive(shape.caps, -beyond_mm).mesh
        fit = _fit(shape, rim, hollow.mesh)
        if not len(fit.hollow_left) and not len(fit.rim_left):
            return _joined(shape, rim, hollow, fit)
        beyond_mm = _closed_at(shape.caps, beyond_mm, rim.vertices_mm[fit.rim_left])
        hollow = hollow.without(fit.hollow_left)
    raise EditError("edit.wall.no_hollow")


def _names(faces: Faces, count: int) -> Int64[np.ndarray, " f"]:
    """A number for each face that tells its corners."""
    low, middle, high = np.sort(faces.astype(np.int64), axis=1).T
    return (low * count + middle) * count + high


def _mended(closed: Mesh, own: Faces, caps: Int32[np.ndarray, "k 3"]) -> Mesh:
    """The closed shape whose caps are laid anew, without places inside, where they fold onto it.

    The triangles of a cap follow a ragged edge loosely, and may lie over a tooth of it.
    """
    for rings in range(_MENDINGS):
        closed = replace(closed, faces=np.concatenate([own, caps]))
        new = np.arange(len(closed.faces)) >= len(own)
        bent = find_bent(closed, new, _ACUTE_DEG)
        crossing = find_crossings(closed.vertices_mm, closed.faces, new)
        spoilt = np.unique(closed.faces[np.concatenate([bent, crossing]).ravel()])
        if not len(spoilt):
            break
        near = np.zeros(len(closed), np.bool_)
        near[spoilt] = True
        for _ in range(rings):
            near[caps[with_any(near, caps)]] = True
        left = caps[~with_any(near, caps)]
        laid = _laid(closed.vertices_mm, np.concatenate([own, left]))
        if laid is not None:
            caps = np.concatenate([left, laid])
    return closed


def _laid(vertices: Points3, faces: Faces) -> Int32[np.ndarray, "k 3"] | None:
    """Triangles of the least area over all openings; None where there is no answer."""
    if not is_vertex_manifold(faces):
        return None
    ends = half_edges(faces)
    laid: list[Faces] = []
    for loop in boundary_loops(faces):
        place = np.full(len(vertices), -1)
        place[loop] = np.arange(len(loop))
        chords = place[ends]
        chords = chords[(chords >= 0).all(1)]
        taken = np.zeros((len(loop), len(loop)), np.bool_)
        taken[chords[:, 0], chords[:, 1]] = taken[chords[:, 1], chords[:, 0]] = True
        found = triangulate(vertices[loop], taken)
        if found is None:
            return None
        laid.append(loop[found])
    return np.concatenate(laid)


@dataclass(frozen=True)
class _Hollow:
    """The skin of hollows that reach an opening; its faces look into them."""

    mesh: Mesh
    left_out_mm3: float = 0.0

    @classmethod
    def of(cls, shape: Hollowing) -> "_Hollow":
        level = _level(shape)
        if not len(level.faces):
            return cls(level)
        level = refine(level, shape.edge_mm)
        inside = keep_positive(level, shape.depths_mm(level.vertices_mm)).mesh
        for _ in range(_MOVES):
            inside = inside.with_vertices(_at_distance(shape, inside.vertices_mm))
        deep_mm = shape.depths_mm(inside.vertices_mm) - _GAP * shape.cell_mm
        cut = keep_positive(inside, deep_mm).mesh
        turned = replace(cut, faces=np.ascontiguousarray(cut.faces[:, ::-1]))
        edge = np.zeros(len(turned), np.bool_)
        edge[boundary_half_edges(turned.faces)] = True
        parts = face_components(turned.faces)
        opened = np.isin(parts, parts[with_any(edge, turned.faces)])
        return cls(turned).kept(opened)

    def without(self, vertices: Int64[np.ndarray, " k"]) -> "_Hollow":
        """Without the hollows that have one of these vertices."""
        chosen = np.zeros(len(self.mesh), np.bool_)
        chosen[vertices] = True
        parts = face_components(self.mesh.faces)
        return self.kept(~np.isin(parts, parts[with_any(chosen, self.mesh.faces)]))

    def kept(self, faces: Bool[np.ndarray, " f"]) -> "_Hollow":
        if faces.all():
            return self
        gone = abs(volume_mm3(with_faces(self.mesh, self.mesh.faces[~faces])))
        return _Hollow(with_faces(self.mesh, self.mesh.faces[faces]), self.left_out_mm3 + gone)


def _level(shape: Hollowing) -> Mesh:
    """Where the skin is as far as the wall is thick, inside and a little beyond the openings."""
    cell_mm = shape.cell_mm
    reach_mm = _MARGIN * cell_mm + shape.edge_mm
    lowest = shape.closed.vertices_mm.min(0) - reach_mm - 2 * cell_mm
    highest = shape.closed.vertices_mm.max(0) + reach_mm + 2 * cell_mm
    counts = np.ceil((highest - lowest) / cell_mm).astype(np.int64) + 1
    points = lowest + cell_mm * np.indices(counts).reshape(3, -1).T
    looked = _inside(shape.closed, points)
    outside = np.flatnonzero(~looked)
    near = KDTree(shape.caps.vertices_mm).query(
        points[outside], distance_upper_bound=reach_mm, workers=1
    )
    looked[outside[np.isfinite(near[0])]] = True
    values = np.full(len(points), -shape.thickness_mm)
    values[looked] = shape.tree.closest(points[looked]).distances_mm - shape.thickness_mm
    if not (values > 0).any():
        return Mesh(vertices_mm=np.empty((0, 3)), faces=np.empty((0, 3), np.int32))
    return level_surface(values.reshape(counts), lowest, cell_mm)


def _inside(closed: Mesh, points: Points3) -> Bool[np.ndarray, " n"]:
    """By what a ray upwards meets first; near the surface it may be wrong."""
    scene = EmbreeScene()
    TriangleMesh(scene, closed.vertices_mm[closed.faces].astype(np.float32))
    up = np.broadcast_to(np.array([0, 0, 1], np.float32), points.shape)
    met = np.asarray(scene.run(points.astype(np.float32), np.ascontiguousarray(up)))
    return (met >= 0) & (closed.face_normals()[met, 2] > 0)


def _at_distance(shape: Hollowing, points_mm: Points3) -> Points3:
    """Places moved straight to or from the nearest place of the skin, to the wall's thickness."""
    nearest = shape.tree.closest(points_mm)
    size = np.maximum(nearest.distances_mm, 1e-9)[:, None]
    return nearest.points_mm + (points_mm - nearest.points_mm) * shape.thickness_mm / size


@dataclass(frozen=True)
class _Fit:
    """Outlines of the rim and of the hollow that belong together."""

    outlines: list[Loop]
    loops: list[Loop]
    rim_left: Int64[np.ndarray, " k"]
    """Vertices of outlines of the rim that have none of the hollow's."""
    hollow_left: Int64[np.ndarray, " l"]
    """The same the other way round."""


def _fit(shape: Hollowing, rim: Mesh, hollow: Mesh) -> _Fit:
    count = len(shape.brim)
    outlines = [loop for loop in boundary_loops(rim.faces) if (loop >= count).all()]
    loops = boundary_loops(hollow.faces)
    apart = np.array(
        [
            [
                float(KDTree(rim.vertices_mm[one]).query(hollow.vertices_mm[two])[0].mean())
                for two in loops
            ]
            for one in outlines
        ]
    ).reshape(len(outlines), len(loops))
    pairs: list[tuple[int, int]] = []
    if apart.size:
        pairs = [
            (k, int(apart[k].argmin()))
            for k in range(len(outlines))
            if apart[:, apart[k].argmin()].argmin() == k and apart[k].min() < 2 * shape.cell_mm
        ]
    ones, twos = {one for one, _ in pairs}, {two for _, two in pairs}
    none = [np.empty(0, np.int32)]
    return _Fit(
        [outlines[one] for one, _ in pairs],
        [loops[two] for _, two in pairs],
        np.concatenate([x for k, x in enumerate(outlines) if k not in ones] + none).astype(int),
        np.concatenate([x for k, x in enumerate(loops) if k not in twos] + none).astype(int),
    )


def _closed_at(
    caps: Mesh, beyond_mm: Float64[np.ndarray, " n"], places_mm: Float64[np.ndarray, "k 3"]
) -> Float64[np.ndarray, " n"]:
    """The same values, below zero all over openings that have an edge at these places."""
    if not len(places_mm):
        return beyond_mm
    open_there = beyond_mm > 0
    ends = find_edges(caps.faces).ends
    ends = ends[open_there[ends].all(1)]
    links = csr_array((np.ones(len(ends)), ends.T), shape=(len(caps), len(caps)))
    part = np.asarray(connected_components(links, directed=False)[1])
    candidates = np.flatnonzero(open_there)
    nearest = candidates[KDTree(caps.vertices_mm[candidates]).query(places_mm)[1]]
    return np.where(open_there & np.isin(part, part[nearest]), -1.0, beyond_mm)


def _joined(shape: Hollowing, rim: Mesh, hollow: _Hollow, fit: _Fit) -> Hollowed:
    """Rim and hollow, with a strip along each pair of outlines."""
    count, inner = len(shape.mesh), len(hollow.mesh)
    added = rim.vertices_mm[len(shape.brim) :]
    of_rim = np.concatenate([shape.brim, count + inner + np.arange(len(added))])
    strips: list[np.ndarray] = []
    for outline, loop in zip(fit.outlines, fit.loops, strict=True):
        back = loop[::-1]
        numbers = np.concatenate([of_rim[outline], count + back.astype(np.int64)])
        strips.append(numbers[_strip(rim.vertices_mm[outline], hollow.mesh.vertices_mm[back])])
    places = np.concatenate([hollow.mesh.vertices_mm, added])
    return Hollowed(
        vertices_mm=places,
        hollow=inner,
        hollow_faces=(hollow.mesh.faces + count).astype(np.int32),
        rim_faces=np.concatenate([of_rim[rim.faces], *strips]).astype(np.int32),
        like=np.asarray(KDTree(shape.mesh.vertices_mm).query(places)[1], np.int64),
        left_out_mm3=hollow.left_out_mm3,
    )


def _strip(ones: Points3, twos: Float64[np.ndarray, "m 3"]) -> Int64[np.ndarray, "k 3"]:
    """Triangles between two loops that run alike, of the least sum of the squared ways across.

    Numbered on from the first loop to the second (Fuchs, Kedem, Uselton 1977).
    """
    away, nearest = KDTree(twos).query(ones)
    first = int(np.argmin(away))
    one = np.roll(np.arange(len(ones)), -first)
    two = np.roll(np.arange(len(twos)), -int(np.asarray(nearest)[first]))
    one, two = np.append(one, one[0]), np.append(two, two[0])
    steps = _way(ones[one], twos[two])
    i = np.concatenate([[0], np.cumsum(steps == 0)])
    j = np.concatenate([[0], np.cumsum(steps == 1)])
    a, b, offset = one[i], two[j], len(ones)
    on_one = np.column_stack([a[1:], a[:-1], b[:-1] + offset])
    on_two = np.column_stack([b[:-1] + offset, b[1:] + offset, a[:-1]])
    return np.where((steps == 0)[:, None], on_one, on_two)


@njit(cache=True, nogil=True)
def _way(ones: np.ndarray, twos: np.ndarray):
    """Steps from the first pair of places to the last: 0 along the ones, 1 along the twos."""
    n, m = len(ones), len(twos)
    cost = np.empty(m)
    came = np.empty((n, m), np.int8)
    for i in range(n):
        for j in range(m):
            least = 0.0
            came[i, j] = 0
            if i > 0:
                least = cost[j]
            if j > 0 and (i == 0 or cost[j - 1] < least):
                least = cost[j - 1]
                came[i, j] = 1
            across = 0.0
            for axis in range(3):
                across += (ones[i, axis] - twos[j, axis]) ** 2
            cost[j] = least + across
    steps = np.empty(n + m - 2, np.int8)
    i, j = n - 1, m - 1
    for k in range(n + m - 3, -1, -1):
        steps[k] = came[i, j]
        if came[i, j] == 0:
            i -= 1
        else:
            j -= 1
    return steps
