"""Poses: an object that was turned over during the capture: finds the two sides and joins them.

In      photos in the order in which they were taken, their features, matches and verified pairs,
        the cameras, where photos show the board; the scene they were placed in, where there is one.
Out     Poses: the two sides of the capture, each with its own scene, or none; which keypoints lie
        on the object.
Method  Board, floor and room belong to one pose each, and the object to both. Within one side
        everything keeps still, so each side is placed by all of its matches. The region of the
        object in each side's scene, above that side's own floor, separates the object's keypoints
        from the room's. The remaining matches join the two sides by the object alone.
        The seam between the sides shows in two ways: the rotations of pairs that the object joined
        across it contradict the board that both photos show, and the board lies in several places
        of the scene. If the room joined the sides, no point near the aim is seen by photos of both;
        then the object's regions must also be different bodies there, for two rounds at heights
        that share no points look the same. If the photos could not be placed in one scene, the
        weakest links between consecutive photos are tried. Photos in any order that stand beside
        each other and share nothing of the object (`limb_groups`) are two sides, or two objects if
        nothing on it joins them.
Fails   never: a capture without two sides has none.
Limits  Without a board, only a capture whose photos could not be placed in one scene is examined.
        A board that stands in the room before a still camera counts as none.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from jaxtyping import Bool, Float64
from scipy.spatial import KDTree

from limbgram.core.errors import PlacementError, RegionError, ScaleError
from limbgram.core.geometry.arrays import Matrix3, Points3, Vector3
from limbgram.core.geometry.frames import (
    Rigid,
    angle_between_deg,
)
from limbgram.core.geometry.lens import Camera, View
from limbgram.core.interval import rms
from limbgram.core.run import Run
from limbgram.findings import Finding, note
from limbgram.reconstruction.calibration.cameras import Cameras
from limbgram.reconstruction.dense.depth import DepthMap
from limbgram.reconstruction.dense.region import Region, find_region, footprint
from limbgram.reconstruction.features.detection import Features
from limbgram.reconstruction.lens_groups import ByLens, by_cut, by_lens, lens_is_told
from limbgram.reconstruction.limb_groups import LimbGroups, limb_groups
from limbgram.reconstruction.mapping.placement import DEFAULTS as MAPPING
from limbgram.reconstruction.mapping.placement import MappingOptions, place, place_roughly
from limbgram.reconstruction.mapping.scene import Scene, other_from_one
from limbgram.reconstruction.mapping.verdicts import reverified, solved_lenses
from limbgram.reconstruction.matching.matching import Matches
from limbgram.reconstruction.matching.static_background import StaticBackground
from limbgram.reconstruction.photos.lenses import copies_of
from limbgram.reconstruction.photos.photo import PhotoSet, first_of
from limbgram.reconstruction.scale.background_board import without_background_board
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.scale.scaling import to_millimetres
from limbgram.reconstruction.scale.visibility import aim_of
from limbgram.reconstruction.targets.board import BoardDetections, PhotoCorners
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair
from limbgram.reconstruction.twoview.repeated_print import without_repeated_print
from limbgram.reconstruction.twoview.verification import verify

_FEWEST_PHOTOS = 4
"""Photos of one side, at least."""
_SIDES = 2
_FEWEST_CORNERS = 6
_LEAST_ACROSS = 0.3
"""Smallest ratio of the corners' extents: a row of corners determines no plane."""
_MISSED, _LEAST_MISS = 5.0, 0.0005
"""Corners that miss their board by so many times what the middle photo's do, and by this part of
the picture's width, are no board: good ones miss it by 0.00004 to 0.00025."""
_MOVED_SHARE = 0.04
"""How far photos put the board from one place, of the cameras' distance, where an object was turned
over: 0.12 to 0.13. Good captures have 0.0005, a patient who shifts or a board that is pushed
0.01."""
_IN_PLACE_SHARE = 0.6
"""Share of the photos that the trimmed least squares keep."""
_TRIMMING_ROUNDS = 20
_CONTRADICTION_DEG = 20.0
"""Angle between the rotations of a pair and of its board from which they contradict: the tilt of a
board seen from afar is uncertain by ten degrees and more."""
_FEWEST_CONTRADICTING = 4
_SEAM_TOLERANCE = 3
"""Largest distance, in photos, between the seam by the board and the weak link that it means."""
_MAX_SEAMS = 6
"""Largest number of seams that are tried: each costs two scenes."""
_WEAKEST = 2
"""Number of weak links that are tried as seams."""
_WEAK_LINK = 0.5
"""A weak link has less than this part of the matches of the middle one."""
_NEAR_AIM = 0.4
"""Points within this part of half a frame of the aim are the object's, nearly all of them."""
_FEWEST_NEAR = 30
_SHARED_NEAR = 0.03
"""Photos of one round share a fifth of these points with those before and after, and more."""
_FACING_ALIKE_DEG = 45.0
"""How far at most the middle photo of a side looks from the nearest photo of the other side, where
an object was turned over: photos all round of both poses have 15 to 30. Halves of one ring have 50
to 75; they look at opposite sides of the object and need not share points."""
_SEAMS = 2
"""Changes between the sides in the order of directions round the object that halves of one walk
have; photos round both poses change about as often as there are photos of one."""
_SAME_BODY = 0.6
"""Part of the region of one side that lies in that of the other, where it is one body. A limb that
was laid on its side shares a third with itself."""
_SAME_PLACE = 0.03
"""How far from it at most, of its size."""
_AGREEING = 0.02
"""How far photos of a side may lie from where its own scene has them, of their ring's radius."""
_PLACED_SHARE = 0.8
"""Part of the photos of a side that must find a place in its scene."""


