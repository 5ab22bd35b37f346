"""The check of a whole board against a flat board seen by some lens."""

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.targets.board import Board
from limbgram.reconstruction.targets.board_detection import board_residuals_px, square_sides_px

BOARD = Board.checkerboard("8x6", 10.0)
SIZE_PX = (1280, 960)


def seen(k1: float, k2: float) -> np.ndarray:
    lens = Camera(
        width_px=1280, height_px=960, fx=560.0, fy=560.0, cx=645.0, cy=470.0, k1=k1, k2=k2
    )
    pose = Rigid.from_rotation_vector(np.array([0.3, -0.4, 0.1]), np.array([-45.0, -35.0, 60.0]))
    return lens.project(pose.apply(BOARD.corners_mm))


def off_px(xy_px: np.ndarray) -> np.ndarray:
    squares = BOARD.corners_mm[:, :2] / BOARD.square_mm
    return np.linalg.norm(
        board_residuals_px(squares, xy_px, square_sides_px(squares, xy_px), SIZE_PX), axis=1
    )


@pytest.mark.parametrize(("k1", "k2"), [(0.0, 0.0), (-0.1, 0.01), (-0.2, 0.03)])
def test_bad_corners_stand_out_whatever_the_lens(k1: float, k2: float) -> None:
    xy_px = seen(k1, k2) + np.random.default_rng(1).normal(0.0, 0.05, (48, 2))
    xy_px[[3, 17, 40]] += [[1.5, 0.0], [0.0, -2.0], [6.0, 4.0]]
    off = off_px(xy_px)
    assert off[[3, 17, 40]].min() > 1.0
    assert np.median(np.delete(off, [3, 17, 40])) < 0.4
    assert off[[3, 17, 40]].min() > np.delete(off, [3, 17, 40]).max()


def test_four_corners_leave_nothing_to_check() -> None:
    squares = BOARD.corners_mm[:4, :2]
    assert np.isnan(board_residuals_px(squares, squares, np.ones((4, 2, 2)), SIZE_PX)).all()
