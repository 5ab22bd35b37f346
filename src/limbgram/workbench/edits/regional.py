"""Regional edits: an area relieved or loaded, fading towards its edge.

The shape is a positive. To relieve a place is to build it up, outwards: what is made over the shape
has room there. To load a place is to carve it in: what is made over the shape presses there. In the
words of J. Zettl and J. Traub (Artificial Limbs 15(1), 1971): the positive is modified "to relieve
pressure-sensitive areas by the addition of build-ups, and to increase the pressure to the
pressure-tolerant areas by the judicious removal of small amounts of plaster". The noun "relief",
by which this program once called the carving, is no edit any more.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.errors import EditError
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.edits.edit import Effect
from limbgram.workbench.edits.fineness import refine_under, refine_where
from limbgram.workbench.edits.guard import require_sound
from limbgram.workbench.edits.regions import (
    Curve,
    FrameName,
    Place,
    calm_normals_on,
    displaced,
    distances_from,
    distances_from_point,
    draw_curve,
    find_sides,
    fine_along,
    inside,
    on_surface,
    position_mm,
    require_ring,
)
from limbgram.workbench.limb import Limb

_FINENESS = 8.0
"""Edges along the falloff, at least."""
_FINEST_MM = 0.4


@dataclass(frozen=True, kw_only=True)
class Relieve:
    """Give room: build the positive up, outwards, round a place or over a drawn region."""

    depth_mm: float
    """How far the surface rises, at the highest point, exactly."""
    falloff_mm: float
    """Width over which the rise fades to nothing, over the surface: outwards from `flat_mm`
    round a place, inwards from the curve of a region."""
    at: Place | None = None
    """The place: a landmark's name or x, y, z."""
    flat_mm: float = 0.0
    """Radius of the full rise round the place."""
    within: tuple[Place, ...] = ()
    """The region: points in order round it, on the surface; `at` or this."""
    positions_in: FrameName = "limb"
    """Frame of coordinates."""

    title: ClassVar[str] = "The edit relieve"
    effect: ClassVar[Effect] = Effect(moves_skin=True)

    def check(self) -> None:
        _require_area(self)

    def apply(self, limb: Limb) -> Limb:
        """Build an area up along the surface's normals.

        Raises:
            EditError: no such area, or the surface would fold or cut through itself.
        """
        return _pushed(limb, self, 1.0)


@dataclass(frozen=True, kw_only=True)
class Load:
    """Give pressure: carve the positive in, round a place or over a drawn region."""

    depth_mm: float
    """How far the surface sinks, at the deepest point, exactly."""
    falloff_mm: float
    """Width over which the depth fades to nothing, over the surface: outwards from `flat_mm`
    round a place, inwards from the curve of a region."""
    at: Place | None = None
    """The place: a landmark's name or x, y, z."""
    flat_mm: float = 0.0
    """Radius of full depth round the place."""
    within: tuple[Place, ...] = ()
    """The region: points in order round it, on the surface; `at` or this."""
    positions_in: FrameName = "limb"
    """Frame of coordinates."""

    title: ClassVar[str] = "The edit load"
    effect: ClassVar[Effect] = Effect(moves_skin=True)

    def check(self) -> None:
        _require_area(self)

    def apply(self, limb: Limb) -> Limb:
        """Carve an area in along the surface's normals.

        Raises:
            EditError: no such area, or the surface would fold or cut through itself.
        """
        return _pushed(limb, self, -1.0)


def fading(share: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, " n"]:
    """From 1 at 0 to 0 at 1, level and without bend at both ends."""
    x = np.clip(share, 0.0, 1.0)
    return 1 - x * x * x * (10 + x * (6 * x - 15))


def _require_area(edit: Relieve | Load) -> None:
    """Refuse an area that makes sense on no limb.

    Raises:
        EditError: amounts below 0, or not just one of a place and a region.
    """
    if edit.depth_mm <= 0 or edit.falloff_mm <= 0 or edit.flat_mm < 0:
        raise EditError("edit.region.depth", what=edit.title)
    if (edit.at is None) == (not edit.within):
        raise EditError("edit.region.place", what=edit.title)
    if edit.within:
        require_ring(edit.within, edit.title)


def _pushed(limb: Limb, edit: Relieve | Load, sign: float) -> Limb:
    """The limb with the area moved along its normals: outwards by sign 1, inwards by -1."""
    what = edit.title
    given = limb.mesh
    limb, weight = (
        _in_a_region(limb, edit, what)
        if edit.at is None
        else _round_a_place(limb, edit, edit.at, what)
    )
    largest = float(weight.max(initial=0.0))
    if largest <= 0:
        raise EditError("edit.region.empty", what=what)
    step = sign * edit.depth_mm * (weight / largest)[:, None]
    changed = displaced(limb, limb.mesh.vertices_mm + step * calm_normals_on(limb.mesh, given))
    require_sound(what, limb.mesh, changed.mesh)
    return changed


def _in_a_region(
    limb: Limb, edit: Relieve | Load, what: str
) -> tuple[Limb, Float64[np.ndarray, " n"]]:
    """The limb fine enough, and the share of the depth at each vertex."""
    picked = np.stack([position_mm(limb, place, edit.positions_in, what) for place in edit.within])
    curve = draw_curve(limb.mesh, on_surface(limb, picked, what), what)
    mesh = fine_along(limb.mesh, curve, _edge_mm(edit))
    coarse = _depth_within(mesh, curve, what)
    fades = (coarse > 0) & (coarse < edit.falloff_mm)
    mesh = refine_where(mesh, np.asarray(fades[mesh.faces].any(1)), _edge_mm(edit))
    depth = _depth_within(mesh, curve, what)
    within = depth > 0
    full = min(edit.falloff_mm, float(depth.max(initial=0.0)))
    return limb.with_mesh(mesh), fading(1 - depth / max(full, 1e-12)) * within


def _edge_mm(edit: Relieve | Load) -> float:
    return max(edit.falloff_mm / _FINENESS, _FINEST_MM)


def _depth_within(mesh: Mesh, curve: Curve, what: str) -> Float64[np.ndarray, " n"]:
    """Distance of each vertex from the curve, over the surface; 0 outside it."""
    sides = find_sides(mesh, curve, what)
    within = inside(mesh, sides)
    start = np.where(within, np.abs(sides.signed_mm), np.inf)
    depth = distances_from(mesh, start, within, np.inf)
    return np.where(within & np.isfinite(depth), depth, 0.0)


def _round_a_place(
    limb: Limb, edit: Relieve | Load, place: Place, what: str
) -> tuple[Limb, Float64[np.ndarray, " n"]]:
    """The limb fine enough, and the share of the depth at each vertex."""
    point = on_surface(limb, position_mm(limb, place, edit.positions_in, what)[None], what)[0]
    reach = edit.flat_mm + edit.falloff_mm

    def close(mesh: Mesh) -> Bool[np.ndarray, " f"]:
        corners = mesh.vertices_mm[mesh.faces]
        middle = corners.mean(1)
        size = np.linalg.norm(corners - middle[:, None], axis=2).max(1)
        return np.linalg.norm(middle - point, axis=1) < reach + size

    limb = limb.with_mesh(refine_under(limb.mesh, close, _edge_mm(edit)))
    distance = distances_from_point(limb.mesh, point, reach)
    return limb, fading((distance - edit.flat_mm) / edit.falloff_mm)
