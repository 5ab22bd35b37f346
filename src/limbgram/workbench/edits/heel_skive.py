"""Heel skive: a slanting flat on one side of the heel, as plaster is rasped off."""

from typing import Annotated, Literal

import numpy as np

from limbgram.core.errors import EditError
from limbgram.core.request_fields import Within
from limbgram.workbench.anatomy.surface_lines import smoothstep
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.sole import SOLE_PLACES, Sole
from limbgram.workbench.limb import Kind, Limb


@edit(
    group="orthosis",
    order=12,
    effect=Effect(moves_skin=True),
    kinds=("foot",),
    example={"depth_mm": 4.0},
)
class HeelSkive(Edit):
    """Skive the heel: take a slanting flat off one side, so that the orthosis pushes there."""

    depth_mm: Annotated[float, Within(0, 10)] = 4.0
    """At the deepest place; usual are 2, 4 and 6."""
    tilt_deg: Annotated[float, Within(0, 30)] = 15.0
    """Of the flat to the plantar plane."""
    border: Literal["medial", "lateral"] = "medial"
    """The side of the heel."""
    reach: Annotated[float, Within(0.1, 0.6)] = 0.35
    """How far to the front it reaches, as a share of heel to ball."""

    words = spoken(
        en=Words(name="Heel skive", title="The heel skive"),
        de=Words(
            name="Fersenskive",
            title="Der Fersenskive",
            does="An einer Seite der Ferse eine schräge Fläche abtragen, damit die Orthese dort "
            "drückt.",
            labels={
                "depth_mm": "Tiefe",
                "tilt_deg": "Neigung",
                "border": "Seite",
                "reach": "Reichweite",
            },
            help={
                "depth_mm": "An der tiefsten Stelle; üblich sind 2, 4 und 6.",
                "tilt_deg": "Der Fläche zur Plantarebene.",
                "border": "Die Seite der Ferse.",
                "reach": "Wie weit nach vorn sie reicht, als Anteil von Ferse bis Ballen.",
            },
            choices={"medial": "medial", "lateral": "lateral"},
        ),
    )

    def places_of(self, kind: Kind) -> set[str]:
        return kind.names_in(SOLE_PLACES)

    def apply(self, limb: Limb) -> Limb:
        """Move what lies below the slanting plane up onto it, running out to the front.

        Raises:
            EditError: a landmark is missing, or the surface has no heel.
        """
        sole = Sole.of(limb)
        x, y, z = sole.points_mm.T
        front = 1 - smoothstep(y / (self.reach * sole.length_mm) * 2 - 1)
        heel = sole.plantar & (front > 0)
        if not heel.any():
            raise EditError("edit.heel_skive.no_heel")
        outwards = x if self.border == "lateral" else -x
        cut = outwards * np.tan(np.radians(self.tilt_deg)) - z
        # As deep as no vertex moves farther than was asked, and one moves as far.
        cut += (self.depth_mm / front[heel] - cut[heel]).min()
        return sole.moved(np.outer(np.maximum(cut, 0) * front * sole.plantar, [0.0, 0.0, 1.0]))
