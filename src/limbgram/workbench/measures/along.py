"""Along the centreline: measures of sections square to a limb's centreline, with their sigmas.

In      an aligned limb; the spacing; how well its landmarks are placed.
Out     AlongCentreline: a station at every multiple of the spacing, counted from the curve's distal
        end towards the body, and lengths between landmarks along the curve.
Method  A bent centreline comes from the kind's landmarks, as of a foot (centreline.py); for
        all others it is the straight long axis of the limb frame, so that the stations are the
        levels. The plane of a station is square to the curve; of several outlines in it the one
        that the curve goes through counts. Planes move with the landmarks that tell the curve:
        their errors count with the surface's.
Fails   MeasureError: not aligned, or a landmark of the curve is missing. A station that cannot be
        measured stands in its row with the reason.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.interval import HOLDS
from limbgram.core.notebook import brief, data_frame, html_of
from limbgram.core.spreadsheet import Cell, Table
from limbgram.findings import Finding, as_json, told
from limbgram.workbench.anatomy.centreline import Centreline
from limbgram.workbench.anatomy.directions import Anatomy
from limbgram.workbench.anatomy.landmark import USUAL, Placing
from limbgram.workbench.anatomy.names import landmarks_by_identity
from limbgram.workbench.frame.landmarks import landmark
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.levels import (
    Figure,
    ap_mm,
    area_mm2,
    contour_mm,
    ml_mm,
    tape_mm,
)
from limbgram.workbench.measures.propagation import (
    CutPlane,
    Measure,
    Propagated,
    Subject,
    measure_section,
)

STATION_MEASURES: Mapping[str, Measure] = {
    "tape_mm": tape_mm,
    "contour_mm": contour_mm,
    "ml_mm": ml_mm,
    "depth_mm": ap_mm,
    "area_mm2": area_mm2,
}
"""What is measured at a station; the depth is square to ML, on a foot from sole to instep."""
_TOUCHING_MM = 1e-6


@dataclass(frozen=True, kw_only=True)
class Station:
    """The measures at one place of the curve."""

    along_mm: float
    """From the curve's distal end, towards the body."""
    figures: Mapping[str, Figure]
    """By the names of STATION_MEASURES; empty where there is a reason."""
    reason: Finding | None = None


@dataclass(frozen=True, kw_only=True)
class LengthAlong:
    """Distance of two landmarks along the curve; positive if the end lies more proximal."""

    start: str
    end: str
    length_mm: Figure


@dataclass(frozen=True, kw_only=True)
class AlongCentreline:
    """The measures along a centreline: stations and lengths."""

    bends: bool
    """Whether the kind has a centreline of its own; otherwise it is the long axis."""
    stations: tuple[Station, ...]
    lengths: tuple[LengthAlong, ...]

    __repr__ = brief

    def table(self, language: str = "en") -> Table:
        """A row for each station; every figure with its sigma."""
        rows: list[tuple[Cell, ...]] = []
        for one in self.stations:
            cells: list[Cell] = []
            for name in STATION_MEASURES:
                figure = one.figures.get(name)
                cells += [None, None] if figure is None else [figure.value, figure.sigma]
            why = None if one.reason is None else told(one.reason, language)
            rows.append((one.along_mm, *cells, why))
        heads = [head for name in STATION_MEASURES for head in (name, f"sigma_{name}")]
        return Table(
            title="along the centreline", columns=("along_mm", *heads, "reason"), rows=tuple(rows)
        )

    def tables(self) -> tuple[Table, ...]:
        """The stations and, where they were asked for, the lengths."""
        lengths = Table(
            title="lengths along the centreline",
            columns=("start", "end", "length_mm", "sigma_length_mm"),
            rows=tuple(
                (one.start, one.end, one.length_mm.value, one.length_mm.sigma)
                for one in self.lengths
            ),
        )
        return (self.table(), *((lengths,) if self.lengths else ()))

    def to_frame(self) -> Any:
        """A pandas.DataFrame with a row for each station.

        Raises:
            MissingError: pandas is not installed.
        """
        return data_frame(self.table())

    def _repr_html_(self) -> str:
        """The stations with ±, for notebooks."""
        rows = tuple(
            (
                one.along_mm,
                *(
                    one.figures[name].with_interval if one.figures else ""
                    for name in STATION_MEASURES
                ),
                None if one.reason is None else told(one.reason),
            )
            for one in self.stations
        )
        table = Table(
            title="stations", columns=("along_mm", *STATION_MEASURES, "reason"), rows=rows
        )
        return html_of(table, f"across the centreline, mm; {HOLDS}")


