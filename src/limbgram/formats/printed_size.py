"""Printed size: the measured size of a sheet, and the files that keep it beside the sheet.

Printers scale, mostly by less than one per cent, and every measurement would be wrong by as much. A
file holds what was drawn and the readings on the rulers that are printed with it; it never
overwrites another kind of file, nor a measured size with none.
"""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, ClassVar, Generic, Literal, Protocol, TypeVar, cast

from limbgram.core.errors import CaseError, OptionsError, reason_of
from limbgram.core.files import json_of, read_content, write_bytes
from limbgram.core.typed import value_of
from limbgram.findings import Finding, fault, note

MOST_OFF = 0.05
"""Largest deviation of a print's size, as a fraction; beyond, the rule was misread or another page
printed."""
_UNEQUAL = 0.001
"""Largest difference between a print's two directions: the largest error that a scale may have."""


@dataclass(frozen=True, kw_only=True)
class Reading:
    """A printed ruler, and what a steel rule says that it is long."""

    drawn_mm: float
    measured_mm: float

    def __post_init__(self) -> None:
        if not self.drawn_mm > 0:
            raise OptionsError("file.print.no_length", drawn_mm=self.drawn_mm)

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
            if one is not None and not abs(one.growth - 1) <= MOST_OFF:
                raise OptionsError(
                    "file.print.off",
                    way=way,
                    drawn_mm=one.drawn_mm,
                    measured_mm=one.measured_mm,
                    most_share=MOST_OFF,
                )
        if self.down is not None and abs(self.down.growth / self.across.growth - 1) > _UNEQUAL:
            raise OptionsError(
                "file.print.stretched",
                across=self.across.growth,
                down=self.down.growth,
                most_share=_UNEQUAL,
            )

    @property
    def growth(self) -> float:
        """True size over drawn size, the mean of both directions."""
        if self.down is None:
            return self.across.growth
        return (self.across.growth + self.down.growth) / 2


class PrintedRecord(Protocol):
    """What stands in such a file: a dataclass."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def format(self) -> str: ...
    @property
    def version(self) -> int: ...
    @property
    def printed(self) -> PrintedSize | None: ...


R = TypeVar("R", bound=PrintedRecord)


@dataclass(frozen=True, kw_only=True)
class PrintedFile(Generic[R]):
    """A kind of file that keeps a printed size."""

    kind: Literal["board", "marks"]
    record: type[R]
    format: str
    version: int
    largest_bytes: int

    def write(self, path: Path, record: R) -> None:
        """Keep a record.

        Raises:
            CaseError: another file lies there, or a measured size would be forgotten.
            ExportError: the file cannot be written.
        """
        self.require_place(path, record.printed)
        text = json.dumps(asdict(record), indent=1, allow_nan=False) + "\n"
        write_bytes(path, text.encode())

    def read(self, path: Path) -> R:
        """What the file holds.

        Raises:
            CaseError: there is no such file, or it is another, or a value cannot be.
        """
        advice = note("file.print.how_made", kind=self.kind)
        content = read_content(path, self.largest_bytes, CaseError, advice)
        try:
            tree = json_of(content)
            if (other := _other_format(tree, self.format)) is not None:
                raise CaseError(
                    "file.print.other_kind", path=str(path), kind=self.kind, format=other
                )
            record = value_of(tree, self.record, "the file")
        except OptionsError as error:
            raise self.impossible(path, error) from error
        except ValueError as error:
            raise self.unusable(path, reason_of(error)) from error
        if (record.format, record.version) != (self.format, self.version):
            found = fault("file.other_version", format=record.format, version=record.version)
            raise self.unusable(path, found)
        return record

    def require_place(self, path: Path, printed: PrintedSize | None = None) -> None:
        """Refuse to write over another file, or over a measured size with none.

        Raises:
            CaseError: another file lies there, or what was measured would be forgotten.
        """
        if not path.exists():
            return
        try:
            content = read_content(path, self.largest_bytes, CaseError)
            there = value_of(json_of(content), self.record)
        except (CaseError, OptionsError, ValueError) as error:
            raise CaseError("file.print.in_the_way", path=str(path), kind=self.kind) from error
        if there.printed is not None and printed is None:
            raise CaseError("file.print.measured_before", path=str(path))

    def impossible(self, path: Path, refusal: OptionsError) -> CaseError:
        """The refusal of a file with values that no sheet can have."""
        return CaseError(
            "file.print.impossible", path=str(path), kind=self.kind, why=refusal.finding
        )

    def unusable(self, path: Path, why: Finding) -> CaseError:
        return CaseError("file.print.unusable", path=str(path), kind=self.kind, why=why)


_FORMATS = ("limbgram board", "limbgram marks", "limbgram camera")
"""Formats that a refusal names."""


def _other_format(tree: object, wanted: str) -> str | None:
    """The other one of these formats that a file has; None if it has none of them."""
    said = cast(dict[object, object], tree).get("format") if isinstance(tree, dict) else None
    return said if isinstance(said, str) and said != wanted and said in _FORMATS else None
