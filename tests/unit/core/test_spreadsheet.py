"""Tables for spreadsheets hold numbers that a spreadsheet of any country takes for the same."""

import io
import math
import shutil
import subprocess
from datetime import date
from pathlib import Path

import pytest

from limbgram.core.spreadsheet import Table, csv_of, heading, several, xlsx_of

openpyxl = pytest.importorskip("openpyxl", reason="openpyxl is not installed")

TABLE = Table(
    title="levels",
    columns=("height_mm", "tape_mm", "area_mm2", "volume_below_ml", "loops", "reason", "conflict"),
    rows=(
        (65.213, 354.0, 9876.5432, 1234.5, 1, "", False),
        (-50.0, None, 0.001, 12.125, 2, "=SUM(A1:A9), with „quotes“; and ü", True),
    ),
)
GERMAN = 1031
"""Microsoft's number of the language, as LibreOffice's filter takes it."""


def test_a_workbook_has_numbers_texts_and_units_of_its_own_kind() -> None:
    sheet = openpyxl.load_workbook(io.BytesIO(xlsx_of([TABLE])))["levels"]
    heads, *rows = sheet.iter_rows(values_only=True)
    assert heads[:4] == ("height [mm]", "tape [mm]", "area [mm²]", "volume below [mL]")
    wanted = [tuple(None if cell == "" else cell for cell in row) for row in TABLE.rows]
    assert rows == wanted
    assert {type(cell) for cell in rows[0][:4]} <= {int, float}
    assert sheet["F3"].data_type == "s"  # no formula


def test_a_workbook_has_a_sheet_for_each_table_and_the_same_bytes_each_time() -> None:
    other = Table(title="volumes", columns=("from_mm",), rows=((1.5,),))
    content = xlsx_of([TABLE, other])
    assert openpyxl.load_workbook(io.BytesIO(content)).sheetnames == ["levels", "volumes"]
    assert content == xlsx_of([TABLE, other])


def test_a_day_is_a_day_and_a_text_too_long_for_a_cell_keeps_its_beginning() -> None:
    """A cell holds 32,767 letters; of more the writer would leave it empty without a word."""
    long = "IMG_0001.jpg: blurred; " * 2000
    table = Table(title="t", columns=("day", "left_out"), rows=((date(2026, 3, 2), long),))
    sheet = openpyxl.load_workbook(io.BytesIO(xlsx_of([table])))["t"]
    assert sheet["A2"].is_date
    assert sheet["A2"].value.date() == date(2026, 3, 2)
    assert sheet["B2"].value == long[:32_766] + "\u2026"
    assert csv_of(table).splitlines()[1].startswith("2026-03-02,IMG_0001")


def test_text_with_a_decimal_comma_parts_columns_by_semicolons() -> None:
    lines = csv_of(TABLE, "comma").removeprefix("\ufeff").splitlines()
    assert lines[1] == "65,213;354,0;9876,5432;1234,5;1;;false"
    assert csv_of(TABLE).splitlines()[1] == "65.213,354.0,9876.5432,1234.5,1,,false"
    assert several([1.5, 2.25], "comma") == "1,5 2,25"


def test_a_zero_has_no_sign() -> None:
    """What is rounded from just below nothing."""
    table = Table(title="t", columns=("off_mm", "name"), rows=((round(-0.0004, 3), "-0.0"),))
    assert csv_of(table, "comma").splitlines()[1] == "0,0;'-0.0"
    sheet = openpyxl.load_workbook(io.BytesIO(xlsx_of([table])))["t"]
    assert math.copysign(1, sheet["A2"].value) == 1
    assert several([-0.0, -1.5]) == "0.0 -1.5"


def test_headings_have_units_in_brackets() -> None:
    assert heading("sigma_tape_mm") == "sigma tape [mm]"
    assert heading("from") == "from"
    assert heading("others_mm") == "others [mm]"


@pytest.mark.slow
def test_a_german_spreadsheet_reads_the_numbers_that_were_written(tmp_path: Path) -> None:
    """And takes a text with decimal points for other numbers, which is why there are the others."""
    if shutil.which("soffice") is None:
        pytest.skip("LibreOffice is not installed")
    (tmp_path / "book.xlsx").write_bytes(xlsx_of([TABLE]))
    (tmp_path / "comma.csv").write_text(csv_of(TABLE, "comma"), "utf-8")
    (tmp_path / "point.csv").write_text(csv_of(TABLE), "utf-8")
    wanted = [row[:4] for row in TABLE.rows]
    assert _in_german(tmp_path / "book.xlsx") == wanted
    assert _in_german(tmp_path / "comma.csv", apart=";") == wanted
    assert _in_german(tmp_path / "point.csv", apart=",")[0][0] == 65213


def _in_german(path: Path, apart: str = "") -> list[tuple[object, ...]]:
    """The first four cells of each row as LibreOffice has them after opening the file in German."""
    folder = path.parent / f"seen-{path.stem}"
    command = ["soffice", f"-env:UserInstallation=file://{path.parent}/profile", "--headless"]
    if apart:  # parted by, quoted by, UTF-8, from line 1, no formats, language
        filtered = f"Text - txt - csv (StarCalc):{ord(apart)},34,76,1,,{GERMAN},false,true"
        command.append(f"--infilter={filtered}")
    command += ["--convert-to", "xlsx", "--outdir", str(folder), str(path)]
    subprocess.run(command, check=True, timeout=120, capture_output=True, env=_german())
    rows = openpyxl.load_workbook(folder / f"{path.stem}.xlsx").active.iter_rows(values_only=True)
    return [row[:4] for row in list(rows)[1:]]


def _german() -> dict[str, str]:
    return {"LANG": "de_DE.UTF-8", "LC_ALL": "de_DE.UTF-8", "PATH": "/usr/bin:/bin:/usr/local/bin"}
