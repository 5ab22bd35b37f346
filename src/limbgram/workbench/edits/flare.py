"""Flare: the brim bent outwards."""

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.workbench.edits.brim import brim_loop
from limbgram.workbench.edits.edit import AboveZeroMm, Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.guard import require_sound
from limbgram.workbench.edits.refinement import edge_for_falloff_mm, refine_where
from limbgram.workbench.edits.regions import (
    axes_in_mesh,
    displaced,
    distances_from,
    points_in_limb_frame,
    section_centres_mm,
)
from limbgram.workbench.limb import Limb


@edit(
    group="ends",
    order=2,
    effect=Effect(moves_skin=True),
    everyday=True,
    guarded=False,
    example={"depth_mm": 3.0, "height_mm": 20.0},
)
class Flare(Edit):
    """Bend the brim outwards."""

    depth_mm: AboveZeroMm
    """Outwards from the axis, at the brim itself."""
    height_mm: AboveZeroMm
    """Width of the bent band, over the surface."""

    words = spoken(
        en=Words(name="Bend the brim outwards", title="The flare"),
        de=Words(
            name="Rand ausstellen",
            title="Das Ausstellen des Randes",
            does="Den Rand nach außen biegen.",
            labels={"depth_mm": "Tiefe", "height_mm": "Höhe"},
            help={
                "depth_mm": "Von der Achse nach außen, am Rand selbst.",
                "height_mm": "Breite des gebogenen Streifens, auf der Fläche.",
            },
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Move a band at the brim outwards, most at the brim itself.

        Raises:
            EditError: no open brim, or a surface that would fold.
        """
        loop = brim_loop(limb)
        reached = np.isfinite(_distance_from_brim_mm(limb, loop, self.height_mm))
        close = np.asarray(reached[limb.mesh.faces].any(1))
        edge_mm = edge_for_falloff_mm(self.height_mm)
        limb = limb.with_mesh(refine_where(limb.mesh, close, edge_mm))
        distance = _distance_from_brim_mm(limb, brim_loop(limb), self.height_mm)
        weight = np.clip(1 - distance / self.height_mm, 0, 1) ** 2
        points = points_in_limb_frame(limb)
        outward = points - section_centres_mm(limb, points)
        outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-12)
        x_axis, y_axis, _ = axes_in_mesh(limb)
        step = (
            self.depth_mm * weight[:, None] * (outward[:, :1] * x_axis + outward[:, 1:2] * y_axis)
        )
        changed = displaced(limb, limb.mesh.vertices_mm + step)
        require_sound(limb.mesh, changed.mesh)
        return changed


def _distance_from_brim_mm(
    limb: Limb, loop: Int64[np.ndarray, " b"], reach_mm: float
) -> Float64[np.ndarray, " n"]:
    """Distance of each vertex from the brim, over the surface; infinite beyond the reach."""
    start = np.full(len(limb.mesh), np.inf)
    start[loop] = 0.0
    return distances_from(limb.mesh, start, np.ones(len(limb.mesh), np.bool_), reach_mm)
