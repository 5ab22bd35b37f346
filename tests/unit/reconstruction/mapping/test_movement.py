"""Movement between two bodies: known motions are found, noise is not."""

from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid, Similarity
from limbgram.core.geometry.lens import Camera
from limbgram.findings import note
from limbgram.reconstruction.mapping.movement import (
    BodyMotion,
    MovementOptions,
    joined_photos,
    movement_between,
    stood_with_first,
)
from limbgram.reconstruction.mapping.scene import Observations, PhotoVerdict, Scene

PHOTOS = 14
DISTANCE = 1500.0
SIGMAS = np.array([2e-4, 2e-4, 2e-4, 0.1, 0.1, 1.0])
"""Of a photo's place by one body: turn in rad, shift in mm."""
CAMERA = Camera(width_px=900, height_px=600, fx=2000, fy=2000, cx=450, cy=300)
RING = [
    Rigid.looking_at(
        DISTANCE * np.array([np.cos(turn) * 0.9, np.sin(turn) * 0.9, 0.44]),
        np.zeros(3),
        np.array([0.0, 0.0, 1.0]),
    )
    for turn in np.linspace(0, 2 * np.pi, PHOTOS, endpoint=False)
]


def placed(
    poses: list[Rigid], rng: np.random.Generator, noise: float = 1.0, bent: float = 0.0
) -> Scene:
    """A scene of these poses, each off by its sigmas, with points round the origin.

    Args:
        bent: By so many sigmas more they are off as the cosine and sine of their turn go.
    """
    turns = np.linspace(0, 2 * np.pi, len(poses), endpoint=False)
    shared = np.column_stack([np.eye(len(poses)), bent * np.cos(turns), bent * np.sin(turns)])
    errors = np.kron(shared, np.diag(SIGMAS))
    off = (noise * errors @ rng.normal(size=errors.shape[1])).reshape(-1, 6)
    moved = [
        Rigid(
            Rigid.from_rotation_vector(one[:3], np.zeros(3)).rotation @ pose.rotation,
            pose.translation + one[3:],
        )
        for pose, one in zip(poses, off, strict=True)
    ]
    covariance = np.zeros((6 * len(poses) + 10,) * 2)
    covariance[:-10, :-10] = errors @ errors.T
    names = tuple(f"{k}.jpg" for k in range(len(poses)))
    return Scene(
        names=names,
        cameras=(CAMERA,),
        camera_idx=(0,) * len(poses),
        camera_from_world=tuple(moved),
        points_in_world=rng.normal(0, 60, (400, 3)),
        observations=Observations(np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros((0, 2))),
        verdicts=tuple(
            PhotoVerdict(name=name, placed=True, points=400, rms_px=0.1) for name in names
        ),
        camera_covariance=covariance,
    )


def seen(shifts: np.ndarray, seed: int, noise: float = 1.0, turn_deg: float = 0.0) -> BodyMotion:
    """What is found where the surroundings shift so in each photo, in another frame and size."""
    rng = np.random.default_rng(seed)
    axis = np.array([0.6, 0.0, 0.8])
    sizes = np.linalg.norm(shifts, axis=1, keepdims=True)
    turns = np.radians(turn_deg) * sizes / max(float(sizes.max()), 1e-12)
    room = [
        pose @ Rigid.from_rotation_vector(turn * axis, shift)
        for pose, turn, shift in zip(RING, turns, shifts, strict=True)
    ]
    frame = Similarity(
        0.01, Rigid.from_rotation_vector(np.array([0.3, -0.2, 0.5]), np.zeros(3)).rotation,
        np.array([3.0, -2.0, 1.0]),
    )  # fmt: skip
    return movement_between(placed(RING, rng, noise), placed(room, rng, noise).moved(frame))


def seen_of_a_soft_ring(shifts: np.ndarray, seed: int, *, together: bool) -> BodyMotion:
    """A ring that bends far by both bodies, evenly along it.

    Args:
        together: Whether the covariance tells that neighbours are off together.
    """
    rng = np.random.default_rng(seed)
    room = [
        pose @ Rigid.from_rotation_vector(np.zeros(3), shift) for pose, shift in zip(RING, shifts)
    ]
    bodies = [placed(poses, rng, bent=8.0) for poses in (RING, room)]
    if not together:
        bodies = [replace(one, camera_covariance=alone(one.camera_covariance)) for one in bodies]
    return movement_between(bodies[0], bodies[1])


def alone(covariance: np.ndarray | None) -> np.ndarray:
    """The covariance without what photos have in common."""
    assert covariance is not None
    photo = np.append(np.repeat(np.arange(PHOTOS), 6), np.full(10, PHOTOS))
    return np.where(photo[:, None] == photo, covariance, 0.0)


