"""The long axis: a line through the centroids of cross-sections, iterated until it stays.

In      a mesh, in any pose.
Out     an Axis in the mesh's frame.
Method  the normals' covariance gives a first direction; a robust line through the centroids of the
        sections across it gives the next one. Ends, caps and brim are left out.
Fails   MeasureError: no direction is longer than the others, or too few whole sections.

Centroids are summed over the crossed faces in mesh order, not along chained sections
(`sections.cut`), so that the limb frames of kept files are reproduced to the last digit.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int32, Int64

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.interval import rms
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_half_edges

_MOST_ITERATIONS = 100
_CONVERGED = 1e-9
"""Sine of the angle between the directions of two iterations."""
_SECTIONS, _LEAST_SECTIONS = 40, 8
_END_SHARE = 0.12
"""Share of the length that is left out at either end."""
_ROUNDEST = 0.75
"""Largest ratio of the first to the second eigenvalue of the normals' covariance."""
_HUBER = 1.5
"""Residuals beyond this many medians lose weight (Huber)."""


@dataclass(frozen=True, kw_only=True)
class Axis:
    """A line in the mesh's frame."""

    point_mm: Vector3
    """Centre of the fitted centroids."""
    direction: Vector3
    """Unit; either sense."""
    spread_mm: float
    """Root mean square distance of the centroids from the line."""


def fit_axis(mesh: Mesh) -> Axis:
    """The long axis of a limb.

    Raises:
        MeasureError: the shape has no long axis, or too little whole wall to fit one.
    """
    border = boundary_half_edges(mesh.faces)
    axis = _along(mesh, border, _first_direction(mesh))
    for _ in range(_MOST_ITERATIONS):
        before, axis = axis, _line_through(_centroids(mesh, border, axis.direction))
        if np.linalg.norm(np.cross(axis.direction, before.direction)) < _CONVERGED:
            break
    return axis


def axis_along(mesh: Mesh, direction: Vector3) -> Axis:
    """The line of a stated direction through the centroids of the sections across it."""
    return _along(mesh, boundary_half_edges(mesh.faces), direction)


def _along(mesh: Mesh, border: Int32[np.ndarray, "b 2"], direction: Vector3) -> Axis:
    unit = direction / np.linalg.norm(direction)
    centroids = _centroids(mesh, border, unit)
    point = np.median(centroids, axis=0)
    off = (centroids - point) - np.outer((centroids - point) @ unit, unit)
    return Axis(point_mm=point, direction=unit, spread_mm=rms(off))


def _first_direction(mesh: Mesh) -> Vector3:
    """The direction to which the surface's normals are most nearly perpendicular."""
    doubled = mesh.face_normals()
    area = np.maximum(np.linalg.norm(doubled, axis=1, keepdims=True), 1e-300)
    eigenvalues, directions = np.linalg.eigh((doubled / area).T @ doubled)
    if eigenvalues[0] > _ROUNDEST * eigenvalues[1]:
        raise MeasureError("mesh.axis.round")
    return directions[:, 0]


def _centroids(mesh: Mesh, border: Int32[np.ndarray, "b 2"], direction: Vector3) -> Points3:
    """Centroids of the sections across a direction that do not run into an open edge."""
    along = mesh.vertices_mm @ direction
    rim = np.sort(along[border], axis=1)
    low, high = _whole_span(rim, (float(along.min()), float(along.max())))
    left_out = _END_SHARE * (high - low)
    corners = along[mesh.faces]
    lowest = np.minimum(np.minimum(corners[:, 0], corners[:, 1]), corners[:, 2])
    highest = np.maximum(np.maximum(corners[:, 0], corners[:, 1]), corners[:, 2])
    centroids: list[Vector3] = []
    for offset in np.linspace(low + left_out, high - left_out, _SECTIONS):
        if ((rim[:, 0] < offset) & (rim[:, 1] >= offset)).any():
            continue
        crossed = np.flatnonzero((lowest < offset) & (highest >= offset))
        if not len(crossed):  # a gap between two pieces
            continue
        centroids.append(_centroid(mesh, crossed, corners[crossed] - offset, direction))
    if len(centroids) < _LEAST_SECTIONS:
        raise MeasureError(
            "mesh.axis.few_sections",
            whole=len(centroids),
            sections=_SECTIONS,
            least=_LEAST_SECTIONS,
        )
    return np.stack(centroids)


def _whole_span(
    border: Float64[np.ndarray, "b 2"], ends: tuple[float, float]
) -> tuple[float, float]:
    """The span between the open brims at either end, if it is a third of the whole or more."""
    low, high = ends
    middle = (low + high) / 2
    top = float(border[border > middle].min(initial=high))
    bottom = float(border[border <= middle].max(initial=low))
    return (bottom, top) if top - bottom > (high - low) / 3 else ends


def _centroid(
    mesh: Mesh,
    crossed: Int64[np.ndarray, " k"],
    heights: Float64[np.ndarray, "k 3"],
    direction: Vector3,
) -> Vector3:
    """Centroid of the area inside a section, from the segments in which it crosses faces."""
    above = heights >= 0
    lone_above = above.sum(1) == 1
    lone = (above == lone_above[:, None]).argmax(1)  # the corner alone on its side
    order = (lone[:, None] + np.arange(3)) % 3
    level = np.take_along_axis(heights, order, axis=1)
    corners = mesh.vertices_mm[np.take_along_axis(mesh.faces[crossed], order, axis=1)]
    fraction = level[:, :1] / (level[:, :1] - level[:, 1:])
    ends = corners[:, :1] + fraction[:, :, None] * (corners[:, 1:] - corners[:, :1])
    origin = ends[:, 0].mean(0)
    ends = ends - origin
    doubled = np.cross(ends[:, 0], ends[:, 1]) @ direction
    doubled = np.where(lone_above, doubled, -doubled)
    total = float(doubled.sum())
    return origin + (ends.sum(1) * doubled[:, None]).sum(0) / (3 * total)


def _line_through(points: Points3) -> Axis:
    """Robust line by iteratively reweighted least squares (Huber)."""
    weights = np.ones(len(points))
    point, direction = points.mean(0), np.zeros(3)
    off = np.zeros_like(points)
    for _ in range(20):
        point = weights @ points / weights.sum()
        centred = points - point
        direction = np.linalg.eigh((centred * weights[:, None]).T @ centred)[1][:, 2]
        off = centred - np.outer(centred @ direction, direction)
        distance = np.linalg.norm(off, axis=1)
        limit = _HUBER * max(float(np.median(distance)), 1e-9)
        weights = np.minimum(1.0, limit / np.maximum(distance, 1e-300))
    return Axis(point_mm=point, direction=direction, spread_mm=rms(off))
