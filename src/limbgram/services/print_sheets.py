"""Print: sheets in true size, and files that know their measured size.

In      the kind of sheet, its page and pattern, and what a steel rule reads on the print.
Out     a PDF and beside it the file of its board or marks; Printed: what was written.
Fails   names that do not fit, a lens that is half told, a size that no print has.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Final

from limbgram.core.errors import OptionsError
from limbgram.core.files import write_bytes
from limbgram.core.request_fields import Text, Within, declared
from limbgram.formats.board_file import require_board_place, write_board
from limbgram.formats.camera import read_camera
from limbgram.formats.marks_file import PrintedKind, require_marks_place, write_marks
from limbgram.formats.printed_size import PrintedSize, Reading
from limbgram.formats.sheets.kinds import KINDS, KindName, SheetOptions
from limbgram.formats.sheets.page import PageName, Sheet
from limbgram.reconstruction.targets.board import Board
from limbgram.services.parse_capture import parse_board

_FILM_MM = 36.0
"""Width of the film that focal lengths in 35 mm terms belong to."""


@dataclass(frozen=True, kw_only=True)
class PrintRequest:
    """What a sheet is like, and what was measured on its print."""

    page: PageName = "a4"
    """Paper."""
    board: Annotated[Board | None, Text(lambda text, _at: parse_board(text))] = None
    """Another board: charuco:SQUARES:SQUARE_MM:MARKER_MM:DICTIONARY or
    checkerboard:INNER_CORNERS:SQUARE_MM; without it charuco:7x5:30:22:4X4_50 or
    checkerboard:14x10:10."""
    sticker_mm: float = SheetOptions.sticker_mm
    """Side of a sticker's mark."""
    first: int = SheetOptions.first
    """Number of the first sticker."""
    pixel_mm: float | None = None
    """For the sock: mm of the limb that a pixel shows; 0.25 without it and --distance-mm."""
    distance_mm: float | None = None
    """For the sock, instead: distance of the camera, with --camera, or with --focal-35mm and
    --width-px."""
    camera: Path | None = None
    """Camera file that --distance-mm goes with."""
    focal_35mm: float | None = None
    """Focal length in 35 mm terms."""
    width_px: int | None = None
    """Pixels along the longer side of a photo."""
    seed: Annotated[int, Within(0, 2**63 - 1)] = SheetOptions.seed
    """Another seed, another sock pattern."""
    measured_mm: float | None = None
    """What a steel rule says of the printed ruler across the page, to a tenth of a mm. For the kit,
    of the scale board's: the printer makes all sheets alike."""
    measured_down_mm: float | None = None
    """The same of the ruler down the page."""

    def options(self) -> SheetOptions:
        """The options by which sheets are drawn.

        Raises:
            OptionsError: what a pixel shows is told twice, or by half.
        """
        return SheetOptions(
            board=self.board,
            sticker_mm=self.sticker_mm,
            first=self.first,
            pixel_mm=self._shown_mm(),
            distance_mm=self.distance_mm,
            seed=self.seed,
        )

    def size_of(self, sheet: Sheet) -> PrintedSize | None:
        """The size that was measured on a print of the sheet; None where nobody has.

        Raises:
            OptionsError: it was measured down alone, or can be no print of the sheet.
        """
        if self.measured_mm is None:
            if self.measured_down_mm is not None:
                raise OptionsError("options.print.measured_across")
            return None
        down_mm = self.measured_down_mm
        return PrintedSize(
            across=Reading(drawn_mm=sheet.ruler_mm, measured_mm=self.measured_mm),
            down=None
            if down_mm is None
            else Reading(drawn_mm=sheet.ruler_down_mm, measured_mm=down_mm),
        )

    def _shown_mm(self) -> float:
        """What one pixel shows, told or from distance and lens."""
        film = self.focal_35mm, self.width_px
        if self.distance_mm is None:
            if self.camera is not None or film != (None, None):
                raise OptionsError("options.print.lens_alone")
            return SheetOptions.pixel_mm if self.pixel_mm is None else self.pixel_mm
        by_lens = self.camera is not None, film != (None, None)
        by_half = film.count(None) == 1
        if self.pixel_mm is not None or sum(by_lens) != 1 or by_half or not self.distance_mm > 0:
            raise OptionsError("options.print.pixel")
        if self.camera is not None:
            return self.distance_mm / read_camera(self.camera).camera.fx
        focal_35mm, width_px = self.focal_35mm or 0.0, self.width_px or 0
        return self.distance_mm * _FILM_MM / (focal_35mm * width_px or float("nan"))


