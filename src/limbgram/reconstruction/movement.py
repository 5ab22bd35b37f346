"""Movement: did the limb move against its surroundings, or bend, during the capture?

In      photos, their keypoints and all matches, the scene that they were placed in, cameras.
Out     a BodyMotion: whether and how the surroundings moved, relative to the limb. Where they did,
        the matches on the limb alone, and the board's corners as if nothing had moved.
Method  The region of the limb in the scene separates the keypoints of every photo into those on the
        limb and those beside it. From the matches of each kind, also those that the scene rejected,
        the photos are placed anew with the lenses fixed: once by the limb, once by the
        surroundings. The search over hypotheses (`hypotheses`) compares the two. The two halves of
        the limb's length are compared in the same way, and its curvature is tested: a limb that
        bends is no rigid body.
        Where limb and surroundings moved against each other, photos placed by the board's corners
        alone show whether the board kept still with the limb. Then only other things were moved:
        the photos keep the poses by all that kept still, if the corners agree better there.
Limits  What moves by more than some hundredths of the picture's width, such as a turntable, is no
        patient who shifts: its matches are not used. A board that fewer than ten photos show does
        not decide who moved. Surroundings that show few points, and an object that cannot be
        separated from them, are said to be unknown.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float64, Int8

from limbgram.core.errors import PlacementError, RegionError
from limbgram.core.geometry.arrays import AnyPoints3, Points2, Points3
from limbgram.core.geometry.frames import Similarity, fit_similarity
from limbgram.core.geometry.lens import View
from limbgram.core.geometry.triangulation import triangulate
from limbgram.core.interval import MAD_TO_SIGMA
from limbgram.findings import Finding, Value, doubt, note
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.dense.region import Region, find_region, footprint
from limbgram.reconstruction.features.detection import Features
from limbgram.reconstruction.hypotheses.curvature import CurvatureChange, find_curvature_change
from limbgram.reconstruction.hypotheses.relative_motion import is_rigid_with_first, movement_between
from limbgram.reconstruction.mapping.body_motion import BodyMotion, connected_photos
from limbgram.reconstruction.mapping.bundle import CAUCHY_SIGMAS
from limbgram.reconstruction.mapping.bundle_adjustment import (
    OUTLIER_SIGMAS,
    SIGMA_INFLATION,
    adjust,
)
from limbgram.reconstruction.mapping.placement import MappingOptions, readjusted, without_photos
from limbgram.reconstruction.mapping.scene import (
    Bodies,
    Movement,
    Observations,
    Scene,
    other_from_one,
)
from limbgram.reconstruction.mapping.score_tests import SIGNIFICANCE_LEVEL
from limbgram.reconstruction.mapping.tracks import best_connected, significant_pairs, with_tracks
from limbgram.reconstruction.mapping.verdicts import refined_keypoints_by
from limbgram.reconstruction.matching.matching import Matches, PairMatches
from limbgram.reconstruction.photos.photo import PhotoSet, first_of
from limbgram.reconstruction.scale.board import placed_photos
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.scale.scaling import to_millimetres
from limbgram.reconstruction.targets.board import BoardDetections, PhotoCorners

_BOARD_CORNERS = 4
_BOARD_PHOTOS = 4
"""Photos of one group from which their board alone sets the scale."""


_REACH = 0.03
"""Largest distance of a match from its expected place, as a share of the photo's width."""
_TRACK_PX = 2.0
"""The same once the photos were placed by one body."""
_PAIR_MATCHES, _HALF_MATCHES = 400, 150
"""Largest number of matches of a pair, on limb or surroundings, and on half a limb."""


@dataclass(frozen=True, kw_only=True)
class Sides:
    """Label of each keypoint: on which half of the limb, beside it, or on the board."""

    keypoints: tuple[Int8[np.ndarray, " k"] | None, ...] = ()
    """By photo and keypoint: 0 beside the limb, 1 and 2 on the halves of its length, 3 where the
    picture may show either, 4 on the board; None where the photo was not placed."""
    unknown: Finding | None = None
    """Why the labels are unknown."""

    def matches_on(self, pairs: Sequence[PairMatches], kinds: tuple[int, ...]) -> list[PairMatches]:
        """Matches of placed photos with both keypoints of these kinds."""
        found: list[PairMatches] = []
        for pair in pairs:
            first, second = self.keypoints[pair.first], self.keypoints[pair.second]
            if first is None or second is None:
                continue
            ends = pair.keypoint_idx
            keep = np.isin(first[ends[:, 0]], kinds) & np.isin(second[ends[:, 1]], kinds)
            found.append(pair.some(keep))
        return found


