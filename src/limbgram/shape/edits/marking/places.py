"""Places: landmarks by name, points in a stated frame, and heights along the limb's axis.

A place is the name of a landmark, or three coordinates in millimetres. Edits say in which frame
their coordinates are: "limb" (origin distal, +Z proximal, +Y anterior, +X right) or "mesh".
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.errors import EditError
from limbgram.geometry.arrays import Points3, Vector3
from limbgram.geometry.rigid import Rigid
from limbgram.shape.limb import Landmark, Limb, LimbFrame, likeliest
from limbgram.surface.closest import TriangleTree

Place = str | tuple[float, float, float]
"""The name of a landmark, or x, y, z in millimetres."""
FrameName = Literal["limb", "mesh"]

_FARTHEST_MM = 10.0
"""A place further from the surface than this is a mistake."""


def frame_of(limb: Limb, what: str) -> LimbFrame:
    """The limb's frame.

    Raises:
        EditError: the limb has not been aligned.
    """
    if limb.frame is None:
        raise EditError(
            f"{what} needs to know where the limb's axis lies. Align the shape first "
            "(`limbgram align`)."
        )
    return limb.frame


def moved_by(motion: Rigid, points: Points3) -> Points3:
    """`motion.apply`, summed in one order whatever the number of threads."""
    return np.einsum("nj,ij->ni", points, motion.rotation) + motion.translation


def in_limb_frame(limb: Limb, what: str) -> Points3:
    """The mesh's vertices in the limb frame."""
    return moved_by(frame_of(limb, what).limb_from_mesh, limb.mesh.vertices_mm)


def axes_in_mesh(limb: Limb, what: str) -> Float64[np.ndarray, "3 3"]:
    """Rows: directions of the limb's X, Y and Z in the mesh's frame."""
    return frame_of(limb, what).limb_from_mesh.rotation


def position_mm(limb: Limb, place: Place, frame: FrameName, what: str) -> Vector3:
    """A place in the mesh's frame.

    Raises:
        EditError: there is no landmark of the name, or no frame for the coordinates.
    """
    if isinstance(place, str):
        for mark in limb.landmarks:
            if mark.name == place:
                return mark.position_mm
        known = ", ".join(f'"{mark.name}"' for mark in limb.landmarks) or "none"
        raise EditError(
            f'{what} names the landmark "{place}", which this limb does not have. '
            f"It has: {known}.{likeliest(place, (mark.name for mark in limb.landmarks))} Pick it, "
            "or give coordinates."
        )
    point = np.array(place, np.float64)
    if frame == "mesh":
        return point
    return moved_by(frame_of(limb, what).limb_from_mesh.inverse, point[None])[0]


def require_ring(places: Sequence[Place], what: str) -> None:
    """Refuse places that make no closed curve.

    Raises:
        EditError: fewer than three, or one of them twice in a row.
    """
    if len(places) < 3:
        raise EditError(f"{what} needs a closed curve of at least 3 points, in order round it.")
    if any(one == other for one, other in pairwise((*places, places[0]))):
        raise EditError(f"{what}: two points in a row are the same. Leave one of them out.")


def on_surface(limb: Limb, points_mm: Points3, what: str) -> Points3:
    """Points in the mesh's frame moved to the nearest places on the surface.

    Raises:
        EditError: a point is so far off that it cannot be meant to lie on the surface.
    """
    closest = TriangleTree.of(limb.mesh.vertices_mm, limb.mesh.faces).closest(points_mm)
    worst = int(np.argmax(closest.distances_mm))
    if closest.distances_mm[worst] > _FARTHEST_MM:
        x, y, z = points_mm[worst]
        raise EditError(
            f"{what}: the point ({x:.1f}, {y:.1f}, {z:.1f}) mm in the mesh's frame lies "
            f"{closest.distances_mm[worst]:.1f} mm from the surface. Pick it on the surface; "
            "perhaps it was given in another frame, or an earlier edit cut that part off."
        )
    return closest.points_mm


def height_mm(limb: Limb, height: float, above: str, what: str) -> float:
    """A height along the limb's axis: above its origin, or above a landmark if one is named."""
    if not above:
        return height
    point = position_mm(limb, above, "mesh", what)
    base = moved_by(frame_of(limb, what).limb_from_mesh, point[None])[0, 2]
    return float(base) + height


def displaced(limb: Limb, vertices_mm: Points3) -> Limb:
    """The limb with moved vertices; landmarks on its surface move with it."""
    old = limb.mesh
    new = old.with_vertices(vertices_mm)
    if not limb.landmarks:
        return replace(limb, mesh=new)
    points = np.stack([mark.position_mm for mark in limb.landmarks])
    closest = TriangleTree.of(old.vertices_mm, old.faces).closest(points)
    shares = corner_shares(old.vertices_mm[old.faces[closest.faces]], closest.points_mm)
    moves = (vertices_mm - old.vertices_mm)[old.faces[closest.faces]]
    near = closest.distances_mm <= _FARTHEST_MM
    shifts = (shares[:, :, None] * moves).sum(1) * near[:, None]
    marks = tuple(
        Landmark(name=mark.name, position_mm=mark.position_mm + shift)
        for mark, shift in zip(limb.landmarks, shifts, strict=True)
    )
    return replace(limb, mesh=new, landmarks=marks)


def corner_shares(corners: Float64[np.ndarray, "k 3 3"], points: Points3) -> Points3:
    """Weights of three corners that give points in their planes."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    size = np.maximum((normal * normal).sum(1), 1e-30)
    of_a = (np.cross(c - b, points - b) * normal).sum(1) / size
    of_b = (np.cross(a - c, points - c) * normal).sum(1) / size
    return np.stack([of_a, of_b, 1 - of_a - of_b], axis=1)
