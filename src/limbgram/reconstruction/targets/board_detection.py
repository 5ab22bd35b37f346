"""Board detection: search in photos, corner refinement, and a check of every corner.

In      a PhotoSet, and the Board.
Out     BoardDetections.
Method  OpenCV's detectors give ids and approximate corners; a model of each corner is fitted to the
        pixels (`targets.corners`); a corner is accepted if its fit is good and it lies where a flat
        board has it.
        Checkerboards: on eight sets of board photos OpenCV's classic detector found all boards that
        its sector-based one (SB) found, but for a few, in a thirtieth of the time; where it fails,
        SB is asked.
        The check: a homography maps pixels, freed of radial distortion by a division model of two
        terms about the picture's centre (Fitzgibbon 2001), to the board: ten unknowns, robust
        weights with a scale that falls from fit to fit. The lens need not be known and may be very
        wide, and no corner is taken as correct beforehand.
        Where few photos show the board clearly, its markers are read by themselves, in the photos
        as taken and mirrored: they tell the board's layout (`targets.layout`), and that photos are
        mirrored where more markers agree so. Otherwise blur or light may hide the board. A
        checkerboard looks the same in a mirror: only a ChArUco board shows that a photo was
        mirrored.
"""

from dataclasses import replace
from itertools import islice
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Float64, Int32
from scipy.optimize import least_squares

from limbgram.core.geometry.arrays import GreyImage, Points2
from limbgram.core.interval import RAYLEIGH_MEDIAN
from limbgram.core.run import in_parallel
from limbgram.findings import Finding, doubt, fault, note
from limbgram.reconstruction.photos.decoding import in_flight_mb, load_luma
from limbgram.reconstruction.photos.photo import Photo, PhotoSet, SetAside
from limbgram.reconstruction.photos.quality import common_fault
from limbgram.reconstruction.photos.resizing import downsampled
from limbgram.reconstruction.targets.board import Board, BoardDetections, PhotoCorners
from limbgram.reconstruction.targets.corners import fit_corners
from limbgram.reconstruction.targets.layout import (
    MOST_CORNERS_BY_CHANCE,
    DetectedMarkers,
    Layout,
    best_layout,
    conflicting_ratio,
    count_in_place,
    detect_markers,
    ratio_beyond_a_ruler,
    ratio_by_edges,
)


class FoundCorners(NamedTuple):
    """Corners as the detector found them, not yet refined or checked."""

    ids: Int32[np.ndarray, " n"]
    xy_px: Points2
    markers: int
    """Markers of the board that were read."""
    agreeing: int
    """Markers among them that lie as on the board."""


def find_charuco(luma: GreyImage, board: Board) -> FoundCorners:
    """Inner corners of the board next to markers that were read."""
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    interpolation = cv2.aruco.CharucoParameters()
    interpolation.minMarkers = 1
    detector = cv2.aruco.CharucoDetector(board.opencv(), interpolation, parameters)
    corners, ids, marker_corners, marker_ids = detector.detectBoard(luma)
    ids = _array_or_empty(ids).astype(np.int32).ravel()
    order = np.argsort(ids, kind="stable")
    read = DetectedMarkers.from_opencv(marker_ids, marker_corners)
    markers, agreeing = len(read.ids), count_in_place(read, board)
    return FoundCorners(
        ids[order], _array_or_empty(corners).reshape(-1, 2)[order], markers, agreeing
    )


def _array_or_empty(found: object) -> np.ndarray:
    """OpenCV's array, or an empty one in place of None."""
    return np.zeros(0) if found is None else np.asarray(found, float)


_FEWEST_MARKERS_IN_PLACE = 2
"""Markers in place that show the board in a photo: one alone may be anything similar."""


_LONG_SIDE_PX = 1600
_CLASSIC_FLAGS = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE


def find_checkerboard(luma: GreyImage, board: Board) -> Points2 | None:
    """Inner corners row by row, or None where the whole board is not seen.

    Large photos are searched in a reduced copy first.
    """
    factor = _search_factor(luma)
    small = downsampled(luma, factor)
    found = _find_classic(small, board.inner)
    if found is None:
        found = _find_sector_based(small, board.inner)
    if found is None and factor < 1.0:
        found, factor = _find_classic(luma, board.inner), 1.0
    if found is None:
        return None
    return _unmirrored((found + 0.5) / factor - 0.5, board.inner)


