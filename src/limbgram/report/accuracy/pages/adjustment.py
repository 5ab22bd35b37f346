"""Sections of the page on the adjustment: residuals, rays and overlap, cameras."""

from collections.abc import Iterator
from html import escape
from typing import Any

from limbgram.report.accuracy.pages.svg import (
    BLUE,
    GREEN,
    ORANGE,
    Series,
    bars,
    figure,
    histogram,
    matrix,
    vectors,
)
from limbgram.report.accuracy.pages.words import text_of
from limbgram.report.document.html import table

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
