"""Background board: rejects a board that belongs to the static background of a turning object.

In      BoardDetections, and what stands still in the photos (matching.still).
Out     the detections without photos whose board stands still: seen from cameras that are placed
        round the object it would have to lie in another place for every photo.
Method  Photos of one still camera show a board that stands still with each corner at one pixel.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from limbgram.findings import fault, note
from limbgram.reconstruction.matching.static_background import StaticBackground
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.reconstruction.targets.board import BoardDetections, PhotoCorners

_STILL_PX = 2.0
"""Largest median move of the corners of a board that stands still, but for a touched tripod."""
_LEAST_PHOTOS = 3
"""Photos in which a board that stands still is found at one place: one that turns may pause."""
_REASON = note("board.photo.stood_still")


def without_background_board(
    detections: BoardDetections, still: StaticBackground
) -> BoardDetections:
    """The detections of photos whose board turns with the object."""
    standing: set[int] = set()
    by_photo = {one.photo_idx: one for one in detections.photos}
    for group in still.groups:
        shown = [by_photo[photo] for photo in group if photo in by_photo]
        standing |= {one.photo_idx for one in shown if _stands(one, shown)}
    if not standing:
        return detections
    return replace(
        detections,
        photos=tuple(one for one in detections.photos if one.photo_idx not in standing),
        set_aside=(
            *detections.set_aside,
            *(SetAside(by_photo[photo].name, _REASON) for photo in sorted(standing)),
        ),
        cause=fault("board.stands_still", photos=len(standing)),
    )


def _stands(one: PhotoCorners, shown: Sequence[PhotoCorners]) -> bool:
    """Whether enough photos of the same camera show the corners at the same pixels."""
    return sum(_move_px(one, other) < _STILL_PX for other in shown) >= _LEAST_PHOTOS


def _move_px(one: PhotoCorners, other: PhotoCorners) -> float:
    """Median move of the corners that both photos show."""
    _, here, there = np.intersect1d(one.ids, other.ids, return_indices=True)
    if not len(here):
        return float("inf")
    return float(np.median(np.linalg.norm(one.xy_px[here] - other.xy_px[there], axis=1)))
