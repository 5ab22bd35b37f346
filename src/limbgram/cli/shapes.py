"""Shapes: the words that all commands on shapes share: a file and its unit, places, directions.

A file is read as its unit says. Directions, landmarks, colours, pairs, spans and tape readings are
made of the texts of options; what cannot be meant is refused with an example.
"""

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, cast

import numpy as np
import typer
from PIL import ImageColor

from limbgram.core.errors import OptionsError
from limbgram.core.files import json_of, read_content
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.tape import read_girth
from limbgram.formats.reading import SUFFIXES, ShapeFile, read_shape
from limbgram.formats.sidecar import LIMB_FILE_ENDING
from limbgram.formats.units import mm_per_unit_of
from limbgram.workbench.limb import Landmark
from limbgram.workbench.measures.tape import TapeReading

_NAMES = [suffix[1:].upper() for suffix in SUFFIXES]
READ = f"{', '.join(_NAMES[:-1])} or {_NAMES[-1]}"
"""The formats that are read, as help says them."""
ShapeArgument = Annotated[Path, typer.Argument(help=f"The shape: {READ}.")]
AlignedShape = Annotated[Path, typer.Argument(help=f"The aligned shape: {READ}.")]
UnitOption = Annotated[
    str | None,
    typer.Option("--unit", help="Unit of the file: mm, cm, m, inch, or so many mm."),
]
UnitOfAll = Annotated[
    str | None,
    typer.Option("--unit", help="Unit of all files: mm, cm, m, inch, or so many mm."),
]


def shape_of(path: Path, unit: str | None) -> ShapeFile:
    """Read a shape; without a typed unit its limb file says it, else the file, else millimetres.

    Raises:
        OptionsError: the unit is none.
        ShapeFileError: the file cannot be read, or is no limb in that unit.
    """
    return read_shape(path, None if unit is None else mm_per_unit_of(unit))


def require_output(path: Path | None, ending: str, what: str) -> None:
    """Refuse a name that would hide what the file is, or take the place of a scan.

    Raises:
        OptionsError: the name ends otherwise than files of this kind do.
    """
    if path is not None and path.suffix.lower() != ending:
        raise OptionsError("options.output.no_name", name=path.name, what=what, ending=ending)
    if path is not None and path.name.lower().endswith(LIMB_FILE_ENDING):
        raise OptionsError("options.output.limb_file", name=path.name, what=what)


def require_no_shape(path: Path, what: str) -> None:
    """Refuse to write what is no shape under the name of one.

    Raises:
        OptionsError: the name ends as a shape's does.
    """
    if path.suffix.lower() in SUFFIXES:
        raise OptionsError("options.output.shape_name", name=path.name, what=what)


def require_apart(path: Path | None, read: Path) -> None:
    """Refuse to write over a file that is read.

    Raises:
        OptionsError: they are one file.
    """
    if path is not None and path.resolve() == read.resolve():
        raise OptionsError("options.output.takes_place", name=path.name)


_AXES = {"x": 0, "y": 1, "z": 2}
_END = "end"
_COUNTED = re.compile("[0-9]{1,4}")
"""A mark's number: thousands of digits, and digits raised above the line, are digits to Python."""
_LARGEST_NAMES = 100_000
_SHORTEST, _LARGEST = 1e-6, 1e9
"""Of a direction, and of any number: beyond, squares are no longer numbers."""


def direction(text: str | None, option: str) -> Vector3 | None:
    """A direction such as +z, -y or 0.2,-1,0."""
    if text is None:
        return None
    if len(text) == 2 and text[0] in "+-" and text[1].lower() in _AXES:
        unit = np.zeros(3)
        unit[_AXES[text[1].lower()]] = 1.0 if text[0] == "+" else -1.0
        return unit
    numbers = _numbers(text, 3)
    if numbers is None or max(map(abs, numbers)) < _SHORTEST:
        raise OptionsError("options.no_direction", text=text, option=option)
    return np.array(numbers)


