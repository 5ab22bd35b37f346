"""Parse captures: boards, known distances, boxes, taped girths, as people write them.

Words for shapes stand in `cli.shapes`: a board brings OpenCV, and would make the start of
`measure` longer by 0.3 s of 1.3 s.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from limbgram.core.errors import OptionsError
from limbgram.core.files import json_of, read_content
from limbgram.core.tape import read_girth
from limbgram.core.typed import TOLERANT, any_value_of, value_of
from limbgram.formats.board_file import read_board
from limbgram.formats.marks_file import read_marks
from limbgram.reconstruction.scale.stated_lengths import KnownDistance, TapedGirth
from limbgram.reconstruction.targets.board import Board
from limbgram.reconstruction.targets.plates import MarkPlate

Box = tuple[tuple[float, float, float], tuple[float, float, float]]

DEFAULT_BOARD = "charuco:7x5:30:22:4X4_50"

_LARGEST_BYTES = 4_000_000

_DISTANCE_EXAMPLE = (
    '[{"label": "A-C", "length_mm": 120, '
    '"first": [{"photo": "IMG_1.jpg", "x_px": 812.5, "y_px": 400.0}, ...], "second": [...]}]'
)


@dataclass(frozen=True)
class _DistancesFile:
    distances: tuple[KnownDistance, ...]


def parse_board(text: str) -> Board:
    """A board such as charuco:7x5:30:22:4X4_50 or checkerboard:14x10:10 (mm), or a board file."""
    if names_board_file(text):
        return read_board(Path(text))
    match text.split(":"):
        case ["charuco", size, square, marker, dictionary]:
            return Board.charuco(size, _millimetres(square), _millimetres(marker), dictionary)
        case ["checkerboard", size, square]:
            return Board.checkerboard(size, _millimetres(square))
        case _:
            raise OptionsError("options.no_board", text=text, example=DEFAULT_BOARD)


def names_board_file(text: str) -> bool:
    """Whether a board is named by its file, and not by its numbers."""
    return text.lower().endswith(".json")


def plates_of(path: Path) -> tuple[MarkPlate, ...]:
    """The plates with known lengths of a marks file, in the size that was measured."""
    kept = read_marks(path)
    plates = tuple(plate for plate in kept.true_plates if len(plate.marks) > 1)
    if not plates:
        raise OptionsError("options.sheet_without_lengths", path=str(path), kind=kept.kind)
    return plates


def read_distances(path: Path) -> tuple[KnownDistance, ...]:
    """Known distances from a JSON file: a list of them, bare or under "distances"."""
    try:
        tree = json_of(read_content(path, _LARGEST_BYTES, OptionsError))
        if isinstance(tree, dict):
            return value_of(tree, _DistancesFile, strictness=TOLERANT).distances
        return any_value_of(tree, tuple[KnownDistance, ...], "distances", TOLERANT)
    except ValueError as error:
        raise OptionsError(
            "options.no_distances", path=str(path), why=str(error), example=_DISTANCE_EXAMPLE
        ) from error


def parse_box(text: str) -> Box:
    """Lowest and highest corner of a box: x,y,z,x,y,z in millimetres."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    box = box_of(numbers)
    if box is None:
        raise OptionsError("options.no_box", text=text)
    return box


def box_of(numbers: Sequence[float]) -> Box | None:
    """Six numbers as a box; None where they are none."""
    if len(numbers) != 6 or not all(map(math.isfinite, numbers)):
        return None
    low, high = numbers[:3], numbers[3:]
    if not all(a < b for a, b in zip(low, high, strict=True)):
        return None
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])


def parse_tape(text: str) -> TapedGirth:
    """A taped girth: 150=354 at a height above the board or table, widest=354 at the widest place.

    150=354+-4 states how surely it was read.
    """
    place, equals, girth = text.partition("=")
    girth_mm, sigma_mm = read_girth(girth)
    if not equals or math.isnan(girth_mm):
        raise OptionsError("options.no_taped_girth", text=text)
    height_mm = None if place.strip().lower() == "widest" else _millimetres(place)
    return TapedGirth(girth_mm=girth_mm, height_mm=height_mm, sigma_mm=sigma_mm)


def _millimetres(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise OptionsError("options.no_length", text=text)
    return value
