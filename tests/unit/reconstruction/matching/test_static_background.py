"""What stands still: a room behind a turning object goes, and nothing of an honest walk does."""

from collections.abc import Sequence

import numpy as np
import pytest

from limbgram.core.errors import MatchingError
from limbgram.findings import told
from limbgram.reconstruction.features.detection import Features, Keypoints
from limbgram.reconstruction.matching.static_background import find_still

SIDES_PX = np.array([1500.0, 1000.0])
ROOM, LIMB = 300, 200


def keypoints(xy_px: np.ndarray, looks: np.ndarray, rng: np.random.Generator) -> Keypoints:
    """Keypoints that look as told, seen with the noise of a photo, largest first."""
    seen = np.abs(looks + rng.normal(scale=2.0, size=looks.shape))
    whole = np.rint(512 * seen / np.linalg.norm(seen, axis=1, keepdims=True))
    scale = np.linspace(8.0, 2.0, len(xy_px), dtype=np.float32)
    order = rng.permutation(len(xy_px))
    return Keypoints(
        xy_px=(xy_px + rng.normal(scale=0.15, size=xy_px.shape)).astype(np.float32)[order],
        scale_px=scale,
        angle_deg=np.zeros(len(xy_px), np.float32),
        descriptors=whole.astype(np.uint8)[order],
    )


def descriptors(count: int, rng: np.random.Generator) -> np.ndarray:
    """As of SIFT: a few large values among many small ones."""
    return 30.0 * rng.gamma(0.6, 1.0, (count, 128))


def photos(
    count: int,
    rng: np.random.Generator,
    moving: Sequence[float],
    room: Sequence[float],
    patch: float = 1.0,
    growth: Sequence[float] | None = None,
) -> Features:
    """Each photo shows limb and room shifted by so much to the right.

    Args:
        patch: Share of the picture's sides that the room takes.
        growth: Of each photo's room, about the middle of the picture, in parts of itself.
    """
    limb_px, room_px = rng.uniform(0, 1, (LIMB, 2)) * 400 + 300, rng.uniform(0, 1, (ROOM, 2))
    looks = descriptors(LIMB + ROOM, rng)
    found: list[Keypoints] = []
    for k in range(count):
        in_room = patch * room_px * SIDES_PX + np.array([room[k], 0.0])
        if growth is not None:
            in_room = in_room + growth[k] * (in_room - SIDES_PX / 2)
        places = np.concatenate([limb_px + np.array([moving[k], 0.0]), in_room])
        found.append(keypoints(places, looks, rng))
    return Features(tuple(found))


def one_scale(features: Features) -> Features:
    """All keypoints of one scale, so that shuffled ones stay comparable."""
    same = [
        Keypoints(
            xy_px=one.xy_px,
            scale_px=np.full(len(one), 4.0, np.float32),
            angle_deg=one.angle_deg,
            descriptors=one.descriptors,
        )
        for one in features.keypoints
    ]
    return Features(tuple(same))


def test_a_still_room_goes_and_the_turning_limb_stays() -> None:
    rng = np.random.default_rng(1)
    features = one_scale(photos(8, rng, moving=[30.0 * k for k in range(8)], room=[0.0] * 8))
    found = find_still(features)
    assert found.groups == (tuple(range(8)),)
    assert "stood still in 8 photos" in told(found.notes[0])
    assert f"{found.count:,} feature points stay" in told(found.notes[0])
    kept = found.moving(features)
    for before, after in zip(features.keypoints, kept.keypoints, strict=True):
        assert len(before) == LIMB + ROOM
        assert LIMB <= len(after) < LIMB + 0.05 * ROOM


def test_a_tripod_that_was_touched_stands_still_all_the_same() -> None:
    rng = np.random.default_rng(2)
    touched = [0.0, 0.0, 1.6, 1.6, -1.0, 0.0, 0.4, 0.0]
    features = one_scale(photos(8, rng, moving=[30.0 * k for k in range(8)], room=touched))
    kept = find_still(features).moving(features)
    assert max(map(len, kept.keypoints)) < LIMB + 0.1 * ROOM


def test_a_stabiliser_shifts_what_stands_still() -> None:
    """By a quarter of a per cent of the picture, one sigma, in every photo."""
    rng = np.random.default_rng(3)
    shifts = rng.normal(scale=0.0025 * SIDES_PX[0], size=9)
    walk = (60.0 * np.arange(9)).tolist()
    features = one_scale(photos(9, rng, moving=walk, room=shifts.tolist()))
    still = find_still(features)
    assert still.photos == tuple(range(9))
    assert still.count > 0.8 * 9 * ROOM
    left = sum(map(len, still.moving(features).keypoints))
    assert left > 0.95 * 9 * LIMB


