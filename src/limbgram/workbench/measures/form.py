"""Form: a measuring sheet as CSV for spreadsheets and as a tree for JSON.

Every sigma is one standard deviation; units stand in their own column.
"""

import csv
import io
from typing import Any

from limbgram.findings import as_json, told
from limbgram.workbench.measures.sheet import MeasuringSheet, SheetRow

COLUMNS = ("name", "measure", "value", "unit", "sigma", "sigma_of_placing", "formula", "reason")
_DIGITS = 6


def sheet_csv(sheet: MeasuringSheet, language: str = "en") -> str:
    """A row for every figure of the form; those without an answer have the reason."""
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(COLUMNS)
    for row in sheet.rows:
        figure = row.figure
        lines.writerow(
            [
                row.name,
                row.words[language],
                "" if figure is None else _number(figure.value),
                row.unit,
                "" if figure is None or figure.sigma is None else _number(figure.sigma),
                "" if row.placing_sigma is None else _number(row.placing_sigma),
                row.formula,
                "" if row.reason is None else told(row.reason, language),
            ]
        )
    return text.getvalue()


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


def _number(value: float) -> str:
    return f"{value:.{_DIGITS}g}"
