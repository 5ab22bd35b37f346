"""Detection: SIFT keypoints of every photo.

In      photos, their masks honoured.
Out     Features: for each photo the strongest keypoints, at most `max_keypoints`, spread over the
        picture.
Method  OpenCV's SIFT from a doubled image (Lowe 2004), with the upscaling that keeps keypoints
        in place; descriptors as RootSIFT (Arandjelovic and Zisserman 2012).
Fails   never: a photo without texture has no keypoints, and matching reports it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Int64, UInt8

from limbgram.core.geometry.arrays import GreyImage, Mask
from limbgram.core.run import in_parallel, worker_count
from limbgram.reconstruction.features.sift import TILE_MB, sift
from limbgram.reconstruction.photos.decoding import in_flight_mb, load_luma
from limbgram.reconstruction.photos.masks import load_mask
from limbgram.reconstruction.photos.photo import Photo, PhotoSet
from limbgram.reconstruction.photos.resizing import downsampled


@dataclass(frozen=True, kw_only=True)
class Keypoints:
    """SIFT keypoints, strongest and largest first.

    `scale_px` is the Gaussian sigma of detection in the photo; `angle_deg` as OpenCV has it
    (clockwise from +x, since y points down). Descriptors are RootSIFT, unit length times 512,
    so a squared distance of bytes is 512^2 times the squared Euclidean distance.
    """

    xy_px: Float32[np.ndarray, "n 2"]
    scale_px: Float32[np.ndarray, " n"]
    angle_deg: Float32[np.ndarray, " n"]
    descriptors: UInt8[np.ndarray, "n 128"]

    def __len__(self) -> int:
        return len(self.xy_px)

    def some(self, keep: Bool[np.ndarray, " n"]) -> "Keypoints":
        """The keypoints that are kept, in their order."""
        return Keypoints(
            xy_px=self.xy_px[keep],
            scale_px=self.scale_px[keep],
            angle_deg=self.angle_deg[keep],
            descriptors=self.descriptors[keep],
        )


@dataclass(frozen=True)
class Features:
    """Keypoints of every photo of a PhotoSet, in its order."""

    keypoints: tuple[Keypoints, ...]


_BYTES_A_PIXEL_IN_FLIGHT = 5
"""Memory for a photo in flight: decoded, reduced, its mask."""
_SPREAD_CELLS = 32
"""Cells along the longer side, over which keypoints are spread."""
_DESCRIBED_SURPLUS = 1.5
"""Keypoints described for each one that is kept, where there are too many."""


_IN_FLIGHT_MB = 600.0
"""Working memory for photos in flight; one photo is always in flight."""


@dataclass(frozen=True, kw_only=True)
class FeatureOptions:
    """How many keypoints to look for, and at what cost."""

    max_keypoints: int = 12_000
    """Most keypoints a photo. Matching a pair costs their square."""
    contrast: float = 0.02
    """SIFT's contrast threshold, as OpenCV counts it (divided by the layers of an octave)."""
    max_megapixels: float = 6.0
    """Larger photos are reduced to this size for detection; correlation sees all their pixels."""


DEFAULTS = FeatureOptions()


def detect(photos: PhotoSet, options: FeatureOptions = DEFAULTS) -> Features:
    """SIFT keypoints of each photo, largest first, in the sensor's pixels."""
    largest = max((p.width_px * p.height_px / 1e6 for p in photos.photos), default=1.0)
    each_mb = TILE_MB + _BYTES_A_PIXEL_IN_FLIGHT * largest
    workers = int(np.clip(_IN_FLIGHT_MB / each_mb, 1, worker_count()))

    def detect_in(photo: Photo) -> Keypoints:
        return find_keypoints(load_luma(photo), load_mask(photo), options)

    found = in_parallel(
        detect_in, photos.photos, workers, each_mb=each_mb + in_flight_mb(photos.photos)
    )
    return Features(tuple(found))


def find_keypoints(
    luma: GreyImage, mask: Mask | None = None, options: FeatureOptions = DEFAULTS
) -> Keypoints:
    """SIFT keypoints of one picture, largest first."""
    factor = float(np.sqrt(options.max_megapixels * 1e6 / luma.size))
    small = downsampled(luma, factor)
    found = sift(
        small,
        _reduced_mask(mask, small.shape),
        options.contrast,
        int(options.max_keypoints * _DESCRIBED_SURPLUS),
    )
    rows, strength = found.rows[:, :4], found.rows[:, 4]
    kept = spread_selection(rows[:, :2], strength, max(small.shape), options.max_keypoints)
    kept = kept[np.lexsort((rows[kept, 1], rows[kept, 0], -rows[kept, 2]))]
    enlarged = _to_full_size(rows[kept], small.shape, luma.shape)
    return _keypoints(enlarged, found.descriptors[kept])


def root_sift(descriptors: Float32[np.ndarray, "n 128"]) -> UInt8[np.ndarray, "n 128"]:
    """Square root of the L1-normalized descriptor, times 512."""
    total = np.maximum(descriptors.sum(axis=1, keepdims=True), 1e-6)
    return np.minimum(np.rint(512 * np.sqrt(descriptors / total)), 255).astype(np.uint8)


def _keypoints(
    rows: Float32[np.ndarray, "n 4"], descriptors: Float32[np.ndarray, "n 128"]
) -> Keypoints:
    columns = np.ascontiguousarray(rows.T)
    return Keypoints(
        xy_px=np.ascontiguousarray(rows[:, :2]),
        scale_px=columns[2],
        angle_deg=columns[3],
        descriptors=root_sift(descriptors),
    )


def _reduced_mask(
    mask: Mask | None, shape: Sequence[int]
) -> Bool[np.ndarray, "rows columns"] | None:
    if mask is None or mask.shape == tuple(shape):
        return mask
    size = (shape[1], shape[0])
    return cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0


def _to_full_size(
    rows: Float32[np.ndarray, "n 4"], small: Sequence[int], full: Sequence[int]
) -> Float32[np.ndarray, "n 4"]:
    """x, y, scale and angle in the full-size picture of keypoints found in the reduced one."""
    if tuple(small) == tuple(full):
        return rows
    enlarged = rows.copy()
    factor_x, factor_y = full[1] / small[1], full[0] / small[0]
    enlarged[:, 0] = (rows[:, 0] + 0.5) * factor_x - 0.5
    enlarged[:, 1] = (rows[:, 1] + 0.5) * factor_y - 0.5
    enlarged[:, 2] *= np.sqrt(factor_x * factor_y)
    return enlarged


def spread_selection(
    xy_px: Float32[np.ndarray, "n 2"],
    strength: Float32[np.ndarray, " n"],
    side_px: int,
    count: int,
) -> Int64[np.ndarray, " k"]:
    """Indices of `count` keypoints: the strongest of each cell, then the second strongest."""
    if len(xy_px) <= count:
        return np.arange(len(xy_px))
    column, row = (xy_px * (_SPREAD_CELLS / side_px)).astype(np.int64).T
    cell = row * (_SPREAD_CELLS + 1) + column
    order = np.lexsort((xy_px[:, 1], xy_px[:, 0], -strength, cell))
    starts = np.flatnonzero(np.diff(cell[order], prepend=-1))
    rank_in_cell = np.arange(len(order)) - np.repeat(starts, np.diff(starts, append=len(order)))
    return order[np.lexsort((-strength[order], rank_in_cell))[:count]]
