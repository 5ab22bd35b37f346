"""Regions: the places and curves where edits work, and the distances of vertices from them.

In      places: the name of a landmark, or three coordinates in millimetres in the frame that the
        edit names: "limb" (origin distal, +Z proximal, +Y anterior, +X right) or "mesh".
Out     points on the surface, closed curves through them, distances over the surface, the middles
        of sections, and meshes with added surface (it counts as filled).
Method  A curve is a periodic cubic spline through the points, brought to the surface. Distances:
        fronts pass from triangle to triangle, circular ones from a point (Novotni and Klein 2002:
        the source is unfolded into each triangle's plane), straight ones from a curve (Kimmel and
        Sethian 1998), until nothing changes. They are exact on what can be unrolled.
Fails   EditError: an unknown place, too few points, or a curve that jumps or meets itself.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float64, Int32, Int64
from scipy.sparse import csr_array
from scipy.spatial import KDTree

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Faces, Points3, Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.polyline import distances_along
from limbgram.core.interval import rms
from limbgram.core.kernels import njit
from limbgram.core.known_words import likeliest
from limbgram.core.mesh.closest_point import Closest
from limbgram.core.mesh.mesh import Mesh, dots, unit
from limbgram.core.mesh.sections import area_and_centroid, cut
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    components,
    corners_by_vertex,
    edge_lengths,
    find_edges,
)
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.reconstruction.surface.holes import fill_holes
from limbgram.workbench.anatomy.names import landmark_named
from limbgram.workbench.edits.refinement import refine_selected
from limbgram.workbench.limb import AlignedLimb, Limb

Place = str | tuple[float, float, float]
"""The name of a landmark, or x, y, z in millimetres."""
FrameName = Literal["limb", "mesh"]
_FARTHEST_MM = 10.0
"""A place further from the surface than this is a mistake."""
_LEAST_POINTS = 3
"""Fewest points of a closed curve."""
_SECTION_COUNT = 48
_LEAST_AREA_SHARE = 0.5
"""Sections with less than this share of the largest area are left out."""
_STEP_MM = 0.5
_LEAST_STEPS = 120
_MOST_STRETCH = 4.0
"""Factor by which steps of a curve may grow when it is projected onto the surface."""
_FARTHEST_SHARE = 0.25
"""Share of a curve's extent by which its spline may leave the surface."""
_MOST_ROUNDS = 5000
_NORMAL_STEPS = 3
_CONVERGED_MM = 1e-9
_LEAST_EDGE_SHARE = 0.1
"""Shorter edges count as this share of the median, so that they do not dominate weights."""


@dataclass(frozen=True)
class Curve:
    """A closed polyline on the surface; the first point is not repeated."""

    points_mm: Points3
    normals: Points3
    """Normals of the surface, smoothed over a few steps."""

    @classmethod
    def on(cls, mesh: Mesh, places: Closest, normal_steps: int) -> "Curve":
        """Through places on a mesh; normals are averaged over so many points to either side."""
        normals = mesh.vertex_normals()[mesh.faces[places.faces]].mean(1)
        total = np.zeros_like(normals)
        for shift in range(-normal_steps, normal_steps + 1):
            total += np.roll(normals, shift, axis=0)
        return cls(places.points_mm, unit(total))

    @property
    def length_mm(self) -> float:
        ahead = np.roll(self.points_mm, -1, axis=0) - self.points_mm
        return float(np.linalg.norm(ahead, axis=1).sum())


@dataclass(frozen=True)
class Sides:
    """The side of a curve on which each vertex lies, and its distance near the curve."""

    left: Bool[np.ndarray, " n"]
    """To the left of somebody who walks along the curve on the outside of the surface."""
    signed_mm: Float64[np.ndarray, " n"]
    """Distance to the curve of the vertices near it, positive to the left; infinite elsewhere."""


