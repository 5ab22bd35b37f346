"""The solver against a direct one."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from limbgram.reconstruction.measuring.thin_plate import solve

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
