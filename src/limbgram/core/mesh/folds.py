"""Folds: what no skin does and what slicers and carvers take literally, found and laid back.

Turned    faces that look against the surface round them.
Points    vertices inside the surface at which it comes to a point.
Bent      neighbouring faces at too sharp an edge.
Crossing  faces that pass through each other.
Method    Each vertex of a fold goes back to the mean of its neighbours, all of them at once: a net
          held at its rim, which does not fold over a flat convex one (Tutte 1963). Where it still
          folds, a ring more of the surface goes back with it.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int64
from scipy import sparse
from scipy.sparse import csgraph
from scipy.sparse.linalg import splu

from limbgram.core.geometry.arrays import Faces, Points3, Vector3
from limbgram.core.kernels import njit
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.mesh import Mesh, dots, lengths, summed, unit
from limbgram.core.mesh.topology import (
    boundary_vertices,
    broken_half_edges,
    corner_fans,
    dilated,
    find_edges,
    is_edge_manifold,
    unmeasured_at,
    with_any,
    with_faces,
)

DOUBLED_DEG = 177.0
"""Angle between the normals of neighbours from which they lie on each other."""
_AROUND = 2
"""Times that each face's normal is added up with those round it; with 3 the ends of a sharp edge at
a rim seem turned, and are not."""
_FLAT = 1e-6
"""Of the usual face's area: what a smaller face looks at is rounding."""
_POINT_DEG = 180.0
"""Sum of the faces' angles at a vertex: 360 on skin, 270 at a box's corner. With less it stands out
of an even ring by 1.7 of its edges or more, as nothing on a limb does."""
_ALONG_RIM = 100.0
"""A vertex on a rim heeds its neighbours on the rim so many times as much as one inside."""
_NEARLY = 1e-3
"""Cosines so near to the limit are computed once more, in the way that decides."""


@dataclass(frozen=True, kw_only=True)
class FoldOptions:
    """What counts as a fold."""

    bent_deg: float = 120.0
    """Angle between the normals of neighbours from which their edge is a fold."""

    foot_cosine: float = -1.0
    """A point is one if the surface round its foot looks as it does, by this cosine on average: at
    a thorn on skin it is 1, at the tip of a cone at most 0.5; -1 takes both."""

    rounds: int = 10
    """Of laying back; each takes a ring more with what is still folded."""


MEASURED = FoldOptions()
"""For a surface that photos measured: no limb has such edges and points."""
ANY_SHAPE = FoldOptions(bent_deg=DOUBLED_DEG, foot_cosine=0.7, rounds=3)
"""For whatever shape: it may be cut at a slant, or end in a tip, and what is still folded after
three rounds may be meant so, as an arm through a body. Of a scanned baby 1,342 vertices went back,
by up to 16 mm, until five rounds had unfolded it."""


@dataclass(frozen=True, kw_only=True)
class Folds:
    """Where a surface is folded."""

    turned: Int64[np.ndarray, " t"]
    """Faces."""
    points: Int64[np.ndarray, " p"]
    """Vertices."""
    bent: Int64[np.ndarray, "b 2"]
    """Pairs of neighbouring faces."""
    crossing: Int64[np.ndarray, "c 2"]
    """Pairs of faces."""

    def __len__(self) -> int:
        return sum(map(len, (self.turned, self.points, self.bent, self.crossing)))

    def first_mm(self, mesh: Mesh) -> Vector3:
        """A vertex of the first of them."""
        return mesh.vertices_mm[int(self.vertices(mesh).argmax())]

    def vertices(self, mesh: Mesh) -> Bool[np.ndarray, " n"]:
        """All vertices that belong to one."""
        folded = np.zeros(len(mesh), np.bool_)
        folded[self.points] = True
        for faces in (self.turned, self.bent.ravel(), self.crossing.ravel()):
            folded[mesh.faces[faces]] = True
        return folded


def find_folds(
    mesh: Mesh, options: FoldOptions = MEASURED, concerned: Bool[np.ndarray, " f"] | None = None
) -> Folds:
    """Where the surface is folded.

    Args:
        concerned: Edges and crossings of these faces alone are looked at; None: all.
    """
    asked = np.ones(len(mesh.faces), np.bool_) if concerned is None else concerned
    return Folds(
        turned=_turned(mesh),
        points=_thorns(mesh, options.foot_cosine),
        bent=find_bent(mesh, asked, options.bent_deg),
        crossing=find_crossings(mesh.vertices_mm, mesh.faces, asked),
    )


