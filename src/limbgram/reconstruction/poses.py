"""Poses: an object in two poses, a cast standing and then lying: splits and joins the capture.

In      photos in the order in which they were taken, their features, matches and verified pairs,
        the cameras, where photos show the board; the scene they were placed in, where there is one.
Out     Poses: the two sides of the capture, each with its own scene, or none; what of the features
        lies on the object.
Method  Board, floor and room belong to one pose each, and the object to both. Within one side all
        of it keeps still, so each side is placed by all of its matches. The region of the object in
        each side's scene, above that side's own floor, parts the object's keypoints from the
        room's. What is left of the matches joins the two sides by the object alone.
        Where the sides part: pairs of photos that the object joined across turn otherwise than the
        board that both show, and the board lies in several places of the scene. If the room joined
        them, no point near the aim is seen by photos of both sides; then the object's regions must
        also be different bodies there, for two rounds at heights that share no points show it so.
        If the photos could not be placed in one scene, the weakest links between a photo and the
        next are tried. Photos in any order that stand beside each other and share nothing of the
        object (`limb_groups`) are two sides, or two objects if nothing on it joins them.
Fails   never: a capture that does not fall into two sides has none.
Limits  Without a board, only a capture whose photos could not be placed in one scene is looked at.
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
    Similarity,
    angle_between_deg,
    fit_similarity,
)
from limbgram.core.geometry.lens import Camera, View
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
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.mapping.verdicts import reverified, solved_lenses
from limbgram.reconstruction.matching.matching import Matches
from limbgram.reconstruction.matching.static_background import Still
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
"""Spread of the corners across, of that along: a row behind which the board is hidden has none."""
_MISSED, _LEAST_MISS = 5.0, 0.0005
"""Corners that miss their board by so many times what the middle photo's do, and by this part of
the picture's width, are no board: good ones miss it by 0.00004 to 0.00025."""
_MOVED_SHARE = 0.04
"""How far photos put the board from one place, of the cameras' distance, where an object was turned
over: 0.12 to 0.13. Good captures have 0.0005, a patient who shifts or a board that is pushed
0.01."""
_MOST = 0.6
"""Part of the photos by which the board's place is found where some put it elsewhere."""
_TRIMMING_ROUNDS = 20
_ASTRAY_DEG = 20.0
"""Turn of a pair against its board from which it contradicts it: a board seen flat from afar leaves
its own tilt open by ten degrees and more."""
_FEWEST_ASTRAY = 4
_BESIDE = 3
"""Photos between the best place to part the photos by the board and the weak link that is meant."""
_MOST_TRIED = 6
"""Places at which a capture is parted, at most: each costs two scenes."""
_WEAKEST = 2
"""Links between a photo and the next at which sides are tried."""
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
    """Photos of one side that hang together without those of the other."""

    metric: MetricScene
    """Of these photos alone; it knows the board and the floor of this pose."""
    region: Region
    """Where the object is in it."""


@dataclass(frozen=True, kw_only=True)
class Side:
    """Photos in which the object kept one pose."""

    photos: tuple[int, ...]
    parts: tuple[Part, ...]
    """The largest first. One, unless photos between two parts share too little with either."""

    @property
    def placed(self) -> int:
        """Photos that have a place in one of its parts."""
        return sum(len(part.metric.scene.placed) for part in self.parts)


@dataclass(frozen=True, kw_only=True)
class Poses:
    """The sides of a capture whose object was turned over; none where it was not."""

    sides: tuple[Side, ...] = ()

    def names(self, photos: PhotoSet) -> tuple[Finding, ...]:
        """First and last photo of each side, or the photos where they do not follow each other."""
        of = photos.names
        return tuple(_named([of[photo] for photo in one.photos], one) for one in self.sides)

    def on_object(self, features: Features) -> tuple[Bool[np.ndarray, " n"], ...]:
        """Which keypoints of each photo lie on the object; of photos without a place, none."""
        found = [np.zeros(len(one), bool) for one in features.keypoints]
        for part in (part for side in self.sides for part in side.parts):
            for photo in part.metric.scene.placed:
                seen = footprint(part.region, part.metric.scene.view(photo))
                found[photo] = seen.shows(features.keypoints[photo].xy_px)
        return tuple(found)

    def matches_on_object(self, features: Features, matches: Matches) -> Matches:
        """The matches with both ends on the object."""
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
        """The board as the side shows it that has it in more photos: one place, one scale."""
        if not self.sides:
            return detections
        counts = [sum(one.photo_idx in side.photos for one in detections.photos)
                  for side in self.sides]  # fmt: skip
        kept = self.sides[int(np.argmax(counts))].photos
        photos = tuple(one for one in detections.photos if one.photo_idx in kept)
        return replace(detections, photos=photos)


