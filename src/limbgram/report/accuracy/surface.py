"""The surface: how complete it is, what is open, how many photos see it, how sure it is.

Around     How much of the limb is missing, seen from its own middle. Every height has a middle of
           its own, that of the circle through what was measured there: it lies where the limb's
           axis is even if only one side was measured, where a centre of gravity would move towards
           that side and see half of the gap. Directions are level ones: the way up is that of the
           board's plane or of the photos, so the sole of a standing foot and the brim of a cast
           are not asked for. An open rim counts by the surface that would be needed to close it.
"""

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float64, Int32, Int64
from scipy.spatial import ConvexHull, QhullError
from scipy.special import erf

from limbgram.core.geometry.arrays import Points2, Points3
from limbgram.core.geometry.lens import View
from limbgram.core.interval import weighted_quantile
from limbgram.core.mesh.mesh import Mesh, Part
from limbgram.core.mesh.topology import boundary_half_edges, components
from limbgram.reconstruction.measuring.visibility import incidence_cosines
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.accuracy.figures import (
    Around,
    Opening,
    OtherBody,
    PhotosPerPlace,
    SurfaceFigures,
    SurfaceSigma,
)

_HEIGHTS = 30
_DIRECTIONS = 60
_FRINGE = 0.02
"""Share of the area that is left out at either end: a slanted brim is no gap."""
_LEAST_POINTS = 8
_FARTHEST = 1.0
"""A circle wider than the whole shape is none; the middle of what is there is taken instead."""
_ON_FLOOR = 0.05
"""A rim this near to the floor, in heights of the shape, is where the shape stands on it."""
_SLANTED = 1.25
"""A brim may be this much larger than the widest level section, being cut at a slant."""
_STEEPEST_DEG = 65.0
"""A photo that looks more closely along the surface than this hardly measures it."""
_RAY_VERTICES = 20_000
_SURFACE_BINS = 50
_SHOWN_QUANTILE = 0.995
_MOST_OPENINGS = 5
_BISECTIONS = 50
UNNAMED = "shared by all vertices"
"""What a shared source is called where the mesh does not tell."""


def surface_figures(evidence: Evidence) -> SurfaceFigures:
    """Completeness, openings, photos per place, and sigma."""
    mesh = evidence.mesh
    areas = mesh.vertex_areas_mm2()
    measured = mesh.measured
    repairs = mesh.repairs
    return SurfaceFigures(
        vertices=len(mesh),
        faces=len(mesh.faces),
        size=tuple(np.ptp(mesh.vertices_mm, axis=0).tolist()),
        height_from=float(mesh.vertices_mm[:, 2].min()),
        area=float(areas.sum()),
        measured_share=_area_share(measured, areas),
        filled_share=_area_share(~measured, areas),
        left_out_share=0.0 if repairs is None else repairs.island_share,
        other_parts=() if repairs is None else tuple(_other_body(one) for one in repairs.others),
        part_given=repairs is not None and repairs.part_given,
        holes_filled=0 if repairs is None else repairs.holes_filled,
        openings=openings(mesh),
        around=around_figures(mesh, evidence.metric.floor_z_mm),
        photos_per_place=_photos_per_place(mesh, evidence.metric.scene.views),
        sigma=_sigma_figures(mesh, areas),
    )


def _other_body(part: Part) -> OtherBody:
    return OtherBody(number=part.number, relation=part.relation, area=part.area_mm2)


def openings(mesh: Mesh) -> tuple[Opening, ...]:
    """The largest openings: length of the rim, and where its middle is."""
    border = boundary_half_edges(mesh.faces)
    if not np.array_equal(np.sort(border[:, 0]), np.unique(border[:, 1])):
        return ()  # rims that touch or branch: no loops to tell
    following = np.zeros(len(mesh), np.int64)
    following[border[:, 0]] = border[:, 1]
    found: list[Opening] = []
    left = set(border[:, 0].tolist())
    while left:
        loop = [left.pop()]
        while (vertex := int(following[loop[-1]])) in left:
            left.remove(vertex)
            loop.append(vertex)
        rim = mesh.vertices_mm[loop]
        sides = np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1)
        found.append(Opening(rim=float(sides.sum()), middle=tuple(rim.mean(0).tolist())))
    return tuple(sorted(found, key=lambda one: -one.rim)[:_MOST_OPENINGS])


def _area_share(chosen: np.ndarray, areas: Float64[np.ndarray, " n"]) -> float:
    total = float(areas.sum())
    return float(areas[chosen].sum()) / total if total > 0 else math.nan


