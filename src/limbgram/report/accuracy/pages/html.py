"""The page: one HTML file, nothing from outside, no script; its first screen is for everybody.

In      the tree of an assessment, and pictures of the surface (PNG).
Out     HTML text.
"""

import base64
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
from limbgram.report.page import table
from limbgram.report.pictures import Picture

_STYLE = """
:root { color-scheme: light; --green: #2f7d4f; --amber: #a8690a; --red: #b8403a; }
body { font: 15px/1.5 system-ui, "Segoe UI", "Helvetica Neue", Arial, sans-serif;
  color: #22303a; background: #fff; max-width: 66rem; margin: 1.4rem auto 4rem;
  padding: 0 1.2rem; }
h1 { font-size: 1.35rem; margin: 0 0 .6rem; } h2 { font-size: 1.12rem; margin: 2.4rem 0 .4rem;
  border-top: 1px solid #dde4e8; padding-top: 1rem; }
h3 { font-size: .98rem; margin: 1.2rem 0 .2rem; }
.light { display: flex; gap: 1rem; align-items: flex-start; padding: .9rem 1.1rem;
  border-left: .5rem solid; font-size: 1.16rem; margin: 0 0 1rem; }
.light b { flex: none; color: #fff; border-radius: .3rem; padding: .05rem .6rem;
  letter-spacing: .04em; }
.green { border-color: var(--green); background: #f0f7f2; } .green b { background: var(--green); }
.amber { border-color: var(--amber); background: #fdf6ea; } .amber b { background: var(--amber); }
.red { border-color: var(--red); background: #fbf0ef; } .red b { background: var(--red); }
.cards { display: grid; grid-template-columns: repeat(auto-fit, minmax(13rem, 1fr)); gap: .8rem; }
.card { border: 1px solid #dde4e8; border-radius: .4rem; padding: .6rem .8rem; }
.card strong { display: block; font-size: 1.45rem; line-height: 1.2; }
.card small, .use, .note, figcaption { color: #55636c; font-size: .88rem; }
ol.do { padding-left: 1.3rem; } ol.do li { margin-bottom: .55rem; } ol.do em { font-style: normal;
  display: block; } .grave { font-weight: 600; }
figure { margin: .4rem 0 1rem; } img, svg { max-width: 100%; height: auto; }
.two { display: grid; grid-template-columns: repeat(auto-fit, minmax(22rem, 1fr)); gap: 1.2rem; }
table { border-collapse: collapse; font-size: .86rem; } td, th { padding: .2rem .8rem .2rem 0;
  text-align: left; vertical-align: top; border-bottom: 1px solid #e4e9ec; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
tr.bad td { color: var(--red); } .wide { overflow-x: auto; }
@media print { h2 { break-after: avoid; } figure, tr { break-inside: avoid; } }
"""


def accuracy_page(tree: dict[str, Any], pictures: Sequence[Picture]) -> str:
    """The assessment as one self-contained page."""
    title = f"How accurate is {tree['case']}?"
    word, _, reason = tree["headline"].partition(":")
    sections = (
        f"<h1>{escape(title)}</h1>",
        f'<p class="light {tree["light"]}"><b>{escape(word)}</b><span>{escape(reason.strip())}'
        "</span></p>",
        _cards(tree),
        f'<p class="note">{escape(MEANING)}</p>',
        "<h2>What limits this result, and what to do</h2>",
        _findings(tree["findings"]),
        f'<p class="use">{escape(tree["intended_use"])}</p>',
        *(_picture(picture) for picture in pictures),
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
    body = "\n".join(sections)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta http-equiv="Content-Security-Policy" '
        "content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">\n"
        f"<title>{escape(title)}</title>\n<style>{_STYLE}</style>\n</head>\n"
        f"<body>\n{body}\n</body>\n</html>\n"
    )


def _cards(tree: dict[str, Any]) -> str:
    """The four figures that everybody asks for."""
    shown = "".join(
        f'<div class="card">{escape(card.question)}<strong>{escape(card.answer)}</strong>'
        f"<small>{escape(card.note)}</small></div>"
        for card in cards(tree)
    )
    return f'<div class="cards">{shown}</div>'


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
            f"{one['red']:g}",
            one["light"],
            one["sentence"],
        )
        for one in judged
    ]
    heads = ("figure", "#found", "unit", "#green up to", "#red beyond", "light", "in words")
    return table(heads, rows, [one["light"] == "red" for one in judged])


def _picture(picture: Picture) -> str:
    data = base64.b64encode(picture.png.tobytes()).decode()
    return (
        f"<h2>{escape(picture.title)}</h2><figure>"
        f'<img alt="{escape(picture.title)}" src="data:image/png;base64,{data}">'
        f"<figcaption>{escape(picture.caption)}</figcaption></figure>"
    )
