"""Arch fill: plaster added under the medial arch."""

from typing import Annotated

import numpy as np

from limbgram.core.request_fields import Within
from limbgram.workbench.anatomy.surface_lines import smoothstep
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.regions import smooth_normals
from limbgram.workbench.edits.sole import SOLE_PLACES, Sole, bump, normalised
from limbgram.workbench.limb import Kind, Limb

_FACING = 0.5
"""Cosine of the surface's turn from straight down up to which it is filled in full: up to 60
degrees. An upright side stays."""


@edit(
    group="orthosis",
    order=11,
    effect=Effect(moves_skin=True),
    kinds=("foot",),
    example={"depth_mm": 3.2},
)
class ArchFill(Edit):
    """Fill the medial arch: the positive grows downwards there, and the orthosis is lower."""

    depth_mm: Annotated[float, Within(0, 15)] = 3.2
    """At the top of the arch; laboratories call 1.6 little, 3.2 standard and 6.4 much. The fill
    never goes below the plantar plane."""
    along: Annotated[float, Within(0.1, 0.5)] = 0.4
    """How far it reaches to the front and back, as a share of heel to ball."""

    words = spoken(
        en=Words(name="Arch fill", title="The arch fill", labels={"along": "Reach"}),
        de=Words(
            name="Gewölbefüllung",
            title="Die Gewölbefüllung",
            does="Das mediale Gewölbe füllen: das Positiv wächst dort nach unten, die Orthese wird "
            "niedriger.",
            labels={"depth_mm": "Tiefe", "along": "Reichweite"},
            help={
                "depth_mm": "Am höchsten Punkt des Gewölbes; Werkstätten nennen 1,6 wenig, 3,2 "
                "üblich und 6,4 viel. Die Füllung geht nie unter die Plantarebene.",
                "along": "Wie weit sie nach vorn und hinten reicht, als Anteil von Ferse bis "
                "Ballen.",
            },
        ),
    )

    def places_of(self, kind: Kind) -> set[str]:
        return kind.names_in(SOLE_PLACES)

    def apply(self, limb: Limb) -> Limb:
        """Move the sole under the navicular down, fading all round.

        Raises:
            EditError: a landmark is missing.
        """
        sole = Sole.over_marked_places(limb)
        x, y, z = sole.points_mm.T
        along = bump((y - sole.arch[1]) / (self.along * sole.length_mm))
        across = smoothstep((sole.lateral_mm - x) / (sole.lateral_mm - sole.medial_mm))
        low = 1 - smoothstep(2 * z / max(float(sole.arch[2]), 1e-9) - 1)
        downwards = -smooth_normals(sole.limb.mesh) @ sole.rotation[2]
        share = normalised(along * across * low * smoothstep(downwards / _FACING))
        down = np.minimum(self.depth_mm * share, np.maximum(z, 0.0))
        return sole.moved(np.outer(down, [0.0, 0.0, -1.0]))