def find_points(vertices: Points3, faces: Faces) -> Bool[np.ndarray, " n"]:
    """Vertices at which the surface comes to a point, whatever the form of its triangles."""
    total = np.zeros(len(vertices))
    for k in range(3):
        at = vertices[faces[:, k]]
        ahead = unit(vertices[faces[:, (k + 1) % 3]] - at)
        behind = unit(vertices[faces[:, (k + 2) % 3]] - at)
        cosines = np.clip(np.einsum("ij,ij->i", ahead, behind), -1, 1)
        total += np.bincount(faces[:, k], np.arccos(cosines), len(vertices))
    return (total > 0) & (total < np.radians(_POINT_DEG))


def find_bent(
    mesh: Mesh, concerned: Bool[np.ndarray, " f"], least_deg: float = DOUBLED_DEG
) -> Int64[np.ndarray, "k 2"]:
    """Neighbouring faces whose normals differ by more, one of them concerned."""
    limit = float(np.cos(np.radians(least_deg)))
    normals = mesh.face_normals()
    sides = find_edges(mesh.faces).faces()
    sides = sides[_nearly_bent(normals, sides, concerned, limit + _NEARLY)]
    cosines = np.einsum("ij,ij->i", unit(normals[sides[:, 0]]), unit(normals[sides[:, 1]]))
    return sides[cosines < limit].astype(np.int64)


@njit(cache=True, nogil=True)
def _nearly_bent(normals: np.ndarray, sides: np.ndarray, concerned: np.ndarray, limit: float):
    """Edges with two faces, one of them concerned, that may be bent so far; few are."""
    found = np.zeros(len(sides), np.bool_)
    for e in range(len(sides)):
        one, two = sides[e, 0], sides[e, 1]
        if two < 0 or not (concerned[one] or concerned[two]):
            continue
        both = size_one = size_two = 0.0
        for axis in range(3):
            both += normals[one, axis] * normals[two, axis]
            size_one += normals[one, axis] * normals[one, axis]
            size_two += normals[two, axis] * normals[two, axis]
        found[e] = both <= limit * np.sqrt(size_one * size_two)
    return found


def find_branching(faces: Faces) -> Int64[np.ndarray, " k"]:
    """Faces at edges and vertices where the surface is no manifold; none where it is one."""
    if not is_edge_manifold(faces):
        return np.flatnonzero(broken_half_edges(faces).reshape(-1, 3).any(1))
    corners, fans = faces.ravel(), corner_fans(faces).ravel()
    of_fan = corners[np.unique(fans, return_index=True)[1]]
    several = np.bincount(of_fan, minlength=int(faces.max(initial=-1)) + 1) > 1
    return np.flatnonzero(several[faces].any(1))


@dataclass(frozen=True, kw_only=True)
class Unfolded:
    """A surface after its folds were laid back."""

    mesh: Mesh
    """What was laid back counts as filled in and has no sigma, as any guess."""
    vertices: int
    """That were laid back."""
    farthest_mm: float
    """How far the farthest of them moved."""
    left: Folds
    """Those that could not be laid back."""


def unfolded(mesh: Mesh, options: FoldOptions = MEASURED) -> Unfolded:
    """The surface without folds, and those that are left.

    A face that hangs on by one edge, at a place that is laid back, is taken away.
    """
    before = mesh.vertices_mm
    back = np.zeros(len(mesh), np.bool_)
    folds = find_folds(mesh, options)
    for rings in range(options.rounds):
        if not len(folds):
            break
        back |= dilated(folds.vertices(mesh), mesh.faces, rings)
        ears = _ears(mesh.faces, back)
        while ears.any():
            used = np.bincount(mesh.faces[~ears].ravel(), minlength=len(mesh)) > 0
            mesh = with_faces(mesh, mesh.faces[~ears])
            before, back = before[used], back[used]
            ears = _ears(mesh.faces, back)
        mesh = mesh.with_vertices(_relaxed(mesh, back))
        folds = find_folds(mesh, options, with_any(back, mesh.faces))
    moved_mm = lengths(mesh.vertices_mm - before)
    return Unfolded(
        mesh=unmeasured_at(mesh, back) if back.any() else mesh,
        vertices=int(back.sum()),
        farthest_mm=float(moved_mm.max(initial=0.0)),
        left=find_folds(mesh, options) if back.any() else folds,
    )


