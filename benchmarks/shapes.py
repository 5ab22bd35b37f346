"""Shapes beside the generator's own limbs: feet, trunks and boxes, as radii.

In      a kind of shape and a random generator for its proportions.
Out     a Scan, as one read from a file: level radii from a long axis, then those of a dome.
Method  Sections are superellipses, and so is the dome in height: power 2 is round, 8 a box with
        rounded edges. A foot stands on its heel, toes together, without the leg; its sole is flat
        and hollow at the arch. A trunk is a child's, cut below the hips, and closed at the neck.
"""

from collections.abc import Callable
from typing import Literal

import numpy as np
from jaxtyping import Float64
from scipy.interpolate import PchipInterpolator

from limbgram.synthetic import Scan

ShapeKind = Literal["foot", "trunk", "box"]
SHAPES: tuple[ShapeKind, ...] = ("foot", "trunk", "box")
_STEP_MM = 1.5
_COLUMNS = 240
_Grid = Float64[np.ndarray, "rows columns"]
_Sections = Callable[[Float64[np.ndarray, " r"]], _Grid]
"""Radii at heights from 0 to 1."""


def shape_of(kind: ShapeKind, rng: np.random.Generator) -> Scan:
    """A shape of this kind, a tenth larger or smaller in each proportion."""
    tall, wide, deep = rng.uniform(0.9, 1.1, 3)
    match kind:
        case "foot":
            return _scan(kind, 200.0 * tall, 25.0, 3.0, lambda at: _foot(at, wide, deep))
        case "trunk":
            return _scan(kind, 210.0 * tall, 55.0, 3.0, lambda at: _trunk(at, wide, deep))
        case "box":
            return _scan(kind, 110.0 * tall, 45.0, 8.0, lambda at: _box(at, wide, deep))


def _scan(
    kind: ShapeKind,
    tube_mm: float,
    dome_mm: float,
    power: float,
    sections: _Sections,
) -> Scan:
    """Sections up to the dome's middle, and over it a dome of this height."""
    tube_rows = round(tube_mm / _STEP_MM)
    tube = sections(np.arange(tube_rows) / tube_rows)
    rim = sections(np.ones(1))
    fan_rows = round(0.5 * np.pi * float(rim.mean()) / _STEP_MM)
    up = np.linspace(0.0, 0.5 * np.pi, fan_rows)[:, None]
    dome = _joined(np.cos(up) / rim, np.sin(up) / dome_mm, power)
    dome[-1] = dome_mm
    return Scan(
        sha256=f"{kind} {tube_mm:.3f} {float(tube.mean()):.3f}",
        mm_per_unit=1.0,
        side="none",
        height_mm=tube_mm + dome_mm,
        tube_mm=tube_mm,
        tube_rows=tube_rows,
        radii_mm=np.concatenate([tube, dome]),
        anterior_rad=0.5 * np.pi,
        notes=(),
    )


def _joined(one: _Grid, other: _Grid, power: float) -> _Grid:
    """Radius of a superellipse, given what the ray's parts are of its half axes."""
    return (np.abs(one) ** power + np.abs(other) ** power) ** (-1.0 / power)


def _angles() -> Float64[np.ndarray, " c"]:
    return 2 * np.pi * np.arange(_COLUMNS) / _COLUMNS


def _along(at: Float64[np.ndarray, " r"], *values: float) -> Float64[np.ndarray, "r 1"]:
    """Values at equal steps from below upwards, joined smoothly."""
    steps = np.linspace(0.0, 1.0, len(values))
    return np.asarray(PchipInterpolator(steps, values)(at))[:, None]


def _foot(at: Float64[np.ndarray, " r"], wide: float, deep: float) -> _Grid:
    """Heel, arch, ball and toes from below upwards; the sole looks along -y."""
    across, away = np.cos(_angles()), np.sin(_angles())
    half_mm = wide * _along(at, 31.0, 34.0, 38.0, 46.0, 43.0)
    instep_mm = deep * _along(at, 40.0, 46.0, 36.0, 24.0, 15.0)
    arch = np.clip(across, 0.0, None)  # on the inner side alone
    hollow_mm = 7.0 * arch * _along(at, 0.0, 1.0, 1.0, 0.0, 0.0)
    sole_mm = deep * (_along(at, 24.0, 22.0, 20.0, 20.0, 15.0) - hollow_mm)
    upper = _joined(across / half_mm, np.clip(away, 0.0, None) / instep_mm, 2.2)
    lower = _joined(across / half_mm, np.clip(-away, 0.0, None) / sole_mm, 5.0)
    return np.where(away >= 0.0, upper, lower)


def _trunk(at: Float64[np.ndarray, " r"], wide: float, deep: float) -> _Grid:
    """Hips, waist and chest from below upwards."""
    half_mm = wide * _along(at, 112.0, 100.0, 94.0, 104.0, 100.0)
    chest_mm = deep * _along(at, 76.0, 70.0, 68.0, 78.0, 70.0)
    spine = np.exp(-((_angles() - 1.5 * np.pi) ** 2) / 0.08)
    return _joined(np.cos(_angles()) / half_mm, np.sin(_angles()) / chest_mm, 2.4) - 4.0 * spine


def _box(at: Float64[np.ndarray, " r"], wide: float, deep: float) -> _Grid:
    half_mm, other_mm = wide * 58.0, deep * 42.0
    section = _joined(np.cos(_angles())[None] / half_mm, np.sin(_angles())[None] / other_mm, 8.0)
    return np.repeat(section, len(at), axis=0)
