"""Prediction: the surface's sigma before it is measured.

In      a LimbProxy, the photos' views, and what each photo shows of each cell.
Out     a Prediction: for each cell the photos that will measure it and the expected sigma.
Method  `measuring` takes up to six photos a vertex, the most frontal ones; the same rule chooses
        them here, by rays against the proxy. Its sigma is a share of a pixel:

            sigma = 0.067 pixel (pixel / 0.4 mm)^0.13 sqrt(1 + edge^2)
                    (photos / 5)^-0.05 sqrt(1 + 0.5 / spread) (slope / 20)^-0.15
                    sqrt(1 + (gap / 17 px)^2)

        edge    width of the sharpest edges, px: blur is what photos disagree by
        spread  sum of |t_k - t|^2, t_k being how far photo k sees the surface move along itself for
                a millimetre along its normal: without it there is no depth
        slope   root mean square of the grey slope, grey levels a pixel: the paint
        gap     how far the paint's nearest feature point lies, pixels: what lies between dabs is
                bridged, and what no paint holds is not known
        The form follows `measuring` (uncertainty.py): noise by the plate, whose length is counted
        in pixels; lost detail, which grows faster than the pixel. The numbers are a fit to 18
        captures: docs/method/prediction.md. What all vertices share (scale) is added. Where the
        triangles that a mesh may have are larger than the pixels ask for, they take their place.
Fails   never: a cell that fewer than two photos see has no sigma.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.capture.proxy import CoarseSkin, LimbProxy
from limbgram.core.geometry.lens import View
from limbgram.core.interval import weighted_quantile
from limbgram.reconstruction.measuring.measurement import GRAZING_DEG
from limbgram.reconstruction.measuring.measurement_pass import (
    MAX_INCIDENCE_DEG,
    MAX_VIEWS,
    measuring_views,
)
from limbgram.reconstruction.measuring.uncertainty import OFFSET_PX
from limbgram.reconstruction.measuring.visibility import (
    best_views,
    incidence_cosine_blocks,
    views_apart,
)
from limbgram.reconstruction.pipeline import EDGE_PX
from limbgram.reconstruction.user_settings import MOST_TRIANGLES

SHARE_OF_PIXEL = 0.067
USUAL_PIXEL_MM, FINE_POWER = 0.4, 0.13
USUAL_PHOTOS, PHOTO_POWER = 5.0, 0.05
LEAST_SPREAD = 0.5
USUAL_SLOPE, SLOPE_POWER = 20.0, 0.15
BRIDGED_PX = 17.0
_FAINTEST_SLOPE = 1.0
_COUNTED = 6.0


@dataclass(frozen=True, kw_only=True)
class Prediction:
    """The predicted measurement of a proxy, by cell."""

    photos: Int64[np.ndarray, " n"]
    """Photos that will measure it, six at most."""
    squarely: Int64[np.ndarray, " n"]
    """Those of them that do not look along it. What no two see so has mostly no depth to begin
    with, and is filled in."""
    pixel_mm: Float64[np.ndarray, " n"]
    """Of its most frontal photo, at full size; NaN where no photo sees it."""
    sigma_mm: Float64[np.ndarray, " n"]
    """Expected standard deviation along the normal; NaN where fewer than two photos see it."""

    def share(self, cells: Bool[np.ndarray, " n"], proxy: LimbProxy) -> float:
        """Share of the limb's area that lies in these cells."""
        area = np.where(proxy.known, proxy.area_mm2, 0.0)
        return float(area[cells].sum() / area.sum())

    def middle_sigma_mm(self, proxy: LimbProxy) -> float:
        """Median sigma over the measured area; NaN where nothing is measured."""
        middle_mm = self.sigma_reached_mm(proxy, 0.5)
        return middle_mm if math.isfinite(middle_mm) else math.nan

    def sigma_reached_mm(self, proxy: LimbProxy, share: float) -> float:
        """Sigma that a share of the measured area reaches; infinite where nothing is measured."""
        measured = proxy.known & np.isfinite(self.sigma_mm)
        if not measured.any():
            return math.inf
        return weighted_quantile(self.sigma_mm[measured], proxy.area_mm2[measured], share)


@dataclass(frozen=True, kw_only=True)
class Showing:
    """How well photos show the cells."""

    pixel_ratio: Float64[np.ndarray, " v"]
    """Pixels of the views' own size that one pixel of the full-size photo is."""
    edge_px: Float64[np.ndarray, " v"]
    """Width of the sharpest edges, full-size pixels."""
    slope: Float64[np.ndarray, "n v"]
    """Root mean square of the grey slope round each cell, grey levels a full-size pixel."""
    relative_sigma: float = 0.0
    """Of the scale."""
    gap_px: Float64[np.ndarray, " n"] | None = None
    """How far the nearest feature point of the paint is, pixels; None: paint is everywhere."""

    @classmethod
    def alike(cls, cells: int, views: int, edge_px: float, slope: float) -> "Showing":
        """All photos show all cells equally well; views are of full size."""
        return cls(
            pixel_ratio=np.ones(views),
            edge_px=np.full(views, edge_px),
            slope=np.full((cells, views), slope),
        )


def incidence_cosines(skin: CoarseSkin, views: Sequence[View]) -> Float64[np.ndarray, "n v"]:
    """Cosine between normal and ray, by place and view; 0 where the place is not shown."""
    return np.concatenate(list(incidence_cosine_blocks(skin.mesh, views, GRAZING_DEG))).astype(
        float
    )


