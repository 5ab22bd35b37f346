"""Coded marks: points of coded marks as keypoints and matches, identified by the mark's number.

In      Features and Matches of the photos, what stands still in them, and the marks they show.
Out     Features and Matches with the marks' points after the other keypoints, and CodedKeypoints:
        which they are.
Method  A mark names itself, so that a point of it is the same point in every photo that shows the
        mark, however far these lie apart. For as long as photos are compared and placed, a mark has
        sixteen points, its corners and those of a net between them: two marks then hold a photo as
        firmly as the paint of one that is just accepted, and one mark alone does not. The last
        adjustment takes the four corners, which are what was measured. In photos of a still camera
        a mark that stays where it is in the picture belongs to the room and is left out.
Limits  The net is straight: on skin of 50 mm radius its middle is 0.2 px off for a mark of 30 px.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from jaxtyping import Float64, Int32

from limbgram.reconstruction.features.detection import Features, Keypoints
from limbgram.reconstruction.matching.matching import Matches, PairMatches
from limbgram.reconstruction.matching.static_background import StaticBackground
from limbgram.reconstruction.targets.marks import MarkDetections

_SIDE = 4
"""Points of the net along a side of a mark."""
_POINTS = _SIDE * _SIDE
_CORNERS = (0, _SIDE - 1, _POINTS - 1, _POINTS - _SIDE)
"""Those of them that are the corners, clockwise from the mark's own top left."""
_CORNER_SIGMA_PX = 0.05
"""Standard deviation of one coordinate of a corner, as renders show it; the fit's own if larger."""
_STANDS_PX = 1.5
"""In photos of a still camera a mark that keeps its place so closely stands still."""
_FEWEST_SHARED = 2
"""Marks that two photos must share to be matched by marks."""


@dataclass(frozen=True)
class CodedKeypoints:
    """Which keypoints are points of coded marks: the last ones of every photo, sixteen a mark."""

    ids: tuple[Int32[np.ndarray, " n"], ...]
    """Of every photo, the marks in the order of their points."""
    sigmas_px: tuple[Float64[np.ndarray, " n"], ...]
    """Of every photo, the standard deviation of the corners of each mark."""
    own: tuple[int, ...]
    """Of every photo, the number of other keypoints, which come before."""
    in_room: tuple[int, ...] = ()
    """Marks that stand still in the picture while the object turns: they were left out."""

    def corners_only(self, pair: PairMatches) -> PairMatches:
        """The matches of other keypoints, and those of the marks' corners only."""
        keep = np.ones(len(pair), bool)
        for side, photo in enumerate((pair.first, pair.second)):
            row = pair.keypoint_idx[:, side] - self.own[photo]
            keep &= (row < 0) | np.isin(row % _POINTS, _CORNERS)
        return pair.some(keep)

    def own_sigmas_px(self) -> tuple[Float64[np.ndarray, " k"], ...]:
        """By photo and keypoint, the sigma of a mark's point; zero for other keypoints."""
        return tuple(
            np.concatenate([np.zeros(own), np.repeat(sigmas, _POINTS)])
            for own, sigmas in zip(self.own, self.sigmas_px, strict=True)
        )


@dataclass(frozen=True)
class CodedMatches:
    """Features and matches with those of coded marks added."""

    features: Features
    matches: Matches
    coded: CodedKeypoints


def with_marks(
    features: Features,
    matches: Matches,
    detections: MarkDetections,
    still: StaticBackground,
    but: frozenset[int] = frozenset(),
) -> CodedMatches:
    """Keypoints and matches, followed by those of the marks.

    Args:
        but: Marks that are left out.
    """
    standing = _standing(detections, still)
    marks = {one.photo_idx: one for one in detections.photos}
    keypoints: list[Keypoints] = []
    ids: list[Int32[np.ndarray, " n"]] = []
    sigmas: list[Float64[np.ndarray, " n"]] = []
    for photo, before in enumerate(features.keypoints):
        seen = marks.get(photo)
        if seen is None:
            corners, kept = np.zeros((0, 4, 2)), np.zeros(0, np.int32)
            sigmas.append(np.zeros(0))
        else:
            keep = ~np.isin(seen.ids, list(standing | but))
            corners, kept = seen.corners_px[keep], seen.ids[keep]
            sigmas.append(np.maximum(seen.sigmas_px[keep], _CORNER_SIGMA_PX))
        ids.append(kept.astype(np.int32))
        keypoints.append(_joined(before, _nets(corners)))
    coded = CodedKeypoints(
        ids=tuple(ids),
        sigmas_px=tuple(sigmas),
        own=tuple(len(one) for one in features.keypoints),
        in_room=tuple(sorted(standing)),
    )
    together = Features(tuple(keypoints))
    return CodedMatches(together, _matched(matches, together, coded), coded)


