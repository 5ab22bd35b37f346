"""Coded marks: single AprilTag or ArUco markers, found in photos and measured by their sides.

In      a PhotoSet, the marks' dictionary, and the lens of each photo if it is known.
Out     MarkDetections: for each photo the marks that it shows, their corners and centres.
Method  OpenCV reads the codes and says to a pixel or two where the squares are; which release of
        it does so leaves no trace, because `edges` fits all four sides anew. A mark that a photo
        shows twice, or whose sides do not fit, is named and not believed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float64, Int32

from limbgram.core.errors import OptionsError
from limbgram.core.geometry.arrays import GreyImage
from limbgram.core.geometry.lens import Camera
from limbgram.core.run import in_parallel
from limbgram.findings import Finding, note
from limbgram.reconstruction.photos.decoding import in_flight_mb, load_luma
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.targets.board import (
    KIT_DICTIONARY,
    marker_dictionary,
    parse_dictionary,
)
from limbgram.reconstruction.targets.edges import SquareFit, fit_square, linear_light

_CELL_PX = 8
"""Pixels of a cell, once a mark is laid flat, of which its colour is read; and"""
_CELL_MARGIN = 0.3
"""share of the cell left out on each side. With OpenCV's 4 pixels and 0.13 one in ten of the marks
that are seen obliquely is not read (52 of 58, 52 of 57 in two captures in steps of 45 degrees); no
mark was misread."""
SEARCH_BYTES = 11.0
"""A pixel, while marks are looked for: OpenCV's copies, and four bytes of linear light."""


_ALWAYS_ALLOWED_SHIFT_PX = 2.5
"""A corner may always move so far."""


_MAX_MISFIT = 0.2
"""RMS of the grey residuals over the contrast, of the worst side."""
_MAX_SHIFT_SIDES = 0.12
"""Farthest that the fit may move a corner from where OpenCV saw it, in sides."""
_MIN_CONTRAST = 6.0
"""Half the step from black to white, of 255 in linear light."""


@dataclass(frozen=True, kw_only=True)
class MarkOptions:
    """When a mark is believed."""

    min_side_px: float = 14.0
    """Of the shortest side."""


DEFAULTS = MarkOptions()


@dataclass(frozen=True, kw_only=True)
class PhotoMarks:
    """The marks seen in one photo."""

    name: str
    photo_idx: int
    """Place in the PhotoSet."""
    ids: Int32[np.ndarray, " n"]
    """Codes, ascending; each stands once."""
    corners_px: Float64[np.ndarray, "n 4 2"]
    """From the mark's own top left, clockwise as printed."""
    centres_px: Float64[np.ndarray, "n 2"]
    """Where the diagonals cross."""
    sigmas_px: Float64[np.ndarray, " n"]
    """Formal sigma of one coordinate of a corner; a relative weight, no promise."""
    bent: Bool[np.ndarray, " n"]
    """Whether the mark surely lies on something round."""
    doubtful_ids: Int32[np.ndarray, " m"]
    """Marks that were read but not believed."""
    doubts: tuple[Finding, ...]
    """Why, for each doubtful mark."""


@dataclass(frozen=True, kw_only=True)
class MarkDetections:
    """Marks of one dictionary in all photos that show any."""

    dictionary: str
    photos: tuple[PhotoMarks, ...]

    @property
    def ids(self) -> tuple[int, ...]:
        """All marks that were believed somewhere."""
        return tuple(sorted({int(one) for photo in self.photos for one in photo.ids}))

    def seen_in(self, mark_id: int) -> int:
        """Photos that show a mark."""
        return sum(int((photo.ids == mark_id).any()) for photo in self.photos)


