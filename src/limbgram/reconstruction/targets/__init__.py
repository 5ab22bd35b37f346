"""Targets: boards of known size, and where their corners appear in photos.

In      a PhotoSet, and the Board that lies in the scene or was photographed for calibration.
Out     BoardDetections: sub-pixel corners with their ids, photo by photo.
"""

from limbgram.reconstruction.targets.board import (
    Board,
    BoardDetections,
    PhotoCorners,
    parse_dictionary,
    parse_size,
)
from limbgram.reconstruction.targets.finding import TargetOptions, find_board, find_in_photo

__all__ = [
    "Board",
    "BoardDetections",
    "PhotoCorners",
    "TargetOptions",
    "find_board",
    "find_in_photo",
    "parse_dictionary",
    "parse_size",
]
