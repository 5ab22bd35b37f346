"""A page: one HTML file that holds everything, asks nothing of the network, runs no script.

Trees: the JSON that reports keep, for those who write it and those who only read it.
"""

import base64
import math
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

from limbgram.report.drawings.drawing import Picture

STYLE = """
:root { color-scheme: light; --green: #2f7d4f; --amber: #a8690a; --red: #b8403a; --blue: #2b6ca3; }
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
.blue { border-color: var(--blue); background: #eef4f9; } .blue b { background: var(--blue); }
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
td.why { color: #55636c; max-width: 44rem; }
tr.bad td { color: var(--red); } .wide { overflow-x: auto; }
@media print { .wide { overflow: visible; } h2 { break-after: avoid; }
  figure, tr { break-inside: avoid; } }
"""


def document(title: str, sections: Iterable[str], style: str = STYLE) -> str:
    """A whole page of sections that are HTML already."""
    body = "\n".join(sections)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta http-equiv="Content-Security-Policy" '
        "content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">\n"
        f"<title>{escape(title)}</title>\n<style>{style}</style>\n</head>\n"
        f"<body>\n{body}\n</body>\n</html>\n"
    )


def card(question: str, answer: str, note: str) -> str:
    """One figure of the first screen."""
    return (
        f'<div class="card">{escape(question)}<strong>{escape(answer)}</strong>'
        f"<small>{escape(note)}</small></div>"
    )


def figure_html(picture: Picture) -> str:
    """A picture under its title, with its caption."""
    data = base64.b64encode(picture.png.tobytes()).decode()
    return (
        f"<h2>{escape(picture.title)}</h2>\n<figure>"
        f'<img alt="{escape(picture.title)}" src="data:image/png;base64,{data}">'
        f"<figcaption>{escape(picture.caption)}</figcaption></figure>"
    )


def table(heads: Sequence[str], rows: Sequence[Sequence[str]], bad: Sequence[bool] = ()) -> str:
    """An HTML table; heads that begin with # stand over columns of numbers.

    The last cell of a row that has fewer cells than there are heads is a sentence over the rest.
    """
    kinds = [' class="n"' if head.startswith("#") else "" for head in heads]
    top = "".join(
        f"<th{kind}>{escape(head.lstrip('#'))}</th>"
        for kind, head in zip(kinds, heads, strict=True)
    )
    lines = [f"<tr>{top}</tr>"]
    for idx, row in enumerate(rows):
        marked = ' class="bad"' if idx < len(bad) and bad[idx] else ""
        lines.append(f"<tr{marked}>{_cells(kinds, row)}</tr>")
    return '<div class="wide"><table>' + "\n".join(lines) + "</table></div>"


def _cells(kinds: Sequence[str], row: Sequence[str]) -> str:
    """A row's cells, the last of a short row wrapped over the columns that are left."""
    left = len(kinds) - len(row)
    own = row[:-1] if left > 0 else row
    cells = "".join(
        f"<td{kind}>{escape(cell)}</td>" for kind, cell in zip(kinds[: len(own)], own, strict=True)
    )
    if left > 0:
        cells += f'<td class="why" colspan="{left + 1}">{escape(row[-1])}</td>'
    return cells


ACCURACY_SCHEMA = "limbgram-accuracy/1"
"""Kind of an accuracy.json: records of shapes read it without the part that makes it."""


def finite(tree: Any) -> Any:
    """The same tree with None for what JSON has no number for."""
    match tree:
        case dict():
            return {name: finite(item) for name, item in tree.items()}
        case list() | tuple():
            return [finite(item) for item in tree]
        case float():
            return tree if math.isfinite(tree) else None
        case _:
            return tree
