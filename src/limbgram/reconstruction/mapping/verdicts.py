"""Verdicts: consistent keypoint positions before placement, a verdict on each pose after it.

Refinement: window matching measured the second keypoint of each pair relative to the first. A
keypoint in many pairs has as many measured positions; those that fit all of them best, in least
squares, are several times better than the detector's own. The unknown shifts z are complex numbers;
a pair says z_second - a z_first = m, where m is the shift that window matching measured and a the
rotation and scale between the two keypoints; the detector says z = 0, with less weight. Two rounds,
the second with Cauchy weights.

Verdicts: that all photos are placed proves nothing, because a scene can be folded over and still
have small residuals. So the relative rotation of every placed photo is compared with those of its
pairs, each estimated by itself with the cheirality test. Pairs of cameras without a calibration are
verified again with the lenses of the scene first: at a focal length 1.6 times the true one the
rotations of 79 pairs were 19 degrees off in the median. A scene that many pairs of placed photos
contradict is refused for the question whether limb or board moved. A photo that was not placed gets
the reason, as far as it was measured, and what to do about it.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Complex128, Float64, Int64
from scipy.sparse import coo_array, diags_array
from scipy.sparse.linalg import splu
from scipy.spatial import KDTree
from scipy.special import bdtrc

from limbgram.core.errors import PlacementError
from limbgram.core.geometry.arrays import Points2
from limbgram.core.geometry.frames import angle_between_deg
from limbgram.core.run import in_parallel
from limbgram.findings import Finding, fault
from limbgram.reconstruction.calibration.cameras import Cameras
from limbgram.reconstruction.features.detection import Features
from limbgram.reconstruction.mapping.resection import FEWEST_POINTS, LARGEST_MISS_PX, resect
from limbgram.reconstruction.mapping.scene import PhotoVerdict, Scene
from limbgram.reconstruction.matching.matching import FEW_KEYPOINTS, PairMatches
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.photos.quality import remarks_by_photo
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair
from limbgram.reconstruction.twoview.verification import verify_pair

_DETECTOR_WEIGHT = 0.1
"""(sigma of window matching / sigma of the detector)^2.

A flat minimum: centre RMS after `place` in mm for 1, 0.3, 0.1, 0.03, 0.01 is 0.047, 0.031,
0.031, 0.023, 0.024 on limb_ring15 and 0.047, 0.031, 0.026, 0.029, 0.029 on foot_ring24; without
refinement 0.104 and 0.089.
"""
_CAUCHY_PX = 0.3


def refined_keypoints(features: Features, pairs: Pairs) -> tuple[Points2, ...]:
    """Keypoints of every photo, refined in least squares by the matches of verified pairs."""
    return refined_keypoints_by(features, [pair.matches for pair in pairs.verified])


def refined_keypoints_by(features: Features, matches: Sequence[PairMatches]) -> tuple[Points2, ...]:
    """Keypoints refined by matches that need not be verified: outliers have little weight."""
    sizes = [len(keypoints) for keypoints in features.keypoints]
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    places = [keypoints.xy_px.astype(float) for keypoints in features.keypoints]
    if not matches:
        return tuple(places)
    whole = np.concatenate(places)
    similarity = np.concatenate(
        [
            keypoints.scale_px * np.exp(1j * np.radians(keypoints.angle_deg.astype(float)))
            for keypoints in features.keypoints
        ]
    )
    ends = np.concatenate(
        [pair.keypoint_idx + offsets[[pair.first, pair.second]] for pair in matches]
    ).astype(np.int64)
    found = np.concatenate([pair.xy_second_px for pair in matches])
    moves = (found - whole[ends[:, 1]]) @ np.array([1.0, 1.0j])
    shifts = _solve_shifts(ends, similarity[ends[:, 1]] / similarity[ends[:, 0]], moves, len(whole))
    whole += shifts.view(float).reshape(-1, 2)
    return tuple(np.split(whole, offsets[1:-1]))


def _solve_shifts(
    ends: Int64[np.ndarray, "m 2"],
    similarities: Complex128[np.ndarray, " m"],
    moves: Complex128[np.ndarray, " m"],
    count: int,
) -> Complex128[np.ndarray, " n"]:
    """Shifts that fit all measured ones, in robust least squares."""
    rows = np.arange(len(ends))
    design = coo_array(
        (
            np.concatenate([np.ones(len(ends)), -similarities]),
            (np.concatenate([rows, rows]), np.concatenate([ends[:, 1], ends[:, 0]])),
        ),
        shape=(len(ends), count),
    ).tocsr()
    weights: Float64[np.ndarray, " m"] = 1.0 / (1.0 + np.abs(moves) ** 2 / _CAUCHY_PX**2)
    shifts: Complex128[np.ndarray, " n"] = np.zeros(count, complex)
    for _ in range(2):
        adjoint = design.conj().T @ diags_array(weights)
        normal = adjoint @ design + _DETECTOR_WEIGHT * diags_array(np.ones(count))
        shifts = splu(normal.tocsc()).solve(adjoint @ moves)
        weights = 1.0 / (1.0 + np.abs(moves - design @ shifts) ** 2 / _CAUCHY_PX**2)
    return shifts


_USUAL_OUTLIER_SHARE = 0.2
"""Share of a sound photo's matches with points of the scene that are wrong; of 20 five may be."""
_SIGNIFICANCE_LEVEL = 0.01
"""Of the test whether a photo has more wrong matches than a sound one."""
CONTRADICTION_DEG = 15.0
"""Rotations of one photo that differ by more contradict each other."""


