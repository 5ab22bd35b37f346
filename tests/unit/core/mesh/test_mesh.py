"""Figures of a mesh by its area."""

import numpy as np
import pytest

from limbgram.core.mesh.mesh import Mesh


def test_what_was_filled_counts_by_its_area() -> None:
    """A hole closed by one large triangle beside a hundred measured small ones."""
    small = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    large = np.array([[50.0, 0, 0], [60, 0, 0], [50, 10, 0]])
    places = [small + np.array([0.0, 2.0 * k, 0.0]) for k in range(100)]
    vertices_mm = np.concatenate([*places, large])
    faces = np.arange(len(vertices_mm), dtype=np.int32).reshape(-1, 3)
    mesh = Mesh(vertices_mm=vertices_mm, faces=faces)
    assert mesh.filled_share() == 0.0
    filled = Mesh(vertices_mm=vertices_mm, faces=faces, filled=np.arange(303) >= 300)
    assert filled.filled_share() == pytest.approx(0.5)
