"""Fittings: the parts of a device with exact geometry: plates, holes, imported bodies.

In      a shell's solid, and parts placed in the limb frame.
Out     one solid.
Method  Booleans of closed meshes by manifold3d, whose results are manifolds by construction.
Fails   EditError: a part is not closed, or does not meet the device.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import manifold3d
import numpy as np
from manifold3d import CrossSection, Manifold

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import Rigid, axis_across
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import volume_mm3

_CIRCLE_SEGMENTS = 96
"""Segments of a circle: a hole of 8 mm is off by 0.002 mm."""
HOLE_OFFSET_MM = 18.0
"""Offset of an adapter's four holes from its middle, along both axes: 36 x 36 mm."""
_CORNER_RADIUS_MM = 6.0
"""Radius of a plate's corners."""
_PYRAMID_END_MM, _PYRAMID_DEG = 21.0, 15.0
_OVERSHOOT_MM = 0.5
"""A hole is drilled this far beyond what it goes through."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """A closed solid that is joined to a device or cut from it."""

    solid: Mesh
    how: Literal["join", "cut"]
    name: str


def with_parts(body: Mesh, parts: Sequence[Part]) -> Mesh:
    """A body with its parts joined or cut, in their order.

    Raises:
        EditError: a part is open, or does not touch the body.
    """
    whole = _manifold(body, "device")
    for part in parts:
        other = _manifold(part.solid, part.name)
        if (whole ^ other).volume() <= 0:
            raise EditError("device.part.apart", name=part.name)
        whole = whole + other if part.how == "join" else whole - other
    return mesh_of(whole) if parts else body


def plate(
    limb_from_plate: Rigid, *, width_mm: float, height_mm: float, hole_mm: float
) -> tuple[Part, ...]:
    """A square plate with the four holes of modular adapters.

    Its frame: origin in the middle of its lower face, Z upwards, Y forwards.
    """
    inner_mm = width_mm - 2 * _CORNER_RADIUS_MM
    outline = CrossSection.square((inner_mm, inner_mm), center=True).offset(
        _CORNER_RADIUS_MM, manifold3d.JoinType.Round, 2.0, _CIRCLE_SEGMENTS
    )
    block = mesh_of(outline.extrude(height_mm))
    holes = [
        _cylinder(hole_mm / 2, -_OVERSHOOT_MM, height_mm + _OVERSHOOT_MM).translate((x, y, 0.0))
        for x in (-HOLE_OFFSET_MM, HOLE_OFFSET_MM)
        for y in (-HOLE_OFFSET_MM, HOLE_OFFSET_MM)
    ]
    return (
        _part_at("plate", block, limb_from_plate, "join"),
        *(_part_at("plate hole", mesh_of(hole), limb_from_plate, "cut") for hole in holes),
    )


def pyramid(limb_from_plate: Rigid, height_mm: float) -> Part:
    """A male pyramid under a plate, wider at its end by 15 degrees to each side.

    Its form is general knowledge of the trade: check it against the part that it has to fit.
    """
    start_mm = _PYRAMID_END_MM - 2 * height_mm * float(np.tan(np.radians(_PYRAMID_DEG)))
    grown = _PYRAMID_END_MM / start_mm
    wide = CrossSection.square((start_mm, start_mm), center=True)
    below = wide.extrude(height_mm, 0, 0.0, (grown, grown)).rotate((180.0, 0.0, 0.0))
    neck = wide.extrude(2 * _OVERSHOOT_MM).translate((0.0, 0.0, -_OVERSHOOT_MM))
    return _part_at("pyramid", mesh_of(below + neck), limb_from_plate, "join")


def hole(
    name: str, place_mm: Vector3, way: Vector3, *, diameter_mm: float, depth_mm: float
) -> Part:
    """A round hole through a place, `depth_mm` to either side along a direction."""
    drill = mesh_of(_cylinder(diameter_mm / 2, -depth_mm, depth_mm))
    return _part_at(name, drill, frame_along(place_mm, way), "cut")


def imported_part(
    name: str, solid: Mesh, limb_from_part: Rigid, how: Literal["join", "cut"]
) -> Part:
    """A body of another maker, as a lock or a valve, read from its file.

    Raises:
        EditError: it is not closed.
    """
    _manifold(solid, name)
    return _part_at(name, solid, limb_from_part, how)


def frame_along(place_mm: Vector3, way: Vector3) -> Rigid:
    """A frame at a place whose Z axis points in a direction."""
    forward = way / np.linalg.norm(way)
    across = np.cross(axis_across(forward), forward)
    across /= np.linalg.norm(across)
    return Rigid(np.column_stack([across, np.cross(forward, across), forward]), place_mm)


def _part_at(name: str, solid: Mesh, motion: Rigid, how: Literal["join", "cut"]) -> Part:
    placed = solid.moved(motion)
    return Part(solid=placed, how=how, name=name)


def _cylinder(radius_mm: float, low_mm: float, high_mm: float) -> Manifold:
    return Manifold.cylinder(high_mm - low_mm, radius_mm, radius_mm, _CIRCLE_SEGMENTS).translate(
        (0.0, 0.0, low_mm)
    )


def _manifold(mesh: Mesh, name: str) -> Manifold:
    made = Manifold(
        manifold3d.Mesh64(
            np.ascontiguousarray(mesh.vertices_mm, np.float64),
            np.ascontiguousarray(mesh.faces, np.uint64),
        )
    )
    if made.status() != manifold3d.Error.NoError or volume_mm3(mesh) <= 0:
        raise EditError("device.part.open", name=name)
    return made


def mesh_of(made: Manifold) -> Mesh:
    found = made.to_mesh64()
    return Mesh(
        vertices_mm=np.array(found.vert_properties[:, :3], np.float64),
        faces=np.array(found.tri_verts, np.int64).astype(np.int32),
    )
