"""Layouts: which ChArUco layout agrees with the detected markers.

A marker is read without knowing the board, and its number says which white square it lies in, once
the number of columns is known and whether a marker comes first (the pattern of OpenCV before 4.6).
Every such layout is tried: the markers of a photo that one homography takes to their squares agree
with it. How much of its square a marker fills is measured too: where the middles of the markers lie
does not depend on it, so that these map the photo to the board, and sides follow.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.core.geometry.arrays import GreyImage
from limbgram.reconstruction.targets.board import DICTIONARIES, Board

_FEWEST_SIDE, _MOST_COLUMNS = 3, 101
"""Squares of a board that can be used."""
_FEWEST_AGREEING = 3
"""Markers of a photo: two that were misread may agree by chance."""
CORNERS_BY_CHANCE = 4 * (_FEWEST_AGREEING - 1)
"""Inner corners beside so many misread markers. Mirrored, two of 4X4_50 read as each other."""
_SAMPLES = 30
"""Enough where the layout is right: hardly a marker is misread."""
_NEAR_SQUARES = 0.25
"""How far a marker's corner may lie from its place: lenses bend the board by less."""


class MarkersRead(NamedTuple):
    """Markers of one photo, whatever board they are on."""

    numbers: Int64[np.ndarray, " m"]
    corners_px: Float64[np.ndarray, "m 4 2"]
    """Clockwise from the marker's top left."""

    @classmethod
    def of(cls, numbers: object, corners_px: object) -> "MarkersRead":
        """What OpenCV gives, which is None or empty where it reads none."""
        if not isinstance(numbers, np.ndarray) or not numbers.size:
            return cls(np.zeros(0, np.int64), np.zeros((0, 4, 2)))
        return cls(
            numbers.astype(np.int64).ravel(), np.asarray(corners_px, np.float64).reshape(-1, 4, 2)
        )


def read_markers(luma: GreyImage, board: Board) -> MarkersRead:
    """All markers of the board's dictionary."""
    markers = cv2.aruco.getPredefinedDictionary(DICTIONARIES[board.dictionary])
    corners, numbers, _ = cv2.aruco.ArucoDetector(markers).detectMarkers(luma)
    return MarkersRead.of(numbers, corners)


def agreeing_with(read: MarkersRead, board: Board) -> int:
    """Markers that lie as on a board; one alone always does."""
    if not len(read.numbers):
        return 0
    return int(_fits(read, board.columns, _has_marker_first(board), board).sum())


@dataclass(frozen=True)
class Layout:
    """Squares across and down, whether a marker comes first, and how much lies so."""

    columns: int
    rows: int
    """As many as the largest number that was read needs."""
    marker_first: bool
    """In the first square: OpenCV before 4.6 printed boards with an even number of rows so."""
    photos: int
    markers: int
    """In these photos together."""

    def is_of(self, board: Board) -> bool:
        """Whether a board has the markers in the same squares, and all that were read."""
        return (
            self.columns == board.columns
            and self.rows <= board.rows
            and self.marker_first == _has_marker_first(board)
        )


