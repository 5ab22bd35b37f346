"""Observations of a board by a known camera, without pictures."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.reconstruction.targets.board import Board, BoardDetections, PhotoCorners

TRUE = Camera(
    width_px=2000, height_px=1500, fx=3210.0, fy=3206.0, cx=1011.0, cy=741.0,
    k1=-0.11, k2=0.08, p1=0.0006, p2=-0.0004,
)  # fmt: skip
BOARD = Board.checkerboard("9x7", 10.0)
EXIF = Exif(make="Canon", model="Canon EOS 500D", lens="EF50mm f/1.8 II", focal_mm=50.0)


@pytest.fixture
def true_camera() -> Camera:
    return TRUE


@pytest.fixture(scope="session")
def capture() -> Callable[..., "Capture"]:
    return Capture


class Capture:
    """Photos of a board: `Capture(photos=12, noise_px=0.05, seed=0, tilt_deg=35, ...)`."""

    def __init__(
        self,
        *,
        photos: int = 12,
        noise_px: float = 0.05,
        seed: int = 0,
        tilt_deg: float = 35.0,
        spread: float = 1.0,
        distance: float = 1.0,
        camera: Camera = TRUE,
        corners_mm: np.ndarray | None = None,
        exif: Exif = EXIF,
    ) -> None:
        rng = np.random.default_rng(seed)
        printed = BOARD.corners_mm if corners_mm is None else corners_mm
        self.poses = tuple(_pose(rng, idx, tilt_deg, spread, distance) for idx in range(photos))
        seen = [
            _seen(f"photo{idx:02}.jpg", idx, camera, printed, pose, noise_px, rng)
            for idx, pose in enumerate(self.poses)
        ]
        self.detections = BoardDetections(
            board=BOARD, corners_mm=BOARD.corners_mm, photos=tuple(seen), set_aside=()
        )
        self.photos = PhotoSet(
            tuple(_photo(one.name, camera, exif) for one in seen),
            (
                CameraGroup(
                    label="", width_px=camera.width_px, height_px=camera.height_px, exif=exif
                ),
            ),
        )

    @property
    def arguments(self) -> tuple[Any, Any]:
        return self.photos, self.detections


def _pose(
    rng: np.random.Generator, idx: int, tilt_deg: float, spread: float, distance: float
) -> Rigid:
    """The board tilted to some side, turned by quarters, somewhere in the picture."""
    side = rng.uniform(0, 2 * np.pi)
    tilt = np.radians(tilt_deg) * rng.uniform(0.4, 1.0)
    tilted = Rigid.from_rotation_vector(
        tilt * np.array([np.cos(side), np.sin(side), 0.0]), np.zeros(3)
    )
    rolled = Rigid.from_rotation_vector(
        np.array([0.0, 0.0, idx % 4 * np.pi / 2 + rng.normal(0, 0.1)]), np.zeros(3)
    )
    distance_mm = distance * rng.uniform(250.0, 330.0)
    away = spread * rng.uniform(-0.14, 0.14, 2) * distance_mm
    middle = BOARD.corners_mm.mean(axis=0)
    centred = Rigid(np.eye(3), -middle)
    moved = Rigid(np.eye(3), np.array([away[0], 0.75 * away[1], distance_mm]))
    return moved @ tilted @ rolled @ centred


def _seen(
    name: str,
    idx: int,
    camera: Camera,
    printed: np.ndarray,
    pose: Rigid,
    noise_px: float,
    rng: np.random.Generator,
) -> PhotoCorners:
    xy_px = camera.project(pose.apply(printed)) + rng.normal(0.0, noise_px, (len(printed), 2))
    inside = np.flatnonzero(camera.contains(xy_px, 10.0)).astype(np.int32)
    return PhotoCorners(
        name=name,
        photo_idx=idx,
        ids=inside,
        xy_px=xy_px[inside],
        sigmas_px=np.full(len(inside), max(noise_px, 1e-3)),
        blur_px=1.0,
        step_px=100.0,
        doubtful_ids=np.zeros(0, np.int32),
        doubtful_xy_px=np.zeros((0, 2)),
        doubts=(),
    )


def _photo(name: str, camera: Camera, exif: Exif) -> Photo:
    return Photo(
        name=name,
        path=Path(name),
        width_px=camera.width_px,
        height_px=camera.height_px,
        exif=exif,
        sha256="",
        camera_idx=0,
    )
