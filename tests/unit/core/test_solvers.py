"""The small solvers against LAPACK."""

import numpy as np
import pytest

from limbgram.core.solvers import adjugate, invert_symmetric, solve_positive


def positive(size: int, seed: int) -> np.ndarray:
    rows = np.random.default_rng(seed).normal(size=(3 * size, size))
    return rows.T @ rows


@pytest.mark.parametrize("seed", range(5))
def test_the_inverse_and_the_adjugate_are_the_matrixs(seed: int) -> None:
    matrix, inverse = positive(3, seed), np.empty((3, 3))
    assert invert_symmetric(matrix, inverse)
    np.testing.assert_allclose(inverse @ matrix, np.eye(3), atol=1e-12)
    *cofactors, determinant = adjugate(*matrix[np.triu_indices(3)])
    np.testing.assert_allclose(determinant, np.linalg.det(matrix), rtol=1e-12)
    expected = np.linalg.inv(matrix)[np.triu_indices(3)]
    np.testing.assert_allclose(np.array(cofactors) / determinant, expected, rtol=1e-9)


def test_a_singular_matrix_has_no_inverse() -> None:
    assert not invert_symmetric(np.outer([1.0, 2, 3], [1.0, 2, 3]), np.empty((3, 3)))


@pytest.mark.parametrize("size", [2, 6, 9])
def test_a_positive_system_is_solved(size: int) -> None:
    matrix, right = positive(size, size), np.arange(1.0, size + 1)
    answer = np.empty(size)
    system = np.column_stack([np.triu(matrix), right])
    assert solve_positive(system, 0.0, answer)
    np.testing.assert_allclose(matrix @ answer, right, rtol=1e-10)


@pytest.mark.parametrize("matrix", [np.zeros((2, 2)), np.ones((2, 2)), np.diag([1.0, -1.0])])
def test_a_system_that_determines_nothing_is_refused(matrix: np.ndarray) -> None:
    system = np.column_stack([np.triu(matrix), np.ones(2)])
    assert not solve_positive(system, 1e-12, np.empty(2))
    assert not solve_positive(np.full((2, 3), np.nan), 0.0, np.empty(2))