_MIN_VIEWS = 2
_BESIDE, _HALVES, _ON_LIMB, _ON_BOARD = 0, (1, 2), (1, 2, 3), 4
_ROOM = (_BESIDE, _ON_BOARD)
"""Labels of Sides.keypoints."""
_BENT_SIGMAS = 16.0
"""Outlier threshold where the limb may bend: such residuals are weighted down, not left out. A lean
of 8 mm is 1.6 px where keypoints have a sigma of 0.03 px."""
_FAR_PX = 1e3
"""Residual of a match that cannot be triangulated."""
_BOARD_MARGIN = 2.0
"""Margin round the outermost corners, in squares: one is printed, and the board may have moved."""


def tell_sides(
    photos: PhotoSet,
    features: Features,
    scene: Scene,
    detections: BoardDetections | None = None,
) -> Sides:
    """Label the keypoints by the projections of the limb's region and of the board."""
    metric = to_millimetres(scene)
    try:
        region = find_region(photos, metric)
    except RegionError:
        return Sides(unknown=note("movement.unknown.region"))
    halves, board = _halved(region), _BoardOutline.of(detections, metric.scene)
    found: list[Int8[np.ndarray, " k"] | None] = [None] * len(scene.names)
    for k in scene.placed:
        view, xy_px = metric.scene.view(k), features.keypoints[k].xy_px
        shown = [footprint(half, view).shows(xy_px) for half in halves]
        own = (shown[0] * _HALVES[0] + shown[1] * _HALVES[1]).astype(np.int8)
        found[k] = np.where(
            (own == _BESIDE) & board.shown_at(k, xy_px.astype(float)), _ON_BOARD, own
        ).astype(np.int8)
    return Sides(keypoints=tuple(found))


@dataclass(frozen=True)
class _BoardOutline:
    """The board's outline in a scene; None where it is not located."""

    scene: Scene
    outline: Float64[np.ndarray, "4 3"] | None

    @classmethod
    def of(cls, detections: BoardDetections | None, scene: Scene) -> "_BoardOutline":
        pose = None if detections is None else _scene_from_board(detections, scene)
        if detections is None or pose is None:
            return cls(scene, None)
        margin = _BOARD_MARGIN * detections.board.square_mm
        (left, low, _), (right, high, _) = (
            detections.corners_mm.min(axis=0) - margin,
            detections.corners_mm.max(axis=0) + margin,
        )
        corners = np.array([(left, low, 0), (right, low, 0), (right, high, 0), (left, high, 0)])
        return cls(scene, pose.apply(corners.astype(float)))

    def shown_at(self, photo: int, xy_px: Points2) -> Bool[np.ndarray, " n"]:
        """Whether the board covers these pixels of a photo."""
        if self.outline is None:
            return np.zeros(len(xy_px), np.bool_)
        view = self.scene.view(photo)
        corners = view.project(self.outline)
        if not np.isfinite(corners).all():
            return np.zeros(len(xy_px), np.bool_)
        sides = np.roll(corners, -1, axis=0) - corners
        off = xy_px[:, None] - corners
        turns = sides[:, 0] * off[..., 1] - sides[:, 1] * off[..., 0]
        inside = (turns > 0.0).all(axis=1) | (turns < 0.0).all(axis=1)
        return np.asarray(inside, np.bool_)


