"""Figures of one level, each with its slope: how it changes as the level's points move.

Through the slopes the sigmas of the vertices become the figure's own.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64, Int64
from scipy.spatial import ConvexHull

from limbgram.geometry.arrays import Points3
from limbgram.geometry.interval import Interval
from limbgram.shape.measures.levels.cutting import Level
from limbgram.surface.mesh import Mesh
from limbgram.surface.uncertainty import propagate


@dataclass(frozen=True)
class Figure:
    """A measure of the limb and its standard deviation, None where the mesh carries no sigmas."""

    value: float
    sigma: float | None

    @property
    def interval(self) -> Interval | None:
        """Where the true value lies in 95 of 100 cases: what ± tells."""
        return None if self.sigma is None else Interval.of_sigma(self.sigma)


@dataclass(frozen=True)
class Sloped:
    """A measure of a level and its change for a millimetre of each point in x and y."""

    value: float
    slopes: Float64[np.ndarray, "k 2"]
    along_mm: Float64[np.ndarray, " k"] | None = None
    """Length along the surface that belongs to each point, for a measure that is such a length."""
    on_tops: bool = False
    """Whether that line rests on the tops of the relief instead of following it."""


_TAPE_SHARE, _BRIDGED = 0.8, 0.007
"""What a tape loses with the finest relief, in shares of what the contour loses: it rests on the
tops, the more so the higher the relief is. The share, and the contour's loss per length at which
half of it is left (0.63 to 0.80 at losses up to 0.0006, 0.44 and 0.54 at 0.004 in ten captures)."""

Measure = Callable[[Level], Sloped | None]


def contour_mm(level: Level) -> Sloped:
    """Length of the outlines, into every hollow."""
    return _around(level, np.flatnonzero(level.outer), level.after[level.outer])


def tape_mm(level: Level) -> Sloped:
    """What a taut tape reads: the length round the convex hull of the outlines."""
    outer = np.flatnonzero(level.outer)
    hull = outer[ConvexHull(level.points_mm[outer]).vertices]
    return replace(_around(level, hull, np.roll(hull, -1)), on_tops=True)


def area_mm2(level: Level) -> Sloped:
    """Area of the material: hollows do not count."""
    points, after = level.points_mm, level.after
    before = np.empty_like(after)
    before[after] = np.arange(len(after))
    middle = points[level.outer].mean(0)
    x, y = (points - middle).T
    value = 0.5 * float(np.sum(x * y[after] - x[after] * y))
    slopes = 0.5 * np.column_stack([y[after] - y[before], x[before] - x[after]])
    return Sloped(value, slopes)


def radius_mm(level: Level) -> Sloped:
    """Radius of the circle of the same area."""
    area = area_mm2(level)
    radius = float(np.sqrt(max(area.value, 0.0) / np.pi))
    return Sloped(radius, area.slopes / (2 * np.pi * max(radius, 1e-300)))


def ml_mm(level: Level) -> Sloped:
    """Caliper width from side to side, along x."""
    return _caliper(level, 0)


def ap_mm(level: Level) -> Sloped:
    """Caliper width from front to back, along y."""
    return _caliper(level, 1)


def ml_through_mm(level: Level) -> Sloped | None:
    """Width from side to side on the line through the long axis; None where it meets nothing."""
    return _through(level, 0)


def ap_through_mm(level: Level) -> Sloped | None:
    """Width from front to back on the line through the long axis."""
    return _through(level, 1)


@dataclass(frozen=True)
class Sigmas:
    """Turns slopes of points into sigmas of figures, for one mesh in the limb frame."""

    mesh: Mesh
    normals: Points3

    @classmethod
    def of(cls, mesh_in_limb: Mesh) -> "Sigmas":
        return cls(mesh_in_limb, mesh_in_limb.vertex_normals())

    def figure(self, level: Level, sloped: Sloped) -> Figure:
        """The measure of the limb: the surface's own, and what a line along it has lost."""
        if self.mesh.sigma_mm is None:
            return Figure(sloped.value, None)
        sigma = propagate(self.mesh, self.gradient(level, sloped))
        if sigma is None or sloped.along_mm is None or self.mesh.lost_length is None:
            return Figure(sloped.value, sigma)
        ends = self.mesh.lost_length.astype(np.float64)[level.crossed]
        at = level.shares[:, None]
        lost_mm, sigma_mm = sloped.along_mm @ ((1 - at) * ends[:, 0] + at * ends[:, 1])
        share = 1.0
        if sloped.on_tops:
            share = _TAPE_SHARE / (1 + max(float(lost_mm), 0.0) / (_BRIDGED * sloped.value))
        value = sloped.value + share * float(lost_mm)
        return Figure(value, math.hypot(sigma, share * float(sigma_mm)))

    def gradient(self, level: Level, sloped: Sloped) -> Float64[np.ndarray, " n"]:
        """Change of the figure for a millimetre of each vertex along its normal.

        A vertex takes the crossing of its edge along, and slides it on the edge back to the plane.
        """
        ends = self.mesh.vertices_mm[level.crossed]
        edge = ends[:, 1] - ends[:, 0]
        lean = edge[:, :2] / edge[:, 2:]
        total = np.zeros(len(self.mesh.vertices_mm))
        for end, share in ((0, 1 - level.shares), (1, level.shares)):
            normal = self.normals[level.crossed[:, end]]
            moved = normal[:, :2] - lean * normal[:, 2:]
            change = share * (sloped.slopes * moved).sum(1)
            total += np.bincount(level.crossed[:, end], change, len(total))
        return total


