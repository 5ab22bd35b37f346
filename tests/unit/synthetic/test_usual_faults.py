"""Usual faults, by name: each is switched on and recorded, alone and with the others."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.faults import Faults
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.rendering.shading import Shadow
from limbgram.synthetic.usual_faults import PHONE, Fault, with_faults

TINY = CaptureOptions(
    photos=3,
    width_px=240,
    height_px=180,
    distance_mm=500.0,
    lens=PHONE,
    calibration_photos=1,
    mesh_step_mm=3.0,
    samples=1,
)


def test_every_fault_changes_the_capture_and_all_are_what_each_is_alone() -> None:
    everything = with_faults(TINY, Fault)
    strengths = {name for name, value in vars(everything.faults).items() if value}
    assert strengths == set(vars(Faults()))
    for fault in Fault:
        alone = with_faults(TINY, [fault])
        assert alone != TINY
        for name, value in vars(alone.faults).items():
            assert value in (getattr(Faults(), name), getattr(everything.faults, name))
    assert everything.board is not None
    assert (everything.board.sag_mm, everything.board.stretch) == (0.5, 0.002)
    assert everything.lighting.shadow is Shadow.MOVING
    assert everything.lighting.gloss > 1


@pytest.mark.parametrize(
    ("fault", "name", "strength"),
    [
        (Fault.STABILISER, "stabiliser_px", 0.6),  # 10 px of 4000
        (Fault.BREATHING, "breathing", 0.00051),
        (Fault.BLUR, "pupil_mm", 4.25 / 1.8),
    ],
)
def test_strengths_follow_the_camera(fault: Fault, name: str, strength: float) -> None:
    assert getattr(with_faults(TINY, [fault]).faults, name) == pytest.approx(strength, rel=0.01)


def test_twice_the_strength_is_twice_of_each() -> None:
    usual, twice = with_faults(TINY, Fault), with_faults(TINY, Fault, 2.0)
    for name in set(vars(Faults())) - {"stored_again", "hand_deg_s", "hand_mm_s"}:
        assert getattr(twice.faults, name) == pytest.approx(2 * getattr(usual.faults, name))
    assert (twice.faults.stored_again, twice.jpeg_quality) == (60, 76)
    assert usual.board is not None
    assert twice.board == replace(usual.board, sag_mm=1.0, stretch=0.004)
    assert twice.lighting.gloss == pytest.approx(23.0)


def test_a_capture_without_a_board_stays_without_one() -> None:
    bare = replace(TINY, board=None)
    assert with_faults(bare, Fault).board is None


def test_all_faults_together_are_photographed_and_recorded(tmp_path: Path) -> None:
    capture = make_capture(tmp_path / "limb", with_faults(TINY, Fault))
    notes = json.loads((capture.folder / "truth" / "notes.json").read_text())
    assert notes["faults"]["creep_mm"] == 0.3
    board = json.loads((capture.folder / "truth" / "board.json").read_text())["scene_board"]
    assert (board["stretch_down_columns"], board["sag_along_rows_mm"]) == (0.002, 0.5)
    assert len(list((capture.folder / "images").iterdir())) == 3