def _turned(mesh: Mesh) -> Int64[np.ndarray, " t"]:
    """Faces that look against the sum of the normals round them, near ones counted most.

    Both where each face counts by its area and where each counts alike: by area a large face, as of
    a flat cap, outvotes the fine ones beside it; alike, many fine ones outvote it.
    """
    own = mesh.face_normals()
    by_area, alike = own, unit(own)
    for _ in range(_AROUND):
        by_area = summed(by_area, mesh.faces, len(mesh))[mesh.faces].sum(1)
        alike = unit(summed(alike, mesh.faces, len(mesh)))[mesh.faces].sum(1)
    least = _FLAT * float(np.median(lengths(own))) if len(own) else 0.0
    against = (dots(own, unit(way)) < -least for way in (by_area, alike))
    return np.flatnonzero(np.logical_and(*against))


def _thorns(mesh: Mesh, foot_cosine: float) -> Int64[np.ndarray, " p"]:
    """Points inside the surface round whose foot it looks as they do."""
    points = np.flatnonzero(
        find_points(mesh.vertices_mm, mesh.faces) & ~boundary_vertices(mesh.faces, len(mesh))
    )
    if not len(points):
        return points
    corners = (mesh.faces.ravel(), np.repeat(np.arange(len(mesh.faces)), 3))
    shape = (len(mesh), len(mesh.faces))
    has = sparse.csr_array((np.ones(3 * len(mesh.faces)), corners), shape=shape)
    own = sparse.csr_array(has[points])
    near = sparse.csr_array(sparse.csr_array(own @ has.T) @ has)
    row, face = near.nonzero()
    beyond = np.asarray(own[row, face]).ravel() == 0
    row, face = row[beyond], face[beyond]
    cosines = dots(mesh.vertex_normals()[points[row]], unit(mesh.face_normals())[face])
    count = np.bincount(row, minlength=len(points))
    mean = np.bincount(row, cosines, len(points)) / np.maximum(count, 1)
    return points[mean >= foot_cosine]


def _ears(faces: Faces, chosen: Bool[np.ndarray, " n"]) -> Bool[np.ndarray, " f"]:
    """Faces with a chosen corner that hang on by one edge or less."""
    edges = find_edges(faces)
    open_sides = (edges.uses[edges.of_half_edge] == 1).reshape(-1, 3).sum(1)
    return (open_sides >= 2) & with_any(chosen, faces)


def _relaxed(mesh: Mesh, back: Bool[np.ndarray, " n"]) -> Points3:
    """The vertices where each of those laid back is the mean of its neighbours."""
    edges = find_edges(mesh.faces)
    beside = back[edges.ends].any(1)
    ends, at_rim = edges.ends[beside], edges.uses[beside] == 1
    on_rim = boundary_vertices(mesh.faces, len(mesh))
    tails, heads = np.concatenate([ends, ends[:, ::-1]]).T
    weight = np.where(np.tile(at_rim, 2) & on_rim[tails], _ALONG_RIM, 1.0)
    size = (len(mesh), len(mesh))
    rows = sparse.csr_array((weight, (tails, heads)), shape=size)[back]
    inside, held = sparse.csr_array(rows[:, back]), sparse.csr_array(rows[:, ~back])
    group = csgraph.connected_components(inside, directed=False)[1]
    anchored = np.bincount(group, np.asarray(held.sum(1)).ravel()) > 0
    solved = anchored[group]
    vertices = mesh.vertices_mm.copy()
    if not solved.any():
        return vertices
    total = np.asarray(rows.sum(1)).ravel()
    system = sparse.diags_array(total) - inside
    right = held @ vertices[~back]
    moved = np.flatnonzero(back)[solved]
    matrix = sparse.csc_array(sparse.csr_array(system)[solved][:, solved])
    vertices[moved] = splu(matrix).solve(right[solved])
    return vertices
