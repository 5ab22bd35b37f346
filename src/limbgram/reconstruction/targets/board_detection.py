"""Board detection in photos: search, sub-pixel fit, and a check of every corner.

In      a PhotoSet, and the Board.
Out     BoardDetections.
Method  OpenCV's detectors give ids and rough places; a model of each crossing is fitted to the
        pixels (`targets.corners`); a corner is believed if its fit is good and it lies where a flat
        board has it.
        Checkerboards: on eight sets of board photos OpenCV's classic detector found all boards that
        its sector-based one (SB) found, but for a few, in a thirtieth of the time; where it fails,
        SB is asked.
        The check: pixels, freed of radial distortion by a division model of two terms about the
        picture's centre (Fitzgibbon 2001), map to the board by a homography: ten unknowns, robust
        weights, first forgiving and then strict. The lens need not be known, it may be very wide,
        and no corner is trusted.
        Where hardly any photo shows it firmly, its markers are read by themselves, in the photos as
        they are and mirrored: they tell which board they lie on (`targets.layout`), and that
        photos are mirrored where more of them agree so. Else blur or light may hide the board. A
        checkerboard looks the same in a mirror: only a ChArUco board can show that a photo was
        mirrored.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Float64, Int32, UInt8
from scipy.optimize import least_squares

from limbgram.core.geometry.arrays import GreyImage, Points2
from limbgram.core.run import in_parallel
from limbgram.findings import Finding, doubt, fault, note
from limbgram.reconstruction.photos.decoding import in_flight_mb, load_luma
from limbgram.reconstruction.photos.photo import Photo, PhotoSet, SetAside
from limbgram.reconstruction.photos.quality import common_fault
from limbgram.reconstruction.targets.board import Board, BoardDetections, PhotoCorners
from limbgram.reconstruction.targets.corners import fit_corners
from limbgram.reconstruction.targets.layout import (
    CORNERS_BY_CHANCE,
    Layout,
    MarkersRead,
    agreeing_with,
    layout_of,
    other_ratio,
    read_markers,
)


class FoundCorners(NamedTuple):
    """Corners as they were found, not yet fitted or checked."""

    ids: Int32[np.ndarray, " n"]
    xy_px: Points2
    markers: int
    """Markers of the board that were read,"""
    agreeing: int
    """and those of them that lie as on the board."""


def find_charuco(luma: GreyImage, board: Board) -> FoundCorners:
    """Inner corners of the board that lie between markers that were read."""
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    interpolation = cv2.aruco.CharucoParameters()
    interpolation.minMarkers = 1
    detector = cv2.aruco.CharucoDetector(board.opencv(), interpolation, parameters)
    corners, ids, marker_corners, marker_ids = detector.detectBoard(luma)
    ids = _rows(ids).astype(np.int32).ravel()
    order = np.argsort(ids, kind="stable")
    read = MarkersRead.of(marker_ids, marker_corners)
    markers, agreeing = len(read.numbers), agreeing_with(read, board)
    return FoundCorners(ids[order], _rows(corners).reshape(-1, 2)[order], markers, agreeing)


def _rows(found: object) -> np.ndarray:
    """OpenCV's array, or an empty one for its None."""
    return np.zeros(0) if found is None else np.asarray(found, float)


_FEWEST_IN_PLACE = 2
"""Markers of a photo that shows the board: one alone is anything that looks like it."""


_LONG_SIDE_PX = 1600
_CLASSIC = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE


def find_checkerboard(luma: GreyImage, board: Board) -> Points2 | None:
    """Inner corners row by row, or None where the whole board is not seen.

    Photos larger than the detectors like are searched in a reduced copy first.
    """
    small, factor = reduced(luma, _LONG_SIDE_PX)
    found = _classic(small, board.inner)
    if found is None:
        found = _sector_based(small, board.inner)
    if found is None and factor < 1.0:
        found, factor = _classic(luma, board.inner), 1.0
    if found is None:
        return None
    return _from_top_left((found + 0.5) / factor - 0.5, board.inner)


