"""The board file: the size that a steel rule found, whatever was drawn."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.errors import CaseError, OptionsError
from limbgram.formats.board_file import read_board, write_board
from limbgram.formats.printed_size import PrintedSize, Reading
from limbgram.reconstruction.targets.board import Board
from limbgram.services.parse_capture import parse_board

SCALE = Board.charuco("7x5", 30, 22, "4X4_50")


def printed(across_mm: float, down_mm: float | None = None) -> PrintedSize:
    down = None if down_mm is None else Reading(drawn_mm=150, measured_mm=down_mm)
    return PrintedSize(across=Reading(drawn_mm=250, measured_mm=across_mm), down=down)


@pytest.mark.parametrize(
    ("across_mm", "down_mm", "code"),
    [
        (262.4, None, None),  # 4.96 % longer
        (262.6, None, "file.print.off"),  # 5.04 %
        (237.4, None, "file.print.off"),
        (250.0, 150.14, None),  # 0.093 % longer down than across
        (250.0, 150.16, "file.print.stretched"),  # 0.107 %
    ],
)
def test_a_print_is_five_per_cent_off_at_most_and_one_in_a_thousand_uneven(
    across_mm: float, down_mm: float | None, code: str | None
) -> None:
    if code is None:
        assert printed(across_mm, down_mm).across.growth == across_mm / 250
        return
    with pytest.raises(OptionsError) as refused:
        printed(across_mm, down_mm)
    assert refused.value.finding.code == code


def test_a_board_that_was_not_measured_is_as_it_was_drawn(tmp_path: Path) -> None:
    write_board(tmp_path / "board.json", SCALE)
    assert read_board(tmp_path / "board.json") == SCALE


def test_a_print_one_per_cent_small_gives_squares_one_per_cent_small(tmp_path: Path) -> None:
    write_board(tmp_path / "board.json", SCALE, printed(247.5))
    board = parse_board(str(tmp_path / "board.json"))
    assert board.square_mm == pytest.approx(29.7, abs=1e-12)
    assert board.marker_mm == pytest.approx(21.78, abs=1e-12)
    assert board.corners_mm[5, 0] == pytest.approx(6 * 29.7, abs=1e-9)


def test_both_rulers_count_half(tmp_path: Path) -> None:
    write_board(tmp_path / "board.json", SCALE, printed(250.0, 150.12))
    assert read_board(tmp_path / "board.json").square_mm == pytest.approx(30 * 1.0004, abs=1e-9)


@pytest.mark.parametrize(
    ("across_mm", "down_mm", "words"),
    [(230.0, None, "100 %"), (270.0, None, "100 %"), (250.0, 150.3, "stretched")],
)
def test_a_print_that_cannot_serve_is_refused(
    across_mm: float, down_mm: float | None, words: str
) -> None:
    with pytest.raises(OptionsError, match=words):
        printed(across_mm, down_mm)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"square_mm": "30"}, "square_mm"),
        ({"square_mm": -30}, "30 mm"),
        ({"format": "limbgram camera"}, "it is a camera file. A camera is given as --camera"),
        ({"format": "limbgram marks"}, "Bars, a mat or a ring are given as --marks"),
        ({"format": "another board"}, "another board"),
        ({"version": 2}, "version 2"),
        ({"colour": "red"}, "colour"),
        ({"printed": {"across": {"drawn_mm": 250, "measured_mm": 25}}}, "100 %"),
        ({"printed": {"across": {"drawn_mm": 0, "measured_mm": 250}}}, "tells no size"),
        ({"dictionary": "9X9"}, "9X9"),
    ],
)
def test_a_changed_file_is_refused_with_its_place(
    tmp_path: Path, change: dict[str, object], words: str
) -> None:
    path = tmp_path / "board.json"
    write_board(path, SCALE)
    path.write_text(json.dumps(json.loads(path.read_text("utf-8")) | change), "utf-8")
    with pytest.raises(CaseError, match=words):
        read_board(path)


def test_what_is_no_board_file_is_not_written_over(tmp_path: Path) -> None:
    path = tmp_path / "camera.json"
    path.write_text("{}", "utf-8")
    with pytest.raises(CaseError, match="would be lost"):
        write_board(path, SCALE)
    assert path.read_text("utf-8") == "{}"


def test_the_command_prints_then_remembers_what_was_measured(tmp_path: Path) -> None:
    sheet = tmp_path / "board.pdf"
    asked = ["print", "scale-board", "-o", str(sheet)]
    assert CliRunner().invoke(app, asked).exit_code == 0
    drawn = sheet.read_bytes()
    assert drawn.startswith(b"%PDF")
    assert read_board(tmp_path / "board.json") == SCALE
    assert CliRunner().invoke(app, [*asked, "--measured-mm", "249.0"]).exit_code == 0
    assert read_board(tmp_path / "board.json").square_mm == pytest.approx(30 * 249 / 250)
    assert sheet.read_bytes() == drawn


def test_a_measured_size_is_not_forgotten_by_printing_again(tmp_path: Path) -> None:
    asked = ["print", "scale-board", "-o", str(tmp_path / "board.pdf")]
    assert CliRunner().invoke(app, [*asked, "--measured-mm", "249.0"]).exit_code == 0
    assert CliRunner().invoke(app, asked).exit_code == 3
    assert read_board(tmp_path / "board.json").square_mm == pytest.approx(30 * 249 / 250)


def test_a_checkerboard_is_no_charuco_board(tmp_path: Path) -> None:
    out = ["-o", str(tmp_path / "board.pdf"), "--board", "charuco:7x5:30:22:4X4_50"]
    answer = CliRunner().invoke(app, ["print", "checkerboard", *out])
    assert answer.exit_code == 2
    assert not list(tmp_path.iterdir())


def test_a_print_may_be_five_per_cent_off_and_a_thousandth_stretched() -> None:
    printed(262.4)
    printed(250.0, 150.14)
    for across_mm, down_mm, code in ((262.6, None, "off"), (250.0, 150.16, "stretched")):
        with pytest.raises(OptionsError) as refused:
            printed(across_mm, down_mm)
        assert refused.value.finding.code == f"file.print.{code}"
