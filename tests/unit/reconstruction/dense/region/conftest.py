"""A capsule on a stand, on a table with clutter before a wall, photographed from a ring."""

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.scale.metric import MetricScene, Scale

LENS = Camera(width_px=1200, height_px=800, fx=2750.0, fy=2750.0, cx=605.0, cy=395.0, k1=-0.1)
FOCUS = np.array([0.0, 0.0, 160.0])


def capsule(count: int, seed: int, centre: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """Points on an upright capsule: radius 50, from z = 40 to 290; denser on its wall."""
    draw = np.random.default_rng(seed)
    normals = draw.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    flat = normals[:, :2] / np.linalg.norm(normals[:, :2], axis=1, keepdims=True)
    wall = np.column_stack([50 * flat, draw.uniform(90, 240, count)])
    ends = np.where(normals[:, 2] > 0, 240.0, 90.0)
    caps = 50 * normals + np.column_stack([np.zeros((count, 2)), ends])
    points = np.where((draw.random(count) < 0.7)[:, None], wall, caps)
    return points + np.array([*centre, 0.0])


def plane(count: int, seed: int) -> np.ndarray:
    draw = np.random.default_rng(seed)
    return np.column_stack([draw.uniform(-350, 350, (count, 2)), draw.normal(0, 0.3, count)])


def clutter(seed: int) -> np.ndarray:
    """The skin of a box beside the capsule, 70 mm from it, and a wall far behind."""
    draw = np.random.default_rng(seed)
    box = draw.uniform((120, -30, 0), (180, 30, 60), (300, 3))
    side = draw.integers(3, size=300)
    low, high = np.array([120, -30, 0]), np.array([180, 30, 60])
    ends = np.where(draw.random(300) < 0.5, low[side], high[side])
    box[np.arange(300), side] = ends
    wall = draw.uniform((-900, 880, 0), (900, 900, 900), (500, 3))
    return np.concatenate([box, wall])


def ring(count: int) -> tuple[View, ...]:
    views = []
    for angle in 2 * np.pi * np.arange(count) / count:
        side = 1200 * np.array([np.sin(angle), -np.cos(angle), 0.0])
        pose = Rigid.looking_at(FOCUS + side + (0, 0, 700), FOCUS, np.array([0.0, 0.0, 1.0]))
        views.append(View(f"photo{len(views):02d}.jpg", LENS, pose))
    return tuple(views)


def metric_scene(views: tuple[View, ...], points: np.ndarray) -> MetricScene:
    """Each point is observed by the (up to) three nearest views in whose direction it faces."""
    centres = np.array([view.centre_in_world for view in views])
    outward = points * (1, 1, 0) + (0, 0, 40)
    toward = np.einsum("pk,vk->pv", outward, centres - FOCUS)
    nearest = np.argsort(-toward, axis=1)[:, :3]
    point_idx = np.repeat(np.arange(len(points), dtype=np.int32), 3)
    photo_idx = nearest.ravel().astype(np.int32)
    xy_px = np.zeros((len(photo_idx), 2))
    scene = Scene(
        names=tuple(view.name for view in views),
        cameras=(LENS,),
        camera_idx=(0,) * len(views),
        camera_from_world=tuple(view.camera_from_world for view in views),
        points_in_world=points,
        observations=Observations(photo_idx, point_idx, xy_px),
        verdicts=(),
    )
    scale = Scale(unit="mm", source="board", relative_sigma=1e-4)
    return MetricScene(scene=scene, scale=scale, floor_z_mm=0.0)


@pytest.fixture(scope="session")
def views() -> tuple[View, ...]:
    return ring(15)


@pytest.fixture(scope="session")
def metric(views: tuple[View, ...]) -> MetricScene:
    points = np.concatenate([capsule(2500, 1), plane(1500, 2), clutter(3)])
    stray = np.random.default_rng(4).uniform((-200, -200, 5), (200, 200, 350), (40, 3))
    return metric_scene(views, np.concatenate([points, stray]))
