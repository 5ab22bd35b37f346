"""Repeated print: pairs of photos that the board's print joins wrongly.

In      verified pairs, and where photos show the board's corners.
Out     the pairs without those whose matches join other places of the print.
Method  A checkerboard looks alike a quarter turn or two squares further on, and where paint is
        scarce most matches of a pair lie on it. The corners that were read say where on the board
        a match lies in either photo: these places must be the same. Matches count near corners that
        both photos show, so that what stands before the board is not taken for it.
Fails   never: of a photo without corners nothing is said.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float64
from scipy.spatial import KDTree

from limbgram.core.geometry.arrays import Points2
from limbgram.reconstruction.targets.board import BoardDetections, PhotoCorners
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair

_FEWEST_CORNERS = 6
_LEAST_ACROSS_SQUARES = 1.0
"""Smallest extent of the corners: a single row does not determine the homography."""
_NEAR_SQUARES = 0.75
"""Largest distance from a detected corner, in squares; a square's centre is 0.71 from its own."""
_SAME_SQUARES = 0.5
_MAJORITY = 0.5


def without_repeated_print(pairs: Pairs, detections: BoardDetections | None) -> Pairs:
    """The pairs without those whose matches join different places of the board's print."""
    if detections is None:
        return pairs
    prints = {
        one.photo_idx: found
        for one in detections.photos
        if (found := _Print.of(one, detections)) is not None
    }

    def is_confused(pair: VerifiedPair) -> bool:
        one, other = (prints.get(k) for k in pair.matches.photos)
        if one is None or other is None:
            return False
        first, second = one.at(pair.matches.xy_first_px), other.at(pair.matches.xy_second_px)
        on_board = first.near & second.near
        apart = np.linalg.norm(first.places - second.places, axis=1) > _SAME_SQUARES
        return bool(on_board.mean() > _MAJORITY and apart[on_board].mean() > _MAJORITY)

    kept = tuple(pair for pair in pairs.verified if not is_confused(pair))
    return Pairs(kept, pairs.rejected + len(pairs.verified) - len(kept))


@dataclass(frozen=True)
class _Places:
    """Positions on the board of some pixels."""

    places: Float64[np.ndarray, "n 2"]
    """In squares."""
    near: Bool[np.ndarray, " n"]
    """Whether a detected corner is near."""


@dataclass(frozen=True)
class _Print:
    """The homography from a photo to the board's print, and its detected corners."""

    squares_from_px: Float64[np.ndarray, "3 3"]
    corners: Float64[np.ndarray, "k 2"]
    """Detected corners, in squares."""

    @classmethod
    def of(cls, shown: PhotoCorners, detections: BoardDetections) -> "_Print | None":
        if len(shown.ids) < _FEWEST_CORNERS:
            return None
        corners = detections.corners_mm[shown.ids, :2] / detections.board.square_mm
        if np.ptp(corners, axis=0).min() < _LEAST_ACROSS_SQUARES:
            return None
        return cls(cv2.findHomography(shown.xy_px.astype(float), corners)[0], corners)

    def at(self, xy_px: Points2) -> _Places:
        """Positions of some pixels on the board."""
        places = cv2.perspectiveTransform(xy_px[:, None].astype(float), self.squares_from_px)[:, 0]
        return _Places(places, KDTree(self.corners).query(places)[0] < _NEAR_SQUARES)