@dataclass(frozen=True, kw_only=True)
class LabelledScene:
    """Placed photos whose keypoints are labelled: on the limb, beside it, or on the board."""

    photos: PhotoSet
    features: Features
    matches: Matches
    """All of them, those beside the limb too."""
    scene: Scene
    sides: Sides
    cameras: Cameras
    detections: BoardDetections | None = None
    """Of a board, which tells what a millimetre is."""

    def matches_on(self, kinds: tuple[int, ...]) -> list[PairMatches]:
        """Matches of placed photos with both keypoints of these kinds."""
        return self.sides.matches_on(self.matches.pairs, kinds)

    @cached_property
    def mm(self) -> float | None:
        """Length of a millimetre in the scene; None where it is unknown."""
        return millimetre(self.detections, self.scene)


def find_movement(seen: LabelledScene) -> BodyMotion:
    """The motion of the surroundings relative to the limb, by photo."""
    if seen.sides.unknown:
        return BodyMotion.unknown(len(seen.scene.names), seen.sides.unknown)
    limb = _BodyMatches("limb", seen.matches_on(_ON_LIMB))
    room = _BodyMatches("room", seen.matches_on(_ROOM))
    return _compared_bodies("limb and room", limb, room, seen, _PAIR_MATCHES)


def find_bending(seen: LabelledScene) -> BodyMotion:
    """The relative motion of the two halves of the limb, and any change of its curvature."""
    if seen.sides.unknown:
        return BodyMotion.unknown(len(seen.scene.names), seen.sides.unknown)
    one = _BodyMatches("half", seen.matches_on(_HALVES[:1]))
    other = _BodyMatches("other half", seen.matches_on(_HALVES[1:]))
    found = _compared_bodies("halves", one, other, seen, _HALF_MATCHES)
    limb = _thinned(seen.matches_on(_ON_LIMB), _PAIR_MATCHES)
    bent = _curvature_change(limb, seen)
    return found if bent is None else replace(found, movement=bent.merged_with(found.movement))


def _curvature_change(limb: list[PairMatches], seen: LabelledScene) -> CurvatureChange | None:
    """The change of the limb's curvature, from photos placed by the limb alone."""
    try:
        placed = _placed_by_matches(seen, limb, outlier_sigmas=_BENT_SIGMAS)
        if placed is None:
            return None
        alone = _in_frame_of(seen.scene, placed)
        return find_curvature_change(alone, seen.cameras.calibrations, seen.mm)
    except np.linalg.LinAlgError:  # a photo loses all its points
        return None


def millimetre(detections: BoardDetections | None, scene: Scene) -> float | None:
    """Approximate length of a millimetre in the scene, by the board; None where it is not seen."""
    pose = None if detections is None else _scene_from_board(detections, scene)
    return None if pose is None else float(pose.scale)


def _scene_from_board(detections: BoardDetections, scene: Scene) -> Similarity | None:
    """Approximate similarity from the board's frame to the scene; None where it is not located."""
    seen = placed_photos(detections, scene)
    if len(seen) < _MIN_VIEWS:
        return None
    places = _triangulated_corners(seen.values(), scene.views_of(seen), len(detections.corners_mm))
    known = np.asarray(np.isfinite(places).all(axis=1))
    if known.sum() < _BOARD_CORNERS:
        return None
    return fit_similarity(detections.corners_mm[known], places[known])


def held_against_board(seen: LabelledScene, found: BodyMotion) -> Movement:
    """The movement, but `beside` if limb and board kept still and only other things moved.

    Leaflets and boxes that somebody moves seem to be a limb that moves against its surroundings.
    The size is taken from the board, so what counts is whether the limb kept still against that.
    """
    if seen.detections is None:
        return found.movement
    scene, cameras = seen.scene, seen.cameras
    try:
        by_limb = _placed_by_matches(seen, _thinned(seen.matches_on(_ON_LIMB), _PAIR_MATCHES))
        by_board = _placed_by_board(seen.detections, scene, cameras)
    except np.linalg.LinAlgError:  # equations without a solution: a photo loses all its points
        return found.movement
    if by_limb is None or by_board is None:
        return found.movement
    limb_scene, board_scene = _in_frame_of(scene, by_limb), _in_frame_of(scene, by_board)
    if not is_rigid_with_first(limb_scene, board_scene, found, cameras.calibrations):
        return found.movement
    return replace(_as_still(found.movement), beside=True)


