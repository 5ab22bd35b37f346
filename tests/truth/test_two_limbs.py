"""Two casts beside one board, and one that was turned there: told by check and reconstruction."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np
import pytest

from limbgram.cases.capture_check import check_sources
from limbgram.core.errors import PlacementError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.run import Run
from limbgram.reconstruction.calibration.cameras import Calibration, cameras_for
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.pipeline import DEFAULTS, Placing, place_photos
from limbgram.reconstruction.targets.board_detection import find_board
from limbgram.synthetic import (
    PHONE,
    SCALE_BOARD,
    CaptureOptions,
    LimbKind,
    Movement,
    Paint,
    make_capture,
    truth,
)
from limbgram.synthetic.capture import Capture

pytestmark = pytest.mark.slow
CAST = CaptureOptions(
    seed=5, photos=10, width_px=600, height_px=450, distance_mm=500.0, lens=PHONE,
    calibration_photos=0, samples=2, mesh_step_mm=2.0,
)  # fmt: skip
OTHER = replace(CAST, kind=LimbKind.BULBOUS, paint=Paint.PRINT, photos=11)
"""In the same room beside the same board: these follow from the seed."""


def placed(folder: Path, lens: Calibration) -> Placing:
    photos = read_photos([folder])
    cameras = cameras_for(photos, [lens])
    return place_photos(photos, cameras, DEFAULTS, Run(), find_board(photos, SCALE_BOARD.board))


def test_two_casts_in_one_folder_are_refused_and_both_named(
    tmp_path: Path, lens_of: Callable[[Capture], Calibration]
) -> None:
    folder = tmp_path / "both"
    folder.mkdir()
    for name, options in (("a", CAST), ("b", OTHER)):
        capture = make_capture(tmp_path / name, options)
        lens = lens_of(capture)
        for photo in capture.photos:
            shutil.copy(photo, folder / f"{name}_{photo.name}")
    with pytest.raises(PlacementError) as refusal:
        placed(folder, lens)
    checked = check_sources([folder], [lens], SCALE_BOARD.board, Run())
    assert not checked.go
    for finding in (refusal.value.finding, checked.findings[0]):
        assert finding.code == "placing.two_limbs"
        groups = [cast(tuple[str, ...], finding.values[which]) for which in ("one", "other")]
        assert {frozenset(name[0] for name in group) for group in groups} == {
            frozenset("a"), frozenset("b"),
        }  # fmt: skip
        assert sum(map(len, groups)) == CAST.photos + OTHER.photos


def test_a_cast_turned_beside_its_board_is_told_in_two_poses(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    lens_of: Callable[[Capture], Calibration],
) -> None:
    """By 110 degrees about its axis, after the first of two rounds."""
    rounds, first = 18, 11

    def turned(_: Movement, photos: int, __: int, middle: Vector3) -> tuple[Rigid, ...]:
        turn = Rigid.from_rotation_vector(np.radians([0.0, 0.0, 110.0]), np.zeros(3))
        there = Rigid(turn.rotation, middle - turn.apply(middle[None])[0])
        return tuple(Rigid.identity() if k < first else there for k in range(photos))

    monkeypatch.setattr(truth, "motions", turned)
    options = replace(CAST, photos=rounds, rings=2, movement=Movement())
    capture = make_capture(tmp_path / "turned", options)
    found = placed(tmp_path / "turned" / "images", lens_of(capture))
    sides = [{*side.photos} for side in found.poses.sides]
    assert len(sides) == 2
    second = {*range(first, rounds)}
    # a photo whose matches on the cast outnumber those of the room may stand by the cast
    assert min(len(second ^ side) for side in sides) <= 1
    assert len(found.scene.placed) == rounds
