"""Descriptors: nearest neighbours between the descriptors of two photos.

Minimum Euclidean distance with two tests: the best must be clearly nearer than the second best
(Lowe's ratio), and each must be the other's best (mutual). One blocked matrix product a pair gives
the distances; the bests of rows and columns are taken from each block while it is in the cache, so
no matrix of distances is ever stored. As fast as the product alone by OpenBLAS (10,000 x 10,000:
0.3 CPU s), whose threads would compete with ours.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float32, Int32, Int64, UInt8

from limbgram.core.kernels import njit

_COLUMNS = 64
_PART = 16
_FARTHEST = -1.0
"""Product of opposite descriptors."""
_SECTOR_DEG = 20
_SECTORS_BESIDE = 2
"""Sectors on either side that are compared too: directions may be 40 degrees off, or more."""


def comparable(descriptors: UInt8[np.ndarray, "n 128"]) -> Float32[np.ndarray, "n 128"]:
    """Descriptors at unit length: the squared distance of two is 2 - 2 times their product."""
    rows = descriptors.astype(np.float32)
    rows /= np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1.0)
    return rows


@dataclass(frozen=True)
class ScaleBand:
    """Which keypoints are comparable: those whose scale ratio (second to first) is in the band.

    Kept for groups of neighbouring keypoints, not for each.
    """

    first_scale_px: Float32[np.ndarray, " n"]
    """Falling, as in Keypoints."""
    second_scale_px: Float32[np.ndarray, " m"]
    """Falling too."""
    smallest: float
    largest: float

    def rows(self, starts: Int64[np.ndarray, " b"]) -> Int64[np.ndarray, "b 2"]:
        """First and last (exclusive) comparable row for each block of columns."""
        ends = np.minimum(starts + _COLUMNS, len(self.second_scale_px)) - 1
        most = self.second_scale_px[starts] / self.smallest
        least = self.second_scale_px[ends] / self.largest
        falling = -self.first_scale_px
        return np.stack(
            [np.searchsorted(falling, -most, "left"), np.searchsorted(falling, -least, "right")],
            axis=1,
        )

    def among(self, rows: Int64[np.ndarray, " r"], columns: Int64[np.ndarray, " c"]) -> "ScaleBand":
        """The band of some of the keypoints, in their order."""
        return replace(
            self,
            first_scale_px=self.first_scale_px[rows],
            second_scale_px=self.second_scale_px[columns],
        )


@dataclass(frozen=True)
class RotationBand:
    """Which keypoints are comparable: those whose rotation is near that of the pair.

    How few of the true matches that costs: docs/method/speed.md.
    """

    first_angle_deg: Float32[np.ndarray, " n"]
    second_angle_deg: Float32[np.ndarray, " m"]
    pair_deg: float
    """Rotation of the second photo against the first."""

    def groups(self) -> Iterator[tuple[Int64[np.ndarray, " r"], Int64[np.ndarray, " c"]]]:
        """Rows and columns that are compared with each other; every column comes once."""
        count = 360 // _SECTOR_DEG
        first = (self.first_angle_deg // _SECTOR_DEG).astype(np.int64) % count
        upright = np.mod(self.second_angle_deg - self.pair_deg, 360)
        second = (upright // _SECTOR_DEG).astype(np.int64) % count
        for sector in range(count):
            off = (first - sector + _SECTORS_BESIDE) % count
            yield np.flatnonzero(off <= 2 * _SECTORS_BESIDE), np.flatnonzero(second == sector)


def match_descriptors(
    first: Float32[np.ndarray, "n d"],
    second: Float32[np.ndarray, "m d"],
    max_ratio: float,
    band: ScaleBand | None = None,
    turn: RotationBand | None = None,
) -> Int32[np.ndarray, "k 2"]:
    """Indices of mutual best matches that pass the ratio test, in order of the first.

    Args:
        first: descriptors as `comparable` gives them; d is a multiple of 16.
        second: those of the other photo.
        max_ratio: largest accepted ratio of the best to the second best distance.
        band: leaves out keypoints of very different scale.
        turn: leaves out keypoints that turn otherwise.
    """
    if len(first) < 2 or len(second) < 2:
        return np.zeros((0, 2), np.int32)
    nearest = np.full(len(first), -1, np.int64)
    row_bests = np.full((len(first), 2), _FARTHEST, np.float32)
    best_row = np.full(len(second), -1, np.int64)
    everything = [(np.arange(len(first)), np.arange(len(second)))]
    for rows, columns in everything if turn is None else turn.groups():
        starts = np.arange(0, len(columns), _COLUMNS)
        if band is None:
            compared = np.stack([np.zeros_like(starts), np.full_like(starts, len(rows))], axis=1)
        else:
            compared = band.among(rows, columns).rows(starts)
        bests, column, row = row_bests[rows], np.full(len(rows), -1), np.full(len(columns), -1)
        _best_two(first[rows], second[columns], compared, column, bests, row)
        better, met = column >= 0, row >= 0
        row_bests[rows] = bests
        nearest[rows[better]] = columns[column[better]]
        best_row[columns[met]] = rows[row[met]]
    squares = np.maximum(2 - 2 * row_bests, 0)
    clear = squares[:, 0] < max_ratio**2 * squares[:, 1]
    mutual = best_row[nearest] == np.arange(len(first))
    found = np.flatnonzero(clear & mutual & (nearest >= 0))
    return np.stack([found, nearest[found]], axis=1).astype(np.int32)


@njit(cache=True, nogil=True)
def _best_two(
    first: np.ndarray,
    second: np.ndarray,
    rows: np.ndarray,
    nearest: np.ndarray,
    row_bests: np.ndarray,
    best_row: np.ndarray,
) -> None:
    """Two largest products of each row, with the best column; and the best row of each column.

    A block of columns at a time, which stays in the cache, and two rows at a time.
    """
    tile = np.zeros((first.shape[1], _COLUMNS), np.float32)
    upper = np.empty(_COLUMNS, np.float32)
    lower = np.empty(_COLUMNS, np.float32)
    column_bests = np.empty(_COLUMNS, np.float32)
    column_rows = np.empty(_COLUMNS, np.int32)
    for block in range(rows.shape[0]):
        start = block * _COLUMNS
        width = min(_COLUMNS, second.shape[0] - start)
        for j in range(width):
            for k in range(first.shape[1]):
                tile[k, j] = second[start + j, k]
        column_bests[:] = _FARTHEST
        column_rows[:] = -1
        for row in range(rows[block, 0], rows[block, 1], 2):
            next_row = min(row + 1, rows[block, 1] - 1)
            _multiply(first[row], first[next_row], tile, upper, lower)
            _carry_on(upper, width, start, row, nearest, row_bests, column_bests, column_rows)
            if next_row > row:
                _carry_on(
                    lower, width, start, next_row, nearest, row_bests, column_bests, column_rows
                )
        for j in range(width):  # to copy a slice would take 2 s more to compile
            best_row[start + j] = column_rows[j]


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "nsz"})
def _multiply(
    a: np.ndarray, b: np.ndarray, tile: np.ndarray, upper: np.ndarray, lower: np.ndarray
) -> None:
    """Products of two rows with a block of columns; the loop over `j` becomes vectors."""
    upper[:] = 0.0
    lower[:] = 0.0
    for part in range(a.size // _PART):
        for step in range(_PART // 8):  # of constant length: twice as fast
            k = part * _PART + step * 8
            a0, a1, a2, a3, a4, a5, a6, a7 = (
                a[k], a[k + 1], a[k + 2], a[k + 3], a[k + 4], a[k + 5], a[k + 6], a[k + 7],
            )  # fmt: skip
            b0, b1, b2, b3, b4, b5, b6, b7 = (
                b[k], b[k + 1], b[k + 2], b[k + 3], b[k + 4], b[k + 5], b[k + 6], b[k + 7],
            )  # fmt: skip
            for j in range(_COLUMNS):
                t0, t1, t2, t3 = tile[k, j], tile[k + 1, j], tile[k + 2, j], tile[k + 3, j]
                t4, t5, t6 = tile[k + 4, j], tile[k + 5, j], tile[k + 6, j]
                t7 = tile[k + 7, j]
                upper[j] += (a0 * t0 + a1 * t1 + a2 * t2 + a3 * t3) + (
                    a4 * t4 + a5 * t5 + a6 * t6 + a7 * t7
                )
                lower[j] += (b0 * t0 + b1 * t1 + b2 * t2 + b3 * t3) + (
                    b4 * t4 + b5 * t5 + b6 * t6 + b7 * t7
                )


@njit(cache=True, nogil=True, fastmath={"nsz", "nnan", "reassoc"})
def _carry_on(
    products: np.ndarray,
    width: int,
    start: int,
    row: int,
    nearest: np.ndarray,
    row_bests: np.ndarray,
    column_bests: np.ndarray,
    column_rows: np.ndarray,
) -> None:
    """Update the best products of a row and of a block of columns."""
    top = np.float32(_FARTHEST)
    for j in range(_COLUMNS):
        value = products[j]
        top = max(top, value)
        larger = value > column_bests[j]
        column_bests[j] = value if larger else column_bests[j]
        column_rows[j] = row if larger else column_rows[j]
    largest, second = row_bests[row, 0], row_bests[row, 1]
    if top <= second:
        return
    for j in range(width):
        value = products[j]
        if value > second:
            if value > largest:
                second = largest
                largest = value
                nearest[row] = start + j
            else:
                second = value
    row_bests[row, 0] = largest
    row_bests[row, 1] = second
