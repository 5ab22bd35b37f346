"""Calibration against known cameras: made up, rendered, and calibrated by others."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import HELD, PARAMETERS, Camera
from limbgram.reconstruction.calibration.board import (
    BoardCalibration,
    CalibrationOptions,
    calibrate_detections,
)
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.targets.board import Board, BoardDetections, PhotoCorners
from limbgram.reconstruction.targets.board_detection import find_board

FLAT = CalibrationOptions(board_gain=2.0)
FREE = [PARAMETERS.index(name) for name in PARAMETERS if name not in HELD]
TRUE = Camera(
    width_px=2400, height_px=1600, fx=5500.0, fy=5498.0, cx=1211.0, cy=781.0,
    k1=-0.09, k2=0.05, p1=0.0004, p2=-0.0003,
)  # fmt: skip


def made_up(seed: int, noise_px: float) -> tuple[PhotoSet, BoardDetections]:
    """Twelve hand-held photos of a board by TRUE."""
    rng = np.random.default_rng(seed)
    board = Board.checkerboard("10x7", 10.0)
    middle = board.corners_mm.mean(axis=0)
    corners, photos = [], []
    for idx in range(12):
        turn = np.append(rng.uniform(-0.5, 0.5, 2), idx % 4 * np.pi / 2)
        away = np.append(rng.uniform(-20, 20, 2), rng.uniform(420, 520))
        pose = Rigid.from_rotation_vector(turn, np.zeros(3))
        pose = Rigid(pose.rotation, away - pose.rotation @ middle)
        xy_px = TRUE.project(pose.apply(board.corners_mm))
        xy_px = xy_px + rng.normal(0, noise_px, xy_px.shape)
        name = f"{idx:02}.jpg"
        corners.append(
            PhotoCorners(
                name=name,
                photo_idx=idx,
                ids=np.arange(len(xy_px), dtype=np.int32),
                xy_px=xy_px,
                sigmas_px=np.full(len(xy_px), noise_px),
                blur_px=1.0,
                step_px=100.0,
                doubtful_ids=np.zeros(0, np.int32),
                doubtful_xy_px=np.zeros((0, 2)),
                doubts=(),
            )
        )
        photos.append(
            Photo(
                name=name,
                path=Path(name),
                width_px=2400,
                height_px=1600,
                exif=Exif(),
                sha256="",
                camera_idx=0,
            )
        )
    group = CameraGroup(label="", width_px=2400, height_px=1600, exif=Exif())
    return PhotoSet(tuple(photos), (group,)), BoardDetections(
        board=board, corners_mm=board.corners_mm, photos=tuple(corners), set_aside=()
    )


@pytest.mark.slow
def test_errors_are_as_large_as_the_sigmas_say() -> None:
    ratios, sigma0s = [], []
    for seed in range(24):
        result = calibrate_detections(*made_up(seed, 0.1))
        off = result.calibration.camera.packed - TRUE.packed
        ratios.append(off[FREE] / result.calibration.sigmas[FREE])
        sigma0s.append(result.sigma0_px)
    spread = np.sqrt(np.mean(np.square(ratios), axis=0))
    assert 0.75 < np.sqrt(np.mean(np.square(ratios))) < 1.15
    assert (spread > 0.45).all()
    assert (spread < 1.6).all()
    assert np.mean(sigma0s) == pytest.approx(0.1, rel=0.02)


class Real:
    """Real or rendered photos of a board, with the corners found in them."""

    def __init__(self, data_folder: Path, pattern: str, size: str, square_mm: float) -> None:
        self.photos = read_photos(sorted(data_folder.glob(pattern)))
        self.corners = find_board(self.photos, Board.checkerboard(size, square_mm))

    def calibrated(self, options: CalibrationOptions | None = None) -> BoardCalibration:
        return calibrate_detections(self.photos, self.corners, options or CalibrationOptions())

    def opencv_rms_px(self, used: BoardCalibration) -> float:
        """OpenCV's RMS on the corners that `used` kept, with the parameters that it freed."""
        flags = 0 if used.k3_delivered else cv2.CALIB_FIX_K3
        camera = used.calibration.camera
        return cv2.calibrateCamera(
            [self.corners.corners_mm[one.ids].astype(np.float32) for one in used.photos],
            [one.xy_px.astype(np.float32).reshape(-1, 1, 2) for one in used.photos],
            (camera.width_px, camera.height_px),
            np.eye(3),
            np.zeros(5),
            flags=flags,
        )[0]