def told_from_board(seen: LabelledScene, found: BodyMotion) -> Movement:
    """The movement, decided between limb and board by what lies beside both.

    The board's print shows many of the points beside the limb. Where what lies beside both
    kept still with the limb, the board was pushed; where nothing decides, both are named.
    """
    try:
        placed = _placed_by_matches(seen, _thinned(seen.matches_on(_ON_LIMB), _PAIR_MATCHES))
    except np.linalg.LinAlgError:  # a photo loses all its points
        placed = None
    if placed is None:
        return limb_or_board(found.movement)
    limb = _in_frame_of(seen.scene, placed)
    moved = third_moved(limb, seen.matches_on((_BESIDE,)), found)
    if moved is None:
        return limb_or_board(found.movement)
    return found.movement if moved else replace(_as_still(found.movement), pushed=True)


def third_moved(limb: Scene, pairs: Sequence[PairMatches], found: BodyMotion) -> bool | None:
    """Whether the points of these pairs moved as the second body did; False if they kept still.

    They need not join the photos: each pair of photos that shows the second body in two places
    tells by itself. None where neither is significant, or where that rests on one
    photo: wrong points of one photo agree with each other.
    """
    known_group = found.movement.group >= 0
    ends: list[tuple[int, int]] = []
    residuals_px: list[Float64[np.ndarray, "2 m"]] = []
    for pair in pairs:
        photos = pair.first, pair.second
        known = all(known_group[k] and limb.camera_from_world[k] is not None for k in photos)
        if not known or not len(pair) or not np.ptp(found.motions[list(photos)], axis=0).any():
            continue
        seen_px = (pair.xy_first_px, pair.xy_second_px)
        still = [limb.view(k) for k in photos]
        moved = [
            replace(view, camera_from_world=view.camera_from_world @ found.in_photo(k))
            for k, view in zip(photos, still, strict=True)
        ]
        residuals_px.append(np.array([_residuals_px(views, seen_px) for views in (still, moved)]))
        ends.append(photos)
    if not ends:
        return None
    # of the limb's own points: many matches beside it are wrong, and fit neither
    scale_px = CAUCHY_SIGMAS * MAD_TO_SIGMA * float(np.nanmedian(np.abs(limb.residuals_px())))
    weight = (CAUCHY_SIGMAS / SIGMA_INFLATION) ** 2
    costs = np.array([weight * np.log1p((px / scale_px) ** 2).sum(axis=1) for px in residuals_px])
    for_motion = costs[:, 0] - costs[:, 1]
    shows = np.array([np.isin(ends, photo).any(axis=1) for photo in np.unique(ends)])
    total = float(for_motion.sum())
    without_one = total - shows @ for_motion
    sign = math.copysign(1.0, total)
    # that one photo is wrong is rare by itself: the others need to tell half as much
    least = -2.0 * math.log(SIGNIFICANCE_LEVEL)
    if abs(total) < least or (sign * without_one < least / 2.0).any():
        return None
    return total > 0.0


def _residuals_px(views: Sequence[View], seen_px: Sequence[Points2]) -> Float64[np.ndarray, " m"]:
    """Reprojection errors of two photos' matches at the points triangulated from them."""
    count = len(seen_px[0])
    point = np.arange(count, dtype=np.int32)
    places = triangulate(
        views,
        np.repeat(np.arange(2, dtype=np.int32), count),
        np.concatenate([point, point]),
        np.concatenate(seen_px).astype(float),
        count,
    ).points_in_world
    off = np.hstack([view.project(places) - xy for view, xy in zip(views, seen_px, strict=True)])
    return np.nan_to_num(np.linalg.norm(off, axis=1), nan=_FAR_PX)


def limb_or_board(movement: Movement) -> Movement:
    """The movement where nothing decides between limb and board: unknown, without facts."""
    doubted = tuple(
        replace(one, failed=("board",)) if one.is_fact else one for one in movement.explanations
    )
    unknown = Movement.unknown(len(movement.shift), chance=movement.chance)
    return replace(unknown, explanations=doubted)