_MAX_CONTRADICTING_SHARE = 0.25
"""Share of contradicting matches beyond which a scene is refused. It was at most 0.09 in 44
sound or spoiled ones that placed all photos, 0.06 to 0.17 in sound ones that left some out, and
0.34 to 0.41 in folded rings."""


def solved_lenses(scene: Scene, cameras: Cameras) -> Cameras:
    """The calibrations by boards; for cameras without one, the lenses of the scene."""
    return Cameras(
        tuple(
            given if given.source == "board" else replace(given, camera=lens)
            for given, lens in zip(cameras.calibrations, scene.cameras, strict=True)
        )
    )


def reverified(scene: Scene, pairs: Pairs, cameras: Cameras) -> Pairs:
    """The pairs, those of uncalibrated cameras verified again with the lenses of the scene.

    Pairs without a geometry are left out.
    """
    found = solved_lenses(scene, cameras).calibrations

    def again(pair: VerifiedPair) -> VerifiedPair | None:
        first, second = (found[scene.camera_idx[photo]] for photo in pair.matches.photos)
        if first.source == second.source == "board":
            return pair
        return verify_pair(pair.matches, first, second)

    solved = [pair for pair in in_parallel(again, pairs.verified) if pair is not None]
    return Pairs(tuple(solved), pairs.rejected)


def contradicted(scene: Scene, pairs: Pairs) -> Bool[np.ndarray, " p"]:
    """Photos whose rotation contradicts the pairs that hold most of their matches.

    A planar pair has two poses and keeps one of them: where that agrees it supports the photo,
    where it does not it says nothing. A general pair that sees little but a plane, or of chance
    matches, has a wrong rotation: a pair that disagrees counts if another one agrees with it, or if
    it alone has more matches than all that agree with the photo.
    """
    return np.array(
        [bool(own) and _is_contradicted(own) for own in _pair_rotations(scene, pairs)], bool
    )


def disputed(scene: Scene, pairs: Pairs) -> Bool[np.ndarray, " p"]:
    """Photos for which two pairs agree on another rotation, however many agree with their pose.

    Pairs of chance matches have random rotations. Where two agree the photo shows two things that
    moved against each other, as a cast that was turned over and its room, and may hang on either.
    """
    found: list[bool] = []
    for own in _pair_rotations(scene, pairs):
        against = np.array([one.from_placed for one in own if not one.planar]).reshape(-1, 3, 3)
        against = against[angles_deg(against) >= CONTRADICTION_DEG]
        found.append(bool(_confirmed(against).any()))
    return np.array(found, bool)


def _pair_rotations(scene: Scene, pairs: Pairs) -> "list[list[_PairRotation]]":
    """By photo, the rotations that pairs with placed photos give it."""
    turns: list[list[_PairRotation]] = [[] for _ in scene.names]
    for pair in pairs.verified:
        ends = pair.matches.photos
        placed = [scene.camera_from_world[k] for k in ends]
        turn = pair.second_from_first
        if pair.kind == "rotation" or turn is None or placed[0] is None or placed[1] is None:
            continue
        one, other = placed[0].rotation, placed[1].rotation
        told = pair.kind == "planar", len(pair.matches)
        turns[ends[0]].append(_PairRotation(turn.rotation.T @ other @ one.T, *told))
        turns[ends[1]].append(_PairRotation(turn.rotation @ one @ other.T, *told))
    return turns


