"""Photo depth: one photo's depth map by PatchMatch from its source views, coarse to fine."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float32, Float64, Int64

from limbgram.core.geometry.arrays import Mask
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.dense import patchmatch
from limbgram.reconstruction.dense.crops import HALVINGS, Crop, Halved, Level, finer, level_of
from limbgram.reconstruction.dense.depth import DepthMap
from limbgram.reconstruction.dense.patchmatch import distance_weights, grey_weights, window_px2
from limbgram.reconstruction.dense.region import Region

_SIGMA_GREY = 40.0
"""Grey difference from the window's centre at which a sample's weight falls to 0.6."""
_SWEEPS = (5, 2, 2)
"""Rounds of propagation at a quarter, a half and the whole of the crop's scale."""
_LEAST_CORRELATION = 0.5
"""Places that correlate worse are not measured."""


_MAX_INCIDENCE_DEG = 78.0
"""Places seen more slantingly are not measured."""
AGREE_PX = 0.75
"""How close to itself a point must return from another photo's depth map, in pixels of the
reduced photo."""
AGREE_DEG = 35.0
"""How far the normals of two depth maps may differ."""
LEAST_AGREEING = 2
"""Other maps that must agree (fewer where there are fewer)."""
LEAST_MEASURED = 0.05
"""Refuse if less of the region's pixels than this fraction was measured."""


@dataclass(frozen=True, kw_only=True)
class DenseOptions:
    """How finely and how strictly depth is measured."""

    most_px: int = 8_000_000
    """Pixels of all photos that show the region: they are reduced until there are no more."""
    sources: int = 5
    """Other photos that each photo is compared with."""
    sigma_px: float = 3.0
    """Distance from the window's centre at which a sample's weight falls to 0.6."""
    seed: int = 1
    """Start of the random numbers."""


Planes = Float32[np.ndarray, "3 n"]
"""Inverse depth of each place (1/mm; 0 where there is none) and its change per pixel."""

STEPS = (1, 2, 2)
"""Pixels from one place to the next, by pyramid level."""
_FIRST_STEP_PX = (8.0, 1.0, 0.5)
"""First random change of depth by pyramid level, as movement in the sources."""
_FIRST_TILT = (0.6, 0.2, 0.1)
"""First random change of the slopes by pyramid level."""
_FALL = 0.45
"""Each sweep's random changes are this fraction of the last one's."""
_POLISH_PX = 0.4
"""Spacing of the correlations through which the sub-pixel parabola goes, as movement."""
_LEAST_TRUST = 0.3
"""Photos that correlate worse take no part in the sub-pixel polish."""


@dataclass(frozen=True)
class Solution:
    """The planes of one crop at one pyramid level."""

    crop: Crop
    halvings: int
    step: int
    """Pixels of the halved crop from one place to the next."""
    shape: tuple[int, int]
    """Rows and columns of places."""
    planes: Planes
    score: Float32[np.ndarray, " n"]


def solve_coarse(
    pictures: Halved, own: int, sources: Sequence[int], options: DenseOptions
) -> Solution:
    """Planes at the coarsest level, found from nothing but the region's depths."""
    crop = pictures.crops[own]
    level = level_of(pictures, own, sources, crop.wanted, STEPS[0])
    planes = np.zeros((3, level.wanted.size), np.float32)
    places = np.concatenate(level.red_and_black)
    patchmatch.start(places, _w_range(crop), level.focal_px, options.seed, planes)
    score = _improve(level, 0, crop, planes, options)
    return Solution(crop, pictures.halvings, level.step, level.wanted.shape, planes, score)


def solve_fine(
    finer_pictures: Sequence[Halved],
    own: int,
    sources: Sequence[int],
    wanted: Mask,
    coarse: Solution,
    options: DenseOptions,
) -> Solution:
    """Planes by the crop's own pixels, from those of the coarsest level.

    Args:
        finer_pictures: At half and at whole scale.
        wanted: Pixels of the crop itself that are sought.
    """
    solution = coarse
    for depth, pictures in enumerate(finer_pictures, start=1):
        level = level_of(pictures, own, sources, wanted, STEPS[depth])
        planes = finer(solution.planes, solution.shape, solution.step, level.wanted, level.step)
        score = _improve(level, depth, coarse.crop, planes, options)
        solution = Solution(
            coarse.crop, pictures.halvings, level.step, level.wanted.shape, planes, score
        )
    return solution


