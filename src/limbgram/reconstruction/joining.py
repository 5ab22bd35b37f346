"""Joining: camera poses from keypoints and coded marks together, where keypoints alone fail.

In      photos, their keypoints, what stands still in them, the coded marks they show, cameras.
Out     a Joined: the Scene, and the features, matches and pairs that it was made of.
Method  The points of the marks become keypoints and matches (`matching.coded`), pairs are verified
        and photos placed as ever. A mark whose corners do not stay in the scene in half of the
        photos that show it moved against the others (it lies in the room and the limb moved, or it
        came off); the photos are then placed anew without it, and it is named.
Fails   MatchingError, PlacementError: the marks do not join the photos either, or some do not fit
        even after others were left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from limbgram.core.errors import PlacementError
from limbgram.core.run import Run
from limbgram.findings import Finding, doubt, note
from limbgram.reconstruction.calibration.cameras import Cameras
from limbgram.reconstruction.features.detection import Features
from limbgram.reconstruction.mapping.placement import MappingOptions, place
from limbgram.reconstruction.mapping.scene import JoinedByMarks, Scene
from limbgram.reconstruction.matching.coded_marks import CodedKeypoints, CodedMatches, with_marks
from limbgram.reconstruction.matching.matching import Matches
from limbgram.reconstruction.matching.static_background import StaticBackground
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.targets.marks import MarkDetections, PhotoMarks
from limbgram.reconstruction.twoview.pairs import Pairs
from limbgram.reconstruction.twoview.verification import verify

_AT_PX = 0.01
"""An observation so near to a corner is that corner."""
_CORNERS_SEEN = 3
"""Corners of a mark in a photo that stay where the mark fits."""
_FEWEST_PHOTOS = 2
_MOST_AGAIN = 2
"""Times that photos are placed again: without some marks others may turn out not to fit."""
_IN_ROOM = note("placing.mark_in_room")


@dataclass(frozen=True, kw_only=True)
class MarkedPhotos:
    """Photos with paint and coded marks, before any has a place by both."""

    photos: PhotoSet
    features: Features
    matches: Matches
    marks: MarkDetections
    still: StaticBackground
    cameras: Cameras
    placed_by_paint: int
    """Photos that paint alone places."""

    def with_marks(self, left_out: frozenset[int] = frozenset()) -> CodedMatches:
        return with_marks(self.features, self.matches, self.marks, self.still, left_out)


@dataclass(frozen=True)
class Joined:
    """Placed photos, and by what."""

    features: Features
    matches: Matches
    pairs: Pairs
    scene: Scene
    coded: CodedKeypoints


def leaves_open(scene: Scene) -> bool:
    """Whether a photo has no place, or the ring does not close."""
    return len(scene.placed) < len(scene.names) or scene.ring is None or not scene.ring.closed


def joins_better(scene: Scene, before: Scene) -> bool:
    """Whether more photos have a place than before, or as many in a ring that now closes."""
    if len(scene.placed) != len(before.placed):
        return len(scene.placed) > len(before.placed)
    closed = [one.ring is not None and one.ring.closed for one in (scene, before)]
    return closed == [True, False]


def shared_marks(detections: MarkDetections) -> tuple[int, ...]:
    """Marks that two photos or more show."""
    return tuple(one for one in detections.ids if detections.seen_in(one) >= _FEWEST_PHOTOS)


def join_by_marks(shown: MarkedPhotos, mapping: MappingOptions, run: Run) -> Joined:
    """Place the photos by paint and marks.

    Raises:
        MatchingError, PlacementError: they do not join the photos.
    """
    moved: dict[int, Finding] = {}
    joined = _joined(shown, shown.with_marks(), mapping, run)
    for _ in range(_MOST_AGAIN):
        odd = _odd_marks(joined.scene, shown.marks, joined.coded)
        if not odd:
            break
        moved |= odd
        joined = _joined(shown, shown.with_marks(frozenset(moved)), mapping, run)
    else:
        if odd := _odd_marks(joined.scene, shown.marks, joined.coded):
            raise PlacementError("placing.marks_moved", marks=tuple(map(int, moved | odd)))
    in_room = dict.fromkeys(joined.coded.in_room, _IN_ROOM)
    left_out = dict(sorted((in_room | moved).items()))
    held = sorted({*shared_marks(shown.marks)} - {*left_out})
    marks = JoinedByMarks(
        photos_by_paint=shown.placed_by_paint,
        ids=tuple(held),
        left_out=tuple(left_out),
        reasons=tuple(left_out.values()),
    )
    return replace(joined, scene=replace(joined.scene, marks=marks))


def _joined(
    shown: MarkedPhotos,
    given: CodedMatches,
    mapping: MappingOptions,
    run: Run,
) -> Joined:
    pairs = run(verify, shown.photos, given.matches, shown.cameras)
    scene = run(place, shown.photos, given.features, pairs, shown.cameras, mapping, given.coded)
    return Joined(given.features, given.matches, pairs, scene, given.coded)


def _odd_marks(
    scene: Scene, detections: MarkDetections, coded: CodedKeypoints
) -> dict[int, Finding]:
    """Marks that do not fit in half of the placed photos that show them, and why."""
    shown: dict[int, list[bool]] = {}
    for one in detections.photos:
        if scene.camera_from_world[one.photo_idx] is None:
            continue
        used = {*coded.ids[one.photo_idx].tolist()}
        for mark_id, stays in zip(one.ids.tolist(), _stays(scene, one), strict=True):
            if mark_id in used:
                shown.setdefault(mark_id, []).append(stays)
    return {
        mark_id: doubt("placing.mark_moved", fits=sum(stays), shown=len(stays))
        for mark_id, stays in sorted(shown.items())
        if len(stays) >= _FEWEST_PHOTOS and 2 * sum(stays) < len(stays)
    }


def _stays(scene: Scene, shown: PhotoMarks) -> Sequence[bool]:
    """Of each mark in a photo: whether its corners are among the scene's observations."""
    seen = scene.observations
    own = seen.xy_px[seen.photo_idx == shown.photo_idx]
    if not len(own):
        return [False] * len(shown.ids)
    away = np.linalg.norm(shown.corners_px[:, :, None] - own, axis=3).min(axis=2)
    return ((away < _AT_PX).sum(axis=1) >= _CORNERS_SEEN).tolist()