def refuse_contradicted(scene: Scene, pairs: Pairs, cameras: Cameras) -> None:
    """Refuse a scene that left photos out and that many of its own pairs contradict.

    Repeated texture, or what stands still in the room, joined photos that show nothing in common,
    and the ring is folded. Its limb and board seem to have moved, and did not.

    Raises:
        PlacementError: more than `_MAX_CONTRADICTING_SHARE` of the matches contradict.
    """
    if len(scene.placed) == len(scene.names):
        return
    share = contradicting_share(scene, reverified(scene, pairs, cameras))
    if share > _MAX_CONTRADICTING_SHARE:
        raise PlacementError("placing.torn", share=share, count=len(scene.placed))


def contradicting_share(scene: Scene, pairs: Pairs) -> float:
    """Share of the matches between placed photos whose pairs contradict their rotations.

    Only general pairs count, neither planar ones nor pure rotations.
    """
    contradicting = matched = 0
    for pair in pairs.verified:
        first, second = (scene.camera_from_world[k] for k in pair.matches.photos)
        turn = pair.second_from_first
        if pair.kind != "general" or turn is None or first is None or second is None:
            continue
        off_deg = angle_between_deg(turn.rotation @ first.rotation, second.rotation)
        matched += len(pair.matches)
        contradicting += len(pair.matches) * (off_deg > CONTRADICTION_DEG)
    return contradicting / max(matched, 1)


class _PairRotation(NamedTuple):
    """Rotation of one photo of a pair by the relative pose of the pair."""

    from_placed: Float64[np.ndarray, "3 3"]
    """Rotation from the photo's pose in the scene to that by the pair."""
    planar: bool
    matches: int


def _is_contradicted(turns: Sequence[_PairRotation]) -> bool:
    """Whether the rotations by pairs contradict that of the scene."""
    from_placed = np.array([one.from_placed for one in turns])
    planar = np.array([one.planar for one in turns])
    count = np.array([one.matches for one in turns])
    agrees = angles_deg(from_placed) < CONTRADICTION_DEG
    agreeing = count[agrees].sum()
    against, matches = from_placed[~agrees & ~planar], count[~agrees & ~planar]
    return bool(agreeing < matches[_confirmed(against) | (matches > agreeing)].sum())


def _confirmed(turns: Float64[np.ndarray, "n 3 3"]) -> Bool[np.ndarray, " n"]:
    """Mask of the rotations with which another one agrees."""
    apart_deg = angles_deg(turns[:, None] @ turns.transpose(0, 2, 1)[None])
    return (apart_deg < CONTRADICTION_DEG).sum(axis=1) > 1  # one is itself


def angles_deg(turns: Float64[np.ndarray, "*n 3 3"]) -> Float64[np.ndarray, "*n"]:
    """Angles of rotations."""
    cosines = 0.5 * (np.trace(turns, axis1=-2, axis2=-1) - 1.0)
    return np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))


def photo_points(scene: Scene) -> Float64[np.ndarray, "p 2"]:
    """Per photo: number of scene points seen in it, and RMS reprojection error."""
    seen = scene.observations.photo_idx
    squares = np.nansum(scene.residuals_px() ** 2, axis=1)
    count = np.bincount(seen, minlength=len(scene.names)).astype(float)
    total = np.bincount(seen, weights=squares, minlength=len(scene.names))
    return np.column_stack([count, np.sqrt(total / np.maximum(count, 1.0))])