def require_aligned(limb: Limb) -> AlignedLimb:
    """The limb with its axes.

    Raises:
        EditError: the limb has not been aligned.
    """
    return limb.aligned(EditError("edit.not_aligned"))


def moved_by(motion: Rigid, points: Points3) -> Points3:
    """Points after a motion, with the same rounding for any number of threads."""
    return np.einsum("nj,ij->ni", points, motion.rotation) + motion.translation


def points_in_limb_frame(limb: Limb) -> Points3:
    """The mesh's vertices in the limb frame."""
    return moved_by(require_aligned(limb).limb_from_mesh, limb.mesh.vertices_mm)


def upright_mm(limb: Limb) -> Points3:
    """The mesh's vertices in the limb frame; in the file's where the limb is not aligned."""
    motion = limb.known_limb_from_mesh
    return limb.mesh.vertices_mm if motion is None else moved_by(motion, limb.mesh.vertices_mm)


def axes_in_mesh(limb: Limb) -> Float64[np.ndarray, "3 3"]:
    """Rows: directions of the limb's X, Y and Z in the mesh's frame."""
    return require_aligned(limb).limb_from_mesh.rotation


def position_mm(limb: Limb, place: Place, frame: FrameName) -> Vector3:
    """A place in the mesh's frame.

    Raises:
        EditError: there is no landmark of the name, or no frame for the coordinates.
    """
    if isinstance(place, str):
        mark = landmark_named(place, limb.landmarks)
        if mark is not None:
            return mark.position_mm
        names = tuple(mark.name for mark in limb.landmarks)
        raise EditError(
            "edit.landmark.none",
            name=place,
            names=names or None,
            meant=likeliest(place, names),
        )
    point = np.array(place, np.float64)
    if frame == "mesh":
        return point
    return moved_by(require_aligned(limb).limb_from_mesh.inverse, point[None])[0]


def require_ring(places: Sequence[Place]) -> None:
    """Refuse places that make no closed curve.

    Raises:
        EditError: fewer than three, or one of them twice in a row.
    """
    if len(places) < _LEAST_POINTS:
        raise EditError("edit.ring.few", least=_LEAST_POINTS)
    if any(one == other for one, other in pairwise((*places, places[0]))):
        raise EditError("edit.ring.twice")


def on_surface(limb: Limb, points_mm: Points3) -> Points3:
    """Points in the mesh's frame moved to the nearest places on the surface.

    Raises:
        EditError: a point is so far off that it cannot be meant to lie on the surface.
    """
    closest = tree_on(limb.mesh).closest(points_mm)
    worst = int(np.argmax(closest.distances_mm))
    if closest.distances_mm[worst] > _FARTHEST_MM:
        raise EditError(
            "edit.point.off_surface",
            point_mm=tuple(points_mm[worst].tolist()),
            off_mm=float(closest.distances_mm[worst]),
        )
    return closest.points_mm


def height_mm(limb: Limb, height: float, above: str) -> float:
    """A height along the limb's axis: above its origin, or above a landmark if one is named."""
    if not above:
        return height
    point = position_mm(limb, above, "mesh")
    base = moved_by(require_aligned(limb).limb_from_mesh, point[None])[0, 2]
    return float(base) + height


def displaced(limb: Limb, vertices_mm: Points3) -> Limb:
    """The limb with moved vertices; landmarks on its surface move with it."""
    old = limb.mesh
    new = old.with_vertices(vertices_mm)
    if not limb.landmarks:
        return replace(limb, mesh=new)
    points = np.stack([mark.position_mm for mark in limb.landmarks])
    closest = tree_on(old).closest(points)
    shares = barycentric_weights(old.vertices_mm[old.faces[closest.faces]], closest.points_mm)
    moves = (vertices_mm - old.vertices_mm)[old.faces[closest.faces]]
    near = closest.distances_mm <= _FARTHEST_MM
    shifts = (shares[:, :, None] * moves).sum(1) * near[:, None]
    marks = tuple(
        replace(mark, position_mm=mark.position_mm + shift)
        for mark, shift in zip(limb.landmarks, shifts, strict=True)
    )
    return replace(limb, mesh=new, landmarks=marks)


