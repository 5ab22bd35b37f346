"""Refusals name their cause: a small capture is damaged in one way at a time.

Each message must name the damage with its remedy, and no other cause.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageFilter, ImageOps

from limbgram.core.errors import CalibrationError, LimbgramError, PlacementError, ScaleError
from limbgram.reconstruction.calibration.board import calibrate
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras, cameras_for
from limbgram.reconstruction.features.detection import Features, detect
from limbgram.reconstruction.mapping.placement import place
from limbgram.reconstruction.matching.matching import Matches, match
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.scale.scaling import to_millimetres
from limbgram.reconstruction.targets.board import Board
from limbgram.reconstruction.targets.board_detection import find_board
from limbgram.reconstruction.twoview.verification import verify
from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.options import CaptureOptions

BOARD = Board.charuco("7x5", 30.0, 22.0, "4X4_50")
CHECKERBOARD = Board.checkerboard("14x10", 10.0)
WORDS = {
    "blur": "are blurred",
    "overexposure": "are overexposed",
    "underexposure": "are underexposed",
    "mirror": "The photos are mirrored",
    "camera": "The camera file is not that of these photos",
    "board": "Check the board's size",
    "moved": "The board moved",
    "paint": "plain",
    "overlap": "too far apart",
    "spot": "nearly the same spot",
    "walk": "steps of 20 degrees",
}


OPTIONS = CaptureOptions(
    photos=12,
    width_px=720,
    height_px=480,
    seed=31,
    samples=2,
    mesh_step_mm=1.2,
    calibration_photos=8,
)


HALF = 7
"""Photos that follow one another."""


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("causes") / "capture"
    make_capture(folder, OPTIONS)
    return folder


@pytest.fixture(scope="module")
def calibration(capture: Path) -> Calibration:
    return calibrate(read_photos([capture / "calibration"]), CHECKERBOARD).calibration


def damaged(
    folder: Path, to: Path, change: Callable[[Image.Image], Image.Image], count: int | None = None
) -> PhotoSet:
    """The first photos of a folder, each changed; EXIF stays."""
    to.mkdir()
    for path in sorted(folder.glob("*.jpg"))[:count]:
        with Image.open(path) as picture:
            change(picture).save(to / path.name, quality=94, exif=picture.getexif())
    return read_photos([to])


def blurred(sigma_px: float) -> Callable[[Image.Image], Image.Image]:
    return lambda picture: picture.filter(ImageFilter.GaussianBlur(sigma_px))


def exposed(times: float) -> Callable[[Image.Image], Image.Image]:
    """So many times the light, clipped as a sensor clips."""

    def change(picture: Image.Image) -> Image.Image:
        light = (np.asarray(picture) / 255.0) ** 2.2 * times
        return Image.fromarray((255 * np.clip(light, 0, 1) ** (1 / 2.2)).astype(np.uint8))

    return change


def half(capture: Path) -> PhotoSet:
    """Photos of one side, as many as a reconstruction needs to come as far as its scale."""
    return read_photos(sorted((capture / "images").iterdir())[:HALF])


MATCHED: dict[str, tuple[Features, Matches]] = {}
"""By the photos' digest."""


def matched(photos: PhotoSet) -> tuple[Features, Matches]:
    """Keypoints and matches, which hang on the pixels and not on what is known of the camera."""
    if photos.digest not in MATCHED:
        features = detect(photos)
        MATCHED[photos.digest] = features, match(photos, features)
    return MATCHED[photos.digest]


def scaled(photos: PhotoSet, cameras: Cameras) -> None:
    """A reconstruction as far as its scale, which is where a board is needed."""
    features, matches = matched(photos)
    pairs = verify(photos, matches, cameras)
    scene = place(photos, features, pairs, cameras)
    to_millimetres(scene, find_board(photos, BOARD), (), cameras=cameras)


def refusal_of(photos: PhotoSet, cameras: Cameras, *kinds: type[LimbgramError]) -> str:
    with pytest.raises(kinds or LimbgramError) as refusal:
        scaled(photos, cameras)
    return str(refusal.value)


