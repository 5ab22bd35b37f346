"""Plates: rigid pieces with coded marks at known places, whose distances are known lengths.

Scale bars, floor mats and turntable rings are plates; a sticker is one with a single mark.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

from limbgram.core.errors import OptionsError
from limbgram.reconstruction.targets.board import DICTIONARIES, KIT_DICTIONARY, code_count


@dataclass(frozen=True, kw_only=True)
class PrintedMark:
    """A mark on a plate."""

    mark_id: int
    x_mm: float
    """Of its middle, to the right on the print."""
    y_mm: float
    """Downwards on the print."""


class MarkLength(NamedTuple):
    """The distance between the middles of two marks."""

    first_id: int
    second_id: int
    length_mm: float


@dataclass(frozen=True, kw_only=True)
class MarkPlate:
    """One stiff piece."""

    name: str
    side_mm: float
    """Of each mark's black square."""
    marks: tuple[PrintedMark, ...]
    dictionary: str = KIT_DICTIONARY

    def __post_init__(self) -> None:
        if self.dictionary not in DICTIONARIES:
            raise OptionsError(
                "board.plate.dictionary", plate=self.name, dictionary=self.dictionary
            )
        codes = code_count(self.dictionary)
        ids = [one.mark_id for one in self.marks]
        if not ids or len(set(ids)) < len(ids) or not all(0 <= one < codes for one in ids):
            raise OptionsError("board.plate.marks", plate=self.name, most=codes - 1)
        places = [value for one in self.marks for value in (one.x_mm, one.y_mm)]
        if not all(map(math.isfinite, places)) or not 0 < self.side_mm < 1e4:
            raise OptionsError("board.plate.lengths", plate=self.name)

    def grown(self, growth: float) -> "MarkPlate":
        """The plate as it came out of a printer that makes everything `growth` times as large."""
        return replace(
            self,
            side_mm=self.side_mm * growth,
            marks=tuple(
                replace(one, x_mm=one.x_mm * growth, y_mm=one.y_mm * growth) for one in self.marks
            ),
        )

    def lengths(self) -> tuple[MarkLength, ...]:
        """Known lengths, the longest first; no two share a mark, so that each tests the others."""
        pairs = sorted(
            (
                (-math.hypot(one.x_mm - two.x_mm, one.y_mm - two.y_mm), one.mark_id, two.mark_id)
                for k, one in enumerate(self.marks)
                for two in self.marks[k + 1 :]
            ),
        )
        used: set[int] = set()
        found: list[MarkLength] = []
        for negative_mm, first, second in pairs:
            if not {first, second} & used:
                used |= {first, second}
                found.append(MarkLength(first, second, -negative_mm))
        return tuple(found)
