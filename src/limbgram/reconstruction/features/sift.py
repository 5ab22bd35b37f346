"""SIFT of large pictures in little memory: full size by tiles, large scales on a reduced copy.

OpenCV keeps two float pyramids of the doubled picture, 235 bytes a pixel. Small keypoints look
at little of it: they are found in tiles that overlap by as much as they reach, and come out as
from the whole picture. Large ones are found in the picture reduced to a quarter.
"""

from collections.abc import Sequence
from itertools import pairwise, product
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float32

from limbgram.core.geometry.arrays import GreyImage, Mask

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
"""A tile may hold this many times its share of the keypoints, by area."""
_ENOUGH = 2 / 3
"""Of the keypoints asked for; with fewer, full tiles get what the others left."""
_ROUNDS = 3


class Found(NamedTuple):
    """Keypoints as OpenCV found them."""

    rows: Float32[np.ndarray, "n 5"]
    """x, y, scale (sigma), angle and strength."""
    descriptors: Float32[np.ndarray, "n 128"]

    def only(self, chosen: Bool[np.ndarray, " n"]) -> "Found":
        return Found(self.rows[chosen], self.descriptors[chosen])


class _Tile(NamedTuple):
    """A part of the picture, and what is looked at for it."""

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


def sift(picture: GreyImage, mask: Mask | None, contrast: float, most: int) -> Found:
    """SIFT keypoints of a picture, about `most` at most."""
    if picture.size <= (TILE_PX + 2 * _OVERLAP_PX) ** 2:
        return _detected(picture, mask, contrast, most, _EVERY)[0]
    parts = [*_small(picture, mask, contrast, most), _large(picture, mask, contrast, most)]
    return Found(
        np.concatenate([part.rows for part in parts]),
        np.concatenate([part.descriptors for part in parts]),
    )


def _small(picture: GreyImage, mask: Mask | None, contrast: float, most: int) -> list[Found]:
    """Tile by tile; where the texture fills few tiles, these once more with a higher limit."""
    tiles = _tiles(picture.shape)
    shares = [picture[tile.with_overlap].size / picture.size for tile in tiles]
    limits = [int(min(_UNEVEN * share, 1.0) * most) for share in shares]
    found = [_nothing() for _ in tiles]
    due = list(range(len(tiles)))
    for _ in range(_ROUNDS):
        full: list[int] = []
        for k in due:
            found[k], count = _in_tile(picture, mask, contrast, tiles[k], limits[k])
            if limits[k] <= count and limits[k] < most:
                full.append(k)
        spare = most - sum(len(one.rows) for one in found)
        if not full or spare <= (1 - _ENOUGH) * most:
            break
        growth = 1 + spare / max(sum(limits[k] for k in full), 1)
        for k in full:
            limits[k] = min(int(growth * limits[k]) + 1, most)
        due = full
    return found


def _in_tile(
    picture: GreyImage, mask: Mask | None, contrast: float, tile: _Tile, limit: int
) -> tuple[Found, int]:
    """The tile's own keypoints, and how many there were with those of its overlap."""
    part = tile.with_overlap
    found, count = _detected(
        picture[part], None if mask is None else mask[part], contrast, limit, _FINE
    )
    found.rows[:, :2] += (part[1].start, part[0].start)
    x, y = found.rows[:, 0], found.rows[:, 1]
    height, width = picture.shape
    here = (x >= tile.left) | (tile.left == 0)
    here &= (y >= tile.top) | (tile.top == 0)
    here &= (x < tile.right) | (tile.right == width)
    here &= (y < tile.bottom) | (tile.bottom == height)
    return found.only(here), count


def _tiles(shape: Sequence[int]) -> list[_Tile]:
    spans = product(_spans(shape[0]), _spans(shape[1]))
    return [_Tile(*rows, *columns) for rows, columns in spans]


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
        return _nothing()
    small = cv2.resize(picture[whole], (width, height), interpolation=cv2.INTER_AREA)
    middle = _REDUCTION // 2
    found, _ = _detected(
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
) -> tuple[Found, int]:
    """Of the `most` strongest keypoints those of octaves up to `highest`; and how many all were."""
    sift = cv2.SIFT.create(
        nfeatures=max(most, 1), contrastThreshold=contrast, enable_precise_upscale=True
    )
    allowed = None if mask is None else mask.astype(np.uint8) * 255
    keypoints, descriptors = sift.detectAndCompute(np.ascontiguousarray(picture), allowed)
    if not keypoints:
        return _nothing(), 0
    rows = np.array([(*k.pt, k.size / 2, k.angle, k.response) for k in keypoints], np.float32)
    octaves = np.array([k.octave for k in keypoints]).astype(np.uint8).view(np.int8)
    return Found(rows, descriptors).only(octaves <= highest), len(rows)


def _nothing() -> Found:
    return Found(np.zeros((0, 5), np.float32), np.zeros((0, 128), np.float32))
