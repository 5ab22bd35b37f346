"""Flatness: boards bent by known amounts, and lenses that look alike."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from limbgram.reconstruction.hypotheses.flatness import board_bend
from limbgram.reconstruction.mapping.lens_equations import DEVIATION_SIZE
from limbgram.reconstruction.mapping.scene import Explanation
from limbgram.reconstruction.scale.board import located_board

Take = Callable[..., Any]
N = 14
SIZE_MM = np.array([210.0, 150.0])


def found(take: Take, **options: Any) -> Explanation | None:
    taken = take(points=400, **options)
    board = located_board(taken.limb, taken.board)
    assert board is not None
    return board_bend(taken.limb, [taken.calibration], board, SIZE_MM)


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, 4))]
)
def test_a_flat_board_is_not_bent(take: Take, seed: int) -> None:
    assert found(take, seed=seed) is None
    assert found(take, seed=seed, by_exif=True) is None


@pytest.mark.parametrize(
    "sag_mm", [1.0, -1.5, *(pytest.param(one, marks=pytest.mark.slow) for one in (1.5, 4.0))]
)
def test_a_bent_board_is_told_with_its_sag(take: Take, sag_mm: float) -> None:
    bend = found(take, sag_mm=sag_mm)
    assert bend is not None
    assert (bend.bodies, bend.kind, bend.is_fact) == ("board", "bend", True)
    assert bend.photos == tuple(range(N))
    assert bend.low < abs(sag_mm) < bend.high
    assert bend.high - bend.low < 0.4


def test_what_is_usual_is_no_fact(take: Take) -> None:
    bend = found(take, sag_mm=0.5)
    assert bend is not None
    assert bend.failed == ("size",)
    assert found(take, sag_mm=0.1) is None


def test_before_a_lens_that_no_board_calibrated_it_is_open(take: Take) -> None:
    bend = found(take, sag_mm=2.0, by_exif=True)
    assert bend is not None
    assert "model" in bend.failed
    assert bend.low < 2.0 < bend.high


@pytest.mark.parametrize(
    "lens",
    [
        {"k1": -0.15},
        *(
            pytest.param(one, marks=pytest.mark.slow)
            for one in ({"focal_px": 1530.0}, {"k1": 0.05})
        ),
    ],
)
def test_another_lens_than_the_files_bends_no_board(take: Take, lens: dict[str, float]) -> None:
    bend = found(take, **lens)
    assert bend is None or not bend.is_fact


@pytest.mark.parametrize(
    "number", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, DEVIATION_SIZE))]
)
def test_lenses_that_differ_from_photo_to_photo_bend_no_board(take: Take, number: int) -> None:
    own = np.zeros((N, DEVIATION_SIZE))
    own[:, number] = 4e-3 * np.random.default_rng(number).normal(size=N)
    bend = found(take, own=own)
    assert bend is None or not bend.is_fact


def test_one_photo_alone_bends_no_board(take: Take) -> None:
    bend = found(take, sag_mm=8.0, sag_in=3)
    assert bend is None or not bend.is_fact


@pytest.mark.parametrize(("photos", "failed"), [(3, ("one photo",)), (4, ())])
def test_three_photos_leave_a_bent_board_open(
    take: Take, photos: int, failed: tuple[str, ...]
) -> None:
    assert found(take, photos=photos) is None
    bend = found(take, photos=photos, sag_mm=1.5)
    assert bend is not None
    assert bend.failed == failed
    assert bend.low < 1.5 < bend.high


def test_a_corner_that_a_lens_cannot_show_says_nothing(take: Take) -> None:
    """It lies behind the one camera that shows it; the others tell of the bend as they did."""
    taken = take(points=400, sag_mm=4.0)
    board = located_board(taken.limb, taken.board)
    assert board is not None
    centre = taken.limb.view(0).centre_in_world
    offsets = board.offsets.copy()
    offsets[0] += 1.5 * (centre - board.corners[0])
    kept = (board.corner_idx != 0) | (board.photo_idx == 0)
    moved = replace(
        board,
        offsets=offsets,
        photo_idx=board.photo_idx[kept],
        corner_idx=board.corner_idx[kept],
        xy_px=board.xy_px[kept],
    )
    assert np.isnan(taken.limb.view(0).project(moved.corners[:1])).all()
    bend = board_bend(taken.limb, [taken.calibration], moved, SIZE_MM)
    assert bend is not None
    assert bend.low < 4.0 < bend.high
    assert bend.effect == pytest.approx(4.0, abs=0.05)
