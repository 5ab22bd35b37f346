"""Layout: the part of a positive that a device covers, inside its edges and outside its openings.

In      a Body and the edges drawn on it; slots, round vents, and an opening from end to end.
Out     the positive, refined along all of them, and its vertices' signed distance beyond them.
Method  Distances over the surface go out from each edge to both sides (edits/regions). Round a slot
        or a vent the surface is laid out by the distance and the direction from its middle, which
        keeps lengths there to a share of a per cent on a limb's calf.
Fails   EditError: edges that cross, an opening that runs into an edge, or a hole of the scan inside
        the device.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.spatial import KDTree

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.mesh.mesh import Mesh, lengths, longest_sides_mm, unit
from limbgram.core.mesh.topology import boundary_half_edges, face_components
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.workbench.devices.body import Body
from limbgram.workbench.devices.trims import Edge
from limbgram.workbench.edits.refinement import refine_selected
from limbgram.workbench.edits.regions import (
    Curve,
    distances_from,
    distances_from_point,
    find_sides,
    refined_along,
)

_EDGE_LENGTH_MM = 1.5
"""Edge length of triangles along the device's edges and openings."""
_EDGE_PER_FALLOFF = 1 / 3
"""Edge length of triangles under a rib, as a share of its falloff."""
_SELF_CONTACT_MM, _LEAST_ARC_MM = 6.0, 15.0
"""A curve touches itself where two places come this near though this far apart along it."""
_CORNER_MM = 12.0
"""Radius of the corners where a gap meets the edges."""
_REACH_MM = 40.0
"""Distances from an edge are cut off here: nothing depends on larger ones."""


@dataclass(frozen=True, kw_only=True)
class Opening:
    """A slot for a strap, or a vent: a straight hole with round ends."""

    name: str
    middle_mm: Vector3
    """On the surface, in the limb frame."""
    along: Vector3
    """The direction of its length."""
    length_mm: float
    """From end to end; a round vent's is its width."""
    width_mm: float
    measures: tuple[str, ...] = ()
    """The measures that set its place and size, for refusals."""


@dataclass(frozen=True, kw_only=True)
class Gap:
    """An opening from the upper to the lower edge, as a brace has it."""

    name: str
    outward: Vector3
    """Unit: the side on which it lies."""
    across: Vector3
    """Unit: the direction of its width."""
    width_mm: float


@dataclass(frozen=True, kw_only=True)
class Rib:
    """A raised band along a line on the surface."""

    line_mm: Points3
    width_mm: float
    """Of the part at full height."""
    falloff_mm: float
    add_mm: float


@dataclass(frozen=True, kw_only=True)
class CoveredArea:
    """The positive, and the signed distance of its vertices beyond the device's edges."""

    positive: Mesh
    beyond_mm: Float64[np.ndarray, " n"]


def cover(
    body: Body,
    edges: Sequence[Edge],
    openings: Sequence[Opening] = (),
    gaps: Sequence[Gap] = (),
    bridge_mm: float = 0.0,
    ribs: Sequence[Rib] = (),
) -> CoveredArea:
    """The part of the positive that a device covers.

    Args:
        ribs: Under these the mesh is refined, so that they come out smooth.
        bridge_mm: Least width of material between an opening and an edge, or another opening.

    Raises:
        EditError: see the head of this file.
    """
    mesh = body.mesh
    for edge in edges:
        mesh = refined_along(mesh, edge.curve, _EDGE_LENGTH_MM)
    for opening in openings:
        mesh = _refined_round_opening(mesh, opening)
    for rib in ribs:
        mesh = _refined_under_rib(mesh, rib)
    beyond = np.full(len(mesh), -_REACH_MM)
    others: list[tuple[str, Float64[np.ndarray, " n"]]] = []
    for edge in edges:
        others.append((edge.name, _distance_beyond_edge(mesh, edge)))
        beyond = np.maximum(beyond, others[-1][1])
    beyond = _largest_kept_piece(mesh, beyond, edges)
    for gap in gaps:
        others.append((gap.name, depth_in_gap(mesh.vertices_mm, gap)))
        beyond = _rounded_max(beyond, others[-1][1])
    for opening in openings:
        depth = _depth_in_opening(mesh, opening)
        _require_bridge(mesh, beyond, depth, opening, bridge_mm, others)
        beyond = np.maximum(beyond, depth)
        others.append((opening.name, depth))
    _require_no_hole(mesh, beyond)
    return CoveredArea(positive=mesh, beyond_mm=beyond)


