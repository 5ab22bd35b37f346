"""Stragglers: photos that the mapper left out, placed by pairs' turns and a few points.

In      a scene with points from all matches, keypoints, verified pairs, smaller scenes that could
        not be joined to it; how a scene is remade.
Out     the scene with the photos that could be joined to it, one by one, the surest first.
Method  The mapper resects a photo from points that three photos show, and asks for twenty. Where
        photos stand 30 degrees apart a pair still shares a hundred points, of which a third photo
        shows ten. The pair tells how its photos are turned and which way the step went; each of
        the ten tells how long the step was, and one would do.
        So a photo's place is tried by each of its general pairs, at the length of step on which
        most points agree, and by resection. The one with most points joins the scene, whose points
        are made anew and adjusted with it. The photo stays if chance would make so many points
        agree in one of 10^4 photos, if its turn is known to a quarter of a degree, if its pairs do
        not contradict it, and if no two of them turn it the same other way. Matches of a verified
        pair lie near their epipolar lines even if they are wrong: chance has to meet a place on
        the line.
        Where hardly a third photo shows any point, two pairs do: both turn a photo alike, and the
        steps from its two partners meet there: four numbers agree. Of 347 couples with a wrong pair
        4 turned a photo within 15 degrees of each other, of 228 right ones all within 7. It stays
        if the adjusted scene holds most matches of both.
        Photos that make a smaller scene of their own join together where two pairs start from two
        of them: both turn that scene alike, and the steps tell its size and its place.
Fails   never: a photo that cannot be joined stays without a place.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations
from math import comb
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int64
from scipy.optimize import least_squares
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from limbgram.core.errors import PlacementError
from limbgram.core.geometry.arrays import Points2, Points3
from limbgram.core.geometry.frames import Rigid, Similarity, angle_between_deg
from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.mapping.resection import LARGEST_MISS_PX, resect
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.mapping.solution import OUTLIER_SIGMAS, turn_sigma_deg
from limbgram.reconstruction.mapping.tracks import breadth_px, epipolar_px, near_by_chance
from limbgram.reconstruction.mapping.verdicts import (
    CONTRADICTION_DEG,
    contradicted,
    disputed,
    matched_points,
    points_shown,
)
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair

_BY_CHANCE = 1e-4
"""Level of the test of one photo."""
_FITTED = 3
"""Points that a pose can be made to meet."""
_MOST_TURN_DEG = 0.25
"""Standard deviation of the turn of a photo that stays. Of 60 photos of which three quarters of the
matches were taken, it was 0.02 to 0.22; where wrong pairs placed them, 0.42 and more."""
_MOST = 0.5
"""Of the matches of a pair. Right ones kept 0.64 to 1.0 of theirs."""
_TELLING_RAYS = 3
"""Photos that show a point which tells how long a step was."""
_MOST_LENGTHS = 100
"""Lengths of one step that are tried."""
_SIMILARITY = 7
"""Numbers of a size, a turn and a place."""
_REMADE = 2
"""Times that a scene is remade: the first places bring more matches within reach."""


def with_stragglers(
    scene: Scene,
    places_px: Sequence[Points2],
    pairs: Pairs,
    groups: Sequence[Scene],
    remade: Callable[[Scene], Scene],
) -> Scene:
    """The scene with those of its photos without a place that a few points, or two pairs, hold.

    Args:
        pairs: Of these photos, by the lenses of the scene.
        groups: Smaller scenes of some of them.
        remade: A scene with its points made anew from all matches, and adjusted.
    """
    grown: Scene | None = scene
    while grown is not None:
        scene = grown
        left = sorted({*range(len(scene.names))} - {*scene.placed})
        places = chain(  # groups are looked at last, where no single photo stays
            _by_points(left, scene, places_px, pairs),
            _by_steps(left, scene, pairs),
            _by_bridges(groups, scene, places_px, pairs),
        )
        joined = (_joined(one, scene, places_px, pairs, remade) for one in places)
        grown = next((one for one in joined if one is not None), None)
    return scene


def _by_points(
    left: Sequence[int],
    scene: Scene,
    places_px: Sequence[Points2],
    pairs: Pairs,
) -> "list[Place]":
    """Places that points hold beyond chance, the surest first."""
    within_px = OUTLIER_SIGMAS * scene.sigma_px
    tried = [_likeliest(photo, scene, places_px, pairs) for photo in left]
    hopeful = [
        (chance, one)
        for one in tried
        if one is not None and (chance := one.by_chance(one.agreeing, within_px)) <= _BY_CHANCE
    ]
    return [one for _, one in sorted(hopeful, key=lambda hope: hope[0])]


def _by_steps(left: Sequence[int], scene: Scene, pairs: Pairs) -> "list[Meeting]":
    """Places where the steps of two pairs meet, those that turn the photo most alike first."""
    met = [one for photo in left if (one := _meeting(photo, scene, pairs)) is not None]
    return sorted(met, key=lambda one: one.apart_deg)


def _by_bridges(
    groups: Sequence[Scene], scene: Scene, places_px: Sequence[Points2], pairs: Pairs
) -> "Iterator[Meeting]":
    """Places of whole groups, those that most pairs tell first."""
    tried = (_bridged(group, scene, places_px, pairs) for group in groups)
    met = [one for one in tried if one is not None]
    yield from sorted(met, key=lambda one: -len(one.pairs))


@dataclass(frozen=True)
class Place:
    """Where a photo may have been taken."""

    photo: int
    camera_from_world: Rigid
    keypoints: Int64[np.ndarray, " k"]
    """Those that its pairs join with points of the scene,"""
    agreeing: int
    """and how many of them lie near these."""
    broad_px: float
    """Shorter side of the strip of the photo in which they lie."""

    @property
    def poses(self) -> Mapping[int, Rigid]:
        """camera_from_world by photo."""
        return {self.photo: self.camera_from_world}

    def by_chance(self, agreeing: int, within_px: float) -> float:
        """How many of such photos would have so many agree, were all matches wrong."""
        tried = len(self.keypoints)
        of_those = near_by_chance(agreeing, tried, _FITTED, within_px, self.broad_px)
        return min(comb(tried, _FITTED) * of_those, 1.0)

    def held(self, joined: Scene, places_px: Sequence[Points2]) -> bool:
        """Whether beyond chance points that a third photo shows hold the photo in a scene."""
        seen = joined.observations
        rays = np.bincount(seen.point_idx, minlength=len(joined.points_in_world))
        telling = (seen.photo_idx == self.photo) & (rays[seen.point_idx] >= _TELLING_RAYS)
        shown = KDTree(places_px[self.photo]).query(seen.xy_px[telling])[1]
        holding = int(np.isin(self.keypoints, shown).sum())
        return self.by_chance(holding, OUTLIER_SIGMAS * joined.sigma_px) <= _BY_CHANCE


@dataclass(frozen=True)
class Meeting:
    """Where the steps of pairs from placed photos meet: in one photo, or in a group of photos."""

    poses: Mapping[int, Rigid]
    """camera_from_world by photo."""
    pairs: tuple[VerifiedPair, ...]
    apart_deg: float
    """How far two of them turn photo or group otherwise."""

    def held(self, joined: Scene, places_px: Sequence[Points2]) -> bool:
        """Whether a scene holds most matches of each."""
        return all(_share_held(one, joined, places_px) > _MOST for one in self.pairs)


def _joined(
    place: Place | Meeting,
    scene: Scene,
    places_px: Sequence[Points2],
    pairs: Pairs,
    remade: Callable[[Scene], Scene],
) -> Scene | None:
    """The scene with photos at their places; None where these do not stay there."""
    poses = list(scene.camera_from_world)
    for photo, pose in place.poses.items():
        poses[photo] = pose
    joined = replace(scene, camera_from_world=tuple(poses), camera_covariance=None)
    try:
        for _ in range(_REMADE):
            joined = remade(joined)
    except PlacementError:
        return None
    if {*joined.placed} != {*scene.placed, *place.poses}:
        return None
    if not place.held(joined, places_px):
        return None
    if any(turn_sigma_deg(joined, photo) > _MOST_TURN_DEG for photo in place.poses):
        return None
    against = contradicted(joined, pairs) | disputed(joined, pairs)
    if any(against[photo] for photo in place.poses):
        return None
    return joined


def _likeliest(
    photo: int, scene: Scene, places_px: Sequence[Points2], pairs: Pairs
) -> Place | None:
    """The place at which most points agree; None where no pair tells one."""
    own = Pairs(tuple(one for one in pairs.verified if photo in one.matches.photos), 0)
    matched = matched_points(photo, scene, places_px, own.verified)
    keypoints = np.unique(matched[:, 0])
    if len(keypoints) <= _FITTED:
        return None
    lens = scene.cameras[scene.camera_idx[photo]]
    points, xy_px = scene.points_in_world[matched[:, 1]], places_px[photo][matched[:, 0]]
    broad_px = breadth_px(xy_px)

    def place(pose: Rigid) -> Place:
        off_px = np.linalg.norm(lens.project(pose.apply(points)) - xy_px, axis=1)
        agreeing = len(np.unique(matched[off_px < LARGEST_MISS_PX, 0]))
        return Place(photo, pose, keypoints, agreeing, broad_px)

    tried = map(place, _poses(photo, scene, own, lens, points, xy_px))
    return max(tried, key=lambda one: one.agreeing, default=None)


def _poses(
    photo: int, scene: Scene, own: Pairs, lens: Camera, points: Points3, xy_px: Points2
) -> Iterator[Rigid]:
    """By resection, and by each general pair with a placed photo."""
    by_points = resect(lens, points, xy_px)
    if by_points is not None:
        yield by_points
    for pair in own.verified:
        ends, turn = pair.matches.photos, pair.second_from_first
        other = scene.camera_from_world[ends[1 - ends.index(photo)]]
        if pair.kind == "general" and turn is not None and other is not None:
            step = turn if ends[1] == photo else turn.inverse
            yield from _by_step(step, other, lens, points, xy_px)


def _by_step(
    step: Rigid, other: Rigid, lens: Camera, points: Points3, xy_px: Points2
) -> Iterator[Rigid]:
    """Poses a step of known turn and direction from another, as long as each point tells it."""
    way = step.translation / np.linalg.norm(step.translation)
    turned = Rigid(step.rotation, np.zeros(3)) @ other
    rays = np.column_stack([lens.normalize(xy_px), np.ones(len(xy_px))])
    # ray x (point + length * way) = 0
    across, along = np.cross(rays, turned.apply(points)), np.cross(rays, way)
    square: Float64[np.ndarray, " m"] = (along**2).sum(1)
    lengths = -(across * along).sum(1)[square > 0] / square[square > 0]
    lengths = np.sort(lengths[lengths > 0])
    for length in lengths[:: 1 + len(lengths) // _MOST_LENGTHS].tolist():
        yield Rigid(turned.rotation, turned.translation + length * way)


class _Step(NamedTuple):
    """What a pair with a placed photo tells of the other one."""

    pair: VerifiedPair
    turn: Float64[np.ndarray, "3 3"]
    """From the world to the photo."""
    start: Float64[np.ndarray, " 3"]
    """Where the placed photo was taken,"""
    way: Float64[np.ndarray, " 3"]
    """and which way from there the photo was."""


def _meeting(photo: int, scene: Scene, pairs: Pairs) -> Meeting | None:
    """Where those two steps meet that turn a photo most alike; None where no two do."""
    met = [
        one
        for couple in combinations(_steps(photo, scene, pairs), 2)
        if (one := _met(photo, *couple)) is not None
    ]
    return min(met, key=lambda one: one.apart_deg, default=None)


def _steps(photo: int, scene: Scene, pairs: Pairs) -> Iterator[_Step]:
    for pair in pairs.verified:
        ends, step = pair.matches.photos, pair.second_from_first
        if photo not in ends or pair.kind != "general" or step is None:
            continue
        other = scene.camera_from_world[ends[1 - ends.index(photo)]]
        if other is not None:
            step = step if ends[1] == photo else step.inverse
            to_world = other.inverse
            way = to_world.rotation @ step.inverse.translation
            turn = step.rotation @ other.rotation
            yield _Step(pair, turn, to_world.translation, way / np.linalg.norm(way))


def _met(photo: int, one: _Step, other: _Step) -> Meeting | None:
    """None where they turn the photo otherwise, or do not meet ahead."""
    apart_deg = angle_between_deg(one.turn, other.turn)
    if apart_deg >= CONTRADICTION_DEG:
        return None
    ways = np.column_stack([one.way, -other.way])
    lengths = np.linalg.lstsq(ways, other.start - one.start, rcond=None)[0]
    if (lengths <= 0).any():
        return None
    between = 0.5 * Rotation.from_matrix(other.turn @ one.turn.T).as_rotvec()
    turn = Rotation.from_rotvec(between).as_matrix() @ one.turn
    ends = one.start + lengths[0] * one.way, other.start + lengths[1] * other.way
    pose = Rigid(turn, -turn @ (0.5 * (ends[0] + ends[1])))
    return Meeting({photo: pose}, (one.pair, other.pair), apart_deg)


class _Crossing(NamedTuple):
    """What a pair tells of a group that one of its photos is in."""

    photo: int
    step: _Step
    turn: Float64[np.ndarray, "3 3"]
    """From the group to the world."""


def _bridged(
    group: Scene, scene: Scene, places_px: Sequence[Points2], pairs: Pairs
) -> Meeting | None:
    """Where pairs put a group that turn it alike; None where two photos of it are not bridged so,
    or where the steps do not lead there."""
    left = sorted({*group.placed} - {*scene.placed})
    crossings = [
        _Crossing(photo, step, step.turn.T @ group.view(photo).camera_from_world.rotation)
        for photo in left
        for step in _steps(photo, scene, pairs)
    ]
    together, apart_deg = _most_alike(crossings)
    laid = _laid(together, group)
    if laid is None:
        return None
    bridges = tuple(one.step.pair for one in together)

    def poses(step: Float64[np.ndarray, "7"]) -> dict[int, Rigid]:
        placed = _stepped(laid, step)
        return {k: placed.move_camera(group.view(k).camera_from_world) for k in left}

    def misses_px(step: Float64[np.ndarray, "7"]) -> Float64[np.ndarray, " m"]:
        moved = list(scene.camera_from_world)
        for photo, pose in poses(step).items():
            moved[photo] = pose
        tried = replace(scene, camera_from_world=tuple(moved), camera_covariance=None)
        return np.concatenate([epipolar_px(tried, places_px, one.matches) for one in bridges])

    start = np.zeros(_SIMILARITY)
    fitted = least_squares(misses_px, start, loss="soft_l1", x_scale="jac").x
    return Meeting(poses(fitted), bridges, apart_deg)


def _most_alike(crossings: Sequence[_Crossing]) -> tuple[list[_Crossing], float]:
    """Those that turn a group as two from different photos of it do, as many as can be; and how far
    these two turn it otherwise."""
    best, fewest = (list[_Crossing](), 0.0), (0, 0.0)
    for one, other in combinations(crossings, 2):
        apart_deg = angle_between_deg(one.turn, other.turn)
        if one.photo == other.photo or apart_deg >= CONTRADICTION_DEG:
            continue
        alike = [
            k
            for k in crossings
            if max(angle_between_deg(k.turn, ref.turn) for ref in (one, other)) < CONTRADICTION_DEG
        ]
        if (-len(alike), apart_deg) < fewest:
            best, fewest = (alike, apart_deg), (-len(alike), apart_deg)
    return best


def _stepped(one: Similarity, step: Float64[np.ndarray, "7"]) -> Similarity:
    """Another size, turn and place."""
    turn = Rotation.from_rotvec(step[1:4]).as_matrix()
    moved = Similarity(float(np.exp(step[0])), turn, step[4:])
    return Similarity(
        moved.scale * one.scale, turn @ one.rotation, moved.apply(one.translation[None])[0]
    )


def _laid(crossings: Sequence[_Crossing], group: Scene) -> Similarity | None:
    """The group as steps to its photos lay it; None where they do not lead to it."""
    if not crossings:
        return None
    weights = [len(one.step.pair.matches) for one in crossings]
    turn = Rotation.from_matrix([one.turn for one in crossings]).mean(weights).as_matrix()
    arms = [turn @ group.view(one.photo).centre_in_world for one in crossings]
    # way x (size * arm + shift - start) = 0
    across = [np.cross(np.eye(3), one.step.way).T for one in crossings]
    design = [
        -off @ np.column_stack([arm, np.eye(3)]) for off, arm in zip(across, arms, strict=True)
    ]
    right = [-off @ one.step.start for off, one in zip(across, crossings, strict=True)]
    found = np.linalg.lstsq(np.concatenate(design), np.concatenate(right), rcond=None)[0]
    size, shift = float(found[0]), found[1:]
    lengths = [
        (size * arm + shift - one.step.start) @ one.step.way
        for arm, one in zip(arms, crossings, strict=True)
    ]
    return Similarity(size, turn, shift) if min(size, *lengths) > 0.0 else None


def _share_held(pair: VerifiedPair, scene: Scene, places_px: Sequence[Points2]) -> float:
    """Of a pair's matches, those whose two keypoints show one point of the scene."""
    shown = [
        points_shown(photo, scene, places_px)[pair.matches.keypoint_idx[:, side]]
        for side, photo in enumerate(pair.matches.photos)
    ]
    return float(((shown[0] == shown[1]) & (shown[0] >= 0)).mean())
