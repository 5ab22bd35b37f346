"""Hollow: an inward wall that is nowhere thinner than asked: what is too narrow for it is solid.

In      an open Mesh and the wall's thickness.
Out     the wall: the given skin as it was, the skin of the hollow, and the rim between them.
Method  Openings are closed straight across. The hollow is what lies farther from the given skin
        than the wall is thick, inside and a little beyond the openings: a level of the distance on
        a grid, its vertices moved to the distance itself. The wall is the closed shape without it;
        what is left of the openings is the rim. Hollows that reach no opening stay solid.
Fails   EditError: no hollow is left.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from jaxtyping import Bool, Float64, Int32, Int64
from scipy.spatial import KDTree

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.booleans import without
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.folds import ANY_SHAPE, unfolded
from limbgram.core.mesh.isosurface import level_surface
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.core.mesh.signed_distance import SignedSurface
from limbgram.core.mesh.topology import face_components, with_any, with_faces
from limbgram.reconstruction.surface.resampling import Triangles, collapse_short, refine
from limbgram.workbench.edits.apart import FINE_TO, FINER, Apart
from limbgram.workbench.edits.fineness import refine_where
from limbgram.workbench.edits.regions import averaging
from limbgram.workbench.edits.spanning import spanned

_MARGIN = 3.0
"""Cells by which what is looked at goes on beyond the openings."""
_BEVEL, _BEVELLED_DEG, _EVENED = 1.5, (75.0, 60.0), 4
"""Width of a bevel of the rim, in cells; angles of an edge between which it begins; and how often
it is spread over the vertices of an opening."""
_LEAST_ACUTE = 0.05
"""Of what is less acute no bevel is made."""
_BEYOND = 2.0
"""Cells beyond the openings to which the hollow's skin is moved to the wall's thickness, so that it
is right where it leaves."""
_NEARER_MM, _ALONG = 0.04, 0.25
"""What is nearer by more where the hollow leaves is moved along the opening, unless the skin lies
almost straight above it: the cosine squared."""
_SHORTEST_MM, _SHORTENINGS = 0.01, 3
"""Shorter edges, as they come about where the hollow meets an opening, are none in a file of 32
bits; rounds in which they are taken out."""


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


@dataclass(frozen=True)
class Hollowing:
    """A skin that is to become a wall."""

    mesh: Mesh
    thickness_mm: float

    @cached_property
    def apart(self) -> Apart:
        return Apart(self.mesh, self.thickness_mm)

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

    @cached_property
    def _acute(self) -> Float64[np.ndarray, " c"]:
        """By how much the hollow would run under an opening, at each vertex of its cap: 0 where
        it goes straight in, 1 where the rim would end in an edge of 60 degrees or less."""
        caps = self.caps
        below = caps.vertices_mm - self.bevel_mm * caps.vertex_normals()
        away_mm = self.apart.tree.closest(np.concatenate([caps.vertices_mm, below])).distances_mm
        at, under = away_mm[: len(caps)], away_mm[len(caps) :]
        low, high = np.cos(np.radians(_BEVELLED_DEG))
        acute = np.clip(((under - at) / self.bevel_mm - low) / (high - low), 0.0, 1.0)
        mean = averaging(caps)
        for _ in range(_EVENED):
            acute = np.maximum(acute, mean @ acute)
        return np.where(acute > _LEAST_ACUTE, acute, 0.0)

    @property
    def bevel_mm(self) -> float:
        return min(_BEVEL * self.apart.cell_mm, self.thickness_mm / 2)

    def wanted_mm(self, points_mm: Points3) -> Float64[np.ndarray, " n"]:
        """How far from the skin the hollow begins: the wall's thickness, and less near an opening
        under which it would run: the edge there is bevelled, where it would be a thin lip."""
        wanted = np.full(len(points_mm), float(self.thickness_mm))
        nearest = KDTree(self.caps.vertices_mm).query(
            points_mm, distance_upper_bound=self.bevel_mm + self.apart.edge_mm, workers=1
        )
        near = np.flatnonzero(np.isfinite(nearest[0]))
        off_mm = self.cap_tree.closest(points_mm[near]).distances_mm
        acute = self._acute[np.asarray(nearest[1])[near]]
        wanted[near] -= acute * np.maximum(self.bevel_mm - off_mm, 0.0)
        return wanted

    def depths_mm(self, points_mm: Points3) -> Float64[np.ndarray, " n"]:
        """How far places lie inside the openings; negative outside."""
        away_mm = self.cap_tree.closest(points_mm).distances_mm
        return np.where(self.whole.signed(points_mm).signed_mm < 0, away_mm, -away_mm)


def hollowed(shape: Hollowing) -> Hollowed:
    """The wall inside a skin.

    Raises:
        EditError: no hollow is left.
    """
    hollow = _hollow(shape)
    if not len(hollow.faces):
        raise EditError("edit.wall.no_hollow")
    found = without(with_faces(shape.closed, shape.closed.faces), hollow)
    own = (found.of_one >= 0) & (found.of_one < len(shape.mesh.faces))
    of_hollow = np.zeros(len(found.vertices_mm), np.bool_)
    of_rim = of_hollow.copy()
    of_hollow[found.faces[found.of_one < 0]] = True
    of_rim[found.faces[~own & (found.of_one >= 0)]] = True
    work = Triangles(found.vertices_mm, found.faces, own, np.arange(len(found.vertices_mm)))
    for _ in range(_SHORTENINGS):
        work = collapse_short(work, _SHORTEST_MM, np.inf)
    edge = np.flatnonzero((of_hollow & of_rim)[work.origin])
    work.vertices[edge] = _no_nearer(shape, work.vertices[edge])
    added = work.faces[~work.frozen]
    inside = of_hollow[work.origin][added].all(1) & ~of_rim[work.origin][added].all(1)
    wanted = shape.wanted_mm(work.vertices)
    inside &= (wanted[added] == shape.thickness_mm).all(1)  # a bevel is a part of the rim
    return _numbered(shape, work, added[inside], added[~inside])


def _no_nearer(shape: Hollowing, points_mm: Points3) -> Points3:
    """Places on the openings, those too near to the skin moved along the opening."""
    nearest = shape.apart.tree.closest(points_mm)
    lacking_mm = shape.thickness_mm - nearest.distances_mm
    away = unit(points_mm - nearest.points_mm)
    normals = unit(shape.caps.face_normals()[shape.cap_tree.closest(points_mm).faces])
    away -= np.einsum("ij,ij->i", away, normals)[:, None] * normals
    size = np.einsum("ij,ij->i", away, away)
    moved = (lacking_mm > _NEARER_MM) & (size > _ALONG)
    moved &= shape.wanted_mm(points_mm) == shape.thickness_mm
    step_mm = np.where(moved, lacking_mm / np.maximum(size, _ALONG), 0.0)
    return points_mm + step_mm[:, None] * away


def _numbered(
    shape: Hollowing, work: Triangles, hollow: Faces, rim: Int32[np.ndarray, "r 3"]
) -> Hollowed:
    """The wall with the given skin's vertices by their own numbers, then the hollow's, then the
    rim's."""
    number = np.full(len(work.vertices), -1)
    skin = np.unique(work.faces[work.frozen])
    number[skin] = KDTree(shape.mesh.vertices_mm).query(work.vertices[skin])[1]
    count = len(shape.mesh)
    fresh = [np.unique(hollow[number[hollow] < 0])]
    number[fresh[0]] = count + np.arange(len(fresh[0]))
    fresh.append(np.unique(rim[number[rim] < 0]))
    number[fresh[1]] = count + len(fresh[0]) + np.arange(len(fresh[1]))
    places = work.vertices[np.concatenate(fresh)]
    return Hollowed(
        vertices_mm=places,
        hollow=len(fresh[0]),
        hollow_faces=number[hollow].astype(np.int32),
        rim_faces=number[rim].astype(np.int32),
        like=np.asarray(KDTree(shape.mesh.vertices_mm).query(places)[1], np.int64),
    )