def _named(names: Sequence[str], side: Side) -> Finding:
    """The photos of a side, in words."""
    if side.photos[-1] - side.photos[0] == len(side.photos) - 1:
        return note("placing.side", first=names[0], last=names[-1])
    return note("placing.side.photos", **first_of(names))


@dataclass(frozen=True)
class Placed:
    """Photos that have places, by the object alone where it was turned over between them."""

    matches: Matches
    pairs: Pairs
    scene: Scene
    poses: Poses
    lenses: ByLens | None = None
    """Where the photos themselves told of other lenses than their files."""


@dataclass(frozen=True, kw_only=True)
class Unplaced:
    """Photos and what was found in them, before any has a place."""

    photos: PhotoSet
    features: Features
    still: Still
    """What stands still; matches and pairs are of what does not."""
    matches: Matches
    pairs: Pairs
    cameras: Cameras
    detections: BoardDetections | None

    def by(self, lenses: ByLens) -> "Unplaced":
        """The same photos with other lenses."""
        return replace(self, photos=lenses.photos, cameras=lenses.cameras)


def place_object(found: Unplaced, run: Run, mapping: MappingOptions = MAPPING) -> Placed:
    """Place photos, with other lenses than files tell where the photos themselves tell so.

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
        return with_lenses(run(by_cut, photos, found.features, found.pairs, cameras, mapping))
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
    """Place photos, and where the object was turned over between them join the sides by it alone.

    Raises:
        PlacementError: too few photos hang together, the object does not join its two sides, or the
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
    """The photos of both sides placed by what lies on the object.

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
    """That photos which board or room join show two limbs, or one in two poses."""
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
    """Groups of photos that share nothing of the limb, as the sides of one that was turned.

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
    by_pairs = _where_pairs_leave_board(turning, detections, lenses)
    others = _weak_links(pairs, count) if scene is None else _suspected(scene, detections, pairs)
    candidates, tried = [*by_pairs, *others], set[int]()
    best: tuple[Side, ...] = ()
    moves = scene is not None and _board_moves(scene, detections)
    while candidates and len(tried) < _MOST_TRIED:
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
        if scene is None or moves or not _one_body(known, scene):
            # a side that itself falls apart begins or ends elsewhere
            scenes = (part.metric.scene for side in known for part in side.parts)
            again = [k for one in scenes for k in _suspected(one, detections)]
            if not again:
                return Poses(sides=known)
            candidates = [*again, *candidates]
            best = max(best, known, key=_photos_placed)
    return Poses(sides=best)


def _photos_placed(sides: Sequence[Side]) -> int:
    return sum(side.placed for side in sides)


def may_be_turned_over(scene: Scene, detections: BoardDetections | None) -> bool:
    """Whether a scene looks as if the object or the room were in it twice."""
    return any(True for _ in _suspected(scene, detections))


def board_beside(detections: BoardDetections | None, still: Still) -> BoardDetections | None:
    """The board where it may lie beside the object: one of the room tells nothing of its poses."""
    return None if detections is None else without_background_board(detections, still)


def board_of_object(detections: BoardDetections, still: Still, poses: Poses) -> BoardDetections:
    """The board where it keeps one place beside the object: only there it tells the scale."""
    return poses.one_board(without_background_board(detections, still))


def refuse_apart(poses: Poses, scene: Scene) -> None:
    """Refuse a scene that the object's two sides do not share, or share wrongly.

    Raises:
        PlacementError: what lies on the object does not join the sides firmly.
    """
    for side in poses.sides:
        agreeing = [_agreeing(part.metric.scene, scene) for part in side.parts]
        if None in agreeing or sum(filter(None, agreeing)) < _PLACED_SHARE * len(side.photos):
            names = [scene.names[photo] for photo in side.photos]
            raise PlacementError("placing.poses_apart", first=names[0], last=names[-1])