_CLEARANCE = 0.004
"""What counts as floor in a depth map: this far above its plane, of the cameras' distance."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """Photos of one side that make a scene of their own."""

    metric: MetricScene
    """Scene of these photos alone, with the board and the floor of this pose."""
    region: Region
    """Region of the object in that scene."""


@dataclass(frozen=True, kw_only=True)
class Side:
    """Photos in which the object kept one pose."""

    photos: tuple[int, ...]
    parts: tuple[Part, ...]
    """The largest first. One, unless photos between two parts share too little with either."""

    @property
    def placed(self) -> int:
        """Number of photos that one of its parts places."""
        return sum(len(part.metric.scene.placed) for part in self.parts)


@dataclass(frozen=True, kw_only=True)
class Poses:
    """The sides of a capture whose object was turned over; none where it was not."""

    sides: tuple[Side, ...] = ()

    def names(self, photos: PhotoSet) -> tuple[Finding, ...]:
        """First and last photo of each side, or the photos where they do not follow each other."""
        of = photos.names
        return tuple(_photo_range([of[photo] for photo in one.photos], one) for one in self.sides)

    def on_object(self, features: Features) -> tuple[Bool[np.ndarray, " n"], ...]:
        """Mask of each photo's keypoints on the object; all False where it is not placed."""
        found = [np.zeros(len(one), bool) for one in features.keypoints]
        for part in (part for side in self.sides for part in side.parts):
            for photo in part.metric.scene.placed:
                seen = footprint(part.region, part.metric.scene.view(photo))
                found[photo] = seen.shows(features.keypoints[photo].xy_px)
        return tuple(found)

    def matches_on_object(self, features: Features, matches: Matches) -> Matches:
        """The matches with both keypoints on the object."""
        if not self.sides:
            return matches
        inside = self.on_object(features)
        return replace(
            matches,
            pairs=tuple(
                one.some(
                    inside[one.first][one.keypoint_idx[:, 0]]
                    & inside[one.second][one.keypoint_idx[:, 1]],
                )
                for one in matches.pairs
            ),
        )

    def one_board(self, detections: BoardDetections) -> BoardDetections:
        """The detections of the side that shows the board in more photos."""
        if not self.sides:
            return detections
        counts = [sum(one.photo_idx in side.photos for one in detections.photos)
                  for side in self.sides]  # fmt: skip
        kept = self.sides[int(np.argmax(counts))].photos
        photos = tuple(one for one in detections.photos if one.photo_idx in kept)
        return replace(detections, photos=photos)


def _photo_range(names: Sequence[str], side: Side) -> Finding:
    """The finding that names the photos of a side."""
    if side.photos[-1] - side.photos[0] == len(side.photos) - 1:
        return note("placing.side", first=names[0], last=names[-1])
    return note("placing.side.photos", **first_of(names))


