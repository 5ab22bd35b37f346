"""The page of a record: one HTML file, nothing from outside, no script.

In      the tree of a record and its pictures.
Out     HTML text; its first screen says side, unit and what to check.
"""

from collections.abc import Iterator, Sequence
from html import escape
from typing import Any

from limbgram.report.document.html import card, document, shown, table
from limbgram.report.drawings.drawing import Picture
from limbgram.report.shape.record.pages import words

Tree = dict[str, Any]


def record_page(tree: Tree, pictures: Sequence[Picture]) -> str:
    """The record as one self-contained page."""
    title = words.title(tree)
    cards = "".join(card(*row) for row in words.card_rows(tree))
    sections = (
        f"<h1>{escape(title)}</h1>",
        f'<p class="light blue"><b>{words.badge(tree)}</b>'
        f"<span>{escape(words.banner(tree))}</span></p>",
        f'<div class="cards">{cards}</div>',
        f'<p class="use">{escape(tree["intended_use"])}</p>',
        "<h2>Before anything is made from it</h2>",
        _findings(tree["findings"]),
        shown(pictures[0]),
        *_landmarks(tree),
        "<h2>Measures by level</h2>",
        f'<p class="note">{escape(words.measure_note(tree))}</p>',
        table(words.MEASURE_HEADS, words.measure_rows(tree)),
        *_inside(tree),
        *_comparison(tree),
        *(shown(picture) for picture in pictures[1:]),
        *_recipe(tree),
        "<h2>What each step does to a radius</h2>",
        f'<p class="note">{escape(words.BIAS_NOTE)}</p>',
        table(words.BIAS_HEADS, words.bias_rows(tree)),
        "<h2>Files and versions</h2>",
        f'<p class="note">{escape(tree["names"])}</p>',
        table(words.FILE_HEADS, words.file_rows(tree)),
        f'<p class="note">{escape(words.versions(tree))}</p>',
    )
    return document(f"{title}, {words.badge(tree)}", sections)


def _findings(found: Sequence[dict[str, str]]) -> str:
    items = "".join(
        f'<li><span class="{"grave" if one["gravity"] == "serious" else "mild"}">'
        f"{escape(one['what'])}</span><em>&rarr; {escape(one['remedy'])}</em></li>"
        for one in found
    )
    return f'<ol class="do">{items}</ol>'


def _landmarks(tree: Tree) -> Iterator[str]:
    yield "<h3>Landmarks, in the limb's axes</h3>"
    rows = words.landmark_rows(tree)
    yield table(words.LANDMARK_HEADS, rows) if rows else "<p>None were marked.</p>"


def _inside(tree: Tree) -> Iterator[str]:
    if tree["inside"] is None:
        return
    yield "<h3>Measures of the inside by level</h3>"
    yield f'<p class="note">{words.inside_note()}</p>'
    yield table(words.MEASURE_HEADS, words.inside_rows(tree))


def _comparison(tree: Tree) -> Iterator[str]:
    compared = tree["comparison"]
    if compared is None:
        return
    yield f"<h2>Compared with {escape(compared['first'])}</h2>"
    yield f"<p>{escape(compared['verdict'])}</p>"
    yield f'<p class="note">{words.COMPARISON_NOTE}</p>'
    yield table(words.CHANGE_HEADS, words.change_rows(tree))


def _recipe(tree: Tree) -> Iterator[str]:
    if tree["recipe"] is None:
        return
    yield "<h2>Edits and what they did</h2>"
    yield f'<p class="note">{escape(words.recipe_note(tree))}</p>'
    yield table(words.LEDGER_HEADS, words.ledger_rows(tree))
    yield f'<p class="note">{words.LEDGER_NOTE}</p>'
    yield "<h3>Girths after each edit, by height in the limb frame (contour, mm)</h3>"
    yield table(*words.girth_ledger(tree))