def _photos_per_place(mesh: Mesh, views: Sequence[View]) -> PhotosPerPlace:
    """Photos that see a place under `_STEEPEST_DEG` or squarer; some vertices stand for all."""
    step = max(1, len(mesh) // _RAY_VERTICES)
    number = (incidence_cosines(mesh, views, _STEEPEST_DEG, step) > 0).sum(1)
    return PhotosPerPlace(
        median=float(np.median(number)),
        below_3_share=float(np.mean(number < 3)),
        places=tuple(np.bincount(number).tolist()),
    )


def _sigma_figures(mesh: Mesh, areas: Float64[np.ndarray, " n"]) -> SurfaceSigma | None:
    """Sigma figures along the normal of the measured surface; None where there are no sigmas."""
    if mesh.sigma_mm is None:
        return None
    known = np.isfinite(mesh.sigma_mm) & mesh.measured & (areas > 0)
    if not known.any():
        return None
    sigmas, weights = mesh.sigma_mm[known].astype(np.float64), areas[known]
    weights = weights / weights.sum()
    shares = _shared_sigmas(mesh, known, weights)
    shared = math.hypot(*shares.values())
    total = float(np.sqrt(weights @ sigmas**2))
    reach = float(np.quantile(sigmas, _SHOWN_QUANTILE))
    edges = np.linspace(0.0, reach, _SURFACE_BINS + 1)
    area_share = np.histogram(np.minimum(sigmas, reach), edges, weights=weights)[0]
    return SurfaceSigma(
        rms_mm=total,
        median_mm=weighted_quantile(sigmas, weights, 0.5),
        p95_mm=weighted_quantile(sigmas, weights, 0.95),
        shared_rms_mm=shared,
        shares_mm=shares,
        own_rms_mm=float(np.sqrt(max(total**2 - shared**2, 0.0))),
        correlation_mm=math.nan if mesh.correlation_mm is None else mesh.correlation_mm,
        expected_error_p95_mm=expected_p95(sigmas, weights),
        edges_mm=tuple(edges.tolist()),
        area_share=tuple(area_share.tolist()),
    )


def _shared_sigmas(
    mesh: Mesh, known: Bool[np.ndarray, " n"], weights: Float64[np.ndarray, " k"]
) -> dict[str, float]:
    """RMS over the area of what each shared source does to the surface, by the source's name."""
    if mesh.shared_mm is None:
        return {}
    energies = weights @ mesh.shared_mm[known].astype(np.float64) ** 2
    names = mesh.shared_sources or len(energies) * (UNNAMED,)
    return {
        name: float(np.sqrt(sum(e for e, of in zip(energies, names, strict=True) if of == name)))
        for name in dict.fromkeys(names)
    }


def expected_p95(sigmas: Float64[np.ndarray, " n"], weights: Float64[np.ndarray, " n"]) -> float:
    """Error within which 95 % of the surface is expected, its errors being Gaussian."""
    low, high = 0.0, 4.0 * float(sigmas.max())
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        inside = erf(middle / np.maximum(sigmas, 1e-12) / np.sqrt(2))
        low, high = (middle, high) if float(weights @ inside) < 0.95 else (low, middle)
    return (low + high) / 2


def around_figures(mesh: Mesh, floor_z: float | None) -> Around:
    """Directions without measured surface, the widest gap, and what is open beyond one brim."""
    measured = mesh.measured
    faces = mesh.faces[measured[mesh.faces].any(1)]
    corners = np.unique(faces)
    corners = corners[measured[corners]]
    places = np.concatenate([mesh.vertices_mm[faces].mean(1), mesh.vertices_mm[corners]])
    if len(places) < _LEAST_POINTS:
        return Around(missing_share=math.nan, widest_gap_deg=math.nan, open_share=0.0)
    low, high = np.quantile(places[:, 2], (_FRINGE, 1 - _FRINGE))
    inside = (places[:, 2] >= low) & (places[:, 2] <= high)
    places = places[inside]
    height = ((places[:, 2] - low) / max(high - low, 1e-12) * _HEIGHTS).astype(np.int64)
    height = np.minimum(height, _HEIGHTS - 1)
    seen = _has_surface(places[:, :2], height)
    return Around(
        missing_share=float(1 - seen.mean()),
        widest_gap_deg=float(np.median([_widest_gap(row) for row in seen])),
        open_share=_open_share(mesh, floor_z, _widest_section(places[:, :2], height)),
    )


def _has_surface(xy: Points2, height: Int64[np.ndarray, " n"]) -> Bool[np.ndarray, "h d"]:
    """Whether there is surface at a height in a direction from the middle there."""
    away = xy - _section_centres(xy, height)[height]
    turn = np.arctan2(away[:, 1], away[:, 0]) / (2 * np.pi) % 1.0
    cell = height * _DIRECTIONS + np.minimum((turn * _DIRECTIONS).astype(np.int64), _DIRECTIONS - 1)
    count = np.bincount(cell, minlength=_HEIGHTS * _DIRECTIONS)
    return count.reshape(_HEIGHTS, _DIRECTIONS) > 0


def _section_centres(
    xy: Points2, height: Int64[np.ndarray, " n"]
) -> Float64[np.ndarray, "heights 2"]:
    """Middle of the circle through the points of each height (Kasa 1976), of all heights at once.

    x^2 + y^2 = 2 a x + 2 b y + c is linear in the middle (a, b).
    """
    origin = xy.mean(0)
    x, y = (xy - origin).T
    terms = np.stack([x, y, np.ones_like(x)], axis=1)
    square = x * x + y * y

    def summed(values: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, " h"]:
        return np.bincount(height, values, _HEIGHTS)

    normal = np.stack(
        [np.stack([summed(terms[:, i] * terms[:, j]) for j in range(3)], 1) for i in range(3)], 1
    )
    right = np.stack([summed(terms[:, i] * square) for i in range(3)], 1)
    solved = (np.linalg.pinv(normal, rcond=1e-10) @ right[..., None])[..., 0]
    middle = solved[:, :2] / 2
    squared_radius = solved[:, 2] + (middle**2).sum(1)
    number = np.maximum(summed(np.ones_like(x)), 1)
    plain = np.stack([summed(x) / number, summed(y) / number], 1)
    size = float(np.ptp(xy, axis=0).max())
    good = (squared_radius > 0) & (squared_radius < (_FARTHEST * size) ** 2)
    return origin + np.where(good[:, None], middle, plain)


def _widest_gap(seen: Bool[np.ndarray, " d"]) -> float:
    """The widest run of directions without surface, in degrees."""
    if not seen.any():
        return 360.0
    there = np.flatnonzero(seen)
    steps = np.diff(np.append(there, there[0] + len(seen))) - 1
    return float(steps.max() * 360.0 / len(seen))


def _widest_section(xy: Points2, height: Int64[np.ndarray, " n"]) -> float:
    """Area within a tape round the shape, at the height where that is largest."""
    order = np.argsort(height, kind="stable")
    found = [0.0]
    for part in np.split(xy[order], np.flatnonzero(np.diff(height[order])) + 1):
        try:
            found.append(float(ConvexHull(part).volume))  # of two dimensions: its area
        except (QhullError, ValueError):
            continue  # too few points, or all on a line: no section
    return max(found)


def _open_share(mesh: Mesh, floor_z: float | None, section: float) -> float:
    """Area that would close all rims but one brim, as a share of the closed surface."""
    border = boundary_half_edges(mesh.faces)
    if not len(border):
        return 0.0
    rim = components(border, len(mesh))[border[:, 0]]
    _, rim = np.unique(rim, return_inverse=True)
    open_area = _rim_fan_areas(mesh.vertices_mm, border, rim)
    if floor_z is not None:
        z = mesh.vertices_mm[:, 2]
        top = np.full(len(open_area), -np.inf)
        np.maximum.at(top, rim, z[border[:, 0]])
        open_area = open_area[top > floor_z + _ON_FLOOR * (z.max() - floor_z)]
    brim = min(float(open_area.max(initial=0.0)), _SLANTED * section)
    beyond = float(open_area.sum()) - brim
    surface = float(np.linalg.norm(mesh.face_normals(), axis=1).sum()) / 2
    return beyond / (surface + beyond + brim)


def _rim_fan_areas(
    vertices: Points3, border: Int32[np.ndarray, "b 2"], rim: Int64[np.ndarray, " b"]
) -> Float64[np.ndarray, " r"]:
    """Area of triangles from each rim's middle to its edges."""
    number = np.maximum(np.bincount(rim), 1)
    first, second = vertices[border[:, 0]], vertices[border[:, 1]]
    middle = np.stack([np.bincount(rim, first[:, k]) / number for k in range(3)], 1)[rim]
    twice = np.linalg.norm(np.cross(first - middle, second - middle), axis=1)
    return np.bincount(rim, twice) / 2
