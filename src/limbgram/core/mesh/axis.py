"""The long axis: a line through the middles of cross-sections, found again and again across itself.

In      a mesh, in any pose.
Out     an Axis in the mesh's frame.
Method  the wall's normals tell a first direction; sections across it have centroids; a robust line
        through them is the next direction, until it stays. Ends, caps and brim are left out.
Fails   MeasureError: no direction is longer than the others, or too few whole sections.

Centroids are summed over the crossed faces as they come. `core/mesh/sections.cut` would chain them
in the same time (0.05 s for 40 sections of 130,000 faces), but in another order of sums, and limb
frames that were written before could not be had again to the last digit.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int32, Int64

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_half_edges

_ROUNDS = 100
_STILL = 1e-9
_SECTIONS, _LEAST_SECTIONS = 40, 8
_FRINGE = 0.12
"""Share of the length that is left out at either end."""
_ROUNDEST = 0.75
"""Largest share of wall that may face along the axis, against that across it."""
_TURN_OF_WEIGHT = 1.5
"""Residuals beyond so many typical ones lose weight (Huber)."""


@dataclass(frozen=True, kw_only=True)
class Axis:
    """A line in the mesh's frame."""

    point_mm: Vector3
    """Middle of the fitted sections."""
    direction: Vector3
    """Unit; of either sense."""
    spread_mm: float
    """Root mean square distance of the sections' middles from the line."""


def fit_axis(mesh: Mesh) -> Axis:
    """The long axis of a limb.

    Raises:
        MeasureError: the shape has no long axis, or too little whole wall to fit one.
    """
    border = boundary_half_edges(mesh.faces)
    axis = _along(mesh, border, _first_direction(mesh))
    for _ in range(_ROUNDS):
        middles = _middles(mesh, border, axis.direction)
        after = _line_through(middles)
        still = np.linalg.norm(np.cross(after.direction, axis.direction)) < _STILL
        axis = after
        if still:
            break
    return axis


def axis_along(mesh: Mesh, direction: Vector3) -> Axis:
    """The line of a stated direction through the middle of the sections across it."""
    return _along(mesh, boundary_half_edges(mesh.faces), direction)


def _along(mesh: Mesh, border: Int32[np.ndarray, "b 2"], direction: Vector3) -> Axis:
    unit = direction / np.linalg.norm(direction)
    middles = _middles(mesh, border, unit)
    point = np.median(middles, axis=0)
    off = (middles - point) - np.outer((middles - point) @ unit, unit)
    return Axis(point_mm=point, direction=unit, spread_mm=_rms(off))


def _first_direction(mesh: Mesh) -> Vector3:
    """The direction along which the least surface faces."""
    doubled = mesh.face_normals()
    area = np.maximum(np.linalg.norm(doubled, axis=1, keepdims=True), 1e-300)
    shares, directions = np.linalg.eigh((doubled / area).T @ doubled)
    if shares[0] > _ROUNDEST * shares[1]:
        raise MeasureError("mesh.axis.round")
    return directions[:, 0]


def _middles(mesh: Mesh, border: Int32[np.ndarray, "b 2"], direction: Vector3) -> Points3:
    """Centroids of the cuts across a direction, where they do not run into an open edge."""
    along = mesh.vertices_mm @ direction
    rim = np.sort(along[border], axis=1)
    low, high = _whole_span(rim, (float(along.min()), float(along.max())))
    fringe = _FRINGE * (high - low)
    corners = along[mesh.faces]
    lowest = np.minimum(np.minimum(corners[:, 0], corners[:, 1]), corners[:, 2])
    highest = np.maximum(np.maximum(corners[:, 0], corners[:, 1]), corners[:, 2])
    middles: list[Vector3] = []
    for offset in np.linspace(low + fringe, high - fringe, _SECTIONS):
        if ((rim[:, 0] < offset) & (rim[:, 1] >= offset)).any():
            continue
        crossed = np.flatnonzero((lowest < offset) & (highest >= offset))
        middles.append(_centroid(mesh, crossed, corners[crossed] - offset, direction))
    if len(middles) < _LEAST_SECTIONS:
        raise MeasureError(
            "mesh.axis.few_sections",
            whole=len(middles),
            sections=_SECTIONS,
            least=_LEAST_SECTIONS,
        )
    return np.stack(middles)


def _whole_span(
    border: Float64[np.ndarray, "b 2"], ends: tuple[float, float]
) -> tuple[float, float]:
    """The span without what an open brim at either end cuts away, if a third is left."""
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
    """Middle of the area inside a cut, from the pieces in which it crosses faces."""
    above = heights >= 0
    lone_above = above.sum(1) == 1
    lone = (above == lone_above[:, None]).argmax(1)
    order = (lone[:, None] + np.arange(3)) % 3
    level = np.take_along_axis(heights, order, axis=1)
    places = mesh.vertices_mm[np.take_along_axis(mesh.faces[crossed], order, axis=1)]
    share = level[:, :1] / (level[:, :1] - level[:, 1:])
    ends = places[:, :1] + share[:, :, None] * (places[:, 1:] - places[:, :1])
    around = ends - ends[:, 0].mean(0)
    doubled = np.cross(around[:, 0], around[:, 1]) @ direction
    doubled = np.where(lone_above, doubled, -doubled)
    total = float(doubled.sum())
    return ends[:, 0].mean(0) + (around.sum(1) * doubled[:, None]).sum(0) / (3 * total)


def _line_through(points: Points3) -> Axis:
    """Robust line: points far off lose weight (Huber), until the weights stay."""
    weights = np.ones(len(points))
    point, direction = points.mean(0), np.zeros(3)
    off = np.zeros_like(points)
    for _ in range(20):
        point = weights @ points / weights.sum()
        around = points - point
        direction = np.linalg.eigh((around * weights[:, None]).T @ around)[1][:, 2]
        off = around - np.outer(around @ direction, direction)
        distance = np.linalg.norm(off, axis=1)
        typical = _TURN_OF_WEIGHT * max(float(np.median(distance)), 1e-9)
        weights = np.minimum(1.0, typical / np.maximum(distance, 1e-300))
    return Axis(point_mm=point, direction=direction, spread_mm=_rms(off))


def _rms(off_mm: Points3) -> float:
    return float(np.sqrt((off_mm**2).sum(1).mean()))