def other_inner_that_fits(luma: GreyImage, board: Board) -> tuple[int, int] | None:
    """Another number of inner corners that fits the photo, to explain a failure.

    The usual mistakes are tried: squares counted instead of corners, or one row missed.
    """
    small = downsampled(luma, _search_factor(luma))
    across, down = board.inner
    for inner in [
        (across - 1, down - 1),
        (across + 1, down + 1),
        (across - 1, down),
        (across, down - 1),
        (across + 1, down),
        (across, down + 1),
    ]:
        if min(inner) > 2 and _find_classic(small, inner, cv2.CALIB_CB_FAST_CHECK) is not None:
            return inner
    return None


def _search_factor(luma: GreyImage) -> float:
    """Factor by which checkerboards are searched smaller, at most 1."""
    return min(_LONG_SIDE_PX / max(luma.shape), 1.0)


def _find_classic(luma: GreyImage, inner: tuple[int, int], more_flags: int = 0) -> Points2 | None:
    found, corners = cv2.findChessboardCorners(luma, inner, flags=_CLASSIC_FLAGS | more_flags)
    return np.asarray(corners, float).reshape(-1, 2) if found else None


def _find_sector_based(luma: GreyImage, inner: tuple[int, int]) -> Points2 | None:
    found, corners = cv2.findChessboardCornersSB(luma, inner, flags=cv2.CALIB_CB_EXHAUSTIVE)
    return np.asarray(corners, float).reshape(-1, 2) if found else None


def _unmirrored(xy_px: Points2, inner: tuple[int, int]) -> Points2:
    """The corners in an order in which the board's z axis points away from the camera.

    Seen from the front, x to y turns clockwise in the picture (its y points down); rows are
    reversed where a detector reads the board mirrored. A half turn stays undecided where the
    print looks the same.
    """
    grid = xy_px.reshape(inner[1], inner[0], 2)
    along_x = grid[:, -1] - grid[:, 0]
    along_y = grid[-1] - grid[0]
    turn = np.cross(np.append(along_x.mean(axis=0), 0.0), np.append(along_y.mean(axis=0), 0.0))[2]
    if turn < 0:
        grid = grid[::-1]
    return np.ascontiguousarray(grid.reshape(-1, 2))


_CORNERS_FOR_DISTORTION = 12
"""Corners from which on the two distortion terms are fitted too."""
_CAUCHY_SCALES_PX = (10.0, 1.0, 0.3)
"""Scale of the Cauchy loss, from the first fit to the last."""


def board_residuals_px(
    board_squares: Points2,
    xy_px: Points2,
    sides_px: Float64[np.ndarray, "n 2 2"],
    size_px: tuple[int, int],
) -> Float64[np.ndarray, "n 2"]:
    """Corners of a flat board minus detected corners; NaN for fewer than five, which check nothing.

    Args:
        board_squares: The corners on the board, in squares.
        sides_px: For each corner a square's two sides in pixels, one a row.
        size_px: Width and height of the photo.
    """
    if len(xy_px) < 5:
        return np.full(xy_px.shape, np.nan)
    centre = 0.5 * (np.array(size_px) - 1.0)
    normalised = (xy_px - centre) / (0.5 * float(np.hypot(*size_px)))
    origin = board_squares.mean(axis=0)
    centred = board_squares - origin
    start = np.array(cv2.findHomography(normalised, centred, cv2.LMEDS)[0], float)
    if start.shape != (3, 3) or abs(start[2, 2]) < 1e-9:
        return np.full(xy_px.shape, np.nan)
    parameters = (start / start[2, 2]).ravel()[:8]
    if len(xy_px) >= _CORNERS_FOR_DISTORTION:
        parameters = np.concatenate([parameters, [0.0, 0.0]])

    def residuals_px(parameters: np.ndarray) -> np.ndarray:
        off_squares = _map_to_board(parameters, normalised) - centred
        return np.einsum("ni,nij->nj", off_squares, sides_px).ravel()

    for scale_px in _CAUCHY_SCALES_PX:
        parameters = least_squares(
            residuals_px, parameters, loss="cauchy", f_scale=scale_px, x_scale="jac"
        ).x
    return residuals_px(parameters).reshape(-1, 2)


