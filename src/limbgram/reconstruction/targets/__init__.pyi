"""Targets: its names, each imported when it is first used."""

from .board import Board, BoardDetections, PhotoCorners, parse_dictionary, parse_size
from .board_detection import find_board, find_in_photo
from .marks import MarkDetections, MarkOptions, PhotoMarks, find_marks
from .plates import MarkPlate, PrintedMark

__all__ = [
    "Board",
    "BoardDetections",
    "MarkDetections",
    "MarkOptions",
    "MarkPlate",
    "PhotoCorners",
    "PhotoMarks",
    "PrintedMark",
    "find_board",
    "find_in_photo",
    "find_marks",
    "parse_dictionary",
    "parse_size",
]