def _as_still(movement: Movement) -> Movement:
    """The movement of the same photos if nothing had moved."""
    known = movement.group >= 0
    nothing = np.where(known, 0.0, np.nan)
    return replace(
        movement,
        kind="still",
        group=np.where(known, 0, -1),
        shift=nothing,
        turn_deg=nothing.copy(),
        chance=1.0,
        largest=0.0,
    )


def without_what_moved_beside(
    photos: PhotoSet, scene: Scene, cameras: Cameras, mapping: MappingOptions
) -> Scene:
    """The scene adjusted without the points beside the limb that only two photos show.

    Of a thing that is moved between photos, two of them still make a point, somewhere; a third one
    contradicts it. On the limb, which kept still, two photos do.
    """
    metric = to_millimetres(scene)
    try:
        region = find_region(photos, metric)
    except RegionError:
        return scene
    seen = scene.observations
    on_limb = np.zeros(len(scene.points_in_world), np.bool_)
    for photo in scene.placed:
        rows = seen.photo_idx == photo
        shown = footprint(region, metric.scene.view(photo)).shows(seen.xy_px[rows])
        on_limb[seen.point_idx[rows][shown]] = True
    times = np.bincount(seen.point_idx, minlength=len(on_limb))
    firm = np.flatnonzero(on_limb | (times > _MIN_VIEWS))
    new_idx = np.full(len(on_limb), -1)
    new_idx[firm] = np.arange(len(firm))
    kept = seen.some(new_idx[seen.point_idx] >= 0)
    rest = replace(
        scene,
        points_in_world=scene.points_in_world[firm],
        observations=replace(kept, point_idx=new_idx[kept.point_idx].astype(np.int32)),
    )
    try:
        return readjusted(rest, cameras, mapping)
    except PlacementError:
        return scene


def corners_agree_better(detections: BoardDetections, first: Scene, second: Scene) -> bool:
    """Whether the board's corners have smaller residuals in the first scene.

    They take no part in the placing of either, and so tell which one is nearer to the truth.
    """
    misses: list[float] = []
    for scene in (first, second):
        seen = placed_photos(detections, scene)
        if not seen:
            return False
        photos, views = seen.values(), scene.views_of(seen)
        places = _triangulated_corners(photos, views, len(detections.corners_mm))
        misses.append(_median_residual_px(photos, views, places))
    return misses[0] < misses[1]


def limb_matches(matches: Matches, sides: Sides) -> Matches:
    """The matches with both keypoints on the limb."""
    if sides.unknown:
        return matches
    return replace(matches, pairs=tuple(sides.matches_on(matches.pairs, _ON_LIMB)))


def still_board(detections: BoardDetections, scene: Scene, found: BodyMotion) -> BoardDetections:
    """The board's corners as photos would show them if all had kept still.

    The board lies in the surroundings: what moves these in a photo moves its corners too. Where
    enough photos of one group show the board, theirs are taken as they are and no others; that is
    0.07 px sure where corners that were moved are sure to 0.3 px (14 photos of 0.5 MP).
    Things behind the limb can move as well, and limb and board keep still: corners that agree
    better from where the photos are by the limb than from where they are by the surroundings are
    taken as they are.
    """
    seen = placed_photos(detections, scene)
    groups = found.movement.group[[*seen]]
    if found.movement.kind == "step" and (groups >= 0).any():
        largest = int(np.bincount(groups[groups >= 0]).argmax())
        agreeing = [seen[k] for k in seen if found.movement.group[k] == largest]
        if len(agreeing) >= _BOARD_PHOTOS:
            return replace(detections, photos=tuple(agreeing))
    return _motion_corrected(detections, seen, scene, found)