def judge(
    scene: Scene,
    photos: PhotoSet,
    keypoints_px: Sequence[Points2],
    pairs: Pairs,
    others: Sequence[Scene],
    dropped: dict[int, Finding],
) -> tuple[PhotoVerdict, ...]:
    """A verdict for every photo.

    Args:
        keypoints_px: Keypoints of every photo, as in the scene's observations.
        others: Smaller scenes that could not be joined to this one.
        dropped: Reasons for photos that had a pose and lost it.
    """
    figures = photo_points(scene)
    remarked = remarks_by_photo(photos)
    verdicts: list[PhotoVerdict] = []
    for photo, name in enumerate(scene.names):
        placed = scene.camera_from_world[photo] is not None
        reason = None if placed else dropped.get(photo)
        if not placed and reason is None:
            measured = tuple(remarked.get(name, ()))
            reason = _rejection_reason(photo, scene, keypoints_px, pairs, others, measured)
        verdicts.append(
            PhotoVerdict(
                name=name,
                placed=placed,
                points=int(figures[photo, 0]),
                rms_px=float(figures[photo, 1]) if placed else float("nan"),
                reason=reason,
            )
        )
    return tuple(verdicts)


def _rejection_reason(
    photo: int,
    scene: Scene,
    keypoints_px: Sequence[Points2],
    pairs: Pairs,
    others: Sequence[Scene],
    measured: tuple[Finding, ...],
) -> Finding:
    """Why a photo has no place; a fault of the photo is named only where it was measured."""
    found, faults = len(keypoints_px[photo]), len(measured)
    if found < FEW_KEYPOINTS:
        return fault("placing.photo.plain", points=found, faults=faults, measured=measured)
    for other in others:
        if photo in other.placed:
            names = tuple(other.names[k] for k in other.placed if k != photo)
            return fault("placing.photo.other_group", names=names)
    own = [pair for pair in pairs.verified if photo in pair.matches.photos]
    if not own:
        return fault("placing.photo.alone")
    if all(pair.kind == "rotation" for pair in own):
        return fault("placing.photo.same_spot")
    agreeing, matched = _resection_inliers(photo, scene, keypoints_px, own)
    by_chance = bdtrc(matched - agreeing - 1, matched, _USUAL_OUTLIER_SHARE)
    if not measured and by_chance > _SIGNIFICANCE_LEVEL:
        return fault("placing.photo.few_agree", points=agreeing)
    return fault(
        "placing.photo.disagrees",
        agreeing=agreeing,
        matched=matched,
        faults=faults,
        measured=measured,
    )


class _ResectionInliers(NamedTuple):
    """Matches of a photo with points of the scene: inliers of its best pose, and all."""

    inliers: int
    """An upper bound where no pose was found, which takes six."""
    matched: int


def _resection_inliers(
    photo: int, scene: Scene, keypoints_px: Sequence[Points2], own: Sequence[VerifiedPair]
) -> _ResectionInliers:
    matched = matched_points(photo, scene, keypoints_px, own)
    xy_px, points = keypoints_px[photo][matched[:, 0]], scene.points_in_world[matched[:, 1]]
    lens = scene.cameras[scene.camera_idx[photo]]
    pose = resect(lens, points, xy_px)
    if pose is None:
        return _ResectionInliers(min(len(matched), FEWEST_POINTS - 1), len(matched))
    off_px = np.linalg.norm(lens.project(pose.apply(points)) - xy_px, axis=1)
    return _ResectionInliers(int((off_px < LARGEST_MISS_PX).sum()), len(matched))


def matched_points(
    photo: int, scene: Scene, keypoints_px: Sequence[Points2], own: Sequence[VerifiedPair]
) -> Int64[np.ndarray, "m 2"]:
    """Keypoints of a photo matched with points of the scene, through the photo's pairs.

    Args:
        own: The pairs of the photo.
    """
    found = [np.zeros((0, 2), np.int64)]
    for pair in own:
        ends = pair.matches.photos
        side = ends.index(photo)
        other = ends[1 - side]
        point = points_shown(other, scene, keypoints_px)[pair.matches.keypoint_idx[:, 1 - side]]
        ours = pair.matches.keypoint_idx[:, side]
        found.append(np.column_stack([ours, point])[point >= 0])
    return np.unique(np.concatenate(found), axis=0)


def points_shown(
    photo: int, scene: Scene, keypoints_px: Sequence[Points2]
) -> Int64[np.ndarray, " k"]:
    """By keypoint of a photo, the point of the scene that it observes; -1 where none."""
    seen = scene.observations.some(scene.observations.photo_idx == photo)
    shown = np.full(len(keypoints_px[photo]), -1)
    if len(seen.xy_px):
        shown[KDTree(keypoints_px[photo]).query(seen.xy_px)[1]] = seen.point_idx
    return shown
