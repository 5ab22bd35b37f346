"""The grammar of AOP: from bytes to numbers, each refusal with its line.

Lines may end in CR, LF or CRLF, mixed. Every count is checked before memory is taken for it.
"""

import math
import re
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import ShapeFileError
from limbgram.core.files import without_mark
from limbgram.findings import Finding, fault, note
from limbgram.workbench.carving.radius_map import RadiusMap
from limbgram.workbench.limb import Side

_LARGEST_BYTES = 64 << 20
_SPOKES, _SLICES = (3, 3600), (2, 20_000)
_MOST_RADII = 20_000_000
_MOST_LANDMARKS, _MOST_POINTS = 1000, 10_000
_MOST_COMMENTS = 10_000
_LARGEST_VALUE = 1e5
"""No length or angle of a limb is larger, whatever its unit."""
_WIDER = 1.25
"""Listed spokes leave a gap if the last one lies farther from the first than this times any two."""
_SIDES: dict[str, Side] = {"LEFT": "left", "RIGHT": "right", "NONE": "none"}


@dataclass(frozen=True, kw_only=True)
class AopLandmark:
    """A point, or a line of several points, in the file's units."""

    name: str
    places: Float64[np.ndarray, "k 3"]
    """Radius (in the file's own unit), theta in degrees, z in mm."""


@dataclass(frozen=True, kw_only=True)
class AopFile:
    """The content of an AOP file, not yet interpreted."""

    comments: tuple[str, ...]
    side: Side
    landmarks: tuple[AopLandmark, ...]
    radius_map: RadiusMap
    spokes_listed: bool
    """The angles are listed one by one, not given as a spacing."""
    slices_listed: bool
    warnings: tuple[Finding, ...]


def parse_aop(content: bytes, name: str) -> AopFile:
    """Read the lines of an AOP file.

    Raises:
        ShapeFileError: with the line, what should stand there, and what does.
    """
    if len(content) > _LARGEST_BYTES:
        raise ShapeFileError("aop.large", name=name, most_mb=_LARGEST_BYTES >> 20)
    lines = _Lines(re.split(r"\r\n|\r|\n", without_mark(content).decode("latin-1")), name)
    mark = fault("aop.mark")
    if not lines.take(mark).upper().startswith("AAOP"):
        raise lines.error(mark)
    comments: list[str] = []
    while (comment := lines.take(fault("aop.comment"))).upper() != "END COMMENTS":
        comments.append(comment)
        if len(comments) > _MOST_COMMENTS:
            raise lines.error(fault("aop.end_comments"))
    if lines.take(fault("aop.system")).upper() != "CYLINDRICAL":
        raise lines.error(fault("aop.cylindrical"))
    side = _SIDES.get(lines.take(fault("aop.side")).upper())
    if side is None:
        raise lines.error(fault("aop.left_or_right"))
    count = lines.count(fault("aop.landmark_count"), (0, _MOST_LANDMARKS))
    landmarks = tuple(_landmark(lines) for _ in range(count))
    spokes = _positions(lines, "spokes", _SPOKES)
    slices = _positions(lines, "slices", _SLICES)
    radii = _radii(lines, len(slices.values), len(spokes.values))
    radius_map = RadiusMap(thetas_deg=spokes.values, z_mm=slices.values, radii_mm=radii)
    warnings = [*_turn_warnings(spokes), *lines.rest_warnings()]
    return AopFile(
        comments=tuple(one for one in comments if one.upper() != "AAOP1"),  # the mark, repeated
        side=side,
        landmarks=landmarks,
        radius_map=radius_map,
        spokes_listed=spokes.listed,
        slices_listed=slices.listed,
        warnings=tuple(warnings),
    )


