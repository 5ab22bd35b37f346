"""Probing: spheres and cylinders found in a surface, and the bodies of Gauss associated with them.

In      a mesh with what was measured of it, and the nominal diameter.
Out     Probed: where the body lies, its diameter, and how far the measured points lie off it.
Method  Finding: from every vertex a step of one radius against its normal leads to the middle of a
        sphere, or to the axis of a cylinder, wherever else the surface goes; the places where many
        steps meet are the candidates. A cylinder's axis is square to the normals of two of its
        points: many pairs are tried.
        What counts: vertices near the body whose normals point away from it. Where the surface
        leaves the body (the bar of a ball bar, the face of a cylinder) it leaves for good, and a
        strip along that border is left out as acceptance tests leave out the neighbourhood of the
        shaft. A place that is off and all round which the body goes on is no border: it is an
        error of form and counts.
        Associating: least squares of the distances from the body (ISO 10360-6), each vertex with
        the area for which it stands, so that finer triangles weigh no more. The form is the width
        of the shell round it that holds all vertices, or the narrowest that holds 95 % of the area.
Fails   never: a body that is not there, or of which too little was measured, is None.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.spatial import KDTree

from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.frames import axes_across
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import components_among

_VOTE_CELL = 0.1
"""Side of a cell in which steps are counted, in radii: they miss by as much where a normal is 6
degrees off."""
_LEAST_VOTES = 0.12
"""Of the sphere's area, for a candidate."""
_NEAR, _NEAR_REFINED = 0.10, 0.05
"""Of the radius: what lies so near to the nominal, then to the fitted body, may be part of it."""
_LEAST_COSINE = np.cos(np.radians(30.0))
"""Of the angle between a normal and the way from the body's middle."""
_ROUNDS = 6
_OUTLIER_SHARE = 0.03
"""A patch off the body larger than this share of its area, or that reaches farther than _NEAR, is
where the surface leaves it."""
_STRIP, _STRIP_MM = 0.12, 2.0
"""Width of the strip left out along that border: of the radius, and at least."""
_LEAST_SEEN = 0.25
"""Of a sphere's area, or of a cylinder's turn, that must have been measured."""
_HOLDS = 0.95
_PAIRS = 2000
_TRIED_POINTS = 4000
_SECTORS = 36


@dataclass(frozen=True, kw_only=True)
class ProbedBody:
    """A least-squares (Gaussian) sphere or cylinder, with its points."""

    middle_mm: Vector3
    """Of the sphere; of a cylinder a point on its axis."""
    axis: Vector3 | None
    """Unit, of a cylinder."""
    diameter_mm: float
    form_mm: float
    """Width of the shell that holds every point."""
    form_95_mm: float
    """The narrowest that holds 95 % of the area."""
    points: int
    seen: float
    """Share of the sphere's area, or of the cylinder's turn, that was measured and counts."""
    vertices: Int64[np.ndarray, " k"]
    """Which vertices of the surface count."""
    off_mm: Float64[np.ndarray, " k"]
    """How far each lies outside the body."""


@dataclass(frozen=True, kw_only=True)
class Surface:
    """A measured surface, ready to be searched."""

    vertices_mm: Points3
    normals: Points3
    areas_mm2: Float64[np.ndarray, " n"]
    measured: Bool[np.ndarray, " n"]
    edges: Int64[np.ndarray, "e 2"]


def surface_of(meshes: Sequence[Mesh]) -> Surface:
    """All bodies of a reconstruction as one searchable surface."""
    start = np.cumsum([0, *(len(mesh) for mesh in meshes)])
    edges = [
        (mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(np.int64) + first)
        for mesh, first in zip(meshes, start[:-1], strict=True)
    ]
    return Surface(
        vertices_mm=np.concatenate([mesh.vertices_mm for mesh in meshes]),
        normals=np.concatenate([mesh.vertex_normals() for mesh in meshes]),
        areas_mm2=np.concatenate([mesh.vertex_areas_mm2() for mesh in meshes]),
        measured=np.concatenate([m.measured for m in meshes]),
        edges=np.concatenate(edges),
    )


