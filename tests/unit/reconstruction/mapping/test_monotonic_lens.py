"""The monotonicity constraint of uncalibrated lenses, where its boundary is known by formula."""

import numpy as np
import pytest

from limbgram.core.geometry.lens import LENS_SIZE, PARAMETERS
from limbgram.reconstruction.mapping.monotonic_lens import MonotonicityConstraints

CORNER = float(np.hypot(799.5, 599.5)) / 1250.0
LENS = np.zeros(LENS_SIZE)
LENS[:4] = 1250.0, 1250.0, 799.5, 599.5
SIZE_PX = 1600, 1200


@pytest.mark.parametrize(
    ("name", "value", "boundary"),
    [
        ("k1", -0.9, -0.25 * (0.75 / CORNER) ** 2),  # 1 + 3 k1 r^2 = 1/4 where r (1 + k1 r^2) = c
        ("k2", -0.58, -0.15 * (0.85 / CORNER) ** 4),
        ("k3", -0.58, -0.75 / 7 * ((1 - 0.75 / 7) / CORNER) ** 6),
    ],
)
def test_a_step_is_held_where_the_corner_s_slope_is_a_quarter(
    name: str, value: float, boundary: float
) -> None:
    place, free = PARAMETERS.index(name), np.ones(LENS_SIZE, bool)
    step = np.zeros(LENS_SIZE)
    step[place] = value
    (held,) = MonotonicityConstraints((SIZE_PX,), free).violated_by(LENS, step)
    assert -held.violation / held.gradient[place] == pytest.approx(boundary, rel=1e-6)
    step[place] = 0.99 * boundary
    assert not MonotonicityConstraints((SIZE_PX,), free).violated_by(LENS, step)
    step[place] = value
    assert not MonotonicityConstraints((None,), free).violated_by(LENS, step), (
        "a board knows better"
    )
    assert not MonotonicityConstraints((SIZE_PX,), ~free).violated_by(LENS, step), (
        "it is held anyway"
    )


@pytest.mark.parametrize("radial", [(-0.3, 0.0), (0.2, -0.6), (-0.1, -0.3)])
def test_the_constraint_has_the_derivatives_of_the_corner_s_slope(
    radial: tuple[float, float],
) -> None:
    step = np.zeros(LENS_SIZE)
    step[5:7] = 3 * np.array(radial)
    constraints = MonotonicityConstraints((SIZE_PX,), np.ones(LENS_SIZE, bool))
    (held,) = constraints.violated_by(LENS, step)
    high = next(part for part in np.linspace(0, 1, 200) if _slope(LENS + part * step) < 0.25)
    low = 0.0
    for _ in range(50):  # where on its way the step meets the boundary
        middle = (low + high) / 2
        low, high = (middle, high) if _slope(LENS + middle * step) > 0.25 else (low, middle)
    at_boundary = LENS + high * step
    for place in (0, 1, 5, 6, 9):
        move = np.zeros(LENS_SIZE)
        move[place] = 1e-5 * max(1.0, LENS[place])
        expected = (_slope(at_boundary - move) - _slope(at_boundary + move)) / (2 * move[place])
        assert held.gradient[place] == pytest.approx(expected, rel=1e-3)


def test_only_lenses_that_do_not_show_their_corners_cost() -> None:
    constraints, folded = (
        MonotonicityConstraints((SIZE_PX, SIZE_PX), np.ones(2 * LENS_SIZE, bool)),
        LENS.copy(),
    )
    folded[6] = -0.58
    assert constraints.cost(np.concatenate([LENS, LENS])) == 0.0
    assert constraints.cost(np.concatenate([LENS, folded])) > 1e6


def _slope(lens: np.ndarray) -> float:
    """Of the ray that ends in the picture's corner, by Newton."""
    corner = np.hypot(799.5 / lens[0], 599.5 / lens[1])
    ray = corner
    for _ in range(100):
        square = ray * ray
        far = ray * (1 + square * (lens[5] + square * (lens[6] + square * lens[9])))
        slope = 1 + square * (3 * lens[5] + square * (5 * lens[6] + square * 7 * lens[9]))
        ray -= (far - corner) / slope
    return float(slope)
