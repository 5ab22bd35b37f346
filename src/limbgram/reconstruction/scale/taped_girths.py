"""Taped girths: girths taped at the capture, compared with the reconstructed surface.

A tape is the one length that owes nothing to the scale board. It was laid where two people find
the same place again: at the widest place, or so high above the printed side of the board (without
one, above the table): a board's thickness shows in no photo. It lies across the limb's own axis,
however the limb leans.

Method  sections across the long axis; a tape reads the length drawn taut round the closed outline
        that the axis goes through, or that continues that limb, at the smoothing length.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from scipy.spatial import QhullError

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Points2, Vector3
from limbgram.core.geometry.frames import plane_basis
from limbgram.core.geometry.smoothed_length import taut_length
from limbgram.core.mesh.axis import Axis, fit_axis
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.sections import Z_AXIS, contains_point, cut, outlines_of_limb
from limbgram.core.tape import PLACING_SIGMA_MM, TAPER_SHARES, tape_sigma_mm, taper_beside_mm
from limbgram.findings import Finding
from limbgram.reconstruction.scale.stated_lengths import TapedGirth

_SEARCHED = 80
_SEARCHED_AGAIN = 20
_UPRIGHT = 0.7
"""Cosine of the steepest lean at which a height above the table names a place on the limb."""


@dataclass(frozen=True)
class TapePlane:
    """The plane of a tape, normal to an axis at a distance along it."""

    axis: Axis
    along_mm: float


@dataclass(frozen=True, kw_only=True)
class TapeWitness:
    """A taped girth compared with the girth of the surface."""

    taped: TapedGirth
    measured_mm: float
    """NaN where it cannot be measured."""
    sigma_mm: float
    """Of the tape: reading, and placing where the limb tapers."""
    plane: TapePlane | None = None
    """None where it cannot be measured."""
    reason: Finding | None = None
    """Why there is no figure."""


@dataclass(frozen=True)
class TapeWitnesses:
    """All girths that were taped."""

    found: tuple[TapeWitness, ...] = ()


def hold_tapes(
    mesh: Mesh, floor_z_mm: float | None, taped: tuple[TapedGirth, ...]
) -> TapeWitnesses:
    """Compare taped girths with a surface; one that cannot be measured has a reason."""
    return TapeWitnesses(tuple(_compared(mesh, floor_z_mm, one) for one in taped))


def _compared(mesh: Mesh, floor_z_mm: float | None, taped: TapedGirth) -> TapeWitness:
    try:
        if taped.height_mm is None:
            return _at_widest(mesh, taped)
        return _at_height(mesh, floor_z_mm, taped, taped.height_mm)
    except MeasureError as error:
        nothing = float("nan")
        return TapeWitness(taped=taped, measured_mm=nothing, sigma_mm=nothing, reason=error.finding)


def _at_widest(mesh: Mesh, taped: TapedGirth) -> TapeWitness:
    """The largest girth; that of a brim is none, for the limb goes on there."""
    axis = fit_axis(mesh)
    along = mesh.vertices_mm @ axis.direction
    low, high = float(along.min()), float(along.max())
    step = (high - low) / (_SEARCHED + 1)
    places = low + step * np.arange(1, _SEARCHED + 1)
    girths = _girths(mesh, axis, places)
    known = np.flatnonzero(np.isfinite(girths))
    if len(known) < 3:
        raise MeasureError("scale.tape.torn")
    best = known[np.argmax(girths[known])]
    if best in (known[0], known[-1]):
        raise MeasureError("scale.tape.open_end")
    finer = np.linspace(places[best] - step, places[best] + step, _SEARCHED_AGAIN)
    girths = _girths(mesh, axis, finer)
    widest = int(np.nanargmax(girths))
    return TapeWitness(
        taped=taped,
        measured_mm=float(girths[widest]),
        sigma_mm=tape_sigma_mm(taped.sigma_mm, 0.0),
        plane=TapePlane(axis, float(finer[widest])),
    )


def _at_height(
    mesh: Mesh, floor_z_mm: float | None, taped: TapedGirth, height_mm: float
) -> TapeWitness:
    if floor_z_mm is None:
        raise MeasureError("scale.tape.no_table")
    axis = _upright(fit_axis(mesh))
    if axis.direction[2] < _UPRIGHT:
        raise MeasureError("scale.tape.lying")
    rise = (floor_z_mm + height_mm - axis.point_mm[2]) / axis.direction[2]
    centre = float((axis.point_mm + rise * axis.direction) @ axis.direction)
    shares = np.array(TAPER_SHARES)
    off_mm = PLACING_SIGMA_MM * np.concatenate([[0.0], -shares, shares])
    girth_mm, *near_mm = _girths(mesh, axis, centre + off_mm)
    if not np.isfinite(girth_mm):
        raise MeasureError("scale.tape.no_girth", height_mm=height_mm)
    taper_mm = max(taper_beside_mm(girth_mm, one) for one in np.reshape(near_mm, (2, -1)))
    return TapeWitness(
        taped=taped,
        measured_mm=float(girth_mm),
        sigma_mm=tape_sigma_mm(taped.sigma_mm, taper_mm),
        plane=TapePlane(axis, centre),
    )


def _upright(axis: Axis) -> Axis:
    up = axis.direction if axis.direction @ Z_AXIS >= 0 else -axis.direction
    return Axis(point_mm=axis.point_mm, direction=up, spread_mm=axis.spread_mm)


def _girths(mesh: Mesh, axis: Axis, places: np.ndarray) -> np.ndarray:
    """What a tape reads at each place along an axis; NaN where no whole loop is cut."""
    across = _across(axis.direction)
    along = mesh.vertices_mm @ axis.direction

    def rings_at(offsets_mm: Sequence[float]) -> list[list[Points2]]:
        return _outlines(mesh, axis, across, offsets_mm)

    found = rings_at(places.tolist())
    ends = float(along.min()), float(along.max())
    limb = outlines_of_limb(rings_at, ends, places.tolist(), found, axis.point_mm @ across)
    girths = np.full(len(places), np.nan)
    for at, (rings, chosen) in enumerate(zip(found, limb, strict=True)):
        if chosen is not None:
            with suppress(QhullError, ValueError):  # a scrap without an inside
                girths[at] = taut_length(rings[chosen]).value_mm
    return girths


def _outlines(
    mesh: Mesh, axis: Axis, across: np.ndarray, offsets_mm: Sequence[float]
) -> list[list[Points2]]:
    """The outermost loops at each place along an axis; none where one is torn."""
    rings: dict[float, list[Points2]] = {float(place): [] for place in offsets_mm}
    torn: set[float] = set()
    for section in cut(mesh, list(rings), axis.direction):
        if section.closed:
            rings[section.offset_mm].append(section.points_mm @ across)
        else:
            torn.add(section.offset_mm)
    return [
        []
        if place in torn
        else [
            one
            for one in found
            if not any(contains_point(o, one[0]) for o in found if o is not one)
        ]
        for place, found in rings.items()
    ]


def _across(direction: Vector3) -> np.ndarray:
    """Two units across a direction, as columns."""
    return plane_basis(direction).T