def _standing(detections: MarkDetections, still: StaticBackground) -> frozenset[int]:
    """Marks that keep their place in the picture in most photos of a still camera."""
    found: set[int] = set()
    for group in still.groups:
        places: dict[int, list[Float64[np.ndarray, 2]]] = {}
        for one in detections.photos:
            if one.photo_idx in group:
                for mark_id, centre in zip(one.ids.tolist(), one.centres_px, strict=True):
                    places.setdefault(mark_id, []).append(centre)
        for mark_id, centres in places.items():
            off = np.linalg.norm(np.array(centres) - np.median(centres, axis=0), axis=1)
            if len(centres) >= _FEWEST_SHARED and np.median(off) < _STANDS_PX:
                found.add(mark_id)
    return frozenset(found)


def _nets(corners_px: Float64[np.ndarray, "n 4 2"]) -> Float64[np.ndarray, "k 2"]:
    """Sixteen points of each mark, by the perspective of its four corners."""
    steps = np.linspace(0.0, 1.0, _SIDE)
    across, down = np.meshgrid(steps, steps)
    grid = np.stack([across, down], axis=-1).reshape(1, -1, 2)
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], np.float32)
    nets = [
        cv2.perspectiveTransform(grid, cv2.getPerspectiveTransform(square, own.astype(np.float32)))
        for own in corners_px
    ]
    found = np.array(nets, float).reshape(len(corners_px), _POINTS, 2)
    found[:, _CORNERS] = corners_px  # exactly as they were measured
    return found.reshape(-1, 2)


def _joined(before: Keypoints, points_px: Float64[np.ndarray, "k 2"]) -> Keypoints:
    """Keypoints followed by points without a descriptor."""
    count = len(points_px)
    return Keypoints(
        xy_px=np.concatenate([before.xy_px, points_px.astype(np.float32)]),
        scale_px=np.concatenate([before.scale_px, np.ones(count, np.float32)]),
        angle_deg=np.concatenate([before.angle_deg, np.zeros(count, np.float32)]),
        descriptors=np.concatenate([before.descriptors, np.zeros((count, 128), np.uint8)]),
    )


def _matched(matches: Matches, features: Features, coded: CodedKeypoints) -> Matches:
    """The matches, and in every pair of photos those of the marks that both show."""
    by_pair = {(one.first, one.second): one for one in matches.pairs}
    photos = len(coded.ids)
    new = 0
    for first in range(photos):
        for second in range(first + 1, photos):
            more = _of_marks(first, second, features, coded)
            if more is None:
                continue
            known = by_pair.get((first, second))
            if known is None and len(more) < _FEWEST_SHARED * _POINTS:
                continue
            new += known is None
            by_pair[first, second] = more if known is None else _added(known, more)
    pairs = tuple(by_pair[key] for key in sorted(by_pair))
    return replace(matches, pairs=pairs, pairs_tried=matches.pairs_tried + new)


def _of_marks(
    first: int, second: int, features: Features, coded: CodedKeypoints
) -> PairMatches | None:
    shared, here, there = np.intersect1d(
        coded.ids[first], coded.ids[second], assume_unique=True, return_indices=True
    )
    if not len(shared):
        return None
    net = np.arange(_POINTS)
    rows = [
        (own + _POINTS * at[:, None] + net).ravel()
        for own, at in ((coded.own[first], here), (coded.own[second], there))
    ]
    ends = np.column_stack(rows).astype(np.int32)
    return PairMatches(
        first=first,
        second=second,
        keypoint_idx=ends,
        xy_first_px=features.keypoints[first].xy_px[ends[:, 0]].astype(float),
        xy_second_px=features.keypoints[second].xy_px[ends[:, 1]].astype(float),
        correlation=np.full(len(ends), np.nan, np.float32),
    )


def _added(one: PairMatches, other: PairMatches) -> PairMatches:
    return replace(
        one,
        keypoint_idx=np.concatenate([one.keypoint_idx, other.keypoint_idx]),
        xy_first_px=np.concatenate([one.xy_first_px, other.xy_first_px]),
        xy_second_px=np.concatenate([one.xy_second_px, other.xy_second_px]),
        correlation=np.concatenate([one.correlation, other.correlation]),
    )
