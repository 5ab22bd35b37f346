"""PDF: a report on sheets of A4, to file or to print.

In      a Report; its sections say on which sheet they stand.
Out     the bytes of a PDF, tagged, with its fonts; the same report gives the same bytes. Charts are
        vectors, with the words of the page's.
Method  Typst lays out `templates/report.typ`. Where a sheet is too full, pictures become smaller,
        optional ones are left out, and the longest table or list is shortened, row by row, and says
        so. What is still too much is not shortened at all: it flows on to another sheet.
"""

import base64
import io
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import typst
from PIL import Image

from limbgram.findings import Finding, Gravity, advice, sentence
from limbgram.report.blocks import (
    AdviceList,
    Block,
    Card,
    Columns,
    Fields,
    Heading,
    Illustration,
    Link,
    Report,
    Section,
    Table,
    Text,
)
from limbgram.report.drawings.drawing import Chart, Picture

_WIDTH_IN = 8.27 - 2 * 0.58
"""Of what is printed, as the template has it."""
_COLUMN_GAP_IN = 0.2
_HALVINGS = 4
"""Of the search for how large pictures may be: to a sixteenth of the room they may take."""
_LETTERS_OF_CARD = 16
"""That a card's answer has room for in its usual size, on a third of the sheet."""


def pdf_of(report: Report) -> bytes:
    """The report as a PDF of as many pages as it names sheets, or more where one is too full."""
    numbers = sorted({one.sheet for one in report.sections if one.sheet is not None})
    sheets = [
        _Sheet.of([one for one in report.sections if one.sheet == number]) for number in numbers
    ]
    _fit_sheets(report, sheets)
    images: dict[str, bytes] = {}
    source = _source(report, sheets, images)
    return typst.compile(source | images, font_paths=_fonts(), pdf_standards=["ua-1"])


@dataclass(frozen=True)
class _Reduction:
    """How far the blocks of a sheet are reduced to fit."""

    without: frozenset[int] = frozenset()
    """Optional pictures that are left out, by number of block."""
    shortened: tuple[int, ...] = ()
    """By number of block: rows left out, or for a thinned table one less than the step."""


@dataclass
class _Sheet:
    """The sections of a sheet, and how far their blocks are reduced."""

    sections: Sequence[Section]
    blocks: Sequence[Block]
    """Of all sections, in their order."""
    ways: Sequence[_Reduction]
    """From what gives way to nothing, to what gives way most."""
    way: int = 0
    growth: float = 0.0
    """Of pictures, from their least height to the one that they would like: 0 to 1."""

    @staticmethod
    def of(sections: Sequence[Section]) -> "_Sheet":
        blocks = [one for section in sections for one in section.blocks if not one.page_only]
        return _Sheet(sections, blocks, _reductions(blocks))

    @property
    def given(self) -> _Reduction:
        return self.ways[self.way]

    @property
    def has_pictures(self) -> bool:
        return any(isinstance(one, Illustration | Columns) for one in self.blocks)


def _reductions(blocks: Sequence[Block]) -> list[_Reduction]:
    """The reductions of blocks in order: optional pictures, the last first; then table rows."""
    given = _Reduction(shortened=(0,) * len(blocks))
    ways = [given]
    for k in reversed(range(len(blocks))):
        block = blocks[k]
        if isinstance(block, Illustration) and block.optional:
            given = replace(given, without=given.without | {k})
            ways.append(given)
    while True:
        rows = [_rows_left(one, given.shortened[k]) for k, one in enumerate(blocks)]
        longest = max(range(len(blocks)), key=rows.__getitem__, default=None)
        if longest is None or rows[longest] < 1:
            return ways
        shortened = list(given.shortened)
        shortened[longest] += 1
        given = replace(given, shortened=tuple(shortened))
        ways.append(given)


