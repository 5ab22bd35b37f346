"""Boards in rendered scenes: every believed corner against its exact place."""

import json
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.targets.board import Board
from limbgram.reconstruction.targets.board_detection import find_board


@pytest.mark.parametrize(("name", "photos_with_board"), [("limb_ring15", 14), ("foot_ring24", 19)])
def test_the_scale_board_is_measured_to_hundredths_and_bad_corners_are_not_believed(
    data_folder: Path, name: str, photos_with_board: int
) -> None:
    folder = data_folder / "rendered" / name
    truth = json.loads((folder / "truth" / "cameras.json").read_text())
    scene_board = json.loads((folder / "truth" / "board.json").read_text())["scene_board"]
    lens = truth["intrinsics"]
    camera = Camera(
        width_px=lens["width"],
        height_px=lens["height"],
        fx=lens["fx"],
        fy=lens["fy"],
        cx=lens["cx"],
        cy=lens["cy"],
        **truth["distortion"],
    )
    poses = {one["name"]: (np.array(one["R"]), np.array(one["t"])) for one in truth["images"]}
    board = Board.charuco("7x5", 30.0, 22.0, "4x4_50")
    in_world = board.corners_mm @ np.array(scene_board["R"]).T + scene_board["t"]
    np.testing.assert_allclose(in_world, scene_board["corners_world_mm"], atol=1e-6)

    found = find_board(read_photos([folder / "images"]), board)
    off_px, sigmas_px = [], []
    for photo in found.photos:
        rotation, shift = poses[photo.name]
        exact = camera.project(in_world @ rotation.T + shift)
        off_px.append(photo.xy_px - exact[photo.ids])
        sigmas_px.append(photo.sigmas_px)
    off, sigmas = np.concatenate(off_px), np.concatenate(sigmas_px)
    assert len(found.photos) >= photos_with_board
    assert 0.005 < np.sqrt((off**2).mean()) < 0.035
    assert np.linalg.norm(off, axis=1).max() < 0.5
    assert np.abs(off.mean(axis=0)).max() < 0.01
    assert 0.6 < np.sqrt(((off / sigmas[:, None]) ** 2).mean()) < 1.5
