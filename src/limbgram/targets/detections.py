"""Board detections: where the inner corners of a board appear in each photo."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int32

from limbgram.photos.photo import SetAside
from limbgram.targets.board import Board


@dataclass(frozen=True, kw_only=True)
class PhotoCorners:
    """The corners of the board seen in one photo."""

    name: str
    photo_idx: int
    """Place in the PhotoSet."""
    ids: Int32[np.ndarray, " n"]
    """Rows of `BoardDetections.corners_mm`, ascending."""
    xy_px: Float64[np.ndarray, "n 2"]
    sigmas_px: Float64[np.ndarray, " n"]
    """Formal sigma of one coordinate from the fit to the pixels; a relative weight, no promise."""
    blur_px: float
    """Median sigma of the edges' Gaussian blur."""
    step_px: float
    """Median side of a square in this photo."""
    doubtful_ids: Int32[np.ndarray, " m"]
    """Corners that were found but not believed."""
    doubtful_xy_px: Float64[np.ndarray, "m 2"]
    doubts: tuple[str, ...]
    """Why, for each doubtful corner."""


@dataclass(frozen=True, kw_only=True)
class BoardDetections:
    """One board in all photos that show it; the others are set aside with their reason."""

    board: Board
    corners_mm: Float64[np.ndarray, "n 3"]
    """All inner corners in the board frame (`Board.corners_mm`)."""
    photos: tuple[PhotoCorners, ...]
    set_aside: tuple[SetAside, ...]
    cause: str = ""
    """What is wrong with the photos, and the remedy: why, should too few show the board."""

    @property
    def corner_count(self) -> int:
        """Believed corners in all photos together."""
        return sum(len(photo.ids) for photo in self.photos)
