"""Estimation: depth and normal wherever a photo shows the region, photo by photo.

In      the photos, a MetricScene, a Region.
Out     one DepthMap a photo, holding only what other photos' maps confirm.
Method  Pinhole crops; PatchMatch at a quarter of their scale; what other photos confirm there,
        and its surroundings, again at half and whole scale with a sub-pixel polish; then a place
        stays if enough other maps have its point with a similar normal.
        Places: at half and whole scale depth is sought at every second pixel of every second row,
        with whole windows. Windows of neighbouring pixels share nearly all they see, and the cloud
        asks for no more points.
        Confirmation: a place's point is taken into another photo, onto the plane that was measured
        there, and back. It agrees if it returns to within a fraction of a pixel, at about the same
        depth, with a similar normal. Matches that are wrong rarely do so twice.
Fails   DenseError: too few photos show the region, or next to nothing could be matched.
"""

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from jaxtyping import Float64, UInt16

from limbgram.core.errors import DenseError, OptionsError
from limbgram.core.geometry.arrays import Mask
from limbgram.core.kernels import njit
from limbgram.core.run import in_parallel
from limbgram.findings import doubt
from limbgram.reconstruction.dense.crops import HALVINGS, Crop, crop_photo, halved, reduction_for
from limbgram.reconstruction.dense.depth import DepthMap
from limbgram.reconstruction.dense.patchmatch import MOST_SOURCES
from limbgram.reconstruction.dense.photo_depth import (
    AGREE_DEG,
    AGREE_PX,
    LEAST_AGREEING,
    LEAST_MEASURED,
    STEPS,
    DenseOptions,
    depth_map_of,
    solve_coarse,
    solve_fine,
)
from limbgram.reconstruction.dense.region import Region
from limbgram.reconstruction.dense.source_views import NeighbourOptions, choose_neighbours
from limbgram.reconstruction.photos.decoding import in_flight_mb
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.photos.quality import common_fault
from limbgram.reconstruction.scale.metric import MetricScene

_DEPTH_TOLERANCE = 0.02
"""Relative; only to keep apart surfaces that a return to the same pixel would not."""


def agreeing(
    depth_map: DepthMap, others: Sequence[DepthMap], agree_px: float, agree_deg: float
) -> UInt16[np.ndarray, "h w"]:
    """Number of other maps that agree, by pixel."""
    votes = np.zeros(depth_map.depth_mm.shape, np.uint16)
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
def into_view(view: np.ndarray, x: float, y: float, z: float):
    """World point to pixel and depth."""
    a = view[0] * x + view[1] * y + view[2] * z + view[9]
    b = view[3] * x + view[4] * y + view[5] * z + view[10]
    c = view[6] * x + view[7] * y + view[8] * z + view[11]
    p, q = a / c, b / c
    return view[12] * p + view[16] * q + view[14], view[13] * q + view[15], c


@njit(inline="always")
def out_of_view(view: np.ndarray, u: float, v: float, depth: float):
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
def turned_out(view: np.ndarray, nx: float, ny: float, nz: float):
    """Direction in the camera to direction in the world."""
    return (
        view[0] * nx + view[3] * ny + view[6] * nz,
        view[1] * nx + view[4] * ny + view[7] * nz,
        view[2] * nx + view[5] * ny + view[8] * nz,
    )


@njit(inline="always")
def depth_on_plane(
    view: np.ndarray,
    u: float,
    v: float,
    column: float,
    row: float,
    depth: float,
    nx: float,
    ny: float,
    nz: float,
):
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
    depth: np.ndarray,
    normal: np.ndarray,
    view: np.ndarray,
    other_depth: np.ndarray,
    other_normal: np.ndarray,
    other_view: np.ndarray,
    agree_px: float,
    least_cosine: float,
    votes: np.ndarray,
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


DEFAULTS = DenseOptions()

_WIDEST_DEG = 65.0
"""Photos with this angle between their rays are still compared, if no narrower ones serve."""
_CROP_BYTES = 2.0
"""A pixel of a photo, for its mask while it is cropped."""
_COARSE_AGREE_PX, _COARSE_AGREE_DEG = 1.5, 60.0
"""How closely a rough map must agree with another one."""
_SURROUNDINGS_PX = 3
"""Pixels round a confirmed one that are looked at again, at the coarsest level."""


