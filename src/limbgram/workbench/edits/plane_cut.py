"""Plane cut: the limb cut by a plane across its axis."""

from typing import Annotated

import numpy as np

from limbgram.core.errors import EditError
from limbgram.core.request_fields import Within
from limbgram.workbench.edits.cutting import ON_CUT_MM, Part, cap, keep_positive
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.regions import height_mm, points_in_limb_frame, section_centres_mm
from limbgram.workbench.limb import Limb

_STEEPEST_DEG = 80
"""What is steeper no longer lies across the limb."""


@edit(
    group="cuts",
    order=1,
    effect=Effect(reports_displacement=False, volume="cuts"),
    everyday=True,
    rarely=("forward_deg", "right_deg"),
    example={"height_mm": 60.0, "forward_deg": 10.0},
)
class PlaneCut(Edit):
    """Cut by a plane across the limb's axis."""

    height_mm: float
    """Where the plane meets the middle of the limb."""
    above: str = ""
    """Landmark from which the height counts; without it the distal end's origin."""
    forward_deg: Annotated[float, Within(-_STEEPEST_DEG, _STEEPEST_DEG)] = 0.0
    """Tilt: how much the plane rises towards posterior (its normal leans to anterior). To cut along
    the limb there is the trimline."""
    right_deg: Annotated[float, Within(-_STEEPEST_DEG, _STEEPEST_DEG)] = 0.0
    """Tilt: how much the plane rises towards the left (its normal leans to the patient's right).
    To cut along the limb there is the trimline."""
    keep: Part = "distal"
    """Which part stays."""
    capped: bool = False
    """Whether the cut is closed by a flat surface; that of a solid always is."""

    words = spoken(
        en=Words(
            name="Cut level",
            title="The plane cut",
            labels={
                "above": "Height counts from",
                "forward_deg": "Rises backwards",
                "right_deg": "Rises to the left",
                "keep": "Which part stays",
                "capped": "Close the cut",
            },
            choices={"distal": "the distal part", "proximal": "the proximal part"},
        ),
        de=Words(
            name="Eben schneiden",
            title="Der ebene Schnitt",
            does="Mit einer Ebene quer zur Achse schneiden.",
            labels={
                "height_mm": "Höhe",
                "above": "Höhe zählt ab",
                "forward_deg": "Steigt nach hinten",
                "right_deg": "Steigt nach links",
                "keep": "Welcher Teil bleibt",
                "capped": "Schnitt schließen",
            },
            help={
                "height_mm": "Wo die Ebene die Mitte des Gliedmaßes trifft.",
                "above": "Landmarke, ab der die Höhe zählt; sonst ab dem distalen Ende.",
                "forward_deg": "Neigung: wie viel die Ebene nach hinten steigt (ihre Senkrechte "
                "neigt sich nach vorn). Längs des Gliedmaßes schneidet die Randlinie.",
                "right_deg": "Neigung: wie viel die Ebene nach links steigt (ihre Senkrechte neigt "
                "sich nach rechts des Patienten). Längs des Gliedmaßes schneidet die Randlinie.",
                "keep": "Welcher Teil bleibt.",
                "capped": "Ob der Schnitt mit einer ebenen Fläche geschlossen wird; der eines "
                "Körpers wird es immer.",
            },
            choices={"distal": "der distale Teil", "proximal": "der proximale Teil"},
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Cut by a plane; triangles across it are split, so the new edge lies in it.

        Raises:
            EditError: the plane misses the shape, or cannot be closed.
        """
        level = height_mm(limb, self.height_mm, self.above)
        points = points_in_limb_frame(limb)
        middle = section_centres_mm(limb, np.array([[0.0, 0.0, level]]))[0]
        tilt = np.tan(np.radians([self.right_deg, self.forward_deg]))
        normal = np.array([tilt[0], tilt[1], 1.0])
        normal /= np.linalg.norm(normal)
        values = ((points - middle) * normal).sum(1) * (1.0 if self.keep == "proximal" else -1.0)
        if not (values > ON_CUT_MM).any() or not (values < -ON_CUT_MM).any():
            low, high = float(points[:, 2].min()), float(points[:, 2].max())
            raise EditError("edit.cut.misses", height_mm=level, low_mm=low, high_mm=high)
        cut = keep_positive(limb.mesh, values)
        return limb.with_mesh(cap(cut.mesh, cut.on_cut) if self.capped else cut.mesh)