def depth_in_gap(places_mm: Points3, gap: Gap) -> Float64[np.ndarray, " n"]:
    """Depth of places inside a gap, measured straight across it; negative outside."""
    off = np.abs(places_mm @ gap.across)
    return np.where(places_mm @ gap.outward > 0, gap.width_mm / 2 - off, -_REACH_MM)


def _distance_beyond_edge(mesh: Mesh, edge: Edge) -> Float64[np.ndarray, " n"]:
    try:
        sides = find_sides(mesh, [edge.curve])
    except EditError as error:
        contact = _self_contact(edge.curve)
        x, y, z = edge.curve.points_mm[contact[0]].tolist()
        raise EditError(
            "device.trim.crosses",
            name=edge.name,
            point_mm=(x, y, z),
            measures=edge.measures_beside(contact) or None,
        ) from error
    near = np.isfinite(sides.signed_mm)
    start = np.where(near, np.abs(sides.signed_mm), np.inf)
    away = distances_from(mesh, start, np.ones(len(mesh), np.bool_), _REACH_MM)
    away = np.minimum(away, _REACH_MM)
    kept = mesh.faces[tree_on(mesh).closest(edge.keeps_mm[None]).faces[0], 0]
    inside = sides.left == sides.left[kept]
    return np.where(inside, -away, away)


def _self_contact(curve: Curve) -> Int64[np.ndarray, " k"]:
    """The two points of a curve at which parts of it come nearest to each other; else its sharpest
    corner."""
    points = curve.points_mm
    count = len(points)
    pairs = KDTree(points).query_pairs(_SELF_CONTACT_MM, output_type="ndarray")
    along = np.abs(pairs[:, 1] - pairs[:, 0])
    apart = np.minimum(along, count - along) * curve.length_mm / count > _LEAST_ARC_MM
    if not apart.any():
        ways = unit(np.roll(points, -1, axis=0) - points)
        return np.array([np.argmin((ways * np.roll(ways, 1, axis=0)).sum(1))])
    pairs = pairs[apart]
    return pairs[int(np.argmin(lengths(points[pairs[:, 0]] - points[pairs[:, 1]])))]


def _largest_kept_piece(
    mesh: Mesh, beyond: Float64[np.ndarray, " n"], edges: Sequence[Edge]
) -> Float64[np.ndarray, " n"]:
    """Distances beyond edges, with every piece but the device's own counted as outside."""
    inside = beyond < 0
    faces = np.flatnonzero(inside[mesh.faces].any(1))
    pieces = face_components(mesh.faces[faces])
    seed = tree_on(mesh).closest(edges[0].keeps_mm[None]).faces[0]
    at = np.flatnonzero(faces == seed)
    if not len(at):
        raise EditError("device.nothing_left")
    own = np.zeros(len(mesh), np.bool_)
    own[mesh.faces[faces[pieces == pieces[at[0]]]]] = True
    return np.where(inside & ~own, _REACH_MM, beyond)


def _rounded_max(
    one: Float64[np.ndarray, " n"], two: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, " n"]:
    """The larger of two distances, with the corner between their zero lines rounded."""
    corner = np.hypot(np.maximum(one + _CORNER_MM, 0.0), np.maximum(two + _CORNER_MM, 0.0))
    return np.minimum(np.maximum(one, two), -_CORNER_MM) + corner