@dataclass(frozen=True)
class Placed:
    """The placed photos of a capture; by the object alone if it was turned over between them."""

    matches: Matches
    pairs: Pairs
    scene: Scene
    poses: Poses
    lenses: ByLens | None = None
    """Lenses by the photos themselves, where these contradict their files."""


@dataclass(frozen=True, kw_only=True)
class Unplaced:
    """Photos with their features, matches and detections, before they are placed."""

    photos: PhotoSet
    features: Features
    still: StaticBackground
    """Static background; matches and pairs are without it."""
    matches: Matches
    pairs: Pairs
    cameras: Cameras
    detections: BoardDetections | None

    def by(self, lenses: ByLens) -> "Unplaced":
        """The same photos with other lenses."""
        return replace(self, photos=lenses.photos, cameras=lenses.cameras)


def place_object(found: Unplaced, run: Run, mapping: MappingOptions = MAPPING) -> Placed:
    """Place photos, with lenses by the photos themselves where these contradict the files.

    Raises:
        PlacementError: see `_placed`.
    """
    pairs = without_repeated_print(found.pairs, found.detections)
    found = replace(found, pairs=pairs, detections=board_beside(found.detections, found.still))
    photos, cameras = found.photos, found.cameras

    def with_lenses(lenses: ByLens) -> Placed:
        return replace(_placed(found.by(lenses), run, mapping), lenses=lenses)

    def by_photos() -> ByLens | None:
        return run(by_lens, photos, found.features, found.pairs, cameras, mapping)

    told = lens_is_told(photos, cameras)
    if copies_of(photos):
        lenses = run(by_cut, photos, found.features, found.pairs, cameras, mapping)
        if lenses.photos.cameras != photos.cameras:
            return with_lenses(lenses)
    try:
        placed = _placed(found, run, mapping)
    except PlacementError:
        lenses = None if told else by_photos()
        if lenses is None:
            raise
        return with_lenses(lenses)
    if told or len(placed.scene.placed) == len(placed.scene.names):
        return placed
    lenses = by_photos()
    if lenses is None:
        return placed
    try:
        again = with_lenses(lenses)
    except PlacementError:
        return placed
    return again if len(again.scene.placed) > len(placed.scene.placed) else placed


def _placed(found: Unplaced, run: Run, mapping: MappingOptions) -> Placed:
    """Place photos; if the object was turned over between them, join the sides by it alone.

    Raises:
        PlacementError: too few photos are connected, the object does not join its two sides, or the
            photos show two limbs.
    """
    photos, features, pairs, cameras = found.photos, found.features, found.pairs, found.cameras
    seen = (photos, features, pairs, cameras, found.detections)
    try:
        scene = run(place, photos, features, pairs, cameras, mapping)
    except PlacementError:
        poses = run(find_poses, *seen, None)
        if not poses.sides:
            raise
    else:
        poses = Poses()
        if may_be_turned_over(scene, found.detections):
            poses = run(find_poses, *seen, scene)
        if not poses.sides:
            groups = run(limb_groups, photos, features, found.matches, scene, cameras)
            if not groups.photos:
                return Placed(found.matches, pairs, scene, poses)
            try:
                poses = run(poses_of_groups, *seen, groups)
                return _joined_by_object(found, poses, run, mapping)
            except PlacementError as apart:
                raise _two_limbs(groups, photos) from apart
    return _joined_by_object(found, poses, run, mapping)


def _joined_by_object(found: Unplaced, poses: Poses, run: Run, mapping: MappingOptions) -> Placed:
    """The photos of both sides, placed by what lies on the object.

    Raises:
        PlacementError: it does not join them firmly.
    """
    photos, features, cameras = found.photos, found.features, found.cameras
    matches = poses.matches_on_object(features, found.matches)
    pairs = run(verify, photos, matches, cameras)
    scene = run(place, photos, features, pairs, cameras, mapping)
    refuse_apart(poses, scene)
    return Placed(matches, pairs, scene, poses)


def _two_limbs(groups: LimbGroups, photos: PhotoSet) -> PlacementError:
    """The error that photos joined by board or room show two limbs, or one in two poses."""
    one, other = (tuple(photos.names[k] for k in group) for group in groups.photos[:2])
    return PlacementError("placing.two_limbs", groups=len(groups.photos), one=one, other=other)


