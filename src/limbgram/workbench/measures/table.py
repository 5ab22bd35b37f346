"""The measures as tables for spreadsheets, as CSV, and as a tree for JSON.

Lengths in mm, areas in mm2, volumes in mL; every sigma is one standard deviation.
"""

from typing import Any

import numpy as np

from limbgram.core.geometry.smoothed_length import SMOOTHING_MM
from limbgram.core.spreadsheet import Cell, Decimal, Table, csv_of, several
from limbgram.core.units import MM3_PER_ML
from limbgram.findings import as_json, told
from limbgram.workbench.edits.thickness import Thickness
from limbgram.workbench.measures.lengths import Length
from limbgram.workbench.measures.levels import MEASURES, Figure
from limbgram.workbench.measures.measuring import Measures, Row
from limbgram.workbench.measures.sheet import MeasuringSheet
from limbgram.workbench.measures.tape import TapeCheck

COLUMNS = (*MEASURES, "volume_below_ml")
_DECIMALS = 4


def csv_text(measures: Measures, decimal: Decimal = "point") -> str:
    """A row for every height; sigmas stand in columns of their own if there are any.

    `others_mm` has the contours of outlines that are other limbs', separated by spaces.
    """
    return csv_of(_level_table(measures, decimal), decimal)


def tables(measures: Measures, form: MeasuringSheet | None = None) -> tuple[Table, ...]:
    """All measures as tables: one for levels, and one for each other kind that was asked for."""
    given = [
        _level_table(measures),
        _volume_table(measures),
        _length_table(measures),
        _tape_table(measures),
    ]
    if form is not None:
        given.append(form.table())
    return (*(one for one in given if one.rows), _about_table(measures))


def _level_table(measures: Measures, decimal: Decimal = "point") -> Table:
    with_sigma = any(
        figure is not None and figure.sigma is not None
        for row in measures.rows
        for figure in row.figures.values()
    )
    sigmas = [f"sigma_{name}" for name in COLUMNS] if with_sigma else []
    columns = (
        "height_mm",
        "from_reference_mm",
        "reference",
        *COLUMNS,
        *sigmas,
        "loops",
        "others_mm",
        "reason",
        "skin",
        "girths_smoothed_over_mm",
    )
    rows: list[tuple[Cell, ...]] = []
    for row in measures.rows:
        figures = _figures_by_column(row)
        values = [None if f is None else round(f.value, _DECIMALS) for f in figures]
        spreads = [None if f is None or f.sigma is None else _rounded(f.sigma) for f in figures]
        place = [round(row.height_mm, _DECIMALS), round(row.from_reference_mm, _DECIMALS)]
        others = several([round(other.contour_mm, _DECIMALS) for other in row.others], decimal)
        reason = " ".join(told(one) for one in row.reasons)
        tail = [row.loops, others, reason, measures.skin, SMOOTHING_MM]
        middle = [*values, *(spreads if with_sigma else [])]
        rows.append((*place, measures.reference_name, *middle, *tail))
    return Table(title="levels", columns=columns, rows=tuple(rows))


def _volume_table(measures: Measures) -> Table:
    """The table of volumes; an end of the surface has no height."""
    rows = tuple(
        (
            row.low_mm if np.isfinite(row.low_mm) else None,
            row.high_mm if np.isfinite(row.high_mm) else None,
            *_value_and_sigma(in_ml(row.volume_mm3)),
            " ".join(told(one) for one in row.notes),
        )
        for row in measures.volumes
    )
    columns = ("from_mm", "to_mm", "volume_ml", "sigma_volume_ml", "notes")
    return Table(title="volumes", columns=columns, rows=rows)


def _length_table(measures: Measures) -> Table:
    names = ("along_axis_mm", "straight_mm", "over_surface_mm")
    rows = tuple(
        (
            length.start,
            length.end,
            *_value_and_sigma(length.along_axis),
            *_value_and_sigma(length.straight),
            *_value_and_sigma(length.over_surface),
        )
        for length in measures.lengths
    )
    figures = (column for name in names for column in (name, f"sigma_{name}"))
    return Table(title="lengths", columns=("from", "to", *figures), rows=rows)


def _tape_table(measures: Measures) -> Table:
    rows = tuple(
        (
            check.height_mm,
            check.height_mm - measures.reference_mm,
            check.read_mm,
            *_value_and_sigma(check.measured),
            round(check.difference_mm, _DECIMALS),
            _rounded(check.sigma_mm),
            check.conflict,
        )
        for check in measures.tape
    )
    columns = ("height_mm", "from_reference_mm", "read_mm", "measured_mm", "sigma_measured_mm")
    difference = ("difference_mm", "sigma_difference_mm", "conflict")
    return Table(title="tape", columns=(*columns, *difference), rows=rows)


