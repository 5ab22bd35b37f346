"""`limbgram measure`: the table of girths, widths, areas, volumes and lengths of a shape."""

import math
from collections.abc import Iterator
from itertools import chain
from typing import Annotated, Any

import typer

from limbgram.cli.replies import Reply, answered, spoken
from limbgram.cli.request_options import asking
from limbgram.cli.shape_options import (
    AlignedShape,
    UnitOption,
    require_apart,
    require_output,
    shape_of,
)
from limbgram.core.errors import with_full_stop
from limbgram.core.geometry.smoothed_length import SMOOTHED_OVER
from limbgram.core.interval import Interval, plus_minus, what_it_means
from limbgram.core.typed import tree_of
from limbgram.findings import Finding
from limbgram.services.measure import MeasureFiles, MeasureRequest, measure
from limbgram.workbench.bodies import left_out_findings
from limbgram.workbench.frame.landmarks import notes_but_unconfirmed, unconfirmed_finding
from limbgram.workbench.limb import KIND_NAMED, Limb
from limbgram.workbench.measures.along import AlongCentreline, along_tree
from limbgram.workbench.measures.form import sheet_tree
from limbgram.workbench.measures.levels import Figure
from limbgram.workbench.measures.measuring import Measures, Row
from limbgram.workbench.measures.sheet import MeasuringSheet
from limbgram.workbench.measures.table import in_ml, tree
from limbgram.workbench.measures.tape import TapeCheck, TapeFit

_SHOWN = ("tape_mm", "contour_mm", "ml_mm", "ap_mm")
_HEADING = (
    f"{'height':>8}{'tape':>10}{'contour':>10}{'ML':>9}{'AP':>9}{'area cm2':>10}{'mL below':>10}"
)


@answered
@asking
def measure_command(
    shape: AlignedShape,
    ask: MeasureRequest,
    files: MeasureFiles,
    unit: UnitOption = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,  # noqa: ARG001
) -> Reply:
    """Measure a shape by level: girth as a taut tape and along the contour, widths, area, volume.

    Both girths are smoothed over 5 mm: finer knit and creases have no part in them. A height that
    has no answer stands in the table with the reason. Run `limbgram align` first.
    """
    require_output(files.xlsx, ".xlsx", "table")
    require_output(files.csv, ".csv", "table")
    require_output(files.sheet_csv, ".csv", "sheet")
    require_output(files.picture, ".png", "picture")
    require_output(files.walls, ".png", "map")
    require_apart(files.fit, shape)
    limb = shape_of(shape, unit).limb
    sheet = measure(limb, ask, files)
    return Reply(
        (
            *_lines(limb, sheet.measures),
            *what_it_means(_intervals(sheet.measures)),
            *_fit_lines(sheet.fitted, sheet.measures),
            *([] if sheet.along is None else _along_lines(sheet.along)),
            *([] if sheet.form is None else _form_lines(sheet.form)),
            *(f"Written: {path}" for path in sheet.written),
        ),
        {
            **tree(sheet.measures),
            "fit": _fit_tree(sheet.fitted, sheet.measures.limb),
            "along": None if sheet.along is None else along_tree(sheet.along),
            "sheet": None if sheet.form is None else sheet_tree(sheet.form),
            "written": [str(path) for path in sheet.written],
        },
    )