def poses_of_groups(
    photos: PhotoSet,
    features: Features,
    pairs: Pairs,
    cameras: Cameras,
    detections: BoardDetections | None,
    groups: LimbGroups,
) -> Poses:
    """The sides of a limb that was turned over, from groups of photos that share nothing of it.

    Raises:
        PlacementError: they are not two, or one of them makes no scene of its own.
    """
    sides = [
        _side(group, photos, features, pairs, cameras, detections, whole=True)
        for group in groups.photos
    ]
    known = tuple(side for side in sides if side is not None)
    if len(known) != len(groups.photos) or len(known) != _SIDES:
        raise PlacementError("placing.unheld")
    return Poses(sides=known)


def find_poses(
    photos: PhotoSet,
    features: Features,
    pairs: Pairs,
    cameras: Cameras,
    detections: BoardDetections | None,
    scene: Scene | None,
) -> Poses:
    """The two sides of a capture whose object was turned over; none where it kept its pose."""
    count = len(photos.photos)
    turning, by = pairs, cameras
    if scene is not None:
        turning, by = reverified(scene, pairs, cameras), solved_lenses(scene, cameras)
    lenses = [by.calibrations[one.camera_idx].camera for one in photos.photos]
    by_pairs = _seam_by_pairs(turning, detections, lenses)
    others = (
        _seams_by_weak_links(pairs, count)
        if scene is None
        else _suspected_seams(scene, detections, pairs)
    )
    candidates, tried = [*by_pairs, *others], set[int]()
    best: tuple[Side, ...] = ()
    moves = scene is not None and _board_moves(scene, detections)
    while candidates and len(tried) < _MAX_SEAMS:
        start = candidates.pop(0)
        if start in tried:
            continue
        tried.add(start)
        halves = tuple(range(start)), tuple(range(start, count))
        sides = [
            _side(half, photos, features, pairs, cameras, detections, whole=not moves)
            for half in halves
        ]
        known = tuple(side for side in sides if side is not None)
        if len(known) < len(halves):
            continue
        if scene is None or moves or not _is_one_body(known, scene):
            # a side with a seam of its own begins or ends elsewhere
            scenes = (part.metric.scene for side in known for part in side.parts)
            again = [k for one in scenes for k in _suspected_seams(one, detections)]
            if not again:
                return Poses(sides=known)
            candidates = [*again, *candidates]
            best = max(best, known, key=_photos_placed)
    return Poses(sides=best)


def _photos_placed(sides: Sequence[Side]) -> int:
    """Number of photos that the sides place."""
    return sum(side.placed for side in sides)


def may_be_turned_over(scene: Scene, detections: BoardDetections | None) -> bool:
    """Whether a scene shows signs of a seam: the object or the board in two places."""
    return any(True for _ in _suspected_seams(scene, detections))


def board_beside(
    detections: BoardDetections | None, still: StaticBackground
) -> BoardDetections | None:
    """The board unless it belongs to the static background, which says nothing of poses."""
    return None if detections is None else without_background_board(detections, still)


def board_of_object(
    detections: BoardDetections, still: StaticBackground, poses: Poses
) -> BoardDetections:
    """The board where it keeps one place beside the object: only there it sets the scale."""
    return poses.one_board(without_background_board(detections, still))


def refuse_apart(poses: Poses, scene: Scene) -> None:
    """Refuse a scene that contradicts the scenes of the object's two sides.

    Raises:
        PlacementError: what lies on the object does not join the sides firmly.
    """
    for side in poses.sides:
        agreeing = [_agreeing_photos(part.metric.scene, scene) for part in side.parts]
        if None in agreeing or sum(filter(None, agreeing)) < _PLACED_SHARE * len(side.photos):
            names = [scene.names[photo] for photo in side.photos]
            raise PlacementError("placing.poses_apart", first=names[0], last=names[-1])


def _agreeing_photos(own: Scene, scene: Scene) -> int | None:
    """Number of photos that both scenes place alike; None where they are few, or contradict."""
    shared = sorted({*own.placed} & {*scene.placed})
    if len(shared) < _FEWEST_PHOTOS:
        return None
    ours, theirs = scene.centres_in_world(shared), own.centres_in_world(shared)
    off = np.linalg.norm(other_from_one(own, scene, shared).apply(theirs) - ours, axis=1)
    size = np.linalg.norm(ours - ours.mean(0), axis=1)
    return len(shared) if off.max() < _AGREEING * size.mean() else None


