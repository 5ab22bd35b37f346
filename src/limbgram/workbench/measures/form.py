"""Form: a measuring sheet as a table for spreadsheets and as a tree for JSON.

Every sigma is one standard deviation; units stand in their own column.
"""

from typing import Any

from limbgram.core.spreadsheet import Cell, Table
from limbgram.findings import as_json, told
from limbgram.workbench.measures.sheet import MeasuringSheet, SheetRow

COLUMNS = ("name", "measure", "value", "unit", "sigma", "sigma_of_placing", "formula", "reason")
_DIGITS = 6


def sheet_table(sheet: MeasuringSheet, language: str = "en") -> Table:
    """A row for every figure of the form; those without an answer have the reason."""
    rows: list[tuple[Cell, ...]] = []
    for row in sheet.rows:
        figure = row.figure
        rows.append(
            (
                row.name,
                row.words[language],
                None if figure is None else _rounded(figure.value),
                row.unit,
                None if figure is None or figure.sigma is None else _rounded(figure.sigma),
                None if row.placing_sigma is None else _rounded(row.placing_sigma),
                row.formula,
                None if row.reason is None else told(row.reason, language),
            )
        )
    return Table(title="measuring sheet", columns=COLUMNS, rows=tuple(rows))


def sheet_tree(sheet: MeasuringSheet) -> dict[str, Any]:
    """The form for JSON."""
    return {
        "kind": sheet.kind,
        "side": sheet.side,
        "rows": [_row(row) for row in sheet.rows],
    }


def _row(row: SheetRow) -> dict[str, Any]:
    figure = row.figure
    return {
        "name": row.name,
        "words": dict(row.words),
        "unit": row.unit,
        "value": None if figure is None else figure.value,
        "sigma": None if figure is None else figure.sigma,
        "sigma_of_placing": row.placing_sigma,
        "formula": row.formula,
        "reason": None if row.reason is None else as_json(row.reason),
    }


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")
