"""The PDF: two pages to file or print, the first for everybody, the second for those who measure.

In      the tree of an assessment, and pictures of the surface (PNG).
Out     the bytes of a PDF (A4).
"""

import io
import textwrap
from collections.abc import Sequence
from typing import Any

import matplotlib.image as mpimg
import numpy as np
from jaxtyping import Float64
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patches import Rectangle
from matplotlib.transforms import Bbox

from limbgram.report.accuracy.page import MEANING, cards
from limbgram.report.accuracy.svg import SURE_SIGMAS
from limbgram.report.document.paper import PAGE_IN, RULE, pdf_of
from limbgram.report.drawings.drawing import BLUE, FAINT, GREEN, INK, ORANGE, RED, Picture, plain

_LIGHTS = {"green": GREEN, "amber": "#a8690a", "red": RED}
_WRAP = 104
_CRITERIA_HIGHEST = 0.225
"""What is left for the table of criteria above the foot of the page."""
_SHOWN_FINDINGS = 6
_HEADLINE, _HEADLINE_PAD, _HEADLINE_TOP = 0.0155, 0.010, 0.942
"""Height of a line of the verdict, room round them, top of its box, as shares of the page."""

Tree = dict[str, Any]


def accuracy_pdf(tree: Tree, pictures: Sequence[Picture]) -> bytes:
    """The assessment as a PDF of two pages."""
    return pdf_of((_first(tree, pictures), _second(tree)))


def _first(tree: Tree, pictures: Sequence[Picture]) -> Figure:
    figure = Figure(figsize=PAGE_IN, facecolor="white")
    below = _banner(figure, tree)
    for idx, card in enumerate(cards(tree)):
        x = 0.07 + 0.225 * idx
        figure.text(
            x, below - 0.025, textwrap.fill(card.question, 24), fontsize=7.5, color=FAINT, va="top"
        )
        figure.text(x, below - 0.070, card.answer, fontsize=14, weight="bold", color=INK)
        figure.text(
            x, below - 0.077, textwrap.fill(card.note, 32), fontsize=6.5, color=FAINT, va="top"
        )
    figure.text(0.07, below - 0.115, textwrap.fill(MEANING, 130), fontsize=7, color=FAINT, va="top")
    y = _findings(figure, tree["findings"], below - 0.148)
    if pictures:
        image = mpimg.imread(io.BytesIO(pictures[0].png.tobytes()))
        axes = figure.add_axes((0.07, 0.30, 0.86, max(y - 0.33, 0.1)))
        axes.imshow(image, interpolation="antialiased")
        axes.set_axis_off()
        figure.text(0.07, y - 0.026, pictures[0].title, fontsize=10, weight="bold", color=INK)
    _criteria(figure, tree["criteria"])
    figure.text(0.07, 0.03, textwrap.fill(tree["intended_use"], 140), fontsize=6.5, color=FAINT)
    return figure


def _banner(figure: Figure, tree: Tree) -> float:
    """The verdict in a box as high as its words; returns where the box ends."""
    colour = _LIGHTS[tree["light"]]
    word = tree["light"].upper()
    reason = tree["headline"].removeprefix(word).lstrip(": ")
    lines = textwrap.wrap(reason, 84)[:4]
    height = _HEADLINE * max(len(lines), 1) + 2 * _HEADLINE_PAD
    below = _HEADLINE_TOP - height
    middle = below + height / 2
    figure.text(0.07, 0.955, f"How accurate is {tree['case']}?", fontsize=13, weight="bold",
                color=INK)  # fmt: skip
    figure.add_artist(Rectangle((0.07, below), 0.86, height, color=colour, alpha=0.10, lw=0))
    figure.add_artist(Rectangle((0.07, below), 0.008, height, color=colour, lw=0))
    figure.text(0.095, middle, word, fontsize=12, weight="bold", color=colour, va="center")
    figure.text(0.20, middle, "\n".join(lines), fontsize=9.5, color=INK, va="center")
    return below


def _findings(figure: Figure, found: Sequence[dict[str, str]], top: float) -> float:
    """What limits the result; returns where the next thing may begin."""
    figure.text(0.07, top, "What limits this result, and what to do", fontsize=10, weight="bold",
                color=INK, va="top")  # fmt: skip
    y = top - 0.022
    for idx, one in enumerate(found[:_SHOWN_FINDINGS]):
        what = textwrap.wrap(f"{idx + 1}. {one['what']}", _WRAP)
        remedy = textwrap.wrap(f"→ {one['remedy']}", _WRAP)
        weight = "bold" if one["gravity"] == "serious" else "normal"
        figure.text(0.07, y, "\n".join(what), fontsize=8, color=INK, weight=weight, va="top")
        y -= 0.0125 * len(what)
        figure.text(0.085, y, "\n".join(remedy), fontsize=8, color=FAINT, va="top")
        y -= 0.0125 * len(remedy) + 0.005
    if len(found) > _SHOWN_FINDINGS:
        more = f"and {len(found) - _SHOWN_FINDINGS} more on the page"
        figure.text(0.07, y, more, fontsize=8, color=FAINT, va="top")
        y -= 0.018
    return y


