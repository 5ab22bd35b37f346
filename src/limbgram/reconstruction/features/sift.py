"""SIFT of large pictures in little memory: full size by tiles, large scales on a reduced copy.

OpenCV keeps two float pyramids of the doubled picture, 235 bytes a pixel. Small keypoints depend on
a small part of it: they are found in tiles that overlap by their reach, and come out as from the
whole picture. Large ones are found in the picture reduced to a quarter.
"""

from collections.abc import Sequence
from itertools import pairwise, product
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float32

from limbgram.core.geometry.arrays import GreyImage, Mask

TILE_PX = 800
TILE_MB = 190
"""Working memory for a tile with its overlap."""
_OVERLAP_PX = 48
"""Reach of descriptor and blur of the largest keypoints that are taken from tiles."""
_LAST_TILED_OCTAVE = 0
"""Tiles give the octaves from that of the doubled picture (-1) to this one."""
_REDUCTION = 2 ** (_LAST_TILED_OCTAVE + 2)
"""Reduction of the copy whose doubled picture has the first octave that tiles leave out."""
_ALL_OCTAVES = 99
_MOST_TILE_SHARES = 2.0
"""A tile may hold this many times its share, by area, of the keypoints."""
_ENOUGH_SHARE = 2 / 3
"""Share of the wanted keypoints; with fewer, full tiles get what the others left."""
_MAX_ROUNDS = 3


class OpenCvKeypoints(NamedTuple):
    """Keypoints as OpenCV found them."""

    rows: Float32[np.ndarray, "n 5"]
    """x, y, scale (sigma), angle and strength."""
    descriptors: Float32[np.ndarray, "n 128"]

    def subset(self, chosen: Bool[np.ndarray, " n"]) -> "OpenCvKeypoints":
        return OpenCvKeypoints(self.rows[chosen], self.descriptors[chosen])


class _Tile(NamedTuple):
    """A part of the picture."""

    top: int
    bottom: int
    left: int
    right: int

    @property
    def with_overlap(self) -> tuple[slice, slice]:
        return (
            slice(max(self.top - _OVERLAP_PX, 0), self.bottom + _OVERLAP_PX),
            slice(max(self.left - _OVERLAP_PX, 0), self.right + _OVERLAP_PX),
        )


def sift(picture: GreyImage, mask: Mask | None, contrast: float, most: int) -> OpenCvKeypoints:
    """SIFT keypoints of a picture, no more than about `most`."""
    if picture.size <= (TILE_PX + 2 * _OVERLAP_PX) ** 2:
        return _detect(picture, mask, contrast, most, _ALL_OCTAVES)[0]
    parts = [
        *_small_keypoints(picture, mask, contrast, most),
        _large_keypoints(picture, mask, contrast, most),
    ]
    return OpenCvKeypoints(
        np.concatenate([part.rows for part in parts]),
        np.concatenate([part.descriptors for part in parts]),
    )


def _small_keypoints(
    picture: GreyImage, mask: Mask | None, contrast: float, most: int
) -> list[OpenCvKeypoints]:
    """Small keypoints by tile; if texture fills few tiles, these again with a higher limit."""
    tiles = _tiles(picture.shape)
    shares = [picture[tile.with_overlap].size / picture.size for tile in tiles]
    limits = [int(min(_MOST_TILE_SHARES * share, 1.0) * most) for share in shares]
    found = [_no_keypoints() for _ in tiles]
    pending = list(range(len(tiles)))
    for _ in range(_MAX_ROUNDS):
        full: list[int] = []
        for k in pending:
            found[k], count = _tile_keypoints(picture, mask, contrast, tiles[k], limits[k])
            if limits[k] <= count and limits[k] < most:
                full.append(k)
        spare = most - sum(len(one.rows) for one in found)
        if not full or spare <= (1 - _ENOUGH_SHARE) * most:
            break
        growth = 1 + spare / max(sum(limits[k] for k in full), 1)
        for k in full:
            limits[k] = min(int(growth * limits[k]) + 1, most)
        pending = full
    return found


def _tile_keypoints(
    picture: GreyImage, mask: Mask | None, contrast: float, tile: _Tile, limit: int
) -> tuple[OpenCvKeypoints, int]:
    """Keypoints of the tile, and their number with those of its overlap."""
    part = tile.with_overlap
    found, count = _detect(
        picture[part], None if mask is None else mask[part], contrast, limit, _LAST_TILED_OCTAVE
    )
    found.rows[:, :2] += (part[1].start, part[0].start)
    x, y = found.rows[:, 0], found.rows[:, 1]
    height, width = picture.shape
    own = (x >= tile.left) | (tile.left == 0)
    own &= (y >= tile.top) | (tile.top == 0)
    own &= (x < tile.right) | (tile.right == width)
    own &= (y < tile.bottom) | (tile.bottom == height)
    return found.subset(own), count


def _tiles(shape: Sequence[int]) -> list[_Tile]:
    spans = product(_tile_bounds(shape[0]), _tile_bounds(shape[1]))
    return [_Tile(*rows, *columns) for rows, columns in spans]


def _tile_bounds(length: int) -> list[tuple[int, int]]:
    """Bounds of even parts, which begin where OpenCV's halved pictures have a pixel."""
    count = -(-length // TILE_PX)
    ends = [round(k * length / count / _REDUCTION) * _REDUCTION for k in range(count)] + [length]
    return list(pairwise(ends))


def _large_keypoints(
    picture: GreyImage, mask: Mask | None, contrast: float, most: int
) -> OpenCvKeypoints:
    """Large keypoints, found in the reduced picture."""
    width, height = picture.shape[1] // _REDUCTION, picture.shape[0] // _REDUCTION
    whole = np.s_[: height * _REDUCTION, : width * _REDUCTION]
    if min(width, height) < 1:
        return _no_keypoints()
    small = cv2.resize(picture[whole], (width, height), interpolation=cv2.INTER_AREA)
    middle = _REDUCTION // 2
    found, _ = _detect(
        small.astype(np.uint8, copy=False),
        None if mask is None else mask[whole][middle::_REDUCTION, middle::_REDUCTION],
        contrast,
        most,
        _ALL_OCTAVES,
    )
    found.rows[:, :2] = (found.rows[:, :2] + 0.5) * _REDUCTION - 0.5
    found.rows[:, 2] *= _REDUCTION
    return found


def _detect(
    picture: GreyImage, mask: Mask | None, contrast: float, most: int, last_octave: int
) -> tuple[OpenCvKeypoints, int]:
    """Keypoints up to `last_octave` among the `most` strongest, and the number of all."""
    sift = cv2.SIFT.create(
        nfeatures=max(most, 1), contrastThreshold=contrast, enable_precise_upscale=True
    )
    allowed = None if mask is None else mask.astype(np.uint8) * 255
    keypoints, descriptors = sift.detectAndCompute(np.ascontiguousarray(picture), allowed)
    if not keypoints:
        return _no_keypoints(), 0
    rows = np.array([(*k.pt, k.size / 2, k.angle, k.response) for k in keypoints], np.float32)
    octaves = np.array([k.octave for k in keypoints]).astype(np.uint8).view(np.int8)
    return OpenCvKeypoints(rows, descriptors).subset(octaves <= last_octave), len(rows)


def _no_keypoints() -> OpenCvKeypoints:
    return OpenCvKeypoints(np.zeros((0, 5), np.float32), np.zeros((0, 128), np.float32))
