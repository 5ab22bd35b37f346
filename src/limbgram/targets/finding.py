"""Finding a board in photos: detection, sub-pixel fit, and a check of every corner.

In      a PhotoSet, and the Board.
Out     BoardDetections.
Method  OpenCV's detectors give ids and rough places; a model of each crossing is fitted to the
        pixels; a corner is believed if its fit is good and it lies where a flat board has it.
        Where hardly any photo shows the board, photos are looked at mirrored, and asked whether
        blur or light hide it. A checkerboard looks alike mirrored, so that only a ChArUco board
        can tell.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int32

from limbgram.geometry.arrays import GreyImage, Points2
from limbgram.photos.decoding import in_flight_mb
from limbgram.photos.photo import Photo, PhotoSet, SetAside
from limbgram.photos.quality import common_fault
from limbgram.photos.reading import load_luma
from limbgram.run import in_parallel
from limbgram.targets.board import Board
from limbgram.targets.charuco import find_charuco
from limbgram.targets.checkerboard import find_checkerboard, likely_inner
from limbgram.targets.consistency import board_residuals_px
from limbgram.targets.corners import fit_corners
from limbgram.targets.detections import BoardDetections, PhotoCorners


@dataclass(frozen=True, kw_only=True)
class TargetOptions:
    """When a corner, and a photo of the board, is believed."""

    min_corners: int = 6
    """Believed corners without which a photo is set aside."""
    min_contrast: float = 8.0
    """Half the grey step from black to white squares, of 255."""
    max_misfit: float = 0.35
    """RMS of the corner fit's grey residuals over its contrast."""
    max_shift: float = 0.2
    """Farthest that the fit may move a corner from where it was detected, in squares."""
    max_off_board_px: float = 0.5
    """Accepted distance from the flat board's image, or `max_off_board_spread` if larger."""
    max_off_board_spread: float = 6.0
    """The same in robust standard deviations of the photo's corners."""
    reach: float = 0.45
    """Half side of the fit's window in squares (less where markers are near)."""
    max_reach_px: float = 40.0
    """Half side of the fit's window at most."""


DEFAULTS = TargetOptions()
_FEW_PHOTOS = 3
"""With fewer photos of the board neither a camera nor a scale can be told."""
SEARCH_BYTES = 7.0
"""A pixel, while a board is looked for: 5.8 (ChArUco) and less (checkerboard) on 24 MP."""
_MIRRORED = (
    "The photos are mirrored: {count} of them show the board only when left and right are swapped. "
    "A front camera or a program mirrored them, or the board was printed mirrored. Use the rear "
    "camera and give the photos as they come from it; a limb measured in mirrored photos would be "
    "its mirror image."
)


def find_board(
    photos: PhotoSet, board: Board, options: TargetOptions = DEFAULTS
) -> BoardDetections:
    """Find the corners of one board in every photo that shows it."""

    def work(photo_idx: int) -> PhotoCorners | SetAside:
        photo = photos.photos[photo_idx]
        return find_in_photo(photo, photo_idx, load_luma(photo), board, options)

    results = in_parallel(
        work, range(len(photos.photos)), each_mb=in_flight_mb(photos.photos, SEARCH_BYTES)
    )
    found = tuple(one for one in results if isinstance(one, PhotoCorners))
    return BoardDetections(
        board=board,
        corners_mm=board.corners_mm,
        photos=found,
        set_aside=tuple(one for one in results if isinstance(one, SetAside)),
        cause=_cause(photos, board, len(found), options),
    )


def _cause(photos: PhotoSet, board: Board, found: int, options: TargetOptions) -> str:
    """What would explain that the board is hard to find; empty where the photos do not tell."""
    if board.kind == "charuco" and found < _FEW_PHOTOS:
        mirrored = sum(
            in_parallel(
                lambda photo: _shows_mirrored(photo, board, options),
                photos.photos,
                each_mb=in_flight_mb(photos.photos, SEARCH_BYTES),
            )
        )
        if mirrored > found:
            return _MIRRORED.format(count=mirrored)
    return common_fault(photos.photos) or ""


