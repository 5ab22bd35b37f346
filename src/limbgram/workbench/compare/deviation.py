"""Deviation: how far two surfaces lie apart, at every vertex of both, and how their normals turn.

Differences are positive where the second surface lies outside the first, on both maps. Places that
were filled in, lie near a brim, or whose nearest place is a brim, have no figure (NaN). Averages
are by area, so that they do not depend on how finely a surface is cut into triangles. Samples are
spread evenly over a surface, the same each time.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.workbench.compare.counterparts import CounterpartSurface, measured_vertices

_STEPS = (0.7548776662466927, 0.5698402909980532)
"""Of the plane's evenly filling sequence (Roberts 2018): powers of 1 over the plastic number."""
LOCAL_LIMIT_MM = 1.0
"""Beyond it a place counts as different, whatever the averages say."""


@dataclass(frozen=True, kw_only=True)
class Samples:
    """Places on a surface, each standing for the same area."""

    points_mm: Points3
    normals: Points3
    """Unit, interpolated between the vertices' normals."""
    faces: Int64[np.ndarray, " n"]


@dataclass(frozen=True, kw_only=True)
class DistanceFigures:
    """Summary figures of a map of differences, in mm."""

    mean_mm: float
    mean_abs_mm: float
    rms_mm: float
    p95_mm: float
    """Of the absolute differences."""
    largest_mm: float
    far_mm2: float
    """Area that lies farther than LOCAL_LIMIT_MM from the other surface."""
    compared_share: float
    """Of the surface's area: the rest has no counterpart."""


@dataclass(frozen=True, kw_only=True)
class DifferenceMap:
    """Differences and angles of normals at the vertices of one surface."""

    difference_mm: Float64[np.ndarray, " n"]
    """Second less first; NaN where there is no counterpart."""
    normal_angle_deg: Float64[np.ndarray, " n"]
    """Between the normals of the vertex and of its counterpart."""
    figures: DistanceFigures


@dataclass(frozen=True, kw_only=True)
class Deviation:
    """The deviation of two surfaces from each other, both ways."""

    on_first: DifferenceMap
    on_second: DifferenceMap
    hausdorff95_mm: float
    """The larger of both 95th percentiles."""
    snae_mean_deg: float
    """Surface-normal-angle error: mean over the first surface."""
    snae_p95_deg: float


def deviation(first: Mesh, second: Mesh, brim_mm: float) -> Deviation:
    """Compare two surfaces that lie in one frame.

    Raises:
        MeasureError: no place of one has a counterpart on the other.
    """
    grounds = CounterpartSurface.of(first, brim_mm), CounterpartSurface.of(second, brim_mm)
    on_first = _map(first, grounds[1], brim_mm, sign=-1.0)
    on_second = _map(second, grounds[0], brim_mm, sign=1.0)
    angles, areas = on_first.normal_angle_deg, first.vertex_areas_mm2()
    known = np.isfinite(angles)
    return Deviation(
        on_first=on_first,
        on_second=on_second,
        hausdorff95_mm=max(on_first.figures.p95_mm, on_second.figures.p95_mm),
        snae_mean_deg=float(np.average(angles[known], weights=areas[known])),
        snae_p95_deg=area_quantile(angles[known], areas[known], 0.95),
    )


def sample_evenly(mesh: Mesh, count: int) -> Samples:
    """`count` places in the order of the faces, by area."""
    areas = np.linalg.norm(mesh.face_normals(), axis=1)
    reach = np.cumsum(areas)
    places = (np.arange(count) + 0.5) / count * reach[-1]
    faces = np.minimum(np.searchsorted(reach, places), len(areas) - 1)
    u, v = ((0.5 + step * np.arange(count)) % 1.0 for step in _STEPS)
    beyond = u + v > 1
    u, v = np.where(beyond, 1 - u, u), np.where(beyond, 1 - v, v)
    weights = np.column_stack([1 - u - v, u, v])
    corners = mesh.faces[faces]
    normals = np.einsum("nk,nkc->nc", weights, mesh.vertex_normals()[corners])
    return Samples(
        points_mm=np.einsum("nk,nkc->nc", weights, mesh.vertices_mm[corners]),
        normals=unit(normals),
        faces=faces.astype(np.int64),
    )


def area_quantile(
    values: Float64[np.ndarray, " n"], areas_mm2: Float64[np.ndarray, " n"], share: float
) -> float:
    """Value below which this share of the area lies."""
    order = np.argsort(values, kind="stable")
    reach = np.cumsum(areas_mm2[order]) - areas_mm2[order] / 2
    return float(np.interp(share * areas_mm2.sum(), reach, values[order]))


def _map(mesh: Mesh, ground: CounterpartSurface, brim_mm: float, *, sign: float) -> DifferenceMap:
    """The map of differences of a mesh; sign is 1 if it is the second surface, -1 if the first."""
    found = ground.counterparts(mesh.vertices_mm)
    own = mesh.vertex_normals()
    areas = mesh.vertex_areas_mm2()
    valid = measured_vertices(mesh, brim_mm) & ~found.at_brim & found.measured & (areas > 0)
    if not valid.any():
        raise MeasureError("compare.surface.no_counterpart")
    difference = np.where(valid, sign * found.signed_mm, np.nan)
    cosine = np.einsum("nc,nc->n", own, found.smooth_normals)
    sine = np.linalg.norm(np.cross(own, found.smooth_normals), axis=1)
    angle = np.where(valid, np.degrees(np.arctan2(sine, cosine)), np.nan)
    known, weights = difference[valid], areas[valid]
    figures = DistanceFigures(
        mean_mm=float(np.average(known, weights=weights)),
        mean_abs_mm=float(np.average(np.abs(known), weights=weights)),
        rms_mm=float(np.sqrt(np.average(known**2, weights=weights))),
        p95_mm=area_quantile(np.abs(known), weights, 0.95),
        largest_mm=float(np.abs(known).max()),
        far_mm2=float(weights[np.abs(known) > LOCAL_LIMIT_MM].sum()),
        compared_share=float(weights.sum() / areas.sum()),
    )
    return DifferenceMap(difference_mm=difference, normal_angle_deg=angle, figures=figures)
