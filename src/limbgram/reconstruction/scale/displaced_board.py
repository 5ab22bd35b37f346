"""Displaced board: finds between which photos the board was pushed, and keeps the largest run.

In      a Scene whose photos are placed by what kept still, and BoardDetections.
Out     the detections of the largest run of photos that agree on the board's place; the others are
        set aside with the photos between which it was pushed.
Method  Limb, room and board are three bodies. The first two place the photos (`movement` separates
        them); the residuals of the corners are then due to the board. Where they are larger than
        those of a board that keeps still, the longest run of consecutive photos is searched from
        which the corners, triangulated without the others, have half of these residuals or less in
        every photo. Photos of a board that keeps still hold no such run. Photos beside the run that
        agree with it are kept as well.
        Corners that only one of two runs shows contradict nothing, wherever the board lay. Where
        two runs have less than half of their corners in common, the board's known shape, fitted to
        the corners of the larger run, predicts the others: the smaller run is kept only where it
        agrees with these.
        A board that is pushed does not come back: a photo that contradicts others before and after
        it shows a limb that swayed, or is placed wrongly.
        A board that is pushed stays in its plane. Where the others agree that it lies in another
        one, the limb was turned over beside it, or photos are placed wrongly.
Limits  A push by less than the residuals of a still board, and a board that moves in every photo,
        are not found here; the corners' own tests refuse the latter.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.frames import Similarity, fit_similarity
from limbgram.core.geometry.lens import View
from limbgram.core.geometry.triangulation import triangulate
from limbgram.findings import Finding, doubt, note
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.reconstruction.scale.board import placed_photos
from limbgram.reconstruction.targets.board import BoardDetections, PhotoCorners

_FEWEST = 4
"""Fewest photos of a run, which is a third of all at least: fewer may agree by chance."""
_LEAST_SHARE = 1 / 3
_STILL_RESIDUAL_PX = 0.35
"""Largest median residual of a photo of a board that kept still: these have 0.06 to 0.2 px."""
_RESIDUAL_RATIO = 0.5
"""Largest ratio of the residuals of a run by itself over those of all photos."""
_FEWEST_ASIDE = 3
"""Fewest photos beside the run: one or two are left out by the corners' own tests."""
_IN_COMMON = 0.5
"""Share of the smaller run's corners in common from which the residuals compare two runs."""
_TIPPED_DEG = 20.0
"""Angle between two planes of the board beyond which it was not pushed along a table."""
_LEAST_BREADTH = 0.1
"""Smallest breadth over length of corners that determine the pose of the board."""


def without_displaced_board(scene: Scene, detections: BoardDetections) -> BoardDetections:
    """The detections of the largest run of photos that agree on the board's place."""
    shown = placed_photos(detections, scene)
    seen = [_BoardView(shown[k], scene.view(k)) for k in sorted(shown)]
    kept = _agreeing(seen, detections.corners_mm)
    if kept.agree.all():
        kept = _by_board_shape(seen, detections.corners_mm)
    aside = [one.photo.name for one, agrees in zip(seen, kept.agree, strict=True) if not agrees]
    if len(aside) < _FEWEST_ASIDE:
        return detections
    tipped = _tipped(seen, kept.agree, detections.corners_mm)
    within = kept.agree if tipped else _with_those_between(kept.agree)
    pushes = tuple(
        note("board.push", before=seen[k - 1].photo.name, after=seen[k].photo.name)
        for k in range(1, len(seen))
        if within[k] != within[k - 1]
    )
    others = len(seen) - len(aside)
    reason = doubt(
        "board.photo.tipped"
        if tipped
        else "board.photo.pushed"
        if kept.sure
        else "board.photo.perhaps_pushed",
        others=others,
        pushes=pushes,
    )
    came_back = doubt("board.photo.came_back", others=others)
    set_aside = (
        SetAside(one.photo.name, came_back if is_within else reason)
        for one, agrees, is_within in zip(seen, kept.agree, within, strict=True)
        if not agrees
    )
    return replace(
        detections,
        photos=tuple(one for one in detections.photos if one.name not in aside),
        set_aside=(*detections.set_aside, *set_aside),
    )


