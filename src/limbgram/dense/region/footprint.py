"""Footprint: which pixels of a photo can show the region, and between which depths."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Float64
from numba import njit

from limbgram.dense.region.cubes import Region
from limbgram.geometry.arrays import Mask
from limbgram.geometry.camera import View
from limbgram.scale.sight import in_sight

_STRETCH = 1.1
"""How much larger a cube's disc is drawn than the pinhole says: slant and lens distortion."""


@dataclass(frozen=True, kw_only=True)
class Footprint:
    """What a region covers in one reduced photo: a crop of pixels with depth bounds.

    Pixel (row r, column c) of the arrays is pixel (x0 + c, y0 + r) of the photo reduced by the
    factor that was asked for. No surface inside the region projects outside the mask, nor lies
    outside the bounds; both may be a cube too wide.
    """

    x0: int
    y0: int
    mask: Mask
    near_mm: Float32[np.ndarray, "h w"]
    """Least depth along the camera's z axis; NaN outside the mask."""
    far_mm: Float32[np.ndarray, "h w"]
    """Largest depth along the camera's z axis; NaN outside the mask."""


def footprint(region: Region, view: View, factor: float = 1.0) -> Footprint:
    """The crop of a photo, reduced by `factor`, that shows the region.

    A region out of the photo's sight gives a crop of no pixels.
    """
    camera = view.camera.scaled(factor)
    in_camera = view.camera_from_world.apply(region.centres_mm(region.skin()))
    radius_mm = region.cell_mm * np.sqrt(3) / 2
    in_camera = in_camera[in_sight(camera, in_camera) & (in_camera[:, 2] > 2 * radius_mm)]
    depth_mm = in_camera[:, 2]
    xy_px = camera.project(in_camera)
    radius_px = _STRETCH * max(camera.fx, camera.fy) * radius_mm / (depth_mm - radius_mm) + 0.5

    seen = np.all(xy_px + radius_px[:, None] >= 0, axis=1) & np.all(
        xy_px - radius_px[:, None] <= (camera.width_px - 1, camera.height_px - 1), axis=1
    )
    if not seen.any():
        nothing = np.zeros((0, 0), np.float32)
        return Footprint(x0=0, y0=0, mask=nothing > 0, near_mm=nothing, far_mm=nothing)

    discs = np.column_stack([xy_px, radius_px, depth_mm])[seen]
    low = np.floor((discs[:, :2] - discs[:, 2:3]).min(0)).astype(int)
    high = np.ceil((discs[:, :2] + discs[:, 2:3]).max(0)).astype(int) + 1
    x0, y0 = np.maximum(low, 0)
    width, height = np.minimum(high, (camera.width_px, camera.height_px)) - (x0, y0)
    near = np.full((height, width), np.inf, np.float32)
    far = np.full((height, width), -np.inf, np.float32)
    discs[:, :2] -= (x0, y0)
    _draw_discs(discs, radius_mm, near, far)
    mask = far > 0
    near[~mask] = far[~mask] = np.nan
    return Footprint(x0=int(x0), y0=int(y0), mask=mask, near_mm=near, far_mm=far)


@njit(cache=True, nogil=True)
def _draw_discs(
    discs: Float64[np.ndarray, "n 4"],
    radius_mm: float,
    near: Float32[np.ndarray, "h w"],
    far: Float32[np.ndarray, "h w"],
) -> None:
    """Widen near and far by each cube: x, y and radius in pixels of the arrays, depth in mm."""
    height, width = near.shape
    for k in range(len(discs)):
        x, y, radius, depth = discs[k, 0], discs[k, 1], discs[k, 2], discs[k, 3]
        first = max(0, int(np.ceil(y - radius)))
        last = min(height - 1, int(np.floor(y + radius)))
        for row in range(first, last + 1):
            reach = np.sqrt(max(0.0, radius * radius - (row - y) * (row - y)))
            left = max(0, int(np.ceil(x - reach)))
            right = min(width - 1, int(np.floor(x + reach)))
            for column in range(left, right + 1):
                near[row, column] = min(near[row, column], np.float32(depth - radius_mm))
                far[row, column] = max(far[row, column], np.float32(depth + radius_mm))
