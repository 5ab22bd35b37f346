"""The marks file: what was printed with coded marks, and the size that a steel rule found.

It stands beside the sheet and holds the kind, its parameters, every plate with its marks as they
were drawn, and the readings on the rulers; whoever reads it gets the plates in their true size.
The places themselves are kept, so that a print of today is understood by every later version.
"""

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from limbgram.core.errors import CaseError, OptionsError
from limbgram.core.files import json_of, read_content, write_bytes
from limbgram.core.typed import value_of
from limbgram.formats.board_file import PrintedSize
from limbgram.reconstruction.targets.plates import MarkPlate

_FORMAT = "limbgram marks"
_VERSION = 1
_LARGEST_BYTES = 1_000_000


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


def write_marks(path: Path, sheet: PrintedKind) -> None:
    """Keep what was printed, as it was drawn, and what was measured on the print.

    Raises:
        CaseError: another file lies there, or a measured size would be forgotten.
        ExportError: the file cannot be written.
    """
    require_marks_place(path, sheet.printed)
    record = _Record(format=_FORMAT, version=_VERSION, sheet=sheet)
    write_bytes(path, (json.dumps(asdict(record), indent=1, allow_nan=False) + "\n").encode())


def read_marks(path: Path) -> PrintedKind:
    """What a marks file holds.

    Raises:
        CaseError: there is no such file, or it is no marks file, or a value cannot be.
    """
    content = read_content(
        path, _LARGEST_BYTES, CaseError, "A marks file is made with `limbgram print`."
    )
    try:
        record = value_of(json_of(content), _Record, "the file")
    except (ValueError, OptionsError) as error:
        raise _unusable(path, str(error)) from error
    if (record.format, record.version) != (_FORMAT, _VERSION):
        raise _unusable(path, f"it is {record.format!r}, version {record.version}")
    return record.sheet


def require_marks_place(path: Path, printed: PrintedSize | None = None) -> None:
    """Refuse to write over what is no marks file, or over a measured size with none.

    Raises:
        CaseError: another file lies there, or what was measured would be forgotten.
    """
    if not path.exists():
        return
    try:
        there = value_of(json_of(read_content(path, _LARGEST_BYTES, CaseError)), _Record)
    except (CaseError, OptionsError, ValueError) as error:
        raise CaseError(
            f"{path} is there already and is no marks file: it would be lost. Choose another name "
            "by -o."
        ) from error
    if there.sheet.printed is not None and printed is None:
        raise CaseError(
            f"{path} holds the measured size of an earlier print, which would be lost. For a new "
            "print choose another name by -o, or give what its ruler measures: --measured-mm."
        )


def _unusable(path: Path, why: str) -> CaseError:
    return CaseError(f"{path} is no usable marks file: {why}. Make it again: `limbgram print`.")
