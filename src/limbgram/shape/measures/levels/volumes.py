"""Volumes between two heights: the clipped solid, exactly, without building it.

Method  divergence of (x, y, 0) / 2: its flux through level caps is nothing, so the volume is the
        flux through the clipped triangles alone. What of a triangle lies below a height is itself
        told by three numbers, the integrals of its barycentric coordinates.
Fails   MeasureError: the surface is open between the heights.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.errors import MeasureError
from limbgram.shape.measures.levels.figures import Figure, Sigmas
from limbgram.surface.topology import boundary_half_edges
from limbgram.surface.uncertainty import propagate

DISTAL_END, PROXIMAL_END = -np.inf, np.inf
"""Heights that stand for the ends of a closed surface."""


@dataclass(frozen=True, kw_only=True)
class Volumes:
    """Volumes of one mesh in the limb frame; prepared once for many heights."""

    sigmas: Sigmas
    heights: Float64[np.ndarray, "f 3"]
    lowest: Float64[np.ndarray, " f"]
    highest: Float64[np.ndarray, " f"]
    lifts: Float64[np.ndarray, "f 3"]
    """Volume that a face gains while a corner's vertex goes a millimetre along its normal."""
    flux: Float64[np.ndarray, "f 3"]
    """Through a face where a corner's barycentric coordinate would be 1 all over it."""
    tops: Float64[np.ndarray, " f"]
    """Highest corners of the faces, rising."""
    sums: Float64[np.ndarray, " f+1"]
    """Flux through all faces up to each of those."""
    border: Float64[np.ndarray, "b 2"]
    """Lowest and highest end of each open edge."""

    @classmethod
    def of(cls, sigmas: Sigmas) -> "Volumes":
        mesh = sigmas.mesh
        heights = mesh.vertices_mm[:, 2][mesh.faces]
        lowest = np.minimum(np.minimum(heights[:, 0], heights[:, 1]), heights[:, 2])
        highest = np.maximum(np.maximum(heights[:, 0], heights[:, 1]), heights[:, 2])
        flat = (mesh.vertices_mm[:, :2] - mesh.vertices_mm[:, :2].mean(0))[mesh.faces]
        half_normals = mesh.face_normals() / 2
        flux = 0.5 * np.einsum("fkd,fd->fk", flat, half_normals[:, :2])
        order = np.argsort(highest, kind="stable")
        border = mesh.vertices_mm[:, 2][boundary_half_edges(mesh.faces)]
        return cls(
            sigmas=sigmas,
            heights=heights,
            lowest=lowest,
            highest=highest,
            lifts=np.einsum("fkd,fd->fk", sigmas.normals[mesh.faces], half_normals),
            flux=flux,
            tops=highest[order],
            sums=np.concatenate([[0.0], np.cumsum(flux.sum(1)[order] / 3)]),
            border=np.sort(border, axis=1),
        )

    def between(self, low_mm: float, high_mm: float) -> Figure:
        """Volume between two heights, mm3; negative where they are swapped or faces are inside out.

        Raises:
            MeasureError: the surface is open between the heights, or one misses the limb.
        """
        self._require_whole(min(low_mm, high_mm), max(low_mm, high_mm))
        value = self._below(high_mm) - self._below(low_mm)
        if self.sigmas.mesh.sigma_mm is None:
            return Figure(value, None)
        return Figure(value, propagate(self.sigmas.mesh, self.gradient(low_mm, high_mm)))

    def gradient(self, low_mm: float, high_mm: float) -> Float64[np.ndarray, " n"]:
        """Change of the volume for a millimetre of each vertex along its normal."""
        faces = self.sigmas.mesh.faces
        low, high = min(low_mm, high_mm), max(low_mm, high_mm)
        within = np.flatnonzero((self.highest > low) & (self.lowest < high))
        heights = self.heights[within]
        parts = parts_below(heights, high_mm) - parts_below(heights, low_mm)
        changes = (parts * self.lifts[within]).ravel()
        return np.bincount(faces[within].ravel(), changes, len(self.sigmas.mesh.vertices_mm))

    def _below(self, height_mm: float) -> float:
        crossed = np.flatnonzero((self.lowest < height_mm) & (self.highest > height_mm))
        parts = parts_below(self.heights[crossed], height_mm)
        whole = self.sums[np.searchsorted(self.tops, height_mm, side="right")]
        return float(whole) + float((parts * self.flux[crossed]).sum())

    def _require_whole(self, low_mm: float, high_mm: float) -> None:
        ends = float(self.lowest.min()), float(self.tops[-1])
        for height in (low_mm, high_mm):
            if np.isnan(height) or (np.isfinite(height) and not ends[0] <= height <= ends[1]):
                raise MeasureError(
                    f"There is no volume up to {height:.2f} mm: the limb reaches from "
                    f"{ends[0]:.2f} to {ends[1]:.2f} mm. Choose heights between them, or `end`."
                )
        open_here = (self.border[:, 0] < high_mm) & (self.border[:, 1] > low_mm)
        if open_here.any():
            lowest, highest = self.border[open_here].min(), self.border[open_here].max()
            raise MeasureError(
                f"There is no volume between {_end(low_mm)} and {_end(high_mm)}: the surface is "
                f"open there, from {lowest:.2f} to {highest:.2f} mm. Choose heights that are "
                "clear of the brim and of holes, or fill the holes."
            )


def parts_below(
    heights: Float64[np.ndarray, "f 3"], height_mm: float
) -> Float64[np.ndarray, "f 3"]:
    """Means of the barycentric coordinates over each face, taken below a height only.

    A third each for a face that lies below it, nothing for one above.
    """
    if not np.isfinite(height_mm):
        return np.full(heights.shape, 1 / 3 if height_mm > 0 else 0.0)
    below = heights <= height_mm
    count = below[:, 0].astype(np.int8) + below[:, 1] + below[:, 2]
    parts = np.where((count == 3)[:, None], 1 / 3, np.zeros(heights.shape))
    for lone_below in (True, False):
        rows = np.flatnonzero(count == (1 if lone_below else 2))
        lone = (below[rows] == lone_below).argmax(1)
        order = (lone[:, None] + np.arange(3)) % 3
        apex, one, two = np.take_along_axis(heights[rows], order, axis=1).T
        # Shares of the lone corner's two sides that its small triangle takes.
        s, t = (height_mm - apex) / (one - apex), (height_mm - apex) / (two - apex)
        small = np.column_stack([3 - s - t, s, t]) * (s * t / 3)[:, None]
        values = small if lone_below else 1 / 3 - small
        parts[rows[:, None], order] = values
    return parts


def _end(height_mm: float) -> str:
    return f"{height_mm:.2f} mm" if np.isfinite(height_mm) else "the end"