def section_centres_mm(limb: Limb, points: Points3) -> Points3:
    """The centre of the section at the height of each point; all in the limb frame.

    The centre line follows the centroids of closed sections, smoothed; where sections are
    open (at a slanting brim) or shrink (at the distal end), it continues along the axis.
    """
    vertices = points_in_limb_frame(limb)
    mesh = limb.mesh.with_vertices(vertices)
    low, high = float(vertices[:, 2].min()), float(vertices[:, 2].max())
    heights = low + (high - low) * (np.arange(_SECTION_COUNT) + 0.5) / _SECTION_COUNT
    rows: list[tuple[float, float, float, float]] = []
    for section in cut(mesh, heights.tolist()):
        if section.closed:
            area, x, y = area_and_centroid(section.points_mm)
            rows.append((section.offset_mm, area, x, y))
    table = np.array(rows).reshape(-1, 4)
    largest = table[:, 1].max(initial=0.0)
    table = table[table[:, 1] > _LEAST_AREA_SHARE * largest]
    if not len(table):
        return np.array([0.0, 0.0, 1.0]) * points
    table = _largest_section_rows(table)
    line = np.stack([_moving_average(table[:, 2]), _moving_average(table[:, 3])], axis=1)
    x = np.interp(points[:, 2], table[:, 0], line[:, 0])
    y = np.interp(points[:, 2], table[:, 0], line[:, 1])
    return np.stack([x, y, points[:, 2]], axis=1)


def draw_curve(mesh: Mesh, picked_mm: Points3) -> Curve:
    """The smooth closed curve on the surface through picked points.

    Raises:
        EditError: fewer than three points, or points so far apart that the line would jump.
    """
    from scipy.interpolate import CubicSpline  # a tenth of a second, for curves alone

    if len(picked_mm) < _LEAST_POINTS:
        raise EditError("edit.ring.few", least=_LEAST_POINTS)
    ring = np.concatenate([picked_mm, picked_mm[:1]])
    gaps = np.linalg.norm(np.diff(ring, axis=0), axis=1)
    if gaps.min() < 1e-6:
        raise EditError("edit.ring.twice")
    # Centripetal spacing keeps the spline from looping where points lie unevenly.
    knots = np.concatenate([[0.0], np.cumsum(np.sqrt(gaps))])
    spline = CubicSpline(knots, ring, bc_type="periodic")
    steps = max(_LEAST_STEPS, int(np.ceil(gaps.sum() / _STEP_MM)))
    at = np.linspace(0.0, knots[-1], 4 * steps + 1)
    fine = spline(at)
    walked = distances_along(fine)
    even = np.interp(np.linspace(0.0, walked[-1], steps + 1)[:-1], walked, at)
    tree = tree_on(mesh)
    drawn = np.asarray(spline(even))
    closest = tree.closest(drawn)
    reach = _FARTHEST_SHARE * float(np.linalg.norm(np.ptp(picked_mm, axis=0)))
    jumps = np.linalg.norm(np.roll(closest.points_mm, -1, axis=0) - closest.points_mm, axis=1)
    step = walked[-1] / steps
    if closest.distances_mm.max() > reach or jumps.max() > _MOST_STRETCH * step:
        worst = (
            int(np.argmax(jumps))
            if jumps.max() > _MOST_STRETCH * step
            else int(np.argmax(closest.distances_mm))
        )
        segment = int(np.searchsorted(knots, even[worst], side="right"))
        raise EditError("edit.curve.leaves", first=segment, second=segment % len(picked_mm) + 1)
    return Curve.on(mesh, closest, _NORMAL_STEPS)


