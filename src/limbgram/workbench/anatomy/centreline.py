"""Centreline: the curve to which sections, girths, widths and charts of a limb are square.

In      for a bent limb, middles of landmarks from proximal to distal; else a straight axis.
Out     Centreline: points at even steps along it, with the unit direction at each, proximal first.
Method  Corners are rounded by arcs, so that the planes across the curve turn evenly, about a line
        that lies in front of the instep: they do not cross in the limb as they would at a corner.
        The ends go on straight.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from scipy.spatial import KDTree

from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.polyline import distances_along
from limbgram.core.mesh.mesh import unit

_STEP_MM = 1.0
_STRAIGHT_ANGLE_RAD = 1e-3


@dataclass(frozen=True)
class CentrelinePlace:
    """A place on the curve."""

    point_mm: Vector3
    direction: Vector3
    """Along the curve, towards its distal end."""


@dataclass(frozen=True, kw_only=True)
class Centreline:
    """A smooth curve from the proximal end to the distal one."""

    points_mm: Points3
    """In the mesh's frame, close together."""
    directions: Points3
    lengths_mm: Float64[np.ndarray, " k"]
    """From the proximal end of the curve to each point."""

    @property
    def length_mm(self) -> float:
        return float(self.lengths_mm[-1])

    def at(self, along_mm: float) -> CentrelinePlace:
        """The place at a distance from the proximal end; the curve is straight beyond its ends."""
        held = float(np.clip(along_mm, 0.0, self.length_mm))
        point, direction = self._between_nodes(held)
        direction /= np.linalg.norm(direction)
        return CentrelinePlace(point + (along_mm - held) * direction, direction)

    def moved(self, motion: Rigid) -> "Centreline":
        """The same curve in another frame."""
        return Centreline(
            points_mm=motion.apply(self.points_mm),
            directions=self.directions @ motion.rotation.T,
            lengths_mm=self.lengths_mm,
        )

    def straightened(self, points_mm: Points3, across: Vector3) -> Points3:
        """Places as if the curve were straightened to the z axis, its distal end at 0.

        Args:
            across: Direction that becomes x, such as to the right; nowhere along the curve.
        """
        along = self.nearest_mm(points_mm)
        middle, direction = self._between_nodes(np.clip(along, 0.0, self.length_mm))
        up = -unit(direction)
        x = unit(across - (up @ across)[:, None] * up)
        off = points_mm - middle
        y = np.cross(up, x)
        return np.column_stack([(off * x).sum(1), (off * y).sum(1), self.length_mm - along])

    def _between_nodes(self, along_mm: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points and directions at distances from the proximal end; directions not quite unit."""
        point, direction = (
            np.stack([np.interp(along_mm, self.lengths_mm, column) for column in given.T], axis=-1)
            for given in (self.points_mm, self.directions)
        )
        return point, direction

    def nearest_mm(self, points_mm: Points3) -> Float64[np.ndarray, " n"]:
        """Distance along the curve of the plane across it through each point.

        Of several such planes the one nearest to the curve counts.
        """
        from_first = (points_mm - self.points_mm[0]) @ self.directions[0]
        from_last = (points_mm - self.points_mm[-1]) @ self.directions[-1]
        nearest = np.asarray(KDTree(self.points_mm).query(points_mm, workers=1)[1], np.int64)
        ahead = ((points_mm - self.points_mm[nearest]) * self.directions[nearest]).sum(1)
        found = self.lengths_mm[nearest] + ahead
        found = np.where((nearest == 0) & (from_first < 0), from_first, found)
        last = len(self.points_mm) - 1
        return np.where((nearest == last) & (from_last > 0), self.length_mm + from_last, found)


def straight_centreline(start_mm: Vector3, end_mm: Vector3) -> Centreline:
    """The line from a proximal place to a distal one."""
    return _resampled_centreline(np.stack([start_mm, end_mm]))


def rounded_polyline(nodes_mm: Points3, share: float) -> Centreline:
    """A centreline through the first and last node, with arcs at the corners between.

    Args:
        nodes_mm: From proximal to distal; three or more.
        share: Of the shorter way from a corner to the next node, or to the middle between two
            corners, that the arc takes up.
    """
    steps = np.diff(nodes_mm, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    free = np.concatenate([lengths[:1], lengths[1:-1] / 2, lengths[-1:]])
    units = steps / lengths[:, None]
    way = [nodes_mm[:1]]
    for corner in range(1, len(nodes_mm) - 1):
        before, after = units[corner - 1], units[corner]
        reach_mm = share * float(min(free[corner - 1], free[corner]))
        way.append(_arc(nodes_mm[corner], before, after, reach_mm))
    way.append(nodes_mm[-1:])
    return _resampled_centreline(np.concatenate(way))


def _arc(corner: Vector3, before: Vector3, after: Vector3, reach_mm: float) -> Points3:
    """The arc that touches both legs of a corner at a distance from it."""
    turn_rad = float(np.arccos(np.clip(before @ after, -1.0, 1.0)))
    if turn_rad < _STRAIGHT_ANGLE_RAD:
        return corner[None]
    radius_mm = reach_mm / np.tan(turn_rad / 2)
    inwards = after - before * (after @ before)
    inwards /= np.linalg.norm(inwards)
    start = corner - reach_mm * before
    count = max(int(np.ceil(radius_mm * turn_rad / _STEP_MM)), 8) + 1
    angles = np.linspace(0, turn_rad, count)[:, None]
    return start + radius_mm * (np.sin(angles) * before + (1 - np.cos(angles)) * inwards)


def _resampled_centreline(corners_mm: Points3) -> Centreline:
    """A centreline with points at even steps along a polyline."""
    knots = distances_along(corners_mm)
    at = np.linspace(0, knots[-1], max(int(knots[-1] / _STEP_MM), 2) + 1)
    points = np.column_stack([np.interp(at, knots, column) for column in corners_mm.T])
    directions = np.gradient(points, at, axis=0)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return Centreline(points_mm=points, directions=directions, lengths_mm=at)
