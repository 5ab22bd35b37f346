"""Poses and verified pairs: still backgrounds, planes, turns on the spot, wrong matches."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid, angle_between_deg
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.matching.matching import Matches, PairMatches
from limbgram.reconstruction.matching.static_background import ImageMotion, StaticBackground
from limbgram.reconstruction.twoview.essential import (
    essential_from_fundamental,
    estimate_essential,
    estimate_homography,
    in_front,
    pose_from_essential,
    poses_from_homography,
    to_normalized,
)
from limbgram.reconstruction.twoview.verification import verify_pair


def angle_deg(first: np.ndarray, second: np.ndarray) -> float:
    return float(np.degrees(np.arccos(np.clip(first @ second, -1.0, 1.0))))


def noisy(matches: PairMatches, sigma_px: float = 0.3) -> PairMatches:
    rng = np.random.default_rng(9)
    shape = matches.xy_first_px.shape
    return replace(
        matches,
        xy_first_px=matches.xy_first_px + rng.normal(scale=sigma_px, size=shape),
        xy_second_px=matches.xy_second_px + rng.normal(scale=sigma_px, size=shape),
    )


def joined(first: PairMatches, first_px: np.ndarray, second_px: np.ndarray) -> PairMatches:
    """More matches behind those given; their keypoint numbers go on counting."""
    count = len(first_px)
    number = len(first) + np.arange(count, dtype=np.int32)
    return replace(
        first,
        keypoint_idx=np.vstack([first.keypoint_idx, np.column_stack([number, number])]),
        xy_first_px=np.vstack([first.xy_first_px, first_px]),
        xy_second_px=np.vstack([first.xy_second_px, second_px]),
        correlation=np.concatenate([first.correlation, np.full(count, np.nan, np.float32)]),
    )


def test_pose_from_f_and_k_passes_the_cheirality_test(
    limb_pair: Any, calibration: Calibration
) -> None:
    matrix = calibration.camera.matrix
    essential = essential_from_fundamental(limb_pair.fundamental, matrix, matrix)
    ideal = to_normalized(matrix, limb_pair.first), to_normalized(matrix, limb_pair.second)
    found = pose_from_essential(essential, *ideal)
    np.testing.assert_allclose(found.second_from_first.rotation, limb_pair.pose.rotation, atol=1e-6)
    np.testing.assert_allclose(
        found.second_from_first.translation, limb_pair.pose.translation, atol=1e-5
    )
    assert found.in_front.all()
    behind = Rigid(limb_pair.pose.rotation, -limb_pair.pose.translation)
    assert not in_front(behind, *ideal).any()


def test_five_matches_suffice(limb_pair: Any, calibration: Calibration) -> None:
    first, second = limb_pair.noisy(0.3)
    matrix = calibration.camera.matrix
    found = estimate_essential(first, second, matrix, matrix)
    assert found.second_from_first is not None
    assert angle_between_deg(found.second_from_first.rotation, limb_pair.pose.rotation) < 0.5
    assert found.inliers.mean() > 0.98


def test_a_limb_pair_is_general_and_its_wrong_matches_go(
    limb_pair: Any, calibration: Calibration
) -> None:
    right = noisy(limb_pair.photographed)
    rng = np.random.default_rng(3)
    places = rng.uniform([800, 100], [1600, 1500], (2, 200, 2))
    found = verify_pair(joined(right, places[0], places[1]), calibration, calibration)
    assert found is not None
    assert found.kind == "general"
    wrong = found.matches.keypoint_idx[:, 0] >= len(right)
    assert wrong.sum() <= 8
    assert (~wrong).sum() > 0.97 * len(right)
    assert found.second_from_first is not None
    assert angle_between_deg(found.second_from_first.rotation, limb_pair.pose.rotation) < 0.5
    assert angle_deg(found.second_from_first.translation, limb_pair.pose.translation) < 0.5
    assert 23.0 < found.median_angle_deg < 27.0
    assert found.rms_residual_px == pytest.approx(0.15, rel=0.1)  # half of sigma


@pytest.mark.parametrize(
    ("right", "wrong", "verified"),
    [(20, 0, True), (19, 0, False), (40, 80, True), (28, 92, False)],
    ids=["twenty", "nineteen", "a third", "below three tenths"],
)
def test_twenty_matches_and_three_tenths_of_all_must_agree(
    limb_pair: Any, calibration: Calibration, right: int, wrong: int, verified: bool
) -> None:
    """Of 120 that is 36; a few wrong ones may lie on their epipolar line by chance."""
    some = np.arange(len(limb_pair.photographed)) < right
    places = np.random.default_rng(8).uniform(0, 1000, (2, wrong, 2))
    matches = joined(limb_pair.photographed.some(some), places[0], places[1])
    found = verify_pair(matches, calibration, calibration)
    assert (found is not None) == verified


def test_a_plane_is_told_and_its_pose_is_one_of_two(
    flat_pair: Any, calibration: Calibration
) -> None:
    found = verify_pair(noisy(flat_pair.photographed, 0.05), calibration, calibration)
    assert found is not None
    assert found.kind == "planar"
    assert len(found.matches) > 0.97 * len(flat_pair.photographed)
    matrix = calibration.camera.matrix
    plane = estimate_homography(flat_pair.first, flat_pair.second, threshold_px=0.5)
    assert plane.share == 1.0
    poses = poses_from_homography(plane.matrix, matrix, matrix)
    errors = [angle_between_deg(pose.rotation, flat_pair.pose.rotation) for pose in poses]
    assert min(errors) < 0.1
    assert found.second_from_first is not None
    nearest = [angle_between_deg(found.second_from_first.rotation, pose.rotation) for pose in poses]
    assert min(nearest) < 3.0


def test_f_of_an_exif_camera_gives_the_same_pose(limb_pair: Any, calibration: Calibration) -> None:
    guessed = replace(calibration, source="exif")
    found = verify_pair(noisy(limb_pair.photographed), guessed, guessed)
    assert found is not None
    assert found.second_from_first is not None
    assert angle_between_deg(found.second_from_first.rotation, limb_pair.pose.rotation) < 2.0


def test_a_turn_on_the_spot_has_no_pose(limb_pair: Any, calibration: Calibration) -> None:
    matches, lens = limb_pair.photographed, calibration.camera
    turn = Rigid.from_rotation_vector(np.array([0.01, 0.03, 0.02]), np.zeros(3))
    turned = replace(matches, xy_second_px=lens.project(turn.apply(lens.rays(matches.xy_first_px))))
    found = verify_pair(noisy(turned), calibration, calibration)
    assert found is not None
    assert found.kind == "rotation"
    assert found.second_from_first is None
    assert found.median_angle_deg == 0.0


@pytest.mark.parametrize("move", [ImageMotion(), ImageMotion(0.005, np.array([3.0, -2.0]))])
def test_the_still_room_behind_a_turntable_does_not_win(
    limb_pair: Any, calibration: Calibration, move: ImageMotion
) -> None:
    """Also where a stabiliser shifts the second photo, and a focus found anew lets it grow."""
    limb = noisy(limb_pair.photographed)
    rng = np.random.default_rng(5)
    room = rng.uniform([0, 0], [2399, 1599], (4 * len(limb), 2))
    shaken = room + rng.normal(scale=0.2, size=room.shape)
    both = joined(limb, room, (shaken + move.shift_px) / (1.0 - move.growth))
    every = Matches(
        pairs=(replace(both, first=0, second=1),), pairs_tried=1, descriptor_matches=len(both)
    )
    (moving,) = StaticBackground(moves=(ImageMotion(), move)).moving_matches(every).pairs
    found = verify_pair(moving, calibration, calibration)
    assert found is not None
    assert (found.matches.keypoint_idx[:, 0] < len(limb)).all()
    assert len(found.matches) > 0.97 * len(limb)
    # the same room wins when it is not recognised: the test would notice
    blind = verify_pair(both, calibration, calibration)
    assert blind is None or (blind.matches.keypoint_idx[:, 0] >= len(limb)).mean() > 0.5


def test_chance_matches_are_no_pair(calibration: Calibration, limb_pair: Any) -> None:
    rng = np.random.default_rng(7)
    none = replace(
        limb_pair.photographed,
        xy_second_px=rng.uniform([800, 100], [1600, 1500], limb_pair.second.shape),
    )
    assert verify_pair(none, calibration, calibration) is None