def _rows_left(block: Block, shortened: int) -> int:
    """Rows that may still be left out."""
    match block:
        case Table(rows=rows, shorten="thin"):
            return -(-len(rows) // (shortened + 1)) - 1
        case Table(rows=rows, shorten="cut"):
            return len(rows) - shortened
        case AdviceList(items=items):
            return len(items) - shortened
        case _:
            return 0


def _fit_sheets(report: Report, sheets: Sequence[_Sheet]) -> None:
    """Reduce each sheet as little as it needs to fit; all sheets are tried at the same time."""
    least = [0] * len(sheets)
    most = [len(sheet.ways) - 1 for sheet in sheets]
    fitting = _sheets_that_fit(report, sheets)
    most = [0 if fits else up for fits, up in zip(fitting, most, strict=True)]
    if any(most):
        for sheet, up in zip(sheets, most, strict=True):
            sheet.way = up
        fitting = _sheets_that_fit(report, sheets)
        most = [up if fits else 0 for fits, up in zip(fitting, most, strict=True)]
    while any(low < up for low, up in zip(least, most, strict=True)):
        for sheet, low, up in zip(sheets, least, most, strict=True):
            sheet.way = (low + up) // 2
        for k, fits in enumerate(_sheets_that_fit(report, sheets)):
            if fits or least[k] == most[k]:
                most[k] = sheets[k].way
            else:
                least[k] = sheets[k].way + 1
    for sheet, way in zip(sheets, most, strict=True):
        sheet.way = way
    if any(sheet.has_pictures for sheet in sheets):
        _enlarge_pictures(report, sheets)


def _enlarge_pictures(report: Report, sheets: Sequence[_Sheet]) -> None:
    """Enlarge pictures into the room that is left on their sheet."""
    largest = [0.0] * len(sheets)
    for step in [1.0, *(0.5**k for k in range(1, _HALVINGS + 1))]:
        for sheet, grown in zip(sheets, largest, strict=True):
            sheet.growth = min(grown + step, 1.0)
        for k, fits in enumerate(_sheets_that_fit(report, sheets)):
            largest[k] = sheets[k].growth if fits else largest[k]
    for sheet, grown in zip(sheets, largest, strict=True):
        sheet.growth = grown


def _sheets_that_fit(report: Report, sheets: Sequence[_Sheet]) -> list[bool]:
    """Which sheets fit on one page."""
    edges = typst.query(
        _source(report, sheets, None),
        "<edge>",
        field="value",
        font_paths=_fonts(),
    )
    pages: list[set[int]] = [set() for _ in sheets]
    for edge in json.loads(edges):
        pages[edge["sheet"]].add(edge["page"])
    return [len(one) == 1 for one in pages]


def _source(report: Report, sheets: Sequence[_Sheet], images: dict[str, bytes] | None) -> Any:
    """What Typst lays out: files by name, a way of input that its stub lacks.

    Args:
        images: Takes the pictures; without it they are empty frames.
    """
    banner = report.banner
    told: dict[str, Any] = {
        "title": report.title,
        "language": "en",
        "banner": {
            "badge": banner.badge,
            "words": banner.words,
            "colour": banner.colour,
            "reasons": banner.reasons,
        },
        "cards": [_card(one) for one in report.cards],
        "note": report.note,
        "intended_use": report.intended_use,
        "sheets": [list(_sections(sheet, images)) for sheet in sheets],
    }
    template = files("limbgram.report").joinpath("templates", "report.typ").read_bytes()
    return {"main.typ": template, "report.json": json.dumps(told).encode()}


def _card(card: Card) -> dict[str, Any]:
    points = 13.0 * min(1.0, _LETTERS_OF_CARD / max(len(card.answer), 1))
    return {
        "question": card.question,
        "answer": card.answer,
        "note": card.note,
        "points": max(points, 8.0),
    }


def _sections(sheet: _Sheet, images: dict[str, bytes] | None) -> Iterator[dict[str, Any]]:
    number = 0
    for section in sheet.sections:
        laid: list[dict[str, Any]] = []
        for block in section.blocks:
            if block.page_only:
                continue
            if number not in sheet.given.without:
                laid += _typst_block(block, sheet.given.shortened[number], sheet.growth, images)
            number += 1
        yield {"title": section.title if laid else "", "blocks": laid}


def _typst_block(
    block: Block, shortened: int, growth: float, images: dict[str, bytes] | None
) -> Iterator[dict[str, Any]]:
    match block:
        case Text(words=words, note=note):
            yield {"kind": "text", "words": words, "note": note}
        case Heading(words=words):
            yield {"kind": "heading", "words": words}
        case Fields(labels=labels):
            yield {"kind": "fields", "labels": labels}
        case AdviceList(items=items):
            yield _advice(items, shortened)
        case Table() as table:
            yield _table(_for_paper(table), shortened)
        case Illustration() as figure:
            yield {"kind": "figures", "figures": [_figure(figure, _WIDTH_IN, growth, images)]}
        case Columns(figures=figures):
            width_in = (_WIDTH_IN - _COLUMN_GAP_IN * (len(figures) - 1)) / len(figures)
            yield {
                "kind": "figures",
                "figures": [_figure(one, width_in, growth, images) for one in figures],
            }
        case Link():
            return


def _advice(items: tuple[Finding, ...], shortened: int) -> dict[str, Any]:
    return {
        "kind": "advice",
        "items": [
            {
                "what": f"{number}. {sentence(one)}",
                "remedy": advice(one),
                "grave": one.gravity is Gravity.FAULT,
            }
            for number, one in enumerate(items[: len(items) - shortened], start=1)
        ],
        "note": f"and {shortened} more on the page" if shortened else "",
    }


def _for_paper(table: Table) -> Table:
    """The table without the column that the page alone has."""
    if table.page_head not in table.heads:
        return table
    k = table.heads.index(table.page_head)
    rows = tuple((*row[:k], *row[k + 1 :]) for row in table.rows)
    return replace(table, heads=(*table.heads[:k], *table.heads[k + 1 :]), rows=rows)


def _table(table: Table, shortened: int) -> dict[str, Any]:
    rows, note = [_row(table, k) for k in range(len(table.rows))], ""
    if shortened and table.shorten == "thin":
        rows = rows[:: shortened + 1]
        note = f"One row in {shortened + 1}; all are on the page."
    elif shortened:
        rows = rows[: len(rows) - shortened]
        note = f"and {shortened} more on the page"
    words = [k for k, head in enumerate(table.heads) if not head.startswith("#")]
    return {
        "kind": "table",
        "columns": [int(not words or k == words[-1]) for k in range(len(table.heads))],
        "heads": [_cell(head.removeprefix("#"), head, weight="bold") for head in table.heads],
        "rows": rows,
        "note": note,
    }


def _row(table: Table, number: int) -> list[dict[str, Any]]:
    """The cells; the last one spans the heads that have none, and has the verdict's colour."""
    row, heads = table.rows[number], table.heads
    ink = "red" if table.marked and table.marked[number] else "ink"
    light = table.colours[number] if table.colours else None
    cells = [_cell(cell, head, colour=ink) for cell, head in zip(row, heads, strict=False)]
    across = len(heads) - len(row) + 1
    if across > 1:
        cells[-1] = _cell(row[-1], "", colour="pale", across=across)
    elif light is not None:
        cells[-1] = _cell(row[-1], heads[-1], colour=light, weight="bold")
    return cells


def _cell(
    words: str, head: str, *, colour: str = "ink", weight: str = "regular", across: int = 1
) -> dict[str, Any]:
    return {
        "words": words,
        "number": head.startswith("#"),
        "colour": colour,
        "weight": weight,
        "across": across,
    }


def _figure(
    figure: Illustration, width_in: float, growth: float, images: dict[str, bytes] | None
) -> dict[str, Any]:
    """A picture keeps its shape; a chart takes the whole width."""
    image = figure.image
    full_in = min(width_in * _aspect(image), figure.most_in)
    least_in = min(figure.least_in, full_in)
    height_in = least_in + growth * (full_in - least_in)
    across_in = (
        min(width_in, height_in / _aspect(image)) if isinstance(image, Picture) else width_in
    )
    name = ""
    if images is not None:
        name = f"{len(images)}.svg"
        vectors = (
            _svg_of_picture(image)
            if isinstance(image, Picture)
            else image.svg(name, across_in, height_in)
        )
        images[name] = vectors.encode()
    return {
        "file": name,
        "width_in": across_in,
        "height_in": height_in,
        "caption": figure.caption,
        "alt": image.title or figure.caption or "Picture",  # PDF/UA demands one
    }


def _svg_of_picture(picture: Picture) -> str:
    """The picture inside an SVG: Typst takes no files but text from memory."""
    data = picture.png.tobytes()
    width_px, height_px = Image.open(io.BytesIO(data)).size
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width_px} {height_px}">'
        f'<image width="{width_px}" height="{height_px}" '
        f'href="data:image/png;base64,{base64.b64encode(data).decode()}"/></svg>'
    )


def _aspect(image: Picture | Chart) -> float:
    """Height over width of an image."""
    if isinstance(image, Chart):
        return image.height_in / image.width_in
    width, height = Image.open(io.BytesIO(image.png.tobytes())).size
    return height / width


@cache
def _fonts() -> typst.Fonts:
    """The fonts of charts, which matplotlib brings along; found once for all layouts."""
    import matplotlib as mpl

    folder = Path(mpl.get_data_path(), "fonts", "ttf")
    return typst.Fonts(include_system_fonts=False, font_paths=[folder])
