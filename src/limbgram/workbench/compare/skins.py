"""Skins: which skin of a wall, such as a socket, is compared with a limb.

In      two shapes or more, any of which may be a wall.
Out     the same, each wall as one skin that faces outwards as a limb does; and which it is.
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

from limbgram.core.mesh.topology import with_faces
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.findings import Finding, doubt
from limbgram.workbench.compare.frames import axes_of, mesh_in_frame
from limbgram.workbench.compare.icp import MIDDLE, known_pose, measured_samples
from limbgram.workbench.edits.thickness import solid_wall
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.measured_skin import inner_faces

_SAME_MM = 0.1
"""Median distance within which a wall's outside is the surface from which it was made."""


class _ComparedSkin(NamedTuple):
    """The part of a shape that is compared."""

    limb: Limb
    skin: Literal["inside", "outside", "both"]


class ComparedSkins(NamedTuple):
    """The parts of several shapes that are compared."""

    limbs: tuple[Limb, ...]
    findings: tuple[Finding, ...]
    """A doubt for each wall, about which skin is compared."""


def skins_to_compare(limbs: Sequence[Limb]) -> ComparedSkins:
    """The parts of shapes that are compared, in their order, and a doubt for each wall."""
    walls = [solid_wall(limb.mesh) for limb in limbs]
    limb_itself = next(
        (limb for limb, wall in zip(limbs, walls, strict=True) if wall is None), None
    )
    compared = [
        _ComparedSkin(limb, "both") if wall is None else _skin_to_compare(limb, limb_itself)
        for limb, wall in zip(limbs, walls, strict=True)
    ]
    findings = tuple(
        doubt("compare.wall", name=limb.name, median_mm=wall.median_mm, skin=one.skin)
        for limb, wall, one in zip(limbs, walls, compared, strict=True)
        if wall is not None
    )
    return ComparedSkins(tuple(one.limb for one in compared), findings)


def _skin_to_compare(wall: Limb, other: Limb | None) -> _ComparedSkin:
    """The skin of a wall that is compared with another shape; None if all are walls."""
    mesh = wall.mesh
    inner = inner_faces(mesh_in_frame(mesh, axes_of(wall).limb_from_mesh))
    if not inner.any():
        return _ComparedSkin(wall, "both")
    inside = wall.with_mesh(with_faces(mesh, mesh.faces[inner][:, ::-1].copy()))
    outside = wall.with_mesh(with_faces(mesh, mesh.faces[~inner]))
    made = None if other is None else known_pose(other, outside)
    if other is None or made is None:
        return _ComparedSkin(inside, "inside")
    places_mm = made.first_from_second.apply(measured_samples(outside, MIDDLE, 0.0))
    off_mm = float(np.median(tree_on(other.mesh).closest(places_mm).distances_mm))
    return (
        _ComparedSkin(outside, "outside") if off_mm < _SAME_MM else _ComparedSkin(inside, "inside")
    )
