"""Lengths at the smoothing length against closed forms."""

import math

import numpy as np
import pytest
from scipy.special import ellipe

from limbgram.core.geometry.smoothed_length import (
    SMOOTHING_MM,
    smoothed_length,
    taut_length,
)


def ring(radius_mm: float, wave_mm: float, height_mm: float, count: int = 20000) -> np.ndarray:
    """A circle that carries a wave of some length and height (from its middle)."""
    angles = 2 * np.pi * np.arange(count) / count
    waves = round(2 * np.pi * radius_mm / wave_mm)
    radii = radius_mm + height_mm * np.cos(waves * angles)
    return radii[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])


def stays(wave_mm: float) -> float:
    """Of a wave's height."""
    return 1 / (1 + (SMOOTHING_MM / wave_mm) ** 4)


@pytest.mark.parametrize("radius_mm", [10.0, 50.0])
def test_a_circle_keeps_its_length(radius_mm: float) -> None:
    points = ring(radius_mm, 10.0, 0.0)
    for found in (smoothed_length(points, closed=True), taut_length(points)):
        assert found.value_mm == pytest.approx(2 * math.pi * radius_mm, rel=1e-4)
        assert found.along_mm.sum() == pytest.approx(found.value_mm, abs=1e-9)


@pytest.mark.parametrize("wave_mm", [2.0, 3.0, 5.0, 10.0, 20.0])
def test_a_wave_lengthens_a_contour_by_what_stays_of_its_slope(wave_mm: float) -> None:
    """By a quarter of its squared slope; a knit of 2 mm, 0.1 mm high, by 0.001 of 1.9 mm.

    A wave of 20 mm bends the circle as well, which is 4 % of it.
    """
    slope = 0.05 * 2 * math.pi / wave_mm
    more = smoothed_length(ring(50.0, wave_mm, 0.05), closed=True).value_mm
    more -= smoothed_length(ring(50.0, wave_mm, 0.0), closed=True).value_mm
    assert more == pytest.approx(
        100 * math.pi * (slope * stays(wave_mm)) ** 2 / 4, rel=0.04, abs=6e-4
    )


@pytest.mark.parametrize("finer", [2, 5])
def test_the_length_does_not_depend_on_how_finely_a_knit_is_drawn(finer: int) -> None:
    coarse, fine = (
        smoothed_length(ring(50.0, 2.0, 0.05, count), closed=True).value_mm
        for count in (1600, 1600 * finer)
    )
    assert fine == pytest.approx(coarse, abs=2e-3)


def test_a_straight_way_stays_and_so_do_the_ends_of_a_wavy_one() -> None:
    straight = np.linspace([0, 0, 0], [30.0, 40, 0], 77)
    assert smoothed_length(straight, closed=False).value_mm == pytest.approx(50, abs=1e-9)
    assert smoothed_length(straight[[0, -1]], closed=False).value_mm == pytest.approx(50, abs=1e-9)
    at = np.linspace(0, 100, 8001)
    for wave_mm in (2.0, 5.0, 10.0):
        way = np.column_stack([at, 0.05 * np.sin(2 * np.pi * at / wave_mm), 0 * at])
        more = smoothed_length(way, closed=False).value_mm - 100
        slope = 0.05 * 2 * math.pi / wave_mm * stays(wave_mm)
        assert more == pytest.approx(100 * slope**2 / 4, rel=0.03, abs=1e-4)


def taut_mm(points: np.ndarray) -> float:
    """Of a closed outline, by Cauchy's formula: the mean width over all directions, times pi."""
    angles = np.linspace(0, 2 * np.pi, 2880, endpoint=False)
    reach = [(points @ [math.cos(angle), math.sin(angle)]).max() for angle in angles]
    return 2 * math.pi * float(np.mean(reach))


def test_a_tape_round_an_ellipse_is_as_long_as_the_ellipse() -> None:
    points = ring(1.0, 1.0, 0.0) * [60.0, 40.0]
    whole_mm = 4 * 60 * float(ellipe(1 - (40 / 60) ** 2))
    assert taut_length(points).value_mm == pytest.approx(whole_mm, rel=1e-5)


