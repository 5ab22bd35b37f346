"""The adjustment's projection of a board against the camera's."""

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.calibration.adjustment import bent_board, board_slopes, project_board
from limbgram.reconstruction.targets.board import Board

BOARD_MM = Board.checkerboard("7x5", 20.0).corners_mm
POSE = Rigid.from_rotation_vector(np.array([0.3, -0.4, 0.2]), np.array([-50.0, -40.0, 300.0]))
LENS = Camera(
    width_px=1, height_px=1, fx=900.0, fy=950.0, cx=300.0, cy=200.0, skew=5.0,
    k1=-0.2, k2=0.1, p1=0.01, p2=-0.02, k3=0.05,
)  # fmt: skip
BEND = np.array([0.01, 0.02, 0.03, -0.02, 0.01])
UNKNOWNS = np.append(LENS.packed, BEND)


def test_a_flat_board_projects_as_the_camera_does() -> None:
    shape = bent_board(BOARD_MM, BEND, BOARD_MM)
    np.testing.assert_allclose(
        project_board(BOARD_MM, board_slopes(BOARD_MM, BOARD_MM), UNKNOWNS, POSE).xy_px,
        LENS.project(POSE.apply(shape)),
        atol=1e-10,
    )
    assert np.abs(shape - BOARD_MM).max() > 0.5


def test_the_board_bends_about_its_middle_and_stretches_along_y_only() -> None:
    bent = bent_board(BOARD_MM, np.array([0.1, 0.0, 0.2, 0.0, 0.0]), BOARD_MM)
    middle = BOARD_MM.mean(axis=0)
    half_mm = 0.5 * np.ptp(BOARD_MM[:, 0])
    np.testing.assert_allclose((bent - middle)[:, 1], 1.1 * (BOARD_MM - middle)[:, 1])
    np.testing.assert_allclose(bent[:, 0], BOARD_MM[:, 0])
    assert bent[:, 2].max() == pytest.approx(0.2 * half_mm)