def _with_those_between(agree: Bool[np.ndarray, " n"]) -> Bool[np.ndarray, " n"]:
    """Also the photos that were taken between some that agree."""
    first, last = np.flatnonzero(agree)[[0, -1]]
    photos = np.arange(len(agree))
    return (first <= photos) & (photos <= last)


def tipped_photos(set_aside: Sequence[SetAside]) -> list[Finding]:
    """The reasons for photos that were set aside because they show the board in another plane."""
    reasons = [one.reason for one in set_aside]
    return [one for one in reasons if one.code == "board.photo.tipped"]


@dataclass(frozen=True)
class _BoardView:
    """A placed photo and its corners."""

    photo: PhotoCorners
    view: View


@dataclass(frozen=True)
class _Agreement:
    """Which photos agree on the board's place, and whether the others surely do not."""

    agree: Bool[np.ndarray, " n"]
    sure: bool = True

    @classmethod
    def all_of(cls, seen: Sequence[_BoardView]) -> "_Agreement":
        """That all photos agree."""
        return cls(np.ones(len(seen), bool))


def _agreeing(seen: Sequence[_BoardView], corners_mm: Points3) -> _Agreement:
    """The photos that agree with the largest self-consistent run; all if the board kept still."""
    count = len(seen)
    together_px = (
        _worst(_median_residuals_px(seen, _places(seen, corners_mm))) if count > _FEWEST else 0.0
    )
    if not together_px > _STILL_RESIDUAL_PX:
        return _Agreement.all_of(seen)
    for length in range(count - 1, max(_FEWEST, math.ceil(_LEAST_SHARE * count)) - 1, -1):
        runs = [seen[first : first + length] for first in range(count - length + 1)]
        worst_px = [
            _worst(_median_residuals_px(run, _places(run, corners_mm)), _FEWEST) for run in runs
        ]
        best = int(np.argmin(worst_px))
        if worst_px[best] < _RESIDUAL_RATIO * together_px:
            places = _places(runs[best], corners_mm)
            residuals_px = _median_residuals_px(seen, places)
            unknown = np.isnan(residuals_px)
            residuals_px[unknown] = _median_residuals_px(seen, _completed(places, corners_mm))[
                unknown
            ]
            return _Agreement(
                residuals_px < max(_RESIDUAL_RATIO * together_px, 2.0 * worst_px[best])
            )
    return _Agreement.all_of(seen)


def _tipped(
    seen: Sequence[_BoardView], agree: Bool[np.ndarray, " photos"], corners_mm: Points3
) -> bool:
    """Whether the other photos agree among themselves on another plane of the board."""
    normals: list[Vector3] = []
    for chosen in (agree, ~agree):
        group = [one for one, is_in in zip(seen, chosen, strict=True) if is_in]
        places = _places(group, corners_mm)
        pose = _pose_of(places, corners_mm)
        if pose is None or not _worst(_median_residuals_px(group, places)) < _STILL_RESIDUAL_PX:
            return False
        normals.append(pose.rotation[:, 2])
    return float(normals[0] @ normals[1]) < math.cos(math.radians(_TIPPED_DEG))


