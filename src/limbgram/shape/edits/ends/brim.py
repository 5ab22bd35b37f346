"""Edits at the proximal end: the brim raised, and flared."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.errors import EditError
from limbgram.shape.edits.guard import require_sound
from limbgram.shape.edits.marking.axis import middles_mm
from limbgram.shape.edits.marking.distances import distances_from
from limbgram.shape.edits.marking.fineness import refine_where
from limbgram.shape.edits.marking.growth import with_added
from limbgram.shape.edits.marking.neighbours import calm_normals
from limbgram.shape.edits.marking.places import (
    axes_in_mesh,
    displaced,
    frame_of,
    in_limb_frame,
    moved_by,
)
from limbgram.shape.limb import Limb
from limbgram.surface.topology import boundary_loops

_STEEPEST = 0.5
"""Slope with which an extension may begin, mm outwards for each mm up."""
_CALM_SHARE = 0.1
"""Part of the brim over which that slope is averaged, to either side."""
_MOST_ROWS = 100
"""Of triangles up an extension: a brim that was made fine would give it millions."""
_FINENESS = 8.0
_FINEST_MM = 0.4


@dataclass(frozen=True, kw_only=True)
class Extension:
    """Raise the brim along the limb's axis to a level edge."""

    length_mm: float
    """From the highest point of the brim as it is to the new, level edge."""


@dataclass(frozen=True, kw_only=True)
class Flare:
    """Bend the brim outwards."""

    depth_mm: float
    """Outwards from the axis, at the brim itself."""
    height_mm: float
    """Width of the bent band, over the surface."""


def require_length(edit: Extension, what: str) -> None:
    """Refuse a length that makes sense on no limb.

    Raises:
        EditError: it is not above 0 mm.
    """
    if edit.length_mm <= 0:
        raise EditError(f"{what} needs a length above 0 mm.")


def require_flare(edit: Flare, what: str) -> None:
    """Refuse a flare that makes sense on no limb.

    Raises:
        EditError: its depth or height is not above 0 mm.
    """
    if edit.depth_mm <= 0 or edit.height_mm <= 0:
        raise EditError(f"{what} needs a depth and a height above 0 mm.")


def extension(limb: Limb, edit: Extension) -> Limb:
    """Add a wall from the brim to a level edge; it goes on with the slope, and turns to the axis.

    Raises:
        EditError: no open brim, or a wall that would cut through the limb.
    """
    what = "The extension"
    require_length(edit, what)
    loop = brim_loop(limb, what)
    points = in_limb_frame(limb, what)
    start = points[loop]
    rise = start[:, 2].max() + edit.length_mm - start[:, 2]
    slope = _slope(limb, loop, points, what)
    edge = np.linalg.norm(np.roll(start, -1, axis=0) - start, axis=1)
    rows = max(2, int(np.ceil(rise.max() / max(float(np.median(edge)), 0.5))))
    rows = min(rows, _MOST_ROWS)
    share = (np.arange(1, rows + 1) / rows)[:, None]
    up = share * rise
    out = (share - share**2 / 2) * rise * slope[:, 2]
    ring = np.stack(
        [start[:, 0] + out * slope[:, 0], start[:, 1] + out * slope[:, 1], start[:, 2] + up], axis=2
    )
    count = len(loop)
    number = np.concatenate(
        [loop[None], len(limb.mesh) + np.arange(rows * count).reshape(rows, -1)]
    )
    here, ahead = number, np.roll(number, -1, axis=1)
    # The old faces run along the loop; the new ones below each row run against it.
    one = np.stack([ahead[:-1], here[:-1], here[1:]], axis=-1)
    two = np.stack([ahead[:-1], here[1:], ahead[1:]], axis=-1)
    faces = np.concatenate([one.reshape(-1, 3), two.reshape(-1, 3)]).astype(np.int32)
    places = moved_by(frame_of(limb, what).limb_from_mesh.inverse, ring.reshape(-1, 3))
    grown = with_added(limb.mesh, places, np.tile(loop, rows).astype(np.int64), faces)
    require_sound(what, limb.mesh, grown)
    return limb.with_mesh(grown)


def flare(limb: Limb, edit: Flare) -> Limb:
    """Move a band at the brim outwards, most at the brim itself.

    Raises:
        EditError: no open brim, or a surface that would fold.
    """
    what = "The flare"
    require_flare(edit, what)
    loop = brim_loop(limb, what)
    reached = np.isfinite(_from_brim_mm(limb, loop, edit.height_mm))
    close = np.asarray(reached[limb.mesh.faces].any(1))
    edge_mm = max(edit.height_mm / _FINENESS, _FINEST_MM)
    limb = limb.with_mesh(refine_where(limb.mesh, close, edge_mm))
    distance = _from_brim_mm(limb, brim_loop(limb, what), edit.height_mm)
    weight = np.clip(1 - distance / edit.height_mm, 0, 1) ** 2
    points = in_limb_frame(limb, what)
    outward = points - middles_mm(limb, points, what)
    outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-12)
    x_axis, y_axis, _ = axes_in_mesh(limb, what)
    step = edit.depth_mm * weight[:, None] * (outward[:, :1] * x_axis + outward[:, 1:2] * y_axis)
    changed = displaced(limb, limb.mesh.vertices_mm + step)
    require_sound(what, limb.mesh, changed.mesh)
    return changed


def brim_loop(limb: Limb, what: str) -> Int64[np.ndarray, " b"]:
    """The proximal opening: the longest loop of open edges in the upper half of the limb.

    Raises:
        EditError: the shape is closed there.
    """
    heights = in_limb_frame(limb, what)[:, 2]
    middle = (heights.min() + heights.max()) / 2
    upper = [loop for loop in boundary_loops(limb.mesh.faces) if heights[loop].mean() > middle]
    if not upper:
        raise EditError(
            f"{what} works on the open brim, and this shape has none at its proximal end. Cut it "
            "open by a plane or a trimline first."
        )
    ends = limb.mesh.vertices_mm
    lengths = [np.linalg.norm(ends[loop] - ends[np.roll(loop, -1)], axis=1).sum() for loop in upper]
    return upper[int(np.argmax(lengths))].astype(np.int64)


def _slope(
    limb: Limb, loop: Int64[np.ndarray, " b"], points: Float64[np.ndarray, "n 3"], what: str
) -> Float64[np.ndarray, "b 3"]:
    """At each vertex of the brim: direction outwards (x, y), and mm outwards for each mm up."""
    motion = frame_of(limb, what).limb_from_mesh
    normals = np.einsum("nj,ij->ni", calm_normals(limb.mesh)[loop], motion.rotation)
    outward = (points - middles_mm(limb, points, what))[loop, :2]
    outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-12)
    across = (normals[:, :2] * outward).sum(1)
    steep = np.clip(-normals[:, 2] / np.maximum(across, 0.2), -_STEEPEST, _STEEPEST)
    reach = max(1, int(_CALM_SHARE * len(loop)))
    around = sum((np.roll(steep, shift) for shift in range(-reach, reach + 1)), np.zeros(len(loop)))
    return np.column_stack([outward, around / (2 * reach + 1)])


def _from_brim_mm(
    limb: Limb, loop: Int64[np.ndarray, " b"], reach_mm: float
) -> Float64[np.ndarray, " n"]:
    """Distance of each vertex from the brim, over the surface; infinite beyond the reach."""
    start = np.full(len(limb.mesh), np.inf)
    start[loop] = 0.0
    return distances_from(limb.mesh, start, np.ones(len(limb.mesh), np.bool_), reach_mm)
