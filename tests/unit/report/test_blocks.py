"""A report's blocks on page and paper: nothing lost, nothing cut off, nothing from outside."""

import re

import numpy as np
from matplotlib.axes import Axes
from tests.unit.report.conftest import Paper, papers_of

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
from limbgram.report.pdf import pdf_of

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


def printed(made: Report) -> Paper:
    (sheet,) = papers_of(made)
    return sheet


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
    assert NASTY in printed(made).words


def test_what_is_to_be_typed_stands_out_and_stays_escaped() -> None:
    page = html_of(report(Text(words="Say `--tape 150=<mm>` & go on; a lone ` stays.")))
    assert "Say <code>--tape 150=&lt;mm&gt;</code> &amp; go on; a lone ` stays." in page


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
    plain = printed(report(Table(heads=heads, rows=(("260.0", "1", "2"),)), Text(words="end")))
    long = printed(report(Table(heads=heads, rows=(("260.0", reason),)), Text(words="end")))
    assert reason in long.words
    assert sum("word" in line for line in long.lines) > 2
    last = [min(one.bottom for one in paper.letters if one.bottom > 100) for paper in (plain, long)]
    assert last[0] - last[1] > 2 * 7.0


def test_nothing_on_paper_lies_beyond_the_edge_or_on_something_else() -> None:
    rows = tuple((f"photo {k}", "1.0", "a remark " * (k % 5)) for k in range(20))
    paper = printed(
        report(
            Text(words="word " * 200),
            Text(words="averyveryverylongword" * 20),
            Table(heads=("photo", "#mm", "remarks"), rows=rows),
            Illustration(image=picture(), caption="Caption"),
        )
    )
    whole = "".join(paper.lines).replace("\u200b", "")  # where a word may break
    assert whole.count("averyveryverylongword") == 20
    for one in (*paper.letters, *paper.images):
        assert 36 < one.left < one.right < paper.width - 36
        assert 12 < one.bottom < one.top < paper.height - 18
    (image,) = paper.images
    assert not any(one.meets(image) for one in paper.letters)
    for k, one in enumerate(paper.letters):
        assert not any(one.meets(other) for other in paper.letters[k + 1 :])


def test_a_full_sheet_shrinks_pictures_then_leaves_out_then_shortens_and_says_so() -> None:
    def filled(rows: int) -> Paper:
        table = Table(heads=("#a", "#b"), rows=(("123", "456"),) * rows, shorten="cut")
        return printed(report(table, Illustration(image=picture(), caption="", optional=True)))

    def high(paper: Paper) -> float:
        (image,) = paper.images
        return image.top - image.bottom

    large, small = filled(5), filled(38)
    assert high(large) > high(small) >= 72.0 - 0.1
    assert "more on the page" not in small.words
    none = filled(100)
    assert none.images == []
    left_out = 100 - none.words.count("123")
    assert 0 < left_out < 60
    assert f"and {left_out} more on the page" in none.words


def test_a_table_is_thinned_out_evenly() -> None:
    rows = tuple((f"row{k}", "x") for k in range(150))
    paper = printed(report(Table(heads=("#a", "b"), rows=rows, shorten="thin")))
    kept = [int(one) for one in re.findall(r"row(\d+)", paper.words)]
    steps = set(np.diff(kept))
    assert len(steps) == 1
    (step,) = steps
    assert step > 1
    assert f"One row in {step}; all are on the page." in paper.words


def test_a_pdf_is_the_same_bytes_each_time() -> None:
    made = report(Columns(figures=(Illustration(image=chart(), caption="c"),)), Text(words="x"))
    assert pdf_of(made) == pdf_of(made)
    assert html_of(made) == html_of(made)


def test_a_pdf_can_be_read_aloud() -> None:
    """Tagged, with a title, a language and fonts whose letters have names."""
    pdf = pdf_of(report(Columns(figures=(Illustration(image=chart(), caption="c"),))))
    assert b"/Title" in pdf
    assert b"/Lang" in pdf
    assert b"/MarkInfo" in pdf
    assert b"/FontFile" in pdf
    assert b"/Type3" not in pdf
    assert b"pdfuaid:part>1" in pdf


def test_what_cannot_be_shortened_goes_on_on_another_sheet() -> None:
    texts = [Text(words=f"number{number} " + "word " * 150) for number in range(40)]
    papers = papers_of(report(*texts))
    assert len(papers) > 2
    for number, paper in enumerate(papers, start=1):
        assert f"Title (sheet {number} of {len(papers)})" in paper.words
        assert "AMBER" in paper.words
        assert "For professionals." in paper.words
        lowest = min(one.bottom for one in paper.letters if one.bottom > 45)
        assert number == len(papers) or lowest < 0.15 * paper.height, "no sheet half empty"
    begun = [int(one) for paper in papers for one in re.findall(r"number(\d+)", paper.words)]
    assert begun == list(range(40))


def test_a_table_that_does_not_fit_goes_on_below_its_heads_and_loses_no_row() -> None:
    rows = tuple((f"row{k}", "x") for k in range(200))
    papers = papers_of(report(Table(heads=("#first", "second"), rows=rows)))
    assert len(papers) > 1
    assert all("first" in paper.words for paper in papers)
    kept = [int(one) for paper in papers for one in re.findall(r"row(\d+)", paper.words)]
    assert kept == list(range(200))