def find_spheres(surface: Surface, diameter_mm: float) -> tuple[ProbedBody, ...]:
    """Every sphere of about this diameter, the one with most of its area measured first."""
    found: list[ProbedBody] = []
    for middle in _candidates(surface, diameter_mm / 2):
        probed = _sphere(surface, middle, diameter_mm / 2)
        if probed is None:
            continue
        apart = [np.linalg.norm(probed.middle_mm - one.middle_mm) for one in found]
        if min(apart, default=np.inf) > diameter_mm / 2:
            found.append(probed)
    return tuple(sorted(found, key=lambda one: -one.seen))


def find_cylinder(surface: Surface, diameter_mm: float) -> ProbedBody | None:
    """The cylinder of about this diameter of which most was measured."""
    start = _axis_among(surface, diameter_mm / 2)
    return None if start is None else _cylinder(surface, *start, diameter_mm / 2)


def _candidates(surface: Surface, radius: float) -> Points3:
    """Centre candidates where steps of one radius against the normals meet, by falling area."""
    kept = surface.measured
    steps = surface.vertices_mm[kept] - radius * surface.normals[kept]
    cell = _VOTE_CELL * radius
    low = steps.min(0) - 2 * cell
    at = np.floor((steps - low) / cell).astype(np.int64)
    size = at.max(0) + 3
    cells, of_step = np.unique(np.ravel_multi_index(tuple(at.T), size), return_inverse=True)
    votes = np.bincount(of_step, surface.areas_mm2[kept])
    least = _LEAST_VOTES * 4 * np.pi * radius**2
    around = np.indices((3, 3, 3)).reshape(3, -1).T - 1
    around = around @ [size[1] * size[2], size[2], 1]
    # only beside a cell with its share of them can there be enough
    places = np.unique(cells[votes > least / len(around), None] + around)
    sums = np.sum([_votes_in(places + step, cells, votes) for step in around], axis=0)
    enough = sums > least
    order = np.argsort(-sums[enough], kind="stable")
    places = np.stack(np.unravel_index(places[enough][order], size), axis=1)
    middles = low + (places + 0.5) * cell
    chosen: list[Vector3] = []
    for middle in middles:
        if all(np.linalg.norm(middle - one) > radius for one in chosen):
            chosen.append(middle)
    return np.array(chosen).reshape(-1, 3)


def _votes_in(
    asked: Int64[np.ndarray, " k"],
    cells: Int64[np.ndarray, " c"],
    votes: Float64[np.ndarray, " c"],
) -> Float64[np.ndarray, " k"]:
    """What was counted in each cell asked for; `cells` are sorted, and others have nothing."""
    at = np.minimum(np.searchsorted(cells, asked), len(cells) - 1)
    return np.where(cells[at] == asked, votes[at], 0.0)


def _sphere(surface: Surface, middle: Vector3, radius: float) -> ProbedBody | None:
    """The least-squares sphere from a start; None where too little of it was measured."""
    nominal, gate = radius, _NEAR
    for _ in range(_ROUNDS):
        arms = surface.vertices_mm - middle
        near = _faces_away(surface, arms, radius, gate) & surface.measured
        if near.sum() < 10:
            return None
        middle, radius = _gauss_sphere(surface, near, middle, radius)
        if not 0.5 * nominal < radius < 2 * nominal:
            return None
        gate = _NEAR_REFINED
    arms = surface.vertices_mm - middle
    off = np.linalg.norm(arms, axis=1) - radius
    area = 4 * np.pi * radius**2
    counts = _inner_vertices(surface, off, _faces_away(surface, arms, radius, gate), radius, area)
    seen = float(surface.areas_mm2[counts].sum() / area)
    if seen < _LEAST_SEEN:
        return None
    middle, radius = _gauss_sphere(surface, counts, middle, radius)
    off = np.linalg.norm(surface.vertices_mm[counts] - middle, axis=1) - radius
    return _probed_body(surface, counts, off, middle, None, radius, seen)


