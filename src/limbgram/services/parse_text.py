"""Parse text: directions, landmarks, colours, pairs, spans, girths, days, as people write them.

Options of the command line and files of a batch have them as texts; a request has what they mean.
What cannot be meant is refused with an example. The constants stand beside the fields of requests.
"""

import math
import re
from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import Annotated, Any, Final, Literal, cast

import numpy as np
from PIL import ImageColor

from limbgram.core.errors import OptionsError
from limbgram.core.files import json_of, read_content
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.interval import COVER
from limbgram.core.request_fields import Text, Within
from limbgram.core.tape import READING_SIGMA_MM, read_girth
from limbgram.core.typed import Mismatch, any_value_of
from limbgram.workbench.devices.device import WallZone
from limbgram.workbench.limb import Landmark
from limbgram.workbench.measures.tape import TapeReading

Direction = tuple[float, float, float]
Pair = tuple[str, str]
Value = tuple[str, float]
"""A measure by its name."""
Height = Annotated[float, Within(-5000, 5000)]
Span = tuple[Height | None, Height | None]
"""Two heights, mm; None for the limb's end."""

_AXES = {"x": 0, "y": 1, "z": 2}
_END = "end"
_FIT = "fit"
_COUNTED = re.compile("[0-9]{1,4}")
"""A mark's number: thousands of digits, and digits raised above the line, are digits to Python."""
_LARGEST_NAMES = 100_000
_SHORTEST, _LARGEST = 1e-6, 1e9
"""Of a direction, and of any number: beyond, squares are no longer numbers."""


def direction(text: str, option: str) -> Direction:
    """A direction such as +z, -y or 0.2,-1,0."""
    if len(text) == 2 and text[0] in "+-" and text[1].lower() in _AXES:
        sense = 1.0 if text[0] == "+" else -1.0
        x, y, z = (sense if k == _AXES[text[1].lower()] else 0.0 for k in range(3))
        return x, y, z
    numbers = _numbers(text, 3)
    if numbers is None or max(map(abs, numbers)) < _SHORTEST:
        raise OptionsError("options.no_direction", text=text, option=option)
    return numbers[0], numbers[1], numbers[2]


def axis_or_fit(text: str, option: str) -> Direction | Literal["fit"]:
    """A direction, or `fit`."""
    return "fit" if text == _FIT else direction(text, option)


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


def colour_of(text: str, option: str = "") -> tuple[int, int, int]:  # noqa: ARG001
    """A colour by its English name, as #e614c8, or as 230,20,200."""
    numbers = _numbers(text, 3)
    if numbers is not None and all(value in range(256) for value in numbers):
        return int(numbers[0]), int(numbers[1]), int(numbers[2])
    try:
        red, green, blue = ImageColor.getrgb(text)[:3]
    except ValueError as error:
        raise OptionsError("options.no_colour", text=text) from error
    return red, green, blue


def asks_for_marks(texts: Sequence[str]) -> bool:
    return any(text.rpartition("=")[2].startswith("#") for text in texts)


def pair_of(text: str, option: str) -> Pair:
    """Two names with a colon between them."""
    first, colon, second = text.partition(":")
    if not colon or not first.strip() or not second.strip():
        raise OptionsError("options.no_pair", text=text, option=option)
    return first.strip(), second.strip()


def span_of(text: str, option: str = "") -> Span:  # noqa: ARG001
    """Two heights in mm with a colon between them; `end` stands for the limb's end."""
    low, _, high = text.partition(":")
    first = None if low.strip() == _END else _number(low)
    last = None if high.strip() == _END else _number(high)
    if not (-math.inf if first is None else first) < (math.inf if last is None else last):
        raise OptionsError("options.no_span", text=text)  # NaN is below nothing
    return first, last


def reading_of(text: str, option: str = "") -> TapeReading:  # noqa: ARG001
    """A girth as HEIGHT=GIRTH in mm, or HEIGHT=GIRTH+-TOLERANCE."""
    height, _, girth = text.partition("=")
    girth_mm, sigma_mm = read_girth(girth)
    if math.isnan(_number(height)) or math.isnan(girth_mm):
        raise OptionsError("options.no_tape_reading", text=text)
    return TapeReading(height_mm=_number(height), girth_mm=girth_mm, sigma_mm=sigma_mm)


def weight_of(text: str, option: str = "") -> tuple[str, float]:  # noqa: ARG001
    """The weight of a landmark as NAME=0.5."""
    name, _, number = text.rpartition("=")
    try:
        return name.strip(), float(number)
    except ValueError:
        raise OptionsError("options.no_weight", text=text) from None


def value_of(text: str, option: str = "") -> Value:  # noqa: ARG001
    """A measure's value as NAME=12.5."""
    name, _, number = text.rpartition("=")
    value = _number(number)
    if not name.strip() or math.isnan(value):
        raise OptionsError("options.no_value", text=text)
    return name.strip(), value


def zone_of(text: str, option: str = "") -> WallZone:  # noqa: ARG001
    """A zone of a wall as LANDMARK=ADD:REACH in mm."""
    name, _, numbers = text.rpartition("=")
    add, _, reach = numbers.partition(":")
    parts = {"at": name.strip(), "add_mm": _number(add), "reach_mm": _number(reach)}
    try:
        if not name.strip() or math.isnan(_number(add)) or math.isnan(_number(reach)):
            raise Mismatch("it is LANDMARK=ADD:REACH")
        zone: WallZone = any_value_of(parts, WallZone)
        return zone
    except Mismatch as error:
        raise OptionsError("options.no_zone", text=text, reason=str(error)) from error


def day_of(text: str, option: str = "") -> date:  # noqa: ARG001
    """A day as 2026-03-31."""
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise OptionsError("options.no_day", text=text) from None


def _direction_text(given: Direction | Literal["fit"]) -> str:
    return given if isinstance(given, str) else ",".join(map(repr, given))


def _pair_text(given: Pair) -> str:
    return ":".join(given)


def _span_text(given: Span) -> str:
    return ":".join(_END if one is None else repr(one) for one in given)


def _reading_text(given: TapeReading) -> str:
    sure = "" if given.sigma_mm == READING_SIGMA_MM else f"+-{COVER * given.sigma_mm!r}"
    return f"{given.height_mm!r}={given.girth_mm!r}{sure}"


def _colour_text(given: tuple[int, int, int]) -> str:
    return ",".join(map(str, given))


def _weight_text(given: tuple[str, float]) -> str:
    return f"{given[0]}={given[1]!r}"


def _zone_text(given: WallZone) -> str:
    return f"{given.at}={given.add_mm!r}:{given.reach_mm!r}"


def _landmark(text: str, marks: Sequence[Vector3]) -> Landmark:
    name, _, place = text.rpartition("=")
    name = name.strip()
    if place.startswith("#") and name:
        number = int(place[1:]) if _COUNTED.fullmatch(place[1:]) else 0
        if not 1 <= number <= len(marks):
            raise OptionsError("options.no_such_mark", text=text, seen=len(marks))
        return Landmark(name=name, position_mm=marks[number - 1], placed="painted")
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


DIRECTION: Final = Text(direction, _direction_text)
AXIS: Final = Text(axis_or_fit, _direction_text)
PAIR: Final = Text(pair_of, _pair_text)
SPAN: Final = Text(span_of, _span_text)
READING: Final = Text(reading_of, _reading_text)
COLOUR: Final = Text(colour_of, _colour_text)
WEIGHT: Final = Text(weight_of, _weight_text)
ZONE: Final = Text(zone_of, _zone_text)
VALUE: Final = Text(value_of, _weight_text)
DAY: Final = Text(day_of)
