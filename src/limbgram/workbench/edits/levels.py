"""Levels: sections made smaller or larger by per cent at heights along the axis.

A girth changed by p per cent scales a section's radius by 1 - p / 100; a volume changed by p per
cent scales its area so, and its radius by the root of that. Every vertex keeps its height.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import EditError
from limbgram.core.request_fields import Within
from limbgram.workbench.edits.edit import Edit, Words, spoken
from limbgram.workbench.edits.regions import (
    axes_in_mesh,
    displaced,
    height_mm,
    points_in_limb_frame,
    section_centres_mm,
)
from limbgram.workbench.limb import Limb

PerCentOf = Literal["girth", "volume"]
_LEVEL_TOLERANCE_MM = 1.0
"""A level so little beyond an end of the shape is meant to be that end."""


@dataclass(frozen=True, kw_only=True)
class Levels(Edit):
    """What reductions and increases have in common."""

    heights_mm: tuple[float, ...]
    """Levels along the limb's axis, rising."""
    per_cent: tuple[Annotated[float, Within(0, 50)], ...]
    """One for each level; below the first and above the last the same as there."""
    of: PerCentOf
    """What the per cent are of."""
    above: str = ""
    """Landmark from which heights count; without it the distal end's origin."""

    words = spoken(
        en=Words(
            labels={
                "heights_mm": "Heights",
                "per_cent": "Per cent",
                "of": "Per cent of",
                "above": "Heights count from",
            },
        ),
        de=Words(
            labels={
                "heights_mm": "Höhen",
                "per_cent": "Prozent",
                "of": "Prozent von",
                "above": "Höhen zählen ab",
            },
            help={
                "heights_mm": "Höhen längs der Achse, steigend.",
                "of": "Wovon die Prozente sind.",
                "above": "Landmarke, ab der Höhen zählen; sonst ab dem distalen Ende.",
            },
            choices={"girth": "Umfang", "volume": "Volumen"},
        ),
    )

    def check(self) -> None:
        """Refuse levels that make sense on no limb.

        Raises:
            EditError: not one per cent for each level, or levels out of order.
        """
        heights = np.array(self.heights_mm)
        if len(heights) != len(self.per_cent) or not len(heights):
            raise EditError(
                "edit.levels.unpaired",
                heights=len(heights),
                per_cent=len(self.per_cent),
            )
        if (np.diff(heights) <= 0).any():
            raise EditError("edit.levels.order")


def change_by_levels(limb: Limb, edit: Levels, sign: float) -> Limb:
    """Scale sections by sign times the per cent."""
    heights, per_cent = np.array(edit.heights_mm), np.array(edit.per_cent)
    base = height_mm(limb, 0.0, edit.above)
    points = points_in_limb_frame(limb)
    change = sign * np.interp(points[:, 2], base + heights, per_cent) / 100
    factor = 1 + change if edit.of == "girth" else np.sqrt(1 + change)
    step = (factor - 1)[:, None] * (points - section_centres_mm(limb, points))
    return displaced(limb, limb.mesh.vertices_mm + _without_axial_part(limb, step))


def require_on_limb(limb: Limb, edit: Levels) -> None:
    """Refuse levels none of which the shape has; some beyond its ends are of a longer limb."""
    heights = points_in_limb_frame(limb)[:, 2]
    low, high = float(heights.min()), float(heights.max())
    levels = height_mm(limb, 0.0, edit.above) + np.array(edit.heights_mm)
    near = (levels >= low - _LEVEL_TOLERANCE_MM) & (levels <= high + _LEVEL_TOLERANCE_MM)
    if not near.any() and not levels.min() < low < levels.max():
        nearest = levels.min() if levels.min() > high else levels.max()
        raise EditError("edit.levels.off_shape", low_mm=low, high_mm=high, nearest_mm=nearest)


def _without_axial_part(limb: Limb, step: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, "n 3"]:
    """Displacements in the limb frame, without their part along the axis, in the mesh's frame."""
    x_axis, y_axis, _ = axes_in_mesh(limb)
    return step[:, :1] * x_axis + step[:, 1:2] * y_axis
