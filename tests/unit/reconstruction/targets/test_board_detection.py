"""Finding boards in pictures whose corners are known exactly."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera
from limbgram.findings import told
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet, SetAside
from limbgram.reconstruction.targets.board import Board, PhotoCorners
from limbgram.reconstruction.targets.board_detection import (
    _most_common,
    find_board,
    find_in_photo,
)

CHECKERBOARD = Board.checkerboard("8x5", 10.0)
CHARUCO = Board.charuco("7x5", 12.0, 9.0, "apriltag_16h5")
POSE = Rigid.from_rotation_vector(np.array([0.35, -0.3, 0.2]), np.array([-40.0, -32.0, 190.0]))
PHOTO = Photo(
    name="board.png",
    path=Path("board.png"),
    width_px=480,
    height_px=360,
    exif=Exif(),
    sha256="",
    camera_idx=0,
)


def found_in(luma: np.ndarray, board: Board) -> PhotoCorners:
    found = find_in_photo(PHOTO, 0, luma, board)
    assert isinstance(found, PhotoCorners), found
    return found


@pytest.mark.parametrize("board", [CHECKERBOARD, CHARUCO], ids=["checkerboard", "charuco"])
def test_corners_lie_where_they_were_painted(
    paint: Callable[..., np.ndarray], camera: Camera, board: Board
) -> None:
    found = found_in(paint(board, POSE, noise=2.0), board)
    error_px = found.xy_px - camera.project(POSE.apply(board.corners_mm[found.ids]))
    rms_px = float(np.sqrt((error_px**2).mean()))
    assert len(found.ids) == len(board.corners_mm)
    assert 1e-4 < rms_px < 0.05
    assert np.abs(error_px.mean(axis=0)).max() < 0.02
    assert np.abs(found.xy_px[0] - found.xy_px[1]).max() == pytest.approx(found.step_px, rel=0.4)


def test_a_checkerboard_is_first_looked_for_in_a_reduced_copy_of_a_large_photo(
    paint: Callable[..., np.ndarray], camera: Camera
) -> None:
    small = paint(CHECKERBOARD, POSE, noise=2.0)
    large = np.pad(small, ((700, 700), (900, 900)), mode="edge")
    photo = replace(PHOTO, width_px=large.shape[1], height_px=large.shape[0])
    found = find_in_photo(photo, 0, large, CHECKERBOARD)
    assert isinstance(found, PhotoCorners), found
    moved = np.array([900.0, 700.0])
    truth = camera.project(POSE.apply(CHECKERBOARD.corners_mm[found.ids])) + moved
    np.testing.assert_allclose(found.xy_px, truth, atol=0.2)


def test_corners_cut_by_something_in_front_are_not_believed(
    paint: Callable[..., np.ndarray], camera: Camera
) -> None:
    luma = paint(CHARUCO, POSE, noise=2.0)
    truth = camera.project(POSE.apply(CHARUCO.corners_mm))
    y, x = np.mgrid[: luma.shape[0], : luma.shape[1]]
    middle = truth[8] + [1.0, 2.0]
    luma[(x - middle[0]) ** 2 + (y - middle[1]) ** 2 < 7.0**2] = 120
    found = found_in(luma, CHARUCO)
    assert 8 not in found.ids
    assert len(found.ids) >= 16
    assert np.linalg.norm(found.xy_px - truth[found.ids], axis=1).max() < 0.2
    assert all(found.doubts)


def test_a_board_of_another_size_is_told(paint: Callable[..., np.ndarray]) -> None:
    squares = Board.checkerboard("9x6", 10.0)
    answer = find_in_photo(PHOTO, 0, paint(CHECKERBOARD, POSE), squares)
    assert isinstance(answer, SetAside)
    assert "8 x 5 inner corners" in told(answer.reason)


def test_a_picture_without_a_board_is_set_aside_with_its_reason() -> None:
    grey = np.random.default_rng(0).integers(90, 110, (360, 480)).astype(np.uint8)
    for board in (CHECKERBOARD, CHARUCO):
        answer = find_in_photo(PHOTO, 0, grey, board)
        assert isinstance(answer, SetAside)
        assert "found" in told(answer.reason)


def photos_of(folder: Path, pictures: dict[str, np.ndarray]) -> PhotoSet:
    for name, luma in pictures.items():
        Image.fromarray(luma).save(folder / name)
    return PhotoSet(
        tuple(replace(PHOTO, name=name, path=folder / name) for name in pictures),
        (CameraGroup(label="", width_px=480, height_px=360, exif=Exif()),),
    )


def test_photos_are_read_and_those_without_the_board_set_aside(
    tmp_path: Path, paint: Callable[..., np.ndarray]
) -> None:
    pictures = {
        "a.png": paint(CHECKERBOARD, POSE),
        "b.png": np.full((360, 480), 128, np.uint8),
    }
    found = find_board(photos_of(tmp_path, pictures), CHECKERBOARD)
    assert [one.name for one in found.photos] == ["a.png"]
    assert found.photos[0].photo_idx == 0
    assert [one.name for one in found.set_aside] == ["b.png"]


TURNS = ((0.35, -0.3, 0.2), (-0.3, 0.2, -0.1), (0.1, 0.4, 0.3))


def board(size: str, *, legacy: bool = False) -> Board:
    return Board.charuco(size, 10.0, 7.5, "4X4_50", legacy=legacy)


def poses_of(printed: Board) -> list[Rigid]:
    """Three looks at a board, its middle before the camera."""
    middle = np.append(0.5 * printed.square_mm * np.array(printed.squares), 0.0)
    poses: list[Rigid] = []
    for turn in TURNS:
        rotation = Rigid.from_rotation_vector(np.array(turn), np.zeros(3)).rotation
        poses.append(Rigid(rotation, np.array([0.0, 0.0, 190.0]) - rotation @ middle))
    return poses


def painted(paint: Callable[..., np.ndarray], printed: Board) -> dict[str, np.ndarray]:
    return {f"{k}.png": paint(printed, pose) for k, pose in enumerate(poses_of(printed))}


@pytest.mark.parametrize("legacy", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_a_board_is_read_in_the_pattern_in_which_it_was_printed(
    tmp_path: Path, paint: Callable[..., np.ndarray], camera: Camera, legacy: bool
) -> None:
    """With an even number of rows OpenCV before 4.6 printed a marker in the first square."""
    printed, given = board("8x6", legacy=legacy), board("8x6", legacy=not legacy)
    found = find_board(photos_of(tmp_path, painted(paint, printed)), given)
    assert found.board == printed
    assert len(found.photos) == 3
    for one, pose in zip(found.photos, poses_of(printed), strict=True):
        truth = camera.project(pose.apply(printed.corners_mm[one.ids]))
        assert len(one.ids) == 35
        assert 1e-4 < float(np.sqrt(((one.xy_px - truth) ** 2).mean())) < 0.1


@pytest.mark.parametrize(
    ("printed", "given", "said"),
    [
        pytest.param(
            board("7x5"), board("5x7"), "7 x 5 squares; 5 x 7 was given", marks=pytest.mark.slow
        ),
        pytest.param(
            board("7x5"), board("9x7"), "7 x 5 squares; 9 x 7 was given", marks=pytest.mark.slow
        ),
        (
            board("8x6", legacy=True),
            board("6x8"),
            "8 x 6 squares, legacy pattern (of OpenCV before 4.6); 6 x 8 was given",
        ),
    ],
)
def test_the_layout_that_fits_is_told_and_a_mirror_where_there_is_one(
    tmp_path: Path, paint: Callable[..., np.ndarray], printed: Board, given: Board, said: str
) -> None:
    pictures = painted(paint, printed)
    found = find_board(photos_of(tmp_path, pictures), given)
    assert found.photos == ()
    assert f"as on a board of {said}" in told(found.cause)
    mirrored = {name: np.ascontiguousarray(luma[:, ::-1]) for name, luma in pictures.items()}
    for asked in (given, printed):
        found = find_board(photos_of(tmp_path, mirrored), asked)
        assert told(found.cause).startswith("The photos are mirrored: 3 of them")


def test_markers_that_are_misread_in_a_mirror_do_not_hide_it(
    tmp_path: Path, paint: Callable[..., np.ndarray]
) -> None:
    """Mirrored, markers 8, 9 and 17 of 4X4_50 are read, and corners beside them pass for flat."""
    pictures = painted(paint, board("8x6", legacy=True))
    mirrored = {name: np.ascontiguousarray(luma[:, ::-1]) for name, luma in pictures.items()}
    photos = photos_of(tmp_path, mirrored)
    for legacy in (False, True):
        found = find_board(photos, board("8x6", legacy=legacy))
        assert told(found.cause).startswith("The photos are mirrored: 3 of them")
        assert found.photos == ()
        assert [one.name for one in found.set_aside] == ["0.png", "1.png", "2.png"]


@pytest.mark.parametrize(
    "given_mm", [6.2, *(pytest.param(one, marks=pytest.mark.slow) for one in (5.0, 8.8))]
)
def test_markers_that_fill_another_part_of_their_squares_are_of_another_board(
    paint: Callable[..., np.ndarray], tmp_path: Path, given_mm: float
) -> None:
    printed = board("7x5")
    photos = photos_of(tmp_path, painted(paint, printed))
    found = find_board(photos, replace(printed, marker_mm=given_mm))
    assert not found.photos
    assert found.cause is not None
    assert found.cause.code == "board.other_ratio"
    true = printed.marker_mm / printed.square_mm
    assert found.cause.values["ratio"] == pytest.approx(true, abs=0.03)
    assert found.cause.values["fitting_mm"] == pytest.approx(printed.marker_mm, abs=0.3)


def test_a_board_in_the_other_pattern_must_have_the_given_ratio_too(
    paint: Callable[..., np.ndarray], tmp_path: Path
) -> None:
    printed = board("8x6", legacy=True)
    photos = photos_of(tmp_path, painted(paint, printed))
    found = find_board(photos, replace(board("8x6"), marker_mm=6.2))
    assert not found.photos
    assert found.cause is not None
    assert found.cause.code == "board.other_ratio"


@pytest.mark.parametrize(
    "off", [-0.02, *(pytest.param(one, marks=pytest.mark.slow) for one in (0.0, 0.02))]
)
def test_a_ratio_that_a_ruler_may_miss_by_is_taken(
    paint: Callable[..., np.ndarray], tmp_path: Path, off: float
) -> None:
    printed = board("7x5")
    photos = photos_of(tmp_path, painted(paint, printed))
    given = replace(printed, marker_mm=printed.marker_mm * (1.0 + off))
    assert len(find_board(photos, given).photos) == len(photos.photos)


@pytest.mark.parametrize("spread", [0.0, 0.3])
def test_a_marker_one_millimetre_off_is_told_whatever_ink_and_light_do_to_edges(
    paint: Callable[..., np.ndarray], tmp_path: Path, spread: float
) -> None:
    """A tone curve widens black, of markers and of squares alike; a ruler errs by half as much."""
    printed = Board.charuco("7x5", 30.0, 22.5, "4X4_50")
    curve = np.round(255.0 * (np.arange(256) / 255.0) ** (1.0 + spread)).astype(np.uint8)
    drawn = painted(paint, board("7x5"))  # a third of the size at a third of the distance
    photos = photos_of(tmp_path, {name: curve[luma] for name, luma in drawn.items()})
    assert len(find_board(photos, printed).photos) == 3
    for given_mm in (21.5, 23.5):
        cause = find_board(photos, replace(printed, marker_mm=given_mm)).cause
        assert cause is not None
        assert cause.code == "board.other_ratio"
        assert cause.values["fitting_mm"] == pytest.approx(22.5, rel=0.012)


def test_burnt_photos_are_blamed_and_not_the_board_whose_markers_they_thin(
    paint: Callable[..., np.ndarray], tmp_path: Path
) -> None:
    """White that burns out eats into black, so that markers look narrower than they are."""
    printed = board("7x5")
    photos = photos_of(tmp_path, painted(paint, printed))
    burnt = replace(photos, photos=tuple(replace(one, burnt=0.9) for one in photos.photos))
    given = replace(printed, marker_mm=8.8)
    for seen, said in ((photos, "board.other_ratio"), (burnt, "photo.most_overexposed")):
        cause = find_board(seen, given).cause
        assert cause is not None
        assert cause.code == said


@pytest.mark.parametrize("codes", [("a", "b"), ("b", "a"), ("c", "b", "a"), ("a", "c", "b")])
def test_of_equally_frequent_doubts_the_first_is_told(codes: tuple[str, ...]) -> None:
    """Whatever the hashes of strings are, which change from run to run."""
    assert _most_common(np.array([f"board.corner.{one}" for one in codes], object)).code == (
        f"board.corner.{codes[0]}"
    )
