"""Layouts: which ChArUco layout agrees with the detected markers.

A marker's id is read without knowing the board. It says which white square the marker fills, once
the number of columns is known and whether a marker comes first (the pattern of OpenCV before 4.6).
Every such layout is tried: markers of a photo that one homography maps to their squares agree with
it. The ratio of a marker's side to its square's is measured too: the markers' middles do not depend
on it, so they give the homography, and with it the length of the sides. Where corners of squares
were found, sides are measured by their edges: ink, glare and a tone curve move the edges of markers
and of black squares alike, and the squares' true side is known.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Float64, Int64

from limbgram.core.geometry.arrays import GreyImage
from limbgram.reconstruction.targets.board import (
    Board,
    PhotoCorners,
    code_count,
    marker_dictionary,
)
from limbgram.reconstruction.targets.edges import Code, fit_square, linear_light

_FEWEST_SQUARES, _MOST_COLUMNS = 3, 101
"""Squares along a side of a board."""
_FEWEST_AGREEING = 3
"""Markers of a photo that say something about a layout: two misread ones may agree by chance."""
MOST_CORNERS_BY_CHANCE = 4 * (_FEWEST_AGREEING - 1)
"""Inner corners next to so few misread markers. Mirrored, two of 4X4_50 read as each other."""
_RANSAC_ITERATIONS = 30
"""Enough for the right layout, in which hardly any marker is misread."""
_TOLERANCE_SQUARES = 0.25
"""Distance that a marker's corner may have from its place: lens distortion is less."""


class DetectedMarkers(NamedTuple):
    """Markers that were read in one photo, of whatever board."""

    ids: Int64[np.ndarray, " m"]
    corners_px: Float64[np.ndarray, "m 4 2"]
    """Clockwise from the marker's top left."""

    @classmethod
    def from_opencv(cls, ids: object, corners_px: object) -> "DetectedMarkers":
        """OpenCV's ids and corners, which are None or empty where it reads none."""
        if not isinstance(ids, np.ndarray) or not ids.size:
            return cls(np.zeros(0, np.int64), np.zeros((0, 4, 2)))
        return cls(
            ids.astype(np.int64).ravel(), np.asarray(corners_px, np.float64).reshape(-1, 4, 2)
        )


def detect_markers(luma: GreyImage, board: Board) -> DetectedMarkers:
    """Markers of the board's dictionary in a photo, by OpenCV."""
    markers = marker_dictionary(board.dictionary)
    corners, ids, _ = cv2.aruco.ArucoDetector(markers).detectMarkers(luma)
    return DetectedMarkers.from_opencv(ids, corners)


def count_in_place(read: DetectedMarkers, board: Board) -> int:
    """Number of markers that lie as on the board; one alone always does."""
    if not len(read.ids):
        return 0
    return int(_in_place(read, board.columns, board.marker_first, board).sum())


@dataclass(frozen=True)
class Layout:
    """A layout of markers on a board, and the photos and markers that agree with it."""

    columns: int
    rows: int
    """As many as the largest id that was read needs."""
    marker_first: bool
    """Whether the first square holds a marker: OpenCV before 4.6, even number of rows."""
    photos: int
    markers: int
    """Agreeing markers in these photos together."""

    def is_of(self, board: Board) -> bool:
        """Whether a board has all markers that were read, in the same squares."""
        return (
            self.columns == board.columns
            and self.rows <= board.rows
            and self.marker_first == board.marker_first
        )


