"""Sections of the page below the first screen: charts and tables for those who measure."""

from collections.abc import Iterator
from html import escape
from typing import Any

from limbgram.report.accuracy.pages.svg import (
    BLUE,
    Series,
    bars,
    curve,
    figure,
    histogram,
)
from limbgram.report.accuracy.pages.words import shown_terms, text_of
from limbgram.report.document.html import table

Tree = dict[str, Any]


def against_truth(tree: Tree) -> Iterator[str]:
    """Distances from the truth, girths, and whether sigmas are honest."""
    truth = tree["truth"]
    if truth is None:
        return
    yield f"<h2>Against the truth: {escape(truth['kind'])}</h2>"
    yield f'<p class="note">Alignment: {escape(truth["alignment"])}.</p>'
    distances = truth["histogram"]
    shown = [
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
        shown.append(_honesty(truth["sigma"]))
    yield f'<div class="two">{"".join(shown)}</div>'
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
    shown = [
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
        shown.append(
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
    yield f'<div class="two">{"".join(shown)}</div>'
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
    rows = [(one.title, one.value, one.unit, one.definition) for one in shown_terms(tree)]
    yield table(("figure", "#value", "unit", "definition"), rows)
