"""A small scene whose truth is a formula: a painted cylinder before an arc of cameras."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.dense.region import Region
from limbgram.reconstruction.mapping.scene import Observations, PhotoVerdict, Scene
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene, Scale

RADIUS_MM, HALF_HEIGHT_MM, DISTANCE_MM, STEP_DEG = 40.0, 30.0, 400.0, 12.0
CAMERA = Camera(width_px=250, height_px=200, fx=1000, fy=1000, cx=126.3, cy=98.4, k1=-0.2, p1=0.001)
PIXEL_MM = (DISTANCE_MM - RADIUS_MM) / CAMERA.fx
PHOTOS = 7


@dataclass(frozen=True)
class Capture:
    photos: PhotoSet
    metric: MetricScene
    region: Region


@pytest.fixture(scope="session")
def capture_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Capture]:
    def make(*, painted: bool = True, drift_px: float = 0.0) -> Capture:
        """`drift_px`: each photo shows everything this much further to the right than the last."""
        folder = tmp_path_factory.mktemp("cylinder")
        views = [_view(k) for k in range(PHOTOS)]
        photos = [_photograph(folder, k, views[k], painted, drift_px) for k in range(PHOTOS)]
        group = CameraGroup(label="", width_px=250, height_px=200, exif=Exif())
        return Capture(PhotoSet(tuple(photos), (group,)), _metric(views), _region())

    return make


@pytest.fixture(scope="session")
def painted(capture_of: Callable[..., Capture]) -> Capture:
    return capture_of()


def _view(k: int) -> View:
    angle = np.radians(STEP_DEG * (k - PHOTOS // 2))
    centre = np.array([DISTANCE_MM * np.cos(angle), DISTANCE_MM * np.sin(angle), 15.0 * (k % 2)])
    pose = Rigid.looking_at(centre, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    return View(f"P{k}.png", CAMERA, pose)


def _photograph(folder: Path, k: int, view: View, painted: bool, drift_px: float) -> Photo:
    grey = np.mean(
        [_shade(view, i, j, painted, drift_px * k) for i in (-1, 0, 1) for j in (-1, 0, 1)], axis=0
    )
    grey += np.random.default_rng(k).normal(0, 1.0, grey.shape)
    path = folder / view.name
    cv2.imwrite(str(path), np.clip(np.rint(grey), 0, 255).astype(np.uint8))
    return Photo(
        name=view.name, path=path, width_px=250, height_px=200, exif=Exif(), sha256="", camera_idx=0
    )


def _shade(view: View, i: int, j: int, painted: bool, shift_px: float) -> np.ndarray:
    """Grey of the sub-pixels (i, j): the ray meets the cylinder, the texture is a formula."""
    x, y = np.meshgrid(np.arange(250) + i / 3 - shift_px, np.arange(200) + j / 3)
    rays = view.camera.rays(np.stack([x, y], -1)) @ view.camera_from_world.rotation
    start = view.centre_in_world
    a = (rays[..., :2] ** 2).sum(-1)
    b = rays[..., :2] @ start[:2]
    inside = b * b - a * (start[:2] @ start[:2] - RADIUS_MM**2)
    hit = start + rays * ((-b - np.sqrt(np.maximum(inside, 0))) / a)[..., None]
    on_limb = (inside > 0) & (np.abs(hit[..., 2]) < HALF_HEIGHT_MM)
    return np.where(on_limb, _paint(hit) if painted else 150.0, 30.0)


def _paint(points: np.ndarray) -> np.ndarray:
    """Waves of 3 to 12 mm in all directions along the surface."""
    along = RADIUS_MM * np.arctan2(points[..., 1], points[..., 0])
    grey = np.full(along.shape, 128.0)
    rng = np.random.default_rng(5)
    for length in np.geomspace(3.0, 12.0, 16):
        turn, phase = rng.uniform(0, 2 * np.pi, 2)
        direction = np.cos(turn) * along + np.sin(turn) * points[..., 2]
        grey += 14 * np.sin(2 * np.pi * direction / length + phase)
    return grey


def _metric(views: list[View]) -> MetricScene:
    rng = np.random.default_rng(0)
    angle, z = rng.uniform(-1.2, 1.2, 400), rng.uniform(-HALF_HEIGHT_MM, HALF_HEIGHT_MM, 400)
    points = np.stack([RADIUS_MM * np.cos(angle), RADIUS_MM * np.sin(angle), z], 1)
    outward = points * (1, 1, 0) / RADIUS_MM
    facing = [((v.centre_in_world - points) * outward).sum(1) > 0.5 * DISTANCE_MM for v in views]
    photo_idx, point_idx = np.nonzero(facing)
    xy = np.concatenate([views[k].project(points[facing[k]]) for k in range(PHOTOS)])
    scene = Scene(
        names=tuple(view.name for view in views),
        cameras=(CAMERA,),
        camera_idx=(0,) * PHOTOS,
        camera_from_world=tuple(view.camera_from_world for view in views),
        points_in_world=points,
        observations=Observations(photo_idx.astype(np.int32), point_idx.astype(np.int32), xy),
        verdicts=tuple(
            PhotoVerdict(name=view.name, placed=True, points=100, rms_px=0.1) for view in views
        ),
    )
    return MetricScene(scene=scene, scale=Scale(unit="mm", source="board", relative_sigma=1e-4))


def _region() -> Region:
    """Cubes of 4 mm within 8 mm of the cylinder."""
    origin, cell = np.array([-60.0, -60.0, -32.0]), 4.0
    cells = np.indices((30, 30, 16)).reshape(3, -1).T
    centres = origin + cell * (cells + 0.5)
    near = np.abs(np.hypot(centres[:, 0], centres[:, 1]) - RADIUS_MM) < 8
    return Region(origin_mm=origin, cell_mm=cell, occupied=near.reshape(30, 30, 16))
