"""The page: one HTML file, nothing from outside, no script; its first screen is for everybody.

In      the tree of an assessment, and pictures of the surface (PNG).
Out     HTML text.
"""

from collections.abc import Sequence
from html import escape
from typing import Any

from limbgram.report.accuracy.pages.adjustment import (
    camera_section,
    network_section,
    pose_section,
    residual_section,
)
from limbgram.report.accuracy.pages.sections import (
    against_truth,
    glossary_section,
    image_section,
    length_section,
    sigma_section,
)
from limbgram.report.accuracy.pages.words import MEANING, cards
from limbgram.report.document.html import card, document, shown, table
from limbgram.report.drawings.drawing import Picture


def accuracy_page(tree: dict[str, Any], pictures: Sequence[Picture]) -> str:
    """The assessment as one self-contained page."""
    title = f"How accurate is {tree['case']}?"
    word = tree["light"].upper()
    reason = tree["headline"].removeprefix(word).lstrip(": ")
    sections = (
        f"<h1>{escape(title)}</h1>",
        f'<p class="light {tree["light"]}"><b>{escape(word)}</b><span>{escape(reason)}</span></p>',
        _cards(tree),
        f'<p class="note">{escape(MEANING)}</p>',
        "<h2>What limits this result, and what to do</h2>",
        _findings(tree["findings"]),
        f'<p class="use">{escape(tree["intended_use"])}</p>',
        *(shown(picture) for picture in pictures),
        "<h2>Limits and what was found</h2>",
        _criteria(tree["criteria"]),
        *against_truth(tree),
        *sigma_section(tree),
        *length_section(tree),
        *residual_section(tree),
        *network_section(tree),
        *camera_section(tree),
        *pose_section(tree),
        *image_section(tree),
        *glossary_section(tree),
    )
    return document(title, sections)


def _cards(tree: dict[str, Any]) -> str:
    """The four figures that everybody asks for."""
    found = "".join(card(one.question, one.answer, one.note) for one in cards(tree))
    return f'<div class="cards">{found}</div>'


def _findings(found: Sequence[dict[str, str]]) -> str:
    if not found:
        return "<p>Nothing that would be worth another photograph.</p>"
    items = "".join(
        f'<li><span class="{"grave" if one["gravity"] == "serious" else "mild"}">'
        f"{escape(one['what'])}</span><em>&rarr; {escape(one['remedy'])}</em></li>"
        for one in found
    )
    return f'<ol class="do">{items}</ol>'


def _criteria(judged: Sequence[dict[str, Any]]) -> str:
    rows = [
        (
            one["title"],
            "not known" if one["value"] is None else f"{one['value']:.3g}",
            one["unit"],
            f"{one['green']:g}",
            "never" if one["red"] is None else f"{one['red']:g}",
            one["light"],
            one["sentence"],
        )
        for one in judged
    ]
    heads = ("figure", "#found", "unit", "#green up to", "#red beyond", "light", "in words")
    return table(heads, rows, [one["light"] == "red" for one in judged])
