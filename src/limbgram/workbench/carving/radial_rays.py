"""Radial rays: where rays from the z axis cross a surface, exactly, at many heights at once.

In      a mesh with its axis along z; angles from +Y towards +X; heights.
Out     radii, and how often each ray crosses: a radius means something only where it is once.
Method  every face a plane cuts gives a segment; a segment crosses the rays between its ends'
        angles, half open, so that a ray through a corner is crossed once.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.core.geometry.arrays import Points2
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.sections import level_segments

_EDGE = 1e-9
"""Barycentric slack, so that the axis through a vertex or edge pierces."""


@dataclass(frozen=True)
class RadialCast:
    """Radii and crossings of rays from the z axis, by height and angle."""

    radii_mm: Float64[np.ndarray, "m n"]
    """NaN where the ray does not cross once."""
    outermost_mm: Float64[np.ndarray, "m n"]
    """Where it crosses last; 0 where it does not."""
    beneath_mm: Float64[np.ndarray, "m n"]
    """Where it crosses before that; 0 where it does not."""
    crossings: Int64[np.ndarray, "m n"]
    girths_mm: Float64[np.ndarray, " m"]
    """Length of the section at each height, all its parts."""


def cast_radii(
    mesh: Mesh, thetas_deg: Float64[np.ndarray, " n"], z_mm: Float64[np.ndarray, " m"]
) -> RadialCast:
    """Cast a ray at every angle (rising, 0 to 360) and height (rising)."""
    cuts = level_segments(mesh, z_mm)
    rays, planes = len(thetas_deg), len(z_mm)
    start_deg, end_deg = _angle_deg(cuts.start_mm), _angle_deg(cuts.end_mm)
    first = np.searchsorted(thetas_deg, start_deg)
    change = end_deg - start_deg
    turns = (change < -180).astype(np.int64) - (change > 180)
    count = np.searchsorted(thetas_deg, end_deg) + rays * turns - first
    low = np.where(count >= 0, first, first + count)
    hits = np.abs(count)
    segment = np.repeat(np.arange(len(hits)), hits)
    within = np.arange(len(segment)) - np.repeat(np.cumsum(hits) - hits, hits)
    ray = (low[segment] + within) % rays

    angle = np.radians(thetas_deg[ray])
    along = cuts.end_mm[segment] - cuts.start_mm[segment]
    start = cuts.start_mm[segment]
    slant = np.sin(angle) * along[:, 1] - np.cos(angle) * along[:, 0]
    radii = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / slant
    place = cuts.plane[segment] * rays + ray
    crossings = np.bincount(place, minlength=planes * rays)
    total = np.bincount(place, radii, planes * rays)
    ranked = np.append(radii[np.lexsort((radii, place))], 0.0)
    last = np.cumsum(crossings) - 1
    outermost = np.where(crossings > 0, ranked[last], 0.0)
    beneath = np.where(crossings > 1, ranked[last - 1], 0.0)
    lengths = np.linalg.norm(cuts.end_mm - cuts.start_mm, axis=1)
    return RadialCast(
        np.where(crossings == 1, total, np.nan).reshape(planes, rays),
        outermost.reshape(planes, rays),
        beneath.reshape(planes, rays),
        crossings.reshape(planes, rays),
        np.bincount(cuts.plane, lengths, planes),
    )


def axis_heights_mm(mesh: Mesh) -> Float64[np.ndarray, " k"]:
    """Heights at which the z axis pierces the surface, rising."""
    a, b, c = (mesh.vertices_mm[mesh.faces[:, k]] for k in range(3))
    area = _cross(b - a, c - a)
    upright = np.abs(area) > 1e-12
    inverse = 1 / np.where(upright, area, 1.0)
    u, v = _cross(c, a) * inverse, _cross(a, b) * inverse
    inside = upright & (u >= -_EDGE) & (v >= -_EDGE) & (u + v <= 1 + _EDGE)
    heights = a[:, 2] + u * (b - a)[:, 2] + v * (c - a)[:, 2]
    return np.sort(heights[inside])


def _angle_deg(points: Points2) -> Float64[np.ndarray, " s"]:
    return np.degrees(np.arctan2(points[:, 0], points[:, 1])) % 360


def _cross(p: np.ndarray, q: np.ndarray) -> Float64[np.ndarray, " f"]:
    return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
