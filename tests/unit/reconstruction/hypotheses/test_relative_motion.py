"""Movement of two bodies as the pipeline takes it up: groups, sizes, and who moved."""

import itertools
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from limbgram.findings import note
from limbgram.reconstruction.hypotheses.relative_motion import is_rigid_with_first, movement_between
from limbgram.reconstruction.mapping.body_motion import BodyMotion, connected_photos
from limbgram.reconstruction.mapping.placement import without_photos
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.matching.matching import PairMatches
from limbgram.reconstruction.movement import moved_photos, third_moved

Take = Callable[..., Any]
N = 14
ALONG = np.array([0.6, 0.64, 0.48])


def steps(*sizes_mm: float) -> np.ndarray:
    """As many photos of each."""
    each = np.array_split(np.arange(N), len(sizes_mm))
    motions = np.zeros((N, 6))
    for size_mm, rows in zip(sizes_mm, each, strict=True):
        motions[rows, 3:] = size_mm * ALONG
    return motions


def seen(taken: Any) -> BodyMotion:
    return movement_between(taken.limb, taken.room, [taken.calibration], "limb and room", 1.0)


def test_a_body_that_kept_still(take: Take) -> None:
    found = seen(take()).movement
    assert (found.kind, found.largest, found.explanations) == ("still", 0.0, ())
    assert found.group.tolist() == [0] * N


def test_the_largest_shift_is_between_any_two_photos(take: Take) -> None:
    """Not from the largest group: steps of 3 mm to either side part photos by 6 mm."""
    found = seen(take(motions=steps(-3.0, 0.0, 0.0, 3.0))).movement
    assert found.kind == "step"
    assert found.group[[0, 6, -1]].tolist() == [0, 1, 2]
    assert found.largest == pytest.approx(6.0, abs=0.2)
    assert np.nanmax(found.shift) == pytest.approx(3.0, abs=0.2)
    assert found.scaled(2.0).largest == pytest.approx(12.0, abs=0.4)


def test_a_body_that_came_back_lies_where_it_lay(take: Take) -> None:
    """Only the photos between both steps show it elsewhere."""
    motions = np.zeros((N, 6))
    motions[5:9, 3:] = 3.0 * ALONG
    found = seen(take(motions=motions))
    assert found.movement.kind == "step"
    assert found.movement.group.tolist() == [0] * 5 + [1] * 4 + [0] * 5
    assert moved_photos(found.movement, tuple(map(str, range(N)))) == ("5", "6", "7", "8")
    assert not found.motions[9:].any()
    assert found.movement.largest == pytest.approx(3.0, abs=0.2)


def test_what_is_not_decided_is_unknown_and_does_not_fit(take: Take) -> None:
    motions = np.zeros((N, 6))
    motions[5, 3:] = [2.0, 1.0, 0.0]
    found = seen(take(motions=motions)).movement
    assert (found.kind, found.moved, found.misfit) == ("unknown", False, True)
    assert found.undecided[0].photos == (5,)


def test_a_photo_that_few_points_hold_is_left_out(take: Take) -> None:
    motions = np.zeros((N, 6))
    motions[5, 3:] = [2.0, 1.0, 0.0]
    taken = take(motions=motions)
    room = taken.room.observations
    kept = (room.photo_idx != 5) | (np.cumsum(room.photo_idx == 5) <= 25)
    loose = replace(taken, room=replace(taken.room, observations=room.some(kept)))
    found = seen(loose).movement
    assert found.kind == "still"
    assert np.flatnonzero(~np.isfinite(found.shift)).tolist() == [5]


