"""Footprints and depth bounds of a region, against its own points."""

import numpy as np
import pytest

from limbgram.core.geometry.lens import View
from limbgram.reconstruction.dense.region import Region, footprint


def ball() -> Region:
    """A ball of radius 60 about (0, 0, 160) in cubes of 4 mm."""
    centres = np.stack(np.meshgrid(*[np.arange(-78, 79, 4.0)] * 3, indexing="ij"), -1)
    occupied = np.linalg.norm(centres, axis=-1) <= 60
    return Region(origin_mm=np.array([-80.0, -80.0, 80.0]), cell_mm=4.0, occupied=occupied)


@pytest.mark.parametrize("factor", [1.0, 0.5, 0.125])
def test_points_of_the_region_lie_in_mask_and_bounds(
    views: tuple[View, ...], factor: float
) -> None:
    region = ball()
    draw = np.random.default_rng(1)
    points = draw.uniform((-70, -70, 90), (70, 70, 230), (20000, 3))
    points = points[region.contains(points)]
    for view in views[:3]:
        found = footprint(region, view, factor)
        camera = view.camera.scaled(factor)
        in_camera = view.camera_from_world.apply(points)
        column, row = np.round(camera.project(in_camera)).astype(int).T
        row, column = row - found.y0, column - found.x0
        assert found.mask[row, column].all()
        assert np.all(found.near_mm[row, column] <= in_camera[:, 2])
        assert np.all(found.far_mm[row, column] >= in_camera[:, 2])


def test_footprint_is_hardly_larger_than_the_region(views: tuple[View, ...]) -> None:
    """A ball of 60 mm at 1389 mm shows a disc of 119 px at full size; a cube is 8 px wide."""
    found = footprint(ball(), views[0], 1.0)
    radius_px = 2750 * 60 / np.sqrt(1200**2 + 700**2)
    assert np.pi * radius_px**2 < found.mask.sum() < np.pi * (radius_px + 12) ** 2
    assert np.nanmax(found.far_mm - found.near_mm) < 120 + 2 * 4 * np.sqrt(3)
    assert np.isnan(found.near_mm[~found.mask]).all()


def test_a_region_out_of_sight_has_no_pixels(views: tuple[View, ...]) -> None:
    region = ball()
    behind = Region(
        origin_mm=region.origin_mm + 3 * views[0].centre_in_world,
        cell_mm=4.0,
        occupied=region.occupied,
    )
    assert footprint(behind, views[0]).mask.size == 0


def test_contains_and_box_agree_with_the_cubes() -> None:
    region = ball()
    low, high = region.box_mm
    np.testing.assert_allclose(low, [-60, -60, 100])
    np.testing.assert_allclose(high, [60, 60, 220])
    points = np.array([[0.0, 0, 160], [0, 0, 300], [-81, 0, 160], [0, 0, 100.5], [0, 0, 99.5]])
    np.testing.assert_array_equal(region.contains(points), [True, False, False, True, False])