def find_sides(mesh: Mesh, curves: Sequence[Curve]) -> Sides:
    """The two sides of a curve; for a wall, which is cut through, those of two curves.

    Raises:
        EditError: a curve crosses itself or comes too near to itself, or there is a way round it.
    """
    tree = tree_on(mesh)
    signed = np.full(len(mesh), np.inf)
    for curve in curves:
        band = _faces_along(mesh, tree.closest(_densified_points(curve)).faces)
        vertices = np.unique(mesh.faces[band])
        found = signed_mm(mesh.vertices_mm[vertices], curve)
        nearer = np.abs(found) < np.abs(signed[vertices])
        signed[vertices[nearer]] = found[nearer]
    sign = np.where(np.isfinite(signed), np.where(signed > 0, 1, -1), 0)
    ends = find_edges(mesh.faces).ends
    across = sign[ends[:, 0]] * sign[ends[:, 1]] < 0
    count = len(mesh)
    part = components(ends[~across], count)
    parts = int(part.max()) + 1
    lefts = np.bincount(part[sign > 0], minlength=parts)
    rights = np.bincount(part[sign < 0], minlength=parts)
    if ((lefts > 0) & (rights > 0)).any() or not lefts.any() or not rights.any():
        raise EditError("edit.curve.no_parting")
    return Sides((lefts > 0)[part], signed)


def smaller_side(mesh: Mesh, sides: Sides) -> Bool[np.ndarray, " n"]:
    """The vertices on the side of a curve with less area."""
    areas = np.linalg.norm(mesh.face_normals(), axis=1)
    left_share = sides.left[mesh.faces].mean(1)
    if (areas * left_share).sum() <= (areas * (1 - left_share)).sum():
        return sides.left
    return ~sides.left


def refined_along(mesh: Mesh, curve: Curve, edge_mm: float) -> Mesh:
    """The mesh with edges along a curve refined."""
    points = _densified_points(curve)

    def select(work: Mesh) -> Bool[np.ndarray, " f"]:
        chosen = np.zeros(len(work.faces), np.bool_)
        tree = tree_on(work)
        chosen[tree.closest(points).faces] = True
        return chosen

    return refine_selected(mesh, select, edge_mm)


def distances_from_point(
    mesh: Mesh, point_mm: Vector3, limit_mm: float
) -> Float64[np.ndarray, " n"]:
    """Distance of each vertex from a point on the surface; infinite beyond the limit."""
    face = tree_on(mesh).closest(point_mm[None]).faces[0]
    straight = np.linalg.norm(mesh.vertices_mm - point_mm, axis=1)
    start = np.full(len(mesh), np.inf)
    touching = np.isin(mesh.faces, mesh.faces[face]).any(1)
    first = np.unique(mesh.faces[touching])
    start[first] = straight[first]
    return _propagated_distances(mesh, start, straight <= limit_mm, limit_mm, circular=True)


def distances_from(
    mesh: Mesh,
    start_mm: Float64[np.ndarray, " n"],
    allowed: Bool[np.ndarray, " n"],
    limit_mm: float,
) -> Float64[np.ndarray, " n"]:
    """Distance of each vertex from a curve, whose neighbours' distances are given.

    Args:
        start_mm: Known distances; infinite elsewhere.
        allowed: Vertices that paths may pass.
    """
    return _propagated_distances(mesh, start_mm, allowed, limit_mm, circular=False)


def distances_from_line(
    mesh: Mesh, line_mm: Float64[np.ndarray, "k 3"], limit_mm: float
) -> Float64[np.ndarray, " n"]:
    """Distance of each vertex from a fine line on the surface, open or closed; infinite beyond
    the limit."""
    tree = tree_on(mesh)
    near = np.unique(mesh.faces[_faces_along(mesh, tree.closest(line_mm).faces)])
    start = np.full(len(mesh), np.inf)
    start[near] = KDTree(line_mm).query(mesh.vertices_mm[near], workers=1)[0]
    return distances_from(mesh, start, np.ones(len(mesh), np.bool_), limit_mm)


