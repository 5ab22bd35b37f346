"""Ends: the brim raised or flared, and the distal end made longer, shorter or rounder."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.topology import boundary_loops
from limbgram.workbench.edits.edit import Effect
from limbgram.workbench.edits.fineness import refine_where
from limbgram.workbench.edits.guard import require_sound
from limbgram.workbench.edits.regional import fading
from limbgram.workbench.edits.regions import (
    axes_in_mesh,
    calm_normals,
    displaced,
    distances_from,
    middles_mm,
    moved_by,
    points_in_limb_frame,
    require_frame,
    with_added,
)
from limbgram.workbench.limb import Limb

_STEEPEST = 0.5
"""Slope with which an extension may begin, mm outwards for each mm up."""
_CALM_SHARE = 0.1
"""Part of the brim over which that slope is averaged, to either side."""
_MOST_ROWS = 100
"""Of triangles up an extension: a brim that was made fine would give it millions."""
_FINENESS = 8.0
_FINEST_MM = 0.4
_BLEND = 0.3
"""Part of the height, from its top, over which the round shape takes over."""


@dataclass(frozen=True, kw_only=True)
class Extension:
    """Raise the brim along the limb's axis to a level edge."""

    length_mm: float
    """From the highest point of the brim as it is to the new, level edge."""

    title: ClassVar[str] = "The extension"
    effect: ClassVar[Effect] = Effect(reports_displacement=False)

    def check(self) -> None:
        """Refuse a length that makes sense on no limb.

        Raises:
            EditError: it is not above 0 mm.
        """
        if self.length_mm <= 0:
            raise EditError("edit.extension.length", what=self.title)

    def apply(self, limb: Limb) -> Limb:
        """Add a wall from the brim to a level edge: it goes on with the slope, then turns upright.

        Raises:
            EditError: no open brim, or a wall that would cut through the limb.
        """
        what = self.title
        loop = brim_loop(limb, what)
        points = points_in_limb_frame(limb, what)
        start = points[loop]
        rise = start[:, 2].max() + self.length_mm - start[:, 2]
        slope = _slope(limb, loop, points, what)
        edge = np.linalg.norm(np.roll(start, -1, axis=0) - start, axis=1)
        rows = max(2, int(np.ceil(rise.max() / max(float(np.median(edge)), 0.5))))
        rows = min(rows, _MOST_ROWS)
        share = (np.arange(1, rows + 1) / rows)[:, None]
        up = share * rise
        out = (share - share**2 / 2) * rise * slope[:, 2]
        ring = np.stack(
            [start[:, 0] + out * slope[:, 0], start[:, 1] + out * slope[:, 1], start[:, 2] + up],
            axis=2,
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
        places = moved_by(require_frame(limb, what).limb_from_mesh.inverse, ring.reshape(-1, 3))
        grown = with_added(limb.mesh, places, np.tile(loop, rows).astype(np.int64), faces)
        require_sound(what, limb.mesh, grown)
        return limb.with_mesh(grown)


@dataclass(frozen=True, kw_only=True)
class Flare:
    """Bend the brim outwards."""

    depth_mm: float
    """Outwards from the axis, at the brim itself."""
    height_mm: float
    """Width of the bent band, over the surface."""

    title: ClassVar[str] = "The flare"
    effect: ClassVar[Effect] = Effect()

    def check(self) -> None:
        """Refuse a flare that makes sense on no limb.

        Raises:
            EditError: its depth or height is not above 0 mm.
        """
        if self.depth_mm <= 0 or self.height_mm <= 0:
            raise EditError("edit.flare.depth", what=self.title)

    def apply(self, limb: Limb) -> Limb:
        """Move a band at the brim outwards, most at the brim itself.

        Raises:
            EditError: no open brim, or a surface that would fold.
        """
        what = self.title
        loop = brim_loop(limb, what)
        reached = np.isfinite(_from_brim_mm(limb, loop, self.height_mm))
        close = np.asarray(reached[limb.mesh.faces].any(1))
        edge_mm = max(self.height_mm / _FINENESS, _FINEST_MM)
        limb = limb.with_mesh(refine_where(limb.mesh, close, edge_mm))
        distance = _from_brim_mm(limb, brim_loop(limb, what), self.height_mm)
        weight = np.clip(1 - distance / self.height_mm, 0, 1) ** 2
        points = points_in_limb_frame(limb, what)
        outward = points - middles_mm(limb, points, what)
        outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-12)
        x_axis, y_axis, _ = axes_in_mesh(limb, what)
        step = (
            self.depth_mm * weight[:, None] * (outward[:, :1] * x_axis + outward[:, 1:2] * y_axis)
        )
        changed = displaced(limb, limb.mesh.vertices_mm + step)
        require_sound(what, limb.mesh, changed.mesh)
        return changed


