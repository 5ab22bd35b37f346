"""The page and the PDF hold what the tree says, and nothing from outside."""

import json
import math
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from tests.unit.report.conftest import papers_of

from limbgram.findings import advice, note, told
from limbgram.reconstruction.mapping.scene import Movement
from limbgram.reconstruction.scale.stated_lengths import TapedGirth
from limbgram.reconstruction.scale.taped_girths import TapeWitness, TapeWitnesses
from limbgram.report.accuracy.assessment import assess
from limbgram.report.accuracy.charts import Series, accuracy_pictures, bars, histogram
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.accuracy.glossary import terms, value_at
from limbgram.report.accuracy.judgement import without_light
from limbgram.report.accuracy.layout import accuracy_report
from limbgram.report.accuracy.truth import KnownTruth
from limbgram.report.alignment import Truth
from limbgram.report.drawings.charts import accuracy_chart
from limbgram.report.drawings.drawing import png
from limbgram.report.drawings.surfaces import sigma_map
from limbgram.report.html import html_of

VOID = {"meta", "img", "br"}


class Reader(HTMLParser):
    """Tags in balance, and every address that is asked for."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: set[str] = set()
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def with_truth(evidence: Evidence) -> KnownTruth:
    mesh = evidence.mesh
    truth = Truth(
        vertices_mm=mesh.vertices_mm,
        faces=mesh.faces,
        seen=np.ones(len(mesh), bool),
        centres_mm=np.zeros((0, 3)),
    )
    return KnownTruth(kind="itself", truth=truth, centres_mm=np.zeros((0, 3)), alignment="frame")


def test_the_tree_is_plain_json_and_says_what_its_figures_are(with_sigmas: Evidence) -> None:
    tree = assess(with_sigmas).tree
    assert json.loads(json.dumps(tree, allow_nan=False)) == tree
    assert tree["schema"] == "limbgram-accuracy/2"
    assert [term.path for term in terms()] == list(tree["glossary"])


def test_every_term_of_the_glossary_leads_somewhere(with_sigmas: Evidence) -> None:
    scene = with_sigmas.metric.scene
    still = Movement(
        kind="still",
        group=np.zeros(len(scene.names), np.int64),
        shift=np.zeros(len(scene.names)),
        turn_deg=np.zeros(len(scene.names)),
    )
    looked_at = replace(scene, movement=still, bending=still)
    evidence = replace(with_sigmas, metric=replace(with_sigmas.metric, scene=looked_at))
    tree = assess(evidence, with_truth(with_sigmas)).tree
    unknown = {
        "images.noise_grey",  # no files
        "truth.camera_rms_mm",  # no cameras
        "truth.sigma.rank_correlation",  # all sigmas are equal
    }
    for term in terms():
        assert (value_at(tree, term.path) is None) == (term.path in unknown), term.path


@pytest.mark.parametrize("compared", [False, True])
def test_the_page_is_whole_and_asks_nothing_of_the_network(
    with_sigmas: Evidence, compared: bool
) -> None:
    photo = replace(with_sigmas.photos.photos[0], name="<b>tube</b>", burnt=0.9)
    photos = replace(with_sigmas.photos, photos=(photo, *with_sigmas.photos.photos[1:]))
    named = replace(with_sigmas, photos=photos)
    assessment = assess(named, with_truth(named) if compared else None)
    page = html_of(accuracy_report(assessment, accuracy_pictures(named, assessment)))
    reader = Reader()
    reader.feed(page)
    assert reader.open == []
    assert "script" not in reader.tags
    assert all(address.startswith("data:") for address in reader.addresses)
    assert len(reader.addresses) == (2 if compared else 1)
    assert "<b>tube" not in page
    assert "&lt;b&gt;tube" in page
    assert told(without_light(assessment.headline)) in page
    for finding in assessment.findings:
        assert advice(finding).split("`")[0] in page


def test_a_comparison_says_how_much_of_the_surface_it_is_of(evidence: Evidence) -> None:
    """What lies far from the truth is another thing, and must not be passed over in silence."""
    mesh = evidence.mesh
    moved = mesh.vertices_mm.copy()
    moved[:300, :2] *= 1.4  # 20 mm outwards
    doubled = replace(evidence, mesh=mesh.with_vertices(moved))
    assessment = assess(doubled, with_truth(evidence))
    assert assessment.figures.truth is not None
    compared = assessment.figures.truth.vertices
    assert compared == len(mesh) - 300
    page = html_of(accuracy_report(assessment, accuracy_pictures(doubled, assessment)))
    assert f"{compared:,} of {len(mesh):,} vertices, those measured and nearer than 15 mm" in page
    assert "or it lies 15 mm or more from it" in page


def test_the_pdf_has_two_pages(evidence: Evidence) -> None:
    assessment = assess(evidence)
    pictures = accuracy_pictures(evidence, assessment)
    assert len(papers_of(accuracy_report(assessment, pictures))) == 2


def test_a_histogram_draws_each_step_where_it_is() -> None:
    axes = Figure().subplots()
    histogram([0.0, 1.0, 2.0], [Series("a", [1.0, 3.0], "#000000")], "mm", "steps").draw(axes)
    (steps,) = axes.patches
    xy = steps.get_path().vertices
    assert {tuple(one) for one in xy} >= {(0, 0), (0, 1), (1, 1), (1, 3), (2, 3), (2, 0)}
    assert axes.get_xlabel() == "mm"


@pytest.mark.parametrize("values", [(0.0304, 0.000732), (0.0304, math.nan)])
def test_the_figures_behind_bars_are_not_cut_off(values: tuple[float, float]) -> None:
    chart = bars(["image measurement", "scale"], values, "mm", "parts of the error")
    figure = Figure(figsize=(chart.width_in, chart.height_in))
    chart.draw_on(figure, chart.width_in, chart.height_in)
    FigureCanvasAgg(figure).draw()
    (axes,) = figure.axes
    ends = [words.get_window_extent().x1 for words in axes.texts]
    assert len(ends) == 4
    assert 0.9 * axes.bbox.x1 < max(ends) <= axes.bbox.x1


def test_the_map_of_sigmas_names_its_unit(with_sigmas: Evidence) -> None:
    figure = sigma_map(with_sigmas.mesh, with_sigmas.metric).figure
    assert figure.axes[-1].get_xlabel() == "one standard deviation along the normal, mm"
    bare = replace(with_sigmas.metric, scale=replace(with_sigmas.metric.scale, unit="unitless"))
    assert "NO SCALE" in sigma_map(with_sigmas.mesh, bare).figure.axes[-1].get_xlabel()


@pytest.mark.parametrize("words", [3, 40])
def test_the_verdict_stands_whole_on_every_sheet(with_sigmas: Evidence, words: int) -> None:
    said = replace(
        assess(with_sigmas), light="red", headline=note("said.as_is", message="unlikely " * words)
    )
    for paper in papers_of(accuracy_report(said, ())):
        assert "RED" in paper.words
        assert paper.words.count("unlikely") == words


def test_taped_girths_stand_beside_the_surface_or_say_why_not(with_sigmas: Evidence) -> None:
    near = TapeWitness(
        taped=TapedGirth(girth_mm=315, height_mm=150), measured_mm=314.2, sigma_mm=1.6
    )
    nowhere = TapeWitness(
        taped=TapedGirth(girth_mm=350),
        measured_mm=math.nan,
        sigma_mm=math.nan,
        reason=note("said.as_is", message="no < end"),
    )
    assessment = assess(replace(with_sigmas, tapes=TapeWitnesses((near, nowhere))))
    page = html_of(accuracy_report(assessment, ()))
    assert "<td>at 150 mm above board or table</td>" in page
    assert '<td class="n">-0.8</td>' in page
    assert (
        'at the widest place</td><td class="n">350.0</td><td class="sentence" colspan="4">' in page
    )


def test_photos_with_dollar_signs_in_their_names_are_drawn(evidence: Evidence) -> None:
    names = tuple(f"$__${name}" for name in evidence.metric.scene.names)
    metric = replace(evidence.metric, scene=replace(evidence.metric.scene, names=names))
    drawn = png(accuracy_chart(evidence.photos, metric).figure)
    assert drawn.tobytes().startswith(b"\x89PNG")
