"""Trend: the measuring sheets of a limb's visits, and whether each measure changed.

In      shapes of one limb, aligned and of one kind, with a day for each.
Out     SheetTrend: of each measure its change, how far that may be off, and how probable it is that
        it is real; the tables that were asked for.
Fails   OptionsError: days that are not one for each shape, or all alike. MeasureError: nobody said
        the kind, shapes of several kinds or sides, or no measure that two days have.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Annotated

from limbgram.core.errors import OptionsError
from limbgram.core.files import write_bytes
from limbgram.core.request_fields import Flag
from limbgram.core.spreadsheet import Decimal, csv_of, xlsx_of
from limbgram.services.measure import SheetRequest
from limbgram.services.parse_text import DAY
from limbgram.workbench.compare.comparison import mismatch_findings
from limbgram.workbench.compare.sheets import SheetTrend, SheetVisit, follow_sheets
from limbgram.workbench.compare.skins import skins_to_compare
from limbgram.workbench.frame.landmarks import notes_but_unconfirmed
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.sheet import measuring_sheet


@dataclass(frozen=True, kw_only=True)
class TrendRequest(SheetRequest):
    """When each shape was taken, and what its measuring sheet hangs on."""

    days: Annotated[tuple[Annotated[date, DAY], ...], Flag("day")] = ()
    """Day of each shape, 2026-03-31, in their order."""


@dataclass(frozen=True, kw_only=True)
class TrendFiles:
    """What is written of it."""

    xlsx: Path | None = None
    """Write measures and visits for a spreadsheet (.xlsx), a sheet each."""
    csv: Path | None = None
    """Write the table of measures as text (CSV)."""
    decimal: Decimal = "point"
    """Decimal sign of the text; with a comma semicolons part its columns."""

    def write(self, trend: SheetTrend) -> tuple[Path, ...]:
        """The files that were asked for."""
        written: list[Path] = []
        if self.xlsx is not None:
            written.append(write_bytes(self.xlsx, xlsx_of([trend.table(), trend.visits_table()])))
        if self.csv is not None:
            written.append(write_bytes(self.csv, csv_of(trend.table(), self.decimal).encode()))
        return tuple(written)


def trend(limbs: Sequence[Limb], ask: TrendRequest) -> SheetTrend:
    """Fill in the measuring sheet of each shape, and follow its measures; of a wall its one skin
    that is compared, with a doubt.

    Raises:
        OptionsError: days that are not one for each shape, or all alike.
        MeasureError: nobody said the kind, shapes of several kinds or sides, or no measure that two
            days have.
    """
    if len(ask.days) != len(limbs):
        raise OptionsError("options.compare.days", days=len(ask.days), shapes=len(limbs))
    options = ask.of_sheet()
    limbs, walls = skins_to_compare(limbs)
    visits = [
        SheetVisit(day=day, sheet=measuring_sheet(limb, options))
        for day, limb in zip(ask.days, limbs, strict=True)
    ]
    notes = [
        *walls,
        *(one.sheet.doubt for one in visits if one.sheet.doubt is not None),
        *(one for limb in limbs for one in notes_but_unconfirmed(limb)),
    ]
    notes += [one for limb in limbs[1:] for one in mismatch_findings(limbs[0], limb)]
    return follow_sheets(visits, tuple(dict.fromkeys(notes)))
