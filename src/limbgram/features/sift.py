"""SIFT of a picture of any size in little memory: tile by tile, and once more much reduced.

OpenCV keeps two float pyramids of the doubled picture, 235 bytes a pixel. Small keypoints look
at little of it: they are found in tiles that overlap by as much as they reach, and come out as
from the whole picture. Large ones are found in the picture reduced to a quarter.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float32

from limbgram.geometry.arrays import GreyImage, Mask

TILE_PX = 800
MEGABYTES = 190
"""Working memory of a tile with its overlap."""
_OVERLAP_PX = 48
"""Reach of descriptor and blur of the largest keypoints that are taken from tiles."""
_FINE = 0
"""Octaves taken from tiles: that of the doubled picture (-1) to this one."""
_REDUCTION = 2 ** (_FINE + 2)
"""Its doubled picture has the first octave that tiles leave out."""
_EVERY = 99
_UNEVEN = 2.0
"""A tile may hold this many times its share of the keypoints."""


class Found(NamedTuple):
    """Keypoints as OpenCV found them."""

    rows: Float32[np.ndarray, "n 5"]
    """x, y, scale (sigma), angle and strength."""
    descriptors: Float32[np.ndarray, "n 128"]

    def only(self, chosen: Bool[np.ndarray, " n"]) -> "Found":
        return Found(self.rows[chosen], self.descriptors[chosen])


def sift(picture: GreyImage, mask: Mask | None, contrast: float, most: int) -> Found:
    """SIFT keypoints of a picture, about `most` at most."""
    parts = [*_small(picture, mask, contrast, most), _large(picture, mask, contrast, most)]
    return Found(
        np.concatenate([part.rows for part in parts]),
        np.concatenate([part.descriptors for part in parts]),
    )


def _small(picture: GreyImage, mask: Mask | None, contrast: float, most: int) -> Iterator[Found]:
    """Tile by tile."""
    height, width = picture.shape
    for top, bottom in _spans(height):
        for left, right in _spans(width):
            y0, x0 = max(top - _OVERLAP_PX, 0), max(left - _OVERLAP_PX, 0)
            part = np.s_[y0 : bottom + _OVERLAP_PX, x0 : right + _OVERLAP_PX]
            share = picture[part].size / picture.size
            found = _detected(
                picture[part],
                None if mask is None else mask[part],
                contrast,
                int(min(_UNEVEN * share, 1.0) * most),
                _FINE,
            )
            found.rows[:, :2] += (x0, y0)
            x, y = found.rows[:, 0], found.rows[:, 1]
            here = (x >= left) | (left == 0)
            here &= (y >= top) | (top == 0)
            here &= (x < right) | (right == width)
            here &= (y < bottom) | (bottom == height)
            yield found.only(here)


def _spans(length: int) -> list[tuple[int, int]]:
    """Even parts; they begin where OpenCV's halved pictures have a pixel."""
    count = -(-length // TILE_PX)
    ends = [round(k * length / count / _REDUCTION) * _REDUCTION for k in range(count)] + [length]
    return list(pairwise(ends))


def _large(picture: GreyImage, mask: Mask | None, contrast: float, most: int) -> Found:
    """In the reduced picture, pixel centres kept right."""
    width, height = picture.shape[1] // _REDUCTION, picture.shape[0] // _REDUCTION
    whole = np.s_[: height * _REDUCTION, : width * _REDUCTION]
    if min(width, height) < 1:
        return Found(np.zeros((0, 5), np.float32), np.zeros((0, 128), np.float32))
    small = cv2.resize(picture[whole], (width, height), interpolation=cv2.INTER_AREA)
    middle = _REDUCTION // 2
    found = _detected(
        small.astype(np.uint8, copy=False),
        None if mask is None else mask[whole][middle::_REDUCTION, middle::_REDUCTION],
        contrast,
        most,
        _EVERY,
    )
    found.rows[:, :2] = (found.rows[:, :2] + 0.5) * _REDUCTION - 0.5
    found.rows[:, 2] *= _REDUCTION
    return found


def _detected(
    picture: GreyImage, mask: Mask | None, contrast: float, most: int, highest: int
) -> Found:
    """The `most` strongest keypoints of octaves up to `highest`."""
    sift = cv2.SIFT.create(
        nfeatures=max(most, 1), contrastThreshold=contrast, enable_precise_upscale=True
    )
    allowed = None if mask is None else mask.astype(np.uint8) * 255
    keypoints, descriptors = sift.detectAndCompute(np.ascontiguousarray(picture), allowed)
    if not keypoints:
        return Found(np.zeros((0, 5), np.float32), np.zeros((0, 128), np.float32))
    rows = np.array([(*k.pt, k.size / 2, k.angle, k.response) for k in keypoints], np.float32)
    octaves = np.array([k.octave for k in keypoints]).astype(np.uint8).view(np.int8)
    return Found(rows, descriptors).only(octaves <= highest)
