"""Each fault of a real camera does to the photos what geometry says that it does."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.errors import OptionsError
from limbgram.core.geometry.arrays import Points2
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.targets.finding import find_board
from limbgram.synthetic.capture import Capture, make_capture
from limbgram.synthetic.faults import Faults
from limbgram.synthetic.options import SMALL
from limbgram.synthetic.props.board import CALIBRATION_BOARD
from limbgram.synthetic.truth import ideal_camera, stage_truth

FEW = replace(SMALL, photos=3, calibration_photos=3, mesh_step_mm=3.0, noise=0.2, samples=2)


@pytest.fixture(scope="module")
def without(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    return make_capture(tmp_path_factory.mktemp("ideal") / "limb", FEW)


def corners(capture: Capture) -> list[Points2]:
    """The calibration board's corners as they are found in its photos."""
    photos = read_photos([capture.folder / "calibration"])
    found = find_board(photos, CALIBRATION_BOARD.board).photos
    assert [len(photo.ids) for photo in found] == [140] * 3
    return [photo.xy_px[np.argsort(photo.ids)] for photo in found]


def recorded(capture: Capture, group: str) -> list[dict[str, float]]:
    record = json.loads((capture.folder / "truth" / "cameras.json").read_text())
    return [row.get("own_lens", {}) for row in record[group]]


def test_a_stabiliser_moves_what_is_drawn_by_the_offsets_that_the_truth_records(
    without: Capture, tmp_path: Path
) -> None:
    faulty = make_capture(tmp_path / "limb", replace(FEW, faults=Faults(stabiliser_px=3.0)))
    ideal = ideal_camera(FEW)
    told = np.array(
        [(row["cx"] - ideal.cx, row["cy"] - ideal.cy) for row in recorded(faulty, "calibration")]
    )
    pairs = zip(corners(faulty), corners(without), strict=True)
    moved = np.array([(shifted - still).mean(0) for shifted, still in pairs])
    np.testing.assert_allclose(moved, told, atol=0.01)
    assert np.abs(told).max() > 1.0
    assert recorded(without, "calibration") == [{}] * 3


def test_breathing_draws_every_photo_larger_or_smaller_about_its_principal_point(
    without: Capture, tmp_path: Path
) -> None:
    faulty = make_capture(tmp_path / "limb", replace(FEW, faults=Faults(breathing=0.004)))
    ideal = ideal_camera(FEW)
    middle = np.array([ideal.cx, ideal.cy])
    rows = recorded(faulty, "calibration")
    pairs = zip(corners(faulty), corners(without), rows, strict=True)
    for drawn, still, row in pairs:
        away = still - middle
        grown = ((drawn - middle) * away).sum() / (away**2).sum()
        assert grown == pytest.approx(row["fx"] / ideal.fx, abs=1e-4)  # 0.03 px at the edge
        assert abs(grown - 1) > 5e-4


def test_wandering_has_the_strength_that_was_asked_for_and_photos_differ() -> None:
    options = replace(
        FEW, photos=60, calibration_photos=60, faults=Faults(stabiliser_px=2.5, breathing=0.002)
    )
    truth, ideal = stage_truth(options), ideal_camera(options)
    for views in (truth.views, truth.calibration_views):
        lenses = np.array([view.camera.packed for view in views]) - ideal.packed
        assert lenses[:, 2:4].std() == pytest.approx(2.5, rel=0.25)
        assert (lenses[:, 0] / ideal.fx).std() == pytest.approx(0.002, rel=0.3)
        assert (lenses[:, 4:] == 0).all()
        assert len(np.unique(lenses[:, 2])) == 60
    assert truth.views[0].camera != truth.calibration_views[0].camera


def test_one_fault_does_not_change_another() -> None:
    alone = stage_truth(replace(FEW, faults=Faults(stabiliser_px=2.0)))
    both = stage_truth(replace(FEW, faults=Faults(stabiliser_px=2.0, breathing=0.001)))
    for one, other in zip(alone.views, both.views, strict=True):
        assert (one.camera.cx, one.camera.cy) == (other.camera.cx, other.camera.cy)
        np.testing.assert_array_equal(
            one.camera_from_world.matrix_3x4, other.camera_from_world.matrix_3x4
        )


def test_a_fault_of_negative_strength_is_refused() -> None:
    with pytest.raises(OptionsError, match="0 or more"):
        Faults(stabiliser_px=-1.0)
