"""Sections of the page below the first screen: charts and tables for those who measure."""

from collections.abc import Iterator
from html import escape
from typing import Any

from limbgram.report.accuracy.pages.svg import (
    BLUE,
    GREEN,
    ORANGE,
    Series,
    bars,
    curve,
    histogram,
    matrix,
    vectors,
)
from limbgram.report.accuracy.pages.words import shown_terms
from limbgram.report.page import table

Tree = dict[str, Any]


def against_truth(tree: Tree) -> Iterator[str]:
    """Distances from the truth, girths, and whether sigmas are honest."""
    truth = tree["truth"]
    if truth is None:
        return
    yield f"<h2>Against the truth: {escape(truth['name'])}</h2>"
    yield f'<p class="note">Alignment: {escape(truth["alignment"])}.</p>'
    distances = truth["histogram"]
    shown = [
        _figure(
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
    return _figure(
        curve(
            [part["sigma_mm"] for part in parts],
            [part["rms_error_mm"] for part in parts],
            ("sigma told, mm", "RMS error found, mm"),
            "Error found against sigma told, in tenths of the vertices",
        ),
        f"Error over sigma: robust spread {sigma['robust_spread']:.2f} (1 is honest), "
        f"{sigma['within_95_share']:.1%} inside the 95 % interval, rank correlation "
        f"{_text(sigma['rank_correlation'], '.2f') or 'not known'}.",
    )


def sigma_section(tree: Tree) -> Iterator[str]:
    """How sure the vertices are, and what the expected error is made of."""
    yield "<h2>Expected error</h2>"
    budget = [one for one in tree["expected"]["budget"] if one["sigma_mm"] is not None]
    shown = [
        _figure(
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
            _figure(
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
                _text(one["sigma_mm"], ".4f"),
            )
            for one in lengths[role]
        ]
        heads = ("length", "#known mm", "#measured mm", "#error mm", "#error %", "#sigma mm")
        yield f"<h3>{words}</h3>" + (table(heads, rows) if rows else "<p>None.</p>")
    board = lengths["board"]
    if board is not None:
        yield (
            f'<p class="note">{escape(board["board"])}, seen in {board["photos"]} of '
            f"{board['placed_photos']} photos, {_text(board['corners_per_photo'], '.1f')} of "
            f"{board['corners']} corners on average.</p>"
        )


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
        + _figure(
            histogram(bins["edges_px"], series, unit, "Histogram of the residuals"),
            f"RMS of one coordinate {_text(found['rms_px'], '.4f')} px; "
            f"{_text(found['beyond_3_sigma_share'], '.2%')} lie beyond three robust sigmas "
            "(Gaussian: 0.27 %).",
        )
        + _figure(
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
        yield _figure(
            vectors(camera["grid"], "Mean residual by place in the picture"),
            "Mean residual of all photos by place in the picture. Arrows that follow a pattern "
            f"mean a lens that is not as calibrated: systematic part "
            f"{_text(camera['systematic_px'], '.4f')} px (one coordinate, chance taken off).",
        )
        rows = [
            (
                f"{zone['from_share']:.0%} to {zone['to_share']:.0%}",
                f"{zone['observations']:,}",
                _text(zone["rms_px"], ".4f"),
                _text(zone["outward_px"], "+.4f"),
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
        + _figure(
            histogram(
                angles["edges_deg"],
                [Series("points", angles["points"], BLUE)],
                "widest intersection angle, degrees",
                "Histogram of intersection angles",
            ),
            f"Median {angles['median_deg']:.0f} degrees; 5 % below {angles['low_deg']:.0f}.",
        )
        + _figure(
            histogram(
                [n - 0.5 for n in (*numbers, numbers[-1] + 1)],
                [Series("points", rays["points"], GREEN)],
                f"rays per point ({numbers[-1]}: or more)",
                "Histogram of rays per point",
            ),
            f"{network['points']:,} points, {rays['mean']:.2f} rays on average, "
            f"{rays['two_share']:.0%} with two; redundancy {network['redundancy']:,} "
            f"(mean redundancy number {network['redundancy_share']:.2f}), sigma0 "
            f"{_text(network['sigma0_px'], '.4f')} px.",
        )
        + "</div>"
    )
    weakest = min(overlap["best_partner"], default=0)
    yield _figure(
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
                "held" if one["held"] else _text(one["sigma"], ".2g"),
                f"{one['calibrated']:.6g}",
                "held" if one["held"] else _text(one["calibrated_sigma"], ".2g"),
                _text(one["moved_sigmas"], "+.2f"),
            )
            for one in lens["parameters"]
        ]
        heads = ("parameter", "unit", "#adjusted", "#sigma", "#calibrated", "#sigma",
                 "#moved, sigmas")  # fmt: skip
        yield table(heads, rows)
        tied = lens["correlations"]
        if tied is not None:
            yield _figure(
                matrix(tied["order"], tied["matrix"], "Correlations", signed=True),
                "Correlations of the adjusted parameters; orange is negative.",
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
            _text(one["edge_width_px"], ".2f"),
            _text(one["distance"], ",.0f"),
            _text(one["pixel"], ".3f"),
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


def _figure(svg: str, caption: str) -> str:
    return f"<figure>{svg}<figcaption>{escape(caption)}</figcaption></figure>"


def _text(value: float | None, form: str) -> str:
    return "" if value is None else format(value, form)


def _finite(value: float | None) -> float:
    return 0.0 if value is None else value
