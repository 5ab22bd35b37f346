"""PDF: a report on sheets of A4, to file or to print.

In      a Report; its sections say on which sheet they stand.
Out     the bytes of a PDF; the same report gives the same bytes. Charts are vectors.
Method  every block is laid out at its full height. Where a sheet is too full, pictures become
        smaller, optional ones are left out, and the longest table or list is shortened, row by
        row, and says so. What is still too much goes on on another sheet. matplotlib writes the
        file: it draws the charts too, so page and paper show the same ones. (reportlab wrote the
        text in half the time, 0.45 against 0.9 s of CPU for a record, but takes no vectors from
        matplotlib.)
Fails   ExportError: a single block is higher than a sheet.
"""

import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_pdf import FigureCanvasPdf, PdfPages
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from PIL import Image

from limbgram.core.errors import ExportError
from limbgram.findings import Finding, Gravity, advice, sentence
from limbgram.report.blocks import (
    AdviceList,
    Banner,
    Block,
    Card,
    Colour,
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
from limbgram.report.drawings.drawing import INK, PALE_INK, Chart, Picture, axes_at

PAGE_IN = (8.27, 11.69)
_MARGIN_IN = 0.58
_WIDTH_IN = PAGE_IN[0] - 2 * _MARGIN_IN
_FOOT_IN = 0.3
"""Below the last line of a sheet."""
_POINTS_PER_IN = 72.0
_PICTURE_DPI = 200
_BODY, _SMALL, _HEAD = 7.5, 7.0, 9.5
"""Points of paragraphs, of tables and notes, of headings."""
_LINE = 1.32
"""Height of a line, in heights of its letters."""
_BASELINE = 0.98
"""From the top of a line to the foot of its letters, in heights of these."""
_CELL_GAP_IN = 0.14
_ROW_PAD_IN = 0.012
_COLUMN_GAP_IN = 0.2
_ROUNDING_IN = 1e-6
"""Pictures take all the room that is left: the sum of all heights is the room but for rounding."""
_NARROWEST_IN = 0.5
"""Column of words."""
_RULE = "#dde4e8"
_COLOURS: dict[Colour, str] = {
    "green": "#2f7d4f",
    "amber": "#a8690a",
    "red": "#b8403a",
    "blue": "#2b6ca3",
}


def pdf_of(report: Report) -> bytes:
    """The report as a PDF of as many pages as it names sheets."""
    file = io.BytesIO()
    about = {"CreationDate": None, "Creator": "limbgram", "Title": report.title}
    with (
        mpl.rc_context({"text.parse_math": False}),
        PdfPages(file, metadata=about) as pages,
    ):
        for sheet in sheets_of(report):
            figure = _figure(sheet)
            FigureCanvasPdf(figure)
            pages.savefig(figure, dpi=_PICTURE_DPI)
    return file.getvalue()


@dataclass(frozen=True, kw_only=True)
class Line:
    """Letters on a sheet; places are inches from the upper left corner of what holds them."""

    x_in: float
    y_in: float
    """Of the foot of its letters."""
    words: str
    points: float
    colour: str = INK
    bold: bool = False


@dataclass(frozen=True, kw_only=True)
class Box:
    """A rectangle in a colour; a rule where it is very low."""

    x_in: float
    y_in: float
    width_in: float
    height_in: float
    colour: str
    opacity: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Area:
    """Where a picture or a chart is put."""

    x_in: float
    y_in: float
    width_in: float
    height_in: float
    image: Picture | Chart


Mark = Line | Box | Area


@dataclass(frozen=True)
class Laid:
    """What is drawn of something, and how much of the sheet's height it takes."""

    height_in: float
    marks: tuple[Mark, ...] = ()

    def at(self, x_in: float, y_in: float) -> Iterator[Mark]:
        """The marks, moved to a place of the sheet."""
        for mark in self.marks:
            yield replace(mark, x_in=mark.x_in + x_in, y_in=mark.y_in + y_in)


def sheets_of(report: Report) -> list[list[Mark]]:
    """What is drawn on each sheet, from its upper left corner.

    Raises:
        ExportError: a single block is higher than a sheet.
    """
    numbers = sorted({one.sheet for one in report.sections if one.sheet is not None})
    foot = _lines(report.intended_use, _WIDTH_IN, 6.5, PALE_INK)
    below_head_in = PAGE_IN[1] - _MARGIN_IN - _FOOT_IN - foot.height_in - 0.1
    filled: list[list[_Filled]] = []
    for number in numbers:
        rest = [_Filled.of(one) for one in report.sections if one.sheet == number]
        while rest:
            head = _head(report, len(filled) + 1, len(numbers))
            room_in = below_head_in - sum(part.height_in for part in head)
            _fit(rest, room_in)
            sheet, rest = _parted(rest, room_in)
            filled.append(sheet)
    sheets: list[list[Mark]] = []
    for number, sections in enumerate(filled, start=1):
        marks = [*foot.at(_MARGIN_IN, PAGE_IN[1] - _FOOT_IN - foot.height_in)]
        y_in = _MARGIN_IN
        head = _head(report, number, len(filled))
        for part in (*head, *(part for section in sections for part in section.laid())):
            marks += part.at(_MARGIN_IN, y_in)
            y_in += part.height_in
        sheets.append(marks)
    return sheets


def _head(report: Report, number: int, count: int) -> Iterator[Laid]:
    """Title and banner of every sheet; cards and what is said of them on the first."""
    title = f"{report.title} (sheet {number} of {count})"
    yield _lines(title, _WIDTH_IN, 13.0, INK, bold=True)
    yield Laid(0.06)
    yield _banner(report.banner)
    yield Laid(0.1)
    if number > 1:
        return
    if report.cards:
        yield _cards(report.cards)
        yield Laid(0.06)
    if report.note:
        yield _lines(report.note, _WIDTH_IN, _SMALL, PALE_INK)


@dataclass
class _Slot:
    """A block on its sheet, and how far it has given way."""

    block: Block
    shortened: int = 0
    left_out: bool = False
    height_in: float | None = None
    """Of a picture; None for its least."""

    def laid(self) -> Laid:
        if self.left_out:
            return Laid(0.0)
        match self.block:
            case Text(words=words, note=note):
                return _lines(words, _WIDTH_IN, *((_SMALL, PALE_INK) if note else (_BODY, INK)))
            case Heading(words=words):
                return _heading(words, 8.0)
            case Fields(labels=labels):
                return _fields(labels)
            case AdviceList(items=items):
                return _advice(items, self.shortened)
            case Table() as table:
                return _table(_for_paper(table), self.shortened)
            case Illustration() as figure:
                return _illustration(figure, _WIDTH_IN, self.height_in or self.least_in)
            case Columns() as columns:
                return _columns(columns, self.height_in or self.least_in)
            case Link():
                return Laid(0.0)

    @property
    def may_shorten(self) -> bool:
        match self.block:
            case Table(rows=rows, shorten=way) if way:
                return self.shortened < len(rows) - (way == "thin")
            case AdviceList(items=items):
                return self.shortened < len(items)
            case _:
                return False

    @property
    def may_go(self) -> bool:
        return isinstance(self.block, Illustration) and self.block.optional and not self.left_out

    @property
    def least_in(self) -> float:
        match self.block:
            case Illustration() as figure:
                return min(figure.least_in, self.full_in)
            case Columns(figures=figures):
                return min(max(one.least_in for one in figures), self.full_in)
            case _:
                return 0.0

    @property
    def full_in(self) -> float:
        """Height that a picture would like to have."""
        if self.left_out:
            return 0.0
        match self.block:
            case Illustration() as figure:
                return min(_WIDTH_IN * _tall(figure.image), figure.most_in)
            case Columns(figures=figures):
                width_in = _column_in(figures)
                return max(min(width_in * _tall(one.image), one.most_in) for one in figures)
            case _:
                return 0.0


@dataclass
class _Filled:
    """A section on its sheet."""

    section: Section
    slots: list[_Slot]

    @staticmethod
    def of(section: Section) -> "_Filled":
        return _Filled(section, [_Slot(one) for one in section.blocks if not one.page_only])

    def laid(self) -> Iterator[Laid]:
        parts = [slot.laid() for slot in self.slots]
        if any(part.height_in for part in parts) and self.section.title:
            yield _heading(self.section.title, _HEAD)
        yield from parts


def _fit(sections: Sequence[_Filled], room_in: float) -> None:
    """Shorten what may be shortened until all fits, then let the pictures have what is left."""
    slots = [slot for section in sections for slot in section.slots]
    while (over_in := _height(sections) - room_in) > 0:
        optional = [slot for slot in slots if slot.may_go]
        shortest = [slot for slot in slots if slot.may_shorten]
        if optional:
            optional[-1].left_out = True
        elif shortest:
            tallest = max(shortest, key=lambda slot: slot.laid().height_in)
            tallest.shortened += 1
        else:
            break
    else:
        growth = [max(slot.full_in - slot.least_in, 0.0) for slot in slots]
        share = min(1.0, -over_in / sum(growth)) if sum(growth) > 0 else 0.0
        for slot, more_in in zip(slots, growth, strict=True):
            slot.height_in = slot.least_in + share * more_in


def _parted(sections: list[_Filled], room_in: float) -> tuple[list[_Filled], list[_Filled]]:
    """What fits on a sheet, and what goes on on the next one, which is nothing as a rule."""
    over: list[_Filled] = []
    while _height(sections) > room_in + _ROUNDING_IN:
        last = sections[-1]
        if not last.slots:
            sections = sections[:-1]
            continue
        if len(sections) == len(last.slots) == 1:
            raise ExportError(
                f"The sheet {last.section.title!r} cannot be printed: one of its texts or pictures "
                "is higher than the paper. The page (HTML) shows all; shorten names and notes."
            )
        if not over or over[0].section is not last.section:
            over.insert(0, replace(last, slots=[]))
        over[0].slots.insert(0, last.slots.pop())
    return sections, over


def _height(sections: Sequence[_Filled]) -> float:
    return sum(part.height_in for section in sections for part in section.laid())


def _lines(words: str, width_in: float, points: float, colour: str, *, bold: bool = False) -> Laid:
    """A paragraph."""
    step_in = _LINE * points / _POINTS_PER_IN
    marks = tuple(
        Line(
            x_in=0.0,
            y_in=number * step_in + _BASELINE * points / _POINTS_PER_IN,
            words=line,
            points=points,
            colour=colour,
            bold=bold,
        )
        for number, line in enumerate(wrapped(words, width_in, points, bold=bold))
    )
    return Laid(len(marks) * step_in, marks)


def _stacked(parts: Iterable[Laid]) -> Laid:
    marks: list[Mark] = []
    height_in = 0.0
    for part in parts:
        marks += part.at(0.0, height_in)
        height_in += part.height_in
    return Laid(height_in, tuple(marks))


def _heading(words: str, points: float) -> Laid:
    return _stacked(
        (Laid(0.11), _lines(words, _WIDTH_IN, points, INK, bold=True), Laid(0.03)),
    )


def _banner(banner: Banner) -> Laid:
    """As high as its words."""
    points, colour = 13.0, _COLOURS[banner.colour]
    left_in = 0.2 + width_of(banner.badge, points, bold=True) + 0.25
    width_in = _WIDTH_IN - left_in - 0.1
    words = _stacked(
        (
            _lines(banner.words, width_in, 8.5, INK),
            *(_lines(f"• {reason}", width_in, _BODY, INK) for reason in banner.reasons),
        )
    )
    height_in = max(words.height_in, 0.24) + 0.18
    badge = Line(
        x_in=0.2,
        y_in=height_in / 2 + 0.36 * points / _POINTS_PER_IN,
        words=banner.badge,
        points=points,
        colour=colour,
        bold=True,
    )
    ground = Box(
        x_in=0.0, y_in=0.0, width_in=_WIDTH_IN, height_in=height_in, colour=colour, opacity=0.1
    )
    edge = replace(ground, width_in=0.06, opacity=1.0)
    return Laid(
        height_in,
        (ground, edge, badge, *words.at(left_in, (height_in - words.height_in) / 2)),
    )


def _cards(cards: Sequence[Card]) -> Laid:
    """Question, answer and note side by side."""
    step_in = _WIDTH_IN / len(cards)
    width_in = step_in - _CELL_GAP_IN
    columns = [
        (
            _lines(card.question, width_in, _SMALL, PALE_INK),
            _lines(card.answer, width_in, _fitting(card.answer, width_in, 13.0), INK, bold=True),
            _lines(card.note, width_in, 6.5, PALE_INK),
        )
        for card in cards
    ]
    marks: list[Mark] = []
    y_in = 0.0
    for low, row in zip((True, True, False), zip(*columns, strict=True), strict=True):
        height_in = max(part.height_in for part in row)
        for number, part in enumerate(row):
            down_in = height_in - part.height_in if low else 0.0
            marks += part.at(number * step_in, y_in + down_in)
        y_in += height_in
    return Laid(y_in, tuple(marks))


def _fields(labels: Sequence[str]) -> Laid:
    """Words, each with a line behind it to write on."""
    step_in = _WIDTH_IN / len(labels)
    high_in, line_in = 0.12, _LINE * _BODY / _POINTS_PER_IN
    marks: list[Mark] = []
    for number, label in enumerate(labels):
        after_in = width_of(label, _BODY) + 0.06
        marks += _lines(label, step_in, _BODY, INK).at(number * step_in, high_in)
        marks.append(
            Box(
                x_in=number * step_in + after_in,
                y_in=high_in + line_in,
                width_in=max(step_in - after_in - _COLUMN_GAP_IN, 0.3),
                height_in=0.0,
                colour=PALE_INK,
            )
        )
    return Laid(high_in + line_in + 0.08, tuple(marks))


def _advice(items: tuple[Finding, ...], shortened: int) -> Laid:
    kept = items[: len(items) - shortened]
    parts: list[Laid] = []
    for number, one in enumerate(kept, start=1):
        what, grave = f"{number}. {sentence(one)}", one.gravity is Gravity.FAULT
        parts.append(_lines(what, _WIDTH_IN, _BODY, INK, bold=grave))
        if remedy := advice(one):
            parts.append(_lines(f"→ {remedy}", _WIDTH_IN, _SMALL, PALE_INK))
        parts.append(Laid(0.02))
    if shortened:
        parts.append(_lines(f"and {shortened} more on the page", _WIDTH_IN, _SMALL, PALE_INK))
    return _stacked(parts)


def _for_paper(table: Table) -> Table:
    """The table without the column that the page alone has."""
    if table.page_head not in table.heads:
        return table
    k = table.heads.index(table.page_head)
    rows = tuple((*row[:k], *row[k + 1 :]) for row in table.rows)
    return replace(table, heads=(*table.heads[:k], *table.heads[k + 1 :]), rows=rows)


def _table(table: Table, shortened: int) -> Laid:
    rows, note = list(zip(table.rows, _inks(table), strict=True)), ""
    if shortened and table.shorten == "thin":
        rows = rows[:: shortened + 1]
        note = f"One row in {shortened + 1}; all are on the page."
    elif shortened:
        rows = rows[: len(rows) - shortened]
        note = f"and {shortened} more on the page"
    columns_in = _columns_in(table)
    parts = [_row(table.heads, table.heads, columns_in, (INK, INK), bold=True)]
    parts += [_row(table.heads, row, columns_in, inks, bold=False) for row, inks in rows]
    if note:
        parts.append(_lines(note, _WIDTH_IN, 6.5, PALE_INK))
    return _stacked((*parts, Laid(0.05)))


def _inks(table: Table) -> Iterator[tuple[str, str]]:
    """Colour of each row's letters, and of those of its last cell."""
    for k in range(len(table.rows)):
        ink = _COLOURS["red"] if table.marked and table.marked[k] else INK
        light = table.colours[k] if table.colours else None
        yield ink, ink if light is None else _COLOURS[light]


def _row(
    heads: Sequence[str],
    row: Sequence[str],
    columns_in: Sequence[float],
    inks: tuple[str, str],
    *,
    bold: bool,
) -> Laid:
    marks: list[Mark] = []
    x_in = height_in = 0.0
    for number, (head, cell) in enumerate(zip(heads, row)):
        width_in, last = columns_in[number], number == len(row) - 1
        sentence = last and len(row) < len(heads)
        if sentence:
            width_in = sum(columns_in[number:])
        ink = PALE_INK if sentence else inks[1] if last else inks[0]
        words = cell.removeprefix("#") if bold else cell
        heavy = bold or ink not in (inks[0], PALE_INK)
        part = _lines(words, width_in - _CELL_GAP_IN, _SMALL, ink, bold=heavy)
        for mark in part.marks:
            right = head.startswith("#") and not sentence and isinstance(mark, Line)
            shift_in = (
                width_in - _CELL_GAP_IN - width_of(mark.words, _SMALL, bold=heavy)
                if right and isinstance(mark, Line)
                else 0.0
            )
            marks.append(replace(mark, x_in=mark.x_in + x_in + shift_in))
        x_in += width_in
        height_in = max(height_in, part.height_in)
    height_in += 2 * _ROW_PAD_IN
    rule = Box(x_in=0.0, y_in=height_in, width_in=_WIDTH_IN, height_in=0.0, colour=_RULE)
    return Laid(height_in, (*Laid(0.0, tuple(marks)).at(0.0, _ROW_PAD_IN), rule))


def _columns_in(table: Table) -> list[float]:
    """Widths: what the cells need; the widest columns of words give way, and their cells wrap."""
    needed_in = [width_of(head.removeprefix("#"), _SMALL, bold=True) for head in table.heads]
    word_in = list(needed_in)
    for row in table.rows:
        whole = row if len(row) == len(table.heads) else row[:-1]
        for number, cell in enumerate(whole):
            needed_in[number] = max(needed_in[number], width_of(cell, _SMALL, bold=True))
            for word in cell.split():
                word_in[number] = max(word_in[number], width_of(word, _SMALL, bold=True))
    room_in = _WIDTH_IN - _CELL_GAP_IN * len(needed_in)
    least_in = [
        needed if head.startswith("#") else min(needed, max(word, _NARROWEST_IN))
        for head, needed, word in zip(table.heads, needed_in, word_in, strict=True)
    ]
    low_in, high_in = 0.0, max(needed_in, default=0.0)
    widths_in = needed_in
    if sum(needed_in) > room_in:
        for _ in range(30):
            middle_in = (low_in + high_in) / 2
            widths_in = [
                max(least, min(needed, middle_in))
                for least, needed in zip(least_in, needed_in, strict=True)
            ]
            if sum(widths_in) > room_in:
                high_in = middle_in
            else:
                low_in = middle_in
    spare_in = max(room_in - sum(widths_in), 0.0) / len(widths_in)
    return [width_in + spare_in + _CELL_GAP_IN for width_in in widths_in]


def _tall(image: Picture | Chart) -> float:
    """Height over width."""
    if isinstance(image, Chart):
        return image.height_in / image.width_in
    width, height = Image.open(io.BytesIO(image.png.tobytes())).size
    return height / width


def _column_in(figures: Sequence[Illustration]) -> float:
    return (_WIDTH_IN - _COLUMN_GAP_IN * (len(figures) - 1)) / len(figures)


def _columns(columns: Columns, height_in: float) -> Laid:
    width_in = _column_in(columns.figures)
    parts = [_illustration(one, width_in, height_in) for one in columns.figures]
    marks: list[Mark] = []
    for number, part in enumerate(parts):
        marks += part.at(number * (width_in + _COLUMN_GAP_IN), 0.0)
    return Laid(max(part.height_in for part in parts), tuple(marks))


def _illustration(figure: Illustration, width_in: float, height_in: float) -> Laid:
    """A picture keeps its shape; a chart takes the whole width."""
    across_in = width_in
    if isinstance(figure.image, Picture):
        across_in = min(width_in, height_in / _tall(figure.image))
        height_in = across_in * _tall(figure.image)
    area = Area(
        x_in=(width_in - across_in) / 2,
        y_in=0.0,
        width_in=across_in,
        height_in=height_in,
        image=figure.image,
    )
    caption = _lines(figure.caption, width_in, 6.5, PALE_INK)
    return _stacked((Laid(height_in + 0.03, (area,)), caption, Laid(0.06)))


def wrapped(words: str, width_in: float, points: float, *, bold: bool = False) -> list[str]:
    """Words in lines that are no wider; a word that is wider than a line is broken."""
    width_in += 1e-6  # of rounding
    lines: list[str] = []
    for word in words.split():
        if lines and width_of(f"{lines[-1]} {word}", points, bold=bold) <= width_in:
            lines[-1] += f" {word}"
            continue
        while len(word) > 1 and width_of(word, points, bold=bold) > width_in:
            fits = max(
                1,
                next(n for n in range(len(word), 0, -1) if n == 1
                     or width_of(word[:n], points, bold=bold) <= width_in),
            )  # fmt: skip
            lines.append(word[:fits])
            word = word[fits:]
        lines.append(word)
    return lines


def width_of(words: str, points: float, *, bold: bool = False) -> float:
    """Of letters, in inches."""
    return sum(_advance(letter, bold) for letter in words) * points / _POINTS_PER_IN


def _fitting(words: str, width_in: float, points: float) -> float:
    """The size in which words fit on a line, at most `points`."""
    return points * min(1.0, width_in / max(width_of(words, points, bold=True), 1e-9))


@cache
def _font(bold: bool) -> FontProperties:
    return FontProperties(family="DejaVu Sans", weight="bold" if bold else "normal")


@cache
def _advance(letter: str, bold: bool) -> float:
    """Width of a letter whose height is 1."""
    font = get_font(findfont(_font(bold)))
    font.set_size(100.0, _POINTS_PER_IN)
    glyph = font.load_char(ord(letter))
    return glyph.linearHoriAdvance / 65536 / 100.0


class _Letters(Artist):
    """All lines of a sheet, drawn without the search for places that every `Text` would make."""

    def __init__(self, lines: Sequence[Line]) -> None:
        super().__init__()
        self._written = lines

    def draw(self, renderer: RendererBase) -> None:
        for line in self._written:
            gc = renderer.new_gc()
            gc.set_foreground(line.colour)
            font = _font(line.bold).copy()
            font.set_size(line.points)
            x, y = (_POINTS_PER_IN * inch for inch in (line.x_in, PAGE_IN[1] - line.y_in))
            renderer.draw_text(gc, x, y, line.words, font, 0.0)
            gc.restore()


def _figure(sheet: Sequence[Mark]) -> Figure:
    figure = Figure(figsize=PAGE_IN, facecolor="white")
    for mark in sheet:
        match mark:
            case Box():
                figure.add_artist(_box(mark))
            case Area(image=Chart() as chart):
                chart.draw_at(figure, mark.x_in, mark.y_in, mark.width_in, mark.height_in)
            case Area(image=Picture() as picture):
                axes = axes_at(figure, mark.x_in, mark.y_in, mark.width_in, mark.height_in)
                image = np.asarray(Image.open(io.BytesIO(picture.png.tobytes())))
                axes.imshow(image, interpolation="none", aspect="auto")  # no pixel is made twice
                axes.set_axis_off()
            case Line():
                pass
            case _:
                raise TypeError(mark)
    figure.add_artist(_Letters([mark for mark in sheet if isinstance(mark, Line)]))
    return figure


def _box(box: Box) -> Artist:
    left, top = box.x_in / PAGE_IN[0], 1 - box.y_in / PAGE_IN[1]
    width, height = box.width_in / PAGE_IN[0], box.height_in / PAGE_IN[1]
    if height == 0:
        return Line2D((left, left + width), (top, top), color=box.colour, lw=0.6)
    colour = to_rgba(box.colour, box.opacity)
    return Rectangle((left, top - height), width, height, facecolor=colour, lw=0)