def depth_map_of(solution: Solution, region: Region, options: DenseOptions) -> DepthMap:
    """What a solution says about the region, without what is plainly wrong."""
    crop = solution.crop
    shape, side = solution.shape, solution.step << solution.halvings
    camera = at_places(crop.view.camera.scaled(0.5**solution.halvings), solution.step)
    x0, y0 = crop.x0 // side, crop.y0 // side
    good = (solution.score >= _LEAST_CORRELATION) & (solution.planes[0] > 0)
    rows, columns = np.nonzero(good.reshape(shape))
    w, gx, gy = solution.planes.reshape(3, *shape)[:, rows, columns].astype(float)
    gx, gy = solution.step * gx, solution.step * gy
    y = (rows + y0 - camera.cy) / camera.fy
    x = (columns + x0 - camera.cx - camera.skew * y) / camera.fx
    normal_x, normal_y = gx * camera.fx, gy * camera.fy + gx * camera.skew
    normal = -np.stack([normal_x, normal_y, w - normal_x * x - normal_y * y], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    ray = np.stack([x, y, np.ones_like(x)], axis=-1)
    facing = -(normal * ray).sum(-1) / np.linalg.norm(ray, axis=-1)
    points = crop.view.camera_from_world.inverse.apply(ray / w[:, None])
    kept = (facing > np.cos(np.radians(_MAX_INCIDENCE_DEG))) & region.contains(points)
    return _trimmed(
        crop.photo_idx, View(crop.view.name, camera, crop.view.camera_from_world),
        np.stack([rows[kept] + y0, columns[kept] + x0]),
        1 / w[kept], normal[kept], solution.score.reshape(shape)[rows, columns][kept],
        window_px2(distance_weights(options.sigma_px)) / solution.step**2,
    )  # fmt: skip


def at_places(camera: Camera, step: int) -> Camera:
    """The camera whose pixels are every step-th pixel of every step-th row, from the first on."""
    return replace(camera.scaled(1 / step), cx=camera.cx / step, cy=camera.cy / step)


def _trimmed(
    photo_idx: int,
    view: View,
    places: Int64[np.ndarray, "2 k"],
    depths_mm: Float64[np.ndarray, " k"],
    normals: Float64[np.ndarray, "k 3"],
    scores: Float32[np.ndarray, " k"],
    window: float,
) -> DepthMap:
    """A map just large enough for its measured pixels, given by row and column of the photo."""
    corner = places.min(1) if places.size else np.zeros(2, int)
    rows, columns = places - corner[:, None]
    shape = (int(rows.max()) + 1, int(columns.max()) + 1) if places.size else (0, 0)
    depth_mm = np.full(shape, np.nan, np.float32)
    normal_in_camera = np.zeros((*shape, 3), np.float32)
    confidence = np.zeros(shape, np.float32)
    depth_mm[rows, columns] = depths_mm
    normal_in_camera[rows, columns] = normals
    confidence[rows, columns] = np.clip(scores, 0, 1)
    return DepthMap(
        photo_idx=photo_idx,
        camera=view.camera,
        camera_from_world=view.camera_from_world,
        x0=int(corner[1]),
        y0=int(corner[0]),
        depth_mm=depth_mm,
        normal_in_camera=normal_in_camera,
        confidence=confidence,
        window_px2=window,
    )


def _w_range(crop: Crop) -> Float64[np.ndarray, "2"]:
    """Least and largest inverse depth of the region, 1/mm."""
    return np.array([1 / crop.far_mm, 1 / crop.near_mm])


def _improve(
    level: Level, step: int, crop: Crop, planes: Planes, options: DenseOptions
) -> Float32[np.ndarray, " n"]:
    """Improve the planes of one level in place; returns their scores."""
    picture = (
        level.grey, level.width, level.step,
        grey_weights(_SIGMA_GREY), distance_weights(options.sigma_px),
    )  # fmt: skip
    better_half = min(3, (len(level.table) + 1) // 2)
    sources = (level.words, level.table, level.a, level.b, better_half)
    red, black = level.red_and_black
    both = np.concatenate([red, black])
    w_range = _w_range(crop)
    score = np.full(level.wanted.size, -2, np.float32)
    patchmatch.rate(picture, sources, both, w_range, planes, score)
    for turn in range(_SWEEPS[step]):
        w_step = _FIRST_STEP_PX[step] * _FALL**turn * level.w_per_px
        tilt_step = _FIRST_TILT[step] * _FALL**turn
        seed = options.seed + 1000 * (step + 1) + turn
        for colour in (red, black):
            patchmatch.sweep(
                picture, sources, colour, w_range, level.focal_px, w_step, tilt_step, seed,
                planes, score,
            )  # fmt: skip
    if step == HALVINGS:
        w_step = _POLISH_PX * level.w_per_px
        patchmatch.polish(picture, sources, both, w_range, w_step, _LEAST_TRUST, planes, score)
    return score
