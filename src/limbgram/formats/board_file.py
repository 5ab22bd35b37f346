"""The board file: a board as it was printed, with the size that a steel rule found.

Printers scale, mostly by less than one per cent, and everything that is measured would be as wrong.
The file holds the board as it was drawn, and the readings on the rulers that are printed with it;
whoever reads it gets the board of the true size.
"""

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from limbgram.core.errors import CaseError, OptionsError
from limbgram.core.files import json_of, read_content, write_bytes
from limbgram.core.typed import value_of
from limbgram.reconstruction.targets.board import Board, BoardKind

_FORMAT = "limbgram board"
_VERSION = 1
_LARGEST_BYTES = 100_000
_FAR = 0.05
"""A print may be this share off; beyond, the rule was misread or another page was printed to."""
_UNEQUAL = 0.001
"""Of a print's two directions against each other: as much as a scale may be wrong at all."""


@dataclass(frozen=True, kw_only=True)
class Reading:
    """A printed ruler, and what a steel rule says that it is long."""

    drawn_mm: float
    measured_mm: float

    @property
    def growth(self) -> float:
        """True size over drawn size."""
        return self.measured_mm / self.drawn_mm


@dataclass(frozen=True, kw_only=True)
class PrintedSize:
    """What was measured on a print."""

    across: Reading
    down: Reading | None = None

    def __post_init__(self) -> None:
        for way, one in (("across", self.across), ("down", self.down)):
            if one is not None and not abs(one.growth - 1) <= _FAR:
                raise OptionsError(
                    f"The ruler {way} the page was drawn {one.drawn_mm:g} mm long, and "
                    f"{one.measured_mm:g} mm were measured: more than {_FAR:.0%} off. Print at "
                    "100 % (actual size, not fitted to the page), or measure again."
                )
        if self.down is not None and abs(self.down.growth / self.across.growth - 1) > _UNEQUAL:
            raise OptionsError(
                f"The print is stretched: {self.across.growth:.4f} of its size across the page, "
                f"{self.down.growth:.4f} down it. A board must be alike both ways to "
                f"{_UNEQUAL:.1%}. Measure both rulers again, or print on another printer."
            )

    @property
    def growth(self) -> float:
        """True size over drawn size, the mean of both directions."""
        if self.down is None:
            return self.across.growth
        return (self.across.growth + self.down.growth) / 2


@dataclass(frozen=True, kw_only=True)
class _Record:
    """What stands in the file; lengths as drawn."""

    format: str
    version: int
    kind: BoardKind
    columns: int
    rows: int
    square_mm: float
    marker_mm: float
    dictionary: str
    printed: PrintedSize | None = None


def write_board(path: Path, board: Board, printed: PrintedSize | None = None) -> None:
    """Keep a board as it was drawn, and what was measured on its print.

    Raises:
        CaseError: another file lies there.
        ExportError: the file cannot be written.
    """
    require_board_place(path, printed)
    record = _Record(
        format=_FORMAT,
        version=_VERSION,
        kind=board.kind,
        columns=board.columns,
        rows=board.rows,
        square_mm=board.square_mm,
        marker_mm=board.marker_mm,
        dictionary=board.dictionary,
        printed=printed,
    )
    text = json.dumps(asdict(record), indent=1, allow_nan=False) + "\n"
    write_bytes(path, text.encode())


def read_board(path: Path) -> Board:
    """The board of a board file, in its true size.

    Raises:
        CaseError: there is no such file, or it is no board file, or a value cannot be.
    """
    content = read_content(
        path, _LARGEST_BYTES, CaseError, "A board file is made with `limbgram print`."
    )
    try:
        record = value_of(json_of(content), _Record, "the file")
    except (ValueError, OptionsError) as error:
        raise _unusable(path, str(error)) from error
    if (record.format, record.version) != (_FORMAT, _VERSION):
        raise _unusable(path, f"it is {record.format!r}, version {record.version}")
    growth = 1.0 if record.printed is None else record.printed.growth
    try:
        return Board(
            kind=record.kind,
            columns=record.columns,
            rows=record.rows,
            square_mm=record.square_mm * growth,
            marker_mm=record.marker_mm * growth,
            dictionary=record.dictionary,
        )
    except OptionsError as error:
        raise _unusable(path, str(error)) from error


def require_board_place(path: Path, printed: PrintedSize | None = None) -> None:
    """Refuse to write over what is no board file, or over a measured size with none.

    Raises:
        CaseError: another file lies there, or what was measured would be forgotten.
    """
    if not path.exists():
        return
    try:
        there = value_of(json_of(read_content(path, _LARGEST_BYTES, CaseError)), _Record)
    except (CaseError, OptionsError, ValueError) as error:
        raise CaseError(
            f"{path} is there already and is no board file: it would be lost. Choose another name "
            "by -o."
        ) from error
    if there.printed is not None and printed is None:
        raise CaseError(
            f"{path} holds the measured size of an earlier print, which would be lost. For a new "
            "print choose another name by -o, or give what its ruler measures: --measured-mm."
        )


def _unusable(path: Path, why: str) -> CaseError:
    return CaseError(f"{path} is no usable board file: {why}. Make it again: `limbgram print`.")
