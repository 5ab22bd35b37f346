"""Roll: a groove round the limb, as a waist roll holds a brace above the iliac crests."""

from typing import Annotated

import numpy as np

from limbgram.core.errors import EditError
from limbgram.core.request_fields import Within
from limbgram.workbench.edits.edit import AboveZeroMm, Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.regions import (
    axes_in_mesh,
    displaced,
    height_mm,
    points_in_limb_frame,
    section_centres_mm,
)
from limbgram.workbench.edits.sole import bump
from limbgram.workbench.limb import Limb


@edit(
    group="orthosis",
    order=22,
    effect=Effect(moves_skin=True),
    example={"depth_mm": 3.0, "band_mm": 20.0, "at_mm": 60.0},
)
class Roll(Edit):
    """Carve a groove round the limb at a height, most at both sides."""

    depth_mm: AboveZeroMm
    """At its deepest, at the sides."""
    at_mm: float = 0.0
    """Height of its middle."""
    above: str = ""
    """Landmark from which the height counts; without it from the limb's origin."""
    band_mm: AboveZeroMm = 30.0
    """From its middle to where it has run out."""
    front: Annotated[float, Within(0, 1)] = 0.3
    """Of the depth, in front and at the back."""

    words = spoken(
        en=Words(name="Waist roll", title="The roll", labels={"band_mm": "Half width"}),
        de=Words(
            name="Taillenwulst",
            title="Die Taillenrinne",
            does="In einer Höhe eine Rinne um das Gliedmaß abtragen, am tiefsten an beiden Seiten.",
            labels={
                "depth_mm": "Tiefe",
                "at_mm": "Höhe",
                "above": "Über",
                "band_mm": "Halbe Breite",
                "front": "Vorn und hinten",
            },
            help={
                "depth_mm": "An der tiefsten Stelle, an den Seiten.",
                "at_mm": "Höhe ihrer Mitte.",
                "above": "Landmarke, von der die Höhe zählt; sonst vom Ursprung des Gliedmaßes.",
                "band_mm": "Von ihrer Mitte bis dorthin, wo sie ausgelaufen ist.",
                "front": "Anteil der Tiefe vorn und hinten.",
            },
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Move the band towards the middle of its section.

        Raises:
            EditError: the limb is not aligned, has no landmark of the name, or does not reach the
                band.
        """
        points = points_in_limb_frame(limb)
        middle = height_mm(limb, self.at_mm, self.above)
        low, high = float(points[:, 2].min()), float(points[:, 2].max())
        if not low - self.band_mm < middle < high + self.band_mm:
            raise EditError("edit.levels.off_shape", low_mm=low, high_mm=high, nearest_mm=middle)
        outward = points - section_centres_mm(limb, points)
        outward[:, 2] = 0.0
        outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-9)
        aside = self.front + (1 - self.front) * outward[:, 0] ** 2
        depth = self.depth_mm * bump((points[:, 2] - middle) / self.band_mm) * aside
        axes = axes_in_mesh(limb)
        return displaced(limb, limb.mesh.vertices_mm - (depth[:, None] * outward) @ axes)
