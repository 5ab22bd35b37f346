"""Quality: is a photo sharp, and is it lit so that its surface can be measured?

Sharpness is the width of the sharpest edges, which depends little on what the photo shows: an
edge blurred by a Gaussian of width s has a steepest slope of contrast / (s sqrt(2 pi)). Motion
blurs one direction only, so edges across it are taken: the worse of four directions counts.
Exposure is the share of pixels at either end of the scale.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from limbgram.geometry.arrays import GreyImage
from limbgram.photos.photo import PhotoSet

_FINE_PX, _COARSE_PX = 1.0, 2.5
_SIDE_PX = 1800
"""Side of the middle part that is looked at."""
_EDGES = 0.05
"""Share of the pixels that slope in one direction, the steepest ones, that count as edges."""
_LEAST_SLOPE = 3.0
"""Luma over two pixels, beyond what noise shows."""
_SHARPEST = 80.0
"""Percentile: parts out of focus before and behind the limb do not count."""
_BINS = 4
_FEWEST_EDGES = 50
_BURNT_LUMA = 252


@dataclass(frozen=True, kw_only=True)
class QualityOptions:
    """When a photo is worth a remark."""

    max_blur_ratio: float = 2.0
    """Edges this many times wider than those of the set's middle photo count as blurred."""
    min_blur_px: float = 1.5
    """Narrower edges never count as blurred."""
    max_burnt: float = 0.3
    """Share of burnt-out pixels."""
    min_brightest: float = 60.0
    """Photos whose brightest hundredth is darker than this luma count as underexposed."""


DEFAULTS = QualityOptions()


@dataclass(frozen=True)
class Remark:
    """What is wrong with a photo that is used all the same."""

    name: str
    text: str


def remarks(photos: PhotoSet, options: QualityOptions = DEFAULTS) -> tuple[Remark, ...]:
    """Photos that are blurred, too bright or too dark, compared with the rest of the set."""
    widths = np.array([photo.sharpness for photo in photos.photos])
    usual_px = float(np.nanmedian(widths)) if np.isfinite(widths).any() else float("nan")
    limit_px = max(options.min_blur_px, options.max_blur_ratio * usual_px)
    found: list[Remark] = []
    for photo in photos.photos:
        if photo.sharpness > limit_px:
            text = (
                f"blurred: edges {photo.sharpness:.1f} px wide, {usual_px:.1f} px in the other "
                "photos. Hold the camera still, or take a shorter exposure"
            )
            found.append(Remark(photo.name, text))
        if photo.burnt > options.max_burnt:
            text = f"overexposed: {photo.burnt:.0%} of it is burnt out"
            found.append(Remark(photo.name, text))
        if photo.brightest < options.min_brightest:
            found.append(Remark(photo.name, "underexposed: nearly everything in it is dark"))
    return tuple(found)


def edge_width_px(luma: GreyImage) -> float:
    """Gaussian sigma, px, of the sharpest edges in the worst of four directions.

    Slopes at two scales t and T over a blurred step compare as sqrt((s^2 + T^2) / (s^2 + t^2)).
    NaN where the photo shows no edges.
    """
    middle = _middle(luma)
    fine_x, fine_y = _slopes(middle, _FINE_PX)
    coarse_x, coarse_y = _slopes(middle, _COARSE_PX)
    coarse = np.hypot(coarse_x, coarse_y)
    seen = coarse > _LEAST_SLOPE
    coarse, turn = coarse[seen], np.arctan2(coarse_y[seen], coarse_x[seen])
    ratio = np.hypot(fine_x[seen], fine_y[seen]) / coarse
    bins = np.round(turn * (_BINS / np.pi)).astype(np.int64) % _BINS
    widths = [_width_px(ratio[bins == index], coarse[bins == index]) for index in range(_BINS)]
    known = [width for width in widths if not np.isnan(width)]
    return max(known, default=float("nan"))


def burnt_share(luma: GreyImage) -> float:
    """Share of pixels at the upper end of the scale."""
    return float(np.mean(luma[::2, ::2] >= _BURNT_LUMA))


def brightest_luma(luma: GreyImage) -> float:
    """Luma that one pixel in a hundred exceeds."""
    return float(np.percentile(luma[::4, ::4], 99))


def _middle(luma: GreyImage) -> GreyImage:
    top, left = (max(0, (side - _SIDE_PX) // 2) for side in luma.shape)
    return luma[top : top + _SIDE_PX, left : left + _SIDE_PX]


def _slopes(luma: GreyImage, scale_px: float) -> tuple[np.ndarray, np.ndarray]:
    """Differences over two pixels, at every other pixel both ways."""
    smooth = cv2.GaussianBlur(luma.astype(np.float32), (0, 0), scale_px)
    across = cv2.Sobel(smooth, cv2.CV_32F, 1, 0, ksize=1)[::2, ::2]
    return across, cv2.Sobel(smooth, cv2.CV_32F, 0, 1, ksize=1)[::2, ::2]


def _width_px(ratios: np.ndarray, slopes: np.ndarray) -> float:
    """Edge width from the slopes at two scales, at the steepest places of one direction."""
    if _EDGES * len(ratios) < _FEWEST_EDGES:
        return float("nan")
    steepest = ratios[slopes >= np.quantile(slopes, 1 - _EDGES)]
    squared = float(np.percentile(steepest, _SHARPEST)) ** 2
    if squared <= 1:
        return float("inf")
    return float(np.sqrt(max(0.0, (_COARSE_PX**2 - squared * _FINE_PX**2) / (squared - 1))))