def find_marks(
    photos: PhotoSet,
    dictionary: str = KIT_DICTIONARY,
    lenses: Sequence[Camera] = (),
    options: MarkOptions = DEFAULTS,
) -> MarkDetections:
    """Find all marks of a dictionary in all photos.

    Args:
        lenses: The lens of each photo; none: distortion is taken for bent paper.
    """
    dictionary = parse_dictionary(dictionary)
    if lenses and len(lenses) != len(photos.photos):
        raise OptionsError("board.mark.lenses", lenses=len(lenses), photos=len(photos.photos))

    def measure_in(photo_idx: int) -> PhotoMarks:
        photo = photos.photos[photo_idx]
        lens = lenses[photo_idx] if lenses else None
        found = marks_in(load_luma(photo), dictionary, lens, options)
        believed = [one for one in found if not one.doubt and one.fit is not None]
        fits = [one.fit for one in believed if one.fit is not None]
        doubtful = [one for one in found if one.doubt]
        return PhotoMarks(
            name=photo.name,
            photo_idx=photo_idx,
            ids=np.array([one.mark_id for one in believed], np.int32),
            corners_px=np.array([fit.corners_px for fit in fits]).reshape(-1, 4, 2),
            centres_px=np.array([fit.centre_px for fit in fits]).reshape(-1, 2),
            sigmas_px=np.array([float(np.mean(fit.sigmas_px)) for fit in fits]),
            bent=np.array([fit.bent for fit in fits], bool),
            doubtful_ids=np.array([one.mark_id for one in doubtful], np.int32),
            doubts=tuple(one.doubt for one in doubtful if one.doubt is not None),
        )

    each_mb = in_flight_mb(photos.photos, SEARCH_BYTES)
    seen = in_parallel(measure_in, range(len(photos.photos)), each_mb=each_mb)
    shown = tuple(one for one in seen if len(one.ids) or len(one.doubtful_ids))
    return MarkDetections(dictionary=dictionary, photos=shown)


class FoundMark(NamedTuple):
    """A mark that was read."""

    mark_id: int
    fit: SquareFit | None
    doubt: Finding | None
    """Why it is not believed; None where it is."""


def marks_in(
    luma: GreyImage,
    dictionary: str = KIT_DICTIONARY,
    camera: Camera | None = None,
    options: MarkOptions = DEFAULTS,
) -> tuple[FoundMark, ...]:
    """The marks of one picture, by their codes."""
    codes = marker_dictionary(dictionary)
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    parameters.perspectiveRemovePixelPerCell = _CELL_PX
    parameters.perspectiveRemoveIgnoredMarginPerCell = _CELL_MARGIN
    corners, ids, _ = cv2.aruco.ArucoDetector(codes, parameters).detectMarkers(luma)
    if not len(corners):
        return ()
    cells = codes.markerSize + 2
    light = linear_light(luma)
    mark_ids = [int(one) for one in np.asarray(ids).ravel()]
    found: list[FoundMark] = []
    for k in np.argsort(mark_ids, kind="stable").tolist():
        mark_id = mark_ids[k]
        corners_px = np.asarray(corners[k], float).reshape(4, 2)
        if mark_ids.count(mark_id) > 1:
            found.append(FoundMark(mark_id, None, note("board.mark.twice")))
            continue
        code = (codes.generateImageMarker(mark_id, cells) > 0).astype(np.uint8)
        fit = fit_square(light, corners_px, code, camera)
        found.append(FoundMark(mark_id, fit, _why_doubtful(corners_px, fit, options)))
    return tuple(found)


def _why_doubtful(
    square: Float64[np.ndarray, "4 2"], fit: SquareFit | None, options: MarkOptions
) -> Finding | None:
    sides_px = np.linalg.norm(square - np.roll(square, -1, axis=0), axis=1)
    if sides_px.min() < options.min_side_px:
        least_px = options.min_side_px
        return note("board.mark.small", side_px=float(sides_px.min()), least_px=least_px)
    if fit is None:
        return note("board.mark.side_unseen")
    shift_px = float(np.linalg.norm(fit.corners_px - square, axis=1).max())
    if shift_px > max(_ALWAYS_ALLOWED_SHIFT_PX, _MAX_SHIFT_SIDES * float(sides_px.mean())):
        return note("board.mark.moved", shift_px=shift_px)
    if fit.misfit > _MAX_MISFIT:
        return note("board.mark.no_edge")
    if fit.contrast < _MIN_CONTRAST:
        return note("board.corner.contrast")
    return None