def _by_board_shape(seen: Sequence[_BoardView], corners_mm: Points3) -> _Agreement:
    """The larger of two runs with few corners in common, if the board's shape tells them apart.

    All photos if there are no such runs; not sure where the shape predicts nothing.
    """
    count = len(seen)
    worst, kept = (_STILL_RESIDUAL_PX, 0), _Agreement.all_of(seen)
    for border in range(_FEWEST_ASIDE, count - _FEWEST_ASIDE + 1):
        runs = [_Run.of(range(border), seen, corners_mm)]
        runs.append(_Run.of(range(border, count), seen, corners_mm))
        smaller, larger = sorted(runs, key=lambda one: one.size)
        common = int((smaller.located & larger.located).sum())
        if smaller.size[0] == 0 or common >= _IN_COMMON * smaller.size[0]:
            continue
        predicted = _completed(larger.places, corners_mm)
        residuals_px = _median_residuals_px([seen[k] for k in smaller.photos], predicted)
        off_px = math.inf if np.isnan(residuals_px).all() else float(np.nanmean(residuals_px))
        explained = smaller.corners_seen + larger.corners_seen
        if (off_px, explained) > worst:
            agree = np.isin(np.arange(count), np.array(larger.photos))
            worst, kept = (off_px, explained), _Agreement(agree, sure=math.isfinite(off_px))
    return kept


@dataclass(frozen=True)
class _Run:
    """Consecutive photos, with the corners triangulated from them."""

    photos: range
    places: Points3
    corners_seen: int
    """Number of observations of the triangulated corners."""

    @classmethod
    def of(cls, photos: range, seen: Sequence[_BoardView], corners_mm: Points3) -> "_Run":
        own = [seen[k] for k in photos]
        places = _places(own, corners_mm)
        ids = np.concatenate([one.photo.ids for one in own])
        return cls(photos, places, int((~np.isnan(places[ids, 0])).sum()))

    @property
    def located(self) -> Bool[np.ndarray, " c"]:
        return ~np.isnan(self.places[:, 0])

    @property
    def size(self) -> tuple[int, int]:
        """Number of corners, and of photos."""
        return int(self.located.sum()), len(self.photos)


def _places(seen: Sequence[_BoardView], corners_mm: Points3) -> Points3:
    """The corners triangulated from these photos; NaN where too few show them."""
    ids = np.concatenate([one.photo.ids for one in seen])
    xy_px = np.concatenate([one.photo.xy_px for one in seen])
    lengths = [len(one.photo.ids) for one in seen]
    view_idx = np.repeat(np.arange(len(seen), dtype=np.int32), lengths)
    views = [one.view for one in seen]
    return triangulate(views, view_idx, ids, xy_px, len(corners_mm)).points_in_world


def _completed(places: Points3, corners_mm: Points3) -> Points3:
    """The corners, the missing ones predicted by the board's shape."""
    pose = _pose_of(places, corners_mm)
    return places if pose is None else np.where(np.isnan(places), pose.apply(corners_mm), places)


def _pose_of(places: Points3, corners_mm: Points3) -> Similarity | None:
    """The pose of the board by its located corners; None where they do not determine it."""
    known = ~np.isnan(places[:, 0])
    if known.sum() < _FEWEST:
        return None
    off = corners_mm[known] - corners_mm[known].mean(axis=0)
    length, breadth = np.linalg.svd(off, compute_uv=False)[:2]
    if breadth < _LEAST_BREADTH * length:
        return None
    return fit_similarity(corners_mm[known], places[known])


def _median_residuals_px(
    seen: Sequence[_BoardView], places: Points3
) -> Float64[np.ndarray, " photos"]:
    """By photo, the median reprojection error of these corners; NaN where it shows none."""
    residuals_px = np.full(len(seen), np.nan)
    for k, one in enumerate(seen):
        off = np.linalg.norm(one.view.project(places[one.photo.ids]) - one.photo.xy_px, axis=1)
        known = off[np.isfinite(off)]
        if len(known):
            residuals_px[k] = np.median(known)
    return residuals_px


def _worst(residuals_px: Float64[np.ndarray, " photos"], fewest: int = 1) -> float:
    """The largest of the known ones; infinite where fewer than so many are known."""
    known = residuals_px[np.isfinite(residuals_px)]
    return float(known.max()) if len(known) >= fewest else math.inf
