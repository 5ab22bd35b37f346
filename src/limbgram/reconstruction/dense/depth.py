"""Depth maps: the surface as one photo sees it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera


@dataclass(frozen=True, kw_only=True)
class DepthMap:
    """Depth and normal of each pixel of a crop of one reduced photo.

    Row r and column c of the arrays is pixel (x0 + c, y0 + r) of `camera`, a pinhole whose
    pixels are those of the reduced photo at which depth was sought.
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
    """Mean squared distance of a correlation window's samples from its centre, in one direction, in
    pixels of `camera`. On a surface of mean curvature H, the depth is too large by about H times
    this (in mm^2)."""
