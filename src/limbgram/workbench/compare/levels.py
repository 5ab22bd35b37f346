"""Levels: girths, widths, areas and volumes of two shapes at the same heights, and what changed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from limbgram.core.errors import MeasureError
from limbgram.core.mesh.mesh import VERTEX_FIELDS, Mesh
from limbgram.core.mesh.topology import boundary_half_edges
from limbgram.findings import Finding, fault
from limbgram.workbench.compare.frames import brim_height_mm
from limbgram.workbench.measures.levels import (
    DISTAL_END,
    MEASURES,
    Figure,
    Level,
    Refused,
    Sigmas,
    Volumes,
    area_mm2,
    levels_at,
)

COMPARED = ("tape_mm", "contour_mm", "ml_mm", "ap_mm", "area_mm2")
"""What is compared at a level, by the names of the table of measures."""
PLY_SHARE = 0.011
"""Volume of one sock ply (Sanders et al.: the limit that 4 of 10 fabricators kept)."""
_CLEAR_MM = 0.5
_STEP_MM = 0.4
"""Up and down from a level to see how figures change along the axis; less than what is clear."""


@dataclass(frozen=True)
class Change:
    """A figure of both shapes, and its change."""

    first: Figure
    second: Figure

    @property
    def difference(self) -> float:
        """Second less first."""
        return self.second.value - self.first.value

    @property
    def share(self) -> float:
        """The difference as a share of the first; NaN if the first is zero."""
        return self.difference / self.first.value if self.first.value else math.nan

    @property
    def sigma(self) -> float | None:
        """Sigma of the difference; None unless both scans carry sigmas."""
        if self.first.sigma is None or self.second.sigma is None:
            return None
        return math.hypot(self.first.sigma, self.second.sigma)


@dataclass(frozen=True, kw_only=True)
class LevelChange:
    """What changed at one height."""

    height_mm: float
    measures: dict[str, Change]
    """By the names of COMPARED; empty where a shape has no whole section."""
    since_last: Change | None
    """Volume of the slab from the last level, or from the distal end, to this one, mm3."""
    reason: Finding | None
    """Why there are no measures."""
    others_mm: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())
    """Contours of other limbs at this height, of the first shape and of the second: volumes count
    them, no other figure does."""


@dataclass(frozen=True, kw_only=True)
class LevelChanges:
    """All levels, and the volume of everything between the lowest and the highest."""

    levels: tuple[LevelChange, ...]
    volume: Change | None
    """mm3; None where a surface is open in between."""
    from_mm: float | None
    """Lower bound of that volume; None for the distal end."""
    to_mm: float
    laid_sigma_mm3: float
    """Standard deviation of that volume's change from how the second was laid alone, whatever the
    scans know of their own errors; it is in the change's sigma where they do."""
    reason: Finding | None
    """Why there is no volume."""

    @property
    def plies(self) -> float | None:
        """The volume's change in sock plies: positive if the second needs fewer."""
        return None if self.volume is None else self.volume.share / PLY_SHARE


def shared_heights_mm(
    first_in_limb: Mesh, second_in_limb: Mesh, spacing_mm: float
) -> tuple[float, ...]:
    """Multiples of the spacing that lie within both shapes and below both brims.

    Raises:
        MeasureError: the shapes share no such height.
    """
    meshes = (first_in_limb, second_in_limb)
    low = max(float(mesh.vertices_mm[:, 2].min()) for mesh in meshes) + _CLEAR_MM
    high = min(brim_height_mm(mesh) for mesh in meshes) - _CLEAR_MM
    steps = np.arange(math.ceil(low / spacing_mm), math.floor(high / spacing_mm) + 1)
    if not len(steps):
        raise MeasureError("compare.levels.none_shared", spacing_mm=spacing_mm)
    return tuple(float(step) for step in steps * spacing_mm)


def changes_by_level(
    first_in_limb: Mesh,
    second_in_limb: Mesh,
    heights_mm: tuple[float, ...],
    slide_sigma_mm: float = 0.0,
) -> LevelChanges:
    """Measure both shapes at and between the same heights.

    Args:
        slide_sigma_mm: Standard deviation of where the second lies along the axis; it goes into
            the sigmas of the second's figures where it carries any.
    """
    first_in_limb, second_in_limb = equally_detailed([first_in_limb, second_in_limb])
    sigmas = Sigmas.of(first_in_limb), Sigmas.of(second_in_limb)
    volumes = Volumes.of(sigmas[0]), Volumes.of(sigmas[1])
    cuts = [levels_at(mesh, heights_mm) for mesh in (first_in_limb, second_in_limb)]
    closed = not any(_open_below(mesh) for mesh in (first_in_limb, second_in_limb))
    low = DISTAL_END if closed else heights_mm[0]
    slides = [{}] * len(heights_mm)
    if slide_sigma_mm > 0 and second_in_limb.sigma_mm is not None:
        slides = _slide_slopes(second_in_limb, heights_mm, slide_sigma_mm)
    lost = [slide_sigma_mm * _area_mm2(cut, volumes[1]) for cut in cuts[1]]
    laid_mm3 = abs(lost[-1] - (0 if closed else lost[0]))
    volume = _volume(volumes, low, heights_mm[-1], laid_mm3)
    levels: list[LevelChange] = []
    below = 0.0
    for height, one, two, slide, above in zip(heights_mm, *cuts, slides, lost):
        slab = _volume(volumes, low, height, above - below) if height > low else None
        slab = slab if isinstance(slab, Change) else None
        levels.append(_level(sigmas, one, two, slab, slide))
        low, below = height, above
    return LevelChanges(
        levels=tuple(levels),
        volume=volume if isinstance(volume, Change) else None,
        from_mm=None if closed else heights_mm[0],
        to_mm=heights_mm[-1],
        laid_sigma_mm3=laid_mm3,
        reason=volume if isinstance(volume, Finding) else None,
    )