def _around(
    level: Level,
    ids: Int64[np.ndarray, " k"],
    after: Int64[np.ndarray, " k"],
) -> Sloped:
    """Length of the pieces that join points to their followers."""
    steps = level.points_mm[after] - level.points_mm[ids]
    lengths = np.linalg.norm(steps, axis=1)
    along = steps / np.maximum(lengths, 1e-300)[:, None]
    slopes = np.zeros_like(level.points_mm)
    slopes[after] += along
    slopes[ids] -= along
    along_mm = np.bincount(ids, lengths / 2, len(slopes))
    along_mm += np.bincount(after, lengths / 2, len(slopes))
    return Sloped(float(lengths.sum()), slopes, along_mm)


def _caliper(level: Level, axis: int) -> Sloped:
    along = np.where(level.outer, level.points_mm[:, axis], np.nan)
    low, high = int(np.nanargmin(along)), int(np.nanargmax(along))
    slopes = np.zeros_like(level.points_mm)
    slopes[low, axis], slopes[high, axis] = -1.0, 1.0
    return Sloped(float(along[high] - along[low]), slopes)


def _through(level: Level, axis: int) -> Sloped | None:
    """Between the outermost crossings of the outlines with the line through x = y = 0."""
    along, across = level.points_mm[:, axis], level.points_mm[:, 1 - axis]
    astride = np.flatnonzero(level.outer & ((across > 0) != (across[level.after] > 0)))
    if not len(astride):
        return None
    after = level.after[astride]
    rise = across[after] - across[astride]
    share = -across[astride] / rise
    places = along[astride] + share * (along[after] - along[astride])
    if not places.min() < 0 < places.max():
        return None
    slopes = np.zeros_like(level.points_mm)
    for k, sign in ((int(places.argmin()), -1.0), (int(places.argmax()), 1.0)):
        lean = (along[after[k]] - along[astride[k]]) / rise[k]
        for point, part in ((astride[k], 1 - share[k]), (after[k], share[k])):
            slopes[point, axis] += sign * part
            slopes[point, 1 - axis] -= sign * part * lean
    return Sloped(float(places.max() - places.min()), slopes)


MEASURES: dict[str, Measure] = {
    "contour_mm": contour_mm,
    "tape_mm": tape_mm,
    "ml_mm": ml_mm,
    "ap_mm": ap_mm,
    "ml_through_mm": ml_through_mm,
    "ap_through_mm": ap_through_mm,
    "area_mm2": area_mm2,
    "radius_mm": radius_mm,
}
"""Everything that is measured at a level, by its name in tables."""