def _about_table(measures: Measures) -> Table:
    """The table that says what the other tables are about."""
    rows: tuple[tuple[Cell, ...], ...] = (
        ("shape", measures.limb.name),
        ("side", measures.limb.side),
        ("sock taken off [mm]", measures.limb.sock_mm),
        ("heights counted from", measures.reference_name),
        ("reference at [mm]", round(measures.reference_mm, _DECIMALS)),
        ("skin", measures.skin),
        ("girths smoothed over [mm]", SMOOTHING_MM),
        ("sigma", "one standard deviation"),
    )
    return Table(title="about", columns=("what", "value"), rows=rows)


def _value_and_sigma(figure: Figure) -> tuple[Cell, Cell]:
    sigma = None if figure.sigma is None else _rounded(figure.sigma)
    return round(figure.value, _DECIMALS), sigma


def tree(measures: Measures) -> dict[str, Any]:
    """All measures as a tree for JSON."""
    return {
        "format": "limbgram measures",
        "version": 1,
        "shape": measures.limb.name,
        "side": measures.limb.side,
        "sock_taken_off_mm": measures.limb.sock_mm,
        "bodies_left_out": measures.bodies_left_out,
        "loose_bodies": [
            {"in_limb_mm": body.place_mm.tolist(), "size_mm": body.size_mm}
            for body in measures.loose
        ],
        "skin": measures.skin,
        "wall": _wall_tree(measures.wall),
        "reference": measures.reference_name,
        "reference_height_mm": measures.reference_mm,
        "tip_height_mm": measures.tip_mm,
        "beside": None if measures.others_note is None else as_json(measures.others_note),
        "smoothed_over_mm": SMOOTHING_MM,
        "levels": [_level_tree(row) for row in measures.rows],
        "volumes": [
            {
                "from_mm": row.low_mm if np.isfinite(row.low_mm) else None,
                "to_mm": row.high_mm if np.isfinite(row.high_mm) else None,
                "volume_ml": _figure_tree(in_ml(row.volume_mm3)),
                "notes": [as_json(note) for note in row.notes],
            }
            for row in measures.volumes
        ],
        "lengths": [_length_tree(length) for length in measures.lengths],
        "tape": [_tape_tree(check, measures.reference_mm) for check in measures.tape],
    }


def _wall_tree(wall: Thickness | None) -> dict[str, Any] | None:
    if wall is None:
        return None
    return {
        "thinnest_mm": wall.thinnest_mm,
        "in_limb_mm": wall.place_mm.tolist(),
        "median_mm": wall.median_mm,
    }


def in_ml(volume_mm3: Figure) -> Figure:
    sigma = None if volume_mm3.sigma is None else volume_mm3.sigma / MM3_PER_ML
    return Figure(volume_mm3.value / MM3_PER_ML, sigma)


def _figures_by_column(row: Row) -> list[Figure | None]:
    volume = row.figures["volume_below_mm3"]
    return [
        *(row.figures[name] for name in MEASURES),
        None if volume is None else in_ml(volume),
    ]


def _level_tree(row: Row) -> dict[str, Any]:
    figures = {name: _figure_tree(figure) for name, figure in zip(COLUMNS, _figures_by_column(row))}
    return {
        "height_mm": row.height_mm,
        "from_reference_mm": row.from_reference_mm,
        **figures,
        "loops": row.loops,
        "others": [
            {
                "contour_mm": other.contour_mm,
                "area_mm2": other.area_mm2,
                "in_limb_mm": other.middle_mm.tolist(),
            }
            for other in row.others
        ],
        "reasons": [as_json(reason) for reason in row.reasons],
    }


def _length_tree(length: Length) -> dict[str, Any]:
    return {
        "from": length.start,
        "to": length.end,
        "along_axis_mm": _figure_tree(length.along_axis),
        "straight_mm": _figure_tree(length.straight),
        "over_surface_mm": _figure_tree(length.over_surface),
    }


def _tape_tree(check: TapeCheck, reference_mm: float) -> dict[str, Any]:
    return {
        "height_mm": check.height_mm,
        "from_reference_mm": check.height_mm - reference_mm,
        "read_mm": check.read_mm,
        "measured_mm": _figure_tree(check.measured),
        "difference_mm": check.difference_mm,
        "difference_share": check.difference_mm / check.read_mm,
        "difference_sigma_mm": check.sigma_mm,
        "conflict": check.conflict,
    }


def _figure_tree(figure: Figure | None) -> dict[str, float | None] | None:
    return None if figure is None else {"value": figure.value, "sigma": figure.sigma}


def _rounded(sigma: float) -> float:
    """A sigma to three significant digits."""
    return float(f"{sigma:.3g}")
