"""Tables for spreadsheets: a workbook of typed cells, or CSV.

A workbook (.xlsx, ECMA-376) holds numbers as numbers, which every program shows with its user's
decimal sign. In a CSV, `65.213` is read as 65213 where the comma is the decimal sign: there it has
decimal commas, and semicolons between the columns.
"""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime
from math import isfinite
from typing import Literal

Decimal = Literal["point", "comma"]
"""Decimal sign of a CSV; with a comma its columns are separated by semicolons."""
Cell = str | float | int | bool | date | None

_UNITS = {"mm": "mm", "mm2": "mm\u00b2", "mm3": "mm\u00b3", "ml": "mL"}
"""Units by the ending of a column's name."""
_MADE = datetime(2000, 1, 1, tzinfo=UTC)
"""Fixed date of a workbook, so that the same table gives the same bytes."""
_LONGEST_TITLE, _WIDEST = 31, 60
_LONGEST_CELL = 32_767
"""Characters that a cell of a workbook holds; longer texts are truncated."""
_NUMBERS = "0.00##"
_COUNTED = "0"
_DAYS = "yyyy-mm-dd"
_FORMULA_STARTS = ("=", "+", "-", "@", "\t")
_BYTE_ORDER_MARK = "\ufeff"
"""Tells Excel that a CSV is UTF-8."""


@dataclass(frozen=True, kw_only=True)
class Table:
    """Rows of cells under names that end in their unit, as `tape_mm`."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]

    def __post_init__(self) -> None:
        rows = tuple(tuple(_unsigned(cell) for cell in row) for row in self.rows)
        object.__setattr__(self, "rows", rows)


def csv_of(table: Table, decimal: Decimal = "point") -> str:
    """The table as CSV, without thousands separators."""
    text = io.StringIO()
    delimiter = ";" if decimal == "comma" else ","
    sheet = csv.writer(text, lineterminator="\n", delimiter=delimiter)
    sheet.writerow(table.columns)
    for row in table.rows:
        sheet.writerow([_as_text(cell, decimal) for cell in row])
    return (_BYTE_ORDER_MARK if decimal == "comma" else "") + text.getvalue()


def xlsx_of(tables: Sequence[Table]) -> bytes:
    """A workbook with a sheet for each table; headings have units in brackets."""
    from xlsxwriter import Workbook  # a twentieth of a second, for workbooks alone

    content = io.BytesIO()
    book = Workbook(content, {"in_memory": True, "strings_to_formulas": False})
    book.set_properties({"created": _MADE, "comments": "limbgram"})
    head = book.add_format({"bold": True, "text_wrap": True, "valign": "top", "bottom": 1})
    numbers, counted, days = (
        book.add_format({"num_format": one}) for one in (_NUMBERS, _COUNTED, _DAYS)
    )
    for table in tables:
        sheet = book.add_worksheet(table.title[:_LONGEST_TITLE])
        sheet.freeze_panes(1, 1)
        for column, name in enumerate(table.columns):
            sheet.write_string(0, column, heading(name), head)
            longest = max((len(str(row[column])) for row in table.rows), default=0)
            sheet.set_column(column, column, min(max(12, longest + 2), _WIDEST))
        for number, row in enumerate(table.rows, 1):
            for column, cell in enumerate(row):
                match cell:
                    case None | "":
                        pass
                    case bool():
                        sheet.write_boolean(number, column, cell)
                    case str() if len(cell) > _LONGEST_CELL:
                        sheet.write_string(number, column, f"{cell[: _LONGEST_CELL - 1]}\u2026")
                    case str():
                        sheet.write_string(number, column, cell)
                    case date():
                        day = datetime(cell.year, cell.month, cell.day)
                        sheet.write_datetime(number, column, day, days)
                    case int():
                        sheet.write_number(number, column, cell, counted)
                    case float() if isfinite(cell):
                        sheet.write_number(number, column, cell, numbers)
                    case _:
                        sheet.write_string(number, column, str(cell))
    book.close()
    return content.getvalue()


def heading(name: str) -> str:
    """A column's name for people: `sigma_tape_mm` is sigma tape [mm]."""
    words = name.split("_")
    if len(words) > 1 and words[-1] in _UNITS:
        return f"{' '.join(words[:-1])} [{_UNITS[words[-1]]}]"
    return " ".join(words)


def _as_text(cell: Cell, decimal: Decimal) -> str:
    if cell is None:
        return ""
    if isinstance(cell, bool):
        return str(cell).lower()
    if isinstance(cell, str):
        # An apostrophe, as against CSV injection: else a spreadsheet would take it for a formula.
        return f"'{cell}" if cell[:1] in _FORMULA_STARTS else cell
    return str(cell).replace(".", ",") if decimal == "comma" else str(cell)


def several(numbers: Sequence[float], decimal: Decimal = "point") -> str:
    """Numbers in one cell, separated by spaces."""
    return " ".join(_as_text(_unsigned(number), decimal) for number in numbers)


def _unsigned(cell: Cell) -> Cell:
    """The cell, with 0.0 for -0.0."""
    return 0.0 if isinstance(cell, float) and cell == 0.0 else cell