def _criteria(figure: Figure, judged: Sequence[dict[str, Any]]) -> None:
    height = min(0.0165 * (len(judged) + 1), _CRITERIA_HIGHEST)
    axes = figure.add_axes((0.07, 0.28 - height, 0.86, height))
    axes.set_axis_off()
    rows = [
        (
            one["title"],
            "not known" if one["value"] is None else f"{one['value']:.3g} {one['unit']}",
            f"{one['green']:g} {one['unit']}",
            "never" if one["red"] is None else f"{one['red']:g} {one['unit']}",
            one["light"],
        )
        for one in judged
    ]
    cells = axes.table(
        rows,
        colLabels=("Figure", "Found", "Green up to", "Red beyond", "Light"),
        colWidths=(0.46, 0.16, 0.14, 0.14, 0.10),
        cellLoc="left",
        colLoc="left",
        bbox=Bbox.unit(),
        edges="horizontal",
    )
    cells.auto_set_font_size(False)
    cells.set_fontsize(7.5)
    for (row, column), cell in cells.get_celld().items():
        cell.PAD = 0.01
        cell.set_edgecolor(RULE)
        if row == 0:
            cell.set_text_props(weight="bold")
        elif column == 4:
            cell.set_text_props(color=_LIGHTS[judged[row - 1]["light"]], weight="bold")


def _second(tree: Tree) -> Figure:
    figure = Figure(figsize=PAGE_IN, facecolor="white")
    figure.set_layout_engine(ConstrainedLayoutEngine(rect=(0.05, 0.04, 0.9, 0.93), hspace=0.06))
    figure.suptitle(f"{tree['case']}: residuals, network, cameras", fontsize=11, color=INK)
    panels = figure.subplots(4, 2)
    _residuals(plain(panels[0, 0]), tree["residuals"])
    _by_photo(plain(panels[0, 1]), tree["residuals"]["by_photo"])
    _grid(panels[1, 0], tree["residuals"]["by_camera"][0])
    _distribution(plain(panels[1, 1]), tree)
    _steps(plain(panels[2, 0]), tree["network"]["angles"]["edges_deg"],
           tree["network"]["angles"]["points"], "widest intersection angle, degrees")  # fmt: skip
    rays = tree["network"]["rays"]
    edges = [number - 0.5 for number in (*rays["numbers"], rays["numbers"][-1] + 1)]
    _steps(plain(panels[2, 1]), edges, rays["points"], "rays per point (last: or more)")
    _lens(panels[3, 0], tree["cameras"][0])
    _key_figures(panels[3, 1], tree)
    return figure


def _steps(axes: Axes, edges: Sequence[float], values: Sequence[float], label: str) -> None:
    axes.stairs(values, edges, fill=True, color=BLUE, alpha=0.75)
    axes.set_xlabel(label, fontsize=7.5)
    axes.set_ylabel("number", fontsize=7, color=FAINT)


def _residuals(axes: Axes, found: Tree) -> None:
    bins = found["histogram"]
    for name, colour in (("x", BLUE), ("y", ORANGE)):
        axes.stairs(bins[name], bins["edges_px"], color=colour, label=name)
    axes.legend(fontsize=7, frameon=False)
    axes.set_xlabel("residual, px", fontsize=7.5)
    axes.set_title(f"RMS of one coordinate {found['rms_px']:.4f} px", fontsize=8)


def _by_photo(axes: Axes, photos: Sequence[Tree]) -> None:
    axes.bar(range(len(photos)), [one["rms_px"] or 0.0 for one in photos], color=BLUE)
    names = [one["name"].rsplit(".", 1)[0] for one in photos]
    axes.set_xticks(range(len(photos)), names, rotation=90, fontsize=min(6.0, 150 / len(photos)))
    axes.set_ylabel("RMS, px", fontsize=7.5)
    axes.set_title("By photo", fontsize=8)


