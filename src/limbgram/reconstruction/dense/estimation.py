"""Estimation: depth maps of all photos that show the region, checked against each other.

In      the photos, a MetricScene, a Region.
Out     one DepthMap a photo, holding only what other photos' maps confirm.
Method  Pinhole crops; PatchMatch at a quarter of their scale; what other photos confirm there,
        and its surroundings, again at half and whole scale with sub-pixel refinement; then a place
        stays if enough other maps are consistent with it.
        Places: at half and whole scale depth is sought at every second pixel of every second row,
        with whole windows. Windows of neighbouring pixels share nearly all they see, and the cloud
        asks for no more points.
        Geometric consistency: a place's point is projected into another photo, onto the plane that
        was measured there, and back. It agrees if it returns to within a fraction of a pixel, at
        about the same depth, with a similar normal. Wrong matches rarely do so twice.
Fails   DenseError: too few photos show the region, or next to nothing could be matched.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Float64, UInt16

from limbgram.core.errors import DenseError
from limbgram.core.geometry.arrays import Mask
from limbgram.core.kernels import njit
from limbgram.core.run import in_parallel
from limbgram.findings import doubt
from limbgram.reconstruction.dense.crops import (
    HALVINGS,
    Crop,
    crop_photo,
    pyramid_level,
    reduction_for,
)
from limbgram.reconstruction.dense.depth import DepthMap
from limbgram.reconstruction.dense.photo_depth import (
    STEPS_BY_LEVEL,
    DenseOptions,
    depth_map_of,
    solve_coarse,
    solve_fine,
)
from limbgram.reconstruction.dense.region import Region
from limbgram.reconstruction.dense.source_views import SourceViewOptions, select_source_views
from limbgram.reconstruction.photos.decoding import in_flight_mb
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.photos.quality import common_fault
from limbgram.reconstruction.scale.metric import MetricScene

_DEPTH_TOLERANCE = 0.02
"""Relative difference of depth; it only tells surfaces apart along a ray."""


def count_consistent_maps(
    depth_map: DepthMap, others: Sequence[DepthMap], tolerance_px: float, tolerance_deg: float
) -> UInt16[np.ndarray, "h w"]:
    """Number of other maps that are consistent with each pixel."""
    votes = np.zeros(depth_map.depth_mm.shape, np.uint16)
    least_cosine = np.cos(np.radians(tolerance_deg))
    own = _arrays_of(depth_map)
    for other in others:
        _add_consistent(own, _arrays_of(other), tolerance_px, least_cosine, votes)
    return votes


class _MapArrays(NamedTuple):
    """A depth map as the kernels take it."""

    depth_mm: np.ndarray
    normal_in_camera: np.ndarray
    view: np.ndarray
    """Packed pinhole and pose."""


def _arrays_of(depth_map: DepthMap) -> _MapArrays:
    return _MapArrays(depth_map.depth_mm, depth_map.normal_in_camera, packed_pinhole(depth_map))


def packed_pinhole(depth_map: DepthMap) -> Float64[np.ndarray, "17"]:
    """Rotation (9), translation (3), fx, fy, cx, cy, skew of the crop's pinhole, for kernels."""
    camera, pose = depth_map.camera, depth_map.camera_from_world
    lens = [camera.fx, camera.fy, camera.cx - depth_map.x0, camera.cy - depth_map.y0, camera.skew]
    return np.concatenate([pose.rotation.ravel(), pose.translation, lens])


@njit(inline="always")
def project_point(view: np.ndarray, x: float, y: float, z: float):
    """Pixel and depth of a world point."""
    a = view[0] * x + view[1] * y + view[2] * z + view[9]
    b = view[3] * x + view[4] * y + view[5] * z + view[10]
    c = view[6] * x + view[7] * y + view[8] * z + view[11]
    p, q = a / c, b / c
    return view[12] * p + view[16] * q + view[14], view[13] * q + view[15], c


@njit(inline="always")
def unproject_pixel(view: np.ndarray, u: float, v: float, depth: float):
    """World point of a pixel and a depth."""
    q = (v - view[15]) / view[13]
    p = (u - view[14] - view[16] * q) / view[12]
    a, b, c = p * depth - view[9], q * depth - view[10], depth - view[11]
    return (
        view[0] * a + view[3] * b + view[6] * c,
        view[1] * a + view[4] * b + view[7] * c,
        view[2] * a + view[5] * b + view[8] * c,
    )