def _shows_mirrored(photo: Photo, board: Board, options: TargetOptions) -> bool:
    swapped = np.ascontiguousarray(load_luma(photo)[:, ::-1])
    return len(find_charuco(swapped, board).ids) >= options.min_corners


def find_in_photo(
    photo: Photo, photo_idx: int, luma: GreyImage, board: Board, options: TargetOptions = DEFAULTS
) -> PhotoCorners | SetAside:
    """The same for one photo whose pixels are at hand."""
    if board.kind == "checkerboard":
        found = find_checkerboard(luma, board)
        if found is None:
            return SetAside(photo.name, _why_no_checkerboard(luma, board))
        ids = np.arange(len(found), dtype=np.int32)
    else:
        ids, found, markers = find_charuco(luma, board)
        if len(ids) < options.min_corners:
            return SetAside(
                photo.name,
                f"{markers} markers and {len(ids)} corners of the {board} found; "
                f"{options.min_corners} corners are needed",
            )
    return _fit_and_check(photo, photo_idx, luma, board, ids, found, options)


def _fit_and_check(
    photo: Photo,
    photo_idx: int,
    luma: GreyImage,
    board: Board,
    ids: Int32[np.ndarray, " n"],
    found: Points2,
    options: TargetOptions,
) -> PhotoCorners | SetAside:
    size_px = (luma.shape[1], luma.shape[0])
    plate = board.corners_mm[ids, :2] / board.square_mm
    sides = sides_px(plate, found)
    step_px = np.linalg.norm(sides, axis=2).mean(axis=1)
    reach = min(_clear_reach(board, options.reach), options.max_reach_px / np.median(step_px))
    fits = fit_corners(luma, found, sides, float(reach))
    doubts = np.full(len(ids), "", dtype=object)
    doubts[fits.misfit > options.max_misfit] = "the picture round it is no crossing of edges"
    doubts[fits.contrast < options.min_contrast] = "hardly any contrast"
    shift_px = np.linalg.norm(fits.xy_px - found, axis=1)
    doubts[shift_px > options.max_shift * step_px] = "the fit moved it too far"
    doubts[np.isnan(fits.sigma_px)] = "at the picture's border, or no fit"
    _check_flatness(doubts, plate, fits.xy_px, sides, size_px, options)

    good = doubts == ""
    if good.sum() < options.min_corners:
        return SetAside(
            photo.name,
            f"only {good.sum()} of {len(ids)} corners of the board can be measured "
            f"({_commonest(doubts[~good])})",
        )
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
    plate: Points2,
    xy_px: Points2,
    sides: Float64[np.ndarray, "n 2 2"],
    size_px: tuple[int, int],
    options: TargetOptions,
) -> None:
    """Doubt the corners that do not lie on the image of a flat board."""
    rows = np.flatnonzero(doubts == "")
    off_px = np.linalg.norm(
        board_residuals_px(plate[rows], xy_px[rows], sides[rows], size_px), axis=1
    )
    if len(rows) == 0 or np.isnan(off_px).any():
        return
    spread_px = float(np.median(off_px)) / 1.1774
    limit_px = max(options.max_off_board_px, options.max_off_board_spread * spread_px)
    for row, distance_px in zip(rows, off_px):
        if distance_px > limit_px:
            doubts[row] = f"{distance_px:.2f} px off the flat board's image"


def _why_no_checkerboard(luma: GreyImage, board: Board) -> str:
    other = likely_inner(luma, board)
    if other is None:
        return f"no {board} found: it must be seen whole, sharp and evenly lit"
    return (
        f"no {board} found, but one of {other[0]} x {other[1]} inner corners: count the inner "
        "corners, one fewer than the squares each way"
    )


def _commonest(doubts: np.ndarray) -> str:
    reasons = [str(doubt) if "px off" not in str(doubt) else "off the board" for doubt in doubts]
    return max(set(reasons), key=reasons.count) if reasons else "too few were found"
