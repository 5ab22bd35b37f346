"""The sub-pixel fit against crossings that are known exactly."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from limbgram.reconstruction.targets.corners import CornerFits, fit_corners

SIDES_PX = np.array([[[28.0, 5.0], [-9.0, 24.0]]])
SIZE_PX, FINE = 64, 8


def crossing(centre_px: np.ndarray, blur_px: float, gamma: float = 1.0) -> np.ndarray:
    """Two blurred edges along SIDES_PX through a point, integrated over each pixel's area."""
    steps = (np.arange(SIZE_PX * FINE) + 0.5) / FINE - 0.5
    offsets = np.stack(np.meshgrid(steps, steps), axis=-1) - centre_px
    u, v = np.moveaxis(offsets @ np.linalg.inv(SIDES_PX[0]), -1, 0)
    light = gaussian_filter(np.where(u * v > 0, 0.05, 0.75), blur_px * FINE, mode="nearest")
    light = light.reshape(SIZE_PX, FINE, SIZE_PX, FINE).mean(axis=(1, 3))
    return 255.0 * light**gamma


def noisy(grey: np.ndarray, noise: float, seed: int) -> np.ndarray:
    drawn = grey + np.random.default_rng(seed).normal(0.0, noise, grey.shape)
    return np.clip(np.round(drawn), 0, 255).astype(np.uint8)


def fit(luma: np.ndarray, start_px: np.ndarray, reach: float = 0.45) -> CornerFits:
    return fit_corners(luma, start_px[None], SIDES_PX, reach)


@pytest.mark.parametrize("gamma", [1.0, 1 / 2.2])
@pytest.mark.parametrize("blur_px", [0.5, 1.0, 2.5])
def test_a_crossing_is_found_from_a_pixel_away_whatever_blur_and_gamma(
    blur_px: float, gamma: float
) -> None:
    centre = np.array([31.37, 30.81])
    found = fit(noisy(crossing(centre, blur_px, gamma), 0.0, 0), centre + np.array([1.0, -0.8]))
    assert np.abs(found.xy_px[0] - centre).max() < 0.02


def test_blur_and_contrast_are_those_of_the_picture() -> None:
    centre = np.array([31.4, 31.8])
    found = fit(noisy(crossing(centre, 1.5), 0.0, 0), centre)
    assert found.blur_px[0] == pytest.approx(np.hypot(1.5, 1 / np.sqrt(12)), rel=0.05)
    assert found.contrast[0] == pytest.approx(255 * 0.35, rel=0.03)


def test_errors_are_as_large_as_their_sigmas_say() -> None:
    centre = np.array([31.37, 30.81])
    grey = crossing(centre, 1.0)
    ratios: list[np.ndarray] = []
    for seed in range(60):
        found = fit(noisy(grey, 6.0, seed), centre + np.array([0.3, 0.2]))
        ratios.append((found.xy_px[0] - centre) / found.sigma_px[0])
    spread = float(np.sqrt(np.mean(np.square(ratios))))
    assert 0.75 < spread < 1.35


def test_a_wider_window_is_more_precise() -> None:
    centre = np.array([31.37, 30.81])
    luma = noisy(crossing(centre, 1.0), 6.0, 1)
    assert fit(luma, centre, 0.45).sigma_px[0] < 0.8 * fit(luma, centre, 0.2).sigma_px[0]


def test_a_window_cut_by_the_border_gives_no_corner() -> None:
    centre = np.array([8.0, 31.0])
    assert np.isnan(fit(noisy(crossing(centre, 1.0), 0.0, 0), centre).xy_px).all()


def test_what_is_no_crossing_does_not_look_like_one() -> None:
    noise = np.random.default_rng(0).integers(0, 255, (SIZE_PX, SIZE_PX)).astype(np.uint8)
    found = fit(noise, np.array([31.0, 31.0]))
    assert np.isnan(found.misfit[0]) or found.misfit[0] > 0.35