def step(size_mm: float, first: int = PHOTOS // 2) -> np.ndarray:
    shifts = np.zeros((PHOTOS, 3))
    shifts[first:] = size_mm * np.array([0.6, 0.64, 0.48])
    return shifts


def test_photos_without_movement_show_none() -> None:
    kinds = [seen(np.zeros((PHOTOS, 3)), seed).movement.kind for seed in range(100)]
    assert kinds == ["still"] * 100


def test_errors_that_neighbours_share_hide_no_movement() -> None:
    """A ring that bends keeps its ends together, and a drift parts them."""
    drift = np.linspace(0, 1, PHOTOS)[:, None] * np.array([4.0, 0.0, 1.2])
    still = np.zeros((PHOTOS, 3))

    def kinds(shifts: np.ndarray, *, together: bool) -> list[str]:
        found = [seen_of_a_soft_ring(shifts, seed, together=together) for seed in range(30)]
        return [one.movement.kind for one in found]

    assert kinds(still, together=True) == ["still"] * 30
    assert kinds(drift, together=True) == ["drift"] * 30
    assert kinds(drift, together=False) == ["still"] * 30


@pytest.mark.parametrize("size_mm", [2.0, 4.0, 8.0, 10.0])
def test_a_step_is_found_where_it_is_and_as_large_as_it_is(size_mm: float) -> None:
    for seed in range(5):
        found = seen(step(size_mm), seed, turn_deg=0.3)
        assert found.movement.kind == "step"
        assert found.movement.group.tolist() == [0] * 7 + [1] * 7
        assert found.movement.shift[:7].max() == 0.0
        assert abs(found.movement.shift[7] - size_mm) < 0.5
        assert found.movement.turn_deg[7] == pytest.approx(0.3, abs=0.05)
        np.testing.assert_allclose(found.motions[7, 3:], step(size_mm)[7], atol=0.4)


def test_a_step_early_in_the_walk_leaves_the_larger_group_in_place() -> None:
    found = seen(step(8.0, first=3), 1).movement
    assert found.group.tolist() == [0] * 3 + [1] * 11
    assert found.shift[5] == 0.0
    assert abs(found.shift[0] - 8.0) < 0.5


def test_two_steps_are_told_apart() -> None:
    shifts = step(6.0, first=4)
    shifts[9:] += [-4.0, 5.0, 0.0]
    assert seen(shifts, 2).movement.group.tolist() == [0] * 4 + [1] * 5 + [2] * 5


def test_a_slow_drift_is_a_drift() -> None:
    for seed in range(5):
        shifts = np.linspace(0, 1, PHOTOS)[:, None] * np.array([6.0, 0.0, 0.8])
        found = seen(shifts, seed).movement
        assert found.kind == "drift"
        assert abs(found.shift[0] + found.shift[-1] - np.hypot(6.0, 0.8)) < 0.7


def test_a_drift_that_turns_nowhere_is_told_without_a_turn_and_one_that_turns_with_it() -> None:
    drift = np.linspace(0, 1, PHOTOS)[:, None] * np.array([3.0, 0.0, 1.0])
    for seed in range(10):
        plain = seen(drift, seed)
        assert plain.movement.kind == "drift"
        np.testing.assert_allclose(plain.motions[:, :3], 0.0, atol=1e-8)
    turned = seen(2 * drift, 1, turn_deg=0.5)
    assert turned.movement.kind == "drift"
    spread_deg = np.degrees(np.ptp(turned.motions[:, :3] @ [0.6, 0.0, 0.8]))
    assert spread_deg == pytest.approx(0.5, abs=0.1)


def test_a_limb_elsewhere_in_every_photo_is_restless() -> None:
    rng = np.random.default_rng(8)
    found = seen(rng.uniform(-4, 4, (PHOTOS, 3)), 3).movement
    assert found.moved
    assert 2.0 < found.shift.max() < 10.0


def test_a_sway_that_leaves_little_is_told_by_what_chance_does_not_leave() -> None:
    kinds: list[str] = []
    for seed in range(8):
        rng = np.random.default_rng((seed, 1))
        kinds.append(seen(rng.uniform(-0.7, 0.7, (PHOTOS, 3)), seed).movement.kind)
    assert kinds == ["restless"] * 8


def test_one_photo_that_lies_elsewhere_is_no_sway() -> None:
    for seed in range(4):
        shifts = np.zeros((PHOTOS, 3))
        shifts[5] = [0.96, 0.8, 1.28]
        assert seen(shifts, seed).movement.kind == "still"


def test_errors_that_follow_the_camera_round_are_no_sway_and_dealt_otherwise_they_are() -> None:
    turn = np.linspace(0, 2 * np.pi, PHOTOS, endpoint=False)[:, None]
    even = (np.cos(turn) + np.sin(turn)) * np.array([0.0, 0.0, 1.0])
    dealt = np.random.default_rng(3).permutation(PHOTOS)
    for seed in range(3):
        assert seen(0.45 * even, seed).movement.kind == "still"
        assert seen(0.6 * even, seed).movement.kind == "still"
        assert seen(0.45 * even[dealt], seed).movement.kind == "restless"


def test_what_a_lens_that_is_not_known_may_cause_is_not_called_movement() -> None:
    rng = np.random.default_rng(8)
    first, shifts = np.random.default_rng(1), rng.uniform(-4, 4, (PHOTOS, 3))
    room = [pose @ Rigid(np.eye(3), shift) for pose, shift in zip(RING, shifts, strict=True)]
    found = movement_between(placed(RING, first), placed(room, first), lenses_known=False)
    assert (found.movement.kind, found.movement.moved) == ("unknown", False)
    assert found.movement.reason == note("movement.unknown.lens")
    assert found.movement.misfit
    assert found.movement.chance < 1e-5


def test_a_shift_of_every_photo_along_its_line_of_sight_is_another_focus() -> None:
    rng = np.random.default_rng(4)
    axial = rng.normal(0, 8, PHOTOS)
    room = [
        Rigid(pose.rotation, pose.translation + np.array([0.0, 0.0, far]))
        for pose, far in zip(RING, axial, strict=True)
    ]
    found = movement_between(placed(RING, rng), placed(room, rng))
    assert found.movement.kind == "still"


def test_an_error_of_the_lens_that_all_photos_share_is_no_movement() -> None:
    rng = np.random.default_rng(5)
    skewed = Rigid.from_rotation_vector(np.array([0.004, -0.003, 0.002]), np.array([3.0, -2.0, 0]))
    found = movement_between(placed(RING, rng), placed([skewed @ pose for pose in RING], rng))
    assert found.movement.kind == "still"


def test_movement_too_small_to_matter_is_none() -> None:
    assert seen(step(0.3), 6, noise=0.01).movement.kind == "still"
    found = movement_between(
        placed(RING, np.random.default_rng(6), 0.01),
        placed([pose @ Rigid(np.eye(3), s) for pose, s in zip(RING, step(1.5), strict=True)],
               np.random.default_rng(7), 0.01),
        MovementOptions(least_shift=0.0),
    )  # fmt: skip
    assert found.movement.kind == "step"


@pytest.mark.parametrize("firmly", [False, True])
def test_one_photo_elsewhere_is_believed_only_if_points_hold_it(firmly: bool) -> None:
    rng = np.random.default_rng(3)
    shifts = np.zeros((PHOTOS, 3))
    shifts[5] = [4.0, 5.0, 0.0]
    room = [
        pose @ Rigid.from_rotation_vector(np.zeros(3), shift) for pose, shift in zip(RING, shifts)
    ]
    photo = np.repeat(np.arange(PHOTOS, dtype=np.int32), 40)
    point = np.tile(np.arange(40, dtype=np.int32), PHOTOS)
    kept = np.full(len(photo), True) if firmly else (photo != 5) | (point < 10)
    seen_of = Observations(photo[kept], point[kept], np.zeros((int(kept.sum()), 2)))
    limb, around = (replace(placed(one, rng), observations=seen_of) for one in (RING, room))
    found = movement_between(limb, around).movement
    assert found.moved is firmly
    unknown = np.flatnonzero(~np.isfinite(found.shift)).tolist()
    assert unknown == ([] if firmly else [5])


def test_few_photos_tell_nothing() -> None:
    scene = placed(RING[:5], np.random.default_rng(0))
    found = movement_between(scene, scene).movement
    assert (found.kind, found.reason) == (
        "unknown",
        note("movement.unknown.few_shown", photos=5),
    )


def test_a_motion_turns_about_the_middle() -> None:
    found = seen(step(8.0), 1, turn_deg=2.0)
    moved = found.moved(9).apply(found.middle[None])[0] - found.middle
    np.testing.assert_allclose(moved, found.motions[9, 3:], atol=1e-9)


def test_photos_hang_together_only_by_shared_points() -> None:
    scene = placed(RING[:6], np.random.default_rng(0))
    photo = np.repeat(np.arange(6, dtype=np.int32), 20)
    point = np.concatenate([np.arange(20)] * 4 + [np.arange(50, 70)] * 2).astype(np.int32)
    apart = replace(scene, observations=Observations(photo, point, np.zeros((120, 2))))
    assert joined_photos(apart) == (0, 1, 2, 3)


@pytest.mark.parametrize("beside", [True, False])
@pytest.mark.parametrize("seed", range(4))
def test_a_third_body_tells_which_of_two_moved(beside: bool, seed: int) -> None:
    """Boxes moved while limb and board kept still, or the limb moved against both."""
    shifts = np.random.default_rng(seed).normal(0.0, 3.0, (PHOTOS, 3))
    room = seen(shifts, seed)
    assert room.movement.moved
    rng = np.random.default_rng(100 + seed)
    poses = [
        pose if beside else pose @ Rigid.from_rotation_vector(np.zeros(3), shift)
        for pose, shift in zip(RING, shifts, strict=True)
    ]
    board = placed(poses, rng)
    assert stood_with_first(placed(RING, rng), board, room) is beside


def test_a_board_that_cannot_tell_stood_with_nobody() -> None:
    room = seen(step(4.0), 3)
    rng = np.random.default_rng(4)
    size = 6 * PHOTOS + 10
    vague = replace(placed(RING, rng), camera_covariance=1e6 * np.eye(size))
    assert not stood_with_first(placed(RING, rng), vague, room)
    assert not stood_with_first(placed(RING[:9], rng), placed(RING[:9], rng), room)
