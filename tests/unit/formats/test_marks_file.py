"""The marks file and the kit: one reading of a ruler corrects every length that was printed."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.errors import CaseError, OptionsError
from limbgram.formats.board_file import read_board
from limbgram.formats.marks_file import PrintedKind, read_marks, write_marks
from limbgram.reconstruction.targets.plates import MarkPlate, PrintedMark
from limbgram.services.parse_capture import plates_of

BAR = MarkPlate(
    name="scale bar 1",
    side_mm=20.0,
    marks=(PrintedMark(mark_id=100, x_mm=0, y_mm=0), PrintedMark(mark_id=101, x_mm=200, y_mm=0)),
)


def printed(*words: str) -> tuple[int, str]:
    result = CliRunner().invoke(app, ["print", *words])
    return result.exit_code, " ".join(result.output.split())


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    kept = PrintedKind(kind="scale-bars", title="scale bars", page="a4", plates=(BAR,))
    write_marks(tmp_path / "bars.json", kept)
    assert read_marks(tmp_path / "bars.json") == kept


def test_one_reading_corrects_the_whole_kit(tmp_path: Path) -> None:
    folder = tmp_path / "kit"
    code, told = printed("kit", "-o", str(folder), "--measured-mm", "247.5", "--pixel-mm", "1")
    assert code == 0, told
    names = sorted(file.name for file in folder.iterdir())
    assert len(names) == 14
    assert read_board(folder / "scale-board.json").square_mm == pytest.approx(29.7)
    assert read_board(folder / "checkerboard.json").square_mm == pytest.approx(9.9)
    for name in ("scale-bars", "mat", "ring"):
        drawn = read_marks(folder / f"{name}.json")
        true = plates_of(folder / f"{name}.json")
        for before, after in zip(drawn.plates, true, strict=True):
            for one, other in zip(before.lengths(), after.lengths(), strict=True):
                assert other.length_mm == pytest.approx(0.99 * one.length_mm, abs=1e-9)
    with pytest.raises(OptionsError, match="without known lengths"):
        plates_of(folder / "stickers.json")
    # a measured size is not forgotten by printing again
    code, told = printed("scale-bars", "-o", str(folder / "scale-bars.pdf"))
    assert code == 3
    assert "would be lost" in told


def test_what_a_pixel_shows_is_told_in_one_way(tmp_path: Path) -> None:
    out = str(tmp_path / "sock.pdf")
    lens = ("--focal-35mm", "26", "--width-px", "1000")
    code, told = printed("sock", "-o", out, "--distance-mm", "500", *lens)
    assert code == 0
    assert "pixels of 0.692 mm" in told  # 500 x 36 / (26 x 1000)
    for words in (lens, ("--distance-mm", "500"), ("--distance-mm", "5", *lens, "--pixel-mm", "1")):
        code, told = printed("sock", "-o", out, *words)
        assert code == 2


def test_a_broken_or_foreign_file_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "bars.json"
    kept = PrintedKind(kind="scale-bars", title="scale bars", page="a4", plates=(BAR,))
    write_marks(file, kept)
    tree = json.loads(file.read_text())
    tree["sheet"]["plates"][0]["marks"][1]["mark_id"] = 100
    file.write_text(json.dumps(tree))
    with pytest.raises(CaseError, match="different numbers"):
        read_marks(file)
    file.write_text("{}")
    with pytest.raises(CaseError, match="no usable marks file"):
        read_marks(file)
    with pytest.raises(CaseError, match="is no marks file: it would be lost"):
        write_marks(file, kept)
    assert printed("kit", "-o", str(tmp_path / "kit.pdf"))[0] == 2


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("scale-bars", ("--board", "checkerboard:14x10:10")),
        ("checkerboard", ("--sticker-mm", "20")),
        ("stickers", ("--seed", "3")),
        ("ring", ("--distance-mm", "600", "--focal-35mm", "26", "--width-px", "4000")),
    ],
)
def test_a_sheet_s_option_is_not_taken_for_another_sheet(
    tmp_path: Path, kind: str, words: tuple[str, ...]
) -> None:
    code, told = printed(kind, "-o", str(tmp_path / "sheet.pdf"), *words)
    assert code == 2
    assert words[0] in told
    assert f"you write {kind}" in told
    assert not (tmp_path / "sheet.pdf").exists()
