"""The PDF of a record: two sheets to file and sign.

In      the tree of a record and its pictures.
Out     the bytes of a PDF (A4): the shape and its measures; what was done to it and how sure it is.
"""

from collections.abc import Sequence
from typing import Any

from limbgram.report.document.paper import Sheet, pdf_of
from limbgram.report.drawings.drawing import BLUE, FAINT, Picture
from limbgram.report.shape.record.advice import tape_checks
from limbgram.report.shape.record.pages import words

_MOST_LEVELS = 26
_FINDING_IN = 0.26
"""Room of a finding."""
_SENTENCE_IN = 0.13
"""What a reason in place of figures takes beside its first line."""
_SIGN = "Checked by: ____________________   Date: ______________   Signature: ____________________"

Tree = dict[str, Any]


def record_pdf(tree: Tree, pictures: Sequence[Picture]) -> bytes:
    """The record as a PDF of two pages."""
    return pdf_of((_first(tree, pictures).figure, _second(tree, pictures[1:]).figure))


def _first(tree: Tree, pictures: Sequence[Picture]) -> Sheet:
    sheet = _headed(tree, words.title(tree))
    sheet.cards(words.card_rows(tree))
    sheet.picture(pictures[0], 2.85)
    marks = words.landmark_rows(tree)
    if marks:
        sheet.table(words.LANDMARK_HEADS, marks[: sheet.rows_that_fit(4.5)], (1, 6, 2, 2, 2))
    sheet.heading("Measures by level")
    sheet.text(words.measure_note(tree), points=7, colour=FAINT)
    told = [one for one in tree["findings"] if one["topic"] != "tape"]
    rows = words.measure_rows(tree)
    sentences = sum(len(row) < len(words.MEASURE_HEADS) for row in rows)
    below_in = 1.0 + _FINDING_IN * len(told) + _SENTENCE_IN * sentences
    most = min(_MOST_LEVELS, sheet.rows_that_fit(below_in))
    step = max(1, -(-len(rows) // max(most, 1)))
    sheet.table(words.MEASURE_HEADS, rows[::step], (2, 3, 3, 3, 3, 3, 3.4))
    if step > 1:
        sheet.text(f"One level in {step}; all are on the page.", points=6.5, colour=FAINT)
    _findings(sheet, told)
    _tape_boxes(sheet, tree)
    return sheet


def _findings(sheet: Sheet, found: Sequence[dict[str, str]]) -> None:
    sheet.heading("Before anything is made from it")
    for idx, one in enumerate(found):
        if sheet.room_in < 0.85 + _FINDING_IN:
            sheet.text(f"and {len(found) - idx} more on the page", points=7, colour=FAINT)
            return
        weight = "bold" if one["gravity"] == "serious" else "normal"
        sheet.text(f"{idx + 1}. {one['what']}", points=7, weight=weight)
        sheet.text(f"→ {one['remedy']}", points=7, colour=FAINT)


def _tape_boxes(sheet: Sheet, tree: Tree) -> None:
    """Where a professional writes what the tape says."""
    checks = tape_checks(tree)
    if checks:
        sheet.heading("Girths, mm, and what the tape reads")
        boxes = "      ".join(
            f"at {height:g} mm: {girth:.1f}, tape ________" for height, girth in checks
        )
        sheet.text(boxes, points=8)
        sheet.text(
            f"Heights count from: {tree['measures']['reference']}. More than 1 mm or 1 % apart: "
            "find out why before anything is made.",
            points=7,
            colour=FAINT,
        )
    sheet.gap(0.12)
    sheet.text(_SIGN, points=8)


def _second(tree: Tree, pictures: Sequence[Picture]) -> Sheet:
    sheet = _headed(tree, f"{words.title(tree)}, second sheet")
    bias, files = words.bias_rows(tree), words.file_rows(tree)
    below_in = 1.5 + 0.16 * (len(bias) + len(files) + 2)
    if tree["comparison"] is not None:
        sheet.heading(f"Compared with {tree['comparison']['first']}")
        sheet.text(tree["comparison"]["verdict"], points=7.5)
        sheet.text(words.COMPARISON_NOTE, points=6.5, colour=FAINT)
    if tree["recipe"] is not None:
        sheet.heading("Edits and what they did")
        sheet.text(words.recipe_note(tree), points=7, colour=FAINT)
        sheet.text(words.LEDGER_NOTE, points=6.5, colour=FAINT)
        rows = words.ledger_rows(tree)
        kept = rows[: sheet.rows_that_fit(below_in + 0.2)]
        sheet.table(words.LEDGER_HEADS, kept, (0.7, 11, 2, 2, 1.7, 2, 1.7), points=6.5)
        if len(kept) < len(rows):
            more = f"and {len(rows) - len(kept)} more on the page"
            sheet.text(more, points=6.5, colour=FAINT)
    for picture in pictures:
        if sheet.room_in - below_in > 1.2:
            if tree["comparison"] is None:
                sheet.heading(picture.title)
            sheet.picture(picture, sheet.room_in - below_in)
    sheet.heading("What each step does to a radius")
    sheet.text(words.BIAS_NOTE, points=6.5, colour=FAINT)
    sheet.table(words.BIAS_HEADS, bias, (3.4, 2, 2, 2, 1.9, 11.6), points=6.1)
    sheet.heading("Files and versions")
    sheet.table(words.FILE_HEADS, files, (2.2, 2.6, 1, 9), points=6.3)
    sheet.text(f"{words.versions(tree)} {tree['names']}", points=6.5, colour=FAINT)
    return sheet


def _headed(tree: Tree, title: str) -> Sheet:
    sheet = Sheet()
    sheet.text(title, points=12, weight="bold")
    sheet.gap(0.06)
    sheet.banner(words.badge(tree), words.banner(tree), BLUE)
    sheet.foot(tree["intended_use"])
    return sheet