@njit(inline="always")
def to_world_direction(view: np.ndarray, nx: float, ny: float, nz: float):
    """World direction of a direction in the camera."""
    return (
        view[0] * nx + view[3] * ny + view[6] * nz,
        view[1] * nx + view[4] * ny + view[7] * nz,
        view[2] * nx + view[5] * ny + view[8] * nz,
    )


@njit(inline="always")
def depth_on_plane(depth_map: _MapArrays, column: int, row: int, u: float, v: float) -> float:
    """Depth at (u, v) of the plane that a map has at a pixel nearby."""
    depths, normals, view = depth_map
    depth = depths[row, column]
    nx, ny, nz = normals[row, column]
    q0, q1 = (row - view[15]) / view[13], (v - view[15]) / view[13]
    p0 = (column - view[14] - view[16] * q0) / view[12]
    p1 = (u - view[14] - view[16] * q1) / view[12]
    facing = nx * p1 + ny * q1 + nz
    if facing > -1e-3:
        return depth
    return depth * (nx * p0 + ny * q0 + nz) / facing


@njit(cache=True, nogil=True)
def _add_consistent(
    own: _MapArrays,
    other: _MapArrays,
    tolerance_px: float,
    least_cosine: float,
    votes: np.ndarray,
):
    """Add one vote at each pixel that the other map is consistent with."""
    depth, normal, view = own
    other_depth, other_normal, other_view = other
    height, width = depth.shape
    other_height, other_width = other_depth.shape
    for row in range(height):
        for column in range(width):
            depth_mm = depth[row, column]
            if not depth_mm > 0:
                continue
            x, y, z = unproject_pixel(view, column, row, depth_mm)
            u, v, expected = project_point(other_view, x, y, z)
            if not (
                expected > 0 and u > 0 and v > 0 and u < other_width - 1 and v < other_height - 1
            ):
                continue
            i, j = int(u + 0.5), int(v + 0.5)
            measured = other_depth[j, i]
            if not measured > 0:
                continue
            nx, ny, nz = other_normal[j, i]
            plane_depth = depth_on_plane(other, i, j, u, v)
            if abs(plane_depth - expected) > _DEPTH_TOLERANCE * expected:
                continue
            ox, oy, oz = to_world_direction(other_view, nx, ny, nz)
            mx, my, mz = to_world_direction(
                view, normal[row, column, 0], normal[row, column, 1], normal[row, column, 2]
            )
            if ox * mx + oy * my + oz * mz < least_cosine:
                continue
            x, y, z = unproject_pixel(other_view, u, v, plane_depth)
            back_u, back_v, _ = project_point(view, x, y, z)
            if (back_u - column) ** 2 + (back_v - row) ** 2 <= tolerance_px**2:
                votes[row, column] += 1


DEFAULTS = DenseOptions()

_MOST_ANGLE_DEG = 65.0
"""Photos with this angle between their rays are still compared, if no narrower ones serve."""
_CROP_BYTES_A_PIXEL = 2.0
"""A pixel of a photo, for its mask while it is cropped."""
_COARSE_TOLERANCE_PX, _COARSE_TOLERANCE_DEG = 1.5, 60.0
"""How closely a coarse map must agree with another one: return to the pixel, and normals."""
_TOLERANCE_PX = 0.75
"""How close to itself a point must return from another photo's depth map, in pixels of the
reduced photo."""
_TOLERANCE_DEG = 35.0
"""How far the normals of two depth maps may differ."""
_LEAST_CONSISTENT = 2
"""Other maps that must be consistent (all, where there are fewer)."""
_LEAST_MEASURED = 0.05
"""Share of the region's pixels without whose depths the photos are refused."""
_SURROUNDINGS_PX = 3
"""Pixels round a confirmed one that are looked at again, at the coarsest level."""
_SOURCES = 5
"""Other photos that each photo is compared with; the kernels take MOST_SOURCES."""


