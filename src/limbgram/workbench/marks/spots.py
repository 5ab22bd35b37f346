"""Spots: round patches of one hue in one photo, with their middles on the surface.

Method  the hues that the paint has are the peaks of the hues' histogram over all photos, by area
        of the surface. Pixels of one hue join to patches; whiskers are cut off. A patch's middle
        and size are measured on the surface, not in the picture: a disc seen obliquely on a
        curved limb keeps its middle.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Float64, Int64, UInt8
from scipy.ndimage import gaussian_filter1d

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.frames import turn_rad
from limbgram.workbench.marks.pixels import ColouredPixels

_BINS = 180
_SMOOTH_BINS = 2.5
_LEAST_SHARE = 5e-4
"""Hues with less of the coloured area than this are not looked at."""
_FAINTEST = 0.5
"""Pixels of less than this share of their hue's usual saturation are its washed-out edge."""
_FEWEST_PX = 9
_SMALLEST_MM, _LARGEST_MM = 4.0, 30.0
_ROUNDEST_STRETCH = 1.6
"""Largest reach from the middle, as a multiple of the radius of a circle of the same area."""
_LEAST_VIVID = 0.85
"""Mean saturation: what is mixed of several paints is less vivid than one plain colour."""
SAME_HUE_RAD = float(np.radians(20))
"""Hues closer than this are one."""
_OWN_HUE = 0.5
"""Pixels further than this share of the tolerance from their patch's mean hue are not of it."""


@dataclass(frozen=True, kw_only=True)
class Spots:
    """Patches of one hue in one photo, those of a mark's size and shape marked as round."""

    middles_mm: Points3
    diameters_mm: Float64[np.ndarray, " n"]
    """Of the circle of the same area."""
    colours: UInt8[np.ndarray, "n 3"]
    pixels_mm: Float64[np.ndarray, " n"]
    """Size of the photo's pixels there, on the surface."""
    photo_idx: Int64[np.ndarray, " n"]
    points_mm: Float64[np.ndarray, "k 3"]
    """Of all pixels of the spots, on the surface."""
    areas_mm2: Float64[np.ndarray, " k"]
    """Of the surface that each of these pixels covers."""
    spot_idx: Int64[np.ndarray, " k"]
    """The spot that each belongs to."""


@dataclass(frozen=True, kw_only=True)
class HueSpots:
    """The spots of one hue in all photos, and their areas."""

    spots: Spots
    inside_mm2: float
    """Area of the round patches."""
    total_mm2: float
    """Area of all patches."""


def hues_of(pixels: Sequence[ColouredPixels]) -> Float64[np.ndarray, " k"]:
    """Hues that stand out in the photos, none like a stronger one."""
    area = np.zeros(_BINS)
    for one in pixels:
        bins = ((one.hue_rad / (2 * np.pi)) % 1.0 * _BINS).astype(np.int64) % _BINS
        area += np.bincount(bins, one.areas_mm2, _BINS)
    total = area.sum()
    area = gaussian_filter1d(area, _SMOOTH_BINS, mode="wrap")
    peaks = np.flatnonzero((area >= np.roll(area, 1)) & (area > np.roll(area, -1)))
    peaks = peaks[area[peaks] * 2 * _SMOOTH_BINS > _LEAST_SHARE * total]
    hues: list[float] = []
    for peak in peaks[np.argsort(-area[peaks], kind="stable")]:
        hue = (peak + 0.5) / _BINS * 2 * np.pi
        if all(abs(turn_rad(hue, known)) >= SAME_HUE_RAD for known in hues):
            hues.append(hue)
    return np.array(hues)


def spots_of(
    pixels: Iterable[ColouredPixels],
    hues: Float64[np.ndarray, " k"],
    looked_for: int,
) -> list[HueSpots]:
    """Round patches of each of the first `looked_for` hues in all photos."""
    parts: list[list[HueSpots]] = [[] for _ in range(looked_for)]
    for photo_idx, one in enumerate(pixels):
        nearest = _nearest_hue(one.hue_rad, hues)
        for hue_idx, of_hue in enumerate(parts):
            seen = _spots_in_photo(one, nearest == hue_idx, photo_idx)
            of_hue += [] if seen is None else [seen]
    return [
        HueSpots(
            spots=_concatenated([part.spots for part in of_hue]),
            inside_mm2=sum(part.inside_mm2 for part in of_hue),
            total_mm2=sum(part.total_mm2 for part in of_hue),
        )
        for of_hue in parts
    ]


def _nearest_hue(
    hue_rad: Float32[np.ndarray, " n"], hues: Float64[np.ndarray, " k"]
) -> Int64[np.ndarray, " n"]:
    """Index of the hue that each pixel is nearest to; -1 where none is near."""
    nearest = np.full(len(hue_rad), -1)
    least = np.full(len(hue_rad), SAME_HUE_RAD)
    for idx, hue in enumerate(hues.tolist()):
        turn = np.abs(turn_rad(hue_rad, hue))
        nearest[turn < least] = idx
        least = np.minimum(least, turn)
    return nearest


