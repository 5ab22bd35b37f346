"""What was printed: its measured size, and the files that keep it beside the sheet.

Printers scale, mostly by less than one per cent, and everything that is measured would be as wrong.
A file holds what was drawn and the readings on the rulers that are printed with it; it is written
over nothing else, and a measured size is not forgotten by printing again.
"""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, ClassVar, Generic, Protocol, TypeVar, cast

from limbgram.core.errors import CaseError, OptionsError
from limbgram.core.files import json_of, read_content, write_bytes
from limbgram.core.typed import value_of

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
    """A kind of such files."""

    name: str
    """As people call it, such as board file."""
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
        advice = f"A {self.name} is made with `limbgram print`."
        content = read_content(path, self.largest_bytes, CaseError, advice)
        try:
            tree = json_of(content)
            if (other := _other_kind(tree, self.format)) is not None:
                raise CaseError(f"{path} is no {self.name}: {other}")
            record = value_of(tree, self.record, "the file")
        except (ValueError, OptionsError) as error:
            raise self.unusable(path, str(error)) from error
        if (record.format, record.version) != (self.format, self.version):
            raise self.unusable(path, f"it is {record.format!r}, version {record.version}")
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
            raise CaseError(
                f"{path} is there already and is no {self.name}: it would be lost. Choose another "
                "name by -o."
            ) from error
        if there.printed is not None and printed is None:
            raise CaseError(
                f"{path} holds the measured size of an earlier print, which would be lost. For a "
                "new print choose another name by -o, or give what its ruler measures: "
                "--measured-mm."
            )

    def unusable(self, path: Path, why: str) -> CaseError:
        return CaseError(
            f"{path} is no usable {self.name}: {why}. Make it again: `limbgram print`."
        )


_KINDS = {
    "limbgram board": "it is the file of a board, which is given as --board.",
    "limbgram marks": "it is the file of bars, a mat or a ring, which are given as --marks, or of "
    "stickers or a sock, which set no scale.",
    "limbgram camera": "it is a camera file, which is given as --camera.",
}
"""What the program writes, by the name of its format, and what each is for."""


def _other_kind(tree: object, wanted: str) -> str | None:
    """What a file is instead; None where it does not say so."""
    told = cast(dict[object, object], tree).get("format") if isinstance(tree, dict) else None
    return _KINDS.get(told) if isinstance(told, str) and told != wanted else None
