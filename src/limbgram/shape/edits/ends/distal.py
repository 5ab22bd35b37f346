"""The distal end: made longer or shorter, and rounder."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.errors import EditError
from limbgram.geometry.arrays import Points3
from limbgram.shape.edits.guard import require_sound
from limbgram.shape.edits.marking.axis import middles_mm
from limbgram.shape.edits.marking.places import axes_in_mesh, displaced, in_limb_frame
from limbgram.shape.edits.regional import fading
from limbgram.shape.limb import Limb

_BLEND = 0.3
"""Part of the height, from its top, over which the round shape takes over."""


@dataclass(frozen=True, kw_only=True)
class DistalEnd:
    """Shape the distal end, below a height above its lowest point."""

    height_mm: float
    """How far up from the lowest point the change reaches."""
    lengthen_mm: float = 0.0
    """How much lower the lowest point comes to lie; negative shortens."""
    roundness: float = 0.0
    """0 leaves the shape, 1 makes it half an ellipsoid on the section at that height."""


def require_end(edit: DistalEnd, what: str) -> None:
    """Refuse numbers that make sense on no limb.

    Raises:
        EditError: a height, a roundness or a shortening out of its range.
    """
    if not edit.height_mm > 0:
        raise EditError(f"{what} needs a height above 0 mm, counted from the lowest point.")
    if not 0 <= edit.roundness <= 1:
        raise EditError(f"{what} takes a roundness from 0 to 1, not {edit.roundness:g}.")
    if edit.lengthen_mm <= -edit.height_mm / 2:
        raise EditError(
            f"{what} can be shortened by less than half of its height, {edit.height_mm:g} mm. Give "
            "a larger height_mm, or cut it by a plane."
        )


def distal_end(limb: Limb, edit: DistalEnd) -> Limb:
    """Lengthen, shorten or round the distal end.

    Raises:
        EditError: numbers that make no sense, or a surface that would fold.
    """
    what = "The distal end"
    require_end(edit, what)
    points = in_limb_frame(limb, what)
    low, high = float(points[:, 2].min()), float(points[:, 2].max())
    if edit.height_mm >= high - low:
        raise EditError(
            f"{what} needs a height below the length of the shape, {high - low:.0f} mm."
        )
    top = low + edit.height_mm
    depth = np.clip((top - points[:, 2]) / edit.height_mm, 0, 1)
    target = points + edit.roundness * _towards_round(limb, points, top, edit.height_mm, what)
    target[:, 2] -= edit.lengthen_mm * (1 - fading(depth))
    axes = axes_in_mesh(limb, what)
    step = np.einsum("nj,jk->nk", target - points, axes)
    changed = displaced(limb, limb.mesh.vertices_mm + step)
    require_sound(what, limb.mesh, changed.mesh)
    return changed


def _towards_round(limb: Limb, points: Points3, top: float, height: float, what: str) -> Points3:
    """Ways of the vertices below a height to the half ellipsoid on the section there."""
    below = points[:, 2] < top
    centre = middles_mm(limb, np.array([[0.0, 0.0, top]]), what)[0, :2]
    around = points[:, :2] - centre
    radius = np.linalg.norm(around, axis=1)
    rim = _rim_radius(limb, points, top, centre, around)
    drop = np.clip((top - points[:, 2]) / height, 0, 1)
    meridian = np.arctan2(drop, np.maximum(radius / rim, 0.0))
    onto = np.cos(meridian) * rim
    way = np.zeros_like(points)
    way[:, :2] = around * (onto / np.maximum(radius, 1e-9) - 1)[:, None]
    way[:, 2] = top - height * np.sin(meridian) - points[:, 2]
    share = (1 - fading(drop / _BLEND)) * below
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
