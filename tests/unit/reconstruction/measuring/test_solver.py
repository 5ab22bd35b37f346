"""The solver against a direct one."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from limbgram.reconstruction.measuring.thin_plate import solve, solve_all

COUNT = 400


def test_the_solution_meets_its_tolerance() -> None:
    rng = np.random.default_rng(3)
    bending = sp.diags([1.0, -2.0, 1.0], [-1, 0, 1], (COUNT, COUNT)).tocsr()
    system = sp.csr_matrix(30 * bending.T @ bending + sp.diags(rng.uniform(0.5, 2, COUNT)))
    truth = rng.standard_normal(COUNT)
    right = system @ truth
    found = solve(system, right, np.zeros(COUNT))
    assert np.linalg.norm(system @ found - right) <= 1.01e-3 * np.linalg.norm(right)
    direct = np.asarray(spsolve(system.tocsc(), right))
    np.testing.assert_allclose(direct, truth, atol=1e-9)
    # No eigenvalue is below a half, so no error is above twice the residual.
    assert np.linalg.norm(found - direct) <= 2.02e-3 * np.linalg.norm(right)


def test_a_solved_start_stays() -> None:
    system = sp.csr_matrix(sp.diags(np.full(COUNT, 2.0)))
    right = np.arange(COUNT, dtype=float)
    np.testing.assert_array_equal(solve(system, right, right / 2), right / 2)


def test_right_sides_together_are_solved_as_each_alone() -> None:
    """Of six one is nothing and one is easy: they end sooner and then stay."""
    rng = np.random.default_rng(4)
    bending = sp.diags([1.0, -2.0, 1.0], [-1, 0, 1], (COUNT, COUNT)).tocsr()
    system = sp.csr_matrix(30 * bending.T @ bending + sp.diags(rng.uniform(0.5, 2, COUNT)))
    rights = list(rng.standard_normal((6, COUNT)))
    rights[1] = np.zeros(COUNT)
    rights[2] = np.where(np.arange(COUNT) == 3, 1.0, 0.0)
    together = solve_all(system, rights)
    for found, right in zip(together, rights, strict=True):
        alone = solve(system, right, right / system.diagonal())
        np.testing.assert_array_equal(found, alone)
    assert np.abs(together[2]).max() > 0.0