def layout_of(read: Sequence[MarkersRead], given: Board) -> Layout:
    """The layout with which most markers agree; the given board's where as many do."""
    read = [one for one in read if len(one.numbers) >= _FEWEST_AGREEING]
    best = _agreeing(read, given.columns, _has_marker_first(given), given)
    there = len(cv2.aruco.getPredefinedDictionary(DICTIONARIES[given.dictionary]).bytesList)
    most = min(_MOST_COLUMNS, (2 * there + 1) // _FEWEST_SIDE)
    for columns in range(_FEWEST_SIDE, most + 1):
        for marker_first in (False, True):
            found = _agreeing(read, columns, marker_first, given)
            best = found if found.markers > best.markers else best
    return best


def _has_marker_first(board: Board) -> bool:
    return board.legacy and board.rows % 2 == 0


def _agreeing(
    read: Sequence[MarkersRead], columns: int, marker_first: bool, given: Board
) -> Layout:
    photos, markers, rows = 0, 0, _FEWEST_SIDE
    for one in read:
        fits = _fits(one, columns, marker_first, given)
        if fits.sum() >= _FEWEST_AGREEING:
            photos, markers = photos + 1, markers + int(fits.sum())
            largest = one.numbers[fits].max(keepdims=True)
            rows = max(rows, int(_squares(largest, columns, marker_first)[0, 1]) + 1)
    return Layout(columns, rows + rows % 2 * marker_first, marker_first, photos, markers)


def _squares(
    numbers: Int64[np.ndarray, " m"], columns: int, marker_first: bool
) -> Int64[np.ndarray, "m 2"]:
    """Column and row of the squares that markers lie in: white ones, counted row by row."""
    pair, within = np.divmod(numbers, columns)  # two rows have as many markers as columns
    in_first = (columns + marker_first) // 2
    second = within >= in_first
    place = np.where(second, within - in_first, within)
    column = 2 * place + (second == marker_first)
    return np.column_stack([column, 2 * pair + second])


_AROUND = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def _fits(
    read: MarkersRead, columns: int, marker_first: bool, given: Board
) -> Bool[np.ndarray, " m"]:
    """Which markers lie with all their corners where one homography has them."""
    squares = _squares(read.numbers, columns, marker_first)
    around = 0.5 * given.marker_mm / given.square_mm * _AROUND
    places = (squares[:, None] + 0.5 + around).reshape(-1, 2)
    seen = read.corners_px.reshape(-1, 2)
    plane = np.asarray(
        cv2.findHomography(seen, places, cv2.RANSAC, _NEAR_SQUARES, maxIters=_SAMPLES)[0]
    )
    if plane.shape != (3, 3):
        return np.zeros(len(squares), np.bool_)
    there = cv2.perspectiveTransform(seen[None], plane)[0]
    near = np.linalg.norm(there - places, axis=1) < _NEAR_SQUARES
    return np.logical_and.reduce(near.reshape(-1, 4), axis=1)


_FEWEST_FOR_RATIO = 6
"""Markers of a photo that map it to the board,"""
_FEWEST_SAYING = 3
"""and photos that must agree."""
_WITHIN_SHARE, _WITHIN_PX = 0.03, 1.0
"""How far a side may seem from its length: contours run inside what is black, blur and glare eat
into it. Rendered markers of 14 to 63 px come out 1.1 to 1.6 px short."""
_SHORT_PX = 1.3


def other_ratio(read: Sequence[MarkersRead], given: Board) -> float | None:
    """Side of a marker over that of its square, where photos show another one than was given."""
    known = [one for one in (_side(one, given) for one in read) if one is not None]
    if len(known) < _FEWEST_SAYING:
        return None
    ratio = float(np.median([one.squares for one in known]))
    side_px = float(np.median([one.pixels for one in known]))
    stated = given.marker_mm / given.square_mm
    allowed = (_WITHIN_SHARE + _WITHIN_PX / side_px) * max(ratio, stated)
    return ratio if abs(ratio - stated) > allowed else None


class _Side(NamedTuple):
    """Of a typical marker in a photo."""

    squares: float
    pixels: float


def _side(read: MarkersRead, given: Board) -> _Side | None:
    """A marker's usual side in a photo; None where too few markers lie as on the board."""
    squares = _squares(read.numbers, given.columns, _has_marker_first(given)) + 0.5
    if len(squares) < _FEWEST_FOR_RATIO:
        return None
    found = cv2.findHomography(
        _middles(read.corners_px), squares, cv2.RANSAC, _NEAR_SQUARES / 2, maxIters=_SAMPLES
    )
    plane = np.asarray(found[0])
    if plane.shape != (3, 3):
        return None
    kept = np.asarray(found[1]).ravel() > 0
    if kept.sum() < _FEWEST_FOR_RATIO:
        return None
    corners_px = read.corners_px[kept]
    there = cv2.perspectiveTransform(corners_px.reshape(1, -1, 2), plane)[0].reshape(-1, 4, 2)
    pixels, sides = (float(np.median(_sides(one))) for one in (corners_px, there))
    return _Side(sides * (1.0 + _SHORT_PX / pixels), pixels + _SHORT_PX)


def _middles(corners: Float64[np.ndarray, "m 4 2"]) -> Float64[np.ndarray, "m 2"]:
    """Where the diagonals meet: the middle of a square in any perspective."""
    first, second, third, fourth = corners.transpose(1, 0, 2)
    along, across, between = third - first, fourth - second, second - first
    share = _cross(between, across) / _cross(along, across)
    return first + share[:, None] * along


def _cross(
    one: Float64[np.ndarray, "m 2"], other: Float64[np.ndarray, "m 2"]
) -> Float64[np.ndarray, " m"]:
    return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]


def _sides(corners: Float64[np.ndarray, "m 4 2"]) -> Float64[np.ndarray, "m 4"]:
    """Lengths of the four sides of each."""
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