def _lines(limb: Limb, measures: Measures) -> list[str]:
    return [
        *(f"Note: {with_full_stop(spoken(note))}" for note in _notes(limb, measures)),
        *(
            f"Note: {with_full_stop(spoken(one))}"
            for one in left_out_findings(
                measures.bodies_left_out,
                measures.loose,
                frame="limb",
                done="not measured",
            )
        ),
        *_skin_lines(measures),
        f"Heights in mm from {measures.reference_phrase}; lengths in mm; girths {SMOOTHED_OVER}. "
        + _sock_line(limb.sock_mm, measures.limb.sock_mm),
        _HEADING,
        *(_row_line(row) for row in measures.rows),
        *([] if measures.others_note is None else [spoken(measures.others_note)]),
        *(
            f"Volume from {_end(row.low_mm)} to {_end(row.high_mm)}: "
            f"{_text(in_ml(row.volume_mm3), 2)} mL"
            + "".join(f". {spoken(one)}" for one in row.notes)
            for row in measures.volumes
        ),
        *(
            f"{length.start} to {length.end}: {_text(length.along_axis, 2)} mm along the axis, "
            f"{_text(length.straight, 2)} straight, "
            f"{_text(length.over_surface, 2)} over the surface, {SMOOTHED_OVER}"
            for length in measures.lengths
        ),
        *(_tape_line(check, measures.reference_mm) for check in measures.tape),
    ]


def _intervals(measures: Measures) -> Iterator[Interval | None]:
    """The intervals of the figures that the lines show with ±."""
    tapes = (row.figures["tape_mm"] for row in measures.rows if row.level is not None)
    lengths = ((one.along_axis, one.straight, one.over_surface) for one in measures.lengths)
    figures = chain(tapes, (row.volume_mm3 for row in measures.volumes), *lengths)
    yield from (figure.interval for figure in figures if figure is not None)
    yield from (Interval.of_sigma(check.sigma_mm) for check in measures.tape)


def _notes(limb: Limb, measures: Measures) -> Iterator[Finding]:
    """Notes of the limb; of unconfirmed landmarks only those that the table uses."""
    ends = [name for one in measures.lengths for name in (one.start, one.end)]
    said = unconfirmed_finding(limb, [*ends, *([measures.reference] if measures.reference else [])])
    if said is not None:
        yield said
    yield from notes_but_unconfirmed(limb)


def _form_lines(form: MeasuringSheet) -> Iterator[str]:
    """The measuring sheet, a figure a line."""
    side = "" if form.side == "none" else f", {form.side}"
    yield f"Measuring sheet: {KIND_NAMED[form.kind].words['en']}{side}."
    stand_ins = [row.doubt for row in form.rows if row.stand_ins]
    for said in dict.fromkeys([form.doubt, *stand_ins]):
        if said is not None:
            yield f"  {spoken(said)}"
    for row in form.rows:
        value = spoken(row.reason) if row.reason is not None else ""
        if row.figure is not None:
            value = f"{_text(row.figure, 1)} {row.unit}"
        yield f"  {row.words['en']}: {value}" + (f"   ({row.formula})" if row.formula else "")


def _along_lines(found: AlongCentreline) -> Iterator[str]:
    """A station a line, from the distal end towards the body."""
    bends = "of this kind of limb" if found.bends else "which is the straight long axis"
    yield f"Across the centreline {bends}, in mm from its distal end:"
    yield f"{'along':>8}{'tape':>10}{'contour':>10}{'ML':>9}{'depth':>9}{'area cm2':>10}"
    for one in found.stations:
        if one.reason is not None:
            yield f"{one.along_mm:8.1f}  {spoken(one.reason)}"
            continue
        figures = one.figures
        shown = zip(("tape_mm", "contour_mm", "ml_mm", "depth_mm"), (10, 10, 9, 9), strict=True)
        cells = "".join(f"{figures[name].value:{width}.1f}" for name, width in shown)
        reach = plus_minus(figures["tape_mm"].interval, 2)
        area = f"{figures['area_mm2'].value / 100:10.2f}"
        yield f"{one.along_mm:8.1f}{cells}{area}" + (f"   tape {reach}" if reach else "")
    for one in found.lengths:
        yield f"{one.start} to {one.end}: {_text(one.length_mm, 2)} mm along the centreline"


def _skin_lines(measures: Measures) -> Iterator[str]:
    """Which surface of a wall was measured, and the wall's thickness."""
    if measures.skin == "inside":
        yield "Measured: the INSIDE of the wall. Areas and volumes are of what it holds."
    if measures.skin == "outside":
        yield (
            "Measured: the OUTSIDE of a wall with two skins. Areas and volumes are of its "
            "material; --inside measures what it holds."
        )
    if measures.wall is not None:
        sentence = spoken(measures.wall.finding("limb"))
        yield f"{sentence[0].upper()}{sentence[1:]}."


