"""A report's blocks on page and paper: nothing lost, nothing cut off, nothing from outside."""

import re

import numpy as np
import pytest
from matplotlib.axes import Axes

from limbgram.core.errors import ExportError
from limbgram.findings import fault
from limbgram.report.blocks import (
    AdviceList,
    Banner,
    Block,
    Card,
    Columns,
    Illustration,
    Report,
    Section,
    Table,
    Text,
)
from limbgram.report.drawings.drawing import Chart, Picture, bare, png
from limbgram.report.html import html_of
from limbgram.report.pdf import PAGE_IN, Area, Line, pdf_of, sheets_of, width_of, wrapped

NASTY = '<b>$x^$ & "y"</b>'
"""What would be markup, or a formula that cannot be read."""


def report(*blocks: Block, banner: str = "a sentence") -> Report:
    return Report(
        title="Title",
        banner=Banner(badge="AMBER", words=banner, colour="amber"),
        cards=(Card("Question", "Answer", "Note"),),
        intended_use="For professionals.",
        sections=(Section(title="Section", blocks=blocks, sheet=1),),
    )


def words_of(made: Report) -> list[str]:
    (sheet,) = sheets_of(made)
    return [mark.words for mark in sheet if isinstance(mark, Line)]


def picture(height_px: int = 300) -> Picture:
    return Picture("name", "Picture", "Caption", png(bare(3.0, height_px / 100)))


def chart() -> Chart:
    def draw(axes: Axes) -> None:
        axes.barh([0], [1.0])
        axes.set_yticks([0], [NASTY])

    return Chart(draw=draw, title=NASTY)


def test_tables_mark_numbers_and_bad_rows() -> None:
    table = Table(heads=("name", "#number"), rows=(("a", "1"), ("b", "2")), marked=(False, True))
    page = html_of(report(table))
    assert page.count('<td class="n">') == 2
    assert page.count('<tr class="marked">') == 1


def test_a_sentence_in_place_of_figures_spans_their_columns_and_wraps() -> None:
    """In a column of numbers, which never wrap, it would push all others out of sight."""
    reason = "The plane runs into an open edge. " * 5
    rows = (("20.0", "188.6", "27.2"), ("260.0", reason))
    page = html_of(report(Table(heads=("#height", "#tape", "#area"), rows=rows)))
    assert f'<td class="n">260.0</td><td class="sentence" colspan="2">{reason}</td></tr>' in page
    assert page.count('<td class="n">') == 4


def test_words_of_files_are_escaped_and_no_formulas() -> None:
    made = report(
        Text(words=NASTY),
        Table(heads=("a", "b"), rows=((NASTY, NASTY),)),
        AdviceList(items=(fault("record.said", what=NASTY, remedy=NASTY),)),
        Columns(figures=(Illustration(image=chart(), caption=NASTY),)),
        banner=NASTY,
    )
    page = html_of(made)
    assert "<b>$x" not in page
    assert page.count("&lt;b&gt;$x^$ &amp; ") == 10  # three times in the chart
    assert pdf_of(made).endswith(b"%%EOF\n")


def test_a_page_asks_nothing_of_the_network() -> None:
    image = Illustration(image=picture(), caption="")
    page = html_of(report(image, Illustration(image=chart(), caption="")))
    assert not re.findall(r'(?:src|href)="(?!data:|#)', page)
    assert "<script" not in page
    assert "<svg viewBox=" in page
    assert "matplotlib" not in page.lower()


def test_a_sentence_on_paper_is_whole_and_moves_what_follows_down() -> None:
    reason = " ".join(f"word{number}" for number in range(60))
    heads = ("#height", "#tape", "#area")
    (plain,) = sheets_of(report(Table(heads=heads, rows=(("260.0", "1", "2"),)), Text(words="end")))
    (long,) = sheets_of(report(Table(heads=heads, rows=(("260.0", reason),)), Text(words="end")))
    lines = [one for one in long if isinstance(one, Line) and one.words.startswith("word")]
    assert " ".join(one.words for one in lines) == reason
    assert len(lines) > 1
    ends = [one.y_in for sheet in (plain, long) for one in sheet
            if isinstance(one, Line) and one.words == "end"]  # fmt: skip
    assert ends[1] - ends[0] == pytest.approx((len(lines) - 1) * 1.32 * 7 / 72)