def _motion_corrected(
    detections: BoardDetections,
    seen: dict[int, PhotoCorners],
    scene: Scene,
    found: BodyMotion,
) -> BoardDetections:
    """The detections with corners shifted to where they would be had nothing moved."""
    if not seen:
        return detections
    photos, still = seen.values(), scene.views_of(seen)
    moved = [
        replace(view, camera_from_world=view.camera_from_world @ found.in_photo(k))
        for k, view in zip(seen, still, strict=True)
    ]
    places = _triangulated_corners(photos, moved, len(detections.corners_mm))
    kept_still = _triangulated_corners(photos, still, len(detections.corners_mm))
    if _median_residual_px(photos, still, kept_still) < _median_residual_px(photos, moved, places):
        return detections
    new: dict[str, PhotoCorners] = {}
    for photo, here, there in zip(photos, still, moved, strict=True):
        known = np.isfinite(places[photo.ids]).all(1)
        corners = places[photo.ids[known]]
        xy_px = photo.xy_px.copy()
        xy_px[known] += here.project(corners) - there.project(corners)
        new[photo.name] = replace(photo, xy_px=xy_px)
    return replace(
        detections, photos=tuple(new.get(photo.name, photo) for photo in detections.photos)
    )


def _triangulated_corners(
    photos: Collection[PhotoCorners], views: Sequence[View], corners: int
) -> AnyPoints3:
    """The board's corners triangulated from these views."""
    return triangulate(
        views,
        np.repeat(np.arange(len(photos), dtype=np.int32), [len(photo.ids) for photo in photos]),
        np.concatenate([photo.ids for photo in photos]),
        np.concatenate([photo.xy_px for photo in photos]),
        corners,
    ).points_in_world


def _median_residual_px(
    photos: Collection[PhotoCorners], views: Sequence[View], places: AnyPoints3
) -> float:
    """Median reprojection error of the board's corners."""
    misses = np.concatenate(
        [
            np.linalg.norm(view.project(places[photo.ids]) - photo.xy_px, axis=1)
            for photo, view in zip(photos, views, strict=True)
        ]
    )
    known = misses[np.isfinite(misses)]
    return float(np.median(known)) if len(known) else np.inf


@dataclass(frozen=True)
class _BodyMatches:
    """Matches of one body."""

    where: Literal["limb", "room", "half", "other half"]
    pairs: list[PairMatches]


def _compared_bodies(
    bodies: Bodies,
    first: _BodyMatches,
    second: _BodyMatches,
    seen: LabelledScene,
    pair_matches: int,
) -> BodyMotion:
    """The motion between two bodies, from photos placed by each of them alone.

    Args:
        pair_matches: Largest number of matches of a pair on one body.
    """
    scene, cameras = seen.scene, seen.cameras
    alone: list[Scene] = []
    try:
        for body in (first, second):
            some = _thinned(body.pairs, pair_matches)
            placed = _placed_by_matches(seen, some, of_limb=body.where != "room")
            if placed is None:
                few = note("movement.unknown.few_points", where=body.where)
                return BodyMotion.unknown(len(scene.names), few)
            alone.append(_in_frame_of(scene, placed))
        return movement_between(alone[0], alone[1], cameras.calibrations, bodies, seen.mm)
    except np.linalg.LinAlgError:  # equations without a solution: a photo loses all its points
        unheld = note("movement.unknown.unheld", first=first.where, second=second.where)
        return BodyMotion.unknown(len(scene.names), unheld)


def _halved(region: Region) -> tuple[Region, Region]:
    """The region cut in two across its longest axis."""
    cells = np.argwhere(region.occupied).astype(float)
    centred = cells - cells.mean(0)
    along = np.linalg.eigh(centred.T @ centred).eigenvectors[:, -1]
    along = along * np.sign(along[np.argmax(np.abs(along))])
    upper = np.zeros_like(region.occupied)
    upper[region.occupied] = centred @ along > 0.0
    return (
        replace(region, occupied=region.occupied & ~upper),
        replace(region, occupied=upper),
    )


def _thinned(pairs: list[PairMatches], most: int) -> list[PairMatches]:
    """At most `most` matches of each pair: those whose keypoints have most other matches."""
    return [pair.some(keep) for pair, keep in zip(pairs, best_connected(pairs, most), strict=True)]