def _sock_line(before_mm: float, after_mm: float) -> str:
    if not after_mm:
        return "No sock was taken off."
    if after_mm == before_mm:
        return f"{before_mm:g} mm of sock were off this shape already; nothing more was taken off."
    had = f", {before_mm:g} mm of them before" if before_mm else ""
    return f"{after_mm:g} mm of sock are off{had}."


def _row_line(row: Row) -> str:
    start = f"{row.from_reference_mm:8.1f}"
    if row.level is None:
        return f"{start}  {' '.join(map(spoken, row.reasons))}"
    area, volume = row.figures["area_mm2"], row.figures["volume_below_mm3"]
    widths = (10, 10, 9, 9)
    cells = [f"{_value(row.figures[name]):>{width}}" for name, width in zip(_SHOWN, widths)]
    cells.append("" if area is None else f"{area.value / 100:10.2f}")
    cells.append(f"{'-':>10}" if volume is None else f"{volume.value / 1000:10.1f}")
    tape = row.figures["tape_mm"]
    reach = "" if tape is None else plus_minus(tape.interval, 2)
    spread = f"   tape {reach}" if reach else ""
    parts = f"   {row.loops} loops" if row.loops > 1 else ""
    others = " ".join(f"{other.contour_mm:.1f}" for other in row.others)
    beside = f"   beside it: {others} mm" if others else ""
    crumbs = f"   {row.level.left_out} crumbs left out" if row.level.left_out else ""
    return start + "".join(cells) + spread + parts + beside + crumbs


def _tape_line(check: TapeCheck, reference_mm: float) -> str:
    share = check.difference_mm / check.read_mm
    sure = plus_minus(Interval.of_sigma(check.sigma_mm), 1)
    verdict = "CONFLICT" if check.conflict else "agrees"
    return (
        f"Tape at {check.height_mm - reference_mm:.1f} mm: read {check.read_mm:.1f}, the shape has "
        f"{_text(check.measured, 1)} ({check.difference_mm:+z.1f} {sure} mm, {share:+z.1%}): "
        f"{verdict}"
    )


def _fit_lines(fitted: TapeFit | None, measures: Measures) -> list[str]:
    if fitted is None:
        return []
    return [
        *(
            f"Fitted at {change.height_mm - measures.reference_mm:.1f} mm: girth "
            f"{change.before_mm:.1f} to {change.after_mm:.1f} mm, scaled by {change.factor:.4f}"
            for change in fitted.changes
        ),
        f"The farthest point moved by {fitted.largest_mm:.2f} mm; beyond the first and the last "
        "reading the shape was scaled as there.",
        *(f"Note: {with_full_stop(spoken(one))}" for one in _of_fit(fitted, measures.limb)),
    ]


def _of_fit(fitted: TapeFit, before: Limb) -> tuple[Finding, ...]:
    """Notes of the fitted shape that the limb before did not have."""
    return fitted.limb.notes[len(before.notes) :]


def _fit_tree(fitted: TapeFit | None, before: Limb) -> dict[str, Any] | None:
    if fitted is None:
        return None
    return {
        "largest_move_mm": fitted.largest_mm,
        "notes": tree_of(_of_fit(fitted, before)),
        "changes": [
            {
                "height_mm": change.height_mm,
                "before_mm": change.before_mm,
                "after_mm": change.after_mm,
                "factor": change.factor,
            }
            for change in fitted.changes
        ],
    }


def _end(height_mm: float) -> str:
    return f"{height_mm:g} mm" if math.isfinite(height_mm) else "the end"


def _value(figure: Figure | None) -> str:
    return "-" if figure is None else f"{figure.value:.1f}"


def _text(figure: Figure, decimals: int) -> str:
    return f"{figure.value:.{decimals}f} {plus_minus(figure.interval, decimals)}".rstrip()