def _agreeing(own: Scene, scene: Scene) -> int | None:
    """Photos that both scenes have; None where they are few, or stand otherwise."""
    shared = sorted({*own.placed} & {*scene.placed})
    if len(shared) < _FEWEST_PHOTOS:
        return None
    ours = np.array([scene.view(photo).centre_in_world for photo in shared])
    theirs = np.array([own.view(photo).centre_in_world for photo in shared])
    off = np.linalg.norm(_moved(own, scene, shared).apply(theirs) - ours, axis=1)
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
    """Photos of one pose, placed by all that keeps still in them.

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
    """On its board where it shows one, else on the floor that its points show."""
    if detections is not None:
        shown = tuple(one for one in detections.photos if one.photo_idx in own)
        try:
            return to_millimetres(scene, replace(detections, photos=shown))
        except ScaleError:
            pass
    return to_millimetres(scene)


def _where_pairs_leave_board(
    pairs: Pairs, detections: BoardDetections | None, lenses: Sequence[Camera]
) -> Iterator[int]:
    """The photo that parts best the pairs that turn as the board does from those that do not.

    Two photos of one pose turn against each other as the board shows. So do those of two poses that
    the room joined; those that the object joined turn otherwise. No scene is needed for that.
    """
    if detections is None:
        return
    turns = {
        photo: pose.rotation for photo, pose in _cameras_from_board(detections, lenses).items()
    }
    astray = [one for one in pairs.verified if _turns_otherwise(one, turns)]
    others = [one for one in pairs.verified if not _turns_otherwise(one, turns)]
    starts = range(_FEWEST_PHOTOS, len(lenses) - _FEWEST_PHOTOS + 1)
    if len(astray) < _FEWEST_ASTRAY or not starts:
        return
    apart = {start: len(_across(astray, start)) for start in starts}
    most = max(apart.values())
    if most >= _PLACED_SHARE * len(astray):
        # between photos of one pose there are many matches, those of the object and of the room
        joining = {
            start: sum(len(one.matches) for one in _across(others, start))
            for start in starts
            if apart[start] == most
        }
        yield min(joining, key=lambda start: (joining[start], start))


def _turns_otherwise(pair: VerifiedPair, turns: Mapping[int, Matrix3]) -> bool:
    """Whether both photos of a pair show the board, and it turns otherwise than they do."""
    ours, pose = pair.matches, pair.second_from_first
    if pair.kind != "general" or pose is None or not {ours.first, ours.second} <= turns.keys():
        return False
    by_board = turns[ours.second] @ turns[ours.first].T
    return angle_between_deg(by_board, pose.rotation) > _ASTRAY_DEG


def _across(pairs: Sequence[VerifiedPair], start: int) -> list[VerifiedPair]:
    """Pairs of a photo before `start` with one from it on."""
    return [one for one in pairs if one.matches.first < start <= one.matches.second]


def _weak_links(pairs: Pairs, count: int) -> Iterator[int]:
    """Photos that match the one before them much worse than others do, the weakest first."""
    link = np.zeros(count)
    for one in pairs.verified:
        if one.matches.second == one.matches.first + 1:
            link[one.matches.second] = len(one.matches)
    candidates = range(_FEWEST_PHOTOS, count - _FEWEST_PHOTOS + 1)
    usual = float(np.median(link[1:])) if count > 1 else 0.0
    order = sorted(candidates, key=lambda k: (link[k], k))[:_WEAKEST]
    yield from (k for k in order if link[k] < _WEAK_LINK * usual)


def _suspected(
    scene: Scene, detections: BoardDetections | None, pairs: Pairs | None = None
) -> Iterator[int]:
    """Photos from which on object or room may be in another place of the scene, likeliest first."""
    if detections is None:
        return
    weak = [] if pairs is None else list(_weak_links(pairs, len(scene.names)))
    if by_board := _where_board_moves(scene, detections):
        # photos that no scene fits are put anywhere: a weak link tells better where the sides part
        near = [k for k in weak if abs(k - by_board) <= _BESIDE]
        yield from dict.fromkeys([*near, by_board, *weak])
    else:
        yield from _where_object_parts(scene, detections)


def _board_moves(scene: Scene, detections: BoardDetections | None) -> bool:
    return detections is not None and _where_board_moves(scene, detections) is not None


def _where_object_parts(scene: Scene, detections: BoardDetections) -> Iterator[int]:
    """The photo from which on hardly a point near the aim is one of those seen before.

    Photos that show the board where most do are asked: the object may have placed the others.
    """
    aim = aim_of(scene.views, scene.points_in_world)
    boards = _boards_from_cameras(scene, detections)
    if len(boards.photos) < 2 * _FEWEST_PHOTOS:
        return
    in_place = boards.off_their_place() < _MOVED_SHARE * aim.distance
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
        if min(before, after) >= _FEWEST_NEAR and _face_alike(scene, shown, aim.point, start):
            shares.append((1.0 - (before + after) / len(first), start))
    if shares and min(shares)[0] < _SHARED_NEAR:
        yield min(shares)[1]


def _face_alike(scene: Scene, photos: Sequence[int], aim: Vector3, start: int) -> bool:
    """Whether photos before `start` look at the object from where those from it on do."""
    rays = np.array([scene.view(photo).centre_in_world - aim for photo in photos])
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    before = np.array(photos) < start
    if before.all() or not before.any():
        return False
    apart = np.degrees(np.arccos(np.clip(rays[before] @ rays[~before].T, -1.0, 1.0)))
    middle = max(float(np.median(apart.min(axis=k))) for k in (0, 1))
    return middle <= _FACING_ALIKE_DEG and _changes_round(rays, before) > _SEAMS


def _changes_round(rays: Points3, before: Bool[np.ndarray, " n"]) -> int:
    """How often photos of one side follow those of the other in the order round the object."""
    across = np.linalg.svd(rays - rays.mean(axis=0))[2]  # the plane of the walk
    round_it = np.argsort(np.arctan2(*(rays @ across[:2].T).T))
    sides = before[round_it]
    return int(np.count_nonzero(sides != np.roll(sides, 1)))


def _one_body(sides: Sequence[Side], scene: Scene) -> bool:
    """Whether the object is in one place of the scene for both sides."""
    cells: list[Points3] = []
    for side in sides:
        part = side.parts[0]
        shared = sorted({*part.metric.scene.placed} & {*scene.placed})
        if len(shared) < _FEWEST_PHOTOS:
            return False
        cells.append(
            _moved(part.metric.scene, scene, shared).apply(
                part.region.centres_mm(part.region.occupied)
            )
        )
    size = max(float(np.ptp(one, axis=0).max()) for one in cells)
    within: list[float] = []
    for one, other in (cells, cells[::-1]):
        near = KDTree(other).query(one, distance_upper_bound=_SAME_PLACE * size)[0]
        within.append(float(np.isfinite(near).mean()))
    return max(within) > _SAME_BODY


def _where_board_moves(scene: Scene, detections: BoardDetections) -> int | None:
    """The photo from which on the board lies in another place of the scene, if it does.

    A photo shows where the board is from it, in millimetres; how large these are in the scene is
    found with the board's places, by least squares.
    """
    seen = _boards_from_cameras(scene, detections)
    count = len(seen.photos)
    if count < 2 * _FEWEST_PHOTOS:
        return None
    aim = aim_of(scene.views, scene.points_in_world)
    if seen.spread_of(count) < _MOVED_SHARE * aim.distance:
        return None
    starts = range(_FEWEST_PHOTOS, count - _FEWEST_PHOTOS + 1)
    return seen.photos[min(starts, key=lambda start: (seen.spread_of(start), start))]


@dataclass(frozen=True)
class _Boards:
    """In each photo the board's middle, seen from the camera, along the scene's axes, in mm."""

    photos: tuple[int, ...]
    centres: Points3
    """Of the cameras, in the scene."""
    arms_mm: Points3

    def spread_of(self, start: int) -> float:
        """How far photos put the board from its place, root mean square, in the scene.

        It has one place before photo number `start`, and one from it on.
        """
        flat, right = self._equations(start)
        off = right - flat @ np.linalg.lstsq(flat, right, rcond=None)[0]
        return float(np.sqrt(3.0 * np.mean(off**2)))

    def off_their_place(self) -> Float64[np.ndarray, " n"]:
        """How far each photo puts the board from where most of them do (least trimmed squares)."""
        flat, right = self._equations(len(self.photos))
        off = np.zeros(len(self.photos))
        for _ in range(_TRIMMING_ROUNDS):
            rows = np.repeat(off <= np.quantile(off, _MOST), 3)
            found = np.linalg.lstsq(flat[rows], right[rows], rcond=None)[0]
            off = np.linalg.norm((right - flat @ found).reshape(-1, 3), axis=1)
        return off

    def _equations(
        self, start: int
    ) -> tuple[Float64[np.ndarray, "m c"], Float64[np.ndarray, " m"]]:
        """Of the places of the board, one or two that part at `start`, and of its size."""
        places = 3 * (1 + (start < len(self.photos)))
        design = np.zeros((len(self.photos), 3, 1 + places))
        design[:, :, 0] = -self.arms_mm
        design[:start, :, 1:4] = np.eye(3)
        design[start:, :, places - 2 :] = np.eye(3)
        return design.reshape(-1, 1 + places), self.centres.ravel()


def _boards_from_cameras(scene: Scene, detections: BoardDetections) -> _Boards:
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
    return _Boards(photos, np.array(centres).reshape(-1, 3), np.array(arms).reshape(-1, 3))


def _cameras_from_board(detections: BoardDetections, lenses: Sequence[Camera]) -> dict[int, Rigid]:
    """Where photos see the board, but those whose corners miss it by far more than others' do.

    One corner of seven that the limb's silhouette cuts turns the board over.

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
            missed[one.photo_idx] = float(np.sqrt(np.mean(off_px**2))) / lens.width_px
    usual = float(np.median(list(missed.values()))) if missed else 0.0
    most = max(_LEAST_MISS, _MISSED * usual)
    return {photo: board for photo, board in boards.items() if missed[photo] <= most}