def test_nothing_on_paper_lies_beyond_the_edge_or_on_something_else() -> None:
    rows = tuple((f"photo {k}", "1.0", "a remark " * (k % 5)) for k in range(20))
    made = report(
        Text(words="word " * 200),
        Table(heads=("photo", "#mm", "remarks"), rows=rows),
        Illustration(image=picture(), caption="Caption"),
    )
    (sheet,) = sheets_of(made)
    lines = [mark for mark in sheet if isinstance(mark, Line)]
    for line in lines:
        assert line.x_in > 0.5
        assert line.x_in + width_of(line.words, line.points, bold=line.bold) < PAGE_IN[0] - 0.5
        assert 0.5 < line.y_in < PAGE_IN[1] - 0.25
    (area,) = (mark for mark in sheet if isinstance(mark, Area))
    inside = [one for one in lines if area.y_in < one.y_in < area.y_in + area.height_in]
    assert inside == []


def test_a_full_sheet_shrinks_pictures_then_leaves_out_then_shortens_and_says_so() -> None:
    def filled(rows: int) -> tuple[list[Area], list[str]]:
        heads = ("#a", "#b")
        table = Table(heads=heads, rows=(("1", "2"),) * rows, shorten="cut")
        image = Illustration(image=picture(), caption="", optional=True)
        made = report(table, image)
        (sheet,) = sheets_of(made)
        return [mark for mark in sheet if isinstance(mark, Area)], words_of(made)

    (large,), _ = filled(5)
    (small,), words = filled(40)
    assert large.height_in > small.height_in >= 1.0
    assert not any("more on the page" in one for one in words)
    none, words = filled(100)
    assert none == []
    left_out = 100 - words.count("1")
    assert 0 < left_out < 60
    assert f"and {left_out} more on the page" in words


def test_a_table_is_thinned_out_evenly() -> None:
    rows = tuple((str(k), "x") for k in range(150))
    words = words_of(report(Table(heads=("#a", "b"), rows=rows, shorten="thin")))
    kept = [int(one) for one in words if one.isdigit()]
    steps = set(np.diff(kept))
    assert len(steps) == 1
    (step,) = steps
    assert step > 1
    assert f"One row in {step}; all are on the page." in words


def test_lines_are_as_wide_as_asked_and_lose_no_letter() -> None:
    words = "a short one and averyveryverylongwordthatdoesnotfitonanyline " * 3
    lines = wrapped(words, 1.0, 7.0)
    assert max(width_of(line, 7.0) for line in lines) <= 1.0 + 1e-5
    assert "".join(lines).replace(" ", "") == words.replace(" ", "")


def test_a_pdf_is_the_same_bytes_each_time() -> None:
    made = report(Columns(figures=(Illustration(image=chart(), caption="c"),)), Text(words="x"))
    assert pdf_of(made) == pdf_of(made)
    assert html_of(made) == html_of(made)


def test_what_cannot_be_shortened_goes_on_on_another_sheet() -> None:
    texts = [Text(words=f"{number} " + "word " * 150) for number in range(40)]
    sheets = sheets_of(report(*texts))
    assert len(sheets) > 2
    for number, sheet in enumerate(sheets, start=1):
        lines = [mark for mark in sheet if isinstance(mark, Line)]
        assert f"Title (sheet {number} of {len(sheets)})" in [line.words for line in lines]
        foot_in = next(line.y_in for line in lines if line.words == "For professionals.")
        assert max(line.y_in for line in lines) == foot_in < PAGE_IN[1]
        written = [line.y_in for line in lines if line.y_in < foot_in]
        assert number == len(sheets) or max(written) > 0.85 * PAGE_IN[1], "no sheet half empty"
    begun = [mark.words.split()[0] for sheet in sheets for mark in sheet if isinstance(mark, Line)]
    assert [one for one in begun if one.isdigit()] == [str(number) for number in range(40)]


def test_a_text_higher_than_paper_is_refused() -> None:
    with pytest.raises(ExportError, match="higher than the paper"):
        sheets_of(report(Text(words="word " * 9000)))
