"""Crops ready to interpolate: what their coefficients say at pixels, and where pixels lie."""

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.measuring.imagery import Crop, _block_sums, build_imagery

CAMERA = Camera(width_px=300, height_px=300, fx=900.0, fy=900.0, cx=149.5, cy=149.5)
VIEW = View("", CAMERA, Rigid.identity())


def spline_at_pixels(coefficients: np.ndarray) -> np.ndarray:
    """Cubic B-spline at its own pixels: weights 1, 4, 1 over 6 each way, mirrored at the edges."""
    for axis in range(2):
        wide = np.pad(coefficients, [(1, 1) if k == axis else (0, 0) for k in range(2)], "reflect")
        low, high = np.delete(wide, [-1, -2], axis), np.delete(wide, [0, 1], axis)
        coefficients = (low + 4 * coefficients + high) / 6
    return coefficients


@pytest.mark.parametrize("halvings", [0, 1, 2])
def test_coefficients_interpolate_means_of_pixels(halvings: int) -> None:
    random = np.random.default_rng(halvings)
    photos = [random.integers(0, 256, shape).astype(np.uint8) for shape in ((45, 34), (24, 51))]
    crops = [
        Crop(
            x0=8 * k,
            y0=16,
            pixels=_block_sums(pixels, halvings) if halvings else pixels,
            halvings=halvings,
        )
        for k, pixels in enumerate(photos)
    ]
    imagery = build_imagery(crops, [VIEW, VIEW])
    side = 2**halvings
    assert imagery.factor == 1 / side
    end = 0
    for k, pixels in enumerate(photos):
        start, x0, y0, width, height = imagery.crops[k].tolist()
        assert (start, x0, y0) == (end, 8 * k, 16)
        assert (height, width) == (pixels.shape[0] // side, pixels.shape[1] // side)
        end = start + width * height
        blocks = pixels[: height * side, : width * side].astype(float)
        means = blocks.reshape(height, side, width, side).mean((1, 3))
        found = imagery.coefficients[start:end].reshape(height, width).astype(float)
        np.testing.assert_allclose(spline_at_pixels(found), means, atol=1e-3)
    assert end == len(imagery.coefficients)


def test_sums_are_exact() -> None:
    white = np.full((32, 48), 255, np.uint8)
    np.testing.assert_array_equal(_block_sums(white, 4), np.full((2, 3), 255 * 256))
