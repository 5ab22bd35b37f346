"""What people write is understood, or refused with an example."""

import json
from pathlib import Path

import pytest
from tests.unit.file_sizes import require_takes_up_to
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.errors import OptionsError
from limbgram.reconstruction.scale.stated_lengths import TapedGirth
from limbgram.services.calibrate import CalibrateRequest
from limbgram.services.parse_capture import (
    DEFAULT_BOARD,
    parse_board,
    parse_box,
    parse_tape,
    read_distances,
)
from limbgram.services.parse_text import sticker_names


def test_boards() -> None:
    board = parse_board(DEFAULT_BOARD)
    assert (board.kind, board.columns, board.rows) == ("charuco", 7, 5)
    assert (board.square_mm, board.marker_mm, board.dictionary) == (30, 22, "4X4_50")
    plain = parse_board("checkerboard:14x10:9.98")
    assert (plain.kind, plain.inner, plain.square_mm) == ("checkerboard", (14, 10), 9.98)
    assert CalibrateRequest(board="14x10", square_mm=9.98).pattern() == plain


@pytest.mark.parametrize(
    "text",
    ["", "charuco", "charuco:7x5:30:22", "charuco:7:30:22:4X4_50", "charuco:7x5:a:22:4X4_50",
     "charuco:7x5:30:nan:4X4_50", "charuco:7x5:30:40:4X4_50", "charuco:7x5:30:22:9X9",
     "checkerboard:14x10", "checkerboard:14x10:-3", "chess:8x8:3"],
)  # fmt: skip
def test_what_is_no_board_is_refused(text: str) -> None:
    with pytest.raises(OptionsError):
        parse_board(text)


def test_a_board_without_its_square_is_refused() -> None:
    with pytest.raises(OptionsError, match="--square"):
        CalibrateRequest(board="14x10").pattern()


def test_boxes() -> None:
    assert parse_box("-80,-80,5, 80,80,400") == ((-80, -80, 5), (80, 80, 400))


@pytest.mark.parametrize("text", ["", "1,2,3", "1,2,3,0,3,4", "a,b,c,d,e,f", "0,0,0,1,1,nan"])
def test_what_is_no_box_is_refused(text: str) -> None:
    with pytest.raises(OptionsError, match="is no box"):
        parse_box(text)


PICKS = [{"photo": "a ö.jpg", "x_px": 1.5, "y_px": 2}, {"photo": "b.jpg", "x_px": 3, "y_px": 4}]
DISTANCE = {"label": "A-C", "length_mm": 120, "first": PICKS, "second": PICKS}


def test_distances(tmp_path: Path) -> None:
    file = tmp_path / "d.json"
    file.write_text(json.dumps([DISTANCE, DISTANCE]), "utf-8")
    one, _ = read_distances(file)
    assert (one.label, one.length_mm) == ("A-C", 120)
    file.write_text(json.dumps({"about": "a test", "distances": [DISTANCE]}), "utf-8")
    assert read_distances(file) == (one,)


@pytest.mark.parametrize(
    "content",
    ["", "{", "[1]", "{}", json.dumps(DISTANCE), json.dumps([{**DISTANCE, "length_mm": "far"}]),
     json.dumps([{k: v for k, v in DISTANCE.items() if k != "second"}]),
     json.dumps([{**DISTANCE, "length_mm": -1}]),
     json.dumps([{**DISTANCE, "first": [{"photo": 1}]}])],
)  # fmt: skip
def test_what_is_no_distance_is_refused(tmp_path: Path, content: str) -> None:
    file = tmp_path / "d.json"
    file.write_text(content, "utf-8")
    with pytest.raises(OptionsError):
        read_distances(file)


def test_a_missing_distance_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OptionsError, match="cannot be read"):
        read_distances(tmp_path / "none.json")


def test_taped_girths() -> None:
    assert parse_tape("150=354") == TapedGirth(girth_mm=354, height_mm=150)
    assert parse_tape(" Widest = 354.5 ") == TapedGirth(girth_mm=354.5)
    assert parse_tape("150=354+-1.96") == TapedGirth(girth_mm=354, height_mm=150, sigma_mm=1.0)
    assert parse_tape("150=354 ± 3.92") == TapedGirth(girth_mm=354, height_mm=150, sigma_mm=2.0)
    assert parse_tape("-20=354").place == "at -20 mm above board or table"


@pytest.mark.parametrize(
    "text", ["", "354", "150=", "=354", "150=a", "max=354", "150=35e9", "1=nan"]
)
def test_what_is_no_taped_girth_is_refused(text: str) -> None:
    with pytest.raises(OptionsError):
        parse_tape(text)


@pytest.mark.parametrize("margin", ["nan", "inf", "-5", "101"])
def test_a_margin_that_is_no_length_is_refused_by_its_name(margin: str, tmp_path: Path) -> None:
    asked = ["masks", str(tmp_path), "-o", str(tmp_path / "out"), "--margin", margin, "--json"]
    said = CliRunner().invoke(app, asked)
    assert said.exit_code == OptionsError("").exit_code
    error = json.loads(said.stdout)["error"]
    assert error["kind"] == "OptionsError"
    assert "argin" in error["message"]
    assert not (tmp_path / "out").exists()


def test_distances_are_read_up_to_4_mb(tmp_path: Path) -> None:
    require_takes_up_to(read_distances, tmp_path / "distances.json", 4_000_000)


def test_names_of_stickers_are_read_up_to_100_kb(tmp_path: Path) -> None:
    require_takes_up_to(sticker_names, tmp_path / "stickers.json", 100_000)