def signed_mm(points: Points3, curve: Curve) -> Float64[np.ndarray, " n"]:
    """Distance to a curve's polyline, signed by its side on the surface: positive to the left."""
    line, count = curve.points_mm, len(curve.points_mm)
    nearest = np.asarray(KDTree(line).query(points)[1])
    distance = np.full(len(points), np.inf)
    signed = np.empty(len(points))
    for first in (nearest - 1, nearest):
        start, end = line[first % count], line[(first + 1) % count]
        along = end - start
        share = ((points - start) * along).sum(1) / np.maximum((along * along).sum(1), 1e-30)
        foot = start + np.clip(share, 0.0, 1.0)[:, None] * along
        off = np.linalg.norm(points - foot, axis=1)
        leftward = np.cross(curve.normals[nearest], _tangents(curve)[nearest])
        side = ((points - foot) * leftward).sum(1)
        closer = off < distance
        distance[closer] = off[closer]
        signed[closer] = np.where(side > 0, off, -off)[closer]
    return signed


def with_surface_added(
    mesh: Mesh, places_mm: Points3, like: Int64[np.ndarray, " k"], faces: Faces
) -> Mesh:
    """The mesh with vertices and faces added that count as filled.

    Args:
        like: For each new vertex, an old one from which it takes its colour.
        faces: Of old and new vertices; new ones count on from the old.
    """
    if mesh.filled is None:
        mesh = replace(mesh, filled=np.zeros(len(mesh), np.bool_))
    return replace(
        mesh,
        vertices_mm=np.concatenate([mesh.vertices_mm, places_mm]),
        faces=np.concatenate([mesh.faces, faces]).astype(np.int32),
        **mesh.of_vertices(lambda one, values: one.with_unmeasured(values, like)),
    )


def with_holes_closed(
    mesh: Mesh, holes: Sequence[Int32[np.ndarray, " l"]], *, curved: bool = True
) -> Mesh:
    """The mesh with holes closed, each a loop of its vertices; no vertex of it moves.

    Args:
        curved: Whether the filling continues the surface's curvature; else it is a minimal surface.
    """
    if not holes:
        return mesh
    first = len(mesh)
    closed = fill_holes(mesh.vertices_mm, mesh.faces, list(holes), curved=curved)
    if not np.array_equal(closed.vertices_mm[:first], mesh.vertices_mm):
        raise EditError("edit.fill.moved")
    places = closed.vertices_mm[first:]
    rim = np.concatenate(holes).astype(np.int64)
    nearest = np.asarray(KDTree(mesh.vertices_mm[rim]).query(places)[1])
    return with_surface_added(
        replace(mesh, faces=mesh.faces[:0]), places, rim[nearest], closed.faces
    )


def neighbour_averaging(mesh: Mesh) -> csr_array:
    """Matrix that averages vertex values over each vertex's neighbours, weighted by nearness."""
    edges = find_edges(mesh.faces)
    near = edges.neighbours
    sizes = edge_lengths(mesh.vertices_mm, edges.ends)
    weights = 1 / np.maximum(sizes, _LEAST_EDGE_SHARE * float(np.median(sizes)))
    starts = np.pad(near.starts, (0, len(mesh) + 1 - len(near.starts)), "edge")
    mean = csr_array((weights[near.edges], near.vertices, starts), shape=(len(mesh), len(mesh)))
    total = np.asarray(mean.sum(1)).ravel()
    mean.data /= np.repeat(np.maximum(total, 1e-30), np.diff(mean.indptr))
    return mean


