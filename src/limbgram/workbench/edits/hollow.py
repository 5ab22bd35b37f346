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
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.closest import TriangleTree
from limbgram.core.mesh.levels import level_surface
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.signed import SignedSurface
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    boundary_loops,
    edge_lengths,
    face_components,
    find_edges,
    volume_mm3,
    with_any,
    with_faces,
)
from limbgram.reconstruction.surface.resampling import refine
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.edits.spanning import spanned
from limbgram.workbench.edits.strip import strip

_CELL, _CELL_SHARE, _MOST_CELLS = 1.25, 0.5, 4e6
"""Size of a cell: in edges of a usual triangle, and as a share of the thickness at most; and how
many cells there are at most, which makes them larger."""
_MARGIN = 3.0
"""Cells by which what is looked at goes on beyond the openings."""
_GAP = 0.5
"""Cells between an opening and the skin of the hollow, across which the two are joined."""
_MOVES = 3
"""Times that the vertices of the hollow's skin are moved to the wall's thickness."""
_FITTINGS = 5
"""Times that openings without a hollow are closed."""
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
        bare = Mesh(vertices_mm=self.mesh.vertices_mm, faces=self.mesh.faces)
        return spanned(bare)

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
        strips.append(numbers[strip(rim.vertices_mm[outline], hollow.mesh.vertices_mm[back])])
    places = np.concatenate([hollow.mesh.vertices_mm, added])
    return Hollowed(
        vertices_mm=places,
        hollow=inner,
        hollow_faces=(hollow.mesh.faces + count).astype(np.int32),
        rim_faces=np.concatenate([of_rim[rim.faces], *strips]).astype(np.int32),
        like=np.asarray(KDTree(shape.mesh.vertices_mm).query(places)[1], np.int64),
        left_out_mm3=hollow.left_out_mm3,
    )