def equally_detailed(meshes: Sequence[Mesh]) -> list[Mesh]:
    """The meshes with the data on lost relief that all of them have; none if one lacks it.

    One's alone would pass for a difference.
    """
    detail = [name for name, one in VERTEX_FIELDS.items() if one.detail]
    some: dict[str, Any] = {
        name: None for name in detail if any(getattr(mesh, name) is None for mesh in meshes)
    }
    return [replace(mesh, **some) for mesh in meshes]


def _open_below(mesh_in_limb: Mesh) -> bool:
    """Whether the distal end itself is open."""
    heights = mesh_in_limb.vertices_mm[:, 2]
    border = heights[boundary_half_edges(mesh_in_limb.faces)[:, 0]]
    lowest = heights.min() + 0.1 * np.ptp(heights)
    return bool((border < lowest).any())


def _slide_slopes(
    mesh_in_limb: Mesh, heights_mm: tuple[float, ...], slide_sigma_mm: float
) -> list[dict[str, float]]:
    """Standard deviation of figures due to the shape's place along the axis, by height and name."""
    ends = [
        levels_at(mesh_in_limb, [h + step for h in heights_mm]) for step in (-_STEP_MM, _STEP_MM)
    ]
    slides: list[dict[str, float]] = []
    for under, over in zip(*ends):
        slide: dict[str, float] = {}
        if not isinstance(under, Refused) and not isinstance(over, Refused):
            for name in COMPARED:
                low, high = MEASURES[name](under), MEASURES[name](over)
                if low is not None and high is not None:
                    slope = (high.value - low.value) / (2 * _STEP_MM)
                    slide[name] = abs(slope) * slide_sigma_mm
        slides.append(slide)
    return slides


def _area_mm2(level: Level | Refused, volumes: Volumes) -> float:
    """Area of all limbs at a height, as volumes count them."""
    if isinstance(level, Refused):  # no limb was chosen, but the volume counts all
        height, step = level.height_mm, _STEP_MM
        try:
            return volumes.between(height - step, height + step).value / (2 * step)
        except MeasureError:  # nor has the volume up to there an answer
            return 0.0
    return area_mm2(level).value + sum(other.area_mm2 for other in level.others)


def _volume(
    volumes: tuple[Volumes, Volumes], low_mm: float, high_mm: float, slide_mm3: float
) -> Change | Finding:
    if not low_mm < high_mm:
        return fault("compare.levels.one_shared")
    try:
        first, second = (volume.between(low_mm, high_mm) for volume in volumes)
    except MeasureError as error:
        return error.finding
    return Change(first, _with_added_sigma(second, slide_mm3))


def _with_added_sigma(figure: Figure, slide: float) -> Figure:
    if figure.sigma is None:
        return figure
    return Figure(figure.value, math.hypot(figure.sigma, slide))


def _level(
    sigmas: tuple[Sigmas, Sigmas],
    one: Level | Refused,
    two: Level | Refused,
    since_last: Change | None,
    slide: dict[str, float],
) -> LevelChange:
    reasons = [level.reason for level in (one, two) if isinstance(level, Refused)]
    measures: dict[str, Change] = {}
    if not isinstance(one, Refused) and not isinstance(two, Refused):
        for name in COMPARED:
            sloped = MEASURES[name](one), MEASURES[name](two)
            if sloped[0] is not None and sloped[1] is not None:
                second = _with_added_sigma(sigmas[1].figure(two, sloped[1]), slide.get(name, 0.0))
                measures[name] = Change(sigmas[0].figure(one, sloped[0]), second)
    return LevelChange(
        height_mm=one.height_mm,
        measures=measures,
        since_last=since_last,
        reason=reasons[0] if reasons else None,
        others_mm=(_other_contours_mm(one), _other_contours_mm(two)),
    )


def _other_contours_mm(level: Level | Refused) -> tuple[float, ...]:
    return () if isinstance(level, Refused) else tuple(one.contour_mm for one in level.others)
