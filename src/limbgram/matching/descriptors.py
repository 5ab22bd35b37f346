"""Descriptors: which keypoint of one photo looks most like which of another.

Minimum Euclidean distance with two tests: the best must be clearly nearer than the second best
(Lowe's ratio), and each must be the other's best (mutual). The distances come as blocks of one
matrix product; the bests of a block's rows and columns are kept, the block is not.
"""

from dataclasses import dataclass

import numba as nb
import numpy as np
from jaxtyping import Float32, Int32, UInt8

_BLOCK_ROWS = 512
_FARTHEST = np.float32(-1.0)
"""Product of opposite descriptors."""


def comparable(descriptors: UInt8[np.ndarray, "n 128"]) -> Float32[np.ndarray, "n 128"]:
    """Descriptors at unit length: the squared distance of two is 2 - 2 times their product."""
    rows = descriptors.astype(np.float32)
    return rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1.0)


@dataclass(frozen=True)
class ScaleBand:
    """Which keypoints are comparable: those whose scale ratio (second to first) is in the band."""

    first_scale_px: Float32[np.ndarray, " n"]
    """Falling, as in Keypoints."""
    second_scale_px: Float32[np.ndarray, " m"]
    smallest: float
    largest: float

    def columns(self, start: int, end: int) -> slice:
        """Keypoints of the second photo comparable with one of rows `start` to `end`."""
        falling = -self.second_scale_px
        biggest = self.first_scale_px[start] * self.largest
        least = self.first_scale_px[end - 1] * self.smallest
        return slice(
            int(np.searchsorted(falling, -biggest, "left")),
            int(np.searchsorted(falling, -least, "right")),
        )


def match_descriptors(
    first: Float32[np.ndarray, "n d"],
    second: Float32[np.ndarray, "m d"],
    max_ratio: float,
    band: ScaleBand | None = None,
) -> Int32[np.ndarray, "k 2"]:
    """Indices of mutual best matches that pass the ratio test, in order of the first.

    Args:
        first: descriptors as `comparable` gives them.
        second: those of the other photo.
        max_ratio: largest accepted ratio of the best to the second best distance.
        band: leaves out blocks of keypoints of very different scale.
    """
    if len(first) < 2 or len(second) < 2:
        return np.zeros((0, 2), np.int32)
    nearest = np.zeros(len(first), np.int32)
    row_bests = np.full((len(first), 2), _FARTHEST, np.float32)
    best_row = np.full(len(second), -1, np.int32)
    column_bests = np.full(len(second), _FARTHEST, np.float32)
    products = np.empty(_BLOCK_ROWS * len(second), np.float32)
    for start in range(0, len(first), _BLOCK_ROWS):
        end = min(start + _BLOCK_ROWS, len(first))
        columns = slice(0, len(second)) if band is None else band.columns(start, end)
        block = second[columns]
        if len(block) < 2:
            continue
        part = products[: (end - start) * len(block)].reshape(end - start, len(block))
        np.matmul(first[start:end], block.T, out=part)
        _row_bests(part, nearest[start:end], row_bests[start:end])
        nearest[start:end] += columns.start
        _column_bests(part, start, best_row[columns], column_bests[columns])
    squares = np.maximum(2 - 2 * row_bests, 0)
    clear = squares[:, 0] < max_ratio**2 * squares[:, 1]
    mutual = best_row[nearest] == np.arange(len(first))
    rows = np.flatnonzero(clear & mutual).astype(np.int32)
    return np.stack([rows, nearest[rows]], axis=1)


@nb.njit(cache=True, nogil=True)
def _row_bests(products: np.ndarray, nearest: np.ndarray, bests: np.ndarray) -> None:
    """Largest and second largest product of each row, and the column of the largest."""
    for row in range(products.shape[0]):
        largest = _FARTHEST
        second = _FARTHEST
        where = 0
        for column in range(products.shape[1]):
            value = products[row, column]
            if value > second:
                if value > largest:
                    second = largest
                    largest = value
                    where = column
                else:
                    second = value
        nearest[row] = where
        bests[row, 0] = largest
        bests[row, 1] = second


@nb.njit(cache=True, nogil=True)
def _column_bests(
    products: np.ndarray, start: int, best_row: np.ndarray, bests: np.ndarray
) -> None:
    """Carry on each column's largest product and its row, counted from `start`."""
    for row in range(products.shape[0]):
        for column in range(products.shape[1]):
            value = products[row, column]
            larger = value > bests[column]
            bests[column] = value if larger else bests[column]
            best_row[column] = start + row if larger else best_row[column]
