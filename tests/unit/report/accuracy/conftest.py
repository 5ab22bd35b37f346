"""A small finished case whose errors are known: a tube, a ring of cameras, exact projections."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import LENS_SIZE, Camera
from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.mapping.scene import Observations, PhotoVerdict, Ring, Scene
from limbgram.reconstruction.measuring.uncertainty import SCALE
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.reconstruction.scale.metric import LengthCheck, MetricScene, Scale
from limbgram.report.accuracy.evidence import Evidence

LENS = Camera(width_px=1200, height_px=800, fx=1500.0, fy=1500.0, cx=599.5, cy=399.5)
PHOTOS = 12
DISTANCE_MM = 900.0
RADIUS_MM, HEIGHT_MM = 50.0, 240.0
NOISE_PX = 0.1
CHECK = LengthCheck(
    label="A-B",
    known_mm=120.0,
    measured_mm=120.06,
    sigma_mm=0.01,
    role="check",
    between="points",
    marks=(),
)
CONTROL = replace(CHECK, label="C-D", measured_mm=120.0, role="control")

MakeScene = Callable[..., Scene]


def tube(rings: int = 41, spokes: int = 64) -> Mesh:
    """An open tube about z, from z = 0."""
    azimuth = np.arange(spokes) * 2 * np.pi / spokes
    heights = np.linspace(0, HEIGHT_MM, rings)
    wall = np.empty((rings, spokes, 3))
    wall[..., 0], wall[..., 1] = RADIUS_MM * np.cos(azimuth), RADIUS_MM * np.sin(azimuth)
    wall[..., 2] = heights[:, None]
    grid = np.arange(rings * spokes, dtype=np.int32).reshape(rings, spokes)
    a, b = grid[:-1], np.roll(grid, -1, axis=1)[:-1]
    c, d = np.roll(grid, -1, axis=1)[1:], grid[1:]
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return Mesh(vertices_mm=wall.reshape(-1, 3), faces=np.ascontiguousarray(faces))


def poses() -> tuple[Rigid, ...]:
    middle = np.array([0.0, 0.0, HEIGHT_MM / 2])
    angles = np.arange(PHOTOS) * 2 * np.pi / PHOTOS
    centres = middle + DISTANCE_MM * np.stack(
        [np.cos(angles), np.sin(angles), np.full(PHOTOS, 0.0)], axis=1
    )
    return tuple(Rigid.looking_at(one, middle, np.array([0.0, 0.0, 1.0])) for one in centres)


@pytest.fixture
def make_scene() -> MakeScene:
    """A scene of points, each seen by the photos on its side, with Gaussian noise in the pixels."""

    def make(noise_px: float = NOISE_PX, count: int = 4000, seed: int = 3) -> Scene:
        rng = np.random.default_rng(seed)
        azimuth = rng.uniform(0, 2 * np.pi, count)
        points = np.stack(
            [
                RADIUS_MM * np.cos(azimuth),
                RADIUS_MM * np.sin(azimuth),
                rng.uniform(0, HEIGHT_MM, count),
            ],
            axis=1,
        )
        rows: list[np.ndarray] = []
        photos: list[np.ndarray] = []
        pixels: list[np.ndarray] = []
        for k, pose in enumerate(poses()):
            seen = np.flatnonzero(points[:, :2] @ pose.centre[:2] > 0.6 * RADIUS_MM * DISTANCE_MM)
            xy = LENS.project(pose.apply(points[seen]))
            rows.append(seen.astype(np.int32))
            photos.append(np.full(len(seen), k, np.int32))
            pixels.append(xy + noise_px * rng.normal(size=xy.shape))
        names = tuple(f"IMG_{k + 1}.jpg" for k in range(PHOTOS))
        covariance = np.zeros((1, LENS_SIZE, LENS_SIZE))
        covariance[0, 0, 0], covariance[0, 1, 1], covariance[0, 0, 1] = 0.04, 0.04, 0.02
        covariance[0, 1, 0] = 0.02
        return Scene(
            names=names,
            cameras=(LENS,),
            camera_idx=(0,) * PHOTOS,
            camera_from_world=poses(),
            points_in_world=points,
            observations=Observations(
                np.concatenate(photos), np.concatenate(rows), np.concatenate(pixels)
            ),
            verdicts=tuple(
                PhotoVerdict(name=name, placed=True, points=len(seen), rms_px=noise_px)
                for name, seen in zip(names, rows, strict=True)
            ),
            sigma_px=noise_px,
            lens_covariance=covariance,
            ring=Ring(largest_gap_deg=30.0, weakest_bridge=200, closed=True),
        )

    return make


@pytest.fixture
def evidence(make_scene: MakeScene) -> Evidence:
    """The whole case; its photos' files do not exist, its mesh carries no sigmas.

    The tube stands on the floor, so its one brim is the upper one.
    """
    scene = make_scene(count=1500)
    exif = Exif(make="Make", model="Model", focal_mm=50.0, subject_m=0.9)
    photos = tuple(
        Photo(
            name=name, path=Path("photos") / name, width_px=LENS.width_px,
            height_px=LENS.height_px, exif=exif, sha256="0" * 64, camera_idx=0, sharpness=0.9,
            burnt=0.0, brightest=200.0,
        )
        for name in scene.names
    )  # fmt: skip
    group = CameraGroup(label="Model", width_px=1200, height_px=800, exif=exif)
    covariance = np.zeros((LENS_SIZE, LENS_SIZE))
    covariance[0, 0] = covariance[1, 1] = 0.09
    given = Calibration(camera=LENS, covariance=covariance, source="board", label="Model")
    scale = Scale(unit="mm", source="distances", relative_sigma=0.0001, lengths=(CONTROL, CHECK))
    return Evidence(
        photos=PhotoSet(photos, (group,)),
        cameras=Cameras((given,)),
        detections=None,
        metric=MetricScene(scene=scene, scale=scale, floor_z_mm=0.0),
        mesh=tube(),
    )


@pytest.fixture
def with_sigmas(evidence: Evidence) -> Evidence:
    """Sigma 0.1 mm everywhere, 0.06 mm of it shared; poses with a covariance."""
    count = len(evidence.mesh)
    covariance = 1e-4 * np.eye(6 * PHOTOS + LENS_SIZE)
    scene = replace(evidence.metric.scene, camera_covariance=covariance)
    mesh = replace(
        evidence.mesh,
        sigma_mm=np.full(count, 0.1, np.float32),
        shared_mm=np.full((count, 1), 0.06, np.float32),
        shared_sources=(SCALE,),
        correlation_mm=2.0,
    )
    return replace(evidence, mesh=mesh, metric=replace(evidence.metric, scene=scene))