def _side(
    half: Sequence[int],
    photos: PhotoSet,
    features: Features,
    pairs: Pairs,
    cameras: Cameras,
    detections: BoardDetections | None,
    *,
    whole: bool,
) -> Side | None:
    """A candidate side, placed by all that keeps still in it; None where most cannot be placed.

    What the largest part leaves out is placed apart: a face of the object may share too little with
    the next one of the same pose, and be joined to it by the other pose alone.

    Args:
        whole: Whether one part must have most of the photos.
    """
    own = {*half}
    within = [one for one in pairs.verified if {*one.matches.photos} <= own]
    mapping = MappingOptions(min_placed_share=0.0)
    parts: list[Part] = []
    left = own
    try:
        while len(left) >= _FEWEST_PHOTOS and not (whole and parts):
            inside = [k for k in within if {*k.matches.photos} <= left]
            scene = place_roughly(photos, features, Pairs(tuple(inside), 0), cameras, mapping)
            if len(scene.placed) < _FEWEST_PHOTOS:
                break
            metric = _metric(scene, detections, own)
            parts.append(Part(metric=metric, region=find_region(photos, metric)))
            left = left - {*scene.placed}
    except (PlacementError, RegionError):
        pass
    if len(own - left) < _PLACED_SHARE * len(own):
        return None
    return Side(photos=tuple(half), parts=tuple(parts))


def _metric(scene: Scene, detections: BoardDetections | None, own: set[int]) -> MetricScene:
    """The scene scaled by its board where it shows one, else on the floor by its points."""
    if detections is not None:
        shown = tuple(one for one in detections.photos if one.photo_idx in own)
        try:
            return to_millimetres(scene, replace(detections, photos=shown))
        except ScaleError:
            pass
    return to_millimetres(scene)


def _seam_by_pairs(
    pairs: Pairs, detections: BoardDetections | None, lenses: Sequence[Camera]
) -> Iterator[int]:
    """The seam that best separates pairs that contradict the board from those that do not.

    Pairs within one pose rotate as the board shows. So do pairs across the seam that the room
    joined; those that the object joined contradict it. No scene is needed for that.
    """
    if detections is None:
        return
    turns = {
        photo: pose.rotation for photo, pose in _cameras_from_board(detections, lenses).items()
    }
    contradicting = [one for one in pairs.verified if _contradicts_board(one, turns)]
    others = [one for one in pairs.verified if not _contradicts_board(one, turns)]
    starts = range(_FEWEST_PHOTOS, len(lenses) - _FEWEST_PHOTOS + 1)
    if len(contradicting) < _FEWEST_CONTRADICTING or not starts:
        return
    apart = {start: len(_across(contradicting, start)) for start in starts}
    most = max(apart.values())
    if most >= _PLACED_SHARE * len(contradicting):
        # between photos of one pose there are many matches, those of the object and of the room
        joining = {
            start: sum(len(one.matches) for one in _across(others, start))
            for start in starts
            if apart[start] == most
        }
        yield min(joining, key=lambda start: (joining[start], start))


def _contradicts_board(pair: VerifiedPair, turns: Mapping[int, Matrix3]) -> bool:
    """Whether the rotation of a pair contradicts the board that both photos show."""
    ours, pose = pair.matches, pair.second_from_first
    if pair.kind != "general" or pose is None or not {ours.first, ours.second} <= turns.keys():
        return False
    by_board = turns[ours.second] @ turns[ours.first].T
    return angle_between_deg(by_board, pose.rotation) > _CONTRADICTION_DEG


def _across(pairs: Sequence[VerifiedPair], start: int) -> list[VerifiedPair]:
    """Pairs of a photo before `start` with one from it on."""
    return [one for one in pairs if one.matches.first < start <= one.matches.second]


