"""Estimation: depth and normal of every pixel that shows the region, photo by photo.

In      the photos, a MetricScene, a Region.
Out     one DepthMap a photo, holding only what other photos' maps confirm.
Method  pinhole crops; PatchMatch from a quarter of the crop's scale to the whole; sub-pixel
        polish; then a pixel stays if enough other maps have its point with a similar normal.
Fails   DenseError: too few photos show the region, or next to nothing could be matched.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float32, Float64

from limbgram.dense.depth import DepthMap
from limbgram.dense.region import Region
from limbgram.dense.stereo import patchmatch
from limbgram.dense.stereo.agreement import agreeing
from limbgram.dense.stereo.crops import HALVINGS, Crop, crop_photo, reduction_for
from limbgram.dense.stereo.lanes import MOST_SOURCES, distance_weights, grey_weights
from limbgram.dense.stereo.pyramid import Level, finer, level_of
from limbgram.errors import DenseError, OptionsError
from limbgram.geometry.arrays import Mask
from limbgram.photos.photo import PhotoSet
from limbgram.run import in_parallel
from limbgram.scale.metric import MetricScene


@dataclass(frozen=True, kw_only=True)
class StereoOptions:
    """How finely and how strictly depth is measured."""

    most_px: int = 12_000_000
    """Pixels of all depth maps together: more are avoided by reducing the photos."""
    sources: int = 5
    """Other photos that each photo is compared with."""
    sigma_grey: float = 40.0
    """Grey difference from the window's centre at which a sample's weight falls to 0.6."""
    sigma_px: float = 4.0
    """Distance from the window's centre at which a sample's weight falls to 0.6."""
    sweeps: tuple[int, int, int] = (5, 2, 2)
    """Rounds of propagation at a quarter, a half and the whole of the crop's scale."""
    least_correlation: float = 0.5
    """Places that correlate worse are not measured."""
    max_incidence_deg: float = 78.0
    """Places seen more slantingly are not measured."""
    agree_px: float = 0.75
    """How close to itself a point must return from another photo's depth map."""
    agree_deg: float = 35.0
    """How far the normals of two depth maps may differ."""
    least_agreeing: int = 2
    """Other maps that must agree (fewer where there are fewer)."""
    least_measured: float = 0.04
    """Refuse if less of the region's pixels than this fraction was measured."""
    seed: int = 1
    """Start of the random numbers."""


DEFAULTS = StereoOptions()

_FIRST_STEP_PX = (8.0, 1.0, 0.5)
"""First random change of depth by pyramid level, as movement in the sources."""
_FIRST_TILT = (0.6, 0.2, 0.1)
"""First random change of the slopes by pyramid level."""
_FALL = 0.45
"""Each sweep's random changes are this fraction of the last one's."""
_POLISH_PX = (0.5, 0.25)
_LEAST_TRUST = 0.3
"""Photos that correlate worse take no part in the sub-pixel polish."""


def estimate_depth(
    photos: PhotoSet, metric: MetricScene, region: Region, options: StereoOptions = DEFAULTS
) -> tuple[DepthMap, ...]:
    """Depth maps of all placed photos that show the region.

    Raises:
        DenseError: fewer than two photos show the region, or too little could be matched.
    """
    if not 1 <= options.sources <= MOST_SOURCES:
        raise OptionsError(f"sources must lie between 1 and {MOST_SOURCES}.")
    crops = _crops(photos, metric, region, options)
    sources = _sources(crops, options)
    maps = in_parallel(lambda k: _estimate(crops[k], [crops[j] for j in sources[k]], region, options), range(len(crops)))
    wanted_px = sum(int(crop.wanted.sum()) for crop in crops)
    confirmed = in_parallel(
        lambda k: _confirmed(maps[k], [maps[j] for j in sources[k]], options), range(len(maps))
    )
    measured_px = sum(int(np.isfinite(depth_map.depth_mm).sum()) for depth_map in confirmed)
    if measured_px < options.least_measured * wanted_px:
        raise DenseError(
            f"Only {measured_px / wanted_px:.1%} of the limb's pixels could be measured; the photos "
            "show too little there that can be told apart. The sock is probably unpainted, or the "
            "photos are blurred. Paint it with dense, irregular spots, and photograph again."
        )
    return tuple(confirmed)


def _crops(
    photos: PhotoSet, metric: MetricScene, region: Region, options: StereoOptions
) -> list[Crop]:
    scene = metric.scene
    reduction = reduction_for(region, scene.views, options.most_px)
    found = in_parallel(
        lambda k: crop_photo(photos.photos[k], k, scene.view(k), region, reduction), scene.placed
    )
    crops = [crop for crop in found if crop is not None]
    if len(crops) < 2:
        raise DenseError(
            f"{len(crops)} of {len(scene.placed)} placed photos show the region; 2 are needed. "
            "The box or the masks probably miss the limb. Correct them, or leave them out."
        )
    return crops