def test_of_many_photos_some_are_searched_and_the_others_follow(
    take: Take, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("limbgram.reconstruction.hypotheses.relative_motion.MOST_PHOTOS", 16)
    far = np.linspace(0.0, 4.0, 24)
    for sizes_mm, kind in ((np.where(far > 2.0, 2.0, 0.0), "step"), (far, "drift")):
        found = seen(
            take(photos=24, points=80, motions=sizes_mm[:, None] * np.append([0, 0, 0], ALONG))
        )
        assert found.movement.kind == kind
        known = found.movement.group >= 0
        assert known.sum() >= 23, "between two groups nothing is known"
        shift = found.motions[:, 3:] @ ALONG
        np.testing.assert_allclose(
            (shift - shift[0])[known], (sizes_mm - sizes_mm[0])[known], atol=0.25
        )


def test_few_photos_tell_nothing(take: Take) -> None:
    taken = take()
    few = without_photos(taken.limb, set(range(9, N)))
    found = movement_between(few, taken.room, [taken.calibration], "limb and room").movement
    assert found.reason == note("movement.unknown.few_shown", photos=9)
    assert not found.misfit


@pytest.mark.parametrize("beside", [True, False])
@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, 3))]
)
def test_a_third_body_tells_which_of_two_moved(take: Take, beside: bool, seed: int) -> None:
    """Boxes moved while limb and board kept still, or the limb moved against both."""
    motions = np.zeros((N, 6))
    motions[:, 3:] = np.random.default_rng(seed).normal(0.0, 3.0, (N, 3))
    first = take(seed=seed, motions=motions)
    room = seen(first)
    assert room.movement.moved
    board = take(seed=50 + seed, points=80, motions=None if beside else motions).room
    assert is_rigid_with_first(first.limb, board, room, [first.calibration]) is beside


def test_of_many_photos_some_tell_whether_a_third_body_kept_still(
    take: Take, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As many as the search takes: their cost grows with the third power."""
    of, most, asked = "limbgram.reconstruction.hypotheses.relative_motion", 12, list[int]()

    def counted(_: Scene, __: Scene, photos: tuple[int, ...], *___: Any) -> Any:
        asked.append(len(photos))
        return SimpleNamespace(distance=1000.0)

    def moved(*_: Any) -> Any:
        return SimpleNamespace(verdict="moved")

    monkeypatch.setattr(f"{of}.MOST_PHOTOS", most)
    monkeypatch.setattr(f"{of}.two_body_equations", counted)
    monkeypatch.setattr(f"{of}.explain", moved)
    first = take(photos=24, points=80)
    unknown = BodyMotion.unknown(24, None)
    known = replace(unknown, movement=replace(unknown.movement, group=np.zeros(24, np.int64)))
    assert not is_rigid_with_first(first.limb, first.room, known, [first.calibration])
    assert asked == [most]


def pairs_of(third: Scene, photos: tuple[int, ...]) -> list[PairMatches]:
    """Of the points that two of these photos show."""
    seen, found = third.observations, list[PairMatches]()
    for first, second in itertools.combinations(photos, 2):
        rows = [seen.some(seen.photo_idx == k) for k in (first, second)]
        common, one, other = np.intersect1d(
            rows[0].point_idx, rows[1].point_idx, return_indices=True
        )
        found.append(
            PairMatches(
                first=first,
                second=second,
                keypoint_idx=np.zeros((len(common), 2), np.int32),
                xy_first_px=rows[0].xy_px[one],
                xy_second_px=rows[1].xy_px[other],
                correlation=np.ones(len(common), np.float32),
            )
        )
    return found


@pytest.mark.parametrize("size_mm", [1.0, pytest.param(8.0, marks=pytest.mark.slow)])
def test_what_moved_against_two_others_is_what_moved(take: Take, size_mm: float) -> None:
    """Few photos of both sides tell; one photo of a side does not, nor do those of one side."""
    motions = steps(0.0, size_mm)
    board = take(motions=motions)
    room = seen(board)
    for moved, third in ((False, take(points=60)), (True, take(points=60, motions=motions))):
        assert third_moved(board.limb, pairs_of(third.room, (4, 6, 7, 9)), room) is moved
        assert third_moved(board.limb, pairs_of(third.room, (4, 6, 7)), room) is None
        assert third_moved(board.limb, pairs_of(third.room, (7, 8, 9)), room) is None


def test_a_motion_turns_about_the_middle(take: Take) -> None:
    motions = steps(0.0, 2.0)
    motions[7:, :3] = 0.01 * ALONG
    found = seen(take(motions=motions))
    moved = found.in_photo(9).apply(found.middle[None])[0] - found.middle
    np.testing.assert_allclose(moved, found.motions[9, 3:], atol=1e-9)


def test_photos_hang_together_only_by_shared_points(take: Take) -> None:
    photo = np.repeat(np.arange(6, dtype=np.int32), 20)
    point = np.concatenate([np.arange(20)] * 4 + [np.arange(50, 70)] * 2).astype(np.int32)
    scene = replace(take().limb, observations=Observations(photo, point, np.zeros((120, 2))))
    assert connected_photos(scene) == (0, 1, 2, 3)