def measure_along(
    limb: Limb,
    spacing_mm: float = 10.0,
    lengths: Sequence[tuple[str, str]] = (),
    placing: Placing = USUAL,
) -> AlongCentreline:
    """Measure a limb across its centreline.

    Args:
        spacing_mm: Between stations.
        lengths: Pairs of landmarks.

    Raises:
        MeasureError: not aligned, several limbs, or a landmark of the curve is missing.
        OptionsError: a spacing that is none.
    """
    if not 0 < spacing_mm < math.inf:
        raise OptionsError("measure.spacing.not_positive", spacing_mm=spacing_mm)
    right = limb.aligned().limb_from_mesh.rotation[0]
    subject = Subject.of(limb, placing)
    centreline = limb.with_mesh(subject.sigmas.mesh).centreline()
    bends = subject.anatomy.kind.centreline is not None

    def centreline_of(anatomy: Anatomy) -> Centreline:
        return anatomy.centreline() if bends else centreline

    reach_mm = centreline.length_mm - centreline.nearest_mm(subject.sigmas.mesh.vertices_mm)
    first = math.floor((float(reach_mm.min()) + _TOUCHING_MM) / spacing_mm) + 1
    last = math.ceil((float(reach_mm.max()) - _TOUCHING_MM) / spacing_mm) - 1
    return AlongCentreline(
        bends=bends,
        stations=tuple(
            _station(subject, centreline_of, k * spacing_mm, right) for k in range(first, last + 1)
        ),
        lengths=tuple(_length(subject, centreline_of, limb, pair) for pair in lengths),
    )


def along_tree(found: AlongCentreline) -> dict[str, Any]:
    """The table for JSON."""

    def shown(figure: Figure) -> dict[str, float | None]:
        return {"value": figure.value, "sigma": figure.sigma}

    return {
        "bends": found.bends,
        "stations": [
            {
                "along_mm": one.along_mm,
                **{name: shown(figure) for name, figure in one.figures.items()},
                "reason": None if one.reason is None else as_json(one.reason),
            }
            for one in found.stations
        ],
        "lengths": [
            {"start": one.start, "end": one.end, "length_mm": shown(one.length_mm)}
            for one in found.lengths
        ],
    }


def _station(
    subject: Subject,
    centreline_of: Callable[[Anatomy], Centreline],
    along_mm: float,
    right: Vector3,
) -> Station:
    def plane_of(anatomy: Anatomy) -> CutPlane:
        curve = centreline_of(anatomy)
        place = curve.at(curve.length_mm - along_mm)
        across_mm = right - place.direction * (right @ place.direction)
        x_axis = across_mm / np.linalg.norm(across_mm)
        rotation = np.stack([x_axis, np.cross(-place.direction, x_axis), -place.direction])
        return CutPlane(rotation=rotation, through_mm=rotation @ place.point_mm)

    try:
        propagated = measure_section(subject, plane_of, STATION_MEASURES)
    except MeasureError as error:
        return Station(along_mm=along_mm, figures={}, reason=error.finding)
    figures = {name: subject.figure(one)[0] for name, one in propagated.items()}
    return Station(along_mm=along_mm, figures=figures)


def _length(
    subject: Subject,
    centreline_of: Callable[[Anatomy], Centreline],
    limb: Limb,
    pair: tuple[str, str],
) -> LengthAlong:
    ends = [_landmark_identity(limb, name) for name in pair]

    def along_mm(anatomy: Anatomy) -> float:
        places = np.stack([anatomy.places[one] for one in ends])
        start, end = centreline_of(anatomy).nearest_mm(places).tolist()
        return start - end

    slopes = subject.slopes(lambda one: np.array([along_mm(one)]))
    by_place = {name: rows[:, 0] for name, rows in slopes.items()}
    found, _ = subject.figure(Propagated(value=along_mm(subject.anatomy), by_place=by_place))
    return LengthAlong(start=pair[0], end=pair[1], length_mm=found)


def _landmark_identity(limb: Limb, name: str) -> str:
    mark = landmark(limb, name)
    return next(key for key, one in landmarks_by_identity(limb.landmarks).items() if one is mark)
