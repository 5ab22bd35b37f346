"""What equations say of unknowns some of which nothing is seen of."""

import numpy as np
import pytest

from limbgram.reconstruction.mapping.score_tests import NormalEquations, ScoreTest, pseudo_inverse


@pytest.mark.parametrize("weight", [0.0, -1e-9, 1e-300])
def test_an_unknown_that_rounding_leaves_no_weight_hides_nothing_of_the_others(
    weight: float,
) -> None:
    """Where photos of a burst stand in one place, some directions carry rounding alone."""
    root = np.random.default_rng(3).normal(size=(3, 3))
    normal, right = root @ root.T + np.eye(3), np.array([1.0, -2.0, 3.0])
    all_fall = float(right @ np.linalg.solve(normal, right))
    wider, longer = np.full((4, 4), 1e-7), np.append(right, 1e-6)
    wider[:3, :3], wider[3, 3] = normal, weight
    found = ScoreTest.of(NormalEquations(wider, longer))
    assert found.statistic == pytest.approx(all_fall, rel=1e-9)
    assert found.dof == 3
    inverse = pseudo_inverse(wider)
    np.testing.assert_allclose(inverse[:3, :3], np.linalg.inv(normal), rtol=1e-9)
    assert not inverse[3].any()
