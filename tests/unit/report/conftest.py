"""What is printed: the sheets of a report's PDF, as a reader of PDF finds them."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import pypdfium2
from pypdfium2.raw import FPDF_PAGEOBJ_IMAGE

from limbgram.report.blocks import Report
from limbgram.report.pdf import pdf_of


@dataclass(frozen=True, kw_only=True)
class Rect:
    """Points from the lower left corner of a sheet."""

    left: float
    bottom: float
    right: float
    top: float

    def meets(self, other: "Rect") -> bool:
        return (
            min(self.right, other.right) - max(self.left, other.left) > 0.5
            and min(self.top, other.top) - max(self.bottom, other.bottom) > 0.5
        )


@dataclass(frozen=True, kw_only=True)
class Paper:
    """One sheet."""

    width: float
    height: float
    lines: Sequence[str]
    """In the order in which they are read; a line that wraps is several."""
    letters: Sequence[Rect]
    """Around the words of a line, or of a cell."""
    images: Sequence[Rect]

    @property
    def words(self) -> str:
        return " ".join(" ".join(self.lines).split())


def papers_of(report: Report) -> list[Paper]:
    """The sheets of the report's PDF."""
    with _opened(pdf_of(report)) as document:
        return [_paper(page) for page in document]


@contextmanager
def _opened(pdf: bytes) -> Iterator[pypdfium2.PdfDocument]:
    document = pypdfium2.PdfDocument(pdf)
    try:
        yield document
    finally:
        document.close()


def _paper(page: pypdfium2.PdfPage) -> Paper:
    text = page.get_textpage()
    rects = [text.get_rect(k) for k in range(text.count_rects())]
    images = [one.get_bounds() for one in page.get_objects(filter=(FPDF_PAGEOBJ_IMAGE,))]
    width, height = page.get_size()

    def rect(corners: Sequence[float]) -> Rect:
        left, bottom, right, top = corners
        return Rect(left=left, bottom=bottom, right=right, top=top)

    return Paper(
        width=width,
        height=height,
        lines=text.get_text_range().split("\r\n"),
        letters=[rect(one) for one in rects],
        images=[rect(one) for one in images],
    )
