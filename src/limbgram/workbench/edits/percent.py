"""Per cent: sections made smaller or larger by levels along the axis, and published presets.

A girth changed by p per cent scales a section's radius by 1 - p / 100; a volume changed by p per
cent scales its area so, and its radius by the root of that. Every vertex keeps its height.
"""

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import EditError
from limbgram.workbench.edits.edit import Effect
from limbgram.workbench.edits.guard import require_sound
from limbgram.workbench.edits.regions import (
    axes_in_mesh,
    displaced,
    height_mm,
    middles_mm,
    points_in_limb_frame,
)
from limbgram.workbench.limb import Limb

PerCentOf = Literal["girth", "volume"]
_MOST = 50.0
_LEVEL_TOLERANCE_MM = 1.0
"""A level so little beyond an end of the shape is meant to be that end."""


@dataclass(frozen=True, kw_only=True)
class Reduction:
    """Make sections smaller by per cent at levels, in between in proportion."""

    heights_mm: tuple[float, ...]
    """Levels along the limb's axis, rising."""
    per_cent: tuple[float, ...]
    """One for each level; below the first and above the last the same as there."""
    of: PerCentOf
    """What the per cent are of."""
    above: str = ""
    """Landmark from which heights count; without it the distal end's origin."""

    title: ClassVar[str] = "The reduction"
    effect: ClassVar[Effect] = Effect(moves_skin=True)

    def check(self) -> None:
        _require_levels(self, self.title)

    def apply(self, limb: Limb) -> Limb:
        """Scale sections towards their middles.

        Raises:
            EditError: the levels make no sense, or the surface would cut through itself.
        """
        _require_on_limb(limb, self, self.title)
        return change_by_levels(limb, self.title, self, -1.0)


@dataclass(frozen=True, kw_only=True)
class Increase:
    """Make sections larger by per cent at levels, in between in proportion."""

    heights_mm: tuple[float, ...]
    """Levels along the limb's axis, rising."""
    per_cent: tuple[float, ...]
    """One for each level; below the first and above the last the same as there."""
    of: PerCentOf
    """What the per cent are of."""
    above: str = ""
    """Landmark from which heights count; without it the distal end's origin."""

    title: ClassVar[str] = "The increase"
    effect: ClassVar[Effect] = Effect(moves_skin=True)

    def check(self) -> None:
        _require_levels(self, self.title)

    def apply(self, limb: Limb) -> Limb:
        """Scale sections away from their middles.

        Raises:
            EditError: the levels make no sense, or the surface would cut through itself.
        """
        _require_on_limb(limb, self, self.title)
        return change_by_levels(limb, self.title, self, 1.0)


def _require_levels(edit: Reduction | Increase, what: str) -> None:
    """Refuse levels that make sense on no limb.

    Raises:
        EditError: not one per cent for each level, levels out of order, or per cent out of range.
    """
    heights, per_cent = np.array(edit.heights_mm), np.array(edit.per_cent)
    if len(heights) != len(per_cent) or not len(heights):
        raise EditError(
            "edit.levels.unpaired", what=what, heights=len(heights), per_cent=len(per_cent)
        )
    if (np.diff(heights) <= 0).any():
        raise EditError("edit.levels.order", what=what)
    if (per_cent < 0).any() or (per_cent > _MOST).any():
        raise EditError("edit.levels.per_cent", what=what, most=_MOST)


def _require_on_limb(limb: Limb, edit: Reduction | Increase, what: str) -> None:
    """Refuse levels none of which the shape has; some beyond its ends are of a longer limb."""
    heights = points_in_limb_frame(limb, what)[:, 2]
    low, high = float(heights.min()), float(heights.max())
    levels = height_mm(limb, 0.0, edit.above, what) + np.array(edit.heights_mm)
    near = (levels >= low - _LEVEL_TOLERANCE_MM) & (levels <= high + _LEVEL_TOLERANCE_MM)
    if not near.any() and not levels.min() < low < levels.max():
        nearest = levels.min() if levels.min() > high else levels.max()
        raise EditError(
            "edit.levels.off_shape", what=what, low_mm=low, high_mm=high, nearest_mm=nearest
        )


def change_by_levels(limb: Limb, what: str, edit: Reduction | Increase, sign: float) -> Limb:
    """Scale sections by sign times the per cent."""
    heights, per_cent = np.array(edit.heights_mm), np.array(edit.per_cent)
    base = height_mm(limb, 0.0, edit.above, what)
    points = points_in_limb_frame(limb, what)
    change = sign * np.interp(points[:, 2], base + heights, per_cent) / 100
    factor = 1 + change if edit.of == "girth" else np.sqrt(1 + change)
    step = (factor - 1)[:, None] * (points - middles_mm(limb, points, what))
    changed = displaced(limb, limb.mesh.vertices_mm + _across(limb, step, what))
    require_sound(what, limb.mesh, changed.mesh)
    return changed


def _across(limb: Limb, step: Float64[np.ndarray, "n 3"], what: str) -> Float64[np.ndarray, "n 3"]:
    """Displacements in the limb frame, without their part along the axis, in the mesh's frame."""
    x_axis, y_axis, _ = axes_in_mesh(limb, what)
    return step[:, :1] * x_axis + step[:, 1:2] * y_axis