def test_a_focus_found_anew_lets_what_stands_still_grow() -> None:
    """By up to half a per cent, which moves the corners of the picture by 4.5 px."""
    rng = np.random.default_rng(8)
    growth = rng.uniform(-0.0025, 0.0025, 9)
    shifts = rng.normal(scale=0.0025 * SIDES_PX[0], size=9)
    walk = (60.0 * np.arange(9)).tolist()
    features = one_scale(photos(9, rng, walk, shifts.tolist(), growth=growth.tolist()))
    still = find_still(features)
    assert still.photos == tuple(range(9))
    assert still.count > 0.9 * 9 * ROOM
    assert sum(map(len, still.moving(features).keypoints)) > 0.95 * 9 * LIMB
    found = np.array([one.growth for one in still.moves])
    np.testing.assert_allclose(found, growth - growth[0], atol=1e-4)


def test_a_patch_that_is_shifted_alike_is_no_room() -> None:
    """As round the middle of a walk in small steps."""
    walk = (60.0 * np.arange(9)).tolist()
    shifts = (5.0 * np.arange(9)).tolist()
    for patch, groups in ((0.1, 0), (1.0, 1)):
        rng = np.random.default_rng(4)
        features = one_scale(photos(9, rng, moving=walk, room=shifts, patch=patch))
        assert len(find_still(features).groups) == groups


def test_a_photo_that_shows_a_patch_of_the_room_belongs_to_it() -> None:
    """The rest of the room is hidden in it, by the hand that turns the limb."""
    rng = np.random.default_rng(6)
    shifts = (5.0 * np.array([0, 1, 0, 1, 2, 0, 1, 0, 1])).tolist()
    walk = (60.0 * np.arange(9)).tolist()
    features = one_scale(photos(9, rng, moving=walk, room=shifts))
    seen = features.keypoints[4]
    shown = (np.abs(seen.xy_px - SIDES_PX / 2) < 150.0).all(axis=1)
    keypoints = [one.some(shown) if k == 4 else one for k, one in enumerate(features.keypoints)]
    still = find_still(Features(tuple(keypoints)))
    assert still.photos == tuple(range(9))
    np.testing.assert_allclose(still.moves[4].shift_px, [shifts[4], 0.0], atol=0.3)


def test_a_photo_that_shares_a_patch_with_few_of_a_place_was_taken_elsewhere() -> None:
    rng = np.random.default_rng(7)
    shifts, walk = [0.0] * 8 + [5.0], (60.0 * np.arange(9)).tolist()
    features = one_scale(photos(9, rng, moving=walk, room=shifts))
    inside = [(np.abs(one.xy_px - SIDES_PX / 2) < 150.0).all(axis=1) for one in features.keypoints]
    keypoints = [
        one.some(shown if k == 8 else ~shown if 2 < k < 8 else np.ones(len(one), bool))
        for k, (one, shown) in enumerate(zip(features.keypoints, inside, strict=True))
    ]
    assert find_still(Features(tuple(keypoints))).photos == tuple(range(8))


def test_a_walk_round_keeps_every_keypoint() -> None:
    rng = np.random.default_rng(3)
    walk = [25.0 * k for k in range(8)]
    features = one_scale(photos(8, rng, moving=walk, room=[-0.7 * one for one in walk]))
    found = find_still(features)
    assert found.groups == ()
    assert found.notes == ()
    assert found.moving(features) is features


def test_one_photo_taken_twice_in_a_walk_is_left_alone() -> None:
    rng = np.random.default_rng(4)
    walk = [0.0, 25.0, 50.0, 50.0, 75.0, 100.0, 125.0, 125.0]
    features = one_scale(photos(8, rng, moving=walk, room=[-0.7 * one for one in walk]))
    assert find_still(features).groups == ()


def test_five_photos_from_one_spot_of_a_still_limb_are_left_alone() -> None:
    rng = np.random.default_rng(5)
    walk = [0.0] * 5 + [25.0, 50.0, 75.0, 100.0]
    features = one_scale(photos(9, rng, moving=walk, room=[-0.7 * one for one in walk]))
    assert find_still(features).groups == ()


def test_two_places_of_the_tripod_are_two_groups() -> None:
    rng = np.random.default_rng(6)
    room = [0.0] * 6 + [140.0] * 6
    features = one_scale(photos(12, rng, moving=[30.0 * k for k in range(12)], room=room))
    found = find_still(features)
    assert found.groups == (tuple(range(6)), tuple(range(6, 12)))
    assert found.photos == tuple(range(12))
    assert found.count > 0.95 * 12 * ROOM


def test_when_nothing_moves_it_is_said() -> None:
    rng = np.random.default_rng(7)
    features = one_scale(photos(6, rng, moving=[0.0] * 6, room=[0.0] * 6))
    with pytest.raises(MatchingError, match="All 6 photos show the same picture"):
        find_still(features)


def test_photos_that_show_nothing_are_no_group() -> None:
    empty = Keypoints(
        xy_px=np.zeros((0, 2), np.float32),
        scale_px=np.zeros(0, np.float32),
        angle_deg=np.zeros(0, np.float32),
        descriptors=np.zeros((0, 128), np.uint8),
    )
    assert find_still(Features((empty,) * 6)).groups == ()
