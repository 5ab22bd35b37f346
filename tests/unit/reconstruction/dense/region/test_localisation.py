"""Finding the limb among table, clutter and wall, against the true capsule."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from limbgram.core.errors import OptionsError, RegionError
from limbgram.reconstruction.dense.region import Region, RegionOptions, find_region
from limbgram.reconstruction.photos.photo import Exif, Photo, PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene


def photo_set(metric: MetricScene, masks: dict | None = None) -> PhotoSet:
    photos = tuple(
        Photo(
            name=name,
            path=None,
            width_px=1200,
            height_px=800,
            exif=Exif(),
            sha256="",
            camera_idx=0,
            mask_path=(masks or {}).get(name),
        )
        for name in metric.scene.names
    )
    return PhotoSet(photos, ())


def with_points(metric: MetricScene, points: np.ndarray) -> MetricScene:
    return replace(metric, scene=replace(metric.scene, points_in_world=points))


def surface(region: Region) -> float:
    """Share of the true capsule inside the region."""
    height, angle = np.meshgrid(np.linspace(40, 290, 200), np.linspace(0, 2 * np.pi, 120))
    over = np.clip(height - 240, 0, None) + np.clip(90 - height, 0, None)
    radius = np.sqrt(np.maximum(2500 - over**2, 0))
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], -1)
    return float(region.contains(points.reshape(-1, 3)).mean())


def test_the_whole_limb_and_little_else_is_in_the_region(metric: MetricScene) -> None:
    region = find_region(photo_set(metric), metric)
    assert surface(region) >= 0.999
    low, high = region.box_mm
    assert np.all(low[:2] > -75)
    assert np.all(high[:2] < 75)
    assert 0 < low[2] < 40
    assert 290 < high[2] < 315
    rest = metric.scene.points_in_world[2500:4800]
    assert region.contains(rest).mean() < 0.01
    assert region.contains(np.array([[0.0, 0.0, 160.0]]))[0]


def test_nothing_below_the_floor_is_in_the_region(metric: MetricScene) -> None:
    raised = replace(metric, floor_z_mm=60.0)
    low, _ = find_region(photo_set(metric), raised).box_mm
    assert 60 - 4 < low[2] <= 60


def test_a_thin_patch_of_paint_does_not_cut_the_limb(metric: MetricScene) -> None:
    points = metric.scene.points_in_world
    patch = (np.abs(points[:, 2] - 200) < 17) & (points[:, 0] > 0)
    keep = ~patch | (np.random.default_rng(5).random(len(points)) < 0.05)
    region = find_region(photo_set(metric), with_points(metric, points[keep]))
    assert surface(region) >= 0.999


def test_two_like_objects_are_refused(metric: MetricScene) -> None:
    limb = metric.scene.points_in_world[:2500]
    aside = np.array([90.0, 0.0, 0.0])
    twins = np.concatenate([limb - aside, limb + aside])
    with pytest.raises(RegionError, match="Two objects"):
        find_region(photo_set(metric), with_points(metric, twins))


def test_a_sheet_is_no_limb(metric: MetricScene) -> None:
    flat = metric.scene.points_in_world * np.array([1.0, 1.0, 0.01]) + np.array([0.0, 0.0, 100.0])
    with pytest.raises(RegionError, match="flat"):
        find_region(photo_set(metric), with_points(metric, flat))


def test_too_few_points_are_refused(metric: MetricScene) -> None:
    few = metric.scene.points_in_world[:40]
    with pytest.raises(RegionError, match="Only 40 scene points"):
        find_region(photo_set(metric), with_points(metric, few))


def test_a_box_wins(metric: MetricScene) -> None:
    box = ((30.0, 20.0, 10.0), (-10.0, 100.0, 50.0))
    region = find_region(photo_set(metric), metric, RegionOptions(box_mm=box))
    low, high = region.box_mm
    np.testing.assert_allclose(low, (-10, 20, 10))
    np.testing.assert_allclose(high, (30, 100, 50))
    with pytest.raises(OptionsError, match="no volume"):
        find_region(photo_set(metric), metric, RegionOptions(box_mm=(box[0], box[0])))


def test_masks_win_over_what_the_cameras_aim_at(metric: MetricScene, tmp_path) -> None:
    """Masks of the box beside the limb: the region is the box, its floor included."""
    corners = np.array([(x, y, z) for x in (118, 182) for y in (-32, 32) for z in (-2, 62)], float)
    masks = {}
    for view in metric.scene.views:
        mask = np.zeros((800, 1200), np.uint8)
        outline = cv2.convexHull(np.round(view.project(corners)).astype(np.int32))
        cv2.fillConvexPoly(mask, outline, 255)
        masks[view.name] = tmp_path / f"{view.name}.png"
        cv2.imwrite(str(masks[view.name]), mask)
    region = find_region(photo_set(metric, masks), metric, RegionOptions())
    box = metric.scene.points_in_world[4000:4300]
    assert region.contains(box).mean() > 0.99
    assert not region.contains(metric.scene.points_in_world[:2500]).any()
    low, high = region.box_mm
    assert np.all(high - low < 80)
