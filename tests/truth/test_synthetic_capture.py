"""A synthetic capture's photos agree with its truth, judged by OpenCV and by ray casting."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh
from PIL import Image

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.targets.board import Board
from limbgram.reconstruction.targets.board_detection import find_board
from limbgram.synthetic.capture import Capture, make_capture
from limbgram.synthetic.options import SMALL


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    return make_capture(
        tmp_path_factory.mktemp("synthetic") / "limb",
        replace(SMALL, samples=2, calibration_photos=4),
    )


def written_views(folder: Path, group: str) -> list[View]:
    """The views as a reader of the truth folder has them."""
    record = json.loads((folder / "truth" / "cameras.json").read_text())
    lens = dict(record["intrinsics"])
    size = {"width_px": lens.pop("width"), "height_px": lens.pop("height")}
    camera = Camera(**size, **lens, **record["distortion"])
    return [
        View(row["name"], camera, Rigid(np.array(row["R"]), np.array(row["t"])))
        for row in record[group]
    ]


def scene_corners_mm(capture: Capture) -> np.ndarray:
    board = json.loads((capture.folder / "truth" / "board.json").read_text())["scene_board"]
    assert (board["squares_x"], board["squares_y"], board["square_mm"]) == (7, 5, 30.0)
    return np.array(board["corners_world_mm"])


def grey(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path).convert("L"))


def test_board_corners_found_in_the_photos_lie_where_the_truth_projects_them(
    capture: Capture,
) -> None:
    corners = scene_corners_mm(capture)
    photos = read_photos([capture.folder / "images"])
    views = written_views(capture.folder, "images")
    found = find_board(photos, Board.charuco("7x5", 30.0, 22.0, "4X4_50")).photos
    errors = np.concatenate(
        [photo.xy_px - views[photo.photo_idx].project(corners[photo.ids]) for photo in found]
    )
    assert len(errors) > 100
    assert 0.005 < np.linalg.norm(errors, axis=1).mean() < 0.1
    assert np.abs(errors.mean(0)).max() < 0.02


def test_opencv_reads_the_same_board_at_the_same_places(capture: Capture) -> None:
    """The median: OpenCV alone moves some corners of a board this small to a marker's edge."""
    corners = scene_corners_mm(capture)
    marks = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    detector = cv2.aruco.CharucoDetector(cv2.aruco.CharucoBoard((7, 5), 30.0, 22.0, marks))
    errors = []
    for view in written_views(capture.folder, "images"):
        found, ids, _, _ = detector.detectBoard(grey(capture.folder / "images" / view.name))
        if ids is not None:
            errors.append(found.reshape(-1, 2) - view.project(corners[ids.ravel()]))
    all_errors = np.concatenate(errors)
    assert len(all_errors) > 100
    assert 0.005 < np.median(np.linalg.norm(all_errors, axis=1)) < 0.1
    assert np.abs(np.median(all_errors, axis=0)).max() < 0.03


def test_checkerboard_corners_lie_where_the_truth_projects_them(capture: Capture) -> None:
    board = json.loads((capture.folder / "truth" / "board.json").read_text())["calibration_board"]
    y, x = np.mgrid[1:11, 1:15].reshape(2, -1)
    flat = np.stack([x, y, np.zeros_like(x)], -1) * board["square_mm"]
    corners = flat @ np.array(board["R"]).T + np.array(board["t"])
    errors, places = [], []
    for view in written_views(capture.folder, "calibration"):
        picture = grey(capture.folder / "calibration" / view.name)
        whole, found = cv2.findChessboardCornersSB(picture, (14, 10), flags=cv2.CALIB_CB_ACCURACY)
        assert whole, view.name
        truth, found = view.project(corners), found.reshape(-1, 2)
        turned = np.linalg.norm(found[0] - truth[0]) > np.linalg.norm(found[0] - truth[-1])
        errors.append((found[::-1] if turned else found) - truth)
        places.append(found)
    all_errors, all_places = np.concatenate(errors), np.concatenate(places)
    assert 0.005 < np.linalg.norm(all_errors, axis=1).mean() < 0.1
    assert np.abs(all_errors.mean(0)).max() < 0.03
    assert np.ptp(all_places, axis=0).min() > 0.75 * SMALL.height_px


def test_masks_agree_with_rays_cast_at_the_written_mesh(capture: Capture) -> None:
    mesh = trimesh.load_mesh(capture.folder / "truth" / "mesh.ply", process=False)
    for view in written_views(capture.folder, "images")[:2]:
        mask = np.asarray(Image.open(mask_path(capture, view)))
        pixels = np.argwhere(np.ones_like(mask))[:, ::-1].astype(float)
        rays = view.camera.rays(pixels) @ view.camera_from_world.rotation
        hit = mesh.ray.intersects_any(np.tile(view.centre_in_world, (len(rays), 1)), rays)
        square = np.ones((3, 3), np.uint8)
        edge = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_GRADIENT, square)
        assert 20_000 < mask.sum() < mask.size // 2
        assert (hit.reshape(mask.shape) != mask).sum() < 0.01 * edge.sum()


def test_the_written_mesh_is_closed_and_tells_what_photos_see(capture: Capture) -> None:
    loaded = trimesh.load_mesh(capture.folder / "truth" / "mesh.ply", process=False)
    notes = json.loads((capture.folder / "truth" / "notes.json").read_text())
    limb = capture.truth.limb
    np.testing.assert_allclose(loaded.vertices, limb.mesh.vertices_mm, atol=1e-5)
    assert loaded.is_watertight
    assert loaded.volume / 1000 == pytest.approx(notes["volume_ml_closed"], rel=1e-5)
    assert 800 < notes["volume_ml_closed"] < 4000
    flags = loaded.metadata["_ply_raw"]["vertex"]["data"]
    np.testing.assert_array_equal(flags["cap"] == 1, limb.cut)
    assert flags["ncam"][limb.cut].max() == 0
    assert (flags["ncam"][~limb.cut] >= 2).mean() > 0.95
    assert flags["ncam"].max() < SMALL.photos


def test_photos_carry_the_exif_of_their_camera(capture: Capture) -> None:
    for path in (*capture.photos, *capture.calibration_photos):
        picture = Image.open(path)
        exif = picture.getexif()
        detail = exif.get_ifd(0x8769)
        assert picture.size == (SMALL.width_px, SMALL.height_px)
        assert (exif[0x010F], exif[0x0110]) == (SMALL.lens.make, SMALL.lens.model)
        assert detail[0xA434] == SMALL.lens.name
        assert float(detail[0x920A]) == SMALL.lens.focal_mm


def mask_path(capture: Capture, view: View) -> Path:
    return (capture.folder / "truth" / "masks" / view.name).with_suffix(".png")
