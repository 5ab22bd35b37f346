"""Printed stickers become landmarks: from the sheet over photos to names on the limb."""

import json
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from limbgram import read_limb
from limbgram.cli.main import app
from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.options import SMALL
from limbgram.synthetic.props.stickers import SockSticker

pytestmark = pytest.mark.slow
NAMES = {40: "first", 41: "second", 42: "third"}
"""Not those of landmarks whose place on a limb is known: these stand anywhere."""
NOT_THERE = 57
SIDE_MM = 30.0
"""Of a mark: 43 pixels of these small photos."""


def limbgram(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Stickers as printed, a capture of a limb that has some of them, and its finished case."""
    folder = tmp_path_factory.mktemp("stickers")
    sheet = folder / "stickers.pdf"
    printed = limbgram("print", "stickers", "--sticker-mm", SIDE_MM, "--first", 40, "-o", sheet)
    assert printed.exit_code == 0, printed.output
    stuck = tuple(
        SockSticker(mark_id=number, around=0.31 * k, height=0.35 + 0.15 * k, side_mm=SIDE_MM)
        for k, number in enumerate(NAMES)
    )
    make_capture(folder / "capture", replace(SMALL, photos=11, stickers=stuck))
    board = ("--board", "14x10", "--square", 10)
    camera = folder / "camera.json"
    result = limbgram("calibrate", folder / "capture" / "calibration", *board, "-o", camera)
    assert result.exit_code == 0, result.output
    images = folder / "capture" / "images"
    result = limbgram("reconstruct", images, "--camera", camera, "-o", folder / "case")
    assert result.exit_code == 0, result.output
    return folder


def align(folder: Path, names: dict[int, str]) -> Result:
    file = folder / "names.json"
    file.write_text(json.dumps({str(number): name for number, name in names.items()}))
    surface = folder / "case" / "deliverables" / "surface.ply"
    words = ("--photos", folder / "case", "--stickers", file, "--side", "left", "--anterior=+y")
    return limbgram("align", surface, *words)


def test_the_sheet_has_the_stickers_that_were_stuck(folder: Path) -> None:
    plates = json.loads((folder / "stickers.json").read_text())["sheet"]["plates"]
    printed = {mark["mark_id"]: plate["side_mm"] for plate in plates for mark in plate["marks"]}
    assert [printed[number] for number in NAMES] == [SIDE_MM] * len(NAMES)


def test_named_stickers_are_landmarks_where_they_were_stuck(folder: Path) -> None:
    result = align(folder, NAMES)
    assert result.exit_code == 0, result.output
    limb = read_limb(folder / "case" / "deliverables" / "surface.ply")
    places = {one.name: one.position_mm for one in limb.landmarks}
    notes = json.loads((folder / "capture" / "truth" / "notes.json").read_text())["stickers"]
    true = {NAMES[one["mark_id"]]: np.array(one["place_mm"]) for one in notes}
    assert places.keys() == true.keys()
    off_mm = [
        np.linalg.norm(places[one] - places[other]) - np.linalg.norm(true[one] - true[other])
        for one, other in combinations(true, 2)
    ]
    assert 1e-4 < np.abs(off_mm).max() < 0.3


def test_a_named_sticker_that_no_photo_shows_is_refused_by_its_number(folder: Path) -> None:
    result = align(folder, NAMES | {NOT_THERE: "patella"})
    assert result.exit_code != 0
    said = " ".join(result.output.split())
    assert f"{NOT_THERE} (patella): no placed photo shows it" in said