def _seams_by_weak_links(pairs: Pairs, count: int) -> Iterator[int]:
    """Photos with much fewer matches with the one before them than usual, the weakest first."""
    link = np.zeros(count)
    for one in pairs.verified:
        if one.matches.second == one.matches.first + 1:
            link[one.matches.second] = len(one.matches)
    candidates = range(_FEWEST_PHOTOS, count - _FEWEST_PHOTOS + 1)
    usual = float(np.median(link[1:])) if count > 1 else 0.0
    order = sorted(candidates, key=lambda k: (link[k], k))[:_WEAKEST]
    yield from (k for k in order if link[k] < _WEAK_LINK * usual)


def _suspected_seams(
    scene: Scene, detections: BoardDetections | None, pairs: Pairs | None = None
) -> Iterator[int]:
    """Seams: photos from which on object or room may have another pose, likeliest first."""
    if detections is None:
        return
    weak = [] if pairs is None else list(_seams_by_weak_links(pairs, len(scene.names)))
    if by_board := _seam_by_board(scene, detections):
        # poses that contradict are arbitrary: a weak link near by locates the seam better
        near = [k for k in weak if abs(k - by_board) <= _SEAM_TOLERANCE]
        yield from dict.fromkeys([*near, by_board, *weak])
    else:
        yield from _seam_by_points(scene, detections)


def _board_moves(scene: Scene, detections: BoardDetections | None) -> bool:
    """Whether the board lies in two places of the scene."""
    return detections is not None and _seam_by_board(scene, detections) is not None


def _seam_by_points(scene: Scene, detections: BoardDetections) -> Iterator[int]:
    """The seam across which hardly a point near the aim is shared, if there is one.

    Only photos that show the board in its usual place count: the object may have placed others.
    """
    aim = aim_of(scene.views, scene.points_in_world)
    boards = _board_centres(scene, detections)
    if len(boards.photos) < 2 * _FEWEST_PHOTOS:
        return
    in_place = boards.displacements() < _MOVED_SHARE * aim.distance
    shown = [photo for photo, kept in zip(boards.photos, in_place, strict=True) if kept]
    if len(shown) < 2 * _FEWEST_PHOTOS:
        return
    near = np.linalg.norm(scene.points_in_world - aim.point, axis=1) < _NEAR_AIM * aim.reach
    seen = scene.observations.some(np.isin(scene.observations.photo_idx, shown))
    count = len(scene.names)
    first = np.full(len(near), count)
    last = np.full(len(near), -1)
    np.minimum.at(first, seen.point_idx, seen.photo_idx)
    np.maximum.at(last, seen.point_idx, seen.photo_idx)
    first, last = first[near & (last >= 0)], last[near & (last >= 0)]
    shares: list[tuple[float, int]] = []
    for start in range(_FEWEST_PHOTOS, count - _FEWEST_PHOTOS + 1):
        before, after = int((last < start).sum()), int((first >= start).sum())
        if min(before, after) >= _FEWEST_NEAR and _views_overlap(scene, shown, aim.point, start):
            shares.append((1.0 - (before + after) / len(first), start))
    if shares and min(shares)[0] < _SHARED_NEAR:
        yield min(shares)[1]


def _views_overlap(scene: Scene, photos: Sequence[int], aim: Vector3, start: int) -> bool:
    """Whether the photos on both sides of a seam look at the object from like directions."""
    rays = np.array([scene.view(photo).centre_in_world - aim for photo in photos])
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    before = np.array(photos) < start
    if before.all() or not before.any():
        return False
    apart = np.degrees(np.arccos(np.clip(rays[before] @ rays[~before].T, -1.0, 1.0)))
    middle = max(float(np.median(apart.min(axis=k))) for k in (0, 1))
    return middle <= _FACING_ALIKE_DEG and _side_changes(rays, before) > _SEAMS


def _side_changes(rays: Points3, before: Bool[np.ndarray, " n"]) -> int:
    """Number of changes between the sides in the order of directions round the object."""
    across = np.linalg.svd(rays - rays.mean(axis=0))[2]  # the plane of the walk
    round_it = np.argsort(np.arctan2(*(rays @ across[:2].T).T))
    sides = before[round_it]
    return int(np.count_nonzero(sides != np.roll(sides, 1)))


