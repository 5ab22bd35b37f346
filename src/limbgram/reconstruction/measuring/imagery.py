"""Imagery: B-spline coefficients of the photos' crops round the limb, for the measuring kernels.

Crops of all photos lie one after another in one flat array of cubic B-spline coefficients
(Unser 1999), so that a kernel takes two arrays whatever the number and sizes of the crops. They are
most of the measurement's memory: `imagery_mb` predicts how much.

Blur displaces curved surfaces in matching. A pixel averages its surroundings. On a convex surface
seen at a slant it reaches further towards the contour than away from it: to second order (Taylor
expansion of the surface under a pixel) its mean lies as if the surface were displaced along its
normal by

    1/2 (blur pixel)^2 (H + q(r, r) / cos^2)

H being the sum of the principal curvatures, r the tangential part of the ray, q the curvature along
it and cos the cosine of incidence: rays from both sides meet below a convex surface and above a
hollow. Least-squares matching also follows edges, which blur leaves in place; with simulated paint
it shows a share of the displacement.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, cast

import numpy as np
from jaxtyping import Float32, Float64, Int32, Int64, UInt8, UInt16
from scipy.ndimage import spline_filter

from limbgram.core.geometry.arrays import FloatImage, GreyImage, Points3
from limbgram.core.geometry.lens import View
from limbgram.core.run import in_parallel
from limbgram.reconstruction.photos.decoding import in_flight_mb, load_luma
from limbgram.reconstruction.photos.photo import Photo

_BLUR_PX = 0.45
"""Standard deviation of a pixel's point spread: its own square (0.29) and a third of a pixel of
lens and demosaicing; sharp photos have less, soft ones more."""
_MATCHED_SHARE = 0.5
"""Share of the displacement that matching shows. On a painted ball of 40 mm with pixels of 0.4 mm,
the error without correction was 0.000, -0.002 and -0.012 mm at reaches of 0.29, 0.58 and 1.04 px:
shares of 0, 0.3 and 0.55. Simulated dabs in two photos: 0.4 to 0.6."""
_MIN_COSINE = 0.2
_MAX_LIFT_PX = 0.1
"""Larger displacements belong to folds and outliers, where the expansion does not hold."""


def apparent_lift_mm(
    vertices_mm: Points3,
    axes: Float64[np.ndarray, "n 3 3"],
    quadric: Float64[np.ndarray, "n 3"],
    views: Float64[np.ndarray, "k view"],
    seen_by: Int32[np.ndarray, "n c"],
) -> Float32[np.ndarray, "n c"]:
    """Displacement by blur, along the normal, at which each photo of `seen_by` shows each vertex.

    Args:
        axes: two tangents and the normal of each vertex, rows.
        quadric: curvature (uu, uv, vv) along the tangents, 1/mm; negative where convex.
        views: `View.packed` of each photo.
    """
    lift = np.zeros(seen_by.shape, np.float32)
    for photo, view in enumerate(views):
        at, slot = np.nonzero(seen_by == photo)
        rotation, translation = view[:9].reshape(3, 3), view[9:12]
        rays = -rotation.T @ translation - vertices_mm[at]
        pixel_mm = np.abs(rays @ rotation[2]) / np.sqrt(view[12] * view[13])
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        u, v, cosine = np.einsum("nij,nj->in", axes[at], rays)
        uu, uv, vv = quadric[at].T
        along_ray = uu * u * u + 2 * uv * u * v + vv * v * v
        bend = uu + vv + along_ray / np.maximum(cosine, _MIN_COSINE) ** 2
        moved_mm = _MATCHED_SHARE * 0.5 * (_BLUR_PX * pixel_mm) ** 2 * bend
        lift[at, slot] = np.clip(moved_mm, -_MAX_LIFT_PX * pixel_mm, _MAX_LIFT_PX * pixel_mm)
    return lift


_MARGIN_PX = 24
"""Pixels kept round the projected surface, for windows and moves."""


_HALVING_BYTES = 5.0
"""Bytes per pixel of a photo while its crop is halved."""
_COEFFICIENT_BYTES, _PATCH_BYTES = 4, 1
"""Bytes per pixel of a crop: at its own size, and at a quarter of its pixels for patches."""


@dataclass(frozen=True, kw_only=True)
class Crop:
    """Grey crop of a photo that was halved `halvings` times, pixel centres kept."""

    x0: int
    y0: int
    """Corner of the crop in the reduced photo."""
    pixels: UInt8[np.ndarray, "h w"] | UInt16[np.ndarray, "h w"]
    """Grey levels; in a reduced photo exact sums of 4^halvings pixels."""
    halvings: int = 0


class Imagery(NamedTuple):
    """Grey crops of several photos as B-spline coefficients.

    A pixel (x, y) of photo k is at ((x + 0.5) * factor - 0.5 - x0, ...) of its crop.
    """

    coefficients: Float32[np.ndarray, " total"]
    """Cubic B-spline coefficients, crop after crop, row after row."""
    crops: Int64[np.ndarray, "k 5"]
    """By photo: start in `coefficients`, x0, y0, width, height (reduced pixels)."""
    factor: float
    views: Float64[np.ndarray, "k view"]
    """View.packed of every photo at full size."""


def load_crops(
    photos: Sequence[Photo], views: Sequence[View], points_mm: Points3, halvings: int = 0
) -> list[Crop]:
    """Grey crop of each photo round `points_mm`, halved `halvings` times."""

    def crop(k: int) -> Crop:
        box = _bounding_box(views[k], points_mm, 1 << halvings)
        if box is None:
            return Crop(x0=0, y0=0, pixels=np.zeros((8, 8), np.uint8), halvings=halvings)
        x0, y0, x1, y1 = box
        pixels = load_luma(photos[k])[y0:y1, x0:x1]
        return Crop(
            x0=x0 >> halvings,
            y0=y0 >> halvings,
            pixels=pixels.copy() if halvings == 0 else _block_sums(pixels, halvings),
            halvings=halvings,
        )

    return in_parallel(crop, range(len(views)), each_mb=in_flight_mb(photos, _HALVING_BYTES))


def imagery_mb(views: Sequence[View], points_mm: Points3, halvings: int = 0) -> float:
    """Memory of crops round `points_mm` and their coefficients, MiB."""
    boxes = [_bounding_box(view, points_mm, 1 << halvings) for view in views]
    pixels = sum((x1 - x0) * (y1 - y0) for x0, y0, x1, y1 in filter(None, boxes)) >> 2 * halvings
    crop_bytes = 1 if halvings == 0 else 2
    return pixels * (crop_bytes + _COEFFICIENT_BYTES + _PATCH_BYTES) / 2**20


def _bounding_box(
    view: View, points_mm: Points3, aligned_px: int
) -> tuple[int, int, int, int] | None:
    """Left, top, right and bottom of the points in a photo; None if it shows none."""
    xy = view.project(points_mm)
    xy = xy[view.camera.contains(xy)]
    if not len(xy):
        return None
    x0, y0 = np.maximum(np.floor(xy.min(0)) - _MARGIN_PX, 0).astype(int) // aligned_px * aligned_px
    x1, y1 = np.ceil(xy.max(0)).astype(int) + _MARGIN_PX
    right, bottom = min(int(x1), view.camera.width_px), min(int(y1), view.camera.height_px)
    return int(x0), int(y0), right, bottom


def _block_sums(pixels: GreyImage, halvings: int) -> UInt16[np.ndarray, "rows columns"]:
    """Sums over square blocks of 2^halvings pixels a side; exact up to four halvings."""
    summed = pixels.astype(np.uint16)
    for _ in range(halvings):
        height, width = (summed.shape[0] // 2) * 2, (summed.shape[1] // 2) * 2
        whole = summed[:height, :width]
        summed = whole[::2, ::2] + whole[1::2, ::2] + whole[::2, 1::2] + whole[1::2, 1::2]
    return summed


def build_imagery(crops: Sequence[Crop], views: Sequence[View]) -> Imagery:
    """The crops, filtered for B-spline interpolation."""
    table = np.zeros((len(crops), 5), np.int64)
    coefficients = np.empty(sum(crop.pixels.size for crop in crops), np.float32)
    start = 0
    for k, crop in enumerate(crops):
        height, width = crop.pixels.shape
        place = coefficients[start : start + crop.pixels.size].reshape(height, width)
        _spline_coefficients(crop.pixels * np.float32(0.25**crop.halvings), place)
        table[k] = start, crop.x0, crop.y0, width, height
        start += crop.pixels.size
    return Imagery(
        coefficients=coefficients,
        crops=table,
        factor=0.5 ** (crops[0].halvings if crops else 0),
        views=np.stack([view.packed for view in views]),
    )


def _spline_coefficients(pixels: FloatImage, result: FloatImage) -> None:
    output = cast(type, result)  # stub: class only
    spline_filter(pixels, order=3, output=output, mode="mirror")
