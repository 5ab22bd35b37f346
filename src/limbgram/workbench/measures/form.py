"""Sheet for JSON: a measuring sheet as a tree; every sigma is one standard deviation."""

from typing import Any

from limbgram.findings import as_json
from limbgram.workbench.measures.sheet import MeasuringSheet, SheetRow


def sheet_tree(sheet: MeasuringSheet) -> dict[str, Any]:
    """A measuring sheet as a tree for JSON."""
    return {
        "kind": sheet.kind,
        "side": sheet.side,
        "doubt": None if sheet.doubt is None else as_json(sheet.doubt),
        "rows": [_row_tree(row) for row in sheet.rows],
    }


def _row_tree(row: SheetRow) -> dict[str, Any]:
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
        "doubt": None if row.doubt is None else as_json(row.doubt),
    }