def _cylinder(surface: Surface, middle: Vector3, axis: Vector3, radius: float) -> ProbedBody | None:
    """The least-squares cylinder from a start; None where too little of it was measured."""
    nominal, gate = radius, _NEAR
    for _ in range(_ROUNDS):
        arms = _parts_across(surface.vertices_mm - middle, axis)
        near = _faces_away(surface, arms, radius, gate) & surface.measured
        if near.sum() < 10:
            return None
        middle, axis, radius = _gauss_cylinder(surface, near, middle, axis, radius)
        if not 0.5 * nominal < radius < 2 * nominal:
            return None
        gate = _NEAR_REFINED
    arms = _parts_across(surface.vertices_mm - middle, axis)
    on = _faces_away(surface, arms, radius, gate)
    along = (surface.vertices_mm[on] - middle) @ axis
    if len(along) < 10:
        return None
    area = 2 * np.pi * radius * float(np.ptp(along))
    off = np.linalg.norm(arms, axis=1) - radius
    counts = _inner_vertices(surface, off, on, radius, area)
    if counts.sum() < 10:
        return None
    middle, axis, radius = _gauss_cylinder(surface, counts, middle, axis, radius)
    across = _parts_across(surface.vertices_mm[counts] - middle, axis)
    seen = _turn_seen(across, axis)
    if seen < _LEAST_SEEN:
        return None
    off = np.linalg.norm(across, axis=1) - radius
    return _probed_body(surface, counts, off, middle, axis, radius, seen)


def _faces_away(
    surface: Surface, arms: Points3, radius: float, gate: float
) -> Bool[np.ndarray, " n"]:
    """Which vertices lie near the radius and face away; arms: from the centre or the axis."""
    far = np.linalg.norm(arms, axis=1)
    outward = np.einsum("nc,nc->n", arms, surface.normals) / np.maximum(far, 1e-12)
    return (np.abs(far - radius) < gate * radius) & (outward > _LEAST_COSINE)


def _inner_vertices(
    surface: Surface,
    off: Float64[np.ndarray, " n"],
    on: Bool[np.ndarray, " n"],
    radius: float,
    area_mm2: float,
) -> Bool[np.ndarray, " n"]:
    """The measured vertices of the body, without the strip along the borders at which it ends."""
    outside = ~on
    label = components_among(outside, surface.edges)
    areas = np.bincount(label, surface.areas_mm2[outside])
    reach = np.zeros(len(areas))
    np.maximum.at(reach, label, np.abs(off[outside]))
    leaves = (areas > _OUTLIER_SHARE * area_mm2) | (reach > _NEAR * radius)
    elsewhere = np.zeros(len(on), bool)
    elsewhere[outside] = leaves[label]
    counts = ~elsewhere & surface.measured & (np.abs(off) < _NEAR * radius)
    if elsewhere.any() and counts.any():
        strip_mm = max(_STRIP * radius, _STRIP_MM)
        near = np.flatnonzero(elsewhere & (np.abs(off) < radius))
        if len(near):
            tree = KDTree(surface.vertices_mm[near])
            mine = np.flatnonzero(counts)
            counts[mine] = tree.query(surface.vertices_mm[mine])[0] > strip_mm
    return _largest_patch(surface, counts)


def _largest_patch(surface: Surface, counts: Bool[np.ndarray, " n"]) -> Bool[np.ndarray, " n"]:
    """The vertices without small pieces that lie near the body by chance."""
    if not counts.any():
        return counts
    label = components_among(counts, surface.edges)
    areas = np.bincount(label, surface.areas_mm2[counts])
    kept = counts.copy()
    kept[counts] = areas[label] > 0.05 * areas.max()
    return kept


def _gauss_sphere(
    surface: Surface, which: Bool[np.ndarray, " n"], middle: Vector3, radius: float
) -> tuple[Vector3, float]:
    """A sphere by least squares of the distances (Gauss-Newton)."""
    points, weights = surface.vertices_mm[which], np.sqrt(surface.areas_mm2[which])
    for _ in range(20):
        arms = points - middle
        far = np.linalg.norm(arms, axis=1)
        columns = np.column_stack([-arms / far[:, None], -np.ones(len(far))])
        step = np.linalg.lstsq(columns * weights[:, None], -(far - radius) * weights, rcond=None)[0]
        middle, radius = middle + step[:3], radius + float(step[3])
        if np.abs(step).max() < 1e-10 * radius:
            break
    return middle, radius


