"""Gauges: a ball bar and a gauge cylinder, in place of a limb.

In      a BallBar or a GaugeCylinder, and a mesh step.
Out     a Limb, so that everything else of a capture stays the same.
Method  A profile of radii turned about an upright axis, with errors of form, then leaned.
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
"""Bound on the sagitta of a triangle of 0.7 mm edges on a sphere of 10 mm radius."""


@dataclass(frozen=True, kw_only=True)
class BallBar:
    """Two spheres on a bar."""

    diameter_mm: float = 50.0
    spacing_mm: float = 150.0
    bar_mm: float = 16.0
    """Diameter of the bar."""
    foot_mm: float = 12.0
    """Length of the bar below the lower sphere."""
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
    exact = _bar_profile(gauge) if isinstance(gauge, BallBar) else _cylinder_profile(gauge)
    profile = _resampled(exact, step_mm)
    columns = round(2 * np.pi * profile[:, 0].max() / step_mm)
    angles = 2 * np.pi * np.arange(columns) / columns
    directions = np.stack([np.cos(angles), np.sin(angles)], -1)
    lobes = gauge.form_mm / 2 * np.cos(_LOBES * angles)
    radii = profile[:, :1] + _lobe_weights(gauge, profile)[:, None] * lobes
    skin = np.concatenate(
        [
            radii[..., None] * directions,
            np.broadcast_to(profile[:, 1, None, None], (*radii.shape, 1)),
        ],
        -1,
    )
    skin[-1] = skin[-1].mean(0)
    grid = np.concatenate([cut_rings(skin[0]), skin])
    rotation = _lean(gauge.lean_deg)
    grid = grid @ rotation.T
    grid[..., 2] += base_mm - grid[..., 2].min()
    return limb_of_grid(grid, len(grid) - len(skin), base_mm, "right", 0.0)


def sphere_centres_mm(gauge: BallBar, base_mm: float) -> tuple[Vector3, Vector3]:
    """Centres of the lower and the upper sphere in the world."""
    rotation = _lean(gauge.lean_deg)
    lift = base_mm + np.sin(np.radians(abs(gauge.lean_deg))) * gauge.bar_mm / 2
    lower = gauge.foot_mm + gauge.diameter_mm / 2
    first, second = (
        rotation @ np.array([0.0, 0.0, height]) + np.array([0.0, 0.0, lift])
        for height in (lower, lower + gauge.spacing_mm)
    )
    return first, second


def calibrated_values(gauge: Gauge) -> dict[str, Any]:
    """Content of the gauge's artefact file; its uncertainty is that of the rendered facets."""
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
    """Radius and height along bar, lower sphere, bar and upper sphere to its pole."""
    radius, thin = bar.diameter_mm / 2, bar.bar_mm / 2
    junction = np.arcsin(thin / radius)  # from the pole of a sphere, where the bar begins
    first = bar.foot_mm + radius
    lower = _arc(radius, first, np.pi - junction, junction)
    upper = _arc(radius, first + bar.spacing_mm, np.pi - junction, 0.0)
    return np.concatenate([[(thin, 0.0)], lower, upper])


def _arc(
    radius: float, height: float, start_rad: float, stop_rad: float
) -> Float64[np.ndarray, "n 2"]:
    """Radius and height along a sphere between two angles from its upper pole."""
    count = int(np.ceil(radius * abs(start_rad - stop_rad) / _FINE_MM)) + 1
    angle = np.linspace(start_rad, stop_rad, count)
    return np.column_stack([radius * np.sin(angle), height + radius * np.cos(angle)])


def _cylinder_profile(gauge: GaugeCylinder) -> Float64[np.ndarray, "n 2"]:
    radius = gauge.diameter_mm / 2
    return np.array([(radius, 0.0), (radius, gauge.length_mm), (0.0, gauge.length_mm)])


def _resampled(line: Float64[np.ndarray, "n 2"], step_mm: float) -> Float64[np.ndarray, "m 2"]:
    """A polyline at equal arc length, ends included."""
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    at = np.linspace(0.0, length[-1], round(length[-1] / step_mm) + 1)
    return np.column_stack([np.interp(at, length, line[:, k]) for k in range(2)])


def _lobe_weights(gauge: Gauge, profile: Float64[np.ndarray, "n 2"]) -> Float64[np.ndarray, " n"]:
    """Amplitude of the lobes by ring: 1 at a sphere's equator, 0 at its poles."""
    radius, height = profile.T
    if isinstance(gauge, GaugeCylinder):
        return radius / (gauge.diameter_mm / 2)
    first = gauge.foot_mm + gauge.diameter_mm / 2
    from_lower, from_upper = height - first, height - first - gauge.spacing_mm
    nearest = np.where(np.abs(from_lower) < np.abs(from_upper), from_lower, from_upper)
    return np.clip(1 - (2 * nearest / gauge.diameter_mm) ** 2, 0.0, 1.0)
