"""Pictures of boards whose corners are known exactly."""

from collections.abc import Callable
from functools import cache

import cv2
import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.targets.board import Board

CAMERA = Camera(
    width_px=480, height_px=360, fx=600.0, fy=600.0, cx=234.3, cy=174.8, k1=-0.12, p1=0.0005
)
RAYS_A_SIDE = 3
"""Rays through each pixel, across and down."""

Painter = Callable[..., np.ndarray]


@pytest.fixture
def camera() -> Camera:
    return CAMERA


@pytest.fixture
def paint() -> Painter:
    """Photograph a board: `paint(board, camera_from_board, noise, seed)`."""

    def painted(board: Board, pose: Rigid, noise: float = 0.0, seed: int = 0) -> np.ndarray:
        texture, per_mm = _texture(board)
        directions = _rays() @ pose.rotation
        centre = pose.centre
        on_board = centre[:2] - centre[2] * directions[:, :2] / directions[:, 2:]
        where = ((on_board + board.square_mm) * per_mm - 0.5).astype(np.float32)
        side = RAYS_A_SIDE
        where = where.reshape(CAMERA.height_px * side, CAMERA.width_px * side, 2)
        fine = cv2.remap(
            texture, where[..., 0], where[..., 1], cv2.INTER_LINEAR, borderValue=(200.0,)
        )
        shape = (CAMERA.height_px, side, CAMERA.width_px, side)
        grey = cv2.GaussianBlur(fine.reshape(shape).mean(axis=(1, 3)), (0, 0), 0.7)
        grey = grey + np.random.default_rng(seed).normal(0.0, noise, grey.shape)
        return np.clip(np.round(grey), 0, 255).astype(np.uint8)

    return painted


@cache
def _rays() -> np.ndarray:
    """Directions through the parts of all pixels, row by row."""
    steps = (np.arange(RAYS_A_SIDE) + 0.5) / RAYS_A_SIDE - 0.5
    x = (np.arange(CAMERA.width_px)[:, None] + steps).ravel()
    y = (np.arange(CAMERA.height_px)[:, None] + steps).ravel()
    xy_px = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return np.column_stack([CAMERA.normalize(xy_px), np.ones(len(xy_px))])


def _texture(board: Board) -> tuple[np.ndarray, float]:
    """The board with a margin of one white square, and its pixels a millimetre."""
    square = 60
    across, down = board.squares
    inside = np.indices((down * square, across * square)) // square
    texture = np.where(inside.sum(axis=0) % 2 == 0, 30.0, 200.0)
    if board.kind == "charuco":
        drawn = board.opencv().generateImage((across * square, down * square), None, 0, 1)
        texture = 30.0 + 170.0 * (drawn > 127)
    return np.pad(texture, square, constant_values=200.0).astype(np.float32), (
        square / board.square_mm
    )