def _is_one_body(sides: Sequence[Side], scene: Scene) -> bool:
    """Whether the object occupies the same region of the scene for both sides."""
    cells: list[Points3] = []
    for side in sides:
        part = side.parts[0]
        shared = sorted({*part.metric.scene.placed} & {*scene.placed})
        if len(shared) < _FEWEST_PHOTOS:
            return False
        cells.append(
            other_from_one(part.metric.scene, scene, shared).apply(
                part.region.centres_mm(part.region.occupied)
            )
        )
    size = max(float(np.ptp(one, axis=0).max()) for one in cells)
    within: list[float] = []
    for one, other in (cells, cells[::-1]):
        near = KDTree(other).query(one, distance_upper_bound=_SAME_PLACE * size)[0]
        within.append(float(np.isfinite(near).mean()))
    return max(within) > _SAME_BODY


def _seam_by_board(scene: Scene, detections: BoardDetections) -> int | None:
    """The seam from which on the board lies in another place of the scene, if it does.

    A photo gives the board's place relative to the camera in millimetres; their size in the scene
    is estimated together with the board's places, by least squares.
    """
    seen = _board_centres(scene, detections)
    count = len(seen.photos)
    if count < 2 * _FEWEST_PHOTOS:
        return None
    aim = aim_of(scene.views, scene.points_in_world)
    if seen.residual_rms(count) < _MOVED_SHARE * aim.distance:
        return None
    starts = range(_FEWEST_PHOTOS, count - _FEWEST_PHOTOS + 1)
    return seen.photos[min(starts, key=lambda start: (seen.residual_rms(start), start))]


@dataclass(frozen=True)
class _BoardCentres:
    """By photo, the vector from the camera to the board's centre, along the scene's axes."""

    photos: tuple[int, ...]
    centres: Points3
    """Of the cameras, in the scene."""
    arms_mm: Points3

    def residual_rms(self, start: int) -> float:
        """RMS distance of the board from its place, in the unit of the scene.

        The board has one place before photo number `start`, and one from it on.
        """
        flat, right = self._equations(start)
        off = right - flat @ np.linalg.lstsq(flat, right, rcond=None)[0]
        return float(np.sqrt(3.0 * np.mean(off**2)))

    def displacements(self) -> Float64[np.ndarray, " n"]:
        """Distance of the board from its usual place, by photo (least trimmed squares)."""
        flat, right = self._equations(len(self.photos))
        off = np.zeros(len(self.photos))
        for _ in range(_TRIMMING_ROUNDS):
            rows = np.repeat(off <= np.quantile(off, _IN_PLACE_SHARE), 3)
            found = np.linalg.lstsq(flat[rows], right[rows], rcond=None)[0]
            off = np.linalg.norm((right - flat @ found).reshape(-1, 3), axis=1)
        return off

    def _equations(
        self, start: int
    ) -> tuple[Float64[np.ndarray, "m c"], Float64[np.ndarray, " m"]]:
        """Linear equations over a millimetre's length and the board's one or two places."""
        places = 3 * (1 + (start < len(self.photos)))
        design = np.zeros((len(self.photos), 3, 1 + places))
        design[:, :, 0] = -self.arms_mm
        design[:start, :, 1:4] = np.eye(3)
        design[start:, :, places - 2 :] = np.eye(3)
        return design.reshape(-1, 1 + places), self.centres.ravel()


def _board_centres(scene: Scene, detections: BoardDetections) -> _BoardCentres:
    """The board\'s centre seen from each placed photo that shows it."""
    placed = replace(
        detections,
        photos=tuple(one for one in detections.photos if one.photo_idx in scene.placed),
    )
    boards = _cameras_from_board(placed, [scene.camera(k) for k in range(len(scene.names))])
    photos = tuple(sorted(boards))
    middle_mm = detections.corners_mm.mean(0)[None]
    views = [scene.view(photo) for photo in photos]
    arms = [
        view.camera_from_world.rotation.T @ boards[photo].apply(middle_mm)[0]
        for photo, view in zip(photos, views, strict=True)
    ]
    centres = [view.centre_in_world for view in views]
    return _BoardCentres(photos, np.array(centres).reshape(-1, 3), np.array(arms).reshape(-1, 3))


