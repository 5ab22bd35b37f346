"""The check of a limb that turns before a still camera, whole and photo by photo."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from limbgram.capture.coach import CaptureCheck
from limbgram.cases.capture_check import CaptureWatch, check_sources
from limbgram.core.run import Run
from limbgram.findings import told
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.services.parse_capture import DEFAULT_BOARD, parse_board
from limbgram.synthetic import CaptureOptions, TurnedOver, Turning, make_capture
from limbgram.synthetic.capture import Capture

PHOTOS = 16
OPTIONS = CaptureOptions(
    seed=71, photos=PHOTOS, width_px=720, height_px=480, distance_mm=1500.0, calibration_photos=0,
    mesh_step_mm=1.5, samples=2, coverage=0.12, turning=Turning(),
)  # fmt: skip

FEW = replace(OPTIONS, photos=12, width_px=600, height_px=400, distance_mm=1250.0)
"""Smaller pictures at the same size of a pixel on the limb."""


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    return make_capture(tmp_path_factory.mktemp("check") / "capture", OPTIONS)


@pytest.fixture(scope="module")
def whole(capture: Capture, lens_of: Callable[[Capture], Calibration]) -> CaptureCheck:
    """What is told of all photos."""
    photos = list(capture.photos)
    return check_sources(photos, [lens_of(capture)], parse_board(DEFAULT_BOARD), Run())


def test_photos_of_a_turning_limb_are_placed_by_the_limb(
    tmp_path: Path, lens_of: Callable[[Capture], Calibration]
) -> None:
    capture = make_capture(tmp_path / "capture", FEW)
    found = check_sources(
        list(capture.photos), [lens_of(capture)], parse_board(DEFAULT_BOARD), Run()
    )
    assert sum(one.placed for one in found.photos) == FEW.photos, found.headline
    assert any(f"camera stood still in {FEW.photos} photos" in told(one) for one in found.notes), (
        found.notes
    )
    middle = capture.truth.limb.mesh.vertices_mm.mean(0)
    away = np.array([view.centre_in_world for view in capture.truth.views]) - middle
    true_deg = np.degrees(np.arctan2(away[:, 1], away[:, 0]))
    seen_deg = np.array([one.azimuth_deg for one in found.photos])
    off_deg = (seen_deg - true_deg - (seen_deg[0] - true_deg[0]) + 180) % 360 - 180
    assert np.abs(off_deg).max() < 3.0


@pytest.mark.slow
def test_a_growing_folder_is_told_the_same_as_the_whole(
    capture: Capture,
    whole: CaptureCheck,
    tmp_path: Path,
    lens_of: Callable[[Capture], Calibration],
) -> None:
    """What stands still is known better with each photo; matches of before must not be mixed in."""
    board = parse_board(DEFAULT_BOARD)
    with CaptureWatch([lens_of(capture)], board) as watch:
        for photo in capture.photos[: PHOTOS // 2]:
            shutil.copy(photo, tmp_path)
        watch.check([tmp_path])
        for photo in capture.photos[PHOTOS // 2 :]:
            shutil.copy(photo, tmp_path)
        found = watch.check([tmp_path])
        again = Run()
        assert watch.check([tmp_path], again) == found
        assert not {one.stage for one in again.timings} & {"detect", "match pairs", "verify"}
    assert found.go
    assert found.headline.code == whole.headline.code
    assert found.coverage is not None
    assert whole.coverage is not None
    expected_mm = whole.coverage.sigma_middle_mm  # photos are looked at where they first lay
    assert found.coverage.sigma_middle_mm == pytest.approx(expected_mm, rel=0.005)
    turns = [one.azimuth_deg for one in found.photos]
    np.testing.assert_allclose(turns, [one.azimuth_deg for one in whole.photos], atol=0.5)


@pytest.mark.slow
def test_a_board_that_stands_still_tells_no_size(
    tmp_path: Path, lens_of: Callable[[Capture], Calibration]
) -> None:
    options = replace(
        OPTIONS, coverage=CaptureOptions().coverage, turning=Turning(board_turns=False)
    )
    capture = make_capture(tmp_path / "capture", options)
    board = parse_board(DEFAULT_BOARD)
    found = check_sources(list(capture.photos), [lens_of(capture)], board, Run())
    assert not found.go
    assert any("stands still" in told(text) for text in found.findings), found.findings
    assert not [one for one in found.notes if one.code == "coach.turned_over"]


@pytest.mark.slow
def test_a_cast_that_was_turned_over_is_placed_in_both_poses(
    tmp_path: Path, lens_of: Callable[[Capture], Calibration]
) -> None:
    options = replace(
        OPTIONS, seed=72, photos=32, width_px=700, height_px=467, coverage=0.55,
        turning=TurnedOver(),
    )  # fmt: skip
    capture = make_capture(tmp_path / "capture", options)
    board = parse_board(DEFAULT_BOARD)
    found = check_sources(list(capture.photos), [lens_of(capture)], board, Run())
    assert sum(one.placed for one in found.photos) == options.photos, found.headline
    (said,) = [one for one in found.notes if "turned over" in told(one)]
    names = [photo.name for photo in capture.photos]
    assert f"{names[0]} to {names[15]} and {names[16]} to {names[-1]}" in told(said)
