"""Volumes between heights against closed forms of the bodies as they are faceted."""

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from limbgram.core.errors import MeasureError
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.measures.levels import DISTAL_END, PROXIMAL_END, Sigmas, Volumes

N = 96
UNIT = 0.5 * N * math.sin(2 * math.pi / N)
"""Area of the regular polygon round the unit circle's corners."""
EXACT = 1e-9


def volumes(mesh: Mesh) -> Volumes:
    return Volumes.of(Sigmas.of(mesh))


def test_a_cylinder_between_any_two_heights(cylinder: Mesh) -> None:
    body = volumes(cylinder)
    for low, high in ((0, 200), (12.3, 188.8), (20, 25), (31.0, 31.5), (50, 10)):
        found = body.between(low, high).value
        assert found == pytest.approx(UNIT * 2500 * (high - low), rel=EXACT)
    assert body.between(DISTAL_END, PROXIMAL_END).value == pytest.approx(UNIT * 500_000, rel=EXACT)
    assert body.between(DISTAL_END, 33).value == pytest.approx(UNIT * 2500 * 33, rel=EXACT)


def test_a_cone_is_cut_to_frusta(make_turned: Callable[..., Mesh]) -> None:
    body = volumes(make_turned(np.array([60.0, 20.0]), np.array([0.0, 160.0]), N))
    for low, high in ((0, 160), (3, 97), (80, 81)):
        a, b = (60 - 40 * z / 160 for z in (low, high))
        true = UNIT * (high - low) * (a * a + a * b + b * b) / 3
        assert body.between(low, high).value == pytest.approx(true, rel=EXACT)


def test_an_ellipsoid_far_from_the_axis(make_turned: Callable[..., Mesh]) -> None:
    heights = np.linspace(-100, 100, 41)
    radii = 70 * np.sqrt(np.maximum(1 - (heights / 100) ** 2, 1e-4))
    body = make_turned(radii, heights, N, squeeze=0.6)
    body = body.with_vertices(body.vertices_mm + np.array([300, -200, 0]))
    low, high = -61.0, 43.0
    fine = np.unique(
        [*np.linspace(low, high, 60_001), *heights[(heights > low) & (heights < high)]]
    )
    r = np.interp(fine, heights, radii)
    pieces = np.diff(fine) * (r[1:] ** 2 + r[1:] * r[:-1] + r[:-1] ** 2) / 3
    true = 0.6 * UNIT * pieces.sum()
    assert volumes(body).between(low, high).value == pytest.approx(true, rel=EXACT)


def test_parts_add_up_to_the_whole_body_by_tetrahedra(make_turned: Callable[..., Mesh]) -> None:
    rng = np.random.default_rng(2)
    body = make_turned(50 + 6 * np.sin(np.arange(21)), np.linspace(0, 100, 21), 32)
    rough = body.with_vertices(body.vertices_mm + rng.normal(0, 0.4, body.vertices_mm.shape))
    a, b, c = (rough.vertices_mm[rough.faces[:, k]] for k in range(3))
    whole = float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6
    cuts = [DISTAL_END, 7.0, 7.5, 50.1, 93.0, PROXIMAL_END]
    parts = [volumes(rough).between(x, y).value for x, y in pairwise(cuts)]
    assert sum(parts) == pytest.approx(whole, rel=EXACT)
    assert min(parts) > 0


def test_an_open_brim_above_the_heights_does_not_matter(
    make_turned: Callable[..., Mesh],
) -> None:
    tube = make_turned(np.full(5, 50.0), np.linspace(0, 100, 5), N, capped=False)
    assert volumes(tube).between(10, 90).value == pytest.approx(UNIT * 2500 * 80, rel=EXACT)
    assert volumes(tube).between(0, 100).value == pytest.approx(UNIT * 2500 * 100, rel=EXACT)
    with pytest.raises(MeasureError, match=r"open there, from 0\.00 to 100\.00"):
        volumes(tube).between(DISTAL_END, PROXIMAL_END)


def test_a_hole_between_the_heights_is_an_error(cylinder: Mesh) -> None:
    whole = replace(cylinder, faces=cylinder.faces[1:])  # a face of the lowest ring is gone
    assert volumes(whole).between(10, 90).value == pytest.approx(UNIT * 2500 * 80, rel=EXACT)
    with pytest.raises(MeasureError, match="open"):
        volumes(whole).between(2, 90)


def test_a_height_beyond_the_limb_is_an_error(cylinder: Mesh) -> None:
    for ends in ((-1, 20), (20, 201), (math.nan, 20)):
        with pytest.raises(MeasureError, match=r"reaches from 0\.00 to 200\.00"):
            volumes(cylinder).between(*ends)


def test_slopes_are_what_moving_the_vertices_does(make_turned: Callable[..., Mesh]) -> None:
    rng = np.random.default_rng(5)
    body = make_turned(50 + 6 * np.sin(np.arange(21)), np.linspace(0, 100, 21), 32, squeeze=0.8)
    rough = body.with_vertices(body.vertices_mm + rng.normal(0, 0.4, body.vertices_mm.shape))
    normals, push = rough.vertex_normals(), rng.standard_normal(len(rough))
    told = float(volumes(rough).gradient(17.3, 64.4) @ push)
    step = 1e-5
    values = [
        volumes(rough.with_vertices(rough.vertices_mm + sign * step * push[:, None] * normals))
        .between(17.3, 64.4)
        .value
        for sign in (-1, 1)
    ]
    assert abs(told) > 1
    assert told == pytest.approx((values[1] - values[0]) / (2 * step), rel=1e-5)


def test_an_even_shift_of_the_wall_changes_volume_by_its_area(cylinder: Mesh) -> None:
    gradient = volumes(cylinder).gradient(50, 150)
    wall = 2 * N * 50 * math.sin(math.pi / N) * 100
    assert gradient.sum() == pytest.approx(wall * math.cos(math.pi / N), rel=1e-3)
