"""Areas: a place or a drawn region moved along its normals, fading towards its edge.

The shape is a positive. To relieve a place is to build it up, outwards: what is made over the shape
has room there. To load a place is to carve it in: what is made over the shape presses there. In the
words of J. Zettl and J. Traub (Artificial Limbs 15(1), 1971): the positive is modified "to relieve
pressure-sensitive areas by the addition of build-ups, and to increase the pressure to the
pressure-tolerant areas by the judicious removal of small amounts of plaster". The noun "relief",
by which this program once called the carving, is no edit any more.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.core.mesh.topology import is_watertight
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.workbench.edits.edit import AboveZeroMm, Edit, FromZeroMm, Words, spoken
from limbgram.workbench.edits.guard import require_sound
from limbgram.workbench.edits.refinement import (
    edge_for_falloff_mm,
    faces_near,
    refine_selected,
    refine_where,
)
from limbgram.workbench.edits.regions import (
    Curve,
    FrameName,
    Place,
    displaced,
    distances_from,
    distances_from_point,
    draw_curve,
    find_sides,
    on_surface,
    position_mm,
    refined_along,
    require_ring,
    smaller_side,
    smooth_normals_on,
)
from limbgram.workbench.edits.thickness import wall_thickness
from limbgram.workbench.limb import AlignedLimb, Limb
from limbgram.workbench.measures.measured_skin import inner_faces

_WITHIN_MM, _SOLID_SHARE = 10.5, 0.98
"""No wall is so thick that a place this deep under its skin lies as far from all skin."""


@dataclass(frozen=True, kw_only=True)
class Area(Edit):
    """What relieving and loading have in common."""

    depth_mm: AboveZeroMm
    """How far the surface moves, where it moves most, exactly."""
    falloff_mm: AboveZeroMm
    """Width over which it fades to nothing, over the surface: outwards from `flat_mm` round a
    place, inwards from the curve of a region."""
    at: Place | None = None
    """The place: a landmark's name or x, y, z."""
    flat_mm: FromZeroMm = 0.0
    """Radius round the place within which it is full."""
    within: tuple[Place, ...] = ()
    """The region: points in order round it, on the surface; `at` or this."""
    positions_in: FrameName = "limb"
    """Frame of coordinates."""

    words = spoken(
        en=Words(labels={"falloff_mm": "Fades over", "flat_mm": "Full within"}),
        de=Words(
            labels={
                "depth_mm": "Tiefe",
                "falloff_mm": "Läuft aus über",
                "at": "Stelle",
                "flat_mm": "Voll im Umkreis von",
                "within": "Bereich",
                "positions_in": "Koordinaten gelten",
            },
            help={
                "falloff_mm": "Breite, über die es auf der Fläche ausläuft: um eine Stelle nach "
                "außen ab der flachen Mitte, in einem Bereich nach innen ab seiner Linie.",
                "at": "Die Stelle: Name einer Landmarke oder x, y, z.",
                "flat_mm": "Radius um die Stelle, in dem es voll gilt.",
                "within": "Der Bereich: Punkte der Reihe nach um ihn herum, auf der Fläche; statt "
                "der Stelle.",
                "positions_in": "Koordinatensystem der Punkte.",
            },
        ),
    )

    def check(self) -> None:
        """Refuse what is not just one of a place and a region.

        Raises:
            EditError: it is neither, or both, or a region that is no ring.
        """
        if (self.at is None) == (not self.within):
            raise EditError("edit.region.place")
        if self.within:
            require_ring(self.within)


def push_area(limb: Limb, edit: Area, sign: float) -> Limb:
    """The limb with the area moved along its normals: outwards by sign 1, inwards by -1."""
    given = limb.mesh
    limb, weight = (
        _weights_in_region(limb, edit)
        if edit.at is None
        else _weights_round_place(limb, edit, edit.at)
    )
    largest = float(weight.max(initial=0.0))
    if largest <= 0:
        raise EditError("edit.region.empty")
    step = sign * edit.depth_mm * (weight / largest)[:, None]
    changed = displaced(limb, limb.mesh.vertices_mm + step * smooth_normals_on(limb.mesh, given))
    require_sound(limb.mesh, changed.mesh)
    return changed


def require_outside(limb: Limb, places_mm: Points3) -> None:
    """Refuse places on the inside of a wall, where the solid's outward side faces the limb.

    Raises:
        EditError: what is built up there would press, and what is carved in would give room.
    """
    mesh = limb.mesh
    if not (isinstance(limb, AlignedLimb) and is_watertight(mesh.faces)):
        return
    at = tree_on(mesh).closest(places_mm).faces
    within_mm = places_mm - _WITHIN_MM * unit(mesh.face_normals()[at])
    solid = tree_on(mesh).closest(within_mm).distances_mm > _SOLID_SHARE * _WITHIN_MM
    if solid.all() or wall_thickness(mesh) is None:
        return
    if inner_faces(limb.mesh_in_limb)[at].any():
        raise EditError("edit.region.inside")


def falloff(share: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, " n"]:
    """Smooth falloff from 1 at 0 to 0 at 1, with zero slope and curvature at both ends."""
    x = np.clip(share, 0.0, 1.0)
    return 1 - x * x * x * (10 + x * (6 * x - 15))


def _weights_in_region(limb: Limb, edit: Area) -> tuple[Limb, Float64[np.ndarray, " n"]]:
    """The limb fine enough, and the share of the depth at each vertex."""
    picked = np.stack([position_mm(limb, place, edit.positions_in) for place in edit.within])
    picked = on_surface(limb, picked)
    require_outside(limb, picked)
    curve = draw_curve(limb.mesh, picked)
    mesh = refined_along(limb.mesh, curve, edge_for_falloff_mm(edit.falloff_mm))
    coarse = _depth_in_curve(mesh, curve)
    fades = (coarse > 0) & (coarse < edit.falloff_mm)
    mesh = refine_where(
        mesh, np.asarray(fades[mesh.faces].any(1)), edge_for_falloff_mm(edit.falloff_mm)
    )
    depth = _depth_in_curve(mesh, curve)
    within = depth > 0
    full = min(edit.falloff_mm, float(depth.max(initial=0.0)))
    return limb.with_mesh(mesh), falloff(1 - depth / max(full, 1e-12)) * within


def _depth_in_curve(mesh: Mesh, curve: Curve) -> Float64[np.ndarray, " n"]:
    """Distance over the surface of each vertex inside a curve from it; 0 outside."""
    sides = find_sides(mesh, (curve,))
    within = smaller_side(mesh, sides)
    start = np.where(within, np.abs(sides.signed_mm), np.inf)
    depth = distances_from(mesh, start, within, np.inf)
    return np.where(within & np.isfinite(depth), depth, 0.0)


def _weights_round_place(
    limb: Limb, edit: Area, place: Place
) -> tuple[Limb, Float64[np.ndarray, " n"]]:
    """The limb fine enough, and the share of the depth at each vertex."""
    point = on_surface(limb, position_mm(limb, place, edit.positions_in)[None])[0]
    require_outside(limb, point[None])
    reach = edit.flat_mm + edit.falloff_mm

    edge_mm = edge_for_falloff_mm(edit.falloff_mm)
    near = partial(faces_near, point_mm=point, reach_mm=reach)
    limb = limb.with_mesh(refine_selected(limb.mesh, near, edge_mm))
    distance = distances_from_point(limb.mesh, point, reach)
    return limb, falloff((distance - edit.flat_mm) / edit.falloff_mm)
