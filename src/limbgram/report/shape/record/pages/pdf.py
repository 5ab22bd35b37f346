"""The PDF of a record: two sheets to file and sign.

In      the tree of a record and its pictures.
Out     the bytes of a PDF (A4): the shape and its measures; what was done to it and how sure it is.
"""

from collections.abc import Sequence
from typing import Any

from limbgram.report.document.paper import Sheet, pdf_of
from limbgram.report.drawings.drawing import BLUE, FAINT
from limbgram.report.pictures import Picture
from limbgram.report.shape.record.pages import words
from limbgram.report.shape.record.advice import tape_checks

_MOST_LEVELS = 26
_SIGN = "Checked by: ____________________   Date: ______________   Signature: ____________________"

Tree = dict[str, Any]


def record_pdf(tree: Tree, pictures: Sequence[Picture]) -> bytes:
    """The record as a PDF of two pages."""
    return pdf_of((_first(tree, pictures).figure, _second(tree, pictures[1:]).figure))


def _first(tree: Tree, pictures: Sequence[Picture]) -> Sheet:
    sheet = _headed(tree, words.title(tree))
    sheet.table(
        [row[0] for row in words.card_rows(tree)],
        [[f"{row[1]} ({row[2]})" for row in words.card_rows(tree)]],
        [1.0] * len(words.card_rows(tree)),
        points=6.2,
    )
    sheet.picture(pictures[0], 3.1)
    marks = words.landmark_rows(tree)
    if marks:
        sheet.table(words.LANDMARK_HEADS, marks[: sheet.rows_that_fit(4.5)], (1, 6, 2, 2, 2))
    sheet.heading("Measures by level")
    sheet.text(words.measure_note(tree), points=7, colour=FAINT)
    most = min(_MOST_LEVELS, sheet.rows_that_fit(1.1))
    rows = words.measure_rows(tree)
    step = max(1, -(-len(rows) // max(most, 1)))
    sheet.table(words.MEASURE_HEADS, rows[::step], (2, 3, 3, 3, 3, 3, 3.4))
    if step > 1:
        sheet.text(f"Every {step}. level; all are on the page.", points=6.5, colour=FAINT)
    _tape_boxes(sheet, tree)
    return sheet


def _tape_boxes(sheet: Sheet, tree: Tree) -> None:
    """Where a professional writes what the tape says."""
    checks = tape_checks(tree)
    if checks:
        sheet.heading("Read by tape before fabrication")
        boxes = "      ".join(
            f"at {height:g} mm: {girth:.1f}, tape ________" for height, girth in checks
        )
        sheet.text(boxes, points=8)
    sheet.gap(0.12)
    sheet.text(_SIGN, points=8)


def _second(tree: Tree, pictures: Sequence[Picture]) -> Sheet:
    sheet = _headed(tree, f"{words.title(tree)}, second sheet")
    bias, files = words.bias_rows(tree), words.file_rows(tree)
    below_in = 1.35 + 0.16 * (len(bias) + len(files) + 2)
    if tree["comparison"] is not None:
        sheet.heading(f"Compared with {tree['comparison']['first']}")
        sheet.text(tree["comparison"]["verdict"], points=7.5)
    if tree["recipe"] is not None:
        sheet.heading("Edits and what they did")
        sheet.text(words.recipe_note(tree), points=7, colour=FAINT)
        rows = words.ledger_rows(tree)
        kept = rows[: sheet.rows_that_fit(below_in + 0.2)]
        sheet.table(words.LEDGER_HEADS, kept, (0.7, 11, 2, 2, 1.7, 2, 1.7), points=6.5)
        if len(kept) < len(rows):
            more = f"and {len(rows) - len(kept)} more on the page"
            sheet.text(more, points=6.5, colour=FAINT)
    for picture in pictures:
        if sheet.room_in - below_in > 1.2:
            sheet.picture(picture, sheet.room_in - below_in)
    sheet.heading("What each step does to a radius")
    sheet.table(words.BIAS_HEADS, bias, (3.2, 1.6, 1.6, 1.6, 12.5), points=6.3)
    sheet.heading("Files and versions")
    sheet.table(words.FILE_HEADS, files, (2.2, 2.6, 1, 9), points=6.3)
    sheet.text(f"{words.versions(tree)} {tree['names']}", points=6.5, colour=FAINT)
    return sheet


def _headed(tree: Tree, title: str) -> Sheet:
    sheet = Sheet()
    sheet.text(title, points=12, weight="bold")
    sheet.gap(0.06)
    sheet.banner(words.SIDES[tree["side"]], words.banner(tree), BLUE)
    sheet.foot(tree["intended_use"])
    return sheet
