"""Depth maps: the surface as one photo sees it, and the cloud that many of them make."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, UInt8

from limbgram.geometry.camera import Camera
from limbgram.geometry.rigid import Rigid


@dataclass(frozen=True, kw_only=True)
class DepthMap:
    """Depth and normal of each pixel of a crop of one reduced photo.

    Pixel (row r, column c) of the arrays is pixel (x0 + c, y0 + r) of the reduced photo, whose
    lens is `camera` (already reduced, distortion kept: rays come from `camera.rays`).
    """

    photo_idx: int
    camera: Camera
    camera_from_world: Rigid
    x0: int
    y0: int
    depth_mm: Float32[np.ndarray, "h w"]
    """Along the camera's z axis; NaN where nothing was measured."""
    normal_in_camera: Float32[np.ndarray, "h w 3"]
    """Unit, towards the camera."""
    confidence: Float32[np.ndarray, "h w"]
    """0 to 1: mean correlation over the agreeing photos."""
    window_px2: float = 0.0
    """Mean squared reach, in one direction, of the flat windows that were correlated: on a
    surface of mean curvature H, their depth is too large by about H times this (in mm^2)."""


@dataclass(frozen=True, kw_only=True)
class Cloud:
    """Oriented points of the surface."""

    points_mm: Float32[np.ndarray, "n 3"]
    normals: Float32[np.ndarray, "n 3"]
    """Unit, outwards."""
    colours: UInt8[np.ndarray, "n 3"]
    views: UInt8[np.ndarray, " n"]
    """Number of photos that agree on the point."""
    spacing_mm: float
    """Typical distance between neighbours."""

    def __len__(self) -> int:
        return len(self.points_mm)
