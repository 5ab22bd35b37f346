"""Spots of one photo, from pixels that lie in a plane."""

import numpy as np

from limbgram.workbench.marks.pixels import ColouredPixels
from limbgram.workbench.marks.spots import spots_of

PIXEL_MM = 0.5


def seen(hue_rad: np.ndarray) -> ColouredPixels:
    """A plane of square pixels; NaN where nothing is coloured."""
    at = np.argwhere(np.isfinite(hue_rad)).astype(np.int32)
    count = len(at)
    return ColouredPixels(
        shape=(hue_rad.shape[0], hue_rad.shape[1]),
        at=at,
        hue_rad=hue_rad[at[:, 0], at[:, 1]].astype(np.float32),
        saturation=np.ones(count, np.float32),
        colours=np.full((count, 3), 200, np.uint8),
        points_mm=np.column_stack([PIXEL_MM * at[:, ::-1], np.zeros(count)]).astype(np.float32),
        areas_mm2=np.full(count, PIXEL_MM**2, np.float32),
    )


def disc(hue_rad: np.ndarray, middle: tuple[int, int], radius_px: float, hue: float) -> None:
    rows, columns = np.indices(hue_rad.shape)
    hue_rad[np.hypot(rows - middle[0], columns - middle[1]) <= radius_px] = hue


def test_each_hue_has_its_own_disc() -> None:
    picture = np.full((60, 90), np.nan)
    disc(picture, (20, 20), 8, 1.0)
    disc(picture, (30, 60), 12, 2.0)
    first, second = spots_of([seen(picture)], np.array([2.0, 1.0, -2.0]), 2)
    np.testing.assert_allclose(first.spots.middles_mm, [[30.0, 15.0, 0.0]], atol=1e-5)
    np.testing.assert_allclose(second.spots.middles_mm, [[10.0, 10.0, 0.0]], atol=1e-5)
    np.testing.assert_allclose(first.spots.diameters_mm, 12.0, rtol=0.02)
    np.testing.assert_allclose(first.spots.pixels_mm, PIXEL_MM)
    assert first.inside_mm2 == first.total_mm2 > second.total_mm2 > 0


def test_a_patch_of_two_hues_on_either_side_of_the_one_looked_for_is_none() -> None:
    picture = np.full((40, 40), np.nan)
    picture[10:30, 10:20] = np.radians(-15.0)
    picture[10:30, 20:30] = np.radians(15.0)
    (found,) = spots_of([seen(picture)], np.array([0.0]), 1)
    assert len(found.spots.middles_mm) == 0
    assert (found.inside_mm2, found.total_mm2) == (0.0, 0.0)
