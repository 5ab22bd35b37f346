"""F by every estimator, against the F that made the matches."""

from typing import Any

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.triangulation import sampson_px
from limbgram.reconstruction.twoview.essential import _EssentialModel
from limbgram.reconstruction.twoview.fundamental import (
    _Orthonormal,
    canonical_projection,
    damped_step,
    estimate_fundamental,
    estimate_fundamental_linear,
    normal_equations,
    refine_fundamental_gold_standard,
    refine_fundamental_sampson,
)

SIGMA_PX = 0.5
FIRST_LENS = np.array([[900.0, 0.0, 450.0], [0.0, 910.0, 300.0], [0.0, 0.0, 1.0]])
SECOND_LENS = np.array([[800.0, 0.0, 420.0], [0.0, 805.0, 310.0], [0.0, 0.0, 1.0]])


def distance_px(fundamental: np.ndarray, pair: Any) -> float:
    """RMS Sampson distance of the exact matches: how wrong F is, where it matters."""
    return float(np.sqrt(np.mean(sampson_px(fundamental, pair.first, pair.second) ** 2)))


def test_eight_points_give_exact_f_from_exact_matches(limb_pair: Any) -> None:
    assert distance_px(limb_pair.fundamental, limb_pair) < 1e-8
    found = estimate_fundamental_linear(limb_pair.first, limb_pair.second)
    assert distance_px(found, limb_pair) < 1e-4
    assert np.linalg.norm(found) == pytest.approx(1.0)
    assert np.linalg.svd(found)[1][2] < 1e-15


def test_gold_standard_and_sampson_reach_the_statistical_limit(limb_pair: Any) -> None:
    first, second = limb_pair.noisy(SIGMA_PX)
    start = estimate_fundamental_linear(first, second)
    sampson = refine_fundamental_sampson(start, first, second)
    gold = refine_fundamental_gold_standard(sampson, first, second)
    limit = SIGMA_PX * np.sqrt(7 / len(first))
    assert 0.3 * limit < distance_px(gold.fundamental, limb_pair) < 2 * limit
    assert 0.3 * limit < distance_px(sampson, limb_pair) < 2 * limit
    assert distance_px(gold.fundamental, limb_pair) < distance_px(start, limb_pair)


def test_gold_standard_is_the_least_sum_of_squares(limb_pair: Any) -> None:
    first, second = limb_pair.noisy(SIGMA_PX)
    start = estimate_fundamental_linear(first, second)
    gold = refine_fundamental_gold_standard(start, first, second)
    squares = np.sum((np.hstack([first, second]) - gold.exact) ** 2)
    exact_squares = np.sum((np.hstack([first - limb_pair.first, second - limb_pair.second])) ** 2)
    assert squares < exact_squares
    # each match keeps one of its four errors, and F takes seven of them
    assert squares == pytest.approx(SIGMA_PX**2 * (len(first) - 7), rel=0.15)
    assert np.abs(sampson_px(gold.fundamental, gold.exact[:, :2], gold.exact[:, 2:])).max() < 1e-6
    again = refine_fundamental_gold_standard(gold.fundamental, first, second)
    assert again.rms_px == pytest.approx(gold.rms_px, rel=1e-6)


def test_residual_error_is_the_papers(limb_pair: Any) -> None:
    first, second = limb_pair.noisy(SIGMA_PX)
    gold = refine_fundamental_gold_standard(limb_pair.fundamental, first, second)
    in_first = np.sum((first - gold.exact[:, :2]) ** 2, axis=1)
    in_second = np.sum((second - gold.exact[:, 2:]) ** 2, axis=1)
    expected = np.sqrt(in_first.sum() + in_second.sum()) / np.sqrt(4 * len(first))
    assert gold.rms_px == pytest.approx(expected)
    assert gold.rms_px == pytest.approx(SIGMA_PX / 2, rel=0.1)


def test_ransac_finds_f_among_wrong_matches(limb_pair: Any) -> None:
    first, second = limb_pair.noisy(SIGMA_PX)
    wrong = np.random.default_rng(1).random(len(first)) < 0.4
    second[wrong] = np.random.default_rng(2).uniform([800, 100], [1600, 1500], (wrong.sum(), 2))
    robust = estimate_fundamental(first, second, threshold_px=1.5)
    assert robust.fundamental is not None
    assert distance_px(robust.fundamental, limb_pair) < 0.2
    assert (robust.inliers & wrong).sum() < 0.02 * wrong.sum() + 3
    assert (robust.inliers & ~wrong).sum() > 0.97 * (~wrong).sum()


def test_the_seed_decides_the_samples(limb_pair: Any) -> None:
    first, second = limb_pair.noisy(SIGMA_PX)
    runs = [estimate_fundamental(first, second, seed=4).fundamental for _ in range(2)]
    np.testing.assert_array_equal(runs[0], runs[1])


def test_too_few_matches_give_nothing(limb_pair: Any) -> None:
    robust = estimate_fundamental(limb_pair.first[:7], limb_pair.second[:7])
    assert robust.fundamental is None
    assert not robust.inliers.any()


def test_gold_standard_bears_a_match_that_ran_away_to_infinity(limb_pair: Any) -> None:
    """So near that its place in the second photo no longer changes with its depth."""
    first, second = limb_pair.noisy(SIGMA_PX)
    projection = canonical_projection(limb_pair.fundamental)
    points = np.column_stack([first, np.full(len(first), 1e3)])
    points[5, 2] = 1e153
    given = np.hstack([first, second])
    equations = normal_equations(projection, points, given - np.hstack([first, second + 0.1]))
    assert equations.blocks[5, 2, 2] == 0.0
    by_projection, by_point = damped_step(equations, 1e-3)
    assert np.isfinite(by_projection).all()
    assert np.isfinite(by_point).all()


@pytest.mark.parametrize(
    ("model", "size"),
    [
        (
            _EssentialModel(
                Rigid.from_rotation_vector(np.array([0.1, -0.4, 0.2]), np.array([0.6, 0.64, 0.48])),
                FIRST_LENS,
                SECOND_LENS,
            ),
            5,
        ),
        (_Orthonormal(*np.linalg.svd(SECOND_LENS)[::2], 0.7), 7),
    ],
)
def test_derivatives_are_those_of_small_steps(model: Any, size: int) -> None:
    """Up to multiples of the matrix, which move no match."""
    steps = 1e-6 * np.eye(size)
    small = np.array([(model.moved(step).matrix - model.moved(-step).matrix) for step in steps])
    matrix = model.matrix.ravel() / np.linalg.norm(model.matrix)
    off = model.by_step.reshape(size, 9) - small.reshape(size, 9) / 2e-6
    off -= np.outer(off @ matrix, matrix)
    assert np.abs(off).max() < 1e-8 * np.abs(model.by_step).max()
