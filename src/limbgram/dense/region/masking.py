"""Masking: what the photos' masks say about points and cubes of the world."""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float32

from limbgram.dense.region.cubes import Region
from limbgram.geometry.arrays import Mask, Points3
from limbgram.geometry.camera import View
from limbgram.mapping.scene import Scene
from limbgram.photos import PhotoSet, load_mask
from limbgram.run import track
from limbgram.scale.sight import in_frame

_REDUCTION = 4
_ALLOWED_OUTSIDE = 0.1
"""Share of the masked photos that may contradict the others: a slip in one mask of many."""


@dataclass(frozen=True)
class MaskedView:
    """A placed photo and how far each of its pixels lies from the mask."""

    view: View
    """Of the photo reduced by _REDUCTION."""
    outside_px: Float32[np.ndarray, "h w"]
    """Distance from the nearest pixel of the limb; 0 on the limb. Reduced pixels."""


def masked_views(photos: PhotoSet, scene: Scene) -> tuple[MaskedView, ...]:
    """The placed photos that have a mask."""
    return tuple(_masked_views(photos, scene))


def _masked_views(photos: PhotoSet, scene: Scene) -> Iterator[MaskedView]:
    for photo_idx in track(scene.placed):
        photo = photos.photos[photo_idx]
        mask = load_mask(photo) if photo.mask_path is not None else None
        if mask is not None:
            view = scene.view(photo_idx)
            camera = view.camera.scaled(1 / _REDUCTION)
            reduced = View(view.name, camera, view.camera_from_world)
            yield MaskedView(reduced, _distance_outside(mask, (camera.width_px, camera.height_px)))


def inside_masks(
    masked: tuple[MaskedView, ...], points: Points3, slack_mm: float
) -> Bool[np.ndarray, " n"]:
    """Points that hardly a mask excludes; `slack_mm` is how far outside one they may be."""
    outside = np.zeros(len(points))
    for one in masked:
        framed = in_frame([one.view], points)[0]
        column, row = np.round(one.view.project(points[framed])).astype(int).T
        depth = one.view.camera_from_world.apply(points[framed])[:, 2]
        slack_px = one.view.camera.fx * slack_mm / depth + 0.5
        outside[framed] += one.outside_px[row, column] > slack_px
    return outside <= _ALLOWED_OUTSIDE * len(masked)


def carve(region: Region, masked: tuple[MaskedView, ...], slack_mm: float) -> Region:
    """The region without the cubes that the masks exclude."""
    slack_mm += region.cell_mm * float(np.sqrt(3)) / 2
    occupied = region.occupied.copy()
    occupied[occupied] = inside_masks(masked, region.centres_mm(region.occupied), slack_mm)
    return Region(origin_mm=region.origin_mm, cell_mm=region.cell_mm, occupied=occupied)


def _distance_outside(mask: Mask, size: tuple[int, int]) -> Float32[np.ndarray, "h w"]:
    touched = cv2.resize(mask.astype(np.float32), size, interpolation=cv2.INTER_AREA) > 0
    return np.asarray(
        cv2.distanceTransform((~touched).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE),
        np.float32,
    )