def _camera_from_board(shown: PhotoCorners, corners_mm: Points3, camera: Camera) -> Rigid | None:
    """Where the board is, by the corners that the photo shows; None where they are too few."""
    corners = corners_mm[shown.ids]
    if len(corners) < _FEWEST_CORNERS or not _spread_out(corners):
        return None
    ideal = camera.normalize(shown.xy_px)
    found, turn, shift = cv2.solvePnP(
        corners, ideal, np.eye(3), np.zeros(5), flags=cv2.SOLVEPNP_IPPE
    )
    if not found or not (np.isfinite(turn).all() and np.isfinite(shift).all()):
        return None
    return Rigid.from_rotation_vector(np.asarray(turn, float).ravel(), np.ravel(shift))


def _spread_out(corners_mm: Points3) -> bool:
    """Whether corners show a plane, and not a row of them alone."""
    along, across, _ = np.linalg.svd(corners_mm - corners_mm.mean(0), compute_uv=False)
    return bool(across > _LEAST_ACROSS * along)


def above_floors(
    depths: Sequence[DepthMap], metric: MetricScene, poses: Poses
) -> tuple[DepthMap, ...]:
    """Depth maps without what lies on the floor of their own photo's side.

    The table that a lying cast touches stands upright in the frame of the standing one.
    """
    if not poses.sides:
        return tuple(depths)
    clearance_mm = _CLEARANCE * aim_of(metric.scene.views, metric.scene.points_in_world).distance
    floors = {photo: _floor_in(side, metric) for side in poses.sides for photo in side.photos}
    cleared: list[DepthMap] = []
    for one in depths:
        floor = floors[one.photo_idx]
        cleared.append(one if floor is None else _cleared(one, floor, clearance_mm))
    return tuple(cleared)


