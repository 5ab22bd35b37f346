"""Stragglers: photos that the mapper left out, placed by verified pairs and a few points.

In      a scene with points from all matches, keypoints, verified pairs, smaller scenes that could
        not be joined to it; how a scene is rebuilt.
Out     the scene with the photos that could be added to it, one by one, the surest first.
Method  The mapper resects a photo from points that three photos show, and asks for twenty. Where
        photos stand 30 degrees apart a pair still shares a hundred points, of which a third photo
        shows ten. The pair gives the photo's rotation and the direction of the baseline; each of
        the ten gives the baseline's length, and one would do.
        So a photo's pose is tried by each of its general pairs, at the length of baseline with the
        most inliers, and by resection. The pose with most inliers is added to the scene, which is
        rebuilt and adjusted with it. The photo stays if wrong matches would give so many inliers in
        one of 10^4 photos, if the sigma of its rotation is below a quarter of a degree, if its
        pairs do not contradict it, and if no two of them agree on another rotation. Matches of a
        verified pair lie near their epipolar lines even if they are wrong: chance has to meet a
        place on the line.
        Where hardly a third photo shows any point, two pairs do: both give the photo the same
        rotation, and the baselines from its two partners intersect there: four numbers agree. Of
        347 couples with a wrong pair 4 had rotations within 15 degrees of each other, of 228 right
        ones all within 7. The photo stays if most matches of both are inliers of the adjusted
        scene.
        Photos that make a smaller scene of their own are added together where pairs with two of
        them exist: these give that scene the same rotation, and the baselines its scale and place.
Fails   never: a photo that cannot be added stays without a pose.
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
from limbgram.core.geometry.frames import SIMILARITY_SIZE, Rigid, Similarity, angle_between_deg
from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.mapping.bundle_adjustment import OUTLIER_SIGMAS, rotation_sigma_deg
from limbgram.reconstruction.mapping.resection import LARGEST_MISS_PX, resect
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.mapping.tracks import breadth_px, epipolar_px, p_value_of_inliers
from limbgram.reconstruction.mapping.verdicts import (
    CONTRADICTION_DEG,
    contradicted,
    disputed,
    matched_points,
    points_shown,
)
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair

_SIGNIFICANCE_LEVEL = 1e-4
"""Of the test of one photo."""
_POSE_POINTS = 3
"""Points that a pose fits exactly."""
_MAX_ROTATION_SIGMA_DEG = 0.25
"""Largest sigma of the rotation of a photo that stays. Of 60 photos with three quarters of their
matches left out it was 0.02 to 0.22; where wrong pairs placed them, 0.42 and more."""
_MIN_INLIER_SHARE = 0.5
"""Of the matches of a pair. Right pairs have 0.64 to 1.0."""
_MIN_RAYS = 3
"""Photos that show a point which determines the length of a baseline."""
_MOST_LENGTHS = 100
"""Lengths of one baseline that are tried."""
_REBUILDS = 2
"""How often a scene is rebuilt: the first poses bring more matches within the threshold."""


def with_stragglers(
    scene: Scene,
    keypoints_px: Sequence[Points2],
    pairs: Pairs,
    groups: Sequence[Scene],
    rebuilt: Callable[[Scene], Scene],
) -> Scene:
    """The scene with those of its left-out photos that a few points, or two pairs, place.

    Args:
        pairs: Of these photos, verified with the lenses of the scene.
        groups: Smaller scenes of some of them.
        rebuilt: A scene with its points triangulated anew from all matches, and adjusted.
    """
    grown: Scene | None = scene
    while grown is not None:
        scene = grown
        left = sorted({*range(len(scene.names))} - {*scene.placed})
        candidates = chain(  # groups last, where no single photo stays
            _resected_poses(left, scene, keypoints_px, pairs),
            _intersected_poses(left, scene, pairs),
            _group_poses(groups, scene, keypoints_px, pairs),
        )
        joined = (_with_candidate(one, scene, keypoints_px, pairs, rebuilt) for one in candidates)
        grown = next((one for one in joined if one is not None), None)
    return scene


def _resected_poses(
    left: Sequence[int],
    scene: Scene,
    keypoints_px: Sequence[Points2],
    pairs: Pairs,
) -> "list[ResectedPose]":
    """Resected poses with significantly many inliers, the surest first."""
    within_px = OUTLIER_SIGMAS * scene.sigma_px
    tried = [_best_resection(photo, scene, keypoints_px, pairs) for photo in left]
    significant = [
        (p_value, one)
        for one in tried
        if one is not None
        and (p_value := one.p_value(one.inliers, within_px)) <= _SIGNIFICANCE_LEVEL
    ]
    return [one for _, one in sorted(significant, key=lambda ranked: ranked[0])]


def _intersected_poses(left: Sequence[int], scene: Scene, pairs: Pairs) -> "list[IntersectedPoses]":
    """Poses where two baselines intersect, those whose rotations agree best first."""
    met = [one for photo in left if (one := _best_intersection(photo, scene, pairs)) is not None]
    return sorted(met, key=lambda one: one.apart_deg)


def _group_poses(
    groups: Sequence[Scene], scene: Scene, keypoints_px: Sequence[Points2], pairs: Pairs
) -> "Iterator[IntersectedPoses]":
    """Poses of whole groups, those with most pairs first."""
    tried = (_group_by_bridges(group, scene, keypoints_px, pairs) for group in groups)
    met = [one for one in tried if one is not None]
    yield from sorted(met, key=lambda one: -len(one.pairs))


@dataclass(frozen=True)
class ResectedPose:
    """A pose of a left-out photo by points of the scene."""

    photo: int
    camera_from_world: Rigid
    keypoints: Int64[np.ndarray, " k"]
    """Those that its pairs match with points of the scene."""
    inliers: int
    """How many of them lie near the projections of these."""
    broad_px: float
    """Breadth of the region of the photo in which they lie (`breadth_px`)."""

    @property
    def poses(self) -> Mapping[int, Rigid]:
        """camera_from_world by photo."""
        return {self.photo: self.camera_from_world}

    def p_value(self, inliers: int, within_px: float) -> float:
        """Probability of so many inliers if all matches were wrong."""
        matches = len(self.keypoints)
        of_one = p_value_of_inliers(inliers, matches, _POSE_POINTS, within_px, self.broad_px)
        return min(comb(matches, _POSE_POINTS) * of_one, 1.0)

    def is_confirmed(self, joined: Scene, keypoints_px: Sequence[Points2]) -> bool:
        """Whether significantly many points that a third photo shows support it in a scene."""
        seen = joined.observations
        rays = np.bincount(seen.point_idx, minlength=len(joined.points_in_world))
        firm = (seen.photo_idx == self.photo) & (rays[seen.point_idx] >= _MIN_RAYS)
        shown = KDTree(keypoints_px[self.photo]).query(seen.xy_px[firm])[1]
        inliers = int(np.isin(self.keypoints, shown).sum())
        return self.p_value(inliers, OUTLIER_SIGMAS * joined.sigma_px) <= _SIGNIFICANCE_LEVEL


@dataclass(frozen=True)
class IntersectedPoses:
    """Poses of a left-out photo, or of a group, by baselines from placed photos that intersect."""

    poses: Mapping[int, Rigid]
    """camera_from_world by photo."""
    pairs: tuple[VerifiedPair, ...]
    apart_deg: float
    """Angle between the rotations that two of them give."""

    def is_confirmed(self, joined: Scene, keypoints_px: Sequence[Points2]) -> bool:
        """Whether most matches of each pair are inliers of a scene."""
        return all(
            _inlier_share(one, joined, keypoints_px) > _MIN_INLIER_SHARE for one in self.pairs
        )


def _with_candidate(
    candidate: ResectedPose | IntersectedPoses,
    scene: Scene,
    keypoints_px: Sequence[Points2],
    pairs: Pairs,
    rebuilt: Callable[[Scene], Scene],
) -> Scene | None:
    """The scene with a candidate's poses, rebuilt; None where they are not confirmed."""
    poses = list(scene.camera_from_world)
    for photo, pose in candidate.poses.items():
        poses[photo] = pose
    joined = replace(scene, camera_from_world=tuple(poses), camera_covariance=None)
    try:
        for _ in range(_REBUILDS):
            joined = rebuilt(joined)
    except PlacementError:
        return None
    if {*joined.placed} != {*scene.placed, *candidate.poses}:
        return None
    if not candidate.is_confirmed(joined, keypoints_px):
        return None
    if any(
        rotation_sigma_deg(joined, photo) > _MAX_ROTATION_SIGMA_DEG for photo in candidate.poses
    ):
        return None
    against = contradicted(joined, pairs) | disputed(joined, pairs)
    if any(against[photo] for photo in candidate.poses):
        return None
    return joined


