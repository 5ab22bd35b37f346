"""Targets: boards and coded marks of known size, and where they appear in photos.

In      a PhotoSet, and the Board that lies in the scene or was photographed for calibration; or
        the dictionary of the marks on bars, mats and stickers.
Out     BoardDetections, MarkDetections: sub-pixel corners with their ids, photo by photo.
"""

from limbgram.reconstruction.targets.board import (
    Board,
    BoardDetections,
    PhotoCorners,
    parse_dictionary,
    parse_size,
)
from limbgram.reconstruction.targets.finding import TargetOptions, find_board, find_in_photo
from limbgram.reconstruction.targets.marks import (
    MarkDetections,
    MarkOptions,
    PhotoMarks,
    find_marks,
)
from limbgram.reconstruction.targets.plates import MarkPlate, PrintedMark

__all__ = [
    "Board",
    "BoardDetections",
    "MarkDetections",
    "MarkOptions",
    "MarkPlate",
    "PhotoCorners",
    "PhotoMarks",
    "PrintedMark",
    "TargetOptions",
    "find_board",
    "find_in_photo",
    "find_marks",
    "parse_dictionary",
    "parse_size",
]