def likely_inner(luma: GreyImage, board: Board) -> tuple[int, int] | None:
    """Another number of inner corners that does fit the photo, to explain a failure.

    Tried are the mistakes people make: squares counted for corners, or one row missed.
    """
    small, _ = reduced(luma, _LONG_SIDE_PX)
    across, down = board.inner
    for inner in [
        (across - 1, down - 1),
        (across + 1, down + 1),
        (across - 1, down),
        (across, down - 1),
        (across + 1, down),
        (across, down + 1),
    ]:
        if min(inner) > 2 and _classic(small, inner, cv2.CALIB_CB_FAST_CHECK) is not None:
            return inner
    return None


def reduced(
    luma: GreyImage, long_side_px: int
) -> tuple[UInt8[np.ndarray, "small_h small_w"], float]:
    """A copy no longer than asked, and its scale (x_small = (x + 0.5) * scale - 0.5)."""
    factor = long_side_px / max(luma.shape)
    if factor >= 1.0:
        return luma, 1.0
    size = (round(luma.shape[1] * factor), round(luma.shape[0] * factor))
    small = cv2.resize(luma, size, interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.uint8), factor


def _classic(luma: GreyImage, inner: tuple[int, int], more_flags: int = 0) -> Points2 | None:
    found, corners = cv2.findChessboardCorners(luma, inner, flags=_CLASSIC | more_flags)
    return np.asarray(corners, float).reshape(-1, 2) if found else None


def _sector_based(luma: GreyImage, inner: tuple[int, int]) -> Points2 | None:
    found, corners = cv2.findChessboardCornersSB(luma, inner, flags=cv2.CALIB_CB_EXHAUSTIVE)
    return np.asarray(corners, float).reshape(-1, 2) if found else None


def _from_top_left(xy_px: Points2, inner: tuple[int, int]) -> Points2:
    """Order the corners so that the board's z points away from the camera.

    Seen from the front, x to y must turn clockwise in the picture (its y points down); a
    detector that reads the board mirrored is corrected by reversing its rows. Half a turn is
    left open where the print allows it.
    """
    grid = xy_px.reshape(inner[1], inner[0], 2)
    along_x = grid[:, -1] - grid[:, 0]
    along_y = grid[-1] - grid[0]
    turn = np.cross(np.append(along_x.mean(axis=0), 0.0), np.append(along_y.mean(axis=0), 0.0))[2]
    if turn < 0:
        grid = grid[::-1]
    return np.ascontiguousarray(grid.reshape(-1, 2))


_FOR_LENS = 12
"""Corners from which the two distortion terms are fitted too."""
_SCALES_PX = (10.0, 1.0, 0.3)
"""Misses beyond which a corner loses weight, from the first fit to the last."""


def board_residuals_px(
    board_squares: Points2,
    xy_px: Points2,
    sides_px: Float64[np.ndarray, "n 2 2"],
    size_px: tuple[int, int],
) -> Float64[np.ndarray, "n 2"]:
    """Modelled minus found corners; NaN where fewer than five corners leave nothing to check.

    Args:
        board_squares: The corners on the board, in squares.
        sides_px: For each corner a square's two sides in pixels, one a row.
        size_px: Width and height of the photo.
    """
    if len(xy_px) < 5:
        return np.full(xy_px.shape, np.nan)
    centre = 0.5 * (np.array(size_px) - 1.0)
    seen = (xy_px - centre) / (0.5 * float(np.hypot(*size_px)))
    origin = board_squares.mean(axis=0)
    centred = board_squares - origin
    start = np.array(cv2.findHomography(seen, centred, cv2.LMEDS)[0], float)
    if start.shape != (3, 3) or abs(start[2, 2]) < 1e-9:
        return np.full(xy_px.shape, np.nan)
    unknowns = (start / start[2, 2]).ravel()[:8]
    if len(xy_px) >= _FOR_LENS:
        unknowns = np.concatenate([unknowns, [0.0, 0.0]])

    def misses_px(unknowns: np.ndarray) -> np.ndarray:
        off_squares = _on_board(unknowns, seen) - centred
        return np.einsum("ni,nij->nj", off_squares, sides_px).ravel()

    for scale_px in _SCALES_PX:
        unknowns = least_squares(
            misses_px, unknowns, loss="cauchy", f_scale=scale_px, x_scale="jac"
        ).x
    return misses_px(unknowns).reshape(-1, 2)


