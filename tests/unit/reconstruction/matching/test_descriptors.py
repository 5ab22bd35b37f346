"""Descriptor matching against the plain definition."""

import numpy as np
import pytest

from limbgram.reconstruction.matching.descriptors import (
    RotationBand,
    ScaleBand,
    comparable,
    match_descriptors,
)


def plain(first: np.ndarray, second: np.ndarray, allowed: np.ndarray, ratio: float) -> np.ndarray:
    """Nearest, clear and mutual, by the full matrix of distances."""
    distances = np.linalg.norm(first[:, None].astype(float) - second[None], axis=2)
    distances[~allowed] = 2.0
    order = np.argsort(distances, axis=1, kind="stable")
    rows = np.arange(len(first))
    best, second_best = distances[rows, order[:, 0]], distances[rows, order[:, 1]]
    mutual = distances.argmin(axis=0)[order[:, 0]] == rows
    kept = rows[(best < ratio * second_best) & mutual]
    return np.column_stack([kept, order[kept, 0]])


def described(count: int, size: int, seed: int) -> np.ndarray:
    rows = np.random.default_rng(seed).normal(size=(count, size)).astype(np.float32)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def copies(of: np.ndarray, seed: int) -> np.ndarray:
    noisy = of + 0.4 * described(len(of), of.shape[1], seed)
    return noisy / np.linalg.norm(noisy, axis=1, keepdims=True)


@pytest.mark.parametrize(
    ("first", "second", "size"), [(301, 457, 128), (130, 64, 48), (65, 129, 48), (3, 2, 16)]
)
def test_matches_are_nearest_clear_and_mutual(first: int, second: int, size: int) -> None:
    one, two = described(first, size, 1), described(second, size, 2)
    shared = min(first, second) // 2
    two[:shared] = copies(one[-shared:], 3) if shared else two[:shared]
    found = match_descriptors(one, two, 0.8)
    everything = np.ones((first, second), bool)
    np.testing.assert_array_equal(found, plain(one, two, everything, 0.8))
    assert len(found) >= 0.8 * shared


def test_a_band_leaves_out_keypoints_of_other_scale() -> None:
    scales = np.sort(np.random.default_rng(0).uniform(0, 5, 400))[::-1]
    scale_px = (2**scales).astype(np.float32)
    one = described(400, 128, 1)
    two = copies(one, 2)
    shifted = np.roll(two, 200, axis=0)  # true partners now differ much in scale
    band = ScaleBand(scale_px, scale_px, 1 / 1.3, 1.3)
    assert len(match_descriptors(one, two, 0.8, band)) > 390
    assert len(match_descriptors(one, shifted, 0.8)) > 390
    assert len(match_descriptors(one, shifted, 0.8, band)) < 20


def test_a_band_follows_the_change_of_scale_of_the_pair() -> None:
    scale_px = np.linspace(40, 1, 300, dtype=np.float32)
    one = described(300, 128, 1)
    two = copies(one, 2)
    band = ScaleBand(scale_px, 3 * scale_px, 3 / 1.2, 3 * 1.2)
    assert len(match_descriptors(one, two, 0.8, band)) > 290


@pytest.mark.parametrize("pair_deg", [0.0, 95.0, -170.0])
def test_a_turn_leaves_out_keypoints_that_turn_otherwise(pair_deg: float) -> None:
    rng = np.random.default_rng(4)
    one = described(600, 128, 1)
    two = copies(one, 2)
    first_deg = rng.uniform(0, 360, 600).astype(np.float32)
    off_deg = rng.uniform(-180, 180, 600)
    second_deg = np.mod(first_deg + pair_deg + off_deg, 360).astype(np.float32)
    found = match_descriptors(one, two, 0.8, None, RotationBand(first_deg, second_deg, pair_deg))
    matched = np.isin(np.arange(600), found[:, 0])
    assert (found[:, 0] == found[:, 1]).mean() > 0.95
    assert matched[np.abs(off_deg) < 40].all()
    assert not matched[np.abs(off_deg) > 60].any()
    assert 0 < matched[(np.abs(off_deg) > 40) & (np.abs(off_deg) < 60)].mean() < 1


def test_turn_and_band_together_find_what_both_allow() -> None:
    rng = np.random.default_rng(5)
    scale_px = np.sort(2 ** rng.uniform(0, 4, 500))[::-1].astype(np.float32)
    first_deg = rng.uniform(0, 360, 500).astype(np.float32)
    one = described(500, 128, 1)
    two = copies(one, 2)
    band = ScaleBand(scale_px, scale_px, 1 / 1.3, 1.3)
    turn = RotationBand(first_deg, np.mod(first_deg + 30, 360), 30.0)
    found = match_descriptors(one, two, 0.8, band, turn)
    assert len(found) > 490
    assert (found[:, 0] == found[:, 1]).mean() > 0.98


def test_bytes_compare_as_unit_vectors() -> None:
    rows = np.random.default_rng(0).integers(0, 120, (20, 128), dtype=np.uint8)
    rows[3] = 0
    units = comparable(rows)
    lengths = np.linalg.norm(units, axis=1)
    np.testing.assert_allclose(np.delete(lengths, 3), 1, rtol=1e-5)
    assert lengths[3] == 0


def test_nothing_matches_nothing() -> None:
    assert match_descriptors(described(1, 16, 0), described(50, 16, 1), 0.8).shape == (0, 2)
    assert match_descriptors(described(0, 16, 0), described(50, 16, 1), 0.8).shape == (0, 2)