def _placed_by_matches(
    seen: LabelledScene,
    pairs: list[PairMatches],
    outlier_sigmas: float = OUTLIER_SIGMAS,
    of_limb: bool = True,
) -> Scene | None:
    """The scene placed by these matches alone, starting from its poses, with fixed lenses.

    Args:
        of_limb: Whether pairs without significantly many inliers are left out: photos from opposite
            sides share nothing of a limb. No poses fit all of a room in which a board is pushed.
    """
    if not any(len(pair) for pair in pairs):
        return None
    scene, cameras, photos = seen.scene, seen.cameras, seen.photos
    keypoints_px = refined_keypoints_by(seen.features, pairs)
    width = max(photo.width_px for photo in photos.photos)
    for again, reach_px in enumerate((_REACH * width, _TRACK_PX)):
        if of_limb and again:
            pairs = significant_pairs(scene, keypoints_px, pairs, reach_px) or pairs
        scene = _retracked(scene, keypoints_px, pairs, reach_px)
        if len(scene.placed) < 2:
            return None
        scene = _adjusted(scene, cameras, outlier_sigmas)
    while unconnected := {*scene.placed} - {*connected_photos(scene)}:
        scene = without_photos(scene, unconnected)
        if len(scene.placed) < 2:
            return None
        scene = _adjusted(scene, cameras, outlier_sigmas)
    return scene


def _adjusted(scene: Scene, cameras: Cameras, outlier_sigmas: float) -> Scene:
    """The scene adjusted with fixed lenses, and its covariance."""
    fixed = _fixed_calibrations(scene, cameras)
    adjusted = adjust(scene, fixed, rounds=2, outlier_sigmas=outlier_sigmas)
    return replace(adjusted.scene, camera_covariance=adjusted.covariance)


def _placed_by_board(detections: BoardDetections, scene: Scene, cameras: Cameras) -> Scene | None:
    """The scene placed by the board's corners alone, its shape free, with fixed lenses."""
    seen = placed_photos(detections, scene)
    if len(seen) < 2:
        return None
    photos = seen.values()
    places = _triangulated_corners(photos, scene.views_of(seen), len(detections.corners_mm))
    known = np.asarray(np.isfinite(places).all(axis=1))
    ids = np.concatenate([photo.ids for photo in photos])
    photo_idx = np.repeat([*seen], [len(photo.ids) for photo in photos])
    kept = known[ids]
    corners = replace(
        without_photos(scene, {*scene.placed} - {*seen}),
        points_in_world=places[known],
        observations=Observations(
            photo_idx=photo_idx[kept].astype(np.int32),
            point_idx=(np.cumsum(known) - 1)[ids[kept]].astype(np.int32),
            xy_px=np.concatenate([photo.xy_px for photo in photos])[kept],
        ),
    )
    adjusted = adjust(corners, _fixed_calibrations(scene, cameras), rounds=2)
    return replace(adjusted.scene, camera_covariance=adjusted.covariance)


def _in_frame_of(scene: Scene, alone: Scene) -> Scene:
    """A scene that was placed anew, in the frame and at the scale of the original."""
    photos = sorted({*scene.placed} & {*alone.placed})
    return alone.moved(other_from_one(alone, scene, photos)) if len(photos) > 2 else alone


def _retracked(
    scene: Scene, keypoints_px: tuple[Points2, ...], pairs: list[PairMatches], reach_px: float
) -> Scene:
    """The scene with new points from the matches, and only the photos that these connect."""
    new = with_tracks(scene, keypoints_px, pairs, reach_px)
    return without_photos(new, {*new.placed} - {*connected_photos(new)})


def _fixed_calibrations(scene: Scene, cameras: Cameras) -> tuple[Calibration, ...]:
    """The scene's lenses as calibrations without uncertainty."""
    return tuple(
        replace(one, camera=camera, covariance=np.zeros_like(one.covariance))
        for one, camera in zip(cameras.calibrations, scene.cameras, strict=True)
    )


def moved_mm(movement: Movement | None) -> float:
    """Largest shift between any two photos, in the scene's unit; NaN where it is not known."""
    if movement is None or movement.kind == "unknown":
        return math.nan
    if not movement.moved:
        return 0.0
    if math.isfinite(movement.largest):
        return movement.largest
    # a case of an older version; a drift is counted from its middle, and so half of it either side
    ends = movement.shift[np.isfinite(movement.shift)][[0, -1]]
    return float(ends.sum() if movement.kind == "drift" else np.nanmax(movement.shift))


