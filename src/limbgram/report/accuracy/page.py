"""Words: figures of the tree as people read them, for page and PDF alike.

Pictures of the surface for the accuracy page: sigma of every vertex, error where known.

Sections of the page on the adjustment: residuals, rays and overlap, cameras.

Sections of the page below the first screen: charts and tables for those who measure.

The page: one HTML file, nothing from outside, no script; its first screen is for everybody.

In      the tree of an assessment, and pictures of the surface (PNG).
Out     HTML text.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np
from jaxtyping import Float64

from limbgram.report.accuracy.assessment import Assessment
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.accuracy.figures import LENGTH, SHARE
from limbgram.report.accuracy.glossary import Term, terms, value_at
from limbgram.report.accuracy.svg import (
    BLUE,
    GREEN,
    ORANGE,
    Series,
    bars,
    curve,
    figure,
    histogram,
    matrix,
    vectors,
)
from limbgram.report.document.page import card, document, figure_html, table
from limbgram.report.drawings.drawing import Picture, png
from limbgram.report.drawings.maps import signed_map, size_map
from limbgram.report.drawings.surfaces import four_sides

MEANING = (
    "Green: finer than a socket's fit can show. Amber: usable, with the doubt that is named. Red: "
    "much of the limb is missing, a girth or volume may be wrong by a ply of sock or more, or the "
    "size is not known; make nothing from it unchecked."
)


@dataclass(frozen=True)
class Card:
    """One question of the first screen and its answer."""

    question: str
    answer: str
    note: str


@dataclass(frozen=True)
class TermRow:
    """One figure of the glossary, ready to print."""

    title: str
    value: str
    unit: str
    definition: str


def cards(tree: dict[str, Any]) -> tuple[Card, ...]:
    """Surface, scale, completeness, photos."""
    surface, images, lengths = tree["surface"], tree["images"], tree["lengths"]
    unit = tree["unit"]
    if tree["truth"] is not None:
        error, note = tree["truth"]["p95_mm"], "95 % of the surface lies nearer to the truth"
    else:
        sure = tree["expected"]["basis"] == "vertex sigmas"
        error = tree["expected"]["p95_mm"]
        note = "95 % of the surface is expected nearer" + ("" if sure else " (a rough guess)")
    checks = lengths["check"]
    return (
        Card("Surface error", number(error, unit), note),
        Card(
            "Scale on lengths that did not set it",
            f"{100 * lengths['check_worst']:.3f} %" if checks else "not checked",
            f"worst of {len(checks)}: {lengths['check_worst_label']}"
            if checks
            else "give a second known length",
        ),
        Card(
            "Measured",
            f"{surface['measured_share']:.1%}",
            f"filled in {surface['filled_share']:.1%}, left out {surface['left_out_share']:.1%}",
        ),
        Card(
            "Photos placed",
            f"{images['placed']} of {images['photos']}",
            f"a pixel is {number(images['pixel'], unit)} on the limb",
        ),
    )


def number(value: float | None, unit: str) -> str:
    """A length with its unit; three digits."""
    return "not known" if value is None else f"{value:.3g} {unit}"


def text_of(value: float | None, form: str) -> str:
    """A figure in a format; empty where it is not known."""
    return "" if value is None else format(value, form)


def term_rows(tree: dict[str, Any]) -> tuple[TermRow, ...]:
    """Every figure of the glossary that this tree has."""
    found = ((term, value_at(tree, term.path)) for term in terms())
    return tuple(_term_row(term, value, tree["unit"]) for term, value in found if value is not None)


def _term_row(term: Term, value: float, unit: str) -> TermRow:
    if term.unit == SHARE:
        return TermRow(term.title, f"{100 * value:.4g}", "%", term.definition)
    text = f"{value:,}" if isinstance(value, int) else f"{value:.4g}"
    name = unit if term.unit == LENGTH else term.unit.replace(LENGTH, unit).replace("^2", "²")
    if not isinstance(value, int) and abs(value) >= 10_000:
        text = f"{value:,.0f}"
    return TermRow(term.title, text, name, term.definition)


def accuracy_pictures(evidence: Evidence, assessment: Assessment) -> tuple[Picture, ...]:
    """Error map where the truth is known; sigma map, or what was measured and what filled."""
    pictures: list[Picture] = []
    if assessment.off_mm is not None:
        pictures.append(_error_map(evidence, assessment.off_mm))
    if evidence.mesh.sigma_mm is not None:
        pictures.append(_sigma_map(evidence, evidence.mesh.sigma_mm.astype(np.float64)))
    else:
        drawing = four_sides(evidence.mesh, evidence.metric)
        title = "What was measured, and what was filled in"
        pictures.append(Picture("measured", title, drawing.caption, png(drawing.figure)))
    return tuple(pictures)


def _error_map(evidence: Evidence, off_mm: Float64[np.ndarray, " n"]) -> Picture:
    figure = signed_map(
        evidence.mesh, off_mm, "distance from the truth, mm (red: outside)", in_mm=True
    )
    caption = (
        "Signed distance of every measured vertex from the truth. Grey: not compared, because "
        "fewer than three photos see the truth there; orange: filled in, not measured."
    )
    return Picture("error", "Where it is off", caption, png(figure))


def _sigma_map(evidence: Evidence, sigma_mm: Float64[np.ndarray, " n"]) -> Picture:
    label = f"sigma along the normal, {evidence.unit}"
    figure = size_map(evidence.mesh, sigma_mm, label, in_mm=evidence.unit == "mm")
    caption = (
        "How sure each place is: one standard deviation along the normal, cameras and scale "
        "included. Orange is filled in: no photo measured it."
    )
    return Picture("sigma", "How sure the surface is", caption, png(figure))


Tree = dict[str, Any]


def residual_section(tree: Tree) -> Iterator[str]:
    """Histogram, systematic grid, by photo."""
    found = tree["residuals"]
    yield "<h2>Residuals of the image points</h2>"
    bins = found["histogram"]
    series = [Series("x", bins["x"], BLUE), Series("y", bins["y"], ORANGE)]
    unit = "measured minus projected, px (ends hold what lies beyond)"
    photos = found["by_photo"]
    yield (
        '<div class="two">'
        + figure(
            histogram(bins["edges_px"], series, unit, "Histogram of the residuals"),
            f"RMS of one coordinate {text_of(found['rms_px'], '.4f')} px; "
            f"{text_of(found['beyond_3_sigma_share'], '.2%')} lie beyond three robust sigmas "
            "(Gaussian: 0.27 %).",
        )
        + figure(
            bars(
                [one["name"] for one in photos],
                [_finite(one["rms_px"]) for one in photos],
                "px",
                "Residual RMS by photo",
            ),
            "RMS of one coordinate, photo by photo.",
        )
        + "</div>"
    )
    for camera in found["by_camera"]:
        yield figure(
            vectors(camera["grid"], "Mean residual by place in the picture"),
            "Mean residual of all photos by place in the picture. Arrows that follow a pattern "
            f"mean a lens that is not as calibrated: systematic part "
            f"{text_of(camera['systematic_px'], '.4f')} px (one coordinate, chance taken off).",
        )
        rows = [
            (
                f"{zone['from_share']:.0%} to {zone['to_share']:.0%}",
                f"{zone['observations']:,}",
                text_of(zone["rms_px"], ".4f"),
                text_of(zone["outward_px"], "+.4f"),
            )
            for zone in camera["zones"]
        ]
        heads = ("middle to corner", "#image points", "#RMS px", "#mean outward px")
        yield table(heads, rows)


def network_section(tree: Tree) -> Iterator[str]:
    """Rays, angles, overlap."""
    network = tree["network"]
    rays, angles, overlap = network["rays"], network["angles"], network["overlap"]
    yield "<h2>Rays and overlap</h2>"
    numbers = rays["numbers"]
    yield (
        '<div class="two">'
        + figure(
            histogram(
                angles["edges_deg"],
                [Series("points", angles["points"], BLUE)],
                "widest intersection angle, degrees",
                "Histogram of intersection angles",
            ),
            f"Median {angles['median_deg']:.0f} degrees; 5 % below {angles['low_deg']:.0f}.",
        )
        + figure(
            histogram(
                [n - 0.5 for n in (*numbers, numbers[-1] + 1)],
                [Series("points", rays["points"], GREEN)],
                f"rays per point ({numbers[-1]}: or more)",
                "Histogram of rays per point",
            ),
            f"{network['points']:,} points, {rays['mean']:.2f} rays on average, "
            f"{rays['two_share']:.0%} with two; redundancy {network['redundancy']:,} "
            f"(mean redundancy number {network['redundancy_share']:.2f}), sigma0 "
            f"{text_of(network['sigma0_px'], '.4f')} px.",
        )
        + "</div>"
    )
    weakest = min(overlap["best_partner"], default=0)
    yield figure(
        matrix(overlap["names"], overlap["shared_points"], "Points shared by photos", signed=False),
        "Points that two photos share: the darker, the more. The photo joined worst shares "
        f"{weakest:,} with its best partner.",
    )


def camera_section(tree: Tree) -> Iterator[str]:
    """Every lens: parameters, sigmas, correlations."""
    yield "<h2>Cameras</h2>"
    for lens in tree["cameras"]:
        source = "calibrated with a board" if lens["source"] == "board" else "guessed from EXIF"
        name = escape(lens["label"] or f"camera {lens['camera'] + 1}")
        yield f"<h3>{name}, {lens['width_px']} x {lens['height_px']} px, {source}</h3>"
        rows = [
            (
                one["name"],
                one["unit"],
                f"{one['value']:.6g}",
                "held" if one["held"] else text_of(one["sigma"], ".2g"),
                f"{one['calibrated']:.6g}",
                "held" if one["held"] else text_of(one["calibrated_sigma"], ".2g"),
                text_of(one["moved_sigmas"], "+.2f"),
            )
            for one in lens["parameters"]
        ]
        heads = ("parameter", "unit", "#adjusted", "#sigma", "#calibrated", "#sigma",
                 "#moved, sigmas")  # fmt: skip
        yield table(heads, rows)
        tied = lens["correlations"]
        if tied is not None:
            yield figure(
                matrix(tied["order"], tied["matrix"], "Correlations", signed=True),
                "Correlations of the adjusted parameters; orange is negative.",
            )


def pose_section(tree: Tree) -> Iterator[str]:
    """How surely each photo is placed."""
    poses = tree["poses"]
    if poses is None:
        return
    yield "<h3>Where the photos were taken: one standard deviation</h3>"
    rows = [
        (one["name"], f"{one['centre']:.4f}", f"{one['rotation_deg']:.5f}")
        for one in poses["by_photo"]
    ]
    yield table(("photo", f"#centre {tree['unit']}", "#rotation deg"), rows)


def _finite(value: float | None) -> float:
    return 0.0 if value is None else value


def against_truth(tree: Tree) -> Iterator[str]:
    """Distances from the truth, girths, and whether sigmas are honest."""
    truth = tree["truth"]
    if truth is None:
        return
    yield f"<h2>Against the truth: {escape(truth['kind'])}</h2>"
    yield f'<p class="note">Alignment: {escape(truth["alignment"])}.</p>'
    distances = truth["histogram"]
    charts = [
        figure(
            histogram(
                distances["edges_mm"],
                [Series("vertices", distances["vertices"], BLUE)],
                "signed distance, mm (outside is positive)",
                "Histogram of the distances from the truth",
            ),
            f"{truth['vertices']:,} measured vertices: RMS {truth['rms_mm']:.4f} mm "
            f"({truth['rms_px']:.3f} px), 95 % within {truth['p95_mm']:.4f} mm, mean "
            f"{truth['mean_mm']:+.4f} mm.",
        )
    ]
    if truth["sigma"] is not None:
        charts.append(_honesty(truth["sigma"]))
    yield f'<div class="two">{"".join(charts)}</div>'
    rows = [
        (
            f"{one['height_mm']:.1f}",
            f"{one['measured_mm']:.2f}",
            f"{one['true_mm']:.2f}",
            f"{one['error_mm']:+.3f}",
        )
        for one in truth["girths"]
    ]
    yield "<h3>Girths of sections (taut tape)</h3>"
    yield table(("#height mm", "#ours mm", "#true mm", "#error mm"), rows)


def _honesty(sigma: Tree) -> str:
    parts = sigma["by_sigma"]
    return figure(
        curve(
            [part["sigma_mm"] for part in parts],
            [part["rms_error_mm"] for part in parts],
            ("sigma told, mm", "RMS error found, mm"),
            "Error found against sigma told, in tenths of the vertices",
        ),
        f"Error over sigma: robust spread {sigma['robust_spread']:.2f} (1 is honest), "
        f"{sigma['within_95_share']:.1%} inside the 95 % interval, rank correlation "
        f"{text_of(sigma['rank_correlation'], '.2f') or 'not known'}.",
    )


def sigma_section(tree: Tree) -> Iterator[str]:
    """How sure the vertices are, and what the expected error is made of."""
    yield "<h2>Expected error</h2>"
    budget = [one for one in tree["expected"]["budget"] if one["sigma_mm"] is not None]
    charts = [
        figure(
            bars(
                [one["part"] for one in budget],
                [one["sigma_mm"] for one in budget],
                tree["unit"],
                "Parts of the expected error",
            ),
            f"Parts of the expected error, one standard deviation each, from the "
            f"{tree['expected']['basis']}.",
        )
    ]
    sigma = tree["surface"]["sigma"]
    if sigma is not None:
        charts.append(
            figure(
                histogram(
                    sigma["edges_mm"],
                    [Series("area", [100 * share for share in sigma["area_share"]], BLUE)],
                    f"sigma along the normal, {tree['unit']}; height: % of the area",
                    "Histogram of the vertex sigmas",
                ),
                f"Sigma of the measured surface: median {sigma['median_mm']:.3g}, 95 % below "
                f"{sigma['p95_mm']:.3g} {tree['unit']}; {sigma['shared_rms_mm']:.3g} of it is "
                "shared by all vertices.",
            )
        )
    yield f'<div class="two">{"".join(charts)}</div>'
    yield from _openings(tree)


def _openings(tree: Tree) -> Iterator[str]:
    found = tree["surface"]["openings"]
    if not found:
        yield "<p>The surface is closed.</p>"
        return
    rows = [(f"{one['rim']:.1f}", *(f"{c:.1f}" for c in one["middle"])) for one in found]
    unit = tree["unit"]
    yield "<h3>Where it is open</h3>"
    yield table(
        (f"#rim {unit}", f"#middle x {unit}", f"#middle y {unit}", f"#middle z {unit}"), rows
    )


def length_section(tree: Tree) -> Iterator[str]:
    """Control and check lengths apart, and the board."""
    lengths = tree["lengths"]
    yield "<h2>Known lengths</h2>"
    for role, words in (
        ("check", "Check lengths: they did not set the scale, so they test it"),
        ("control", "Control lengths: they set the scale"),
    ):
        rows = [
            (
                one["label"],
                f"{one['known_mm']:.3f}",
                f"{one['measured_mm']:.3f}",
                f"{one['error_mm']:+.4f}",
                f"{100 * one['error']:+.4f}",
                text_of(one["sigma_mm"], ".4f"),
            )
            for one in lengths[role]
        ]
        heads = ("length", "#known mm", "#measured mm", "#error mm", "#error %", "#sigma mm")
        yield f"<h3>{words}</h3>" + (table(heads, rows) if rows else "<p>None.</p>")
    if lengths["tapes"]:
        rows = [
            (
                one["place"],
                f"{one['read_mm']:.1f}",
                *(
                    (one["reason"],)
                    if one["reason"]
                    else (
                        f"{one['measured_mm']:.1f}",
                        f"{one['error_mm']:+.1f}",
                        f"{100 * one['error']:+.1f}",
                        f"{one['sigma_mm']:.1f}",
                    )
                ),
            )
            for one in lengths["tapes"]
        ]
        heads = (
            "girth",
            "#tape mm",
            "#surface mm",
            "#error mm",
            "#error %",
            "#sigma of the tape mm",
        )
        yield "<h3>Taped girths: they owe nothing to the scale</h3>" + table(heads, rows)
    board = lengths["board"]
    if board is not None:
        yield (
            f'<p class="note">{escape(board["board"])}, seen in {board["photos"]} of '
            f"{board['placed_photos']} photos, {text_of(board['corners_per_photo'], '.1f')} of "
            f"{board['corners']} corners on average.</p>"
        )


def image_section(tree: Tree) -> Iterator[str]:
    """Photo by photo."""
    images, unit = tree["images"], tree["unit"]
    yield "<h2>Photos</h2>"
    rows = [
        (
            one["name"],
            "placed" if one["placed"] else "not placed",
            f"{one['points']:,}",
            text_of(one["edge_width_px"], ".2f"),
            text_of(one["distance"], ",.0f"),
            text_of(one["pixel"], ".3f"),
            " ".join((one["reason"], *one["remarks"])).strip(),
        )
        for one in images["by_photo"]
    ]
    heads = ("photo", "verdict", "#points", "#edge width px", f"#distance {unit}",
             f"#pixel {unit}", "remarks")  # fmt: skip
    yield table(heads, rows, [not one["placed"] for one in images["by_photo"]])


def glossary_section(tree: Tree) -> Iterator[str]:
    """Every figure with unit and definition."""
    yield "<h2>Every figure, its unit and what it is</h2>"
    rows = [(one.title, one.value, one.unit, one.definition) for one in term_rows(tree)]
    yield table(("figure", "#value", "unit", "definition"), rows)


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
        *(figure_html(picture) for picture in pictures),
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