def _gauss_cylinder(
    surface: Surface, which: Bool[np.ndarray, " n"], middle: Vector3, axis: Vector3, radius: float
) -> tuple[Vector3, Vector3, float]:
    """A cylinder by least squares: two numbers for its place, two for its axis, its radius."""
    points, weights = surface.vertices_mm[which], np.sqrt(surface.areas_mm2[which])
    middle = middle + axis * float(axis @ (np.average(points, axis=0) - middle))
    for _ in range(30):
        one, two = axes_across(axis)
        arms = points - middle
        along = arms @ axis
        across = _parts_across(arms, axis)
        far = np.linalg.norm(across, axis=1)
        out = across / far[:, None]
        columns = np.column_stack(
            [-out @ one, -out @ two, -along * (out @ one), -along * (out @ two), -np.ones(len(far))]
        )
        step = np.linalg.lstsq(columns * weights[:, None], -(far - radius) * weights, rcond=None)[0]
        middle = middle + step[0] * one + step[1] * two
        axis = axis + step[2] * one + step[3] * two
        axis = axis / np.linalg.norm(axis)
        radius += float(step[4])
        if np.abs(step).max() < 1e-11 * radius:
            break
    return middle, axis, radius


def _axis_among(surface: Surface, radius: float) -> tuple[Vector3, Vector3] | None:
    """A point on the axis and its direction: the pair of vertices with which most area agrees."""
    rng = np.random.default_rng(0)
    measured = np.flatnonzero(surface.measured)
    chosen = measured[:: max(1, len(measured) // _TRIED_POINTS)]
    points, normals = surface.vertices_mm[chosen], surface.normals[chosen]
    areas = surface.areas_mm2[chosen]
    steps = points - radius * normals
    best, most = None, 0.0
    for first, second in rng.integers(0, len(chosen), (_PAIRS, 2)):
        axis = np.cross(normals[first], normals[second])
        sine = float(np.linalg.norm(axis))
        if sine < 0.2:
            continue
        axis = axis / sine
        middle = (steps[first] + steps[second]) / 2
        if (
            np.linalg.norm(_parts_across((steps[first] - steps[second])[None], axis))
            > _NEAR * radius
        ):
            continue
        far = np.linalg.norm(_parts_across(steps - middle, axis), axis=1)
        agree = (far < _NEAR * radius) & (np.abs(normals @ axis) < 0.2)
        share = float(areas[agree].sum())
        if share > most:
            best, most = (middle, axis), share
    return best


def _parts_across(arms: Points3, axis: Vector3) -> Points3:
    """The parts square to an axis."""
    return arms - (arms @ axis)[:, None] * axis


def _turn_seen(across: Points3, axis: Vector3) -> float:
    one, two = axes_across(axis)
    turn = np.arctan2(across @ two, across @ one)
    sectors = np.floor((turn / (2 * np.pi) + 0.5) * _SECTORS).astype(int) % _SECTORS
    return len(np.unique(sectors)) / _SECTORS


def _probed_body(
    surface: Surface,
    counts: Bool[np.ndarray, " n"],
    off: Float64[np.ndarray, " k"],
    middle: Vector3,
    axis: Vector3 | None,
    radius: float,
    seen: float,
) -> ProbedBody:
    return ProbedBody(
        middle_mm=middle,
        axis=axis,
        diameter_mm=2 * radius,
        form_mm=float(np.ptp(off)),
        form_95_mm=narrowest_mm(off, surface.areas_mm2[counts], _HOLDS),
        points=len(off),
        seen=min(seen, 1.0),
        vertices=np.flatnonzero(counts),
        off_mm=off,
    )


def narrowest_mm(
    off: Float64[np.ndarray, " k"], areas: Float64[np.ndarray, " k"], share: float
) -> float:
    """Width of the narrowest shell that holds this share of the area."""
    order = np.argsort(off, kind="stable")
    sorted_off, total = off[order], np.concatenate([[0.0], np.cumsum(areas[order])])
    ends = np.searchsorted(total, total[:-1] + share * total[-1] * (1 - 1e-12))
    fits = ends <= len(off)
    return float((sorted_off[ends[fits] - 1] - sorted_off[fits]).min())