def _refined_round_opening(mesh: Mesh, opening: Opening) -> Mesh:
    reach_mm = 0.5 * max(opening.length_mm, opening.width_mm) + 2 * _EDGE_LENGTH_MM

    def under(work: Mesh) -> Bool[np.ndarray, " f"]:
        away = lengths(work.vertices_mm[work.faces].mean(1) - opening.middle_mm)
        return away < reach_mm + longest_sides_mm(work.vertices_mm, work.faces)

    return refine_selected(mesh, under, _EDGE_LENGTH_MM)


def _refined_under_rib(mesh: Mesh, rib: Rib) -> Mesh:
    line = KDTree(rib.line_mm)
    reach_mm = 0.5 * rib.width_mm + rib.falloff_mm

    def under(work: Mesh) -> Bool[np.ndarray, " f"]:
        away = line.query(work.vertices_mm[work.faces].mean(1), workers=1)[0]
        return away < reach_mm + longest_sides_mm(work.vertices_mm, work.faces)

    return refine_selected(mesh, under, rib.falloff_mm * _EDGE_PER_FALLOFF)


def _depth_in_opening(mesh: Mesh, opening: Opening) -> Float64[np.ndarray, " n"]:
    """Depth of each vertex inside an opening; negative outside."""
    reach_mm = max(opening.length_mm, opening.width_mm) + _REACH_MM / 2
    away = distances_from_point(mesh, opening.middle_mm, reach_mm)
    near = np.isfinite(away)
    face = tree_on(mesh).closest(opening.middle_mm[None]).faces[0]
    normal = unit(mesh.face_normals()[face][None])[0]
    along = opening.along - (opening.along @ normal) * normal
    along = along / np.linalg.norm(along)
    across = np.cross(normal, along)
    straight = mesh.vertices_mm[near] - opening.middle_mm
    flat: Points3 = straight - np.outer(straight @ normal, normal)
    flat = unit(flat) * away[near][:, None]
    half = 0.5 * (opening.length_mm - opening.width_mm)
    off = np.hypot(np.maximum(np.abs(flat @ along) - half, 0.0), flat @ across)
    depth = np.full(len(mesh), -_REACH_MM)
    depth[near] = np.maximum(0.5 * opening.width_mm - off, -_REACH_MM)
    return depth


def _require_bridge(
    mesh: Mesh,
    beyond: Float64[np.ndarray, " n"],
    depth: Float64[np.ndarray, " n"],
    opening: Opening,
    least_mm: float,
    others: Sequence[tuple[str, Float64[np.ndarray, " n"]]],
) -> None:
    """Refuse an opening that leaves less than a bridge beside it.

    A bridge is narrowest where the sum of the distances to its two sides is least.

    Args:
        beyond: Signed distance beyond edges, gaps and the openings before this one.
        others: The same of each of them, by name.

    Raises:
        EditError: names the opening and the place.
    """
    near = np.flatnonzero(depth > -least_mm)
    if not len(near):
        return
    wide_mm = -(beyond + depth)[near]
    at = int(np.argmin(wide_mm))
    if wide_mm[at] < least_mm:
        x, y, z = mesh.vertices_mm[near[at]].tolist()
        raise EditError(
            "device.opening.edge",
            name=opening.name,
            point_mm=(x, y, z),
            wide_mm=max(float(wide_mm[at]), 0.0),
            least_mm=least_mm,
            beside=max(others, key=lambda other: other[1][near[at]])[0],
            fits_mm=None,
            measures=opening.measures or None,
        )


def _require_no_hole(mesh: Mesh, beyond: Float64[np.ndarray, " n"]) -> None:
    """Refuse a hole of the scan in what the device covers.

    Raises:
        EditError: says where.
    """
    border = np.unique(boundary_half_edges(mesh.faces))
    inside = border[beyond[border] < 0] if len(border) else border
    if len(inside):
        x, y, z = mesh.vertices_mm[inside].mean(0).tolist()
        raise EditError("device.hole", point_mm=(x, y, z))
