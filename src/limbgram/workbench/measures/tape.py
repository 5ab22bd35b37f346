"""Tape: girths read by a clinician, compared with the shape, and the shape fitted to them.

A reading and the shape are in conflict by the rule of `core.tape`. Fitting scales the shape
about the middles of its sections, by factors that run straight from one reading to the next and
stay as they are beyond the first and the last; heights do not change. The fitted shape carries no
sigmas any more.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.geometry.arrays import Points2, Points3
from limbgram.core.notebook import brief
from limbgram.core.tape import (
    AGREES_SIGMAS,
    READING_SIGMA_MM,
    require_tape,
    sigmas_apart,
    tape_sigma_mm,
)
from limbgram.workbench.bodies import outer_bodies
from limbgram.workbench.frame.landmarks import (
    with_landmarks,
)
from limbgram.workbench.limb import AlignedLimb, Limb
from limbgram.workbench.measures.levels import AXIS_MM, Figure, Level, area_mm2, level_at, tape_mm

_ROUNDS = 30
_CONVERGED = 1e-9


@dataclass(frozen=True, kw_only=True)
class TapeReading:
    """A girth as read."""

    height_mm: float
    """From the reference of the table."""
    girth_mm: float
    sigma_mm: float = READING_SIGMA_MM
    """Standard deviation of the reading."""


@dataclass(frozen=True, kw_only=True)
class TapeCheck:
    """A tape reading compared with the shape's girth."""

    height_mm: float
    """In the limb frame."""
    read_mm: float
    measured: Figure
    sigma_mm: float
    """Standard deviation of the difference: of the tape (reading and height) and of the shape."""

    @property
    def difference_mm(self) -> float:
        """Positive where the shape is larger than the tape says."""
        return self.measured.value - self.read_mm

    @property
    def sigmas(self) -> float:
        """The difference in standard deviations of tape and shape."""
        return sigmas_apart(self.difference_mm, self.sigma_mm)

    @property
    def conflict(self) -> bool:
        return self.sigmas > AGREES_SIGMAS


@dataclass(frozen=True, kw_only=True)
class TapeChange:
    """The change that fitting made at one reading."""

    height_mm: float
    before_mm: float
    after_mm: float
    factor: float
    """Factor by which the section there was scaled."""


@dataclass(frozen=True, kw_only=True)
class TapeFit:
    """A limb fitted to tape readings, and the changes made."""

    limb: AlignedLimb
    changes: tuple[TapeChange, ...]
    largest_mm: float
    """The largest displacement of a vertex."""

    __repr__ = brief


def check_reading(
    reading: TapeReading, height_mm: float, measured: Figure, taper_mm: float
) -> TapeCheck:
    """Compare a reading with the shape's girth at that height in the limb frame.

    Args:
        taper_mm: Change of the girth over the standard deviation of the tape's height.
    """
    require_girth(reading)
    tape = tape_sigma_mm(reading.sigma_mm, taper_mm)
    return TapeCheck(
        height_mm=height_mm,
        read_mm=reading.girth_mm,
        measured=measured,
        sigma_mm=math.hypot(tape, measured.sigma or 0.0),
    )


def require_girth(reading: TapeReading) -> None:
    require_tape(reading.girth_mm, reading.sigma_mm)


def fit_to_tape(
    limb: Limb,
    readings: Sequence[TapeReading],
    reference_mm: float = 0.0,
    through_mm: tuple[float, float] = AXIS_MM,
) -> TapeFit:
    """Scale an aligned limb across its axis until its tape girths are those that were read.

    Args:
        reference_mm: Height in the limb frame from which the readings' heights count.
        through_mm: Where a line along z goes through the limb that was taped.

    Raises:
        MeasureError: a height misses the limb, or the readings cannot all be met.
    """
    for reading in readings:
        require_girth(reading)
    heights = np.array([reading.height_mm + reference_mm for reading in readings], np.float64)
    if not len(heights) or len(np.unique(heights)) < len(heights):
        raise OptionsError("tape.fit.heights")
    order = np.argsort(heights)
    heights = heights[order]
    wanted = np.array([readings[k].girth_mm for k in order])
    limb = limb.aligned()
    start = limb.mesh_in_limb
    outside = outer_bodies(start)
    outside.require_one_limb()
    skin = outside.mesh
    levels = [level_at(skin, float(height), through_mm) for height in heights]
    middles = np.stack([_centroid(level) for level in levels])
    before = np.array([tape_mm(level).value for level in levels])
    factors = wanted / before
    for _ in range(_ROUNDS):
        scaling = _Scaling(heights, middles, factors)
        scaled = skin.with_vertices(scaling.apply(skin.vertices_mm))
        taped = [level_at(scaled, float(height), through_mm) for height in heights]
        found = np.array([tape_mm(level).value for level in taped])
        if np.abs(found / wanted - 1).max() < _CONVERGED:
            break
        factors = factors * wanted / found
    else:
        raise MeasureError("tape.fit.jumps")
    changes = [
        TapeChange(height_mm=float(h), before_mm=float(b), after_mm=float(a), factor=float(f))
        for h, b, a, f in zip(heights, before, found, scaling.factors)
    ]
    vertices = scaling.apply(start.vertices_mm)
    moved = np.linalg.norm(vertices - start.vertices_mm, axis=1).max()
    fitted = _with_landmarks_moved(_unmeasured(limb.with_vertices_in_limb(vertices)), scaling)
    return TapeFit(limb=fitted, changes=tuple(changes), largest_mm=float(moved))


@dataclass(frozen=True)
class _Scaling:
    """Scale factors and their centres at heights, linear in between."""

    heights_mm: Float64[np.ndarray, " k"]
    middles_mm: Points2
    factors: Float64[np.ndarray, " k"]

    def apply(self, places_mm: Points3) -> Points3:
        z = places_mm[:, 2]
        factor = np.interp(z, self.heights_mm, self.factors)[:, None]
        middle = np.column_stack(
            [np.interp(z, self.heights_mm, self.middles_mm[:, axis]) for axis in range(2)]
        )
        return np.column_stack([middle + factor * (places_mm[:, :2] - middle), z])


def _with_landmarks_moved(limb: AlignedLimb, scaling: _Scaling) -> AlignedLimb:
    places = limb.limb_from_mesh.inverse.apply(scaling.apply(limb.landmarks_in_limb_mm))
    marks = [replace(mark, position_mm=place.copy()) for mark, place in zip(limb.landmarks, places)]
    return with_landmarks(limb, marks)


def _unmeasured(limb: AlignedLimb) -> AlignedLimb:
    """The limb without sigmas: they told of the surface that the photos measured."""
    known = limb.mesh.of_vertices(lambda one, values: None if one.kind == "number" else values)
    return limb.with_mesh(replace(limb.mesh, correlation_mm=None, **known))


def _centroid(level: Level) -> np.ndarray:
    """Centroid of a section's area."""
    area = area_mm2(level)
    points, after = level.points_mm, level.points_mm[level.after]
    doubled = points[:, 0] * after[:, 1] - after[:, 0] * points[:, 1]
    return ((points + after) * doubled[:, None]).sum(0) / (6 * area.value)