@dataclass(frozen=True)
class _Floor:
    """Points with normal @ x = height, in the world of the whole scene."""

    normal: Float64[np.ndarray, "3"]
    height: float


def _floor_in(side: Side, metric: MetricScene) -> _Floor | None:
    """The floor of one side in the scene of both, by the first part of it that shows one."""
    for part in side.parts:
        floor_z = part.metric.floor_z_mm
        shared = sorted({*part.metric.scene.placed} & {*metric.scene.placed})
        if floor_z is None or len(shared) < _FEWEST_PHOTOS:
            continue
        world_from_part = _moved(part.metric.scene, metric.scene, shared)
        normal = world_from_part.rotation[:, 2]
        on_floor = world_from_part.apply(np.array([[0.0, 0.0, floor_z]]))[0]
        return _Floor(normal, float(normal @ on_floor))
    return None


def _moved(one: Scene, other: Scene, shared: Sequence[int]) -> Similarity:
    """other_from_one by the centres of photos that both have."""
    return fit_similarity(
        np.array([one.view(photo).centre_in_world for photo in shared]),
        np.array([other.view(photo).centre_in_world for photo in shared]),
    )


def _cleared(one: DepthMap, floor: _Floor, clearance_mm: float) -> DepthMap:
    """The map without places on the floor or below it."""
    camera, pose = one.camera, one.camera_from_world
    row, column = np.nonzero(np.isfinite(one.depth_mm))
    xy_px = np.column_stack([column + one.x0, row + one.y0]).astype(np.float64)
    rays = np.column_stack([camera.normalize(xy_px), np.ones(len(xy_px))])
    points = pose.inverse.apply(rays * one.depth_mm[row, column][:, None].astype(np.float64))
    low = points @ floor.normal - floor.height < clearance_mm
    depth_mm = one.depth_mm.copy()
    depth_mm[row[low], column[low]] = np.nan
    return replace(one, depth_mm=depth_mm)
