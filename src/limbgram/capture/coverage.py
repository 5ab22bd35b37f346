"""Coverage: what the photos that count show of the limb, by cells of its proxy and by regions.

In      the limb's proxy and points, the photos that count with their slopes, or a Prediction.
Out     Shown, with the Coverage that people are told.
Fails   never: a cell that no photo shows has no sigma.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.capture.answer import CheckedPhoto, Coverage, CoveredRegion
from limbgram.capture.closed_surface import (
    Underside,
    camera_directions,
    closed_surface,
    find_underside,
)
from limbgram.capture.criteria import LEAST_PHOTOS, WIDEST_PAIR_DEG
from limbgram.capture.limb_in_photos import InspectedPhoto
from limbgram.capture.prediction import Prediction, Showing, narrowest_deg, predict
from limbgram.capture.proxy import COLUMNS, LimbProxy, gaps_mm, proxy_of
from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import View
from limbgram.core.interval import COVER
from limbgram.findings import Finding, note
from limbgram.reconstruction.measuring.measurement_pass import MAX_INCIDENCE_DEG
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene

_BARE_PX = 24.0
"""Pixels of the small copies to the nearest feature point beyond which paint is missing: measured
surfaces are 1.7 times less sure there than where paint is dense."""
_BARE_SHARE = 0.25
"""Of a region that lies so far from paint: less is a gap between dabs."""
_THIRDS = ("lower", "middle", "upper")
_HOURS = 2
"""Hours of the clock that a region is wide."""


@dataclass(frozen=True)
class CheckedScene:
    """The scene and findings from which an answer is made."""

    photos: PhotoSet
    small: PhotoSet
    metric: MetricScene
    limb_idx: Int64[np.ndarray, " n"]
    """Points of the scene."""
    looked_at: Sequence[InspectedPhoto]
    found: bool
    """Whether these points are the limb; otherwise they are all there are."""

    @property
    def limb(self) -> Points3:
        return self.metric.scene.points_in_world[self.limb_idx]


@dataclass(frozen=True)
class ShownProxy:
    """The limb's proxy, with what the photos that count show of it."""

    proxy: LimbProxy
    prediction: Prediction
    coverage: Coverage
    thin: float
    """Share of the limb of which no two photos stand near enough to each other to find depth."""
    underside: Underside | None
    """None where the points enclose nothing."""
    bare: tuple[Finding, ...] = ()
    """Regions in which paint is missing."""


def show_proxy(seen: CheckedScene, checked: Sequence[CheckedPhoto]) -> ShownProxy:
    """The proxy with photos and expected sigma of every cell, by the photos that count."""
    scene, small, looked_at = seen.metric.scene, seen.small, seen.looked_at
    proxy = proxy_of(seen.limb, scene.view(scene.placed[0]).centre_in_world)
    counted = [idx for idx, one in enumerate(checked) if one.counts]
    views = [scene.view(idx) for idx in counted]
    ratio = np.array(
        [small.photos[idx].width_px / looked_at[idx].photo.width_px for idx in counted]
    )
    slopes = [
        np.zeros(len(proxy.mesh)) if own is None else own.at(_full_size_px(view, proxy, by))
        for view, by, own in zip(views, ratio, (looked_at[idx].slopes for idx in counted))
    ]
    # pixels of the small copies, whose feature points these are: large photos find finer ones
    gap_px = gaps_mm(proxy, seen.limb) / _usual_pixel(views, proxy)
    prediction = predict(
        proxy,
        views,
        Showing(
            pixel_ratio=ratio,
            edge_px=np.nan_to_num(np.array([checked[idx].edge_px for idx in counted])),
            slope=np.stack(slopes, axis=1) if slopes else np.zeros((len(proxy.mesh), 0)),
            relative_sigma=float(np.nan_to_num(seen.metric.scale.relative_sigma)),
            gap_px=gap_px,
        ),
    )
    in_mm = seen.metric.scale.unit == "mm"
    bare = tuple(_bare_regions(proxy, prediction, gap_px))
    apart_deg = narrowest_deg(proxy, views, MAX_INCIDENCE_DEG)
    wide = np.isfinite(apart_deg) & (apart_deg > WIDEST_PAIR_DEG)
    coverage = coverage_from_prediction(proxy, prediction, in_mm)
    closed = closed_surface(seen.limb, camera_directions(scene)[seen.limb_idx])
    under = closed and find_underside(closed, proxy.axis, views, LEAST_PHOTOS)
    return ShownProxy(proxy, prediction, coverage, prediction.share(wide, proxy), under, bare)