def in_report_unit(metric: MetricScene, limb: Points3) -> tuple[Scene, str]:
    """The scene with its movements in the unit that reports use, and that unit.

    That is mm; where nothing gives a size, shares of the limb's length.

    Args:
        limb: Points of it, in the world.
    """
    scene = metric.scene
    if metric.scale.unit == "mm":
        return scene, "mm"
    middle = limb - limb.mean(axis=0)
    axis = np.linalg.svd(middle, full_matrices=False)[2][0]
    in_length = 100.0 / float(np.ptp(middle @ axis))

    def shares(movement: Movement | None) -> Movement | None:
        return None if movement is None else movement.scaled(in_length)

    told = replace(scene, movement=shares(scene.movement), bending=shares(scene.bending))
    return told, "% of the limb's length"


def why_unknown(movement: Movement, unit: str) -> Finding | None:
    """Why the movement is unknown; if undecided, the best explanation with its failed rule."""
    if not movement.undecided:
        return movement.reason
    most = movement.undecided[0]
    return note(
        "movement.unknown.undecided",
        kind=most.kind,
        halves=most.bodies == "halves",
        far=most.high,
        unit=unit,
        rule=most.failed[0],
    )


def movement_found(movement: Movement, names: Sequence[str], unit: str) -> Finding:
    """The finding whether the limb kept still."""
    if movement.kind == "unknown":
        return note("movement.unknown", reason=why_unknown(movement, unit))
    if movement.kind == "still":
        if movement.pushed:
            return doubt("board.pushed")
        return note("movement.beside") if movement.beside else note("movement.still")
    far, turn_deg = moved_mm(movement), float(np.nanmax(movement.turn_deg))
    match movement.kind:
        case "unclear":
            return doubt("movement.unclear", far=far, unit=unit)
        case "drift":
            return doubt("movement.drift", far=far, unit=unit)
        case "restless":
            return doubt("movement.restless", far=far, unit=unit, turn_deg=turn_deg)
        case "step":
            moved = first_of(moved_photos(movement, names))
            return doubt("movement.step", far=far, unit=unit, turn_deg=turn_deg, **moved)


LensDoubt = Literal["uncalibrated", "varying"]


def lens_doubt(scene: Scene, cameras: Cameras) -> LensDoubt | None:
    """Why the photos' lenses may differ from the solved ones; None where they are known."""
    if any(one.source != "board" for one in cameras.calibrations):
        return "uncalibrated"
    return None if scene.own is None else "varying"


def bending_found(
    bending: Movement, names: Sequence[str], unit: str, lens: LensDoubt | None = None
) -> Finding:
    """The finding whether the limb kept its shape, or what may have caused the contrary.

    Args:
        lens: Why the lens may be another than was found, which looks the same (`lens_doubt`).
    """
    if bending.kind == "unknown":
        return note("movement.shape.unknown", reason=why_unknown(bending, unit))
    if not bending.moved:
        return note("movement.shape.kept")
    values: dict[str, Value] = {
        "far": moved_mm(bending),
        "unit": unit,
        "turn_deg": float(np.nanmax(bending.turn_deg)),
        "step": bending.kind == "step",
        **first_of(moved_photos(bending, names)),
    }
    if lens is not None:
        return doubt("movement.shape.bent_or_lens", lens=lens, **values)
    return doubt("movement.shape.bent", **values)


def moved_photos(movement: Movement, names: Sequence[str]) -> tuple[str, ...]:
    """Photos that show the limb elsewhere than the largest group does."""
    return tuple(name for name, far in zip(names, movement.shift, strict=True) if far > 0.0)


def movement_remark(scene: Scene, photo_idx: int, unit: str) -> tuple[Finding, ...]:
    """The finding that a photo shows the limb elsewhere; none where it does not."""
    movement = scene.movement
    if movement is None or not movement.shift[photo_idx] > 0.0:
        return ()
    far, step = float(movement.shift[photo_idx]), movement.kind == "step"
    return (doubt("movement.photo", far=far, unit=unit, step=step),)