def _spots_in_photo(
    one: ColouredPixels,
    own: Bool[np.ndarray, " n"],
    photo_idx: int,
) -> HueSpots | None:
    """Patches of a hue's own pixels in one photo; None where nothing is left of them."""
    if own.sum() < _FEWEST_PX:
        return None
    usual = float(np.quantile(one.saturation[own], 0.75))
    rows = np.flatnonzero(own & (one.saturation >= _FAINTEST * usual))
    labels = _labels(one, rows)
    rows, labels = rows[labels > 0], labels[labels > 0] - 1
    plain = _near_own_hue(one.hue_rad[rows], labels, _OWN_HUE * SAME_HUE_RAD)
    if not plain.any():
        return None
    return _measured_spots(one, rows[plain], labels[plain], photo_idx)


def _labels(one: ColouredPixels, rows: Int64[np.ndarray, " k"]) -> Int64[np.ndarray, " k"]:
    """Number of the patch of each pixel, from 1; 0 for whiskers."""
    mask = np.zeros(one.shape, np.uint8)
    mask[one.at[rows, 0], one.at[rows, 1]] = 1
    kernel = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    opened = cv2.morphologyEx(mask, cv2.MORPH_OPEN, kernel)
    labels = cv2.connectedComponents(opened, connectivity=4)[1]
    return labels[one.at[rows, 0], one.at[rows, 1]].astype(np.int64)


def _near_own_hue(
    hue_rad: Float32[np.ndarray, " k"], labels: Int64[np.ndarray, " k"], tolerance_rad: float
) -> Bool[np.ndarray, " k"]:
    """Which pixels have the hue of their patch; those of touching paint have another."""
    sines, cosines = np.bincount(labels, np.sin(hue_rad)), np.bincount(labels, np.cos(hue_rad))
    return np.abs(turn_rad(hue_rad, np.arctan2(sines, cosines)[labels])) < tolerance_rad


def _measured_spots(
    one: ColouredPixels,
    rows: Int64[np.ndarray, " k"],
    labels: Int64[np.ndarray, " k"],
    photo_idx: int,
) -> HueSpots:
    """The round patches among labelled pixels."""
    count = int(labels.max()) + 1
    weights = one.areas_mm2[rows].astype(np.float64)
    points = one.points_mm[rows].astype(np.float64)
    areas = np.bincount(labels, weights, count)
    middles = np.stack([np.bincount(labels, weights * x, count) for x in points.T], 1)
    middles /= np.maximum(areas, 1e-30)[:, None]
    away = np.linalg.norm(points - middles[labels], axis=1) - np.sqrt(weights) / 2
    reach = np.zeros(count)
    np.maximum.at(reach, labels, away)
    diameters = np.sqrt(4 * areas / np.pi)
    vivid = np.bincount(labels, weights * one.saturation[rows], count) / np.maximum(areas, 1e-30)
    pixels = np.bincount(labels, minlength=count)
    passing = (diameters >= _SMALLEST_MM) & (diameters <= _LARGEST_MM)
    passing &= (reach <= _ROUNDEST_STRETCH * diameters / 2) & (pixels >= _FEWEST_PX)
    passing &= vivid >= _LEAST_VIVID
    shades = one.colours[rows].astype(np.float64)
    colours = np.stack([np.bincount(labels, weights * band, count) for band in shades.T], 1)
    colours = np.rint(colours / np.maximum(areas, 1e-30)[:, None]).astype(np.uint8)
    kept = passing[labels]
    spots = Spots(
        middles_mm=middles[passing],
        diameters_mm=diameters[passing],
        colours=colours[passing],
        pixels_mm=np.sqrt(areas[passing] / pixels[passing]),
        photo_idx=np.full(int(passing.sum()), photo_idx),
        points_mm=points[kept],
        areas_mm2=weights[kept],
        spot_idx=(np.cumsum(passing) - 1)[labels[kept]],
    )
    return HueSpots(
        spots=spots, inside_mm2=float(areas[passing].sum()), total_mm2=float(areas.sum())
    )


def _concatenated(parts: Sequence[Spots]) -> Spots:
    before = np.cumsum([0, *(len(part.middles_mm) for part in parts)]).tolist()
    numbered = [part.spot_idx + first for part, first in zip(parts, before, strict=False)]
    return Spots(
        middles_mm=np.concatenate([np.zeros((0, 3)), *(part.middles_mm for part in parts)]),
        diameters_mm=np.concatenate([np.zeros(0), *(part.diameters_mm for part in parts)]),
        colours=np.concatenate([np.zeros((0, 3), np.uint8), *(part.colours for part in parts)]),
        pixels_mm=np.concatenate([np.zeros(0), *(part.pixels_mm for part in parts)]),
        photo_idx=np.concatenate([np.zeros(0, np.int64), *(part.photo_idx for part in parts)]),
        points_mm=np.concatenate([np.zeros((0, 3)), *(part.points_mm for part in parts)]),
        areas_mm2=np.concatenate([np.zeros(0), *(part.areas_mm2 for part in parts)]),
        spot_idx=np.concatenate([np.zeros(0, np.int64), *numbered]),
    )