def _map_to_board(parameters: np.ndarray, normalised: Points2) -> Points2:
    """Board coordinates of pixels, which are given in half diagonals from the picture's centre."""
    rows = np.append(parameters[:8], 1.0).reshape(3, 3)
    weight = np.ones((len(normalised), 1))
    if len(parameters) > 8:
        r2 = (normalised**2).sum(axis=1, keepdims=True)
        weight = 1.0 + r2 * (parameters[8] + r2 * parameters[9])
    mapped = normalised @ rows[:, :2].T + weight * rows[:, 2]
    return mapped[:, :2] / np.where(np.abs(mapped[:, 2:]) < 1e-9, 1e-9, mapped[:, 2:])


_MIN_CORNERS = 6
"""Accepted corners that a photo needs."""
_MAX_OFF_BOARD_PX = 0.5
"""Accepted distance from the flat board's image, px; the larger of the two limits holds."""
_MAX_OFF_BOARD_SIGMAS = 6.0
"""The same in robust standard deviations of the photo's corners."""
_MAX_REACH_PX = 40.0
"""Largest half side of the fit's window."""


_MIN_CONTRAST = 8.0
"""Half the grey step from black to white squares, of 255."""
_MAX_MISFIT = 0.35
"""RMS of the corner fit's grey residuals over its contrast."""
_MAX_SHIFT = 0.2
"""Largest distance of a refined corner from the detected one, in squares."""
_REACH = 0.45
"""Half side of the fit's window in squares (less where markers are near)."""


_PHOTOS_FOR_RATIO = 6
"""Photos, those with the largest board, in which the ratio of marker to square is measured."""
_FEW_PHOTOS = 3
"""Fewer photos of the board give neither a camera nor a scale."""
SEARCH_BYTES = 7.0
"""A pixel, while a board is looked for: 5.8 (ChArUco) and less (checkerboard) on 24 MP."""


def find_board(photos: PhotoSet, board: Board) -> BoardDetections:
    """Find the corners of one board in every photo that shows it.

    A board of the given size that is printed in OpenCV's other pattern is read in that pattern. One
    with another ratio of marker to square is another board: one of both sizes was stated wrongly,
    and with that of the squares the scale.
    """
    found = _detect(photos, board)
    firmly_shown = sum(len(one.ids) > MOST_CORNERS_BY_CHANCE for one in found.photos)
    if board.kind == "checkerboard":
        return found
    if firmly_shown >= _FEW_PHOTOS:
        return _with_checked_ratio(found, _ratio_in_largest(photos, found), board)
    as_taken, mirrored, read = _read_layouts(photos, board)
    if mirrored.markers > as_taken.markers:
        return _rejected(found, fault("board.mirrored", photos=mirrored.photos))
    if as_taken.is_of(board) or as_taken.photos <= firmly_shown:
        return _with_checked_ratio(found, conflicting_ratio(read, board), board)
    other_pattern = replace(board, legacy=as_taken.marker_first)
    if as_taken.is_of(other_pattern):
        ratio = conflicting_ratio(read, other_pattern)
        return _with_checked_ratio(_detect(photos, other_pattern), ratio, other_pattern)
    other_layout = fault(
        "board.other_layout",
        columns=as_taken.columns,
        rows=as_taken.rows,
        legacy=as_taken.marker_first,
        given_columns=board.columns,
        given_rows=board.rows,
    )
    return _rejected(found, other_layout)


def _ratio_in_largest(photos: PhotoSet, found: BoardDetections) -> float | None:
    """Measured ratio of marker to square, where it contradicts the board, in the largest photos."""
    board = found.board
    largest = sorted(found.photos, key=lambda one: -one.step_px)[:_PHOTOS_FOR_RATIO]
    by_edges = (
        ratio_by_edges(load_luma(photos.photos[one.photo_idx]), one, board) for one in largest
    )
    ratios = list(islice((one for one in by_edges if one is not None), _FEW_PHOTOS))
    if len(ratios) == _FEW_PHOTOS:
        return ratio_beyond_a_ruler(ratios, board)
    read = in_parallel(
        lambda one: detect_markers(load_luma(photos.photos[one.photo_idx]), board),
        largest,
        each_mb=in_flight_mb(photos.photos, SEARCH_BYTES),
    )
    return conflicting_ratio(read, board)


