"""The distal end, made longer, shorter or rounder."""

from typing import Annotated

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.request_fields import Within
from limbgram.workbench.edits.areas import falloff
from limbgram.workbench.edits.edit import (
    RESIDUAL_LIMBS,
    AboveZeroMm,
    Edit,
    Effect,
    Words,
    edit,
    spoken,
)
from limbgram.workbench.edits.regions import (
    axes_in_mesh,
    displaced,
    points_in_limb_frame,
    section_centres_mm,
)
from limbgram.workbench.limb import Limb

_BLEND = 0.3
"""Part of the height, from its top, over which the round shape takes over."""


@edit(
    group="ends",
    order=3,
    effect=Effect(moves_skin=True),
    everyday=True,
    kinds=RESIDUAL_LIMBS,
    example={"height_mm": 40.0, "lengthen_mm": 5.0, "roundness": 0.5},
)
class DistalEnd(Edit):
    """Shape the distal end, below a height above its lowest point."""

    height_mm: AboveZeroMm
    """How far up from the lowest point the change reaches."""
    lengthen_mm: float = 0.0
    """How much lower the lowest point comes to lie; negative shortens."""
    roundness: Annotated[float, Within(0, 1)] = 0.0
    """0 leaves the shape, 1 makes it half an ellipsoid on the section at that height."""

    words = spoken(
        en=Words(name="Shape the distal end", title="The distal end"),
        de=Words(
            name="Distales Ende formen",
            title="Das Formen des distalen Endes",
            does="Das distale Ende formen, unterhalb einer Höhe über seinem tiefsten Punkt.",
            labels={"height_mm": "Höhe", "lengthen_mm": "Verlängern", "roundness": "Rundung"},
            help={
                "height_mm": "Wie weit die Änderung vom tiefsten Punkt hinaufreicht.",
                "lengthen_mm": "Um wie viel tiefer der tiefste Punkt zu liegen kommt; negativ "
                "verkürzt.",
                "roundness": "0 lässt die Form, 1 macht sie zum halben Ellipsoid auf dem Schnitt "
                "in jener Höhe.",
            },
        ),
    )

    def check(self) -> None:
        """Refuse to shorten by half of the height or more.

        Raises:
            EditError: it is shortened so.
        """
        if self.lengthen_mm <= -self.height_mm / 2:
            raise EditError("edit.end.shortened", height_mm=self.height_mm)

    def apply(self, limb: Limb) -> Limb:
        """Lengthen, shorten or round the distal end.

        Raises:
            EditError: numbers that make no sense, or a surface that would fold.
        """
        points = points_in_limb_frame(limb)
        low, high = float(points[:, 2].min()), float(points[:, 2].max())
        if self.height_mm >= high - low:
            raise EditError("edit.end.beyond", length_mm=high - low)
        top = low + self.height_mm
        depth = np.clip((top - points[:, 2]) / self.height_mm, 0, 1)
        target = points + self.roundness * _moves_to_ellipsoid(limb, points, top, self.height_mm)
        target[:, 2] -= self.lengthen_mm * (1 - falloff(depth))
        axes = axes_in_mesh(limb)
        step = np.einsum("nj,jk->nk", target - points, axes)
        return displaced(limb, limb.mesh.vertices_mm + step)


def _moves_to_ellipsoid(limb: Limb, points: Points3, top: float, height: float) -> Points3:
    """Moves of the vertices below a height onto the half ellipsoid on the section there."""
    below = points[:, 2] < top
    centre = section_centres_mm(limb, np.array([[0.0, 0.0, top]]))[0, :2]
    around = points[:, :2] - centre
    radius = np.linalg.norm(around, axis=1)
    rim = _rim_radius(limb, points, top, centre, around)
    drop = np.clip((top - points[:, 2]) / height, 0, 1)
    meridian = np.arctan2(drop, np.maximum(radius / rim, 0.0))
    onto = np.cos(meridian) * rim
    way = np.zeros_like(points)
    way[:, :2] = around * (onto / np.maximum(radius, 1e-9) - 1)[:, None]
    way[:, 2] = top - height * np.sin(meridian) - points[:, 2]
    share = (1 - falloff(drop / _BLEND)) * below
    return way * share[:, None]


def _rim_radius(
    limb: Limb, points: Points3, top: float, centre: np.ndarray, around: np.ndarray
) -> Float64[np.ndarray, " n"]:
    """Radius of the section at the top of the distal end, in the direction of each vertex."""
    ends = points[limb.mesh.faces]
    starts, stops = ends.reshape(-1, 3), np.roll(ends, -1, axis=1).reshape(-1, 3)
    crossing = (starts[:, 2] < top) != (stops[:, 2] < top)
    starts, stops = starts[crossing], stops[crossing]
    share = (top - starts[:, 2]) / (stops[:, 2] - starts[:, 2])
    rim = (starts + share[:, None] * (stops - starts))[:, :2] - centre
    angle, radius = np.arctan2(rim[:, 1], rim[:, 0]), np.linalg.norm(rim, axis=1)
    order = np.argsort(angle, kind="stable")
    return np.interp(
        np.arctan2(around[:, 1], around[:, 0]), angle[order], radius[order], period=2 * np.pi
    )