def best_layout(read: Sequence[DetectedMarkers], given: Board) -> Layout:
    """The layout with which most markers agree; the given board's where as many agree."""
    read = [one for one in read if len(one.ids) >= _FEWEST_AGREEING]
    best = _support(read, given.columns, given.marker_first, given)
    codes = code_count(given.dictionary)
    most_columns = min(_MOST_COLUMNS, (2 * codes + 1) // _FEWEST_SQUARES)
    for columns in range(_FEWEST_SQUARES, most_columns + 1):
        for marker_first in (False, True):
            found = _support(read, columns, marker_first, given)
            best = found if found.markers > best.markers else best
    return best


def _support(
    read: Sequence[DetectedMarkers], columns: int, marker_first: bool, given: Board
) -> Layout:
    """One layout with the photos and markers that agree with it."""
    photos, markers, rows = 0, 0, _FEWEST_SQUARES
    for one in read:
        fits = _in_place(one, columns, marker_first, given)
        if fits.sum() >= _FEWEST_AGREEING:
            photos, markers = photos + 1, markers + int(fits.sum())
            largest = one.ids[fits].max(keepdims=True)
            rows = max(rows, int(_squares_of(largest, columns, marker_first)[0, 1]) + 1)
    return Layout(columns, rows + rows % 2 * marker_first, marker_first, photos, markers)


def _squares_of(
    ids: Int64[np.ndarray, " m"], columns: int, marker_first: bool
) -> Int64[np.ndarray, "m 2"]:
    """Column and row of the square of each marker: markers fill white squares, row by row."""
    pair, within = np.divmod(ids, columns)  # two rows hold as many markers as columns
    in_first = (columns + marker_first) // 2
    second = within >= in_first
    place = np.where(second, within - in_first, within)
    column = 2 * place + (second == marker_first)
    return np.column_stack([column, 2 * pair + second])


_MARKER_CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def _in_place(
    read: DetectedMarkers, columns: int, marker_first: bool, given: Board
) -> Bool[np.ndarray, " m"]:
    """Which markers have all their corners where one homography maps them."""
    squares = _squares_of(read.ids, columns, marker_first)
    offsets = 0.5 * given.marker_mm / given.square_mm * _MARKER_CORNERS
    expected = (squares[:, None] + 0.5 + offsets).reshape(-1, 2)
    corners_px = read.corners_px.reshape(-1, 2)
    homography = np.asarray(
        cv2.findHomography(
            corners_px, expected, cv2.RANSAC, _TOLERANCE_SQUARES, maxIters=_RANSAC_ITERATIONS
        )[0]
    )
    if homography.shape != (3, 3):
        return np.zeros(len(squares), np.bool_)
    mapped = cv2.perspectiveTransform(corners_px[None], homography)[0]
    near = np.linalg.norm(mapped - expected, axis=1) < _TOLERANCE_SQUARES
    return np.logical_and.reduce(near.reshape(-1, 4), axis=1)


_FEWEST_MARKERS_FOR_RATIO = 6
"""Markers of a photo that map it to the board,"""
_FEWEST_PHOTOS_FOR_RATIO = 3
"""and photos that must agree."""
_RATIO_TOLERANCE, _SIDE_TOLERANCE_PX = 0.03, 1.0
"""Error of a measured side, as a share and in pixels: contours run inside the black, blur and glare
eat into it. Rendered markers of 14 to 63 px measure 1.1 to 1.6 px too short."""
_CONTOUR_SHRINKAGE_PX = 1.3


def conflicting_ratio(read: Sequence[DetectedMarkers], given: Board) -> float | None:
    """Measured ratio of a marker's side to its square's, where it contradicts the given board."""
    known = [one for one in (_typical_side(one, given) for one in read) if one is not None]
    if len(known) < _FEWEST_PHOTOS_FOR_RATIO:
        return None
    ratio = float(np.median([one.squares for one in known]))
    side_px = float(np.median([one.pixels for one in known]))
    stated = given.marker_mm / given.square_mm
    allowed = (_RATIO_TOLERANCE + _SIDE_TOLERANCE_PX / side_px) * max(ratio, stated)
    return ratio if abs(ratio - stated) > allowed else None


_RULER_MM = 0.5
"""Error of a side that was measured on the print with a ruler."""
_EDGE_TOLERANCE = 0.01
"""Error of a ratio by edges: 0.5 % in rendered squares of 25 px, 1 % with a tone curve."""
_SQUARES_BY_EDGES = 2
"""Squares of each colour, the largest of a photo, whose sides are measured by edges."""
_MAX_MISFIT = 0.35
"""RMS of the residuals of a side over its contrast; a tone curve makes 0.3."""
_CROP_MARGIN_PX = 16


def ratio_beyond_a_ruler(ratios: Sequence[float], given: Board) -> float | None:
    """Ratio of a marker's side to its square's by edges, where no ruler errs by as much."""
    ratio = float(np.median(ratios))
    allowed_mm = _RULER_MM + _EDGE_TOLERANCE * given.marker_mm
    return ratio if abs(ratio * given.square_mm - given.marker_mm) > allowed_mm else None


def ratio_by_edges(luma: GreyImage, shown: PhotoCorners, given: Board) -> float | None:
    """Ratio of a marker's side to its square's in one photo, by the edges of its dark squares.

    None where too few squares show all their corners and sides.
    """
    left, top = np.maximum(shown.xy_px.min(axis=0).astype(int) - _CROP_MARGIN_PX, 0)
    right, bottom = shown.xy_px.max(axis=0).astype(int) + _CROP_MARGIN_PX
    light = linear_light(luma[top:bottom, left:right])
    across, down = given.inner
    corners_px = np.full((down, across, 2), np.nan)
    corners_px[np.divmod(shown.ids, across)] = shown.xy_px - (left, top)
    squares_px = np.stack(
        [corners_px[:-1, :-1], corners_px[:-1, 1:], corners_px[1:, 1:], corners_px[1:, :-1]], axis=2
    )
    codes = given.cells()[1:-1, 1:-1]
    white = given.white_squares[1:-1, 1:-1]
    stated = given.marker_mm / given.square_mm
    black = np.zeros((int(np.ceil(2.0 / (1.0 - stated))),) * 2, np.uint8)  # a cell is all white
    marker_sides: list[float] = []
    black_sides: list[float] = []
    for sides, kind, share in ((marker_sides, white, stated), (black_sides, ~white, 1.0)):
        at = np.argwhere(kind & np.isfinite(squares_px).all(axis=(2, 3)))
        diagonals_px = squares_px[*at.T, 2:] - squares_px[*at.T, :2]
        areas_px = np.abs(_cross(diagonals_px[:, 0], diagonals_px[:, 1]))
        for row, column in at[np.argsort(-areas_px, kind="stable")[:_SQUARES_BY_EDGES]].tolist():
            code = codes[row, column] if share < 1.0 else black
            side = _side_by_edges(light, squares_px[row, column], share, code)
            sides += [] if side is None else [side]
    if min(len(marker_sides), len(black_sides)) < _SQUARES_BY_EDGES:
        return None
    return float(1.0 + np.mean(marker_sides) - np.mean(black_sides))


def _side_by_edges(
    light: Float32[np.ndarray, "h w"],
    square_px: Float64[np.ndarray, "4 2"],
    share: float,
    code: Code,
) -> float | None:
    """Mean side of the dark square in the middle of a square, in sides of that square.

    Args:
        share: What it should be.
    """
    unit = (0.5 + 0.5 * _MARKER_CORNERS).astype(np.float32)
    to_px = np.asarray(cv2.getPerspectiveTransform(unit, square_px.astype(np.float32)))
    expected = 0.5 + 0.5 * share * _MARKER_CORNERS
    fit = fit_square(light, cv2.perspectiveTransform(expected[None], to_px)[0], code)
    if fit is None or fit.misfit > _MAX_MISFIT:
        return None
    corners = cv2.perspectiveTransform(fit.corners_px[None], np.linalg.inv(to_px))
    return float(_side_lengths(corners).mean())


class _MarkerSide(NamedTuple):
    """Median side of a photo's markers."""

    squares: float
    pixels: float


def _typical_side(read: DetectedMarkers, given: Board) -> _MarkerSide | None:
    """Median side of a photo's markers; None where too few lie as on the board."""
    squares = _squares_of(read.ids, given.columns, given.marker_first) + 0.5
    if len(squares) < _FEWEST_MARKERS_FOR_RATIO:
        return None
    fitted = cv2.findHomography(
        _diagonal_intersections(read.corners_px),
        squares,
        cv2.RANSAC,
        _TOLERANCE_SQUARES / 2,
        maxIters=_RANSAC_ITERATIONS,
    )
    homography = np.asarray(fitted[0])
    if homography.shape != (3, 3):
        return None
    kept = np.asarray(fitted[1]).ravel() > 0
    if kept.sum() < _FEWEST_MARKERS_FOR_RATIO:
        return None
    corners_px = read.corners_px[kept]
    mapped = cv2.perspectiveTransform(corners_px.reshape(1, -1, 2), homography)[0].reshape(-1, 4, 2)
    pixels, sides = (float(np.median(_side_lengths(one))) for one in (corners_px, mapped))
    return _MarkerSide(
        sides * (1.0 + _CONTOUR_SHRINKAGE_PX / pixels), pixels + _CONTOUR_SHRINKAGE_PX
    )


def _diagonal_intersections(corners: Float64[np.ndarray, "m 4 2"]) -> Float64[np.ndarray, "m 2"]:
    """Where the diagonals of each marker cross: the middle of a square in any perspective."""
    first, second, third, fourth = corners.transpose(1, 0, 2)
    first_diagonal, second_diagonal, first_side = third - first, fourth - second, second - first
    fraction = _cross(first_side, second_diagonal) / _cross(first_diagonal, second_diagonal)
    return first + fraction[:, None] * first_diagonal


def _cross(
    one: Float64[np.ndarray, "m 2"], other: Float64[np.ndarray, "m 2"]
) -> Float64[np.ndarray, " m"]:
    """Cross products of rows of plane vectors."""
    return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]


def _side_lengths(corners: Float64[np.ndarray, "m 4 2"]) -> Float64[np.ndarray, "m 4"]:
    """Lengths of the four sides of each marker."""
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