def _best_resection(
    photo: int, scene: Scene, keypoints_px: Sequence[Points2], pairs: Pairs
) -> ResectedPose | None:
    """The pose with most inliers; None where no pair gives one."""
    own = Pairs(tuple(one for one in pairs.verified if photo in one.matches.photos), 0)
    matched = matched_points(photo, scene, keypoints_px, own.verified)
    keypoints = np.unique(matched[:, 0])
    if len(keypoints) <= _POSE_POINTS:
        return None
    lens = scene.cameras[scene.camera_idx[photo]]
    points, xy_px = scene.points_in_world[matched[:, 1]], keypoints_px[photo][matched[:, 0]]
    broad_px = breadth_px(xy_px)

    def resected(pose: Rigid) -> ResectedPose:
        off_px = np.linalg.norm(lens.project(pose.apply(points)) - xy_px, axis=1)
        inliers = len(np.unique(matched[off_px < LARGEST_MISS_PX, 0]))
        return ResectedPose(photo, pose, keypoints, inliers, broad_px)

    tried = map(resected, _candidate_poses(photo, scene, own, lens, points, xy_px))
    return max(tried, key=lambda one: one.inliers, default=None)


def _candidate_poses(
    photo: int, scene: Scene, own: Pairs, lens: Camera, points: Points3, xy_px: Points2
) -> Iterator[Rigid]:
    """Poses by resection, and by each general pair with a placed photo."""
    by_points = resect(lens, points, xy_px)
    if by_points is not None:
        yield by_points
    for pair in own.verified:
        ends, relative = pair.matches.photos, pair.second_from_first
        other = scene.camera_from_world[ends[1 - ends.index(photo)]]
        if pair.kind == "general" and relative is not None and other is not None:
            step = relative if ends[1] == photo else relative.inverse
            yield from _poses_along_baseline(step, other, lens, points, xy_px)