def assert_names_only(message: str, cause: str) -> None:
    named = {name for name, words in WORDS.items() if words in message}
    assert named == {cause}, message


@pytest.mark.parametrize(
    ("change", "cause"),
    [
        (blurred(4), "blur"),
        pytest.param(blurred(8), "blur", marks=pytest.mark.slow),
        pytest.param(exposed(10), "overexposure", marks=pytest.mark.slow),
        (exposed(30), "overexposure"),
        (exposed(0.003), "underexposure"),
        (ImageOps.mirror, "mirror"),
    ],
)
@pytest.mark.parametrize("calibrated", [pytest.param(True, marks=pytest.mark.slow), False])
def test_damaged_photos(
    capture: Path, calibration: Calibration, tmp_path: Path, change, cause: str, calibrated: bool
) -> None:
    photos = damaged(capture / "images", tmp_path / "photos", change, HALF)
    cameras = cameras_for(photos, [calibration] if calibrated else [])
    assert_names_only(refusal_of(photos, cameras), cause)


def test_the_undamaged_capture_is_scaled(capture: Path, calibration: Calibration) -> None:
    photos = half(capture)
    scaled(photos, cameras_for(photos, [calibration]))


@pytest.mark.parametrize(
    "times", [*(pytest.param(one, marks=pytest.mark.slow) for one in (0.6, 1.3)), 2.0]
)
@pytest.mark.parametrize("tells_its_lens", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_the_file_of_another_camera_of_the_same_size(
    capture: Path, calibration: Calibration, times: float, tells_its_lens: bool
) -> None:
    """Nothing but the shape of the light tells where neither file nor photos name a lens.

    From one side a focal length wrong by a third may pass for a board that moved.
    """
    photos = half(capture) if times == 2.0 else read_photos([capture / "images"])
    if not tells_its_lens:
        bare = tuple(replace(group, exif=type(group.exif)()) for group in photos.cameras)
        photos = replace(photos, cameras=bare)
    lens = calibration.camera
    foreign = replace(
        calibration,
        camera=replace(lens, fx=times * lens.fx, fy=times * lens.fy),
        label="",
        focal_mm=None,
    )
    message = refusal_of(photos, cameras_for(photos, [foreign]), PlacementError, ScaleError)
    assert_names_only(message, "camera")
    assert f"{times * lens.fx:.0f} px" in message


def test_the_file_of_a_camera_of_another_size(capture: Path, calibration: Calibration) -> None:
    photos = read_photos([capture / "images"])
    lens = replace(calibration.camera, width_px=640, height_px=480)
    with pytest.raises(CalibrationError, match="calibration is for 640 x 480, the photos are 720"):
        cameras_for(photos, [replace(calibration, camera=lens)])


@pytest.mark.parametrize(
    ("change", "cause"), [(blurred(14), "blur"), (exposed(30), "overexposure")]
)
def test_damaged_photos_of_a_checkerboard(capture: Path, tmp_path: Path, change, cause) -> None:
    photos = damaged(capture / "calibration", tmp_path / "photos", change)
    with pytest.raises(CalibrationError) as refusal:
        calibrate(photos, CHECKERBOARD)
    assert_names_only(str(refusal.value), cause)


@pytest.mark.parametrize(
    ("change", "cause"),
    [(blurred(4), "blur"), (exposed(30), "overexposure"), (ImageOps.mirror, "mirror")],
)
def test_damaged_photos_of_a_board_with_markers(
    capture: Path, tmp_path: Path, change, cause: str
) -> None:
    photos = damaged(capture / "images", tmp_path / "photos", change, HALF)
    with pytest.raises(CalibrationError) as refusal:
        calibrate(photos, BOARD)
    assert_names_only(str(refusal.value), cause)


def test_another_board_is_not_blamed_on_good_photos(capture: Path) -> None:
    photos = read_photos(sorted((capture / "images").iterdir())[::2])
    with pytest.raises(CalibrationError) as refusal:
        calibrate(photos, Board.charuco("7x5", 30.0, 22.0, "APRILTAG_36H11"))
    assert_names_only(str(refusal.value), "board")
