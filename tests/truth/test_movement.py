"""A rendered limb that moves between the photos: noticed, placed by itself, scaled by the board."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.geometry.frames import fit_similarity
from limbgram.core.run import Run
from limbgram.reconstruction.calibration.cameras import Calibration, cameras_for
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.pipeline import (
    PipelineOptions,
    PlacedPhotos,
    by_the_limb,
    place_photos,
    placed_photos,
)
from limbgram.reconstruction.scale.board import find_scene_board
from limbgram.reconstruction.targets.board_detection import find_board
from limbgram.synthetic import (
    SCALE_BOARD,
    Capture,
    CaptureOptions,
    Movement,
    MovementKind,
    make_capture,
)

PHOTOS = 12
SIGMAS = np.array([0.7, 0.7, 1.0, 1.0, 0.0, 2e-3, 4e-2, 1e-4, 1e-4, 0.0])
OPTIONS = CaptureOptions(
    seed=41, photos=PHOTOS, width_px=600, height_px=400, distance_mm=1250.0,
    calibration_photos=0, mesh_step_mm=1.5, samples=2,
)  # fmt: skip


def taken(folder: Path, movement: Movement | None) -> Capture:
    return make_capture(folder / "capture", replace(OPTIONS, movement=movement))


def settled(capture: Capture) -> PlacedPhotos:
    camera = capture.truth.views[0].camera
    calibration = Calibration(camera=camera, covariance=np.diag(SIGMAS**2), source="board")
    photos = read_photos((capture.folder / "images",))
    cameras = cameras_for(photos, (calibration,))
    run, options = Run(), PipelineOptions()
    found = find_board(photos, SCALE_BOARD.board)
    placing = place_photos(photos, cameras, options, run, found)
    return by_the_limb(placed_photos(photos, cameras, placing, found, run), options, run)


def test_a_step_is_found_and_the_limb_alone_places_the_photos(tmp_path: Path) -> None:
    capture = taken(tmp_path, Movement(shift_mm=8.0))
    _, _, placing, found = settled(capture)
    movement, bending = placing.scene.movement, placing.scene.bending
    assert movement is not None
    assert movement.alone
    assert movement.group.tolist() == [0] * (PHOTOS // 2) + [1] * (PHOTOS // 2)
    assert bending is not None
    assert bending.kind == "still"

    true = np.array([view.centre_in_world for view in capture.truth.views])
    seen = np.array([view.centre_in_world for view in placing.scene.views])
    true_from_scene = fit_similarity(seen, true)
    off_mm = np.linalg.norm(true_from_scene.apply(seen) - true, axis=1)
    assert np.sqrt((off_mm**2).mean()) < 2.0  # 8 mm of movement would leave 4
    assert abs(true_from_scene.scale * movement.shift[-1] - 8.0) < 1.5

    assert found is not None
    assert len({int(movement.group[one.photo_idx]) for one in found.photos}) == 1
    board = find_scene_board(placing.scene, found)
    assert abs(true_from_scene.scale * board.ruler.units_per_mm - 1.0) < 0.002


@pytest.mark.slow
def test_a_drift_carries_the_board_along(tmp_path: Path) -> None:
    capture = taken(tmp_path, Movement(kind=MovementKind.DRIFT, shift_mm=8.0))
    _, _, placing, found = settled(capture)
    assert placing.scene.movement is not None
    assert placing.scene.movement.kind == "drift"
    assert found is not None
    board = find_scene_board(placing.scene, found)
    true = np.array([view.centre_in_world for view in capture.truth.views])
    seen = np.array([view.centre_in_world for view in placing.scene.views])
    assert abs(fit_similarity(seen, true).scale * board.ruler.units_per_mm - 1.0) < 0.002


@pytest.mark.slow
def test_a_limb_that_keeps_still_changes_nothing(tmp_path: Path) -> None:
    _, _, placing, found = settled(taken(tmp_path, None))
    movement, bending = placing.scene.movement, placing.scene.bending
    assert movement is not None
    assert bending is not None
    assert (movement.kind, bending.kind, movement.alone) == ("still", "still", False)
    assert found is not None
    assert len(found.photos) > 6
