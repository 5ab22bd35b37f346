"""Stickers: coded marks on limb or sock, in the placed photos; a named one is a landmark.

In      photos with their views in the frame of the surface, and which numbers are wanted.
Out     PlacedStickers: each sticker's middle in that frame with its sigma, or why it has none.
Method  the four corners are met from all photos that show them; a photo that puts them elsewhere
        than the others is left out. Their mean is the sticker's middle on its chord: on round
        skin it lies under the surface, straight below the middle, so that the nearest place of the
        surface is the landmark.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int32

from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.lens import View
from limbgram.core.geometry.triangulation import triangulate
from limbgram.core.interval import widening
from limbgram.findings import Finding, note
from limbgram.reconstruction.photos.photo import Photo, PhotoSet
from limbgram.reconstruction.targets.board import KIT_DICTIONARY
from limbgram.reconstruction.targets.marks import (
    MarkDetections,
    PhotoMarks,
    find_marks,
)

_LEAST_PHOTOS = 2
_MOST_OFF_PX = 1.5
_LEAST_AGREEING = 0.6
"""Of the photos that show a sticker, so many must agree on it."""
_CORNERS = 4
_LEAST_SIGMA_PX = 0.05


@dataclass(frozen=True, kw_only=True)
class PlacedSticker:
    """A sticker in the frame of the surface."""

    mark_id: int
    position_mm: Vector3
    sigma_mm: float
    """One standard deviation along one direction, by how the photos disagree; not the scale."""
    side_mm: float
    """Mean side, to be held against the print."""
    photos: tuple[str, ...]
    """Those that agree on it."""


@dataclass(frozen=True, kw_only=True)
class LostSticker:
    """A sticker that was seen or asked for, and has no place."""

    mark_id: int
    reason: Finding


@dataclass(frozen=True)
class PlacedStickers:
    """All stickers: those placed, and those without a place."""

    placed: tuple[PlacedSticker, ...]
    lost: tuple[LostSticker, ...]


def find_stickers(photos: Sequence[Photo], views: Sequence[View]) -> PlacedStickers:
    """All stickers that the photos show; `views` go with `photos`."""
    found = find_marks(
        PhotoSet(photos=tuple(photos), cameras=()),
        KIT_DICTIONARY,
        [view.camera for view in views],
    )
    return place_stickers(found, views)


def place_stickers(found: MarkDetections, views: Sequence[View]) -> PlacedStickers:
    """Place stickers whose marks were found; `views` are indexed by `photo_idx`."""
    placed: list[PlacedSticker] = []
    lost: list[LostSticker] = []
    doubted = {
        int(mark_id): doubt
        for photo in found.photos
        for mark_id, doubt in zip(photo.doubtful_ids, photo.doubts, strict=True)
    }
    for mark_id in sorted({*found.ids, *doubted}):
        shown = [photo for photo in found.photos if (photo.ids == mark_id).any()]
        one = _placed_sticker(mark_id, shown, views)
        if isinstance(one, PlacedSticker):
            placed.append(one)
        else:
            if mark_id in doubted:
                one = note("landmark.sticker.doubted", reason=one, doubt=doubted[mark_id])
            lost.append(LostSticker(mark_id=mark_id, reason=one))
    return PlacedStickers(tuple(placed), tuple(lost))


def _placed_sticker(
    mark_id: int, shown: Sequence[PhotoMarks], views: Sequence[View]
) -> PlacedSticker | Finding:
    """One sticker from the photos that show it, or why it has no place."""
    kept = list(shown)
    while len(kept) >= _LEAST_PHOTOS:
        seen = [views[photo.photo_idx] for photo in kept]
        corners_px = np.array([photo.corners_px[photo.ids == mark_id][0] for photo in kept])
        met = triangulate(seen, *_views_and_corners(len(seen)), corners_px.reshape(-1, 2), _CORNERS)
        points = met.points_in_world
        if not np.isfinite(points).all():
            return note("landmark.sticker.no_place")
        again = np.array([view.project(points) for view in seen])
        off_px = np.linalg.norm(again - corners_px, axis=2).max(axis=1)
        if off_px.max() <= _MOST_OFF_PX:
            freedom = max(1, 2 * _CORNERS * len(seen) - 3 * _CORNERS)
            rms_px = float(np.sqrt(((again - corners_px) ** 2).sum() / freedom))
            rms_px *= widening(freedom)
            sigmas = [np.trace(one) / 3 for one in met.covariance]
            sigma_mm = max(rms_px, _LEAST_SIGMA_PX) * float(np.sqrt(np.mean(sigmas)))
            sides = np.linalg.norm(points - np.roll(points, -1, axis=0), axis=1)
            return PlacedSticker(
                mark_id=mark_id,
                position_mm=points.mean(0),
                sigma_mm=sigma_mm,
                side_mm=float(sides.mean()),
                photos=tuple(photo.name for photo in kept),
            )
        if len(kept) - 1 < max(_LEAST_PHOTOS, _LEAST_AGREEING * len(shown)):
            return note("landmark.sticker.moved")
        kept.pop(int(np.argmax(off_px)))
    return note("landmark.sticker.few", count=len(shown), least=_LEAST_PHOTOS)


def _views_and_corners(views: int) -> tuple[Int32[np.ndarray, " m"], Int32[np.ndarray, " m"]]:
    """View and corner of each measurement, photo by photo."""
    return (
        np.repeat(np.arange(views, dtype=np.int32), _CORNERS),
        np.tile(np.arange(_CORNERS, dtype=np.int32), views),
    )