def estimate_depth(
    photos: PhotoSet, metric: MetricScene, region: Region, options: DenseOptions = DEFAULTS
) -> tuple[DepthMap, ...]:
    """Depth maps of all placed photos that show the region.

    Raises:
        DenseError: fewer than two photos show the region, or too little could be matched.
    """
    crops = _crops_of_region(photos, metric, region, options)
    source_views = _source_views(metric, region, crops)
    crops = [crop for crop in crops if source_views[crop.photo_idx]]
    if len(crops) < 2:
        raise DenseError("depth.no_neighbours")
    crop_of_photo = {crop.photo_idx: k for k, crop in enumerate(crops)}
    sources = [[crop_of_photo[photo] for photo in source_views[crop.photo_idx]] for crop in crops]
    crop_idxs = range(len(crops))

    coarse_level = pyramid_level(crops, HALVINGS)
    coarse = in_parallel(lambda k: solve_coarse(coarse_level, k, sources[k], options), crop_idxs)
    rough = [depth_map_of(field, region) for field in coarse]
    finer_levels = [pyramid_level(crops, halvings) for halvings in range(HALVINGS - 1, -1, -1)]

    def fine(k: int) -> DepthMap:
        wanted = _pixels_to_refine(crops[k], rough[k], [rough[j] for j in sources[k]])
        field = solve_fine(finer_levels, k, sources[k], wanted, coarse[k], options)
        return depth_map_of(field, region)

    maps = in_parallel(fine, crop_idxs)
    checked_by = [
        sorted({*sources[k], *(j for j in crop_idxs if k in sources[j])}) for k in crop_idxs
    ]
    confirmed = in_parallel(
        lambda k: _confirmed(maps[k], [maps[j] for j in checked_by[k]]), crop_idxs
    )
    _require_measured(photos, crops, confirmed)
    return tuple(confirmed)


def _crops_of_region(
    photos: PhotoSet, metric: MetricScene, region: Region, options: DenseOptions
) -> list[Crop]:
    scene = metric.scene
    reduction = reduction_for(region, scene.views, options.most_px)
    found = in_parallel(
        lambda k: crop_photo(photos.photos[k], k, scene.view(k), region, reduction),
        scene.placed,
        each_mb=in_flight_mb(photos.photos, _CROP_BYTES_A_PIXEL),
    )
    crops = [crop for crop in found if crop is not None]
    if len(crops) < 2:
        raise DenseError("depth.region_unseen", showing=len(crops), placed=len(scene.placed))
    return crops


def _source_views(
    metric: MetricScene, region: Region, crops: Sequence[Crop]
) -> dict[int, list[int]]:
    """Source views of each photo, best first; without any, the photos it is a source of."""
    showing = [crop.photo_idx for crop in crops]
    selection = SourceViewOptions(most=_SOURCES, most_angle_deg=_MOST_ANGLE_DEG)
    chosen = select_source_views(metric, region, selection)
    own = {photo: [other for other in chosen[photo] if other in showing] for photo in showing}
    return {
        photo: own[photo] or [k for k in showing if photo in own[k]][:_SOURCES] for photo in showing
    }


def _pixels_to_refine(crop: Crop, rough: DepthMap, others: Sequence[DepthMap]) -> Mask:
    """Wanted pixels that another coarse map confirms, and their surroundings."""
    votes = count_consistent_maps(rough, others, _COARSE_TOLERANCE_PX, _COARSE_TOLERANCE_DEG)
    place_px = 1 << HALVINGS
    near = np.zeros((crop.wanted.shape[0] // place_px, crop.wanted.shape[1] // place_px), np.uint8)
    top, left = rough.y0 - crop.y0 // place_px, rough.x0 - crop.x0 // place_px
    near[top : top + votes.shape[0], left : left + votes.shape[1]] = votes > 0
    side = 2 * _SURROUNDINGS_PX + 1
    near = cv2.dilate(near, np.ones((side, side), np.uint8)) > 0
    return crop.wanted & np.repeat(np.repeat(near, place_px, 0), place_px, 1)


def _confirmed(depth_map: DepthMap, others: Sequence[DepthMap]) -> DepthMap:
    """The depth map without the pixels that too few other maps are consistent with."""
    votes = count_consistent_maps(
        depth_map, others, _TOLERANCE_PX / STEPS_BY_LEVEL[-1], _TOLERANCE_DEG
    )
    kept = votes >= max(1, min(_LEAST_CONSISTENT, len(others)))
    return replace(
        depth_map,
        depth_mm=np.where(kept, depth_map.depth_mm, np.float32(np.nan)),
        confidence=np.where(kept, depth_map.confidence, np.float32(0)),
    )


def _require_measured(
    photos: PhotoSet, crops: Sequence[Crop], depth_maps: Sequence[DepthMap]
) -> None:
    wanted = sum(int(crop.wanted.sum()) for crop in crops)
    measured = STEPS_BY_LEVEL[-1] ** 2 * sum(
        int(np.isfinite(depth_map.depth_mm).sum()) for depth_map in depth_maps
    )
    if measured < _LEAST_MEASURED * wanted:
        cause = common_fault(photos.photos) or doubt("depth.unpainted")
        raise DenseError("depth.bare", share=measured / wanted, cause=cause)