@dataclass(frozen=True, kw_only=True)
class WrittenSheet:
    """A sheet, and where it and its file were written."""

    kind: KindName
    sheet: Sheet
    path: Path
    """The PDF."""
    file: Path
    """Of its board or its marks."""


@dataclass(frozen=True, kw_only=True)
class Printed:
    """What was written."""

    sheets: tuple[WrittenSheet, ...]
    size: PrintedSize | None
    """As it was measured on the print; all sheets of a kit come out of one printer."""


def print_sheets(kind: KindName, ask: PrintRequest, out: Path | None = None) -> Printed:
    """Draw a sheet, or all of a kit, and keep beside each what is known of its size.

    Args:
        out: The PDF, or the folder of a kit; None: in the current folder, called by its kind.

    Raises:
        OptionsError: the request cannot be, asks for what the kind does not have, or the name does
            not fit it.
        CaseError: another file lies there, or a measured size would be forgotten.
    """
    options = ask.options()
    places = _places(kind, out, options)
    _require_taken(kind, ask, places)
    sheets = {name: _DRAWN[name].draw(ask.page, options) for name in places}
    size = ask.size_of(next(iter(sheets.values())))
    written = tuple(
        WrittenSheet(kind=name, sheet=sheet, path=places[name], file=_beside(places[name]))
        for name, sheet in sheets.items()
    )
    for one in written:
        require = require_marks_place if one.sheet.board is None else require_board_place
        require(one.file, size)
    for one in written:
        _keep(one, size)
    return Printed(sheets=written, size=size)


_DRAWN: Final = {one.name: one for one in KINDS}
_OF_EVERY_KIND: Final = ("page", "measured_mm", "measured_down_mm")
_OF_LENS: Final = ("camera", "focal_35mm", "width_px")
"""What goes with the distance of the camera."""


def _require_taken(kind: KindName, ask: PrintRequest, drawn: Iterable[KindName]) -> None:
    """Refuse options of other kinds than those that are drawn.

    Raises:
        OptionsError: names them, and the kinds that take them.
    """
    taken = {name for one in drawn for name in _options_of(one)}
    others = [
        one
        for one in declared(PrintRequest)
        if one.name not in taken and getattr(ask, one.name) != one.default
    ]
    if others:
        having = [one.value for one in _DRAWN if others[0].name in _options_of(one)]
        raise OptionsError(
            "ask.other_kind",
            options=tuple(f"--{one.flag}" for one in others),
            kinds=tuple(having),
            kind=kind.value,
        )


def _options_of(kind: KindName) -> tuple[str, ...]:
    takes = _DRAWN[kind].takes
    return (*_OF_EVERY_KIND, *takes, *(_OF_LENS if "distance_mm" in takes else ()))


def _places(kind: KindName, out: Path | None, options: SheetOptions) -> dict[KindName, Path]:
    """Where each sheet is written."""
    if kind is not KindName.KIT:
        place = out or Path(f"{kind.value}.pdf")
        if place.suffix.lower() != ".pdf":
            raise OptionsError("options.print.no_name", name=place.name)
        return {kind: place}
    folder = out or Path(kind.value)
    if folder.suffix:
        raise OptionsError("options.print.kit_into_folder", name=folder.name)
    if options.board is not None:
        raise OptionsError("options.print.kit_has_boards")
    return {name: folder / f"{name.value}.pdf" for name in _DRAWN}


def _beside(place: Path) -> Path:
    return place.with_suffix(".json")


def _keep(one: WrittenSheet, size: PrintedSize | None) -> None:
    """Write a sheet and the file beside it."""
    sheet = one.sheet
    one.path.parent.mkdir(parents=True, exist_ok=True)
    write_bytes(one.path, sheet.pdf)
    if sheet.board is not None:
        write_board(one.file, sheet.board, size)
        return
    kept = PrintedKind(kind=one.kind.value, title=sheet.title, page=sheet.page, plates=sheet.plates)
    write_marks(one.file, replace(kept, printed=size))
