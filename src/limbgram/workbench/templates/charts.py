"""Charts: coordinates of places on a limb that mean the same on every limb.

Up the wall a height counts from the middle of the distal dome (0) to a reference landmark (1);
round the dome it counts the angle down to the tip (-DOME). Angles run from the front (0) to the
lateral side (+90 degrees), so that a left and a right limb share a chart. A limb that bends, as a
foot with its shank, is straightened along its kind's centreline first, so that a place keeps its
height and angle whatever the joint's angle. Landmarks then pull the chart smoothly until each has
the height and angle of the template's.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.known_words import likeliest
from limbgram.workbench.anatomy.centreline import Centreline
from limbgram.workbench.anatomy.kind import BentCentreline
from limbgram.workbench.anatomy.names import landmark_named, landmarks_by_identity
from limbgram.workbench.bodies import outer_bodies
from limbgram.workbench.compare.radial import spoke_radii
from limbgram.workbench.limb import KIND_NAMED, AlignedLimb, Limb, Side

DOME = 0.4
"""Chart height of the whole dome."""
_TALL = 2.5
"""Length of a unit of chart height in radii of a limb, for distances between places."""
_PULL_REACH = 0.8
"""In radii: how far a landmark pulls."""
_FARTHEST_PULL = 0.8
"""Radians, and units of chart height: more is another place, not another limb."""
_STEEP = 0.2
"""A pulled chart must keep this part of its spacing, in every direction."""
_GRID = 0.1
"""In radii: how close the places lie at which that is asked."""
_NEAR_TIP = -0.7 * DOME
"""Below this a landmark has no angle to speak of."""
_SHORTEST_MM = 20.0
_RINGS_MM = 2.0
_SPOKES = 72

Chart = Float64[np.ndarray, "n 2"]
ChartPlace = Float64[np.ndarray, "2"]
"""Height and angle (radians) of places."""
Along = Literal["axis", "centreline"]
"""What heights count along."""
_RIGHT = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True, kw_only=True)
class LimbChart:
    """The chart of one limb, in its limb frame; heights are those of the straightened limb."""

    tip_mm: float
    """Height of the distal end."""
    dome_mm: float
    """Height of the dome's middle."""
    reference_mm: float
    lateral: float
    """1 where +X is lateral, -1 where it is medial."""
    centres: Chart
    """Of the landmarks that pull."""
    weights: Chart
    """How hard they pull."""
    curve: Centreline | None = None
    """In the limb frame; None where the limb is straight, along z."""

    def unpulled(self, points_in_limb: Points3) -> Chart:
        """Height and angle of places, without any pull."""
        x, y, z = _straightened(points_in_limb, self.curve).T
        angle = np.arctan2(self.lateral * x, y)
        wall = (z - self.dome_mm) / (self.reference_mm - self.dome_mm)
        down = np.arctan2(np.maximum(self.dome_mm - z, 0), np.hypot(x, y))
        height = np.where(z >= self.dome_mm, wall, -DOME * down / (np.pi / 2))
        return np.column_stack([height, angle])

    def places(self, points_in_limb: Points3) -> Chart:
        """Height and angle of places on the template's chart."""
        return self.with_pull(self.unpulled(points_in_limb))

    def with_pull(self, own: Chart) -> Chart:
        if not len(self.centres):
            return own
        return own + _nearness(own, self.centres) @ self.weights

    def least_stretch(self, own: Chart) -> Float64[np.ndarray, " n"]:
        """Least stretch at each place that the pulls cause; below 0 where they fold the chart."""
        rise, turn = _offsets_from_marks(own, self.centres)
        falling = -_nearness(own, self.centres) / _PULL_REACH**2
        pulls = self.weights * [_TALL, 1.0]  # all in radii, up and round
        slopes = np.stack([(falling * rise) @ pulls, (falling * np.sin(turn)) @ pulls], axis=2)
        slopes += np.eye(2)
        least = np.linalg.svd(slopes, compute_uv=False)[:, 1]
        return np.where(np.linalg.det(slopes) < 0, -least, least)


def centreline_of_kind(limb: Limb) -> BentCentreline | None:
    """The centreline by which charts of this kind go; None where they go by the long axis."""
    return None if limb.kind is None else KIND_NAMED[limb.kind].centreline


def plain_chart(limb: Limb, reference: str, along: Along) -> LimbChart:
    """The chart without any pull.

    Raises:
        MeasureError: no limb frame, no reference landmark, or one that lies too low; a landmark of
            the centreline is missing.
    """
    limb = limb.aligned()
    mark = landmark_named(reference, limb.landmarks)
    if mark is None:
        names = (one.name for one in limb.landmarks)
        raise MeasureError(
            "template.limb.no_reference",
            name=limb.name or None,
            reference=reference,
            meant=likeliest(reference, names),
        )
    curve = limb.centreline().moved(limb.limb_from_mesh) if along == "centreline" else None
    top = float(_straightened(limb.landmark_in_limb_mm(mark)[None], curve)[0, 2])
    tip, dome = _distal_dome(limb, curve, top)
    if dome is None or top - dome < _SHORTEST_MM:
        raise MeasureError(
            "template.limb.low_reference",
            name=limb.name or None,
            reference=reference,
            above_mm=top - tip,
        )
    return LimbChart(
        tip_mm=tip,
        dome_mm=dome,
        reference_mm=top,
        lateral=lateral_of(limb.side),
        centres=np.empty((0, 2)),
        weights=np.empty((0, 2)),
        curve=curve,
    )


