"""A radius map: a surface as radii round the z axis, by slice and spoke; and its grid alone.

Spokes are counted from the front (+Y) towards the patient's right (+X): clockwise seen from
proximal, as files of the trade count them. In the right-handed limb frame
x = r sin(theta), y = r cos(theta).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int32

from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.mesh import Mesh

_EVEN_DEG = 1e-3
"""Files hold a spacing to six decimals, which adds up over a turn."""
POINT_MM = 0.05
"""An end slice with all radii below this is one point."""


@dataclass(frozen=True, kw_only=True)
class Grid:
    """The angles and heights of a radius map."""

    thetas_deg: Float64[np.ndarray, " n"]
    """Rising, within one turn."""
    z_mm: Float64[np.ndarray, " m"]
    """Rising, from the origin of the file."""

    @property
    def even(self) -> bool:
        """Whether the spokes are evenly spaced, beginning at the front."""
        count = len(self.thetas_deg)
        off_deg = self.thetas_deg - 360.0 / count * np.arange(count)
        return bool(np.abs(off_deg).max() < _EVEN_DEG)


@dataclass(frozen=True, kw_only=True)
class RadiusMap:
    """Radii in a frame whose z axis is the carving axis, +z proximal."""

    thetas_deg: Float64[np.ndarray, " n"]
    """Rising, less than a turn from first to last."""
    z_mm: Float64[np.ndarray, " m"]
    """Rising."""
    radii_mm: Float64[np.ndarray, "m n"]

    def points_mm(self) -> Float64[np.ndarray, "m n 3"]:
        angles = np.radians(self.thetas_deg)
        x, y = self.radii_mm * np.sin(angles), self.radii_mm * np.cos(angles)
        return np.stack([x, y, np.broadcast_to(self.z_mm[:, None], x.shape)], axis=-1)

    def radius_at_mm(
        self, thetas_deg: Float64[np.ndarray, " k"], z_mm: Float64[np.ndarray, " k"]
    ) -> Float64[np.ndarray, " k"]:
        """Radius by linear interpolation; beyond an end slice, that slice's."""
        start = self.thetas_deg[0]
        around = np.append(self.thetas_deg, start + 360)
        turned = (thetas_deg - start) % 360 + start
        i = np.clip(np.searchsorted(around, turned, side="right") - 1, 0, len(around) - 2)
        k = np.clip(np.searchsorted(self.z_mm, z_mm, side="right") - 1, 0, len(self.z_mm) - 2)
        across = (turned - around[i]) / (around[i + 1] - around[i])
        along = np.clip((z_mm - self.z_mm[k]) / (self.z_mm[k + 1] - self.z_mm[k]), 0, 1)
        ring = np.column_stack([self.radii_mm, self.radii_mm[:, 0]])
        low = (1 - across) * ring[k, i] + across * ring[k, i + 1]
        high = (1 - across) * ring[k + 1, i] + across * ring[k + 1, i + 1]
        return (1 - along) * low + along * high

    def girths_mm(self) -> Float64[np.ndarray, " m"]:
        """Perimeter of every slice's polygon."""
        points = self.points_mm()
        return np.linalg.norm(np.roll(points, -1, axis=1) - points, axis=2).sum(1)

    def surface(self) -> Mesh:
        """The mesh of the map: closed distally, open proximally unless it ends in a point."""
        count = len(self.thetas_deg)
        points = self.points_mm()
        vertices: Points3 = points.reshape(-1, 3)
        low, middle = points[0].mean(0), np.array([0.0, 0.0, self.z_mm[-1]])
        vertices = np.concatenate([vertices, low[None], middle[None]])
        cap, tip = len(vertices) - 2, len(vertices) - 1
        ring = np.arange(count)
        fan = np.column_stack([np.full(count, cap), ring, np.roll(ring, -1)])
        faces = np.concatenate([fan, self._sides(points)]).astype(np.int32)
        if (self.radii_mm[0] < POINT_MM).all():
            vertices[cap] = (0.0, 0.0, self.z_mm[0])
            faces = _with_ring_merged(faces, ring, cap)
        if (self.radii_mm[-1] < POINT_MM).all():
            faces = _with_ring_merged(faces, ring + (len(self.z_mm) - 1) * count, tip)
        used, compact = np.unique(faces, return_inverse=True)
        return Mesh(vertices_mm=vertices[used], faces=compact.reshape(-1, 3).astype(np.int32))

    def _sides(self, points: Float64[np.ndarray, "m n 3"]) -> np.ndarray:
        """Outward triangles of the sides: two for each quad, split along its shorter diagonal."""
        slices, count = self.radii_mm.shape
        k, i = np.meshgrid(np.arange(slices - 1), np.arange(count), indexing="ij")
        here, aside = k * count + i, k * count + (i + 1) % count
        over, across = here + count, aside + count
        rising = np.linalg.norm(points[1:] - np.roll(points[:-1], -1, axis=1), axis=2)
        falling = np.linalg.norm(np.roll(points[1:], -1, axis=1) - points[:-1], axis=2)
        first = np.where(falling < rising, 1, 0)[..., None]
        one = np.where(first, _stack(here, across, aside), _stack(here, over, aside))
        two = np.where(first, _stack(here, over, across), _stack(aside, over, across))
        return np.concatenate([one.reshape(-1, 3), two.reshape(-1, 3)])


def _stack(*corners: np.ndarray) -> np.ndarray:
    return np.stack(corners, axis=-1)


def _with_ring_merged(faces: Faces, ring: np.ndarray, point: int) -> Int32[np.ndarray, "kept 3"]:
    """Faces with a ring merged into one vertex; degenerate faces are dropped."""
    faces = np.where(np.isin(faces, ring), np.int32(point), faces)
    a, b, c = faces.T
    return faces[(a != b) & (b != c) & (c != a)]