def _grid(axes: Axes, camera: Tree) -> None:
    grid = camera["grid"]
    shape = grid["rows"], grid["columns"]
    mean = [np.array(grid[name], float).reshape(shape) for name in ("mean_x_px", "mean_y_px")]
    x: Float64[np.ndarray, " c"] = (np.arange(shape[1]) + 0.5) * grid["width_px"] / shape[1] - 0.5
    y: Float64[np.ndarray, " r"] = (np.arange(shape[0]) + 0.5) * grid["height_px"] / shape[0] - 0.5
    seen = np.array(grid["observations"], float).reshape(shape)
    rms = np.array(grid["rms_px"], float).reshape(shape)
    size = np.hypot(*mean)
    sure = size > SURE_SIGMAS * rms / np.sqrt(np.maximum(seen, 1))
    longest = float(np.nanmax(size)) if np.isfinite(size).any() else 1e-9
    stretch = 0.8 * grid["width_px"] / shape[1] / max(longest, 1e-9)
    for chosen, strength in ((sure, 1.0), (~sure, 0.3)):
        rows, columns = np.nonzero(chosen & np.isfinite(size))
        axes.quiver(
            x[columns], y[rows], mean[0][rows, columns], mean[1][rows, columns],
            angles="xy", scale_units="xy", scale=1 / stretch, color=BLUE, width=0.004,
            alpha=strength,
        )  # fmt: skip
    axes.set_xlabel(f"longest arrow {longest:.4f} px; faint: may be none", fontsize=7)
    axes.set_xlim(-0.5, grid["width_px"] - 0.5)
    axes.set_ylim(grid["height_px"] - 0.5, -0.5)
    axes.set_aspect("equal")
    axes.tick_params(colors=FAINT, labelsize=6)
    systematic = camera["systematic_px"]
    said = "not known" if systematic is None else f"{systematic:.4f} px"
    axes.set_title(f"Mean residual by place; systematic {said}", fontsize=8, loc="left")


def _distribution(axes: Axes, tree: Tree) -> None:
    """Distances from the truth where there is one, else the vertex sigmas, else the budget."""
    truth, sigma = tree["truth"], tree["surface"]["sigma"]
    if truth is not None:
        bins = truth["histogram"]
        _steps(axes, bins["edges_mm"], bins["vertices"], "signed distance from the truth, mm")
        axes.set_title(f"RMS {truth['rms_mm']:.4f} mm, mean {truth['mean_mm']:+.4f}", fontsize=8)
    elif sigma is not None:
        share = [100 * one for one in sigma["area_share"]]
        _steps(axes, sigma["edges_mm"], share, f"sigma along the normal, {tree['unit']}")
        axes.set_ylabel("% of the area", fontsize=7, color=FAINT)
        axes.set_title(f"Sigma: median {sigma['median_mm']:.3g} {tree['unit']}", fontsize=8)
    else:
        parts = [one for one in tree["expected"]["budget"] if one["sigma_mm"] is not None]
        axes.barh([one["part"] for one in parts], [one["sigma_mm"] for one in parts], color=BLUE)
        axes.set_xlabel(f"sigma, {tree['unit']}", fontsize=7.5)
        axes.set_title("Parts of the expected error", fontsize=8)


def _lens(axes: Axes, lens: Tree) -> None:
    axes.set_axis_off()
    tied = lens["correlations"]
    if tied is None:
        axes.text(0, 0.5, "The scene keeps no covariance of the lens.", fontsize=7.5)
        return
    matrix = np.array(tied["matrix"], float)
    axes.imshow(matrix, cmap="RdBu", vmin=-1, vmax=1)
    for (row, column), value in np.ndenumerate(matrix):
        if column <= row:
            ink = "white" if abs(value) > 0.6 else INK
            axes.text(column, row, f"{value:.2f}", ha="center", va="center", fontsize=5.5,
                      color=ink)  # fmt: skip
    for idx, name in enumerate(tied["order"]):
        axes.text(-0.7, idx, name, ha="right", va="center", fontsize=7)
    axes.set_title("Correlations of the lens parameters", fontsize=8)


def _key_figures(axes: Axes, tree: Tree) -> None:
    axes.set_axis_off()
    network, residuals = tree["network"], tree["residuals"]
    lines = [
        f"{network['points']:,} points, {network['observations']:,} image points",
        f"redundancy {network['redundancy']:,}, mean {network['redundancy_share']:.2f}",
        f"sigma0 {network['sigma0_px'] or 0:.4f} px, "
        f"robust {network['sigma0_robust_px'] or 0:.4f} px",
        f"beyond three sigmas {residuals['beyond_3_sigma_share'] or 0:.2%} (Gaussian 0.27 %)",
        f"rays {network['rays']['mean']:.2f} a point; {network['rays']['two_share']:.0%} with two",
        "",
        *(
            f"{one['name']:>5} {one['value']:.7g}"
            + ("  held" if one["held"] else f"  sigma {one['sigma']:.2g}" if one["sigma"] else "")
            for one in tree["cameras"][0]["parameters"]
        ),
    ]
    axes.text(0, 1, "\n".join(lines), fontsize=7, family="monospace", va="top", color=INK)