def _poses_along_baseline(
    relative: Rigid, other: Rigid, lens: Camera, points: Points3, xy_px: Points2
) -> Iterator[Rigid]:
    """Poses at the end of a baseline from another photo, of the length that each point gives."""
    direction = relative.translation / np.linalg.norm(relative.translation)
    rotated = Rigid(relative.rotation, np.zeros(3)) @ other
    rays = np.column_stack([lens.normalize(xy_px), np.ones(len(xy_px))])
    # ray x (point + length * direction) = 0
    across, along = np.cross(rays, rotated.apply(points)), np.cross(rays, direction)
    square: Float64[np.ndarray, " m"] = (along**2).sum(1)
    lengths = -(across * along).sum(1)[square > 0] / square[square > 0]
    lengths = np.sort(lengths[lengths > 0])
    for length in lengths[:: 1 + len(lengths) // _MOST_LENGTHS].tolist():
        yield Rigid(rotated.rotation, rotated.translation + length * direction)


class _Baseline(NamedTuple):
    """What a pair with a placed photo gives of the other one's pose."""

    pair: VerifiedPair
    rotation: Float64[np.ndarray, "3 3"]
    """From the world to the camera frame of the photo."""
    start: Float64[np.ndarray, " 3"]
    """Centre of the placed photo, in the world."""
    direction: Float64[np.ndarray, " 3"]
    """From there to the photo, in the world; of unit length."""


def _best_intersection(photo: int, scene: Scene, pairs: Pairs) -> IntersectedPoses | None:
    """The intersecting baselines whose rotations agree best; None if no two intersect."""
    met = [
        one
        for couple in combinations(_baselines(photo, scene, pairs), 2)
        if (one := _intersection(photo, *couple)) is not None
    ]
    return min(met, key=lambda one: one.apart_deg, default=None)


def _baselines(photo: int, scene: Scene, pairs: Pairs) -> Iterator[_Baseline]:
    """Baselines from placed photos to a left-out one."""
    for pair in pairs.verified:
        ends, relative = pair.matches.photos, pair.second_from_first
        if photo not in ends or pair.kind != "general" or relative is None:
            continue
        other = scene.camera_from_world[ends[1 - ends.index(photo)]]
        if other is not None:
            relative = relative if ends[1] == photo else relative.inverse
            world_from_other = other.inverse
            direction = world_from_other.rotation @ relative.inverse.translation
            rotation = relative.rotation @ other.rotation
            yield _Baseline(
                pair, rotation, world_from_other.translation, direction / np.linalg.norm(direction)
            )


def _intersection(photo: int, one: _Baseline, other: _Baseline) -> IntersectedPoses | None:
    """Pose where two baselines intersect; None where their rotations or directions contradict."""
    apart_deg = angle_between_deg(one.rotation, other.rotation)
    if apart_deg >= CONTRADICTION_DEG:
        return None
    directions = np.column_stack([one.direction, -other.direction])
    lengths = np.linalg.lstsq(directions, other.start - one.start, rcond=None)[0]
    if (lengths <= 0).any():
        return None
    between = 0.5 * Rotation.from_matrix(other.rotation @ one.rotation.T).as_rotvec()
    rotation = Rotation.from_rotvec(between).as_matrix() @ one.rotation
    ends = one.start + lengths[0] * one.direction, other.start + lengths[1] * other.direction
    pose = Rigid(rotation, -rotation @ (0.5 * (ends[0] + ends[1])))
    return IntersectedPoses({photo: pose}, (one.pair, other.pair), apart_deg)


class _Bridge(NamedTuple):
    """A baseline to a photo of a group, and the rotation that it gives the group."""

    photo: int
    baseline: _Baseline
    world_from_group: Float64[np.ndarray, "3 3"]
    """Rotation."""


def _group_by_bridges(
    group: Scene, scene: Scene, keypoints_px: Sequence[Points2], pairs: Pairs
) -> IntersectedPoses | None:
    """Poses of a group by pairs that give it the same rotation.

    None where fewer than two of its photos have such pairs, or where the baselines miss them.
    """
    left = sorted({*group.placed} - {*scene.placed})
    bridges = [
        _Bridge(photo, baseline, baseline.rotation.T @ group.view(photo).camera_from_world.rotation)
        for photo in left
        for baseline in _baselines(photo, scene, pairs)
    ]
    consistent, apart_deg = _most_consistent(bridges)
    start = _similarity_of(consistent, group)
    if start is None:
        return None
    joined_by = tuple(one.baseline.pair for one in consistent)

    def poses(step: Float64[np.ndarray, "7"]) -> dict[int, Rigid]:
        placed = _perturbed(start, step)
        return {k: placed.move_camera(group.view(k).camera_from_world) for k in left}

    def residuals_px(step: Float64[np.ndarray, "7"]) -> Float64[np.ndarray, " m"]:
        moved = list(scene.camera_from_world)
        for photo, pose in poses(step).items():
            moved[photo] = pose
        tried = replace(scene, camera_from_world=tuple(moved), camera_covariance=None)
        return np.concatenate([epipolar_px(tried, keypoints_px, one.matches) for one in joined_by])

    zeros = np.zeros(SIMILARITY_SIZE)
    fitted = least_squares(residuals_px, zeros, loss="soft_l1", x_scale="jac").x
    return IntersectedPoses(poses(fitted), joined_by, apart_deg)


def _most_consistent(bridges: Sequence[_Bridge]) -> tuple[list[_Bridge], float]:
    """The largest set of bridges whose rotations agree with two of its own, and the angle of these.

    The two lead to different photos of the group.
    """
    best, fewest = (list[_Bridge](), 0.0), (0, 0.0)
    for one, other in combinations(bridges, 2):
        apart_deg = angle_between_deg(one.world_from_group, other.world_from_group)
        if one.photo == other.photo or apart_deg >= CONTRADICTION_DEG:
            continue
        alike = [
            k
            for k in bridges
            if max(
                angle_between_deg(k.world_from_group, ref.world_from_group) for ref in (one, other)
            )
            < CONTRADICTION_DEG
        ]
        if (-len(alike), apart_deg) < fewest:
            best, fewest = (alike, apart_deg), (-len(alike), apart_deg)
    return best


def _perturbed(one: Similarity, step: Float64[np.ndarray, "7"]) -> Similarity:
    """A similarity after a step of its parameters."""
    rotation = Rotation.from_rotvec(step[1:4]).as_matrix()
    moved = Similarity(float(np.exp(step[0])), rotation, step[4:])
    return Similarity(
        moved.scale * one.scale, rotation @ one.rotation, moved.apply(one.translation[None])[0]
    )


def _similarity_of(bridges: Sequence[_Bridge], group: Scene) -> Similarity | None:
    """world_from_group by baselines to its photos, linear least squares; None if one misses."""
    if not bridges:
        return None
    weights = [len(one.baseline.pair.matches) for one in bridges]
    rotation = (
        Rotation.from_matrix([one.world_from_group for one in bridges]).mean(weights).as_matrix()
    )
    centres = [rotation @ group.view(one.photo).centre_in_world for one in bridges]
    # direction x (scale * centre + translation - start) = 0
    across = [np.cross(np.eye(3), one.baseline.direction).T for one in bridges]
    design = [
        -off @ np.column_stack([centre, np.eye(3)])
        for off, centre in zip(across, centres, strict=True)
    ]
    right = [-off @ one.baseline.start for off, one in zip(across, bridges, strict=True)]
    found = np.linalg.lstsq(np.concatenate(design), np.concatenate(right), rcond=None)[0]
    scale, translation = float(found[0]), found[1:]
    lengths = [
        (scale * centre + translation - one.baseline.start) @ one.baseline.direction
        for centre, one in zip(centres, bridges, strict=True)
    ]
    return Similarity(scale, rotation, translation) if min(scale, *lengths) > 0.0 else None


def _inlier_share(pair: VerifiedPair, scene: Scene, keypoints_px: Sequence[Points2]) -> float:
    """Share of a pair's matches whose two keypoints show the same point of the scene."""
    shown = [
        points_shown(photo, scene, keypoints_px)[pair.matches.keypoint_idx[:, side]]
        for side, photo in enumerate(pair.matches.photos)
    ]
    return float(((shown[0] == shown[1]) & (shown[0] >= 0)).mean())