def narrowest_deg(
    proxy: LimbProxy, views: Sequence[View], max_incidence_deg: float
) -> Float64[np.ndarray, " n"]:
    """Least angle between the rays of two photos that show a cell squarely; inf where none do."""
    narrowest = np.full(len(proxy.mesh), np.inf)
    if len(views) < 2:
        return narrowest
    sees = incidence_cosines(proxy, views) >= np.cos(np.radians(max_incidence_deg))
    rays = np.array([one.centre_in_world for one in views]) - proxy.mesh.vertices_mm[:, None]
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    for one, other in combinations(range(len(views)), 2):
        cosine = np.clip((rays[:, one] * rays[:, other]).sum(axis=1), -1.0, 1.0)
        apart = np.where(sees[:, one] & sees[:, other], np.degrees(np.arccos(cosine)), np.inf)
        narrowest = np.minimum(narrowest, apart)
    return narrowest


def measuring_photos(
    cosines: Float64[np.ndarray, "n v"], apart: Bool[np.ndarray, " v"]
) -> Bool[np.ndarray, "n v"]:
    """The photos that will measure each cell, as `measuring` chooses them."""
    kept = np.where(measuring_views(cosines), cosines, 0.0).astype(np.float32)
    best = best_views(kept, MAX_VIEWS, apart)
    chosen = np.zeros(cosines.shape, bool)
    rows, slots = np.nonzero(best >= 0)
    chosen[rows, best[rows, slots]] = True
    return chosen


def predict(
    proxy: LimbProxy,
    views: Sequence[View],
    showing: Showing,
) -> Prediction:
    """Expected sigma and photos of every cell."""
    cells = proxy.mesh.vertices_mm
    if not views:
        nothing = np.full(len(cells), np.nan)
        none = np.zeros(len(cells), int)
        return Prediction(photos=none, squarely=none, pixel_mm=nothing, sigma_mm=nothing)
    cosines = incidence_cosines(proxy, views)
    chosen = measuring_photos(cosines, views_apart(views, cells.mean(0)))
    square = chosen & (cosines >= np.cos(np.radians(MAX_INCIDENCE_DEG)))
    normals = proxy.mesh.vertex_normals()
    count = chosen.sum(axis=1)
    pixels = np.stack([view.pixel_size_at(cells) for view in views], axis=1) * showing.pixel_ratio
    along = np.stack([_tangential_motion(view, cells, normals) for view in views], axis=1)
    least = np.maximum(count, 1)[:, None]
    off = np.where(chosen[..., None], along, 0.0)
    off = np.where(chosen[..., None], along - off.sum(axis=1, keepdims=True) / least[..., None], 0)
    spread = (off**2).sum(axis=(1, 2))
    pixel_mm = np.where(chosen, pixels, np.inf).min(axis=1)
    edge_px = np.where(chosen, showing.edge_px, 0.0).sum(axis=1) / least[:, 0]
    slope2 = np.where(chosen, showing.slope**2, 0.0).sum(axis=1) / least[:, 0]
    coarse = np.maximum(_mesh_pixel_mm(proxy) / pixel_mm, 1.0)
    sigma_mm = vertex_sigma_mm(pixel_mm * coarse, edge_px / coarse, count, spread, np.sqrt(slope2))
    if showing.gap_px is not None:
        sigma_mm = sigma_mm * bridging_factor(showing.gap_px)
    shared2 = (OFFSET_PX * pixel_mm) ** 2
    shared2 = shared2 + (showing.relative_sigma * np.linalg.norm(cells - proxy.middle, axis=1)) ** 2
    measured = count >= 2
    return Prediction(
        photos=count,
        squarely=square.sum(axis=1),
        pixel_mm=np.where(count > 0, pixel_mm, np.nan),
        sigma_mm=np.where(measured, np.sqrt(sigma_mm**2 + shared2), np.nan),
    )


def bridging_factor(gap_px: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, " n"]:
    """Factor on sigma where the nearest paint is a distance away."""
    return np.sqrt(1.0 + (gap_px / BRIDGED_PX) ** 2)


def _mesh_pixel_mm(proxy: LimbProxy) -> float:
    """The pixel size below which the finest allowed mesh does not measure any better."""
    face_mm2 = float(proxy.area_mm2[proxy.known].sum()) / MOST_TRIANGLES
    return math.sqrt(4 / math.sqrt(3) * face_mm2) / EDGE_PX


def vertex_sigma_mm(
    pixel_mm: Float64[np.ndarray, " n"],
    edge_px: Float64[np.ndarray, " n"],
    photos: Int64[np.ndarray, " n"],
    spread: Float64[np.ndarray, " n"],
    slope: Float64[np.ndarray, " n"],
) -> Float64[np.ndarray, " n"]:
    """A vertex's own sigma by the formula in the header, without shared parts."""
    finite_mm = np.where(np.isfinite(pixel_mm), pixel_mm, USUAL_PIXEL_MM)
    sigma = SHARE_OF_PIXEL * finite_mm * (finite_mm / USUAL_PIXEL_MM) ** FINE_POWER
    sigma = sigma * np.sqrt(1 + edge_px**2)
    sigma = sigma * (np.clip(photos, 1, _COUNTED) / USUAL_PHOTOS) ** -PHOTO_POWER
    sigma = sigma * np.sqrt(1 + LEAST_SPREAD / np.maximum(spread, 0.05))
    return sigma * (np.maximum(slope, _FAINTEST_SLOPE) / USUAL_SLOPE) ** -SLOPE_POWER


def _tangential_motion(
    view: View, cells: np.ndarray, normals: np.ndarray
) -> Float64[np.ndarray, "n 3"]:
    """Apparent tangential motion of the surface for a unit along its normal."""
    rays = view.centre_in_world - cells
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    cosine = np.einsum("ni,ni->n", rays, normals)
    return (rays - cosine[:, None] * normals) / np.maximum(cosine, 0.05)[:, None]
