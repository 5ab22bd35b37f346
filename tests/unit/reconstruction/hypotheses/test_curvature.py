"""CurvatureChange: limbs bowed by known amounts in known photos, and lenses that look alike."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from limbgram.reconstruction.hypotheses.curvature import CurvatureChange, find_curvature_change
from limbgram.reconstruction.mapping.bundle_adjustment import adjust
from limbgram.reconstruction.mapping.lens_deviations import DEVIATIONS
from limbgram.reconstruction.mapping.lens_equations import (
    DEVIATION_SIZE,
    USUAL_SPREAD,
    lens_basis,
)
from limbgram.reconstruction.mapping.scene import Movement, OwnLenses

Take = Callable[..., Any]
N = 14
LATER = (np.arange(N) >= 9).astype(float)


def found(take: Take, bows_mm: np.ndarray, **options: Any) -> CurvatureChange | None:
    taken = take(bows_mm=bows_mm, points=400, outlier_sigmas=16.0, **options)
    return find_curvature_change(taken.limb, [taken.calibration], 1.0)


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, 4))]
)
def test_a_rigid_limb_is_not_bent(take: Take, seed: int) -> None:
    assert found(take, np.zeros(N), seed=seed) is None
    assert found(take, np.zeros(N), seed=seed, shared=0.4) is None


@pytest.mark.parametrize("bow_mm", [1.0, 4.0])
def test_a_limb_that_bows_between_two_photos(take: Take, bow_mm: float) -> None:
    bent = found(take, bow_mm * LATER)
    assert bent is not None
    one = bent.explanation
    assert (one.bodies, one.kind, one.photos, one.is_fact) == (
        "halves",
        "step",
        (9, 10, 11, 12, 13),
        True,
    )
    at_end_mm = (
        0.98**2 * bow_mm
    )  # the ends' last points beyond 0.98 of the half length count as there
    assert one.low < at_end_mm < one.high
    assert one.effect == pytest.approx(at_end_mm, rel=0.15)
    assert bent.course.tolist() == LATER.tolist()


def test_a_limb_that_bows_slowly(take: Take) -> None:
    bent = found(take, np.linspace(0.0, 4.0, N))
    assert bent is not None
    assert (bent.explanation.kind, bent.explanation.is_fact) == ("drift", True)
    assert bent.explanation.effect == pytest.approx(4.0, rel=0.2)


@pytest.mark.parametrize(
    "number", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, DEVIATION_SIZE))]
)
def test_a_lens_that_changes_between_two_photos_bends_no_limb(take: Take, number: int) -> None:
    own = np.zeros((N, DEVIATION_SIZE))
    own[:, number] = 3e-3 * LATER if number != 2 else 5e-3 * LATER
    bent = found(take, np.zeros(N), own=own)
    assert bent is None or not bent.explanation.is_fact


def test_a_bow_weighs_the_same_however_far_lenses_of_photos_were_solved(take: Take) -> None:
    """They are drawn about their camera's lens, not about what the adjustment found."""
    own = 3.0 * np.random.default_rng(3).normal(size=(N, DEVIATION_SIZE)) * USUAL_SPREAD
    own[:, 7:] = 0.0
    taken = take(bows_mm=0.6 * LATER, points=300, outlier_sigmas=16.0, seed=3, own=own)
    given = taken.calibration
    held = replace(given, covariance=np.zeros_like(given.covariance))
    scores: list[float] = []
    for share in (1.0, 0.8):
        solved = OwnLenses(
            deviations=DEVIATIONS,
            values=share * own[:, :7],
            spread=np.std(own[:, :7], axis=0),
            shifts=share * own @ lens_basis(given.camera).T,
            chances=(1e-9,) * len(DEVIATIONS),
        )
        start = replace(taken.limb, own=solved)
        scene = adjust(start, [held], rounds=2, outlier_sigmas=16.0).scene
        bent = find_curvature_change(scene, [given], 1.0)
        assert bent is not None
        scores.append(bent.explanation.score)
    assert scores[0] == pytest.approx(scores[1], rel=0.03)


def test_one_photo_alone_bends_no_limb(take: Take) -> None:
    bent = found(take, 6.0 * (np.arange(N) == 5))
    assert bent is None or "one photo" in bent.explanation.failed


def test_a_lens_that_no_board_calibrated_is_not_asked(take: Take) -> None:
    assert found(take, 4.0 * LATER, by_exif=True) is None


def test_what_is_told_beside_the_halves(take: Take) -> None:
    bent = found(take, 4.0 * LATER)
    assert bent is not None
    told = bent.merged_with(Movement.unknown(N))
    assert (told.kind, told.moved, told.explanations) == ("step", True, (bent.explanation,))
    assert told.group.tolist() == LATER.astype(int).tolist()
    assert told.largest == pytest.approx(4.0, rel=0.2)
    assert np.flatnonzero(told.shift).tolist() == [9, 10, 11, 12, 13]
    # 4 mm bowed over half a length of 100 mm: the end's slope is 2 x 4 / 100
    assert np.nanmax(told.turn_deg) == pytest.approx(np.degrees(0.08), rel=0.3)


def test_what_is_not_decided_beside_the_halves(take: Take) -> None:
    bent = found(take, 4.0 * LATER)
    assert bent is not None
    doubted = replace(bent, explanation=replace(bent.explanation, failed=("lens",)))
    assert doubted.merged_with(Movement.unknown(N)).misfit
    assert doubted.merged_with(Movement.unknown(N)).undecided == (doubted.explanation,)
