"""Calibration of a known camera: what it finds, sets aside, doubts and refuses."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest

from limbgram.core.errors import CalibrationError
from limbgram.core.geometry.lens import HELD, LENS_SIZE, PARAMETERS, Camera
from limbgram.findings import note, told
from limbgram.reconstruction.calibration.adjustment import bent_board
from limbgram.reconstruction.calibration.board import CalibrationOptions, calibrate_detections
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.reconstruction.targets.board import Board, BoardDetections, PhotoCorners
from limbgram.report.calibration import calibration_text

Capture = Callable[..., Any]
FIXED = [PARAMETERS.index(name) for name in HELD]


def with_photo(detections: BoardDetections, idx: int, **changes: object) -> BoardDetections:
    photos = list(detections.photos)
    photos[idx] = replace(photos[idx], **changes)  # pyright: ignore[reportArgumentType]
    return replace(detections, photos=tuple(photos))


def only(photo: PhotoCorners, kept: np.ndarray) -> PhotoCorners:
    """The photo with some of its corners."""
    return replace(
        photo,
        ids=photo.ids[kept],
        xy_px=photo.xy_px[kept],
        sigmas_px=photo.sigmas_px[kept],
    )


def test_exact_corners_give_the_exact_camera(capture: Capture, true_camera: Camera) -> None:
    result = calibrate_detections(*capture(noise_px=0.0).arguments)
    np.testing.assert_allclose(result.calibration.camera.packed, true_camera.packed, atol=1e-4)
    assert result.calibration.rms_px < 1e-5
    assert result.calibration.source == "board"
    assert result.calibration.label == "Canon EOS 500D EF50mm f/1.8 II"
    assert result.calibration.focal_mm == 50.0


@pytest.mark.slow
def test_the_same_corners_give_the_same_bytes_whatever_the_threads(capture: Capture) -> None:
    arguments = capture(photos=30, seed=2).arguments
    before = cv2.getNumThreads()
    cameras: set[bytes] = set()
    try:
        for threads in (1, 4, 4, 4, 4, 4):
            cv2.setNumThreads(threads)
            result = calibrate_detections(*arguments).calibration
            cameras.add(result.camera.packed.tobytes() + result.covariance.tobytes())
            assert cv2.getNumThreads() == threads
    finally:
        cv2.setNumThreads(before)
    assert len(cameras) == 1


def test_poses_are_those_of_the_board(capture: Capture) -> None:
    taken = capture(noise_px=0.0)
    result = calibrate_detections(*taken.arguments)
    for photo, pose in zip(result.photos, taken.poses):
        np.testing.assert_allclose(photo.camera_from_board.matrix_3x4, pose.matrix_3x4, atol=1e-3)


def test_the_fit_is_no_worse_than_opencvs(capture: Capture) -> None:
    taken = capture(noise_px=0.1, seed=3)
    photos = taken.detections.photos
    rms_px = cv2.calibrateCamera(
        [taken.detections.corners_mm[one.ids].astype(np.float32) for one in photos],
        [one.xy_px.astype(np.float32).reshape(-1, 1, 2) for one in photos],
        (2000, 1500),
        np.eye(3),
        np.zeros(5),
        flags=cv2.CALIB_FIX_K3,
    )[0]
    result = calibrate_detections(*taken.arguments)
    assert not result.k3_delivered
    assert 0.9 * rms_px < result.calibration.rms_px <= rms_px * (1 + 1e-5)


def test_what_is_held_fixed_has_no_variance_and_no_correlation(capture: Capture) -> None:
    result = calibrate_detections(*capture(seed=1).arguments)
    assert not result.skew_delivered
    for row in FIXED:
        assert result.calibration.camera.packed[row] == 0.0
        assert not result.calibration.covariance[row].any()
        assert not result.correlations[row].any()
    free = np.delete(np.arange(LENS_SIZE), FIXED)
    np.testing.assert_allclose(np.diag(result.correlations)[free], 1.0)
    assert np.abs(result.correlations).max() <= 1.0 + 1e-9


def test_skew_is_delivered_only_where_it_is_seen_and_matters(
    capture: Capture, true_camera: Camera
) -> None:
    leaning = calibrate_detections(
        *capture(camera=replace(true_camera, skew=12.0), photos=16).arguments
    )
    assert leaning.skew_delivered
    assert abs(leaning.calibration.camera.skew - 12.0) < 5 * leaning.skew.sigma
    hardly = calibrate_detections(
        *capture(camera=replace(true_camera, skew=0.5), noise_px=0.002).arguments
    )
    assert hardly.skew.sigmas_from_zero > 5
    assert not hardly.skew_delivered


def test_sixth_order_distortion_is_kept_where_it_is_seen(
    capture: Capture, true_camera: Camera
) -> None:
    strong = replace(true_camera, fx=1500.0, fy=1500.0, k3=-0.2)
    result = calibrate_detections(
        *capture(camera=strong, photos=20, distance=0.45, spread=2.0).arguments
    )
    assert result.k3_delivered
    assert abs(result.calibration.camera.k3 + 0.2) < 5 * result.k3.sigma


def test_a_bent_and_stretched_board_does_not_bend_the_camera(
    capture: Capture, true_camera: Camera
) -> None:
    flat = capture().detections.corners_mm
    terms = np.array([0.004, 0.0, 0.01, 0.0, 0.005])
    taken = capture(corners_mm=bent_board(flat, terms, flat), photos=16)
    result = calibrate_detections(*taken.arguments)
    assert result.board_shape is not None
    for estimate, true in zip(result.board_shape, terms):
        assert abs(estimate.value - true) < 4 * estimate.sigma
    assert abs(result.aspect.value - true_camera.fy / true_camera.fx) < 4 * result.aspect.sigma
    believed = calibrate_detections(*taken.arguments, CalibrationOptions(board_gain=2.0))
    assert believed.board_shape is None
    assert believed.calibration.rms_px > 3 * result.calibration.rms_px


def test_a_flat_board_is_left_flat(capture: Capture) -> None:
    assert calibrate_detections(*capture(seed=5).arguments).board_shape is None


def test_what_was_no_photo_is_told_with_the_calibration(capture: Capture) -> None:
    taken = capture()
    photos = replace(
        taken.photos,
        set_aside=(SetAside("cut.jpg", note("said.as_is", message="the file is cut off")),),
    )
    result = calibrate_detections(photos, taken.detections)
    assert result.set_aside == (
        SetAside("cut.jpg", note("said.as_is", message="the file is cut off")),
    )
    assert "  cut.jpg: the file is cut off" in calibration_text(result)


def test_a_photo_that_contradicts_the_others_is_set_aside_by_name(capture: Capture) -> None:
    taken = capture()
    detections = taken.detections
    shaken = np.random.default_rng(0).normal(0.0, 3.0, detections.photos[4].xy_px.shape)
    bad = with_photo(detections, 4, xy_px=detections.photos[4].xy_px + shaken)
    result = calibrate_detections(taken.photos, bad)
    assert [one.name for one in result.set_aside] == ["photo04.jpg"]
    assert "px off" in told(result.set_aside[0].reason)
    assert len(result.photos) == 11


def test_wrong_corners_are_left_out_and_counted(capture: Capture, true_camera: Camera) -> None:
    taken = capture()
    xy_px = taken.detections.photos[2].xy_px.copy()
    xy_px[[3, 30]] += [[0.9, 0.0], [0.0, -0.8]]
    result = calibrate_detections(taken.photos, with_photo(taken.detections, 2, xy_px=xy_px))
    assert [photo.dropped for photo in result.photos] == [0, 0, 2] + 9 * [0]
    free = np.delete(np.arange(LENS_SIZE), FIXED)
    off = result.calibration.camera.packed - true_camera.packed
    assert (np.abs(off) < 5 * result.calibration.sigmas)[free].all()


def test_errors_shared_within_a_photo_enlarge_the_sigmas(capture: Capture) -> None:
    taken = capture(photos=16)
    rng = np.random.default_rng(2)
    photos = tuple(
        replace(one, xy_px=one.xy_px + _wave(one.xy_px, rng)) for one in taken.detections.photos
    )
    result = calibrate_detections(taken.photos, replace(taken.detections, photos=photos))
    alone = calibrate_detections(*taken.arguments)
    assert 1.0 <= alone.inflation < 1.6
    assert result.inflation > 2.0
    assert any("not flat" in told(one) for one in result.doubts)


def _wave(xy_px: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """An error that varies slowly over one photo."""
    middle = (xy_px - xy_px.mean(axis=0)) / 500.0
    return 0.3 * (middle**2) @ rng.normal(0.0, 1.0, (2, 2))


def test_few_photos_are_doubted_and_too_few_refused(capture: Capture) -> None:
    few = calibrate_detections(*capture(photos=5, seed=2).arguments)
    assert any("5 photos are few" in told(one) for one in few.doubts)
    with pytest.raises(CalibrationError, match="found in 2 of 2 photos"):
        calibrate_detections(*capture(photos=2).arguments)


@pytest.mark.parametrize("tilt_deg", [0.5, pytest.param(0.0, marks=pytest.mark.slow)])
def test_parallel_views_are_refused_with_advice(capture: Capture, tilt_deg: float) -> None:
    with pytest.raises(CalibrationError, match=r"[Tt]ilt"):
        calibrate_detections(*capture(tilt_deg=tilt_deg).arguments)


def test_a_corner_of_the_picture_never_covered_is_refused_by_name(capture: Capture) -> None:
    taken = capture(photos=16)
    photos = []
    for one in taken.detections.photos:
        keep = (one.xy_px[:, 0] < 1050) | (one.xy_px[:, 1] < 770)
        photos.append(only(one, keep))
    with pytest.raises(CalibrationError, match="near the bottom right of"):
        calibrate_detections(taken.photos, replace(taken.detections, photos=tuple(photos)))


def test_two_zoom_settings_are_refused_by_name(capture: Capture) -> None:
    taken = capture()
    photos = list(taken.photos.photos)
    photos[3] = replace(photos[3], exif=replace(photos[3].exif, focal_mm=35.0))
    with pytest.raises(CalibrationError, match=r"at 35 mm: photo03\.jpg"):
        calibrate_detections(replace(taken.photos, photos=tuple(photos)), taken.detections)


def test_two_sizes_are_refused_by_name(capture: Capture) -> None:
    taken = capture()
    photos = list(taken.photos.photos)
    photos[3] = replace(photos[3], width_px=1500, height_px=2000)
    with pytest.raises(CalibrationError, match=r"1500 x 2000 .*: photo03\.jpg"):
        calibrate_detections(replace(taken.photos, photos=tuple(photos)), taken.detections)


@pytest.mark.parametrize(("photos", "poor"), [(3, (1,)), (11, (0, 2, 4, 6, 8, 10))])
def test_a_photo_that_loses_nearly_all_corners_is_set_aside_or_the_photos_are_refused(
    capture: Capture, photos: int, poor: tuple[int, ...]
) -> None:
    """Cut off and shaken, it shows eight corners that are twenty times as far off as the others."""
    taken = capture(photos=photos, noise_px=0.02)
    draw = np.random.default_rng(8)
    shown = list(taken.detections.photos)
    for k in poor:
        few = only(shown[k], np.isin(np.arange(len(shown[k].ids)), [0, 2, 5, 8, 28, 40, 54, 58]))
        shown[k] = replace(few, xy_px=few.xy_px + draw.normal(0.0, 0.4, few.xy_px.shape))
    detections = replace(taken.detections, photos=tuple(shown))
    if photos == 3:
        with pytest.raises(CalibrationError, match="explains these photos"):
            calibrate_detections(taken.photos, detections)
    else:
        result = calibrate_detections(taken.photos, detections)
        aside = {one.name for one in result.set_aside}
        assert aside
        assert aside <= {shown[k].name for k in poor}
        assert all(len(one.ids) >= 4 for one in result.photos)


def test_two_bodies_of_one_model_are_refused_by_name(capture: Capture) -> None:
    """Their lenses differ, and the camera file would be kept as that of the first one."""
    taken = capture()
    photos = [
        replace(one, exif=replace(one.exif, body="0a1b2c3d" if k % 2 else None))
        for k, one in enumerate(taken.photos.photos)
    ]
    of_one = calibrate_detections(replace(taken.photos, photos=tuple(photos)), taken.detections)
    assert len(of_one.photos) > 3
    photos[4] = replace(photos[4], exif=replace(photos[4].exif, body="4e5f6071"))
    with pytest.raises(CalibrationError, match=r"3 cameras.*photo04\.jpg"):
        calibrate_detections(replace(taken.photos, photos=tuple(photos)), taken.detections)


def test_a_board_never_found_is_told_with_the_first_reasons(capture: Capture) -> None:
    taken = capture()
    nothing = replace(
        taken.detections,
        photos=(),
        set_aside=(SetAside("photo00.jpg", note("said.as_is", message="count the corners")),),
    )
    with pytest.raises(CalibrationError, match=r"photo00\.jpg: count the corners"):
        calibrate_detections(taken.photos, nothing)


def test_photos_that_no_camera_explains_together_are_refused(
    capture: Capture, true_camera: Camera
) -> None:
    taken = capture(photos=10)
    zoomed = capture(photos=10, seed=1, camera=replace(true_camera, fx=4200.0, fy=4195.0))
    mixed = taken.detections.photos[::2] + zoomed.detections.photos[1::2]
    detections = replace(taken.detections, photos=mixed)
    with pytest.raises(CalibrationError, match="together"):
        calibrate_detections(taken.photos, detections)


def test_a_board_that_looks_alike_after_a_quarter_turn_is_believed_flat(capture: Capture) -> None:
    taken = capture(photos=16)
    board_mm = taken.detections.corners_mm
    bent = capture(
        corners_mm=bent_board(board_mm, np.array([0, 0, 0.01, 0, 0]), board_mm), photos=16
    )
    keep = np.flatnonzero((board_mm[:, 0] < 75) & (board_mm[:, 1] < 75))
    square = Board.checkerboard("7x7", 10.0)
    rows = {old: new for new, old in enumerate(keep)}
    photos = []
    for one in bent.detections.photos:
        inside = np.isin(one.ids, keep)
        kept = only(one, inside)
        ids = np.array([rows[idx] for idx in kept.ids], np.int32)
        photos.append(replace(kept, ids=ids))
    detections = replace(
        bent.detections, board=square, corners_mm=square.corners_mm, photos=tuple(photos)
    )
    assert calibrate_detections(bent.photos, detections).board_shape is None
