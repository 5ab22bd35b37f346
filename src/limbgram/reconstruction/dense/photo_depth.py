"""Photo depth: one photo's depth map by PatchMatch from its source views, coarse to fine."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float32, Float64, Int64

from limbgram.core.geometry.arrays import Mask
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.dense import patchmatch
from limbgram.reconstruction.dense.crops import (
    HALVINGS,
    Crop,
    PyramidLevel,
    StereoProblem,
    stereo_problem,
    upsample_planes,
)
from limbgram.reconstruction.dense.depth import DepthMap
from limbgram.reconstruction.dense.patchmatch import (
    distance_weights,
    grey_weights,
    window_second_moment_px2,
)
from limbgram.reconstruction.dense.region import Region

_SIGMA_GREY = 40.0
"""Grey difference from the window's centre at which a sample's weight falls to 0.6."""
_SIGMA_PX = 3.0
"""Distance from the window's centre at which a sample's weight falls to 0.6."""
_SWEEPS_BY_LEVEL = (5, 2, 2)
"""Sweeps at a quarter, a half and the whole of the crop's scale."""
_LEAST_CORRELATION = 0.5
"""Places that correlate worse are not measured."""


_MAX_INCIDENCE_DEG = 78.0
"""Places seen more slantingly are not measured."""


@dataclass(frozen=True, kw_only=True)
class DenseOptions:
    """How finely depth is measured."""

    most_px: int = 8_000_000
    """Pixels of all photos that show the region: they are reduced until there are no more."""
    seed: int = 1
    """Start of the random numbers."""


Planes = Float32[np.ndarray, "3 n"]
"""Inverse depth of each place (1/mm; 0 where there is none) and its change per pixel."""

STEPS_BY_LEVEL = (1, 2, 2)
"""Pixels from one place to the next, by pyramid level."""
_FIRST_DEPTH_STEP_PX = (8.0, 1.0, 0.5)
"""First random change of depth by pyramid level, as movement in the sources."""
_FIRST_TILT_STEP = (0.6, 0.2, 0.1)
"""First random change of the slopes by pyramid level."""
_STEP_DECAY = 0.45
"""Each sweep's random changes are this fraction of the last one's."""
_PARABOLA_STEP_PX = 0.4
"""Spacing of the correlations through which the sub-pixel parabola goes, as movement."""
_LEAST_REFINING_CORRELATION = 0.3
"""Sources that correlate worse take no part in the sub-pixel refinement."""


@dataclass(frozen=True)
class PlaneField:
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
    level: PyramidLevel, reference_idx: int, sources: Sequence[int], options: DenseOptions
) -> PlaneField:
    """Planes at the coarsest level, found from nothing but the region's depths."""
    crop = level.crops[reference_idx]
    problem = stereo_problem(level, reference_idx, sources, crop.wanted, STEPS_BY_LEVEL[0])
    planes = np.zeros((3, problem.wanted.size), np.float32)
    places = np.concatenate(problem.red_and_black)
    patchmatch.initialise_planes(
        places, _inverse_depth_range(crop), problem.focal_px, options.seed, planes
    )
    score = _optimise_planes(problem, 0, crop, planes, options)
    return PlaneField(crop, level.halvings, problem.step, problem.wanted.shape, planes, score)


def solve_fine(
    finer_levels: Sequence[PyramidLevel],
    reference_idx: int,
    sources: Sequence[int],
    wanted: Mask,
    coarse: PlaneField,
    options: DenseOptions,
) -> PlaneField:
    """Planes by the crop's own pixels, from those of the coarsest level.

    Args:
        finer_levels: At half and at whole scale.
        wanted: Pixels of the crop itself that are sought.
    """
    field = coarse
    for level_idx, pyramid_level in enumerate(finer_levels, start=1):
        problem = stereo_problem(
            pyramid_level, reference_idx, sources, wanted, STEPS_BY_LEVEL[level_idx]
        )
        planes = upsample_planes(
            field.planes, field.shape, field.step, problem.wanted, problem.step
        )
        score = _optimise_planes(problem, level_idx, coarse.crop, planes, options)
        field = PlaneField(
            coarse.crop, pyramid_level.halvings, problem.step, problem.wanted.shape, planes, score
        )
    return field