def _cameras_from_board(detections: BoardDetections, lenses: Sequence[Camera]) -> dict[int, Rigid]:
    """camera_from_board by photo, without photos whose residuals are far larger than usual.

    One wrong corner of seven, where the limb's silhouette cuts it, can flip the board.

    Args:
        lenses: Of every photo.
    """
    boards: dict[int, Rigid] = {}
    missed: dict[int, float] = {}
    for one in detections.photos:
        lens = lenses[one.photo_idx]
        board = _camera_from_board(one, detections.corners_mm, lens)
        if board is not None:
            shown = View(one.name, lens, board).project(detections.corners_mm[one.ids])
            boards[one.photo_idx] = board
            off_px = np.linalg.norm(shown - one.xy_px, axis=1)
            missed[one.photo_idx] = rms(off_px) / lens.width_px
    usual = float(np.median(list(missed.values()))) if missed else 0.0
    most = max(_LEAST_MISS, _MISSED * usual)
    return {photo: board for photo, board in boards.items() if missed[photo] <= most}


def _camera_from_board(shown: PhotoCorners, corners_mm: Points3, camera: Camera) -> Rigid | None:
    """camera_from_board by the corners of one photo (planar PnP); None where they are too few."""
    corners = corners_mm[shown.ids]
    if len(corners) < _FEWEST_CORNERS or not _spans_plane(corners):
        return None
    ideal = camera.normalize(shown.xy_px)
    found, turn, shift = cv2.solvePnP(
        corners, ideal, np.eye(3), np.zeros(5), flags=cv2.SOLVEPNP_IPPE
    )
    if not found or not (np.isfinite(turn).all() and np.isfinite(shift).all()):
        return None
    return Rigid.from_rotation_vector(np.asarray(turn, float).ravel(), np.ravel(shift))


def _spans_plane(corners_mm: Points3) -> bool:
    """Whether the corners determine a plane, and are not in a row."""
    along, across, _ = np.linalg.svd(corners_mm - corners_mm.mean(0), compute_uv=False)
    return bool(across > _LEAST_ACROSS * along)


def above_floors(
    depths: Sequence[DepthMap], metric: MetricScene, poses: Poses
) -> tuple[DepthMap, ...]:
    """The depth maps without the floor of the side that each photo belongs to.

    The table that a lying cast touches stands upright in the frame of the standing one.
    """
    if not poses.sides:
        return tuple(depths)
    clearance_mm = _CLEARANCE * aim_of(metric.scene.views, metric.scene.points_in_world).distance
    floors = {photo: _floor_in(side, metric) for side in poses.sides for photo in side.photos}
    cleared: list[DepthMap] = []
    for one in depths:
        floor = floors[one.photo_idx]
        cleared.append(one if floor is None else _without_floor(one, floor, clearance_mm))
    return tuple(cleared)


@dataclass(frozen=True)
class _Floor:
    """A plane normal @ x = height, in the world of the whole scene."""

    normal: Float64[np.ndarray, "3"]
    height: float


def _floor_in(side: Side, metric: MetricScene) -> _Floor | None:
    """The floor of one side, in the scene of both; None where no part of it shows one."""
    for part in side.parts:
        floor_z = part.metric.floor_z_mm
        shared = sorted({*part.metric.scene.placed} & {*metric.scene.placed})
        if floor_z is None or len(shared) < _FEWEST_PHOTOS:
            continue
        world_from_part = other_from_one(part.metric.scene, metric.scene, shared)
        normal = world_from_part.rotation[:, 2]
        on_floor = world_from_part.apply(np.array([[0.0, 0.0, floor_z]]))[0]
        return _Floor(normal, float(normal @ on_floor))
    return None


def _without_floor(one: DepthMap, floor: _Floor, clearance_mm: float) -> DepthMap:
    """The depth map without what lies on the floor or below it."""
    camera, pose = one.camera, one.camera_from_world
    row, column = np.nonzero(np.isfinite(one.depth_mm))
    xy_px = np.column_stack([column + one.x0, row + one.y0]).astype(np.float64)
    rays = np.column_stack([camera.normalize(xy_px), np.ones(len(xy_px))])
    points = pose.inverse.apply(rays * one.depth_mm[row, column][:, None].astype(np.float64))
    low = points @ floor.normal - floor.height < clearance_mm
    depth_mm = one.depth_mm.copy()
    depth_mm[row[low], column[low]] = np.nan
    return replace(one, depth_mm=depth_mm)
