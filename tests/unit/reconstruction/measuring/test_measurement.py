"""What of a rim is believed."""

import numpy as np
import scipy.sparse as sp

from limbgram.core.mesh.topology import find_edges
from limbgram.reconstruction.measuring.measurement import confirmed_patches

ROWS, COLUMNS, EDGE = 24, 30, 8
"""A tube of which rows from 8 on show the limb."""


def _neighbours() -> sp.csr_matrix:
    """Round a tube, two triangles a square; six neighbours round a vertex."""
    first = np.arange((ROWS - 1) * COLUMNS).reshape(ROWS - 1, COLUMNS)
    ahead = np.roll(first, -1, axis=1)
    below, across = first + COLUMNS, ahead + COLUMNS
    triangles = np.stack([first, ahead, across, first, across, below], -1)
    ends = find_edges(triangles.reshape(-1, 3).astype(np.int32)).ends
    size = (ROWS * COLUMNS, ROWS * COLUMNS)
    one_way = sp.csr_matrix((np.ones(len(ends)), tuple(ends.T)), shape=size)
    return sp.csr_matrix(one_way + one_way.T)


def _alike(past: dict[tuple[int, int], float], at_edge: float) -> np.ndarray:
    alike = np.zeros((ROWS, COLUMNS), np.float32)
    alike[EDGE:] = np.linspace(0.9, 1.0, (ROWS - EDGE) * COLUMNS).reshape(-1, COLUMNS)
    alike[EDGE] = at_edge
    for place, value in past.items():
        alike[place] = value
    return alike.ravel()


def test_a_tongue_that_is_alike_by_chance_goes_and_the_last_row_stays() -> None:
    """Patches of the last row hang over the edge: they are less alike, and stand together."""
    tongue = {(7, 12): 0.8, (6, 12): 0.7, (6, 11): 0.65, (5, 11): 0.7, (3, 20): 0.66}
    rim = np.arange(ROWS * COLUMNS) < 16 * COLUMNS
    counts = confirmed_patches(_neighbours(), _alike(tongue, at_edge=0.75), rim).reshape(
        ROWS, COLUMNS
    )
    assert not counts[:EDGE].any()
    assert counts[EDGE].all()
    assert counts[EDGE + 1 :].all()


def test_what_is_as_alike_as_the_limb_stays_by_itself() -> None:
    """Between dabs of sparse paint a patch may stand alone."""
    rim = np.arange(ROWS * COLUMNS) < 16 * COLUMNS
    counts = confirmed_patches(_neighbours(), _alike({(5, 11): 0.97}, at_edge=0.95), rim)
    assert counts.reshape(ROWS, COLUMNS)[5, 11]


def test_with_nothing_but_a_rim_every_believed_patch_counts() -> None:
    everywhere = np.ones(ROWS * COLUMNS, bool)
    alike = _alike({(5, 11): 0.62}, at_edge=0.75)
    np.testing.assert_array_equal(confirmed_patches(_neighbours(), alike, everywhere), alike > 0)