def _with_checked_ratio(
    found: BoardDetections, ratio: float | None, board: Board
) -> BoardDetections:
    """The detections, rejected where this ratio of marker to square contradicts the given one.

    Photos with a common fault do not tell: overexposed white eats into the black of markers.
    """
    if ratio is None or found.cause is not None:
        return found
    cause = fault(
        "board.other_ratio",
        ratio=ratio,
        given_ratio=board.marker_mm / board.square_mm,
        square_mm=board.square_mm,
        marker_mm=board.marker_mm,
        fitting_mm=ratio * board.square_mm,
    )
    return _rejected(found, cause)


def _rejected(found: BoardDetections, cause: Finding) -> BoardDetections:
    """The detections without any photo, because markers were misread."""
    misread = (SetAside(one.name, doubt("board.photo.misread")) for one in found.photos)
    return replace(found, photos=(), set_aside=(*found.set_aside, *misread), cause=cause)


def _detect(photos: PhotoSet, board: Board) -> BoardDetections:
    def work(photo_idx: int) -> PhotoCorners | SetAside:
        photo = photos.photos[photo_idx]
        return find_in_photo(photo, photo_idx, load_luma(photo), board)

    results = in_parallel(
        work, range(len(photos.photos)), each_mb=in_flight_mb(photos.photos, SEARCH_BYTES)
    )
    return BoardDetections(
        board=board,
        corners_mm=board.corners_mm,
        photos=tuple(one for one in results if isinstance(one, PhotoCorners)),
        set_aside=tuple(one for one in results if isinstance(one, SetAside)),
        cause=common_fault(photos.photos),
    )


class _PhotoLayouts(NamedTuple):
    """Layout of the markers in the photos as taken, and with left and right swapped."""

    as_taken: Layout
    mirrored: Layout
    read: list[DetectedMarkers]
    """Markers of each photo as taken."""


def _read_layouts(photos: PhotoSet, board: Board) -> _PhotoLayouts:
    def work(photo: Photo) -> tuple[DetectedMarkers, DetectedMarkers]:
        luma = load_luma(photo)
        mirrored = np.ascontiguousarray(luma[:, ::-1])
        return detect_markers(luma, board), detect_markers(mirrored, board)

    read = in_parallel(work, photos.photos, each_mb=in_flight_mb(photos.photos, SEARCH_BYTES))
    as_taken, mirrored = [one for one, _ in read], [one for _, one in read]
    return _PhotoLayouts(best_layout(as_taken, board), best_layout(mirrored, board), as_taken)


def find_in_photo(
    photo: Photo, photo_idx: int, luma: GreyImage, board: Board
) -> PhotoCorners | SetAside:
    """The board's corners in one photo, or why it is set aside."""
    if board.kind == "checkerboard":
        found = find_checkerboard(luma, board)
        if found is None:
            return SetAside(photo.name, _why_no_checkerboard(luma, board))
        ids = np.arange(len(found), dtype=np.int32)
    else:
        ids, found, markers, agreeing = find_charuco(luma, board)
        if len(ids) < _MIN_CORNERS:
            few = note(
                "board.photo.few_corners",
                markers=int(markers),
                corners=len(ids),
                board=board.finding,
                least=_MIN_CORNERS,
            )
            return SetAside(photo.name, few)
        if agreeing < _FEWEST_MARKERS_IN_PLACE:
            otherwise = note("board.photo.otherwise", markers=int(markers), board=board.finding)
            return SetAside(photo.name, otherwise)
    return _fit_and_check(photo, photo_idx, luma, board, ids, found)


