"""Pushed boards: a board that somebody pushed lies elsewhere in the photos that follow.

In      a Scene whose photos are placed by what kept still, and BoardDetections.
Out     the detections of the largest run of photos that agree on where the board lies; the others
        are set aside with the photos between which it was pushed.
Method  Limb, room and board are three bodies. The first two place the photos (`movement` tells
        them apart); what the corners then say is the board's own. Where they miss each other by
        more than those of a board that keeps still, the longest run of photos, in their order, is
        looked for that locates the corners for itself with half of the misses or less in every one
        of its photos. Photos of a board that keeps still hold no such run. Photos beside the run
        that agree with it are kept as well.
Limits  A push by less than the misses of a still board, and a board that moves in every photo, are
        not told here; the corners' own tests refuse the latter.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.geometry.lens import View
from limbgram.core.geometry.triangulation import triangulate
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.reconstruction.targets.board import BoardDetections, PhotoCorners

_FEWEST = 4
"""Photos of a run, which is a third of them at least: fewer may agree by chance."""
_LEAST_SHARE = 1 / 3
_KEPT_STILL_PX = 0.35
"""In boards that kept still the median corner of a photo misses the others by 0.06 to 0.2 px."""
_HALVED = 0.5
_FEWEST_ASIDE = 3
"""One or two photos that contradict the others are left out by the corners' own tests."""


def without_pushed_board(scene: Scene, detections: BoardDetections) -> BoardDetections:
    """The detections that agree on where the board lies; themselves where it kept still."""
    index = {scene.names[k]: k for k in scene.placed}
    shown = sorted(
        (one for one in detections.photos if one.name in index), key=lambda one: index[one.name]
    )
    seen = [_Seen(one, scene.view(index[one.name])) for one in shown]
    agree = _agreeing(seen, len(detections.corners_mm))
    aside = [one.photo.name for one, agrees in zip(seen, agree, strict=True) if not agrees]
    if len(aside) < _FEWEST_ASIDE:
        return detections
    changes = [k for k in range(1, len(seen)) if agree[k] != agree[k - 1]]
    pushes = [f"between {seen[k - 1].photo.name} and {seen[k].photo.name}" for k in changes]
    reason = (
        f"its board lies elsewhere than in the {len(seen) - len(aside)} photos that set the scale: "
        f"it was pushed {' and '.join(pushes)}"
    )
    return replace(
        detections,
        photos=tuple(one for one in detections.photos if one.name not in aside),
        set_aside=(*detections.set_aside, *(SetAside(name, reason) for name in aside)),
    )


@dataclass(frozen=True)
class _Seen:
    """A placed photo and the corners that it shows."""

    photo: PhotoCorners
    view: View


def _agreeing(seen: Sequence[_Seen], corners: int) -> Bool[np.ndarray, " n"]:
    """Photos that agree with the longest run that agrees with itself; all where none is needed."""
    count = len(seen)
    together_px = _misses_px(seen, seen, corners).max() if count > _FEWEST else 0.0
    if not together_px > _KEPT_STILL_PX:
        return np.ones(count, bool)
    for length in range(count - 1, max(_FEWEST, math.ceil(_LEAST_SHARE * count)) - 1, -1):
        runs = [seen[first : first + length] for first in range(count - length + 1)]
        worst_px = [float(_misses_px(run, run, corners).max()) for run in runs]
        best = int(np.argmin(worst_px))
        if worst_px[best] < _HALVED * together_px:
            misses_px = _misses_px(seen, runs[best], corners)
            return misses_px < max(_HALVED * together_px, 2.0 * worst_px[best])
    return np.ones(count, bool)


def _misses_px(
    seen: Sequence[_Seen], by: Sequence[_Seen], corners: int
) -> Float64[np.ndarray, " n"]:
    """Of each photo the median distance between its corners and where others locate them."""
    ids = np.concatenate([one.photo.ids for one in by])
    xy_px = np.concatenate([one.photo.xy_px for one in by])
    lengths = [len(one.photo.ids) for one in by]
    view_idx = np.repeat(np.arange(len(by), dtype=np.int32), lengths)
    views = [one.view for one in by]
    places = triangulate(views, view_idx, ids, xy_px, corners).points_in_world
    misses_px = np.zeros(len(seen))
    for k, one in enumerate(seen):
        off = np.linalg.norm(one.view.project(places[one.photo.ids]) - one.photo.xy_px, axis=1)
        known = off[np.isfinite(off)]
        misses_px[k] = np.median(known) if len(known) else 0.0
    return misses_px
