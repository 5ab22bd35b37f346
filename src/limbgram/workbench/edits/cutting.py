"""Cuts: along a plane across the limb's axis, or along a trimline on the surface.

In      a Limb and the plane, or the points of the trimline.
Out     the part that is kept; its triangles are split along the cut, so the new edge lies in it.
Method  triangles are cut where a value that is given at the vertices passes zero. A flat opening is
        capped by ear clipping, after its holes were bridged to the outline (Eberly 2002).
Fails   EditError: the cut misses the shape, or cannot be capped.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Faces, Points2
from limbgram.core.geometry.frames import axes_across
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.sections import contains_point
from limbgram.core.mesh.topology import boundary_loops, find_edges, with_faces
from limbgram.reconstruction.surface.holes import loop_area
from limbgram.reconstruction.surface.remeshing import WorkingMesh, remesh_once
from limbgram.workbench.edits.refinement import split_edges
from limbgram.workbench.edits.regions import (
    with_surface_added,
)

_REMESH_ROUNDS = 6
ON_CUT_MM = 1e-3
"""A vertex this near counts as on the cut; thinner triangles would be lost in a file."""
Part = Literal["distal", "proximal"]


@dataclass(frozen=True)
class Cut:
    """The part of a mesh that a cut leaves."""

    mesh: Mesh
    on_cut: Bool[np.ndarray, " n"]
    """Vertices that lie on the cut."""


def keep_positive(mesh: Mesh, values_mm: Float64[np.ndarray, " n"]) -> Cut:
    """The part of a mesh where the value is above zero; faces across it are split.

    Values are distances from the cut; along an edge they are taken as straight.
    """
    values = np.where(np.abs(values_mm) <= ON_CUT_MM, 0.0, values_mm)
    sign = np.sign(values)
    edges = find_edges(mesh.faces)
    ends = edges.ends
    crossed = sign[ends[:, 0]] * sign[ends[:, 1]] < 0
    below, above = values[ends[:, 0]], values[ends[:, 1]]
    shares = np.where(crossed, below / np.where(crossed, below - above, 1.0), 0.5)
    division = split_edges(mesh, edges, crossed, shares)
    signs = np.concatenate([sign, np.zeros(int(crossed.sum()))])
    kept = division.mesh.faces[signs[division.mesh.faces].max(1, initial=-1.0) > 0]
    used = np.unique(kept)
    return Cut(with_faces(division.mesh, kept), signs[used] == 0)


def cap(mesh: Mesh, on_cut: Bool[np.ndarray, " n"]) -> Mesh:
    """Close the openings whose vertices all lie on the cut; inner loops become holes of the cap.

    Raises:
        EditError: the cut runs into the open brim, so it bounds no flat opening.
    """
    loops = boundary_loops(mesh.faces)
    flat = [loop.astype(np.int64) for loop in loops if on_cut[loop].all()]
    if any(on_cut[loop].sum() > 1 and not on_cut[loop].all() for loop in loops) or not flat:
        raise EditError("edit.cap.brim")
    # A cap's faces run against the loops, so its outward side looks away from what was kept.
    rings = [loop[::-1] for loop in flat]
    areas = np.stack([loop_area(mesh.vertices_mm[ring]) for ring in rings])
    normal = areas.sum(0) / np.linalg.norm(areas.sum(0))
    plane = axes_across(normal)
    drawn = [np.einsum("nj,kj->nk", mesh.vertices_mm[ring], plane) for ring in rings]
    outer = (areas * normal).sum(1) > 0
    faces: list[np.ndarray] = []
    for number in np.flatnonzero(outer):
        holes = [
            k for k in np.flatnonzero(~outer).tolist() if _enclosing_ring(drawn, outer, k) == number
        ]
        path = _bridged_path(drawn, int(number), holes)
        ring = np.concatenate(rings)[path]
        corners = np.concatenate(drawn)[path]
        cut = np.empty((len(path) - 2, 3), np.int64)
        if _clip_ears(corners, cut) != len(cut):
            raise EditError("edit.cap.crosses")
        faces.append(ring[cut])
    return _with_even_cap(mesh, np.concatenate(faces).astype(np.int32), normal)


def _enclosing_ring(drawn: list[Points2], outer: Bool[np.ndarray, " k"], hole: int) -> int:
    """The smallest outer ring round a hole."""
    around = [
        int(k) for k in np.flatnonzero(outer) if contains_point(drawn[int(k)], drawn[hole][0])
    ]
    return min(around, key=lambda k: abs(_signed_area(drawn[k])), default=-1)


def _signed_area(ring: Points2) -> float:
    ahead = np.roll(ring, -1, axis=0)
    return float((ring[:, 0] * ahead[:, 1] - ring[:, 1] * ahead[:, 0]).sum()) / 2


def _bridged_path(drawn: list[Points2], ring: int, holes: list[int]) -> Int64[np.ndarray, " k"]:
    """One path round a ring and its holes, with a bridge to each hole and back (Eberly 2002).

    Holes are joined in order of their rightmost point, each to the nearest point of the path
    that it can see to its right.
    """
    first = np.cumsum([0, *(len(points) for points in drawn)])
    places = np.concatenate(drawn)
    path = np.arange(first[ring], first[ring + 1])
    for hole in sorted(holes, key=lambda k: -float(drawn[k][:, 0].max())):
        own = np.arange(first[hole], first[hole + 1])
        start = int(np.argmax(places[own, 0]))
        own = np.roll(own, -start)
        bridge = _visible_corner(places[path], places[own[0]])
        path = np.concatenate([path[: bridge + 1], own, own[:1], path[bridge:]])
    return path


def _visible_corner(path: Points2, point: Float64[np.ndarray, "2"]) -> int:
    """The nearest corner of the path that is visible from a point inside it."""
    order = np.argsort(np.linalg.norm(path - point, axis=1), kind="stable")
    ahead = np.roll(path, -1, axis=0)
    for k in order:
        if _is_unobstructed(point, path[k], path, ahead) and _is_in_corner(path, int(k), point):
            return int(k)
    return int(order[0])


def _is_unobstructed(
    start: Float64[np.ndarray, "2"], end: Float64[np.ndarray, "2"], one: Points2, two: Points2
) -> bool:
    """Whether no segment of a path crosses the line between two points."""
    way = end - start
    left_one = way[0] * (one[:, 1] - start[1]) - way[1] * (one[:, 0] - start[0])
    left_two = way[0] * (two[:, 1] - start[1]) - way[1] * (two[:, 0] - start[0])
    piece = two - one
    of_start = piece[:, 0] * (start[1] - one[:, 1]) - piece[:, 1] * (start[0] - one[:, 0])
    of_end = piece[:, 0] * (end[1] - one[:, 1]) - piece[:, 1] * (end[0] - one[:, 0])
    return not ((left_one * left_two < 0) & (of_start * of_end < 0)).any()


def _is_in_corner(path: Points2, corner: int, point: Float64[np.ndarray, "2"]) -> bool:
    """Whether a point lies within the inner angle at a corner of the path."""
    here = path[corner]
    back, ahead = path[corner - 1] - here, path[(corner + 1) % len(path)] - here
    to = point - here
    turn = np.arctan2(ahead[0] * back[1] - ahead[1] * back[0], ahead @ back) % (2 * np.pi)
    at = np.arctan2(ahead[0] * to[1] - ahead[1] * to[0], ahead @ to) % (2 * np.pi)
    return bool(0 < at < turn)


@njit(cache=True, nogil=True)
def _clip_ears(ring: np.ndarray, faces: np.ndarray):
    """Triangulate a simple polygon, clipping the roundest ear first; returns the face count."""
    n = ring.shape[0]
    before, after = np.arange(n) - 1, np.arange(n) + 1
    before[0], after[n - 1] = n - 1, 0
    worth = np.empty(n)
    for k in range(n):
        worth[k] = _ear_quality(ring, before, after, k)
    made = 0
    while made < n - 2:
        best = -1
        for k in range(n):
            if worth[k] > 0 and (best < 0 or worth[k] > worth[best]):
                best = k
        if best < 0:
            return made
        a, c = before[best], after[best]
        faces[made, 0], faces[made, 1], faces[made, 2] = a, best, c
        made += 1
        after[a], before[c] = c, a
        worth[best] = -1.0
        worth[a] = _ear_quality(ring, before, after, a)
        worth[c] = _ear_quality(ring, before, after, c)
        # A corner that was blocked by the one just cut off may be free now.
        k = after[c]
        while k != a and made < n - 2:
            if worth[k] == 0.0:
                worth[k] = _ear_quality(ring, before, after, k)
            k = after[k]
    return made


@njit(cache=True, nogil=True)
def _ear_quality(ring: np.ndarray, before: np.ndarray, after: np.ndarray, k: int):
    """Roundness of the ear at a corner; -1 if it is reflex, 0 if another corner lies in it."""
    a, c = before[k], after[k]
    ux, uy = ring[k, 0] - ring[a, 0], ring[k, 1] - ring[a, 1]
    vx, vy = ring[c, 0] - ring[k, 0], ring[c, 1] - ring[k, 1]
    double = ux * vy - uy * vx
    if double <= 0:
        return -1.0
    other = after[c]
    while other != a:
        px, py = ring[other, 0], ring[other, 1]
        same = (
            (px == ring[a, 0] and py == ring[a, 1])
            or (px == ring[k, 0] and py == ring[k, 1])
            or (px == ring[c, 0] and py == ring[c, 1])
        )
        if not same:
            one = ux * (py - ring[a, 1]) - uy * (px - ring[a, 0])
            two = vx * (py - ring[k, 1]) - vy * (px - ring[k, 0])
            wx, wy = ring[a, 0] - ring[c, 0], ring[a, 1] - ring[c, 1]
            three = wx * (py - ring[c, 1]) - wy * (px - ring[c, 0])
            if one >= 0 and two >= 0 and three >= 0:
                return 0.0
        other = after[other]
    wx, wy = ring[a, 0] - ring[c, 0], ring[a, 1] - ring[c, 1]
    return double / (ux * ux + uy * uy + vx * vx + vy * vy + wx * wx + wy * wy)


def _with_even_cap(mesh: Mesh, faces: Faces, normal: Float64[np.ndarray, "3"]) -> Mesh:
    """The mesh with a cap of near-equilateral triangles, about as fine as its rim.

    The faces along the rim take part frozen, so that its edges stay whole. Remeshing a jagged rim
    may flip a triangle over, and not back: the last round counts in which none is flipped, and if
    there is none, the cap as it was cut.
    """
    rim = np.zeros(len(mesh), np.bool_)
    rim[faces] = True
    along = mesh.faces[rim[mesh.faces].any(1)]
    together = np.concatenate([along, faces])
    used, compact = np.unique(together, return_inverse=True)
    frozen = np.arange(len(together)) < len(along)
    compact = compact.reshape(-1, 3).astype(np.int32)
    work = WorkingMesh(mesh.vertices_mm[used], compact, frozen, used.astype(np.int64))
    corners = mesh.vertices_mm[along]
    lengths = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    edge = float(np.median(lengths.max(1)))
    tried = work
    for _ in range(_REMESH_ROUNDS):
        tried = remesh_once(tried, edge)
        if _all_face(tried, normal):
            work = tried
    kept = np.zeros(len(work.vertices), np.bool_)
    kept[work.faces[work.frozen]] = True
    number = np.where(kept, work.origin, len(mesh) + np.cumsum(~kept) - 1)
    new = number[work.faces[~work.frozen]].astype(np.int32)
    return with_surface_added(mesh, work.vertices[~kept], work.origin[~kept], new)


def _all_face(work: WorkingMesh, normal: Float64[np.ndarray, "3"]) -> bool:
    """Whether all faces that are not frozen face along a normal."""
    a, b, c = np.moveaxis(work.vertices[work.faces[~work.frozen]], 1, 0)
    return bool((np.cross(b - a, c - a) @ normal > 0).all())