def _fit_and_check(
    photo: Photo,
    photo_idx: int,
    luma: GreyImage,
    board: Board,
    ids: Int32[np.ndarray, " n"],
    found: Points2,
) -> PhotoCorners | SetAside:
    size_px = (luma.shape[1], luma.shape[0])
    board_squares = board.corners_mm[ids, :2] / board.square_mm
    sides = square_sides_px(board_squares, found)
    step_px = np.linalg.norm(sides, axis=2).mean(axis=1)
    reach = min(_window_reach(board, _REACH), _MAX_REACH_PX / np.median(step_px))
    fits = fit_corners(luma, found, sides, float(reach))
    doubts = np.full(len(ids), "", dtype=object)
    doubts[fits.misfit > _MAX_MISFIT] = "board.corner.no_crossing"
    doubts[fits.contrast < _MIN_CONTRAST] = "board.corner.contrast"
    shift_px = np.linalg.norm(fits.xy_px - found, axis=1)
    doubts[shift_px > _MAX_SHIFT * step_px] = "board.corner.moved"
    doubts[np.isnan(fits.sigma_px)] = "board.corner.no_fit"
    _doubt_corners_off_board(doubts, board_squares, fits.xy_px, sides, size_px)

    good = doubts == ""
    if good.sum() < _MIN_CORNERS:
        unmeasured = note(
            "board.photo.unmeasured",
            good=int(good.sum()),
            corners=len(ids),
            reason=_most_common(doubts[~good]),
        )
        return SetAside(photo.name, unmeasured)
    return PhotoCorners(
        name=photo.name,
        photo_idx=photo_idx,
        ids=ids[good],
        xy_px=fits.xy_px[good],
        sigmas_px=fits.sigma_px[good],
        blur_px=float(np.median(fits.blur_px[good])),
        step_px=float(np.median(step_px)),
        doubtful_ids=ids[~good],
        doubtful_xy_px=np.where(np.isnan(fits.xy_px), found, fits.xy_px)[~good],
        doubts=tuple(str(doubt) for doubt in doubts[~good]),
    )


def square_sides_px(board_squares: Points2, xy_px: Points2) -> Float64[np.ndarray, "n 2 2"]:
    """The two sides of a square at each corner, in pixels, from the corners round it."""
    sides = np.empty((len(xy_px), 2, 2))
    for row, centre in enumerate(board_squares):
        away = board_squares - centre
        near = np.exp(-0.5 * (away**2).sum(axis=1))[:, None]
        design = np.column_stack([away, np.ones(len(away))])
        sides[row] = np.linalg.lstsq(design * near, xy_px * near, rcond=None)[0][:2]
    return sides


def _window_reach(board: Board, reach: float) -> float:
    """Half side of the fit's window, in squares: no marker reaches into it."""
    if board.kind == "checkerboard":
        return reach
    return min(reach, 0.95 * 0.5 * (1.0 - board.marker_mm / board.square_mm))


def _doubt_corners_off_board(
    doubts: np.ndarray,
    board_squares: Points2,
    xy_px: Points2,
    sides: Float64[np.ndarray, "n 2 2"],
    size_px: tuple[int, int],
) -> None:
    """Mark the corners that do not lie on the image of a flat board as doubtful."""
    rows = np.flatnonzero(doubts == "")
    off_px = np.linalg.norm(
        board_residuals_px(board_squares[rows], xy_px[rows], sides[rows], size_px), axis=1
    )
    if len(rows) == 0 or np.isnan(off_px).any():
        return
    spread_px = float(np.median(off_px)) / RAYLEIGH_MEDIAN
    limit_px = max(_MAX_OFF_BOARD_PX, _MAX_OFF_BOARD_SIGMAS * spread_px)
    doubts[rows[off_px > limit_px]] = "board.corner.off"


def _why_no_checkerboard(luma: GreyImage, board: Board) -> Finding:
    other = other_inner_that_fits(luma, board)
    if other is None:
        return note("board.photo.no_checkerboard", board=board.finding)
    return note(
        "board.photo.other_checkerboard", board=board.finding, across=other[0], down=other[1]
    )


def _most_common(doubts: np.ndarray) -> Finding:
    codes = [str(code) for code in doubts]
    return Finding(max(codes, key=codes.count) if codes else "board.corner.few_found")