@dataclass(frozen=True, kw_only=True)
class DistalEnd:
    """Shape the distal end, below a height above its lowest point."""

    height_mm: float
    """How far up from the lowest point the change reaches."""
    lengthen_mm: float = 0.0
    """How much lower the lowest point comes to lie; negative shortens."""
    roundness: float = 0.0
    """0 leaves the shape, 1 makes it half an ellipsoid on the section at that height."""

    title: ClassVar[str] = "The distal end"
    effect: ClassVar[Effect] = Effect(moves_skin=True)

    def check(self) -> None:
        """Refuse numbers that make sense on no limb.

        Raises:
            EditError: a height, a roundness or a shortening out of its range.
        """
        if not self.height_mm > 0:
            raise EditError("edit.end.height", what=self.title)
        if not 0 <= self.roundness <= 1:
            raise EditError("edit.end.roundness", what=self.title, roundness=self.roundness)
        if self.lengthen_mm <= -self.height_mm / 2:
            raise EditError("edit.end.shortened", what=self.title, height_mm=self.height_mm)

    def apply(self, limb: Limb) -> Limb:
        """Lengthen, shorten or round the distal end.

        Raises:
            EditError: numbers that make no sense, or a surface that would fold.
        """
        what = self.title
        points = points_in_limb_frame(limb, what)
        low, high = float(points[:, 2].min()), float(points[:, 2].max())
        if self.height_mm >= high - low:
            raise EditError("edit.end.beyond", what=what, length_mm=high - low)
        top = low + self.height_mm
        depth = np.clip((top - points[:, 2]) / self.height_mm, 0, 1)
        target = points + self.roundness * _towards_round(limb, points, top, self.height_mm, what)
        target[:, 2] -= self.lengthen_mm * (1 - fading(depth))
        axes = axes_in_mesh(limb, what)
        step = np.einsum("nj,jk->nk", target - points, axes)
        changed = displaced(limb, limb.mesh.vertices_mm + step)
        require_sound(what, limb.mesh, changed.mesh)
        return changed


def brim_loop(limb: Limb, what: str) -> Int64[np.ndarray, " b"]:
    """The proximal opening: the longest loop of open edges in the upper half of the limb.

    Raises:
        EditError: the shape is closed there.
    """
    heights = points_in_limb_frame(limb, what)[:, 2]
    middle = (heights.min() + heights.max()) / 2
    upper = [loop for loop in boundary_loops(limb.mesh.faces) if heights[loop].mean() > middle]
    if not upper:
        raise EditError("edit.no_brim", what=what)
    ends = limb.mesh.vertices_mm
    lengths = [np.linalg.norm(ends[loop] - ends[np.roll(loop, -1)], axis=1).sum() for loop in upper]
    return upper[int(np.argmax(lengths))].astype(np.int64)


def _slope(
    limb: Limb, loop: Int64[np.ndarray, " b"], points: Float64[np.ndarray, "n 3"], what: str
) -> Float64[np.ndarray, "b 3"]:
    """At each vertex of the brim: direction outwards (x, y), and mm outwards for each mm up."""
    motion = require_frame(limb, what).limb_from_mesh
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