def _on_board(unknowns: np.ndarray, seen: Points2) -> Points2:
    """Places on the board of pixels given in half diagonals from the picture's centre."""
    rows = np.append(unknowns[:8], 1.0).reshape(3, 3)
    weight = np.ones((len(seen), 1))
    if len(unknowns) > 8:
        r2 = (seen**2).sum(axis=1, keepdims=True)
        weight = 1.0 + r2 * (unknowns[8] + r2 * unknowns[9])
    mapped = seen @ rows[:, :2].T + weight * rows[:, 2]
    return mapped[:, :2] / np.where(np.abs(mapped[:, 2:]) < 1e-9, 1e-9, mapped[:, 2:])


_MIN_CORNERS = 6
"""Believed corners without which a photo is set aside."""
_MAX_OFF_BOARD_PX = 0.5
"""Accepted distance from the flat board's image, or `max_off_board_spread` if larger."""
_MAX_OFF_BOARD_SPREAD = 6.0
"""The same in robust standard deviations of the photo's corners."""
_MAX_REACH_PX = 40.0
"""Half side of the fit's window at most."""


_MIN_CONTRAST = 8.0
"""Half the grey step from black to white squares, of 255."""
_MAX_MISFIT = 0.35
"""RMS of the corner fit's grey residuals over its contrast."""
_MAX_SHIFT = 0.2
"""Farthest that the fit may move a corner from where it was detected, in squares."""
_REACH = 0.45
"""Half side of the fit's window in squares (less where markers are near)."""


_ASKED_FOR_RATIO = 6
"""Photos that show the board largest tell how much of a square a marker fills."""
_FEW_PHOTOS = 3
"""With fewer photos of the board neither a camera nor a scale can be told."""
SEARCH_BYTES = 7.0
"""A pixel, while a board is looked for: 5.8 (ChArUco) and less (checkerboard) on 24 MP."""


def find_board(photos: PhotoSet, board: Board) -> BoardDetections:
    """Find the corners of one board in every photo that shows it.

    A board of the given size that was printed in the other pattern of OpenCV is read in that one.
    One whose markers fill another part of their squares is another board: then one of both sizes
    was given wrongly, and with the squares' the scale.
    """
    found = _detected(photos, board)
    firm = sum(len(one.ids) > CORNERS_BY_CHANCE for one in found.photos)
    if board.kind == "checkerboard":
        return found
    if firm >= _FEW_PHOTOS:
        largest = sorted(found.photos, key=lambda one: -one.step_px)[:_ASKED_FOR_RATIO]
        read = in_parallel(
            lambda one: read_markers(load_luma(photos.photos[one.photo_idx]), board),
            largest,
            each_mb=in_flight_mb(photos.photos, SEARCH_BYTES),
        )
        return _of_this_ratio(found, read, board)
    shown, swapped, read = _layouts(photos, board)
    if swapped.markers > shown.markers:
        return _not_this(found, fault("board.mirrored", photos=swapped.photos))
    if shown.is_of(board) or shown.photos <= firm:
        return _of_this_ratio(found, read, board)
    other_pattern = replace(board, legacy=shown.marker_first)
    if shown.is_of(other_pattern):
        return _detected(photos, other_pattern)
    other_layout = fault(
        "board.other_layout",
        columns=shown.columns,
        rows=shown.rows,
        legacy=shown.marker_first,
        given_columns=board.columns,
        given_rows=board.rows,
    )
    return _not_this(found, other_layout)


def _of_this_ratio(
    found: BoardDetections, read: Sequence[MarkersRead], board: Board
) -> BoardDetections:
    """The corners, unless the markers fill their squares otherwise than was given.

    Photos that share a fault do not tell it: burnt white eats into the black of markers.
    """
    ratio = other_ratio(read, board)
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
    return _not_this(found, cause)


def _not_this(found: BoardDetections, cause: Finding) -> BoardDetections:
    """Without the corners between markers that were misread."""
    misread = (SetAside(one.name, doubt("board.photo.misread")) for one in found.photos)
    return replace(found, photos=(), set_aside=(*found.set_aside, *misread), cause=cause)


def _detected(photos: PhotoSet, board: Board) -> BoardDetections:
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