def _usual_pixel(views: Sequence[View], proxy: LimbProxy) -> float:
    """The usual pixel at the middle of the limb, in units of the scene."""
    sizes = [float(view.pixel_size_at(proxy.middle[None])[0]) for view in views]
    return float(np.median(sizes)) if sizes else math.inf


def _full_size_px(view: View, proxy: LimbProxy, ratio: float) -> Float64[np.ndarray, "n 2"]:
    """Positions of the cells in the full-size photo."""
    return (view.project(proxy.mesh.vertices_mm) + 0.5) / ratio - 0.5


def coverage_from_prediction(proxy: LimbProxy, prediction: Prediction, in_mm: bool) -> Coverage:
    """A prediction as reported: cell by cell, by regions, and in all."""
    sigma_mm = prediction.sigma_mm if in_mm else np.full(len(proxy.mesh), np.nan)
    regions = _regions(proxy, prediction, sigma_mm)
    known = proxy.by_row(proxy.known)
    photos, sigmas = proxy.by_row(prediction.squarely), proxy.by_row(sigma_mm)
    unsure = [one for one in regions if math.isfinite(one.sigma_mm)]
    weakest = max(unsure, key=lambda one: one.sigma_mm, default=None)
    return Coverage(
        rows=proxy.rows,
        side_rows=proxy.side_rows,
        columns=COLUMNS,
        photos=tuple(
            tuple(int(n) if there else None for n, there in zip(row, own))
            for row, own in zip(photos, known)
        ),
        sigma_mm=tuple(
            tuple(float(s) if there and np.isfinite(s) else None for s, there in zip(row, own))
            for row, own in zip(sigmas, known)
        ),
        places=tuple(
            tuple((float(x), float(y), float(z)) for x, y, z in row)
            for row in proxy.mesh.vertices_mm[:-1].reshape(proxy.rows, COLUMNS, 3)
        ),
        length=proxy.length,
        radius=proxy.radius,
        measured=prediction.share(prediction.squarely >= 2, proxy),
        well=prediction.share(prediction.squarely >= 3, proxy),
        sigma_middle_mm=prediction.middle_sigma_mm(proxy) if in_mm else math.nan,
        regions=regions,
        weakest=None
        if weakest is None
        else note(
            "coach.region.weakest", region=weakest.name, expected_mm=COVER * weakest.sigma_mm
        ),
    )


def _regions(
    proxy: LimbProxy, prediction: Prediction, sigma_mm: Float64[np.ndarray, " n"]
) -> tuple[CoveredRegion, ...]:
    """Thirds of the side by quarter hours of a clock, and the end."""
    return tuple(
        _region(title, cells, prediction, sigma_mm) for title, cells in _cells_of_regions(proxy)
    )


def _region(
    name: Finding,
    cells: np.ndarray,
    prediction: Prediction,
    sigma_mm: Float64[np.ndarray, " n"],
) -> CoveredRegion:
    own = sigma_mm[cells]
    measured = np.isfinite(own)
    return CoveredRegion(
        name=name,
        photos=int(np.median(prediction.photos[cells])),
        unseen=float(np.mean(prediction.squarely[cells] < 2)),
        sigma_mm=float(np.median(own[measured])) if measured.any() else math.nan,
    )


def _bare_regions(
    proxy: LimbProxy, prediction: Prediction, gap_px: Float64[np.ndarray, " n"]
) -> list[Finding]:
    """Regions of which much is farther from paint than can be bridged, though photos see it."""
    bare = (gap_px > _BARE_PX) & (prediction.squarely >= 2) & proxy.known
    return [
        note("coach.region.bare", region=title, share=float(bare[cells].mean()))
        for title, cells in _cells_of_regions(proxy)
        if cells.any() and bare[cells].mean() > _BARE_SHARE
    ]


def _cells_of_regions(proxy: LimbProxy) -> list[tuple[Finding, Bool[np.ndarray, " n"]]]:
    """The regions by name, from below upwards, with their cells."""
    row, column = np.divmod(np.arange(len(proxy.mesh)), COLUMNS)
    third = np.minimum(row * len(_THIRDS) // proxy.side_rows, len(_THIRDS) - 1)
    found: list[tuple[Finding, Bool[np.ndarray, " n"]]] = []
    for part, name in enumerate(_THIRDS):
        for hour in range(0, 12, _HOURS):
            middle = -hour * COLUMNS / 12 % COLUMNS
            off = np.abs((column - middle + COLUMNS / 2) % COLUMNS - COLUMNS / 2)
            cells = (row < proxy.side_rows) & (third == part) & (off <= _HOURS * COLUMNS / 24)
            found.append((note("coach.region.side", third=name, hour=hour or 12), cells))
    end = (row >= proxy.side_rows) & proxy.known
    if end.any():
        found.append((note("coach.region.end"), end))
    return found
