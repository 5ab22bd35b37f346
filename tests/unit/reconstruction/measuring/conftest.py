"""A painted plane in a few photos, ready for the measuring kernels."""

from dataclasses import dataclass

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.measuring.imagery import Crop, Imagery, _block_sums, build_imagery

CAMERA = Camera(
    width_px=400, height_px=300, fx=1010.0, fy=1000.0, cx=199.0, cy=151.0, skew=0.7,
    k1=-0.12, k2=0.05, p1=1e-3, p2=-8e-4, k3=0.02,
)  # fmt: skip
DISTANCE_MM = 500.0
LEFT_PX, TOP_PX, SIDE_PX = 144, 96, 112
PHOTOS = 5


@dataclass(frozen=True)
class Painted:
    """The plane z = 0 in the world, its paint smooth and random."""

    views: list[View]
    imagery: Imagery


@pytest.fixture(scope="session")
def painted() -> Painted:
    """Five photos; each has its own exposure, and all have noise."""
    random = np.random.default_rng(5)
    waves = random.uniform(0.15, 0.8, (24, 2)) * random.choice([-1, 1], (24, 2))
    phases = random.uniform(0, 2 * np.pi, 24)
    y, x = np.mgrid[TOP_PX : TOP_PX + SIDE_PX, LEFT_PX : LEFT_PX + SIDE_PX].astype(float)
    views, crops = [], []
    for k in range(PHOTOS):
        azimuth, slant = 2 * np.pi * k / PHOTOS, np.radians(30.0 + 5.0 * k)
        away = [np.sin(slant) * np.cos(azimuth), np.sin(slant) * np.sin(azimuth), np.cos(slant)]
        eye = DISTANCE_MM * np.array(away)
        view = View(f"{k}", CAMERA, Rigid.looking_at(eye, np.zeros(3), np.array([0.1, 1.0, 0.0])))
        rays = CAMERA.rays(np.column_stack([x.ravel(), y.ravel()]))
        rays = rays @ view.camera_from_world.rotation
        on_plane = eye - rays * (eye[2] / rays[:, 2])[:, None]
        paint = np.sin(on_plane[:, :2] @ waves.T + phases).sum(1).reshape(x.shape)
        grey = (100 + 10 * k) + (7 + k) * paint + random.normal(0, 1.0, x.shape)
        pixels = np.clip(np.rint(grey), 0, 255).astype(np.uint8)
        views.append(view)
        halved = Crop(x0=LEFT_PX // 2, y0=TOP_PX // 2, pixels=_block_sums(pixels, 1), halvings=1)
        crops.append(halved)
    imagery = build_imagery(crops, views)
    return Painted(views, imagery)
