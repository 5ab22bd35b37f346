"""Agreement: how many other depth maps have the same point of the surface (compiled).

A pixel's point is taken into another photo, onto the plane that was measured there, and back.
It agrees if it returns to within a fraction of a pixel, at about the same depth, with a similar
normal. Matches that are wrong rarely do so twice.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64, UInt8
from numba import njit

from limbgram.dense.depth import DepthMap

_DEPTH_TOLERANCE = 0.02
"""Relative; only to keep apart surfaces that a return to the same pixel would not."""


def agreeing(
    depth_map: DepthMap, others: Sequence[DepthMap], agree_px: float, agree_deg: float
) -> UInt8[np.ndarray, "h w"]:
    """Number of other maps that agree, by pixel."""
    votes = np.zeros(depth_map.depth_mm.shape, np.uint8)
    own = view_row(depth_map)
    for other in others:
        _vote(
            depth_map.depth_mm, depth_map.normal_in_camera, own,
            other.depth_mm, other.normal_in_camera, view_row(other),
            agree_px, np.cos(np.radians(agree_deg)), votes,
        )  # fmt: skip
    return votes


def view_row(depth_map: DepthMap) -> Float64[np.ndarray, "17"]:
    """Rotation (9), translation (3), fx, fy, cx, cy, skew of the crop's pinhole, for kernels."""
    camera, pose = depth_map.camera, depth_map.camera_from_world
    lens = [camera.fx, camera.fy, camera.cx - depth_map.x0, camera.cy - depth_map.y0, camera.skew]
    return np.concatenate([pose.rotation.ravel(), pose.translation, lens])


@njit(inline="always")
def into_view(view, x, y, z):
    """World point to pixel and depth."""
    a = view[0] * x + view[1] * y + view[2] * z + view[9]
    b = view[3] * x + view[4] * y + view[5] * z + view[10]
    c = view[6] * x + view[7] * y + view[8] * z + view[11]
    p, q = a / c, b / c
    return view[12] * p + view[16] * q + view[14], view[13] * q + view[15], c


@njit(inline="always")
def out_of_view(view, u, v, depth):
    """Pixel and depth to world point."""
    q = (v - view[15]) / view[13]
    p = (u - view[14] - view[16] * q) / view[12]
    a, b, c = p * depth - view[9], q * depth - view[10], depth - view[11]
    return (
        view[0] * a + view[3] * b + view[6] * c,
        view[1] * a + view[4] * b + view[7] * c,
        view[2] * a + view[5] * b + view[8] * c,
    )


@njit(inline="always")
def turned_out(view, nx, ny, nz):
    """Direction in the camera to direction in the world."""
    return (
        view[0] * nx + view[3] * ny + view[6] * nz,
        view[1] * nx + view[4] * ny + view[7] * nz,
        view[2] * nx + view[5] * ny + view[8] * nz,
    )


@njit(inline="always")
def depth_on_plane(view, u, v, column, row, depth, nx, ny, nz):
    """Depth at (u, v) of the plane measured at a pixel nearby."""
    q0, q1 = (row - view[15]) / view[13], (v - view[15]) / view[13]
    p0 = (column - view[14] - view[16] * q0) / view[12]
    p1 = (u - view[14] - view[16] * q1) / view[12]
    facing = nx * p1 + ny * q1 + nz
    if facing > -1e-3:
        return depth
    return depth * (nx * p0 + ny * q0 + nz) / facing


@njit(cache=True, nogil=True)
def _vote(
    depth, normal, view, other_depth, other_normal, other_view, agree_px, least_cosine, votes
):
    height, width = depth.shape
    other_height, other_width = other_depth.shape
    for row in range(height):
        for column in range(width):
            here = depth[row, column]
            if not here > 0:
                continue
            x, y, z = out_of_view(view, column, row, here)
            u, v, far = into_view(other_view, x, y, z)
            if not (far > 0 and u > 0 and v > 0 and u < other_width - 1 and v < other_height - 1):
                continue
            i, j = int(u + 0.5), int(v + 0.5)
            measured = other_depth[j, i]
            if not measured > 0:
                continue
            nx, ny, nz = other_normal[j, i]
            there = depth_on_plane(other_view, u, v, i, j, measured, nx, ny, nz)
            if abs(there - far) > _DEPTH_TOLERANCE * far:
                continue
            ox, oy, oz = turned_out(other_view, nx, ny, nz)
            mx, my, mz = turned_out(
                view, normal[row, column, 0], normal[row, column, 1], normal[row, column, 2]
            )
            if ox * mx + oy * my + oz * mz < least_cosine:
                continue
            x, y, z = out_of_view(other_view, u, v, there)
            back_u, back_v, _ = into_view(view, x, y, z)
            if (back_u - column) ** 2 + (back_v - row) ** 2 <= agree_px**2:
                votes[row, column] += 1
