"""Folds: defects that no skin has and that slicers and carvers take literally, found and removed.

Flipped   faces whose normals oppose those of the surface round them.
Spikes    vertices, not on a rim, at which the surface comes to a point.
Bent      neighbouring faces at too sharp an edge.
Crossing  faces that pass through each other.
Method    Every vertex of a fold becomes the mean of its neighbours, in one linear system (Tutte's
          embedding, 1963, which does not fold inside a convex rim). While folds remain, one more
          ring of vertices is included.
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
    faces_touching,
    find_edges,
    is_edge_manifold,
    unmeasured_at,
    with_faces,
)

DOUBLED_DEG = 177.0
"""Angle between the normals of neighbours from which they count as lying on each other."""
_AVERAGINGS = 2
"""Rounds in which each face's normal is summed with its neighbours'; with 3 the ends of a sharp
edge at a rim would count as flipped."""
_SLIVER = 1e-6
"""Of the median face's area: the normal of a smaller face is rounding."""
_SPIKE_DEG = 180.0
"""Sum of the faces' angles at a vertex: 360 on skin, 270 at a box's corner. With less the vertex
stands out of an even ring by 1.7 edge lengths or more, as nothing on a limb does."""
_RIM_WEIGHT = 100.0
"""Weight of a rim vertex's neighbours on the rim, against 1 of those inside."""
_SCREENING = 1e-3
"""Margin of the fast test on cosines, whose hits are tested exactly."""


@dataclass(frozen=True, kw_only=True)
class FoldOptions:
    """What counts as a fold."""

    bent_deg: float = 120.0
    """Angle between the normals of neighbours from which their edge is a fold."""

    foot_cosine: float = -1.0
    """Least mean cosine between a spike's normal and the normals round its foot: 1 at a thorn on
    skin, at most 0.5 at the tip of a cone; -1 accepts both."""

    rounds: int = 10
    """Of removal; each includes one more ring round what is still folded."""


MEASURED = FoldOptions()
"""For a surface measured in photos: no limb has such edges and spikes."""
ANY_SHAPE = FoldOptions(bent_deg=DOUBLED_DEG, foot_cosine=0.7, rounds=3)
"""For any shape: it may be cut at a slant or end in a tip, and what is still folded after three
rounds may be intended, as an arm through a body. Five rounds moved 1,342 vertices of a scanned baby
by up to 16 mm."""


@dataclass(frozen=True, kw_only=True)
class Folds:
    """Where a surface is folded."""

    flipped: Int64[np.ndarray, " f"]
    """Faces."""
    spikes: Int64[np.ndarray, " s"]
    """Vertices."""
    bent: Int64[np.ndarray, "b 2"]
    """Pairs of neighbouring faces."""
    crossing: Int64[np.ndarray, "c 2"]
    """Pairs of faces."""

    def __len__(self) -> int:
        return sum(map(len, (self.flipped, self.spikes, self.bent, self.crossing)))

    def first_mm(self, mesh: Mesh) -> Vector3:
        """A vertex of a fold, to show people where to look."""
        return mesh.vertices_mm[int(self.vertices(mesh).argmax())]

    def vertices(self, mesh: Mesh) -> Bool[np.ndarray, " n"]:
        """All vertices that belong to a fold."""
        folded = np.zeros(len(mesh), np.bool_)
        folded[self.spikes] = True
        for faces in (self.flipped, self.bent.ravel(), self.crossing.ravel()):
            folded[mesh.faces[faces]] = True
        return folded


def find_folds(
    mesh: Mesh, options: FoldOptions = MEASURED, concerned: Bool[np.ndarray, " f"] | None = None
) -> Folds:
    """Where the surface is folded.

    Args:
        concerned: Faces whose edges and crossings are checked; None: all.
    """
    asked = np.ones(len(mesh.faces), np.bool_) if concerned is None else concerned
    return Folds(
        flipped=_flipped(mesh),
        spikes=_interior_spikes(mesh, options.foot_cosine),
        bent=find_bent(mesh, asked, options.bent_deg),
        crossing=find_crossings(mesh.vertices_mm, mesh.faces, asked),
    )


