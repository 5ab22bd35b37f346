"""Estimation: depth and normal of every pixel that shows the region, photo by photo.

In      the photos, a MetricScene, a Region.
Out     one DepthMap a photo, holding only what other photos' maps confirm.
Method  pinhole crops; PatchMatch at a quarter of their scale; what other photos confirm there,
        and its surroundings, again at half and whole scale with a sub-pixel polish; then a pixel
        stays if enough other maps have its point with a similar normal.
Fails   DenseError: too few photos show the region, or next to nothing could be matched.
"""

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from limbgram.dense.depth import DepthMap
from limbgram.dense.neighbours import NeighbourOptions, choose_neighbours
from limbgram.dense.region import Region
from limbgram.dense.stereo.agreement import agreeing
from limbgram.dense.stereo.crops import HALVINGS, Crop, crop_photo, reduction_for
from limbgram.dense.stereo.lanes import MOST_SOURCES
from limbgram.dense.stereo.solving import (
    DenseOptions,
    depth_map_of,
    solve_coarse,
    solve_fine,
)
from limbgram.errors import DenseError, OptionsError
from limbgram.photos.decoding import in_flight_mb
from limbgram.photos.photo import PhotoSet
from limbgram.photos.quality import common_fault
from limbgram.run import in_parallel
from limbgram.scale.metric import MetricScene

DEFAULTS = DenseOptions()

_WIDEST_DEG = 65.0
"""Photos with this angle between their rays are still compared, if no narrower ones serve."""
_CROP_BYTES = 2.0
"""A pixel of a photo, for its mask while it is cropped."""
_COARSE_AGREE_PX, _COARSE_AGREE_DEG = 1.5, 60.0
"""How closely a rough map must agree with another one."""
_UNPAINTED = (
    "The sock is probably unpainted. Paint it with dense, irregular spots, and photograph again."
)
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
        raise OptionsError(f"sources must lie between 1 and {MOST_SOURCES}.")
    crops = _crops(photos, metric, region, options)
    neighbours = _neighbours(metric, region, crops, options)
    crops = [crop for crop in crops if neighbours[crop.photo_idx]]
    if len(crops) < 2:
        raise DenseError(
            "No two photos show the limb from directions that suit each other. Photograph all "
            "round the limb, with 10 to 25 degrees from one photo to the next."
        )
    of_photo = {crop.photo_idx: k for k, crop in enumerate(crops)}
    sources = [[of_photo[photo] for photo in neighbours[crop.photo_idx]] for crop in crops]
    every = range(len(crops))

    coarse = in_parallel(
        lambda k: solve_coarse(crops[k], [crops[j] for j in sources[k]], options), every
    )
    rough = [depth_map_of(solution, region, options) for solution in coarse]
    narrowed = [_narrowed(crops[k], rough[k], [rough[j] for j in sources[k]]) for k in every]

    def fine(k: int) -> DepthMap:
        solution = solve_fine(
            narrowed[k], [crops[j] for j in sources[k]], coarse[k].planes, options
        )
        return depth_map_of(solution, region, options)

    maps = in_parallel(fine, every)
    witnesses = [sorted({*sources[k], *(j for j in every if k in sources[j])}) for k in every]
    confirmed = in_parallel(
        lambda k: _confirmed(maps[k], [maps[j] for j in witnesses[k]], options), every
    )
    _refuse_if_bare(photos, crops, confirmed, options)
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
        raise DenseError(
            f"{len(crops)} of {len(scene.placed)} placed photos show the region; 2 are needed. "
            "The box or the masks probably miss the limb. Correct them, or leave them out."
        )
    return crops


def _neighbours(
    metric: MetricScene, region: Region, crops: Sequence[Crop], options: DenseOptions
) -> dict[int, list[int]]:
    """By photo, the photos to compare it with, best first; without own choice, who chose it."""
    shown = [crop.photo_idx for crop in crops]
    choice = NeighbourOptions(most=options.sources, most_angle_deg=_WIDEST_DEG)
    chosen = choose_neighbours(metric, region, choice)
    own = {photo: [other for other in chosen[photo] if other in shown] for photo in shown}
    return {
        photo: own[photo] or [k for k in shown if photo in own[k]][: options.sources]
        for photo in shown
    }


def _narrowed(crop: Crop, rough: DepthMap, others: Sequence[DepthMap]) -> Crop:
    """The crop wanting only what another rough map confirms, and the surroundings."""
    votes = agreeing(rough, others, _COARSE_AGREE_PX, _COARSE_AGREE_DEG)
    cells = 1 << HALVINGS
    near = np.zeros((crop.wanted.shape[0] // cells, crop.wanted.shape[1] // cells), np.uint8)
    top, left = rough.y0 - crop.y0 // cells, rough.x0 - crop.x0 // cells
    near[top : top + votes.shape[0], left : left + votes.shape[1]] = votes > 0
    side = 2 * _SURROUNDINGS_PX + 1
    near = cv2.dilate(near, np.ones((side, side), np.uint8)) > 0
    return replace(crop, wanted=crop.wanted & np.repeat(np.repeat(near, cells, 0), cells, 1))


def _confirmed(depth_map: DepthMap, others: Sequence[DepthMap], options: DenseOptions) -> DepthMap:
    """Only what enough other maps agree with."""
    votes = agreeing(depth_map, others, options.agree_px, options.agree_deg)
    kept = votes >= max(1, min(options.least_agreeing, len(others)))
    return replace(
        depth_map,
        depth_mm=np.where(kept, depth_map.depth_mm, np.float32(np.nan)),
        confidence=np.where(kept, depth_map.confidence, np.float32(0)),
    )


def _refuse_if_bare(
    photos: PhotoSet, crops: Sequence[Crop], depth_maps: Sequence[DepthMap], options: DenseOptions
) -> None:
    wanted = sum(int(crop.wanted.sum()) for crop in crops)
    measured = sum(int(np.isfinite(depth_map.depth_mm).sum()) for depth_map in depth_maps)
    if measured < options.least_measured * wanted:
        raise DenseError(
            f"Only {measured / wanted:.1%} of the limb's pixels could be measured; the photos "
            "show too little there that can be told apart. "
            + (common_fault(photos.photos) or _UNPAINTED)
        )