def _hollow(shape: Hollowing) -> Mesh:
    """The hollows that reach an opening, and go on a little beyond it."""
    level = _level(shape)
    if not len(level.faces):
        return level
    level = refine(level, shape.apart.edge_mm)
    near = np.abs(shape.depths_mm(level.vertices_mm)) < FINE_TO * shape.apart.cell_mm
    level = refine_where(level, with_any(near, level.faces), FINER * shape.apart.edge_mm)
    deep_mm = shape.depths_mm(level.vertices_mm)
    parts = face_components(level.faces)
    opened = np.isin(parts, parts[with_any(deep_mm < 0, level.faces)])
    exact = deep_mm > -_BEYOND * shape.apart.cell_mm
    exact &= shape.wanted_mm(level.vertices_mm) == shape.thickness_mm
    within = np.flatnonzero(exact)
    number = np.cumsum(exact, dtype=np.int32) - np.int32(1)
    places = level.vertices_mm.copy()
    whole = level.faces[~with_any(~exact, level.faces)]
    places[within] = shape.apart.settled(places[within], number[whole])
    return unfolded(with_faces(level.with_vertices(places), level.faces[opened]), ANY_SHAPE).mesh


def _level(shape: Hollowing) -> Mesh:
    """Where the skin is as far as the wall is thick, inside and a little beyond the openings."""
    cell_mm = shape.apart.cell_mm
    reach_mm = _MARGIN * cell_mm + shape.apart.edge_mm
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
    values = shape.apart.farther_mm(lowest, counts, looked, shape.wanted_mm)
    if not (values > 0).any():
        return Mesh(vertices_mm=np.empty((0, 3)), faces=np.empty((0, 3), np.int32))
    return level_surface(values, lowest, cell_mm)


def _inside(closed: Mesh, points: Points3) -> Bool[np.ndarray, " n"]:
    """By what a ray upwards meets first; near the surface it may be wrong."""
    scene = EmbreeScene()
    TriangleMesh(scene, closed.vertices_mm[closed.faces].astype(np.float32))
    up = np.broadcast_to(np.array([0, 0, 1], np.float32), points.shape)
    met = np.asarray(scene.run(points.astype(np.float32), np.ascontiguousarray(up)))
    return (met >= 0) & (closed.face_normals()[met, 2] > 0)
