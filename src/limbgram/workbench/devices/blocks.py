"""Blocks: solids blended into a shell: a socket's end towards its plate, bosses for joints.

Each gives its signed distance (Quilez 2008 derives that of the round cone), by which the shell
takes it up; it ends within the wall, and never reaches the skin.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.core.geometry.arrays import Points3, Vector3


@dataclass(frozen=True, kw_only=True)
class RoundCone:
    """A round cone, the hull of two spheres, cut off at a plane through the first centre."""

    start_mm: Vector3
    end_mm: Vector3
    start_radius_mm: float
    end_radius_mm: float
    floor: Vector3
    """Unit normal of that plane; what lies below it is left out."""

    def distance_mm(self, points_mm: Points3) -> Float64[np.ndarray, " n"]:
        axis = self.end_mm - self.start_mm
        length = float(np.linalg.norm(axis))
        along = (points_mm - self.start_mm) @ (axis / length)
        off = np.sqrt(np.maximum(((points_mm - self.start_mm) ** 2).sum(1) - along**2, 0.0))
        lean = (self.start_radius_mm - self.end_radius_mm) / length
        rise = np.sqrt(max(1 - lean**2, 1e-12))
        at = along * rise - off * lean
        side = off * rise + along * lean - self.start_radius_mm
        low = np.hypot(off, along) - self.start_radius_mm
        high = np.hypot(off, along - length) - self.end_radius_mm
        cone = np.where(at < 0, low, np.where(at > length * rise, high, side))
        return np.maximum(cone, (self.start_mm - points_mm) @ self.floor)

    def box_mm(self) -> Float64[np.ndarray, "2 3"]:
        low = np.minimum(self.start_mm - self.start_radius_mm, self.end_mm - self.end_radius_mm)
        high = np.maximum(self.start_mm + self.start_radius_mm, self.end_mm + self.end_radius_mm)
        return np.stack([low, high])


@dataclass(frozen=True, kw_only=True)
class Boss:
    """A round seat with a flat face, its edge rounded."""

    face_mm: Vector3
    """Middle of the flat face."""
    outward: Vector3
    """Unit normal of that face."""
    radius_mm: float
    depth_mm: float
    """From the face inwards."""
    rounding_mm: float = 1.5

    def distance_mm(self, points_mm: Points3) -> Float64[np.ndarray, " n"]:
        from_middle = points_mm - (self.face_mm - 0.5 * self.depth_mm * self.outward)
        along = from_middle @ self.outward
        off = np.sqrt(np.maximum((from_middle**2).sum(1) - along**2, 0.0))
        out = off - self.radius_mm + self.rounding_mm
        up = np.abs(along) - 0.5 * self.depth_mm + self.rounding_mm
        return (
            np.minimum(np.maximum(out, up), 0.0)
            + np.hypot(np.maximum(out, 0.0), np.maximum(up, 0.0))
            - self.rounding_mm
        )

    def box_mm(self) -> Float64[np.ndarray, "2 3"]:
        reach = self.radius_mm + self.depth_mm
        return np.stack([self.face_mm - reach, self.face_mm + reach])


Block = RoundCone | Boss
"""A solid that thickens a shell: `distance_mm` is negative inside, `box_mm` the lowest and the
highest corner of its bounding box."""
