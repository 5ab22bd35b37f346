"""Stated lengths: what the user states: distances between picked points, and taped girths."""

from dataclasses import dataclass
from typing import Literal

from limbgram.core.errors import OptionsError
from limbgram.core.tape import READING_SIGMA_MM, require_tape

LengthEnds = Literal["board", "plate", "marks", "points"]
"""What a known length lies between: corners of the scale board, marks printed on one plate, marks
whose distance somebody measured, points picked in photos."""
PRINTED: tuple[LengthEnds, ...] = ("board", "plate")
"""Those that a printer made: one makes all prints, so that no print checks another."""


@dataclass(frozen=True)
class Pick:
    """Where a point appears in a photo, in the sensor's orientation; (0, 0) is a pixel's centre."""

    photo: str
    x_px: float
    y_px: float


@dataclass(frozen=True, kw_only=True)
class KnownDistance:
    """Two points a known length apart, each picked in two or more photos."""

    label: str
    length_mm: float
    first: tuple[Pick, ...]
    second: tuple[Pick, ...]
    sigma_px: float | None = None
    """Standard deviation of one coordinate, of ends that were measured; None: picked by hand."""
    length_sigma_mm: float = 0.0
    """Standard deviation of the length itself: 0.5 to 1 mm of one that a tape read."""
    ends: tuple[str, str] = ("its first end", "its second end")
    """What the ends are called."""
    between: LengthEnds = "points"
    """Of one printer's board and plates no length checks another."""
    marks: tuple[int, ...] = ()
    """Ids of the two marks that it lies between; none of another length."""

    def __post_init__(self) -> None:
        if not 0 < self.length_mm < 1e5:
            raise OptionsError("scale.no_length", label=self.label, length_mm=self.length_mm)
        if not 0 <= self.length_sigma_mm < self.length_mm:
            raise OptionsError(
                "scale.length_sigma",
                label=self.label,
                length_mm=self.length_mm,
                sigma_mm=self.length_sigma_mm,
            )


@dataclass(frozen=True, kw_only=True)
class TapedGirth:
    """A girth as the tape read it."""

    girth_mm: float
    height_mm: float | None = None
    """Above the printed side of the board, however thick that is, or without a board above the
    table; None: at the widest place."""
    sigma_mm: float = READING_SIGMA_MM
    """Standard deviation of the reading."""

    def __post_init__(self) -> None:
        require_tape(self.girth_mm, self.sigma_mm)

    @property
    def place(self) -> str:
        if self.height_mm is None:
            return "at the widest place"
        return f"at {self.height_mm:g} mm above board or table"