def barycentric_weights(corners: Float64[np.ndarray, "k 3 3"], points: Points3) -> Points3:
    """Barycentric coordinates of points in the planes of triangles."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    size = np.maximum((normal * normal).sum(1), 1e-30)
    of_a = (np.cross(c - b, points - b) * normal).sum(1) / size
    of_b = (np.cross(a - c, points - c) * normal).sum(1) / size
    return np.stack([of_a, of_b, 1 - of_a - of_b], axis=1)


def smooth_normals(mesh: Mesh, rounds: int = 8) -> Points3:
    """Unit outward vertex normals, smoothed over neighbours."""
    mean = neighbour_averaging(mesh)
    normals = mesh.vertex_normals()
    for _ in range(rounds):
        normals = 0.5 * (normals + mean @ normals)
    return unit(normals)


def smooth_normals_on(refined: Mesh, mesh: Mesh) -> Points3:
    """Smooth normals of a mesh, interpolated at the vertices of its refinement.

    They turn evenly over each old triangle; the refined mesh's own would turn only at creases.
    """
    normals = smooth_normals(mesh)
    added = refined.vertices_mm[len(mesh) :]
    if not len(added):
        return normals
    closest = tree_on(mesh).closest(added)
    corners = mesh.faces[closest.faces]
    shares = barycentric_weights(mesh.vertices_mm[corners], closest.points_mm)
    between = unit(np.einsum("nk,nkc->nc", shares, normals[corners]))
    return np.concatenate([normals, between])


def on_open_edge(mesh: Mesh) -> Bool[np.ndarray, " n"]:
    """Vertices on an open edge."""
    marked = np.zeros(len(mesh), np.bool_)
    marked[boundary_half_edges(mesh.faces)] = True
    return marked


def roughness_mm(mesh: Mesh) -> float:
    """Deviation of vertices from their neighbours' mean beyond what curvature explains.

    Root mean square along the normal, of vertices away from the brim.
    """
    mean = neighbour_averaging(mesh)
    towards = mean @ mesh.vertices_mm - mesh.vertices_mm
    out = dots(towards, mesh.vertex_normals())
    beyond = out - mean @ out
    inner = ~on_open_edge(mesh)
    return rms(beyond[inner]) if inner.any() else 0.0


def _largest_section_rows(table: Float64[np.ndarray, "k 4"]) -> Float64[np.ndarray, "m 4"]:
    """One row for each height: that of the largest section."""
    order = np.lexsort((-table[:, 1], table[:, 0]))
    first = np.unique(table[order, 0], return_index=True)[1]
    return table[order][first]


def _moving_average(values: Float64[np.ndarray, " m"]) -> Float64[np.ndarray, " m"]:
    """Moving average over five values, with the end values repeated."""
    padded = np.concatenate([values[:1], values[:1], values, values[-1:], values[-1:]])
    return np.asarray(sum(padded[k : k + len(values)] for k in range(5))) / 5


def _faces_along(mesh: Mesh, faces: Int64[np.ndarray, " k"]) -> Bool[np.ndarray, " f"]:
    """The given faces and those that share a vertex with them."""
    touched = np.zeros(len(mesh), np.bool_)
    touched[mesh.faces[faces]] = True
    return np.asarray(touched[mesh.faces].any(1))


def _densified_points(curve: Curve) -> Points3:
    """The curve's points, with three more between each two."""
    here, ahead = curve.points_mm, np.roll(curve.points_mm, -1, axis=0)
    return np.concatenate([here + share * (ahead - here) for share in (0.0, 0.25, 0.5, 0.75)])


def _tangents(curve: Curve) -> Points3:
    chord = np.roll(curve.points_mm, -1, axis=0) - np.roll(curve.points_mm, 1, axis=0)
    return unit(chord)


