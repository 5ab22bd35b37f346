"""Gauges: a ball bar and a gauge cylinder, painted and photographed like a limb.

In      a BallBar or a GaugeCylinder, and a mesh step.
Out     a Limb: the same grid of rings that a limb is, so that everything else of a capture stays.
Method  A profile of radii turned about an upright axis; then the errors of form that were asked
        for, and the lean.
Frame   world: z up from the table, millimetres; the axis starts at (0, 0, base_mm).
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import OptionsError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.synthetic.props.limb import Limb, cut_rings, limb_of_grid

_FINE_MM = 0.02
_LOBES = 3
_FACETS_MM = 0.01
"""So far a triangle of 0.7 mm lies inside a sphere of 10 mm radius at most, and some more."""


@dataclass(frozen=True, kw_only=True)
class BallBar:
    """Two spheres on a bar."""

    diameter_mm: float = 50.0
    spacing_mm: float = 150.0
    bar_mm: float = 16.0
    """Diameter of the bar."""
    foot_mm: float = 12.0
    """Bar below the lower sphere."""
    form_mm: float = 0.0
    """Three lobes round each sphere, peak to valley."""
    lean_deg: float = 0.0
    kind: Literal["ball bar"] = "ball bar"

    def __post_init__(self) -> None:
        if not (
            10 <= self.diameter_mm <= 200
            and self.diameter_mm < self.spacing_mm <= 600
            and 0 < self.bar_mm < 0.8 * self.diameter_mm
            and self.foot_mm >= 0
        ):
            raise OptionsError("made.gauge.ball_bar")
        _require_shape(self.form_mm, self.lean_deg, self.diameter_mm)


@dataclass(frozen=True, kw_only=True)
class GaugeCylinder:
    """An upright cylinder with a flat top."""

    diameter_mm: float = 100.0
    length_mm: float = 180.0
    form_mm: float = 0.0
    """Three lobes round it, peak to valley."""
    lean_deg: float = 0.0
    kind: Literal["cylinder"] = "cylinder"

    def __post_init__(self) -> None:
        if not (10 <= self.diameter_mm <= 300 and 10 <= self.length_mm <= 600):
            raise OptionsError("made.gauge.cylinder")
        _require_shape(self.form_mm, self.lean_deg, self.diameter_mm)


Gauge = BallBar | GaugeCylinder


def make_gauge(gauge: Gauge, step_mm: float, base_mm: float) -> Limb:
    """Build the gauge, standing on the stand."""
    line = _bar_profile(gauge) if isinstance(gauge, BallBar) else _cylinder_profile(gauge)
    profile = _evenly(line, step_mm)
    columns = round(2 * np.pi * profile[:, 0].max() / step_mm)
    angles = 2 * np.pi * np.arange(columns) / columns
    turn = np.stack([np.cos(angles), np.sin(angles)], -1)
    lobes = gauge.form_mm / 2 * np.cos(_LOBES * angles)
    radii = profile[:, :1] + _waviness(gauge, profile)[:, None] * lobes
    skin = np.concatenate(
        [radii[..., None] * turn, np.broadcast_to(profile[:, 1, None, None], (*radii.shape, 1))], -1
    )
    skin[-1] = skin[-1].mean(0)
    grid = np.concatenate([cut_rings(skin[0]), skin])
    rotation = _lean(gauge.lean_deg)
    grid = grid @ rotation.T
    grid[..., 2] += base_mm - grid[..., 2].min()
    return limb_of_grid(grid, len(grid) - len(skin), base_mm, "right", 0.0)


def middles_mm(gauge: BallBar, base_mm: float) -> tuple[Vector3, Vector3]:
    """Middles of the lower and the upper sphere in the world."""
    rotation = _lean(gauge.lean_deg)
    lift = base_mm + np.sin(np.radians(abs(gauge.lean_deg))) * gauge.bar_mm / 2
    lower = gauge.foot_mm + gauge.diameter_mm / 2
    first, second = (
        rotation @ np.array([0.0, 0.0, height]) + np.array([0.0, 0.0, lift])
        for height in (lower, lower + gauge.spacing_mm)
    )
    return first, second


def calibrated_values(gauge: Gauge) -> dict[str, Any]:
    """The gauge as an artefact file has it: exact, but for the facets that are rendered."""
    known = {"uncertainty_mm": _FACETS_MM, "form_mm": gauge.form_mm + _FACETS_MM}
    about = {"format": "limbgram artefact", "version": 1, "name": f"rendered {gauge.kind}"}
    if isinstance(gauge, GaugeCylinder):
        return {**about, "cylinder": {"name": "C", "diameter_mm": gauge.diameter_mm, **known}}
    spheres = [{"name": name, "diameter_mm": gauge.diameter_mm, **known} for name in "AB"]
    length = {"length_mm": gauge.spacing_mm, "uncertainty_mm": _FACETS_MM}
    return {**about, "spheres": spheres, "lengths": [{"first": "A", "second": "B", **length}]}


def _require_shape(form_mm: float, lean_deg: float, diameter_mm: float) -> None:
    if not (0 <= form_mm <= 0.1 * diameter_mm and abs(lean_deg) <= 40):
        raise OptionsError("made.gauge.form")


def _lean(lean_deg: float) -> Float64[np.ndarray, "3 3"]:
    return Rigid.from_rotation_vector(np.array([np.radians(lean_deg), 0, 0]), np.zeros(3)).rotation


def _bar_profile(bar: BallBar) -> Float64[np.ndarray, "n 2"]:
    """Radius and height: bar, sphere, bar, sphere up to its pole."""
    radius, thin = bar.diameter_mm / 2, bar.bar_mm / 2
    meets = np.arcsin(thin / radius)
    first = bar.foot_mm + radius
    lower = _arc(radius, first, np.pi - meets, meets)
    upper = _arc(radius, first + bar.spacing_mm, np.pi - meets, 0.0)
    return np.concatenate([[(thin, 0.0)], lower, upper])


def _arc(
    radius: float, height: float, start_rad: float, stop_rad: float
) -> Float64[np.ndarray, "n 2"]:
    """From one angle to another, measured from the upper pole."""
    count = int(np.ceil(radius * abs(start_rad - stop_rad) / _FINE_MM)) + 1
    angle = np.linspace(start_rad, stop_rad, count)
    return np.column_stack([radius * np.sin(angle), height + radius * np.cos(angle)])


def _cylinder_profile(gauge: GaugeCylinder) -> Float64[np.ndarray, "n 2"]:
    radius = gauge.diameter_mm / 2
    return np.array([(radius, 0.0), (radius, gauge.length_mm), (0.0, gauge.length_mm)])


def _evenly(line: Float64[np.ndarray, "n 2"], step_mm: float) -> Float64[np.ndarray, "m 2"]:
    """The same line in equal steps, with its corners."""
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    at = np.linspace(0.0, length[-1], round(length[-1] / step_mm) + 1)
    return np.column_stack([np.interp(at, length, line[:, k]) for k in range(2)])


def _waviness(gauge: Gauge, profile: Float64[np.ndarray, "n 2"]) -> Float64[np.ndarray, " n"]:
    """Which part of the lobes each ring has: all at a sphere's equator, none at its poles."""
    radius, height = profile.T
    if isinstance(gauge, GaugeCylinder):
        return radius / (gauge.diameter_mm / 2)
    first = gauge.foot_mm + gauge.diameter_mm / 2
    arms = [height - first, height - first - gauge.spacing_mm]
    nearest = np.where(np.abs(arms[0]) < np.abs(arms[1]), arms[0], arms[1])
    share = 1 - (2 * nearest / gauge.diameter_mm) ** 2
    return np.clip(share, 0.0, 1.0)