def find_spikes(vertices: Points3, faces: Faces) -> Bool[np.ndarray, " n"]:
    """Vertices whose faces' angles sum to less than `_SPIKE_DEG`."""
    total_rad = np.zeros(len(vertices))
    for k in range(3):
        at = vertices[faces[:, k]]
        to_next = unit(vertices[faces[:, (k + 1) % 3]] - at)
        to_last = unit(vertices[faces[:, (k + 2) % 3]] - at)
        cosines = np.clip(np.einsum("ij,ij->i", to_next, to_last), -1, 1)
        total_rad += np.bincount(faces[:, k], np.arccos(cosines), len(vertices))
    return (total_rad > 0) & (total_rad < np.radians(_SPIKE_DEG))


def find_bent(
    mesh: Mesh, concerned: Bool[np.ndarray, " f"], least_deg: float = DOUBLED_DEG
) -> Int64[np.ndarray, "k 2"]:
    """Pairs of neighbouring faces, one of them concerned, whose normals differ by more."""
    limit = float(np.cos(np.radians(least_deg)))
    normals = mesh.face_normals()
    sides = find_edges(mesh.faces).faces()
    sides = sides[_nearly_bent(normals, sides, concerned, limit + _SCREENING)]
    cosines = np.einsum("ij,ij->i", unit(normals[sides[:, 0]]), unit(normals[sides[:, 1]]))
    return sides[cosines < limit].astype(np.int64)


@njit(cache=True, nogil=True)
def _nearly_bent(normals: np.ndarray, sides: np.ndarray, concerned: np.ndarray, limit: float):
    """Fast test: edges of two faces, one of them concerned, that may be bent beyond the limit."""
    found = np.zeros(len(sides), np.bool_)
    for e in range(len(sides)):
        one, two = sides[e, 0], sides[e, 1]
        if two < 0 or not (concerned[one] or concerned[two]):
            continue
        dot = square_one = square_two = 0.0
        for axis in range(3):
            dot += normals[one, axis] * normals[two, axis]
            square_one += normals[one, axis] * normals[one, axis]
            square_two += normals[two, axis] * normals[two, axis]
        found[e] = dot <= limit * np.sqrt(square_one * square_two)
    return found


def find_branching(faces: Faces) -> Int64[np.ndarray, " k"]:
    """Faces at non-manifold edges or, if all edges are manifold, at non-manifold vertices."""
    if not is_edge_manifold(faces):
        return np.flatnonzero(broken_half_edges(faces).reshape(-1, 3).any(1))
    corners, fans = faces.ravel(), corner_fans(faces).ravel()
    of_fan = corners[np.unique(fans, return_index=True)[1]]
    several = np.bincount(of_fan, minlength=int(faces.max(initial=-1)) + 1) > 1
    return np.flatnonzero(several[faces].any(1))


@dataclass(frozen=True, kw_only=True)
class Unfolded:
    """A surface after the removal of its folds."""

    mesh: Mesh
    """The vertices that moved are marked as filled and have no sigma."""
    vertices: int
    """How many moved."""
    farthest_mm: float
    """The largest distance by which one moved."""
    left: Folds
    """Those that remain."""


def unfolded(mesh: Mesh, options: FoldOptions = MEASURED) -> Unfolded:
    """The surface with its folds removed.

    A face at a moved vertex that hangs on by one edge is deleted.
    """
    before = mesh.vertices_mm
    moved = np.zeros(len(mesh), np.bool_)
    folds = find_folds(mesh, options)
    for rings in range(options.rounds):
        if not len(folds):
            break
        moved |= dilated(folds.vertices(mesh), mesh.faces, rings)
        ears = _ears(mesh.faces, moved)
        while ears.any():
            used = np.bincount(mesh.faces[~ears].ravel(), minlength=len(mesh)) > 0
            mesh = with_faces(mesh, mesh.faces[~ears])
            before, moved = before[used], moved[used]
            ears = _ears(mesh.faces, moved)
        mesh = mesh.with_vertices(_relaxed(mesh, moved))
        folds = find_folds(mesh, options, faces_touching(moved, mesh.faces))
    distances_mm = lengths(mesh.vertices_mm - before)
    return Unfolded(
        mesh=unmeasured_at(mesh, moved) if moved.any() else mesh,
        vertices=int(moved.sum()),
        farthest_mm=float(distances_mm.max(initial=0.0)),
        left=find_folds(mesh, options) if moved.any() else folds,
    )