def _propagated_distances(
    mesh: Mesh,
    start_mm: Float64[np.ndarray, " n"],
    allowed: Bool[np.ndarray, " n"],
    limit_mm: float,
    *,
    circular: bool,
) -> Float64[np.ndarray, " n"]:
    faces = mesh.faces[allowed[mesh.faces].all(1)]
    kept = np.zeros(len(mesh), np.bool_)
    kept[faces] = True
    used = np.flatnonzero(kept)
    compact = (np.cumsum(kept) - 1).astype(np.int32)[faces]
    distance = start_mm[used].copy()
    sides = _side_geometry(mesh.vertices_mm[used], compact)
    begins, corners = corners_by_vertex(compact, len(used))
    _propagate_fronts(compact, sides, begins, corners // 3, distance, limit_mm, circular)
    whole = start_mm.copy()
    whole[used] = distance
    return whole


def _side_geometry(vertices: Points3, faces: Faces) -> Float64[np.ndarray, "f 3 5"]:
    """Five lengths for each side of each face, from a to b.

    Its own, how far along it the third corner c lies and how far from it, and how far c lies from a
    and from b.
    """
    a, b, c = (vertices[np.roll(faces, -k, axis=1)] for k in (0, 1, 2))
    along, to_c = b - a, c - a
    edge = np.maximum(np.linalg.norm(along, axis=2), 1e-12)
    x, y = (along * to_c).sum(2) / edge, np.linalg.norm(np.cross(along, to_c), axis=2) / edge
    return np.stack([edge, x, y, np.hypot(x, y), np.hypot(x - edge, y)], axis=2)


@njit(cache=True, nogil=True)
def _propagate_fronts(
    faces: np.ndarray,
    sides: np.ndarray,
    begins: np.ndarray,
    faces_round: np.ndarray,
    distance: np.ndarray,
    limit: float,
    circular: bool,
):
    """Propagate fronts over the faces beside changed vertices until no distance changes; those
    beyond the limit stay infinite.
    """
    changed, better = np.isfinite(distance), distance.copy()
    front, asked = np.flatnonzero(changed), np.full(len(faces), -1)
    reached, ahead = np.empty(len(distance), np.int64), np.empty(len(distance), np.int64)
    for turn in range(_MOST_ROUNDS):
        count = 0
        for vertex in front:
            for at in range(begins[vertex], begins[vertex + 1]):
                f = faces_round[at]
                if asked[f] == turn:
                    continue
                asked[f] = turn
                for k in range(3):
                    a, b, c = faces[f, k], faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
                    from_a, from_b = float(distance[a]), float(distance[b])
                    if (changed[a] or changed[b]) and min(from_a, from_b) < better[c]:
                        offered = _front_arrival(from_a, from_b, sides[f, k], circular)
                        if offered < better[c]:
                            if better[c] == distance[c]:
                                reached[count] = c
                                count += 1
                            better[c] = offered
        changed[front] = False
        nearer = 0
        for vertex in reached[:count]:
            if better[vertex] <= limit and better[vertex] < distance[vertex] - _CONVERGED_MM:
                distance[vertex] = better[vertex]
                changed[vertex] = True
                ahead[nearer] = vertex
                nearer += 1
            better[vertex] = distance[vertex]
        front = ahead[:nearer].copy()
        if not nearer:
            break


@njit(cache=True, nogil=True)
def _front_arrival(from_a: float, from_b: float, side: np.ndarray, circular: bool):
    """Distance at which a front that reached a and b reaches c."""
    edge, x, y, to_a, to_b = side
    round_edges = min(from_a + to_a, from_b + to_b)
    if math.isinf(from_a) or math.isinf(from_b):
        return round_edges
    if circular:
        foot = (from_a**2 - from_b**2 + edge**2) / (2 * edge)
        below2 = from_a**2 - foot**2
        if below2 < 0:
            return round_edges
        below = math.sqrt(below2)
        if below + y == 0:
            return round_edges
        crossing = foot + (x - foot) * below / (below + y)
        through = math.hypot(x - foot, y + below)
    else:
        slope = (from_b - from_a) / edge
        if abs(slope) >= 1:
            return round_edges
        rise = math.sqrt(1 - slope**2)
        crossing = x - y * slope / rise
        through = from_a + slope * x + rise * y
    return through if 0 <= crossing <= edge else round_edges