class _Layouts(NamedTuple):
    """How the markers lie in the photos as they are, and with left and right swapped."""

    shown: Layout
    swapped: Layout
    read: list[MarkersRead]
    """As they are."""


def _layouts(photos: PhotoSet, board: Board) -> _Layouts:
    def work(photo: Photo) -> tuple[MarkersRead, MarkersRead]:
        luma = load_luma(photo)
        swapped = np.ascontiguousarray(luma[:, ::-1])
        return read_markers(luma, board), read_markers(swapped, board)

    read = in_parallel(work, photos.photos, each_mb=in_flight_mb(photos.photos, SEARCH_BYTES))
    shown, swapped = [one for one, _ in read], [one for _, one in read]
    return _Layouts(layout_of(shown, board), layout_of(swapped, board), shown)


def find_in_photo(
    photo: Photo, photo_idx: int, luma: GreyImage, board: Board
) -> PhotoCorners | SetAside:
    """The same for one photo whose pixels are at hand."""
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
        if agreeing < _FEWEST_IN_PLACE:
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
    sides = sides_px(board_squares, found)
    step_px = np.linalg.norm(sides, axis=2).mean(axis=1)
    reach = min(_clear_reach(board, _REACH), _MAX_REACH_PX / np.median(step_px))
    fits = fit_corners(luma, found, sides, float(reach))
    doubts = np.full(len(ids), "", dtype=object)
    doubts[fits.misfit > _MAX_MISFIT] = "board.corner.no_crossing"
    doubts[fits.contrast < _MIN_CONTRAST] = "board.corner.contrast"
    shift_px = np.linalg.norm(fits.xy_px - found, axis=1)
    doubts[shift_px > _MAX_SHIFT * step_px] = "board.corner.moved"
    doubts[np.isnan(fits.sigma_px)] = "board.corner.no_fit"
    _check_flatness(doubts, board_squares, fits.xy_px, sides, size_px)

    good = doubts == ""
    if good.sum() < _MIN_CORNERS:
        unmeasured = note(
            "board.photo.unmeasured",
            good=int(good.sum()),
            corners=len(ids),
            reason=_commonest(doubts[~good]),
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


def sides_px(board_squares: Points2, xy_px: Points2) -> Float64[np.ndarray, "n 2 2"]:
    """A square's two sides at each corner, in pixels, from the corners round it."""
    sides = np.empty((len(xy_px), 2, 2))
    for row, centre in enumerate(board_squares):
        away = board_squares - centre
        near = np.exp(-0.5 * (away**2).sum(axis=1))[:, None]
        design = np.column_stack([away, np.ones(len(away))])
        sides[row] = np.linalg.lstsq(design * near, xy_px * near, rcond=None)[0][:2]
    return sides


def _clear_reach(board: Board, reach: float) -> float:
    """Half side of a window that no marker enters, in squares."""
    if board.kind == "checkerboard":
        return reach
    return min(reach, 0.95 * 0.5 * (1.0 - board.marker_mm / board.square_mm))


def _check_flatness(
    doubts: np.ndarray,
    board_squares: Points2,
    xy_px: Points2,
    sides: Float64[np.ndarray, "n 2 2"],
    size_px: tuple[int, int],
) -> None:
    """Doubt the corners that do not lie on the image of a flat board."""
    rows = np.flatnonzero(doubts == "")
    off_px = np.linalg.norm(
        board_residuals_px(board_squares[rows], xy_px[rows], sides[rows], size_px), axis=1
    )
    if len(rows) == 0 or np.isnan(off_px).any():
        return
    spread_px = float(np.median(off_px)) / 1.1774
    limit_px = max(_MAX_OFF_BOARD_PX, _MAX_OFF_BOARD_SPREAD * spread_px)
    doubts[rows[off_px > limit_px]] = "board.corner.off"


def _why_no_checkerboard(luma: GreyImage, board: Board) -> Finding:
    other = likely_inner(luma, board)
    if other is None:
        return note("board.photo.no_checkerboard", board=board.finding)
    return note(
        "board.photo.other_checkerboard", board=board.finding, across=other[0], down=other[1]
    )


def _commonest(doubts: np.ndarray) -> Finding:
    codes = [str(code) for code in doubts]
    return Finding(max(set(codes), key=codes.count) if codes else "board.corner.few_found")