def _straightened(points_in_limb: Points3, curve: Centreline | None) -> Points3:
    """Places of the limb after its centreline was straightened."""
    return points_in_limb if curve is None else curve.straightened(points_in_limb, _RIGHT)


def _distal_dome(
    limb: AlignedLimb, curve: Centreline | None, top: float
) -> tuple[float, float | None]:
    """Heights of the distal end and of its dome's middle; None where it is no dome."""
    in_limb = outer_bodies(limb.mesh_in_limb).mesh
    straight = in_limb.with_vertices(_straightened(in_limb.vertices_mm, curve))
    tip = float(straight.vertices_mm[:, 2].min())
    rings = np.arange(tip + _RINGS_MM, max(top, tip + 2 * _RINGS_MM), _RINGS_MM)
    radii = spoke_radii(straight, rings, _SPOKES).radii_mm
    met = np.isfinite(radii)
    mean = np.nansum(radii, axis=1) / np.maximum(np.count_nonzero(met, axis=1), 1)
    round_end = np.flatnonzero(rings - tip >= mean)
    return tip, float(rings[round_end[0]]) if len(round_end) else None


def lateral_of(side: Side) -> float:
    """Sign of X on the lateral side; +X counts as lateral on a limb without a side."""
    return -1.0 if side == "left" else 1.0


def marks_on(limb: Limb, chart: LimbChart) -> dict[str, ChartPlace]:
    """Own chart place of every landmark that has an angle, by what it is."""
    if not isinstance(limb, AlignedLimb) or not limb.landmarks:
        return {}
    marks = landmarks_by_identity(limb.landmarks)
    places = chart.unpulled(
        limb.limb_from_mesh.apply(np.stack([mark.position_mm for mark in marks.values()]))
    )
    return {one: place for one, place in zip(marks, places) if place[0] > _NEAR_TIP}


def pulled_chart(
    limb: Limb, chart: LimbChart, template_marks: Mapping[str, ChartPlace]
) -> LimbChart:
    """A plain chart, pulled until the limb's landmarks lie where the template's do.

    Raises:
        MeasureError: a landmark lies elsewhere on this limb than any pull may reach.
    """
    own = marks_on(limb, chart)
    names = sorted(set(own) & set(template_marks))
    if not names:
        return chart
    centres = np.stack([own[name] for name in names])
    wanted = np.stack([template_marks[name] for name in names]) - centres
    wanted[:, 1] = (wanted[:, 1] + np.pi) % (2 * np.pi) - np.pi
    for name, (rise, turn) in zip(names, wanted):
        if max(abs(rise), abs(turn)) > _FARTHEST_PULL:
            raise MeasureError(
                "template.limb.misplaced",
                name=limb.name or None,
                landmark=name,
                turn_deg=float(np.degrees(turn)),
                rise=float(rise),
            )
    nearness = _nearness(centres, centres) + 1e-6 * np.eye(len(names))
    weights = np.linalg.solve(nearness, wanted)
    pulled = replace(chart, centres=centres, weights=weights)
    _require_unfolded(pulled, limb.name)
    return pulled


def _offsets_from_marks(
    places: Chart, centres: Float64[np.ndarray, "k 2"]
) -> tuple[Float64[np.ndarray, "n k"], Float64[np.ndarray, "n k"]]:
    """Offsets of places from landmarks, in radii upwards and radians round."""
    apart = places[:, None] - centres
    return _TALL * apart[..., 0], apart[..., 1]


def _nearness(places: Chart, centres: Float64[np.ndarray, "k 2"]) -> Float64[np.ndarray, "n k"]:
    """Kernel weights: 1 at a landmark, falling off smoothly, periodic round the limb."""
    rise, turn = _offsets_from_marks(places, centres)
    square = rise**2 + 2 * (1 - np.cos(turn))
    return np.exp(-square / (2 * _PULL_REACH**2))


def _require_unfolded(chart: LimbChart, name: str) -> None:
    """Refuse a pull that folds the chart anywhere it acts."""
    top = float(chart.centres[:, 0].max()) + 3 * _PULL_REACH / _TALL
    heights = np.arange(-DOME, top, _GRID / _TALL)
    angles = np.linspace(-np.pi, np.pi, round(2 * np.pi / _GRID), endpoint=False)
    grid = np.stack(np.meshgrid(heights, angles, indexing="ij"), axis=-1).reshape(-1, 2)
    if chart.least_stretch(grid).min() < _STEEP:
        raise MeasureError("template.limb.order", name=name or None)
