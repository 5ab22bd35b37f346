"""The board file: a board as it was printed, with the size that a steel rule found.

Whoever reads it gets the board of the true size.
"""

from dataclasses import dataclass, replace
from pathlib import Path

from limbgram.core.errors import OptionsError
from limbgram.formats.printed_size import PrintedFile, PrintedSize
from limbgram.reconstruction.targets.board import Board, BoardKind


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


_FILE = PrintedFile(
    kind="board", record=_Record, format="limbgram board", version=1, largest_bytes=100_000
)


def write_board(path: Path, board: Board, printed: PrintedSize | None = None) -> None:
    """Keep a board as it was drawn, and what was measured on its print.

    Raises:
        CaseError: another file lies there.
        ExportError: the file cannot be written.
    """
    record = _Record(
        format=_FILE.format,
        version=_FILE.version,
        kind=board.kind,
        columns=board.columns,
        rows=board.rows,
        square_mm=board.square_mm,
        marker_mm=board.marker_mm,
        dictionary=board.dictionary,
        printed=printed,
    )
    _FILE.write(path, record)


def read_board(path: Path) -> Board:
    """The board of a board file, in its true size.

    Raises:
        CaseError: there is no such file, or it is no board file, or a value cannot be.
    """
    record = _FILE.read(path)
    try:
        drawn = Board(
            kind=record.kind,
            columns=record.columns,
            rows=record.rows,
            square_mm=record.square_mm,
            marker_mm=record.marker_mm,
            dictionary=record.dictionary,
        )
        return board_as_printed(drawn, record.printed)
    except OptionsError as error:
        raise _FILE.impossible(path, error) from error


def board_as_printed(drawn: Board, printed: PrintedSize | None) -> Board:
    """A board in its true size: as it was drawn, and what was measured on its print."""
    if printed is None:
        return drawn
    return replace(
        drawn,
        square_mm=drawn.square_mm * printed.growth,
        marker_mm=drawn.marker_mm * printed.growth,
    )


def require_board_place(path: Path, printed: PrintedSize | None = None) -> None:
    """Refuse to write over what is no board file, or over a measured size with none.

    Raises:
        CaseError: another file lies there, or what was measured would be forgotten.
    """
    _FILE.require_place(path, printed)