class _Lines:
    """The lines of the file, and the next one to be read."""

    def __init__(self, lines: list[str], name: str) -> None:
        self._lines, self._name, self._next = lines, name, 0

    def take(self, expected: Finding) -> str:
        self._next += 1
        if self._next > len(self._lines):
            raise self.error(expected)
        return self._lines[self._next - 1].strip()

    def error(self, expected: Finding, line: int | None = None) -> ShapeFileError:
        """The refusal of a line.

        line: Number from 1; the one just read if None.
        """
        number = self._next if line is None else line
        at_end = number > len(self._lines)
        return ShapeFileError(
            "aop.line",
            name=self._name,
            line=number,
            expected=expected,
            at_end=at_end,
            found="" if at_end else self._lines[number - 1].strip()[:60],
        )

    def number(self, expected: Finding) -> float:
        text = self.take(expected)
        try:
            value = float(text)
        except ValueError as error:
            raise self.error(expected) from error
        if not math.isfinite(value) or abs(value) > _LARGEST_VALUE:
            raise self.error(fault("aop.within", what=expected, most=_LARGEST_VALUE))
        return value

    def count(self, expected: Finding, limits: tuple[int, int]) -> int:
        text = self.take(expected)
        if not re.fullmatch(r"\d{1,9}", text) or not limits[0] <= int(text) <= limits[1]:
            raise self.error(fault("aop.between", what=expected, least=limits[0], most=limits[1]))
        return int(text)

    def block(self, count: int, expected: Finding) -> list[str]:
        """The next lines together; all must be there."""
        start, self._next = self._next, self._next + count
        if self._next > len(self._lines):
            raise self.error(expected, len(self._lines) + 1)
        return self._lines[start : self._next]

    def line_of_block(self, count: int, idx: int) -> int:
        return self._next - count + idx + 1

    def rest_warnings(self) -> list[Finding]:
        left = sum(1 for line in self._lines[self._next :] if line.strip())
        return [note("aop.lines_left_out", lines=left)] if left else []


def _landmark(lines: _Lines) -> AopLandmark:
    name = lines.take(fault("aop.landmark_name"))
    count = lines.count(fault("aop.point_count"), (1, _MOST_POINTS))
    wanted = (
        fault("aop.landmark_radius"),
        fault("aop.landmark_angle"),
        fault("aop.landmark_height"),
    )
    places = [[lines.number(what) for what in wanted] for _ in range(count)]
    return AopLandmark(name=name, places=np.array(places))


@dataclass(frozen=True)
class _Positions:
    values: Float64[np.ndarray, " n"]
    listed: bool


def _positions(lines: _Lines, what: str, limits: tuple[int, int]) -> _Positions:
    """Angles or heights: given as a spacing; or a spacing of 0, then listed one by one."""
    count = lines.count(fault("aop.count", what=what), limits)
    spacing = lines.number(fault("aop.spacing", what=what))
    if spacing < 0:
        raise lines.error(fault("aop.spacing_from_0", what=what))
    if spacing > 0:
        return _Positions(spacing * np.arange(count), listed=False)
    expected = fault("aop.one_of", count=count, what=what)
    values = [lines.number(expected) for _ in range(count)]
    for idx, (before, after) in enumerate(pairwise(values)):
        if after <= before:
            raise lines.error(fault("aop.rising", what=what), lines.line_of_block(count, idx + 1))
    if what == "spokes" and values[-1] - values[0] >= 360:
        raise lines.error(fault("aop.one_turn"))
    return _Positions(np.array(values), listed=True)


def _radii(lines: _Lines, slices: int, spokes: int) -> Float64[np.ndarray, "m n"]:
    """One radius a line; a second number on a line, a value of that point, is left out."""
    count = slices * spokes
    expected = fault("aop.radius", slices=slices, spokes=spokes, most_mm=_LARGEST_VALUE)
    if count > _MOST_RADII:
        raise lines.error(fault("aop.radius_count", most=_MOST_RADII))
    rows = [line.split(None, 2) for line in lines.block(count, expected)]
    for idx, words in enumerate(rows):
        if len(words) not in (1, 2):
            raise lines.error(expected, lines.line_of_block(count, idx))
    radii = np.array([_radius(words[0]) for words in rows])
    bad = np.flatnonzero(~((radii >= 0) & (radii <= _LARGEST_VALUE)))
    if len(bad):
        raise lines.error(expected, lines.line_of_block(count, int(bad[0])))
    return radii.reshape(slices, spokes)


def _radius(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return math.nan


def _turn_warnings(spokes: _Positions) -> list[Finding]:
    count = len(spokes.values)
    if spokes.listed:
        gaps_deg = np.diff(spokes.values)
        closing_deg = 360 - float(gaps_deg.sum())
        if closing_deg <= _WIDER * float(gaps_deg.max()) + 0.5:
            return []
        return [note("aop.not_one_turn", spokes=count, spacing_deg=float(gaps_deg.mean()))]
    spacing_deg = float(spokes.values[1])
    if abs(spacing_deg * count - 360) <= 0.5:
        return []
    if spokes.values[-1] >= 360:
        return [note("aop.over_one_turn", spokes=count, spacing_deg=spacing_deg)]
    return [note("aop.not_one_turn", spokes=count, spacing_deg=spacing_deg)]