BOARDS = [
    ("calibration/opencv/left*.jpg", "9x6", 25.0, 13),
    ("calibration/opencv/right*.jpg", "9x6", 25.0, 13),
    ("calibration/boofcv/Sony*/*.jpg", "6x4", 30.0, 13),
    ("calibration/boofcv/stereo*/left*.jpg", "6x4", 30.0, 11),
    ("calibration/boofcv/stereo*/right*.jpg", "6x4", 30.0, 11),
    ("calibration/udacity_wide/images/*.jpg", "8x6", 25.0, 33),
]


@pytest.mark.parametrize(("pattern", "size", "square_mm", "usable"), BOARDS)
def test_the_fit_is_no_worse_than_opencvs_on_the_same_corners(
    data_folder: Path, pattern: str, size: str, square_mm: float, usable: int
) -> None:
    real = Real(data_folder, pattern, size, square_mm)
    flat = real.calibrated(FLAT)
    assert len(flat.photos) >= usable
    rms_px = real.opencv_rms_px(flat)
    assert 0.98 * rms_px < flat.calibration.rms_px < 1.0001 * rms_px
    assert 0.01 < real.calibrated().calibration.rms_px < flat.calibration.rms_px


REFERENCES = [
    ("Sony*", "", [701.0117, 698.6538, 308.4552, 246.8430], (-0.255592, 0.099971)),
    ("stereo*", "left", [524.6142, 526.9202, 312.4509, 247.4016], (-0.362537, 0.175328)),
    ("stereo*", "right", [526.4373, 528.6525, 318.4041, 245.9350], (-0.353000, 0.162974)),
]


@pytest.mark.parametrize(("folder", "start", "pinhole", "radial"), REFERENCES)
def test_references_made_from_the_same_photos_are_met(
    data_folder: Path,
    folder: str,
    start: str,
    pinhole: list[float],
    radial: tuple[float, float],
) -> None:
    """BoofCV's, by a flat board and other corners; as uncertain as ours where nothing is said."""
    real = Real(data_folder, f"calibration/boofcv/{folder}/{start}*.jpg", "6x4", 30.0)
    found = real.calibrated(FLAT).calibration
    rows = [0, 1, 2, 3, 5, 6]
    off = found.camera.packed[rows] - np.array([*pinhole, *radial])
    assert (np.abs(off) < 3 * np.sqrt(2) * found.sigmas[rows]).all()
    assert (found.sigmas[:2] < 0.01 * found.camera.fx).all()


@pytest.mark.parametrize("name", ["limb_ring15", "foot_ring24"])
def test_rendered_cameras_are_met_within_their_sigmas(data_folder: Path, name: str) -> None:
    real = Real(data_folder, f"rendered/{name}/calibration/*.jpg", "14x10", 10.0)
    truth = json.loads((data_folder / "rendered" / name / "truth" / "cameras.json").read_text())
    lens, result = truth["intrinsics"], real.calibrated()
    exact = np.array([lens[key] for key in ("fx", "fy", "cx", "cy")])
    off = result.calibration.camera.packed[:4] - exact
    assert len(result.photos) == 18
    assert (np.abs(off) < 3 * result.calibration.sigmas[:4]).all()
    assert np.abs(off[:2]).max() < 1e-4 * exact[0]
    assert np.abs(off[2:]).max() < 0.5
    assert (result.calibration.sigmas[:4] < 0.5).all()
    assert abs(result.aspect.value - 1.0) < 4 * result.aspect.sigma
    assert abs(result.skew.value) < 4 * result.skew.sigma
    assert result.board_shape is None
