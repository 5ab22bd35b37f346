"""Curves: a closed curve drawn on the surface by picked points, and which side of it is which.

In      points picked in order round the region.
Out     a Curve: a smooth closed line through them, lying on the surface; and for every vertex near
        it the signed distance to it.
Method  a periodic cubic spline through the points, brought to the surface.
Fails   EditError: too few points, or a line that jumps or meets itself.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from limbgram.errors import EditError
from limbgram.geometry.arrays import Points3
from limbgram.shape.edits.marking.fineness import refine_under
from limbgram.surface.closest import TriangleTree
from limbgram.surface.mesh import Mesh, unit
from limbgram.surface.topology import find_edges

_STEP_MM = 0.5
_LEAST_STEPS = 120
_JUMP = 4.0
"""Steps of the line may grow by this where it is brought to the surface."""
_FARTHEST = 0.25
"""Share of the curve's extent by which the spline may leave the surface that it is brought to."""


@dataclass(frozen=True)
class Curve:
    """A closed polyline on the surface; the first point is not repeated."""

    points_mm: Points3
    normals: Points3
    """Of the surface, smoothed over a few steps."""

    @property
    def length_mm(self) -> float:
        ahead = np.roll(self.points_mm, -1, axis=0) - self.points_mm
        return float(np.linalg.norm(ahead, axis=1).sum())


@dataclass(frozen=True)
class Sides:
    """Where vertices lie with respect to a curve."""

    left: Bool[np.ndarray, " n"]
    """To the left of somebody who walks along the curve on the outside of the surface."""
    signed_mm: Float64[np.ndarray, " n"]
    """Distance to the curve of the vertices near it, positive to the left; infinite elsewhere."""


def draw_curve(mesh: Mesh, picked_mm: Points3, what: str) -> Curve:
    """The smooth closed curve on the surface through picked points.

    Raises:
        EditError: fewer than three points, or points so far apart that the line would jump.
    """
    from scipy.interpolate import CubicSpline  # a tenth of a second, for curves alone

    if len(picked_mm) < 3:
        raise EditError(f"{what} needs a closed curve of at least 3 points, in order round it.")
    ring = np.concatenate([picked_mm, picked_mm[:1]])
    gaps = np.linalg.norm(np.diff(ring, axis=0), axis=1)
    if gaps.min() < 1e-6:
        raise EditError(f"{what}: two points in a row are the same. Leave one of them out.")
    # Centripetal spacing keeps the spline from looping where points lie unevenly.
    knots = np.concatenate([[0.0], np.cumsum(np.sqrt(gaps))])
    spline = CubicSpline(knots, ring, bc_type="periodic")
    steps = max(_LEAST_STEPS, int(np.ceil(gaps.sum() / _STEP_MM)))
    at = np.linspace(0.0, knots[-1], 4 * steps + 1)
    fine = spline(at)
    walked = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1))])
    even = np.interp(np.linspace(0.0, walked[-1], steps + 1)[:-1], walked, at)
    tree = TriangleTree.of(mesh.vertices_mm, mesh.faces)
    drawn = np.asarray(spline(even))
    closest = tree.closest(drawn)
    reach = _FARTHEST * float(np.linalg.norm(np.ptp(picked_mm, axis=0)))
    jumps = np.linalg.norm(np.roll(closest.points_mm, -1, axis=0) - closest.points_mm, axis=1)
    step = walked[-1] / steps
    if closest.distances_mm.max() > reach or jumps.max() > _JUMP * step:
        worst = (
            int(np.argmax(jumps))
            if jumps.max() > _JUMP * step
            else int(np.argmax(closest.distances_mm))
        )
        segment = int(np.searchsorted(knots, even[worst], side="right"))
        raise EditError(
            f"{what}: the curve leaves the surface between its points {segment} and "
            f"{segment % len(picked_mm) + 1}. Pick more points there."
        )
    normals = mesh.vertex_normals()[mesh.faces[closest.faces]].mean(1)
    return Curve(closest.points_mm, _smoothed(normals))


def find_sides(mesh: Mesh, curve: Curve, what: str) -> Sides:
    """Tell the two sides of a curve apart.

    Raises:
        EditError: the curve crosses itself or comes too near to itself.
    """
    tree = TriangleTree.of(mesh.vertices_mm, mesh.faces)
    band = _faces_along(mesh, tree.closest(_densified(curve)).faces)
    vertices = np.unique(mesh.faces[band])
    signed = np.full(len(mesh), np.inf)
    signed[vertices] = _signed_mm(mesh.vertices_mm[vertices], curve)
    sign = np.where(np.isfinite(signed), np.where(signed > 0, 1, -1), 0)
    ends = find_edges(mesh.faces).ends
    across = sign[ends[:, 0]] * sign[ends[:, 1]] < 0
    count = len(mesh)
    joined = ends[~across]
    graph = coo_array((np.ones(len(joined), np.int8), (joined[:, 0], joined[:, 1])), (count, count))
    part = connected_components(graph, directed=False)[1]
    parts = int(part.max()) + 1
    lefts = np.bincount(part[sign > 0], minlength=parts)
    rights = np.bincount(part[sign < 0], minlength=parts)
    if ((lefts > 0) & (rights > 0)).any() or not lefts.any() or not rights.any():
        raise EditError(
            f"{what}: the curve does not part the surface in two. It crosses itself, comes within "
            "a triangle of itself, or runs over the open brim. Pick its points in order, and "
            "inside the brim."
        )
    return Sides((lefts > 0)[part], signed)


def fine_along(mesh: Mesh, curve: Curve, edge_mm: float) -> Mesh:
    """The mesh with short edges under a curve."""
    points = _densified(curve)

    def under(work: Mesh) -> Bool[np.ndarray, " f"]:
        chosen = np.zeros(len(work.faces), np.bool_)
        tree = TriangleTree.of(work.vertices_mm, work.faces)
        chosen[tree.closest(points).faces] = True
        return chosen

    return refine_under(mesh, under, edge_mm)


def inside(mesh: Mesh, sides: Sides) -> Bool[np.ndarray, " n"]:
    """Vertices on the smaller of the two sides, by area."""
    areas = np.linalg.norm(mesh.face_normals(), axis=1)
    left_share = sides.left[mesh.faces].mean(1)
    if (areas * left_share).sum() <= (areas * (1 - left_share)).sum():
        return sides.left
    return ~sides.left


def _faces_along(mesh: Mesh, faces: Int64[np.ndarray, " k"]) -> Bool[np.ndarray, " f"]:
    """Faces under the curve, and those that touch them."""
    touched = np.zeros(len(mesh), np.bool_)
    touched[mesh.faces[faces]] = True
    return np.asarray(touched[mesh.faces].any(1))


def _densified(curve: Curve) -> Points3:
    """The curve's points with three more between each two."""
    here, ahead = curve.points_mm, np.roll(curve.points_mm, -1, axis=0)
    return np.concatenate([here + share * (ahead - here) for share in (0.0, 0.25, 0.5, 0.75)])


def _signed_mm(points: Points3, curve: Curve) -> Float64[np.ndarray, " n"]:
    """Distance to the polyline, signed by its side on the surface."""
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


def _tangents(curve: Curve) -> Points3:
    chord = np.roll(curve.points_mm, -1, axis=0) - np.roll(curve.points_mm, 1, axis=0)
    return unit(chord)


def _smoothed(normals: Points3) -> Points3:
    around = sum(
        (np.roll(normals, shift, axis=0) for shift in range(-3, 4)), np.zeros_like(normals)
    )
    return unit(around)
