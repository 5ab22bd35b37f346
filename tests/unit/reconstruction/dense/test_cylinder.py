"""Depth and cloud of a cylinder that is known by formula: bias and noise, both bounded."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from limbgram.core import run
from limbgram.core.errors import DenseError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Cloud
from limbgram.reconstruction.dense.depth import DepthMap
from limbgram.reconstruction.dense.estimation import estimate_depth
from limbgram.reconstruction.dense.fusion import LEAST_VIEWS, FusionOptions, fuse
from limbgram.reconstruction.dense.photo_depth import DenseOptions
from limbgram.reconstruction.mapping.scene import Observations

RADIUS_MM, PIXEL_MM, STEP_DEG = 40.0, 0.36, 12.0


@pytest.fixture(scope="module")
def depth_maps(painted: Any) -> tuple[DepthMap, ...]:
    return estimate_depth(painted.photos, painted.metric, painted.region)


@pytest.fixture(scope="module")
def cloud(painted: Any, depth_maps: tuple[DepthMap, ...]) -> Cloud:
    return fuse(painted.photos, painted.metric, depth_maps, painted.region)


def points_of(depth_map: DepthMap) -> tuple[np.ndarray, np.ndarray]:
    """World points and world normals of the measured pixels."""
    rows, columns = np.nonzero(np.isfinite(depth_map.depth_mm))
    xy = np.stack([columns + depth_map.x0, rows + depth_map.y0], 1).astype(float)
    rays = depth_map.camera.rays(xy)
    in_camera = rays / rays[:, 2:] * depth_map.depth_mm[rows, columns, None]
    pose = depth_map.camera_from_world
    return pose.inverse.apply(in_camera), depth_map.normal_in_camera[rows, columns] @ pose.rotation


def off_mm(points: np.ndarray) -> np.ndarray:
    return np.hypot(points[:, 0], points[:, 1]) - RADIUS_MM


def frontal(points: np.ndarray) -> np.ndarray:
    """Seen by several photos, away from top and bottom."""
    angle = np.degrees(np.arctan2(points[:, 1], points[:, 0]))
    return (np.abs(angle) < 40) & (np.abs(points[:, 2]) < 25)


def test_depth_is_right_to_a_fraction_of_a_pixel(depth_maps: tuple[DepthMap, ...]) -> None:
    assert len(depth_maps) == 7
    points, normals = map(np.concatenate, zip(*map(points_of, depth_maps)))
    error = off_mm(points[frontal(points)])
    assert 0.01 * PIXEL_MM < error.std() < 0.35 * PIXEL_MM
    assert abs(np.median(error)) < 0.08 * PIXEL_MM
    outward = points * (1, 1, 0) / np.hypot(points[:, 0], points[:, 1])[:, None]
    assert np.percentile((normals * outward).sum(1), 5) > np.cos(np.radians(20))


def test_the_cloud_covers_the_cylinder_evenly_and_lies_on_it(cloud: Cloud) -> None:
    points = cloud.points_mm.astype(float)
    error = off_mm(points[frontal(points)])
    assert 0.001 < np.sqrt((error**2).mean()) < 0.2 * PIXEL_MM
    assert abs(error.mean()) < 0.06 * PIXEL_MM
    angle, z = np.meshgrid(np.radians(np.linspace(-38, 38, 60)), np.linspace(-24, 24, 50))
    surface = np.stack([RADIUS_MM * np.cos(angle), RADIUS_MM * np.sin(angle), z], -1).reshape(-1, 3)
    gaps = np.linalg.norm(surface[:, None] - points[None], axis=2).min(1)
    assert np.percentile(gaps, 99) < 1.1 * cloud.spacing_mm
    outward = points * (1, 1, 0) / np.hypot(points[:, 0], points[:, 1])[:, None]
    assert np.percentile((cloud.normals * outward).sum(1), 5) > np.cos(np.radians(10))
    assert cloud.views.min() >= LEAST_VIEWS


def test_curvature_is_put_back(
    painted: Any, depth_maps: tuple[DepthMap, ...], cloud: Cloud
) -> None:
    """Flat windows sink by mean curvature times their squared reach: known, so undone."""
    flat = [replace(depth_map, window_px2=0.0) for depth_map in depth_maps]
    sunk = fuse(painted.photos, painted.metric, flat, painted.region).points_mm
    lifted = cloud.points_mm
    by = off_mm(lifted[frontal(lifted)]).mean() - off_mm(sunk[frontal(sunk)]).mean()
    place_mm = PIXEL_MM * 1000 / depth_maps[0].camera.fx
    expected = depth_maps[0].window_px2 * place_mm**2 / (2 * RADIUS_MM)
    assert 0.8 * expected < by < 1.6 * expected


def test_colours_are_those_of_the_paint(cloud: Cloud) -> None:
    seen = cloud.colours.astype(float)
    assert np.ptp(seen, axis=1).max() <= 1
    assert seen.std() > 15
    assert abs(seen.mean() - 128) < 8


def test_half_a_pixel_from_photo_to_photo_moves_the_surface_as_geometry_says(
    capture_of: Callable[..., Any], depth_maps: tuple[DepthMap, ...]
) -> None:
    drift_px = 0.5
    drifting = capture_of(drift_px=drift_px)
    maps = estimate_depth(drifting.photos, drifting.metric, drifting.region)
    right, _ = points_of(depth_maps[3])
    wrong, _ = points_of(maps[3])
    strip = [points[np.abs(points[:, 1]) < 10] for points in (right, wrong)]
    moved = np.median(off_mm(strip[1])) - np.median(off_mm(strip[0]))
    expected = drift_px * PIXEL_MM / np.tan(np.radians(STEP_DEG))
    assert 0.7 * expected < abs(moved) < 1.3 * expected


def test_the_number_of_threads_changes_nothing(
    painted: Any, depth_maps: tuple[DepthMap, ...], cloud: Cloud, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run, "worker_count", lambda: 3)
    again = estimate_depth(painted.photos, painted.metric, painted.region)
    for first, second in zip(depth_maps, again):
        assert first.depth_mm.tobytes() == second.depth_mm.tobytes()
        assert first.normal_in_camera.tobytes() == second.normal_in_camera.tobytes()
    fused = fuse(painted.photos, painted.metric, again, painted.region)
    assert fused.points_mm.tobytes() == cloud.points_mm.tobytes()


def test_reduced_photos_give_the_same_surface(painted: Any) -> None:
    """A reduction that is no whole number keeps pixel centres too."""
    options = DenseOptions(most_px=80_000)
    maps = estimate_depth(painted.photos, painted.metric, painted.region, options)
    factor = maps[0].camera.fx / 1000
    assert 0.2 < factor < 0.42
    points = np.concatenate([points_of(depth_map)[0] for depth_map in maps])
    sunk = maps[0].window_px2 * (PIXEL_MM / factor) ** 2 / (2 * RADIUS_MM)
    error = np.median(off_mm(points[frontal(points)])) + sunk
    assert abs(error) < 0.1 * PIXEL_MM / factor


def test_an_unpainted_sock_is_refused(capture_of: Callable[..., Any]) -> None:
    bare = capture_of(painted=False)
    with pytest.raises(DenseError, match="unpainted"):
        estimate_depth(bare.photos, bare.metric, bare.region)


def test_a_photo_without_neighbours_is_left_out(painted: Any) -> None:
    """The last photo is put behind the cylinder, where no other one sees the same side."""
    scene = painted.metric.scene
    pose = Rigid.looking_at(np.array([-400.0, 0, 0]), np.zeros(3), np.array([0.0, 0, 1]))
    seen = scene.observations.photo_idx != 6
    observations = Observations(
        scene.observations.photo_idx[seen],
        scene.observations.point_idx[seen],
        scene.observations.xy_px[seen],
    )
    poses = (*scene.camera_from_world[:6], pose)
    turned = replace(scene, camera_from_world=poses, observations=observations)
    maps = estimate_depth(painted.photos, replace(painted.metric, scene=turned), painted.region)
    assert [depth_map.photo_idx for depth_map in maps] == [0, 1, 2, 3, 4, 5]


def test_empty_depth_maps_are_refused(painted: Any, depth_maps: tuple[DepthMap, ...]) -> None:
    empty = [replace(m, depth_mm=np.full_like(m.depth_mm, np.nan)) for m in depth_maps]
    with pytest.raises(DenseError, match="Paint"):
        fuse(painted.photos, painted.metric, empty, painted.region)


def test_what_two_photos_agree_on_but_the_others_see_through_is_no_surface(
    painted: Any, depth_maps: tuple[DepthMap, ...]
) -> None:
    flap_mm = 6.0
    false = tuple(
        _with_flap(depth_map, RADIUS_MM + flap_mm) if k in (2, 4) else depth_map
        for k, depth_map in enumerate(depth_maps)
    )
    planted = [points_of(one)[0] for one in (false[2], false[4])]
    pixels = (1000 / false[2].camera.fx) ** 2  # of a place
    assert pixels * min((off_mm(points) > flap_mm - 1).sum() for points in planted) > 100
    crumbs_stay = FusionOptions(least_share=0.0)
    cloud = fuse(painted.photos, painted.metric, false, painted.region, crumbs_stay)
    assert np.abs(off_mm(cloud.points_mm.astype(float))).max() < flap_mm / 2


def _with_flap(depth_map: DepthMap, x_mm: float) -> DepthMap:
    """The map with a square of 5 mm before the cylinder, facing the arc's middle."""
    pose = depth_map.camera_from_world
    height, width = depth_map.depth_mm.shape
    column, row = np.meshgrid(np.arange(width), np.arange(height))
    xy = np.stack([column + depth_map.x0, row + depth_map.y0], -1).reshape(-1, 2).astype(float)
    rays = depth_map.camera.rays(xy)
    rays = rays / rays[:, 2:]
    along = rays @ pose.rotation
    depth_mm = (x_mm - pose.centre[0]) / along[:, 0]
    hit = pose.centre + depth_mm[:, None] * along
    on_flap = (np.abs(hit[:, 1:]) < 2.5).all(1).reshape(height, width)
    depths, normals = depth_map.depth_mm.copy(), depth_map.normal_in_camera.copy()
    depths[on_flap] = depth_mm.reshape(height, width)[on_flap]
    normals[on_flap] = pose.rotation @ np.array([1.0, 0.0, 0.0])
    return replace(depth_map, depth_mm=depths, normal_in_camera=normals)
