"""The marks file: what was printed with coded marks, and the size that a steel rule found.

It stands beside the sheet and holds the kind, its parameters, every plate with its marks as they
were drawn, and the readings on the rulers; whoever reads it gets the plates in their true size.
The places themselves are kept, so that a print of today is understood by every later version.
"""

from dataclasses import dataclass
from pathlib import Path

from limbgram.formats.printed_size import PrintedFile, PrintedSize
from limbgram.reconstruction.targets.plates import MarkPlate


@dataclass(frozen=True, kw_only=True)
class PrintedKind:
    """What was printed."""

    kind: str
    """As `limbgram print` has it."""
    title: str
    """Name and parameters, as printed on the sheet."""
    page: str
    plates: tuple[MarkPlate, ...] = ()
    printed: PrintedSize | None = None

    @property
    def true_plates(self) -> tuple[MarkPlate, ...]:
        """The plates in the size that they were printed in."""
        growth = 1.0 if self.printed is None else self.printed.growth
        return tuple(plate.grown(growth) for plate in self.plates)


@dataclass(frozen=True, kw_only=True)
class _Record:
    format: str
    version: int
    sheet: PrintedKind

    @property
    def printed(self) -> PrintedSize | None:
        return self.sheet.printed


_FILE = PrintedFile(
    kind="marks", record=_Record, format="limbgram marks", version=1, largest_bytes=1_000_000
)


def write_marks(path: Path, sheet: PrintedKind) -> None:
    """Keep what was printed, as it was drawn, and what was measured on the print.

    Raises:
        CaseError: another file lies there, or a measured size would be forgotten.
        ExportError: the file cannot be written.
    """
    _FILE.write(path, _Record(format=_FILE.format, version=_FILE.version, sheet=sheet))


def read_marks(path: Path) -> PrintedKind:
    """What a marks file holds.

    Raises:
        CaseError: there is no such file, or it is no marks file, or a value cannot be.
    """
    return _FILE.read(path).sheet


def require_marks_place(path: Path, printed: PrintedSize | None = None) -> None:
    """Refuse to write over what is no marks file, or over a measured size with none.

    Raises:
        CaseError: another file lies there, or what was measured would be forgotten.
    """
    _FILE.require_place(path, printed)
