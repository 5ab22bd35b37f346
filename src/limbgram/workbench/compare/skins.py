"""Skins: of a wall with two skins, such as a socket, the one that its limb would touch.

In      two shapes or more, any of which may be a wall.
Out     the same, each wall as one skin that faces outwards as a limb does; and what was taken.
Method  The inside is what `measured_skin` tells by levels; the outside is what is left of the wall
        without it, its rim included. The inside counts, as of a socket, also where a limb that was
        much reduced lies nearer to the outside; the outside only where it is the own surface of the
        first shape that is no wall, of which the wall was made inwards. Of walls alone the insides
        count. A wall that is
        open on a side, as a half shell is, shows no hollow: both its skins are compared, and that
        is said.
Fails   never.
"""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from limbgram.core.mesh.topology import is_watertight, with_faces
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.findings import Finding, doubt
from limbgram.workbench.compare.frames import axes_of, mesh_in_frame
from limbgram.workbench.compare.icp import MIDDLE, descent, places_of
from limbgram.workbench.edits.thickness import Thickness, wall_thickness
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.measured_skin import inner_faces

_SAME_MM = 0.1
"""So near lies the middle of what was made of a surface to that surface."""


class _Taken(NamedTuple):
    """What is compared of a shape."""

    limb: Limb
    skin: Literal["inside", "outside", "both"]


class Skins(NamedTuple):
    """What is compared of shapes."""

    limbs: tuple[Limb, ...]
    said: tuple[Finding, ...]
    """Of each wall."""


def skins_to_compare(limbs: Sequence[Limb]) -> Skins:
    """Shapes as what is compared of them, in their order, and what is to be said of each wall."""
    walls = [_wall(limb) for limb in limbs]
    limb_itself = next(
        (limb for limb, wall in zip(limbs, walls, strict=True) if wall is None), None
    )
    taken = [
        _Taken(limb, "both") if wall is None else _skin(limb, limb_itself)
        for limb, wall in zip(limbs, walls, strict=True)
    ]
    said = tuple(
        doubt("compare.wall", name=limb.name, median_mm=wall.median_mm, skin=one.skin)
        for limb, wall, one in zip(limbs, walls, taken, strict=True)
        if wall is not None
    )
    return Skins(tuple(one.limb for one in taken), said)


def _wall(limb: Limb) -> Thickness | None:
    return wall_thickness(limb.mesh) if is_watertight(limb.mesh.faces) else None


def _skin(wall: Limb, other: Limb | None) -> _Taken:
    """The skin of a wall that is compared with another shape, or with walls alone: None."""
    mesh = wall.mesh
    inner = inner_faces(mesh_in_frame(mesh, axes_of(wall).limb_from_mesh))
    if not inner.any():
        return _Taken(wall, "both")
    inside = wall.with_mesh(with_faces(mesh, mesh.faces[inner][:, ::-1].copy()))
    outside = wall.with_mesh(with_faces(mesh, mesh.faces[~inner]))
    made = None if other is None else descent(other, outside)
    if other is None or made is None:
        return _Taken(inside, "inside")
    places_mm = made.first_from_second.apply(places_of(outside, MIDDLE, 0.0))
    off_mm = float(np.median(tree_on(other.mesh).closest(places_mm).distances_mm))
    return _Taken(outside, "outside") if off_mm < _SAME_MM else _Taken(inside, "inside")