def _flipped(mesh: Mesh) -> Int64[np.ndarray, " f"]:
    """Faces opposed to the averaged normals round them, by area and unweighted alike.

    Weighted by area, a large face, as of a flat cap, outvotes the fine ones beside it; unweighted,
    many fine ones outvote it.
    """
    normals = mesh.face_normals()
    by_area, unweighted = normals, unit(normals)
    for _ in range(_AVERAGINGS):
        by_area = summed(by_area, mesh.faces, len(mesh))[mesh.faces].sum(1)
        unweighted = unit(summed(unweighted, mesh.faces, len(mesh)))[mesh.faces].sum(1)
    least = _SLIVER * float(np.median(lengths(normals))) if len(normals) else 0.0
    opposed = (dots(normals, unit(mean)) < -least for mean in (by_area, unweighted))
    return np.flatnonzero(np.logical_and(*opposed))


def _interior_spikes(mesh: Mesh, foot_cosine: float) -> Int64[np.ndarray, " s"]:
    """Spikes not on a rim whose normal agrees with those of the second ring of faces."""
    spikes = np.flatnonzero(
        find_spikes(mesh.vertices_mm, mesh.faces) & ~boundary_vertices(mesh.faces, len(mesh))
    )
    if not len(spikes):
        return spikes
    corners = (mesh.faces.ravel(), np.repeat(np.arange(len(mesh.faces)), 3))
    shape = (len(mesh), len(mesh.faces))
    incidence = sparse.csr_array((np.ones(3 * len(mesh.faces)), corners), shape=shape)
    first_ring = sparse.csr_array(incidence[spikes])
    rings = sparse.csr_array(sparse.csr_array(first_ring @ incidence.T) @ incidence)
    row, face = rings.nonzero()
    second = np.asarray(first_ring[row, face]).ravel() == 0
    row, face = row[second], face[second]
    cosines = dots(mesh.vertex_normals()[spikes[row]], unit(mesh.face_normals())[face])
    count = np.bincount(row, minlength=len(spikes))
    mean = np.bincount(row, cosines, len(spikes)) / np.maximum(count, 1)
    return spikes[mean >= foot_cosine]


def _ears(faces: Faces, chosen: Bool[np.ndarray, " n"]) -> Bool[np.ndarray, " f"]:
    """Faces with a chosen corner that hang on by one edge or less."""
    edges = find_edges(faces)
    open_sides = (edges.uses[edges.of_half_edge] == 1).reshape(-1, 3).sum(1)
    return (open_sides >= 2) & faces_touching(chosen, faces)


def _relaxed(mesh: Mesh, free: Bool[np.ndarray, " n"]) -> Points3:
    """The vertices, each free one the weighted mean of its neighbours.

    Free vertices that no held one anchors stay.
    """
    edges = find_edges(mesh.faces)
    touched = free[edges.ends].any(1)
    ends, at_rim = edges.ends[touched], edges.uses[touched] == 1
    on_rim = boundary_vertices(mesh.faces, len(mesh))
    tails, heads = np.concatenate([ends, ends[:, ::-1]]).T
    weight = np.where(np.tile(at_rim, 2) & on_rim[tails], _RIM_WEIGHT, 1.0)
    size = (len(mesh), len(mesh))
    rows = sparse.csr_array((weight, (tails, heads)), shape=size)[free]
    to_free, to_held = sparse.csr_array(rows[:, free]), sparse.csr_array(rows[:, ~free])
    group = csgraph.connected_components(to_free, directed=False)[1]
    anchored = np.bincount(group, np.asarray(to_held.sum(1)).ravel()) > 0
    solved = anchored[group]
    vertices = mesh.vertices_mm.copy()
    if not solved.any():
        return vertices
    total = np.asarray(rows.sum(1)).ravel()
    system = sparse.diags_array(total) - to_free
    right = to_held @ vertices[~free]
    moved = np.flatnonzero(free)[solved]
    matrix = sparse.csc_array(sparse.csr_array(system)[solved][:, solved])
    vertices[moved] = splu(matrix).solve(right[solved])
    return vertices
