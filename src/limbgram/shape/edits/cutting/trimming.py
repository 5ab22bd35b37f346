"""Cuts: along a plane across the limb's axis, and along a trimline drawn on the surface."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.errors import EditError
from limbgram.shape.edits.cutting.capping import cap
from limbgram.shape.edits.cutting.splitting import ON_IT_MM, keep_positive
from limbgram.shape.edits.guard import require_sound
from limbgram.shape.edits.marking.axis import middles_mm
from limbgram.shape.edits.marking.curves import draw_curve, find_sides, fine_along
from limbgram.shape.edits.marking.places import (
    FrameName,
    Place,
    height_mm,
    in_limb_frame,
    on_surface,
    position_mm,
    require_ring,
)
from limbgram.shape.limb import Limb
from limbgram.surface.mesh import Mesh

Part = Literal["distal", "proximal"]
_EDGE_MM = 1.5
"""Edges along a trimline before it is cut."""
_STEEPEST_DEG = 80.0


@dataclass(frozen=True, kw_only=True)
class PlaneCut:
    """Cut by a plane across the limb's axis."""

    height_mm: float
    """Where the plane meets the middle of the limb."""
    above: str = ""
    """Landmark from which the height counts; without it the distal end's origin."""
    forward_deg: float = 0.0
    """Tilt: how much the plane rises towards posterior (its normal leans to anterior)."""
    right_deg: float = 0.0
    """Tilt: how much the plane rises towards the left (its normal leans to the patient's right)."""
    keep: Part = "distal"
    """Which part stays."""
    capped: bool = False
    """Whether the cut is closed by a flat surface."""


@dataclass(frozen=True, kw_only=True)
class Trimline:
    """Cut along a closed curve drawn on the surface."""

    through: tuple[Place, ...]
    """Points in order round the limb, on the surface; the curve through them is smooth."""
    keep: Part = "distal"
    """Which part stays."""
    positions_in: FrameName = "limb"
    """Frame of coordinates."""


def require_tilts(edit: PlaneCut, what: str) -> None:
    """Refuse a plane that no longer lies across the limb.

    Raises:
        EditError: it is too steep.
    """
    if not max(abs(edit.forward_deg), abs(edit.right_deg)) <= _STEEPEST_DEG:
        raise EditError(
            f"{what} lies across the limb and takes tilts of up to {_STEEPEST_DEG:g} degrees, not "
            f"{edit.forward_deg:g} and {edit.right_deg:g}. Draw a trimline to cut along it."
        )


def plane_cut(limb: Limb, edit: PlaneCut) -> Limb:
    """Cut by a plane; triangles across it are split, so the new edge lies in it.

    Raises:
        EditError: the plane misses the shape, or cannot be closed.
    """
    what = "The plane cut"
    require_tilts(edit, what)
    level = height_mm(limb, edit.height_mm, edit.above, what)
    points = in_limb_frame(limb, what)
    middle = middles_mm(limb, np.array([[0.0, 0.0, level]]), what)[0]
    tilt = np.tan(np.radians([edit.right_deg, edit.forward_deg]))
    normal = np.array([tilt[0], tilt[1], 1.0])
    normal /= np.linalg.norm(normal)
    values = ((points - middle) * normal).sum(1) * (1.0 if edit.keep == "proximal" else -1.0)
    if not (values > ON_IT_MM).any() or not (values < -ON_IT_MM).any():
        low, high = float(points[:, 2].min()), float(points[:, 2].max())
        raise EditError(
            f"{what} at {level:.1f} mm misses the shape, which reaches from {low:.1f} to "
            f"{high:.1f} mm along the axis."
        )
    cut = keep_positive(limb.mesh, values)
    mesh = cap(cut.mesh, cut.on_cut, what) if edit.capped else cut.mesh
    require_sound(what, limb.mesh, mesh)
    return limb.with_mesh(mesh)


def trimline(limb: Limb, edit: Trimline) -> Limb:
    """Cut along a curve; triangles across it are split, so the new brim follows it.

    Raises:
        EditError: the curve does not part the surface in two.
    """
    what = "The trimline"
    require_ring(edit.through, what)
    picked = np.stack([position_mm(limb, place, edit.positions_in, what) for place in edit.through])
    curve = draw_curve(limb.mesh, on_surface(limb, picked, what), what)
    fine = fine_along(limb.mesh, curve, _EDGE_MM)
    sides = find_sides(fine, curve, what)
    heights = in_limb_frame(limb.with_mesh(fine), what)[:, 2]
    left_is_kept = _is_kept(fine, sides.left, heights, edit.keep)
    apart = np.where(np.isfinite(sides.signed_mm), sides.signed_mm, np.where(sides.left, 1e3, -1e3))
    cut = keep_positive(fine, apart if left_is_kept else -apart)
    require_sound(what, limb.mesh, cut.mesh)
    return limb.with_mesh(cut.mesh)


def _is_kept(
    mesh: Mesh, left: Bool[np.ndarray, " n"], heights: Float64[np.ndarray, " n"], keep: Part
) -> bool:
    """Whether the part to the left of the curve is the one to keep, by the middles of both."""
    areas = np.linalg.norm(mesh.face_normals(), axis=1)
    middle, share = heights[mesh.faces].mean(1), left[mesh.faces].mean(1)
    of_left = (areas * share * middle).sum() / (areas * share).sum()
    of_right = (areas * (1 - share) * middle).sum() / (areas * (1 - share)).sum()
    return bool((of_left > of_right) == (keep == "proximal"))