@pytest.mark.parametrize(
    ("wave_mm", "height_mm"), [(2.0, 0.05), (3.0, 0.03), (5.0, 0.05), (8.0, 0.1), (15.0, 0.3)]
)
def test_a_tape_over_a_ripple_rests_on_what_stays_of_it(wave_mm: float, height_mm: float) -> None:
    """On the tops of a knit of 2 mm, 0.1 mm high, it would read 0.31 mm more; 0.008 stays."""
    more = taut_length(ring(50.0, wave_mm, height_mm)).value_mm - 100 * math.pi
    stayed = taut_mm(ring(50.0, wave_mm, height_mm * stays(wave_mm))) - 100 * math.pi
    assert more == pytest.approx(stayed, rel=0.02, abs=1e-3)


def test_a_tape_spans_the_hollow_of_a_snail() -> None:
    """r = 50 + 35 cos: smooth, with a dent; no relief, so nothing of the bridge lies on it."""
    angles = np.linspace(0, 2 * np.pi, 20000, endpoint=False)
    snail = (50 + 35 * np.cos(angles))[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    found = taut_length(snail)
    assert found.value_mm == pytest.approx(taut_mm(snail), rel=1e-5)
    # The dent's leftmost points: x = r cos is least where cos = -50 / 70.
    lip = math.acos(-50 / 70)
    bridge_mm = 2 * (50 + 35 * math.cos(lip)) * math.sin(lip)
    assert found.along_mm.sum() == pytest.approx(found.value_mm - bridge_mm, abs=0.5)
    assert found.along_mm[np.abs(angles - math.pi) < math.pi - lip - 0.05].max() == 0.0


def test_a_tape_spans_a_horseshoe() -> None:
    """Half rings of 40 and 20 mm, legs of 30 mm, round ends: a tape goes straight across 60 mm."""

    def arc(centre_mm: tuple[float, float], radius_mm: float, start: float, turn: float):
        angles = math.pi * np.linspace(start, start + turn, 4000)
        return centre_mm + radius_mm * np.column_stack([np.cos(angles), np.sin(angles)])

    horseshoe = np.concatenate(
        [
            arc((0.0, 0.0), 40.0, 1.0, 1.0),
            arc((30.0, 30.0), 10.0, 0.0, 1.0),
            arc((0.0, 0.0), 20.0, 2.0, -1.0),
            arc((-30.0, 30.0), 10.0, 0.0, 1.0),
        ]
    )
    found = taut_length(horseshoe)
    assert found.value_mm == pytest.approx(50 * math.pi + 60 + 60, abs=0.01)
    inside = (np.hypot(*horseshoe.T) < 25) & (horseshoe[:, 1] < 25)
    assert np.abs(found.slopes[inside]).max() < 1e-6


def test_slopes_of_a_tape_are_what_moving_the_points_does() -> None:
    """Of a rough outline with a hollow, by central differences."""
    rng = np.random.default_rng(5)
    angles = np.sort(rng.uniform(0, 2 * np.pi, 400))
    points = (50 + 35 * np.cos(angles))[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    points += rng.normal(0, 0.1, points.shape)
    told = taut_length(points)
    for move in rng.standard_normal((4, *points.shape)):
        values = [taut_length(points + step * move).value_mm for step in (-1e-6, 1e-6)]
        assert (told.slopes * move).sum() == pytest.approx((values[1] - values[0]) / 2e-6, rel=1e-4)


@pytest.mark.parametrize("closed", [True, False])
def test_slopes_are_what_moving_the_points_does(closed: bool) -> None:
    """Of uneven, rough points, and along the line too: by central differences."""
    rng = np.random.default_rng(3)
    angles = np.sort(rng.uniform(0, 2 * np.pi, 400))
    points = np.column_stack([50 * np.cos(angles), 40 * np.sin(angles), 9 * np.cos(3 * angles)])
    points += rng.normal(0, 0.05, points.shape)
    if not closed:
        points = points[:250]
    told = smoothed_length(points, closed=closed)
    moved = rng.standard_normal((4, *points.shape))
    for move in moved:
        values = [
            smoothed_length(points + step * move, closed=closed).value_mm for step in (-1e-6, 1e-6)
        ]
        assert (told.slopes * move).sum() == pytest.approx((values[1] - values[0]) / 2e-6, rel=1e-4)
