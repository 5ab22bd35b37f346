"""Levels of values on a grid."""

import numpy as np
import pytest

from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.isosurface import level_surface
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    is_edge_manifold,
    is_vertex_manifold,
    volume_mm3,
)


def test_a_ball_is_where_it_is_as_large_as_it_is_and_looks_outwards() -> None:
    places = np.moveaxis(np.indices((44, 44, 44)), 0, -1) * 0.5
    middle = np.array([11.3, 10.6, 10.9])
    values = 8.0 - np.linalg.norm(places - middle, axis=-1)
    origin = np.array([100.0, -20.0, 7.0])
    ball = level_surface(values, origin, 0.5)
    away = np.linalg.norm(ball.vertices_mm - origin - middle, axis=1)
    assert abs(away - 8).max() < 0.15 * 0.5 * np.sqrt(3) + 0.01
    assert volume_mm3(ball) == pytest.approx(4 / 3 * np.pi * 8**3, rel=0.01)


def test_noise_becomes_a_closed_manifold_that_does_not_pass_through_itself() -> None:
    values = np.full((14, 15, 16), -1.0)
    values[1:-1, 1:-1, 1:-1] = np.random.default_rng(5).normal(size=(12, 13, 14))
    found = level_surface(values, np.zeros(3), 1.0)
    assert is_edge_manifold(found.faces)
    assert is_vertex_manifold(found.faces)
    assert not len(boundary_half_edges(found.faces))
    every = np.ones(len(found.faces), np.bool_)
    assert not len(find_crossings(found.vertices_mm, found.faces, every))
