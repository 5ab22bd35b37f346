"""Thinning and moving least squares on spheres and planes that are known by formula."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial import KDTree

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.dense.depth import DepthMap
from limbgram.reconstruction.dense.fusion import (
    MeasuredPoints,
    hash_grid,
    point_visibility,
    points_in_cube,
    poisson_disk_thinned,
    project_to_surface,
)
from limbgram.reconstruction.mapping.scene import Observations, PhotoVerdict, Scene
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene, Scale

RADIUS_MM = 15.0


def sphere(count: int, noise_mm: float) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    outward = rng.normal(size=(count, 3))
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    points = outward * (RADIUS_MM + rng.normal(0, noise_mm, (count, 1)))
    tilted = outward + rng.normal(0, 0.1, (count, 3))
    tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
    return points.astype(np.float32), tilted.astype(np.float32)


def smoothed(
    points: np.ndarray, normals: np.ndarray, radius_mm: float, window_mm2: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    grid = hash_grid(points, radius_mm)
    points, normals = points[grid.order], normals[grid.order]
    seeds = np.arange(0, len(points), 7)
    moved, turned = np.zeros((2, len(seeds), 3), np.float32)
    ones = np.ones(len(points), np.float32)
    support = project_to_surface(
        MeasuredPoints(points, normals, ones, window_mm2 * ones),
        grid.cubes, radius_mm, 0.2, seeds, moved, turned,
    )  # fmt: skip
    assert (support > 0).mean() > 0.99
    return moved[support > 0], turned[support > 0]


@pytest.mark.parametrize("radius_mm", [1.5, 3.0])
def test_a_sphere_does_not_shrink(radius_mm: float) -> None:
    points, normals = sphere(40_000, 0.0)
    moved, turned = smoothed(points, normals, radius_mm)
    error = np.linalg.norm(moved, axis=1) - RADIUS_MM
    plane_would_sink = radius_mm**2 / (8 * RADIUS_MM)
    assert abs(error.mean()) < 0.06 * plane_would_sink
    cosine = (turned * moved).sum(1) / np.linalg.norm(moved, axis=1)
    assert np.degrees(np.arccos(np.clip(np.percentile(cosine, 5), -1, 1))) < 1.0


@pytest.mark.parametrize("photos", [255, 256, 300])
def test_hundreds_of_photos_are_counted(photos: int, tmp_path: Path) -> None:
    """One point lies on the wall that all of them show, the other floats in front of it."""
    cv2.imwrite(str(tmp_path / "P.png"), np.full((20, 20), 90, np.uint8))
    photo = Photo(
        name="P.png", path=tmp_path / "P.png", width_px=20, height_px=20, exif=Exif(), sha256="",
        camera_idx=0,
    )  # fmt: skip
    camera = Camera(width_px=20, height_px=20, fx=100.0, fy=100.0, cx=9.5, cy=9.5)
    scene = Scene(
        names=("P.png",),
        cameras=(camera,),
        camera_idx=(0,),
        camera_from_world=(Rigid.identity(),),
        points_in_world=np.zeros((0, 3)),
        observations=Observations(
            np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros((0, 2), float)
        ),
        verdicts=(PhotoVerdict(name="P.png", placed=True, points=0, rms_px=0.1),),
    )
    wall = DepthMap(
        photo_idx=0, camera=camera, camera_from_world=Rigid.identity(), x0=0, y0=0,
        depth_mm=np.full((20, 20), 100.0, np.float32),
        normal_in_camera=np.tile(np.array([0, 0, -1], np.float32), (20, 20, 1)),
        confidence=np.ones((20, 20), np.float32), window_px2=4.0,
    )  # fmt: skip
    points = np.array([[1.0, 1.0, 100.0], [-1.0, 0.0, 60.0]], np.float32)
    normals = np.array([[0, 0, -1], [0, 0, -1]], np.float32)
    metric = MetricScene(scene=scene, scale=Scale(unit="mm", source="board", relative_sigma=1e-4))
    group = CameraGroup(label="", width_px=20, height_px=20, exif=Exif())
    found = point_visibility(
        PhotoSet((photo,), (group,)), metric, [wall] * photos, points, normals, agree_mm=0.5
    )
    assert found.views.tolist() == [photos, 0]
    assert found.through.tolist() == [0, photos]
    np.testing.assert_array_equal(found.colours[0], 90)


def test_noise_is_averaged_and_no_more_than_statistics_allow() -> None:
    noise, radius_mm, count = 0.1, 2.0, 40_000
    points, normals = sphere(count, noise)
    moved, _ = smoothed(points, normals, radius_mm)
    error = np.linalg.norm(moved, axis=1) - RADIUS_MM
    neighbours = count * radius_mm**2 / (4 * RADIUS_MM**2)
    assert abs(error.mean()) < 0.05 * noise
    assert 0.5 * noise / np.sqrt(neighbours) < error.std() < 5 * noise / np.sqrt(neighbours)


def test_sunken_windows_are_lifted_by_their_curvature() -> None:
    points, normals = sphere(40_000, 0.0)
    still, _ = smoothed(points, normals, 2.0)
    lifted, _ = smoothed(points, normals, 2.0, window_mm2=0.9)
    by = np.linalg.norm(lifted, axis=1).mean() - np.linalg.norm(still, axis=1).mean()
    assert by == pytest.approx(0.9 / RADIUS_MM, rel=0.1)


def test_the_other_side_of_a_thin_plate_does_not_pull() -> None:
    rng = np.random.default_rng(2)
    flat = rng.uniform(-8, 8, (20_000, 2))
    upper = rng.random(20_000) < 0.5
    points = np.column_stack([flat, np.where(upper, 0.5, -0.5)]).astype(np.float32)
    normals = np.column_stack([0 * flat, np.where(upper, 1.0, -1.0)]).astype(np.float32)
    moved, turned = smoothed(points, normals, 2.0)
    np.testing.assert_allclose(np.abs(moved[:, 2]), 0.5, atol=1e-4)
    assert np.all(turned[:, 2] * moved[:, 2] > 0)


def test_thinned_points_keep_their_distance_and_leave_no_gap() -> None:
    points, _ = sphere(30_000, 0.0)
    grid = hash_grid(points, 2.0)
    points = points[grid.order]
    order = np.random.default_rng(0).permutation(len(points))
    kept = poisson_disk_thinned(points, order, grid.cubes, 1.5)
    tree = KDTree(points[kept])
    nearest = tree.query(points[kept], k=2)[0][:, 1]
    assert nearest.min() >= 1.5 - 1e-5
    assert tree.query(points)[0].max() < 1.5
    assert 0.5 < kept.sum() * 1.5**2 / (4 * np.pi * RADIUS_MM**2) < 1.1


def test_every_point_is_found_in_its_cube() -> None:
    points, _ = sphere(3_000, 0.0)
    grid = hash_grid(points, 1.0)
    cells = np.floor((points[grid.order] - grid.cubes.low_mm) / 1.0).astype(int)
    for k in range(0, 3_000, 37):
        first, last = points_in_cube.py_func(grid.cubes, *(int(i) for i in cells[k]))
        assert first <= k < last
        assert np.all(cells[first:last] == cells[k])
    assert points_in_cube.py_func(grid.cubes, 900, 900, 900) == (0, 0)
