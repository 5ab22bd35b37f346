"""Blocks: what a report is made of before it becomes a page or paper.

A report is put together once, by one function, as a list of these; `report.html` writes it as a
page and `report.pdf` as sheets of paper. Words are plain text: who writes them out escapes them.
"""

from dataclasses import dataclass
from typing import Literal

from limbgram.findings import Finding
from limbgram.report.drawings.drawing import Chart, Picture

Colour = Literal["green", "amber", "red", "blue"]


@dataclass(frozen=True, kw_only=True)
class Banner:
    """A coloured strip that nobody can overlook: a word, a sentence, and more sentences."""

    badge: str
    words: str
    colour: Colour
    reasons: tuple[str, ...] = ()


@dataclass(frozen=True)
class Card:
    """One question of the first screen, its answer, and a note on it."""

    question: str
    answer: str
    note: str


@dataclass(frozen=True, kw_only=True)
class Text:
    """A paragraph; a note is printed in smaller and paler letters."""

    words: str
    note: bool = False
    page_only: bool = False
    kind: Literal["text"] = "text"


@dataclass(frozen=True, kw_only=True)
class Heading:
    """A heading inside a section."""

    words: str
    page_only: bool = False
    kind: Literal["heading"] = "heading"


@dataclass(frozen=True, kw_only=True)
class Link:
    """A way to a file beside the page."""

    words: str
    address: str
    page_only: bool = True
    kind: Literal["link"] = "link"


@dataclass(frozen=True, kw_only=True)
class Fields:
    """Words in a row, each with room behind it to write by hand."""

    labels: tuple[str, ...]
    page_only: bool = False
    kind: Literal["fields"] = "fields"


@dataclass(frozen=True, kw_only=True)
class AdviceList:
    """Numbered: what to check or to know, and what to do; on a full sheet the last give way."""

    items: tuple[Finding, ...]
    page_only: bool = False
    kind: Literal["advice"] = "advice"


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table; heads that begin with # stand over columns of numbers.

    The last cell of a row that has fewer cells than there are heads is a sentence over the rest.
    """

    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    marked: tuple[bool, ...] = ()
    """Rows in red."""
    colours: tuple[Colour | None, ...] = ()
    """Of the rows' last words, such as the colour of a verdict."""
    folded: str = ""
    """Not empty: the page shows these words, and the table when they are clicked."""
    page_head: str = ""
    """Head of a column that paper has no room for."""
    shorten: Literal["", "thin", "cut"] = ""
    """How a full sheet shortens it: every second or third row, or the first rows alone."""
    page_only: bool = False
    kind: Literal["table"] = "table"


@dataclass(frozen=True, kw_only=True)
class Illustration:
    """A picture or chart with the sentence that explains it."""

    image: Picture | Chart
    caption: str
    most_in: float = 9.0
    """Height on paper, at most."""
    least_in: float = 1.0
    """Height on paper, at least."""
    optional: bool = False
    """It gives way where a sheet is full."""
    address: str = ""
    """Page beside this one that opens when the picture is clicked; empty for none."""
    page_only: bool = False
    kind: Literal["illustration"] = "illustration"


@dataclass(frozen=True, kw_only=True)
class Columns:
    """Two pictures or charts side by side, as far as the page is wide enough."""

    figures: tuple[Illustration, ...]
    page_only: bool = False
    kind: Literal["columns"] = "columns"


Block = Text | Heading | Link | Fields | AdviceList | Table | Illustration | Columns


@dataclass(frozen=True, kw_only=True)
class Section:
    """Blocks under a heading."""

    title: str
    blocks: tuple[Block, ...]
    sheet: int | None = None
    """On which sheet of paper it stands; None for the page alone."""


@dataclass(frozen=True, kw_only=True)
class Report:
    """What a page shows from top to bottom, and a PDF as far as its sheets hold it."""

    title: str
    banner: Banner
    cards: tuple[Card, ...] = ()
    note: str = ""
    """Under the cards: what the banner means, or the facts behind it."""
    intended_use: str
    sections: tuple[Section, ...]