def estimate_depth(
    photos: PhotoSet, metric: MetricScene, region: Region, options: DenseOptions = DEFAULTS
) -> tuple[DepthMap, ...]:
    """Depth maps of all placed photos that show the region.

    Raises:
        DenseError: fewer than two photos show the region, or too little could be matched.
    """
    if not 1 <= options.sources <= MOST_SOURCES:
        raise OptionsError("depth.sources", most=MOST_SOURCES)
    crops = _crops(photos, metric, region, options)
    neighbours = _neighbours(metric, region, crops, options)
    crops = [crop for crop in crops if neighbours[crop.photo_idx]]
    if len(crops) < 2:
        raise DenseError("depth.no_neighbours")
    of_photo = {crop.photo_idx: k for k, crop in enumerate(crops)}
    sources = [[of_photo[photo] for photo in neighbours[crop.photo_idx]] for crop in crops]
    every = range(len(crops))

    quarter = halved(crops, HALVINGS)
    coarse = in_parallel(lambda k: solve_coarse(quarter, k, sources[k], options), every)
    rough = [depth_map_of(solution, region, options) for solution in coarse]
    finer_pictures = [halved(crops, halvings) for halvings in range(HALVINGS - 1, -1, -1)]

    def fine(k: int) -> DepthMap:
        wanted = _worth_it(crops[k], rough[k], [rough[j] for j in sources[k]])
        solution = solve_fine(finer_pictures, k, sources[k], wanted, coarse[k], options)
        return depth_map_of(solution, region, options)

    maps = in_parallel(fine, every)
    witnesses = [sorted({*sources[k], *(j for j in every if k in sources[j])}) for k in every]
    confirmed = in_parallel(lambda k: _confirmed(maps[k], [maps[j] for j in witnesses[k]]), every)
    _refuse_if_bare(photos, crops, confirmed)
    return tuple(confirmed)


def _crops(
    photos: PhotoSet, metric: MetricScene, region: Region, options: DenseOptions
) -> list[Crop]:
    scene = metric.scene
    reduction = reduction_for(region, scene.views, options.most_px)
    found = in_parallel(
        lambda k: crop_photo(photos.photos[k], k, scene.view(k), region, reduction),
        scene.placed,
        each_mb=in_flight_mb(photos.photos, _CROP_BYTES),
    )
    crops = [crop for crop in found if crop is not None]
    if len(crops) < 2:
        raise DenseError("depth.region_unseen", showing=len(crops), placed=len(scene.placed))
    return crops


def _neighbours(
    metric: MetricScene, region: Region, crops: Sequence[Crop], options: DenseOptions
) -> dict[int, list[int]]:
    """By photo, the photos to compare it with, best first; without own choice, who chose it."""
    looked_at = [crop.photo_idx for crop in crops]
    choice = NeighbourOptions(most=options.sources, most_angle_deg=_WIDEST_DEG)
    chosen = choose_neighbours(metric, region, choice)
    own = {photo: [other for other in chosen[photo] if other in looked_at] for photo in looked_at}
    return {
        photo: own[photo] or [k for k in looked_at if photo in own[k]][: options.sources]
        for photo in looked_at
    }


def _worth_it(crop: Crop, rough: DepthMap, others: Sequence[DepthMap]) -> Mask:
    """Wanted pixels that another rough map confirms, and their surroundings."""
    votes = agreeing(rough, others, _COARSE_AGREE_PX, _COARSE_AGREE_DEG)
    cells = 1 << HALVINGS
    near = np.zeros((crop.wanted.shape[0] // cells, crop.wanted.shape[1] // cells), np.uint8)
    top, left = rough.y0 - crop.y0 // cells, rough.x0 - crop.x0 // cells
    near[top : top + votes.shape[0], left : left + votes.shape[1]] = votes > 0
    side = 2 * _SURROUNDINGS_PX + 1
    near = cv2.dilate(near, np.ones((side, side), np.uint8)) > 0
    return crop.wanted & np.repeat(np.repeat(near, cells, 0), cells, 1)


def _confirmed(depth_map: DepthMap, others: Sequence[DepthMap]) -> DepthMap:
    """Only what enough other maps agree with."""
    votes = agreeing(depth_map, others, AGREE_PX / STEPS[-1], AGREE_DEG)
    kept = votes >= max(1, min(LEAST_AGREEING, len(others)))
    return replace(
        depth_map,
        depth_mm=np.where(kept, depth_map.depth_mm, np.float32(np.nan)),
        confidence=np.where(kept, depth_map.confidence, np.float32(0)),
    )


def _refuse_if_bare(
    photos: PhotoSet, crops: Sequence[Crop], depth_maps: Sequence[DepthMap]
) -> None:
    wanted = sum(int(crop.wanted.sum()) for crop in crops)
    measured = STEPS[-1] ** 2 * sum(
        int(np.isfinite(depth_map.depth_mm).sum()) for depth_map in depth_maps
    )
    if measured < LEAST_MEASURED * wanted:
        cause = common_fault(photos.photos) or doubt("depth.unpainted")
        raise DenseError("depth.bare", share=measured / wanted, cause=cause)
