"""What chance makes of few pairs is not kept, and what was done to them is."""

import numpy as np
import pytest

from limbgram.workbench.templates.learning import robust_mean, significant_nodes

HEIGHTS, ANGLES = 24, 40
SPACING_MM = 5.0
RADIUS_MM = ANGLES * SPACING_MM / (2 * np.pi)
LEAST_MM = 0.1


def nodes_mm() -> np.ndarray:
    """Of a small limb with a rounded tip, on the first of whose heights all nodes are one place."""
    along = SPACING_MM * np.arange(HEIGHTS)[:, None]
    bend = np.minimum(along / RADIUS_MM, np.pi / 2)
    height = np.where(bend < np.pi / 2, RADIUS_MM * (1 - np.cos(bend)), along - 0.57 * RADIUS_MM)
    angles = 2 * np.pi * np.arange(ANGLES) / ANGLES
    radius = RADIUS_MM * np.sin(bend)
    parts = np.broadcast_arrays(radius * np.sin(angles), radius * np.cos(angles), height)
    return np.stack(parts, axis=-1)


def ripples(seed: int, pairs: int) -> np.ndarray:
    """0.4 mm RMS on every pair, waves in all directions, none alike."""
    dice = np.random.default_rng(seed)
    fields = []
    for _ in range(pairs):
        waves, phases = dice.normal(0, 1 / 25, (12, 3)), dice.uniform(0, 2 * np.pi, 12)
        fields.append(0.4 * np.sqrt(2 / 12) * np.cos(nodes_mm() @ waves.T + phases).sum(-1))
    return np.stack(fields)


def kept_of(fields: np.ndarray) -> np.ndarray:
    mean, _ = robust_mean(fields)
    return significant_nodes(fields, 0.05) & (np.abs(mean) >= LEAST_MM)


@pytest.mark.parametrize("pairs", [3, pytest.param(5, marks=pytest.mark.slow)])
def test_chance_alone_is_kept_for_no_more_than_one_limb_of_twenty(pairs: int) -> None:
    """Twelve limbs: one may be, by the promise itself (46 % of such twelves have one or more)."""
    seeds = range(100, 112)
    assert sum(kept_of(ripples(seed, pairs)).any() for seed in seeds) <= 1


@pytest.mark.parametrize("pairs", [3, 5])
def test_a_relief_of_six_millimetres_is_found_and_nothing_beside_it(pairs: int) -> None:
    square = ((nodes_mm() - [0.0, RADIUS_MM, 60.0]) ** 2).sum(-1)
    relief_mm = -6 * np.exp(-square / (2 * 16.0**2))
    found = [kept_of(relief_mm + ripples(seed, pairs)) for seed in range(3)]
    core, outside = relief_mm < -4, relief_mm > -0.05
    assert min(kept[core].mean() for kept in found) > 0.8
    assert sum((kept & outside).sum() for kept in found) <= 0.05 * sum(k.sum() for k in found)


def test_what_one_pair_knows_is_kept_and_what_none_knows_is_not() -> None:
    alone = ripples(0, 1)
    alone[0, 0] = np.nan
    np.testing.assert_array_equal(significant_nodes(alone, 0.05), np.isfinite(alone[0]))
    pairs = 5 + ripples(1, 3)
    pairs[:, -2:] = np.nan
    pairs[0, :4] = np.nan
    kept = significant_nodes(pairs, 0.05)
    assert kept[:-3].mean() > 0.9
    assert not kept[-1].any()