def _sources(crops: Sequence[Crop], options: StereoOptions) -> list[list[int]]:
    axes = np.stack([crop.view.camera_from_world.rotation[2] for crop in crops])
    angles = np.degrees(np.arccos(np.clip(axes @ axes.T, -1, 1)))
    return [
        [int(j) for j in np.argsort(angles[k], kind="stable") if 4 < angles[k, j] < 60][: options.sources]
        for k in range(len(crops))
    ]


def _estimate(
    crop: Crop, sources: Sequence[Crop], region: Region, options: StereoOptions
) -> DepthMap:
    """Depth map of one crop as PatchMatch leaves it, without what is plainly wrong."""
    w_range = np.array([1 / crop.far_mm, 1 / crop.near_mm])
    state = score = np.zeros(0, np.float32)
    for halvings in range(HALVINGS, -1, -1):
        level = level_of(crop, sources, halvings)
        if halvings == HALVINGS:
            state = np.zeros((3, level.wanted.size), np.float32)
            pixels = np.concatenate(level.red_and_black)
            patchmatch.start(pixels, w_range, level.focal_px, options.seed, state)
        else:
            state = finer(state, level.wanted)
        score = _solve(level, HALVINGS - halvings, w_range, state, options)
    return _depth_map(crop, state, score, region, options)


def _solve(
    level: Level,
    step: int,
    w_range: Float64[np.ndarray, "2"],
    state: Float32[np.ndarray, "3 n"],
    options: StereoOptions,
) -> Float32[np.ndarray, " n"]:
    """Improve the planes of one level in place; returns their scores."""
    picture = (
        level.grey, level.width,
        grey_weights(options.sigma_grey), distance_weights(options.sigma_px),
    )  # fmt: skip
    sources = (level.words, level.table, level.a, level.b, min(3, (len(level.table) + 1) // 2))
    red, black = level.red_and_black
    both = np.concatenate([red, black])
    score = np.full(level.wanted.size, -2, np.float32)
    patchmatch.rate(picture, sources, both, w_range, state, score)
    for turn in range(options.sweeps[step]):
        w_step = _FIRST_STEP_PX[step] * _FALL**turn * level.w_per_px
        tilt_step = _FIRST_TILT[step] * _FALL**turn
        seed = options.seed + 1000 * (step + 1) + turn
        for colour in (red, black):
            patchmatch.sweep(
                picture, sources, colour, w_range, level.focal_px, w_step, tilt_step, seed,
                state, score,
            )  # fmt: skip
    if step == HALVINGS:
        for step_px in _POLISH_PX:
            w_step = step_px * level.w_per_px
            patchmatch.polish(
                picture, sources, both, w_range, w_step, _LEAST_TRUST, state, score
            )
    return score


def _depth_map(
    crop: Crop,
    state: Float32[np.ndarray, "3 n"],
    score: Float32[np.ndarray, " n"],
    region: Region,
    options: StereoOptions,
) -> DepthMap:
    shape = crop.grey.shape
    camera = crop.view.camera
    rows, columns = np.nonzero(((score >= options.least_correlation) & (state[0] > 0)).reshape(shape))
    w, gx, gy = state.reshape(3, *shape)[:, rows, columns].astype(float)
    y = (rows + crop.y0 - camera.cy) / camera.fy
    x = (columns + crop.x0 - camera.cx - camera.skew * y) / camera.fx
    normal_x, normal_y = gx * camera.fx, gy * camera.fy + gx * camera.skew
    normal = -np.stack([normal_x, normal_y, w - normal_x * x - normal_y * y], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    ray = np.stack([x, y, np.ones_like(x)], axis=-1)
    facing = -(normal * ray).sum(-1) / np.linalg.norm(ray, axis=-1)
    points = crop.view.camera_from_world.inverse.apply(ray / w[:, None])
    good = (facing > np.cos(np.radians(options.max_incidence_deg))) & region.contains(points)

    depth_mm = np.full(shape, np.nan, np.float32)
    normals = np.zeros((*shape, 3), np.float32)
    confidence = np.zeros(shape, np.float32)
    rows, columns = rows[good], columns[good]
    depth_mm[rows, columns] = 1 / w[good]
    normals[rows, columns] = normal[good]
    confidence[rows, columns] = np.clip(score.reshape(shape)[rows, columns], 0, 1)
    return DepthMap(
        photo_idx=crop.photo_idx, camera=camera, camera_from_world=crop.view.camera_from_world,
        x0=crop.x0, y0=crop.y0, depth_mm=depth_mm, normal_in_camera=normals, confidence=confidence,
    )  # fmt: skip


def _confirmed(
    depth_map: DepthMap, others: Sequence[DepthMap], options: StereoOptions
) -> DepthMap:
    """Only what enough other maps agree with."""
    votes = agreeing(depth_map, others, options.agree_px, options.agree_deg)
    kept = votes >= min(options.least_agreeing, len(others))
    return replace(
        depth_map,
        depth_mm=np.where(kept, depth_map.depth_mm, np.float32(np.nan)),
        confidence=np.where(kept, depth_map.confidence, np.float32(0)),
    )
