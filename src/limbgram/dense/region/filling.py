"""Filling: a solid region from points on its surface."""

import numpy as np
from jaxtyping import Bool, Float64
from scipy import ndimage

from limbgram.dense.region.cubes import Region
from limbgram.geometry.arrays import Points3

_LEAST_PIECE = 0.01
"""Pieces of the region smaller than this share of the largest are noise."""

_LEAST_MARGIN = 1.5
"""In cubes: a point's cube and all that touch its sides and edges."""


def solid(points: Points3, radius_mm: float, margin_mm: float, cell_mm: float) -> Region:
    """Points closed to a body by balls of `radius_mm`, filled, and widened by the margin.

    It is widened by no less than the nearest ring of cubes, whatever the margin.
    """
    margin_mm = max(margin_mm, _LEAST_MARGIN * cell_mm)
    border_mm = radius_mm + margin_mm + 2 * cell_mm
    origin = points.min(0) - border_mm
    shape = np.ceil((points.max(0) + border_mm - origin) / cell_mm).astype(int)
    seeds = np.zeros(shape, bool)
    seeds[tuple(np.floor((points - origin) / cell_mm).astype(int).T)] = True
    body = _enclosed(_distance_to(seeds) * cell_mm <= radius_mm)
    body = _distance_to(~body) * cell_mm > radius_mm
    occupied = _distance_to(body | seeds) * cell_mm <= margin_mm
    return Region(origin_mm=origin, cell_mm=cell_mm, occupied=_without_islands(occupied))


def down_to_floor(region: Region, depth_mm: float, floor_z_mm: float) -> Region:
    """The region with an underside that hardly a photo sees, and nothing below the floor."""
    cells = round(depth_mm / region.cell_mm)
    occupied = np.pad(region.occupied, ((0, 0), (0, 0), (cells, 0)))
    origin = region.origin_mm - (0.0, 0.0, cells * region.cell_mm)
    for _ in range(cells):
        occupied[:, :, :-1] |= occupied[:, :, 1:]
    tops = origin[2] + region.cell_mm * np.arange(1, occupied.shape[2] + 1)
    return Region(origin_mm=origin, cell_mm=region.cell_mm, occupied=occupied & (tops > floor_z_mm))


def _distance_to(cells: Bool[np.ndarray, "i j k"]) -> Float64[np.ndarray, "i j k"]:
    """Distance of each cube's centre from the nearest marked one's, in cubes."""
    return np.asarray(ndimage.distance_transform_edt(~cells))


def _without_islands(occupied: Bool[np.ndarray, "i j k"]) -> Bool[np.ndarray, "i j k"]:
    """The pieces that are not tiny beside the largest one."""
    labels = np.zeros(occupied.shape, np.int32)
    ndimage.label(occupied, output=labels)
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    return (sizes > _LEAST_PIECE * sizes.max())[labels]


def _enclosed(body: Bool[np.ndarray, "i j k"]) -> Bool[np.ndarray, "i j k"]:
    """The body with every cube that it surrounds in five of the six directions of the axes.

    An open brim, a sole that no photo sees and the hollow inside are closed by this.
    """
    sides = np.zeros(body.shape, np.int8)
    for axis in range(3):
        sides += np.maximum.accumulate(body, axis)
        sides += np.flip(np.maximum.accumulate(np.flip(body, axis), axis), axis)
    return body | (sides >= 5)