def landmarks_of(texts: Sequence[str], marks: Sequence[Vector3]) -> tuple[Landmark, ...]:
    """Landmarks as NAME=X,Y,Z in mm, or NAME=#2 for the second mark that was seen."""
    return tuple(_landmark(text, marks) for text in texts)


def sticker_names(path: Path) -> dict[int, str]:
    """Landmark names by the numbers of stickers, from a JSON file such as {"12": "fibula head"}.

    Raises:
        OptionsError: it holds something else.
    """
    try:
        tree = json_of(read_content(path, _LARGEST_NAMES, OptionsError))
        if not isinstance(tree, dict):
            raise ValueError("it is no list of numbers with names")
        return dict(_named_sticker(*row) for row in cast(dict[str, Any], tree).items())
    except ValueError as error:
        raise OptionsError("options.no_stickers", path=str(path), why=str(error)) from error


def _named_sticker(number: str, name: object) -> tuple[int, str]:
    if not _COUNTED.fullmatch(number):
        raise ValueError(f"{number!r} is no number of a sticker")
    if not isinstance(name, str) or not name.strip():
        raise ValueError(f"sticker {number} has no name")
    return int(number), name.strip()


def colour_of(text: str | None) -> tuple[int, int, int] | None:
    """A colour by its English name, as #e614c8, or as 230,20,200."""
    if text is None:
        return None
    numbers = _numbers(text, 3)
    if numbers is not None and all(value in range(256) for value in numbers):
        return int(numbers[0]), int(numbers[1]), int(numbers[2])
    try:
        return ImageColor.getrgb(text)[:3]
    except ValueError as error:
        raise OptionsError("options.no_colour", text=text) from error


def asks_for_marks(texts: Sequence[str]) -> bool:
    return any(text.rpartition("=")[2].startswith("#") for text in texts)


def pair_of(text: str, option: str) -> tuple[str, str]:
    """Two names with a colon between them."""
    first, colon, second = text.partition(":")
    if not colon or not first.strip() or not second.strip():
        raise OptionsError("options.no_pair", text=text, option=option)
    return first.strip(), second.strip()


def span_of(text: str) -> tuple[float, float]:
    """Two heights in mm with a colon between them; `end` stands for the limb's end."""
    low, _, high = text.partition(":")
    ends = (
        -math.inf if low.strip() == _END else _number(low),
        math.inf if high.strip() == _END else _number(high),
    )
    if any(map(math.isnan, ends)) or not ends[0] < ends[1]:
        raise OptionsError("options.no_span", text=text)
    return ends


def reading_of(text: str) -> TapeReading:
    """A girth as HEIGHT=GIRTH in mm, or HEIGHT=GIRTH+-TOLERANCE."""
    height, _, girth = text.partition("=")
    girth_mm, sigma_mm = read_girth(girth)
    if math.isnan(_number(height)) or math.isnan(girth_mm):
        raise OptionsError("options.no_tape_reading", text=text)
    return TapeReading(height_mm=_number(height), girth_mm=girth_mm, sigma_mm=sigma_mm)


def _landmark(text: str, marks: Sequence[Vector3]) -> Landmark:
    name, _, place = text.rpartition("=")
    name = name.strip()
    if place.startswith("#") and name:
        number = int(place[1:]) if _COUNTED.fullmatch(place[1:]) else 0
        if not 1 <= number <= len(marks):
            raise OptionsError("options.no_such_mark", text=text, seen=len(marks))
        return Landmark(name=name, position_mm=marks[number - 1])
    numbers = _numbers(place, 3)
    if not name or numbers is None:
        raise OptionsError("options.no_landmark", text=text)
    return Landmark(name=name, position_mm=np.array(numbers))


def _numbers(text: str, count: int) -> list[float] | None:
    numbers = [_number(part) for part in text.split(",")]
    return numbers if len(numbers) == count and not any(map(math.isnan, numbers)) else None


def _number(text: str) -> float:
    """A number that can be of something measured, or NaN."""
    try:
        value = float(text)
    except ValueError:
        return math.nan
    return value if abs(value) <= _LARGEST else math.nan