def depth_map_of(field: PlaneField, region: Region) -> DepthMap:
    """The depth map of the planes that correlate, lie in the region and are not too slanted."""
    crop = field.crop
    shape, place_px = field.shape, field.step << field.halvings
    camera = subsampled_camera(crop.view.camera.scaled(0.5**field.halvings), field.step)
    x0, y0 = crop.x0 // place_px, crop.y0 // place_px
    good = (field.score >= _LEAST_CORRELATION) & (field.planes[0] > 0)
    rows, columns = np.nonzero(good.reshape(shape))
    w, gx, gy = field.planes.reshape(3, *shape)[:, rows, columns].astype(float)
    gx, gy = field.step * gx, field.step * gy
    y = (rows + y0 - camera.cy) / camera.fy
    x = (columns + x0 - camera.cx - camera.skew * y) / camera.fx
    normal_x, normal_y = gx * camera.fx, gy * camera.fy + gx * camera.skew
    normal = -np.stack([normal_x, normal_y, w - normal_x * x - normal_y * y], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    ray = np.stack([x, y, np.ones_like(x)], axis=-1)
    facing = -(normal * ray).sum(-1) / np.linalg.norm(ray, axis=-1)
    points = crop.view.camera_from_world.inverse.apply(ray / w[:, None])
    kept = (facing > np.cos(np.radians(_MAX_INCIDENCE_DEG))) & region.contains(points)
    return _trimmed_map(
        crop.photo_idx, View(crop.view.name, camera, crop.view.camera_from_world),
        np.stack([rows[kept] + y0, columns[kept] + x0]),
        1 / w[kept], normal[kept], field.score.reshape(shape)[rows, columns][kept],
        window_second_moment_px2(distance_weights(_SIGMA_PX)) / field.step**2,
    )  # fmt: skip


def subsampled_camera(camera: Camera, step: int) -> Camera:
    """The camera whose pixels are every step-th pixel of every step-th row, from the first on."""
    return replace(camera.scaled(1 / step), cx=camera.cx / step, cy=camera.cy / step)


def _trimmed_map(
    photo_idx: int,
    view: View,
    places: Int64[np.ndarray, "2 k"],
    depths_mm: Float64[np.ndarray, " k"],
    normals: Float64[np.ndarray, "k 3"],
    scores: Float32[np.ndarray, " k"],
    window: float,
) -> DepthMap:
    """A map just large enough for its measured pixels, given by row and column of the photo."""
    first = places.min(1) if places.size else np.zeros(2, int)
    rows, columns = places - first[:, None]
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
        x0=int(first[1]),
        y0=int(first[0]),
        depth_mm=depth_mm,
        normal_in_camera=normal_in_camera,
        confidence=confidence,
        window_px2=window,
    )


def _inverse_depth_range(crop: Crop) -> Float64[np.ndarray, "2"]:
    """Least and largest inverse depth of the region in a crop, 1/mm."""
    return np.array([1 / crop.far_mm, 1 / crop.near_mm])


def _optimise_planes(
    problem: StereoProblem, level_idx: int, crop: Crop, planes: Planes, options: DenseOptions
) -> Float32[np.ndarray, " n"]:
    """Optimise the planes of one level in place; returns their scores."""
    reference = (
        problem.grey, problem.width, problem.step,
        grey_weights(_SIGMA_GREY), distance_weights(_SIGMA_PX),
    )  # fmt: skip
    counted = min(3, (len(problem.table) + 1) // 2)
    sources = (problem.words, problem.table, problem.a, problem.b, counted)
    red, black = problem.red_and_black
    places = np.concatenate([red, black])
    w_range = _inverse_depth_range(crop)
    score = np.full(problem.wanted.size, -2, np.float32)
    patchmatch.score_planes(reference, sources, places, w_range, planes, score)
    for sweep in range(_SWEEPS_BY_LEVEL[level_idx]):
        depth_step = _FIRST_DEPTH_STEP_PX[level_idx] * _STEP_DECAY**sweep * problem.w_per_px
        tilt_step = _FIRST_TILT_STEP[level_idx] * _STEP_DECAY**sweep
        seed = options.seed + 1000 * (level_idx + 1) + sweep
        search = patchmatch.RandomSearch(depth_step, tilt_step, seed)
        for colour in (red, black):
            patchmatch.sweep(
                reference, sources, colour, w_range, problem.focal_px, search, planes, score
            )
    if level_idx == HALVINGS:
        depth_step = _PARABOLA_STEP_PX * problem.w_per_px
        patchmatch.refine_subpixel(
            reference,
            sources,
            places,
            w_range,
            depth_step,
            _LEAST_REFINING_CORRELATION,
            planes,
            score,
        )
    return score
