"""What the measuring kernels see of the photos: the part round the limb, ready to interpolate.

Crops of all photos lie one after another in one flat array of cubic B-spline coefficients
(Unser 1999), so that a kernel takes two arrays whatever the number and sizes of the crops.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import cv2
import numpy as np
from jaxtyping import Float32, Float64, Int64
from scipy.ndimage import spline_filter

from limbgram.geometry.arrays import FloatImage, Points3
from limbgram.geometry.camera import View
from limbgram.photos.photo import Photo
from limbgram.photos.reading import load_luma
from limbgram.run import in_parallel

_MARGIN_PX = 24
"""Pixels kept round the projected surface: room for windows and for moves."""


Crop = tuple[int, int, np.ndarray]
"""Grey crop of a photo: x0, y0 (multiples of 8), pixels."""


@dataclass(frozen=True, kw_only=True)
class Imagery:
    """Reduced grey crops of several photos.

    A pixel (x, y) of photo k is at ((x + 0.5) * factor - 0.5 - x0, ...) of its crop.
    """

    coefficients: Float32[np.ndarray, " total"]
    """Cubic B-spline coefficients, crop after crop, row after row."""
    crops: Int64[np.ndarray, "k 5"]
    """By photo: start in `coefficients`, x0, y0, width, height (reduced pixels)."""
    factor: float
    views: Float64[np.ndarray, "k 22"]
    """View.packed of every photo, for the full-size photo."""


def load_crops(photos: Sequence[Photo], views: Sequence[View], points_mm: Points3) -> list[Crop]:
    """Full-size grey crop of each photo round `points_mm`."""

    def crop(k: int) -> Crop:
        xy = views[k].project(points_mm)
        xy = xy[views[k].camera.contains(xy)]
        if not len(xy):
            return 0, 0, np.zeros((8, 8), np.uint8)
        luma = load_luma(photos[k])
        x0, y0 = (np.maximum(np.floor(xy.min(0)) - _MARGIN_PX, 0).astype(int) // 8) * 8
        x1, y1 = np.ceil(xy.max(0)).astype(int) + _MARGIN_PX
        return int(x0), int(y0), luma[y0:y1, x0:x1].copy()

    return in_parallel(crop, range(len(views)))


def prepare(crops: Sequence[Crop], views: Sequence[View], halvings: int) -> Imagery:
    """Halve the crops `halvings` times, pixel centres kept, and filter them for interpolation."""
    table = np.zeros((len(crops), 5), np.int64)
    total = sum((p.shape[0] >> halvings) * (p.shape[1] >> halvings) for _, _, p in crops)
    coefficients = np.empty(total, np.float32)
    start = 0
    for k, (x0, y0, pixels) in enumerate(crops):
        reduced = _halved(pixels, halvings)
        height, width = reduced.shape
        place = coefficients[start : start + reduced.size].reshape(height, width)
        _spline_coefficients(reduced, place)
        table[k] = start, x0 >> halvings, y0 >> halvings, width, height
        start += reduced.size
    return Imagery(
        coefficients=coefficients,
        crops=table,
        factor=0.5**halvings,
        views=np.stack([view.packed for view in views]),
    )


def _halved(pixels: np.ndarray, halvings: int) -> FloatImage:
    reduced = pixels.astype(np.float32)
    for _ in range(halvings):
        height, width = (reduced.shape[0] // 2) * 2, (reduced.shape[1] // 2) * 2
        reduced = cv2.resize(
            reduced[:height, :width], (width // 2, height // 2), interpolation=cv2.INTER_AREA
        )
    return reduced


def _spline_coefficients(pixels: FloatImage, result: FloatImage) -> None:
    output = cast(type, result)  # stub: class only
    spline_filter(pixels, order=3, output=output, mode="mirror")
