"""Charts: residuals, and the accuracy that the image scale lets one expect.

The paper's residual of a match: sqrt((d(x, x^)^2 + d(x', x'^)^2) / 4), d from the point to where
the geometry of the pair puts it.
"""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64

from limbgram.core.interval import rms
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.twoview.pairs import Pairs
from limbgram.report.drawings.drawing import (
    BLUE,
    FAINT,
    GREEN,
    INK,
    ORANGE,
    Drawing,
    as_it_is,
    blank,
    plain,
)
from limbgram.report.image_scale import ImageScale, image_scales

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_BINS = 60


def residual_histograms(pairs: Pairs, metric: MetricScene) -> Drawing:
    """The paper's residual over all matches, and the reprojection after the adjustment."""
    matches = np.concatenate([np.zeros(0), *(pair.residual_px for pair in pairs.verified)])
    residuals = metric.scene.residuals_px()
    reprojection = np.linalg.norm(residuals[np.isfinite(residuals).all(1)], axis=1)
    figure = blank(10, 3.4)
    left, right = (plain(axes) for axes in figure.subplots(1, 2))
    _histogram(left, matches, BLUE, "residual of a match, px (from its pair alone)")
    _histogram(right, reprojection, GREEN, "distance to the reprojected point, px (all photos)")
    return Drawing(
        figure,
        f"Left: the residual error of {len(matches):,} matches against the geometry of their pair; "
        f"root mean square {rms(matches):.3f} px. Right: distance of {len(reprojection):,} image "
        f"points from where the adjusted scene puts them; root mean square "
        f"{rms(reprojection):.3f} px. The largest 0.5 % are not drawn.",
    )


def accuracy_chart(photos: PhotoSet, metric: MetricScene) -> Drawing:
    """Expected accuracy by photo, and the measured errors of the known lengths."""
    unit = metric.scale.unit
    scales = image_scales(photos, metric)
    figure = blank(10, 3.4)
    axes = plain(figure.subplots())
    places = np.arange(len(scales))
    axes.bar(places, [scale.pixel_mm for scale in scales], color="#dfe6eb", label="one pixel")
    axes.bar(places, [scale.error_mm for scale in scales], 0.5, color=BLUE, label="dX = m dx'")
    checks = [length for length in metric.scale.lengths if length.role == "check"]
    if checks:
        worst_mm = max(abs(length.measured_mm - length.known_mm) for length in checks)
        label = f"largest error of {len(checks)} check lengths"
        axes.axhline(worst_mm, color=ORANGE, lw=1.2, label=label)
    axes.set_xticks(places, [as_it_is(scale.name) for scale in scales], rotation=90, fontsize=6)
    axes.set_ylabel(unit if unit == "mm" else "scene units", fontsize=8, color=INK)
    axes.legend(fontsize=8, frameon=False, ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1))
    return Drawing(figure, _accuracy_caption(scales, unit))


def _accuracy_caption(scales: tuple[ImageScale, ...], unit: str) -> str:
    if not scales:
        return "No photo was placed."
    distance, pixel, number, error = np.median(
        [[s.distance_mm, s.pixel_mm, s.scale_number, s.error_mm] for s in scales], axis=0
    )
    named = f" (image scale 1:{number:.0f})" if np.isfinite(number) and unit == "mm" else ""
    unit = unit if unit == "mm" else "scene units"
    return (
        f"At {distance:,.0f} {unit}{named} a pixel is {pixel:.3f} {unit} on the object. An image "
        f"measurement as uncertain as the residuals moves a point by dX = m dx' = {error:.3f} "
        f"{unit}; several photos together do better, a wrong scale does worse: hence the check "
        "lengths."
    )


def _histogram(axes: "Axes", values: Float64[np.ndarray, " n"], colour: str, label: str) -> None:
    if len(values):
        reach = max(float(np.quantile(values, 0.995)), 1e-6)
        axes.hist(values[values <= reach], bins=_BINS, range=(0, reach), color=colour)
        axes.axvline(float(values.mean()), color=INK, lw=1, label=f"mean {values.mean():.3f} px")
        axes.axvline(rms(values), color=ORANGE, lw=1, ls="--", label=f"RMS {rms(values):.3f} px")
        axes.legend(fontsize=8, frameon=False)
    axes.set_xlabel(label, fontsize=8, color=INK)
    axes.set_ylabel("number", fontsize=8, color=FAINT)
