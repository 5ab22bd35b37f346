"""Thickness: how thick a device is at each place: as printed, or as a sheet becomes when draped.

Printed  a base thickness, with zones and ribs added that fall off smoothly at their borders.
Draped   a flat sheet becomes the positive by stretching the same in all directions at each place.
         Then the logarithm u of the stretch solves a Poisson equation with the surface's curvature,
         nothing where the sheet leaves the positive; it keeps its volume, so it is as thick as
         before divided by the stretch of area, exp(2 u). A hemisphere whose rim is held would keep
         a quarter of the sheet at its top. Soft sheets are not held: they draw in from around, over
         a length that screens the equation, u + L (-Laplace) u = L curvature with L its square. It
         is nowhere thicker than the sheet. A model, no measure: sheets also slide, sag and cool.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from scipy import sparse
from scipy.sparse.linalg import splu

from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.polyline import distances_along, resampled
from limbgram.core.mesh.mesh import Mesh, lengths
from limbgram.core.mesh.topology import boundary_half_edges
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.workbench.anatomy.surface_lines import smoothstep
from limbgram.workbench.devices.layout import CoveredArea, Rib
from limbgram.workbench.edits.regions import distances_from, distances_from_point

_SHEET_OVERLAP_MM = 15.0
"""The sheet lies on the positive up to this far beyond the device's edges."""
_LEAST_COTANGENT, _MOST_COTANGENT = 0.05, 20.0
_LINE_STEP_MM = 1.0


@dataclass(frozen=True, kw_only=True)
class Zone:
    """A round zone in which the wall is thicker or thinner."""

    middle_mm: Vector3
    reach_mm: float
    """Radius of the part at full height."""
    falloff_mm: float
    """Distance over which it falls to zero."""
    add_mm: float


def printed_thickness(
    covered: CoveredArea, base_mm: float, zones: Sequence[Zone] = (), ribs: Sequence[Rib] = ()
) -> Float64[np.ndarray, " n"]:
    """Thickness of a printed wall at each vertex."""
    mesh = covered.positive
    thick = np.full(len(mesh), base_mm)
    for zone in zones:
        away = distances_from_point(mesh, zone.middle_mm, zone.reach_mm + zone.falloff_mm)
        thick += zone.add_mm * (1 - smoothstep((away - zone.reach_mm) / zone.falloff_mm))
    for rib in ribs:
        half = 0.5 * rib.width_mm
        away = _distance_from_line(mesh, rib.line_mm, half + rib.falloff_mm)
        thick += rib.add_mm * (1 - smoothstep((away - half) / rib.falloff_mm))
    return thick


def draped_thickness(
    covered: CoveredArea, sheet_mm: float, draw_mm: float = np.inf
) -> Float64[np.ndarray, " n"]:
    """Thickness at each vertex of a sheet after draping.

    Args:
        draw_mm: Length over which the soft sheet draws in; infinite if it is held at its edge.
    """
    mesh = covered.positive
    on_it = covered.beyond_mm < _SHEET_OVERLAP_MM
    on_it[boundary_half_edges(mesh.faces)] = False
    curvature = _angle_defects(mesh)
    weights = _cotangent_laplacian(mesh) + sparse.diags_array(mesh.vertex_areas_mm2() / draw_mm**2)
    stretch = np.zeros(len(mesh))
    free = np.flatnonzero(on_it)
    system = sparse.csc_array(sparse.csr_array(weights)[free][:, free])
    # The flat sheet's metric is exp(-2 u) times the surface's: its curvature 0 is K + Laplace u.
    stretch[free] = splu(system).solve(curvature[free])
    return sheet_mm * np.exp(-2 * np.maximum(stretch, 0.0))


def _distance_from_line(
    mesh: Mesh, line_mm: Float64[np.ndarray, "k 3"], limit_mm: float
) -> Float64[np.ndarray, " n"]:
    """Distance of each vertex over the surface from an open polyline on it."""
    dense = resampled(line_mm, max(2, int(distances_along(line_mm)[-1] / _LINE_STEP_MM)))
    faces = mesh.faces[np.unique(tree_on(mesh).closest(dense).faces)]
    first = np.unique(faces)
    start = np.full(len(mesh), np.inf)
    start[first] = _distance_to_polyline(mesh.vertices_mm[first], dense)
    return distances_from(mesh, start, np.ones(len(mesh), np.bool_), limit_mm)


def _distance_to_polyline(
    points: Points3, line: Float64[np.ndarray, "m 3"]
) -> Float64[np.ndarray, " n"]:
    """Distance of points from a polyline, straight through space."""
    start, way = line[:-1], np.diff(line, axis=0)
    size = np.maximum((way * way).sum(1), 1e-30)
    share = np.clip(((points[:, None] - start) * way).sum(2) / size, 0.0, 1.0)
    foot = start + share[..., None] * way
    return np.linalg.norm(points[:, None] - foot, axis=2).min(1)


def _angle_defects(mesh: Mesh) -> Float64[np.ndarray, " n"]:
    """Angle defect at each vertex: its Gaussian curvature times its area."""
    corners = mesh.vertices_mm[mesh.faces]
    lack = np.full(len(mesh), 2 * np.pi)
    for k in range(3):
        one = corners[:, (k + 1) % 3] - corners[:, k]
        two = corners[:, (k + 2) % 3] - corners[:, k]
        angle = np.arctan2(lengths(np.cross(one, two)), (one * two).sum(1))
        lack -= np.bincount(mesh.faces[:, k], angle, len(mesh))
    return lack


def _cotangent_laplacian(mesh: Mesh) -> sparse.csr_array:
    """The cotangent Laplacian, positive on its diagonal (Pinkall and Polthier 1993)."""
    corners = mesh.vertices_mm[mesh.faces]
    count = len(mesh)
    total = sparse.csr_array((count, count))
    for k in range(3):
        one = corners[:, (k + 1) % 3] - corners[:, k]
        two = corners[:, (k + 2) % 3] - corners[:, k]
        double = np.maximum(lengths(np.cross(one, two)), 1e-12)
        half = 0.5 * np.clip((one * two).sum(1) / double, _LEAST_COTANGENT, _MOST_COTANGENT)
        i, j = mesh.faces[:, (k + 1) % 3], mesh.faces[:, (k + 2) % 3]
        total = total - sparse.csr_array((half, (i, j)), shape=(count, count))
    total = total + total.T
    sums = np.asarray(total.sum(1)).ravel()
    return sparse.csr_array(total - sparse.diags_array(sums))
