"""Boards: parsing, refusals, and the same corners as OpenCV's."""

import numpy as np
import pytest

from limbgram.core.errors import OptionsError
from limbgram.reconstruction.targets.board import Board, parse_dictionary, parse_size


@pytest.mark.parametrize("size", ["14x10", " 14 X 10 ", "14×10"])
def test_a_size_is_read_however_it_is_written(size: str) -> None:
    assert parse_size(size) == (14, 10)


@pytest.mark.parametrize("size", ["14", "14x", "x10", "14x10x2", "-14x10", "1e1x10", ""])
def test_what_is_no_size_is_refused(size: str) -> None:
    with pytest.raises(OptionsError, match="columns x rows"):
        parse_size(size)


@pytest.mark.parametrize(
    ("name", "known"),
    [
        ("DICT_4X4_50", "4X4_50"),
        ("dict_4x4_50", "4X4_50"),
        ("tag36h11", "APRILTAG_36H11"),
        ("AprilTag 36h11", "APRILTAG_36H11"),
        ("DICT_APRILTAG_16h5", "APRILTAG_16H5"),
    ],
)
def test_a_dictionary_is_known_by_its_usual_names(name: str, known: str) -> None:
    assert parse_dictionary(name) == known


def test_an_unknown_dictionary_is_refused_with_the_known_ones() -> None:
    with pytest.raises(OptionsError, match="4X4_50"):
        parse_dictionary("4x5_50")


def test_checkerboard_corners_start_one_square_from_the_outer_corner() -> None:
    board = Board.checkerboard("4x3", 10.0)
    corners = board.corners_mm
    assert corners.shape == (12, 3)
    np.testing.assert_array_equal(corners[0], [10, 10, 0])
    np.testing.assert_array_equal(corners[1], [20, 10, 0])
    np.testing.assert_array_equal(corners[4], [10, 20, 0])
    assert board.squares == (5, 4)


def test_charuco_corners_are_those_of_opencv() -> None:
    board = Board.charuco("7x5", 30.0, 22.0, "4x4_50")
    np.testing.assert_allclose(board.corners_mm, board.opencv().getChessboardCorners(), atol=1e-4)


def test_boards_that_cannot_be_are_refused() -> None:
    with pytest.raises(OptionsError, match="inner corners"):
        Board.checkerboard("1x5", 10.0)
    with pytest.raises(OptionsError, match="millimetres"):
        Board.checkerboard("5x4", 0.0)
    with pytest.raises(OptionsError, match="do not fit"):
        Board.charuco("7x5", 30.0, 30.0, "4x4_50")
    with pytest.raises(OptionsError, match="50 markers"):
        Board.charuco("20x15", 30.0, 20.0, "4x4_50")
