"""Oval: an oval area round a place, moved in or out along one direction, as for a pad.

A pad presses: the positive is carved in. A room gives way: it is built up. Both move along one
direction, that of the surface at the place, so that a pad keeps its flat face. The oval is measured
over the surface, and what turns away from the pad stays: pressed from below, a forefoot's upper
side is not lifted.
"""

from dataclasses import dataclass
from functools import partial
from typing import Annotated

import numpy as np

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.mesh.mesh import unit
from limbgram.core.request_fields import Within
from limbgram.workbench.edits.areas import falloff, require_outside
from limbgram.workbench.edits.edit import AboveZeroMm, Edit, Words, spoken
from limbgram.workbench.edits.guard import require_sound
from limbgram.workbench.edits.refinement import faces_near, refine_selected
from limbgram.workbench.edits.regions import (
    Place,
    axes_in_mesh,
    displaced,
    distances_from_point,
    on_surface,
    position_mm,
    smooth_normals_on,
)
from limbgram.workbench.limb import Kind, Limb

_EDGES_PER_FADE = 8.0
_FINEST_MM = 1.0
_NORMAL_SHARE = 0.5
"""Share of the oval's smaller half axis within which normals are averaged for its direction."""
_FACING = 0.5
"""Cosine of the surface's turn from the pad up to which it moves in full: up to 60 degrees. At
right angles it stays."""
_LEAST_SINE = 0.25
"""Sine of the least angle between the limb's way and the pad's, 14 degrees: nearer to the limb's
end the height goes from back to front."""


@dataclass(frozen=True, kw_only=True)
class Oval(Edit):
    """What pads and rooms have in common."""

    at: Place
    """The middle: a landmark's name or x, y, z in the limb frame."""
    depth_mm: AboveZeroMm
    """How far the surface moves in the middle."""
    width_mm: AboveZeroMm
    """Round the limb."""
    height_mm: AboveZeroMm
    """Along the limb's centreline; across its end, from back to front."""
    edge: Annotated[float, Within(0.05, 1)] = 0.5
    """Share of the way from the rim to the middle over which it fades."""

    words = spoken(
        en=Words(labels={"at": "Middle", "edge": "Fading"}),
        de=Words(
            labels={
                "at": "Mitte",
                "depth_mm": "Tiefe",
                "width_mm": "Breite",
                "height_mm": "Höhe",
                "edge": "Auslauf",
            },
            help={
                "at": "Die Mitte: Name einer Landmarke oder x, y, z in den Achsen des Gliedmaßes.",
                "depth_mm": "Wie weit sich die Fläche in der Mitte bewegt.",
                "width_mm": "Um das Gliedmaß herum.",
                "height_mm": "Entlang der Mittellinie des Gliedmaßes; quer über sein Ende von "
                "hinten nach vorn.",
                "edge": "Anteil des Wegs vom Rand zur Mitte, über den sie ausläuft.",
            },
        ),
    )

    def places_of(self, kind: Kind) -> set[str]:
        return kind.names_in((self.at, kind.centreline))


def move_oval(limb: Limb, oval: Oval, sign: float) -> Limb:
    """The limb with the oval moved outwards by sign 1, inwards by -1.

    Raises:
        EditError: no such place, the inside of a wall, or the surface would fold or cut through
            itself.
    """
    middle = on_surface(limb, position_mm(limb, oval.at, "limb")[None])[0]
    require_outside(limb, middle[None])
    half = np.array([oval.width_mm, oval.height_mm]) / 2
    reach = float(half.max()) * 1.5

    edge_mm = max(oval.edge * float(half.min()) / _EDGES_PER_FADE, _FINEST_MM)
    given = limb.mesh
    near_oval = partial(faces_near, point_mm=middle, reach_mm=reach)
    limb = limb.with_mesh(refine_selected(limb.mesh, near_oval, edge_mm))
    mesh = limb.mesh
    distance = distances_from_point(mesh, middle, reach)
    near = distance < max(_NORMAL_SHARE * float(half.min()), 2 * edge_mm)
    outward = (mesh.vertex_normals() * (mesh.vertex_areas_mm2() * near)[:, None]).sum(0)
    outward /= np.linalg.norm(outward)
    up = _up_in_surface(limb, middle, outward)
    off = mesh.vertices_mm - middle
    way = unit(off - (off @ outward)[:, None] * outward)
    halves = np.hypot(way @ np.cross(up, outward) / half[0], way @ up / half[1])
    across = np.minimum(distance, reach) * halves
    facing = 1 - falloff(smooth_normals_on(mesh, given) @ outward / _FACING)
    share = falloff((across - 1 + oval.edge) / oval.edge) * facing
    step = sign * oval.depth_mm * share[:, None] * outward
    changed = displaced(limb, mesh.vertices_mm + step)
    require_sound(mesh, changed.mesh)
    return changed


def _up_in_surface(limb: Limb, point_mm: Vector3, outward: Vector3) -> Vector3:
    """The limb's way in the surface at a point: along its centreline, proximal, or its long axis
    where the centreline's landmarks are missing; at the limb's end forward."""
    _, front, axis = axes_in_mesh(limb)
    try:
        curve = limb.centreline()
    except MeasureError:
        along = axis
    else:
        along = -curve.at(float(curve.nearest_mm(point_mm[None])[0])).direction
    in_surface = along - outward * (along @ outward)
    if np.linalg.norm(in_surface) < _LEAST_SINE:
        in_surface = front - outward * (front @ outward)
    return in_surface / np.linalg.norm(in_surface)
