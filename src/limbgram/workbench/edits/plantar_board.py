"""Plantar board: heel and metatarsal heads made flat, as if the cast were pressed on a board."""

from typing import Annotated

import numpy as np

from limbgram.core.request_fields import Within
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.sole import SOLE_PLACES, Sole
from limbgram.workbench.limb import Kind, Limb


@edit(
    group="orthosis",
    order=10,
    effect=Effect(moves_skin=True),
    kinds=("foot",),
    example={"depth_mm": 2.0},
)
class PlantarBoard(Edit):
    """Flatten the sole to a board, parallel to the plantar plane."""

    depth_mm: Annotated[float, Within(0, 10)] = 1.0
    """How far the board lies above the plantar plane: so much is taken off heel and ball."""
    blend_mm: Annotated[float, Within(0, 10)] = 2.0
    """Height above the board over which the sole runs into it."""

    words = spoken(
        en=Words(name="Plantar board", title="The plantar board"),
        de=Words(
            name="Plantarbrett",
            title="Das Plantarbrett",
            does="Die Sohle zu einem Brett abflachen, das parallel zur Plantarebene liegt.",
            labels={"depth_mm": "Tiefe", "blend_mm": "Übergang"},
            help={
                "depth_mm": "Wie hoch das Brett über der Plantarebene liegt: so viel geht an Ferse "
                "und Ballen ab.",
                "blend_mm": "Höhe über dem Brett, über die die Sohle in es übergeht.",
            },
        ),
    )

    def places_of(self, kind: Kind) -> set[str]:
        return kind.names_in(SOLE_PLACES)

    def apply(self, limb: Limb) -> Limb:
        """Move what lies below the board onto it, and what lies just above a little down to it.

        Raises:
            EditError: a landmark is missing.
        """
        sole = Sole.over_marked_places(limb)
        high = sole.points_mm[:, 2] - self.depth_mm
        steps = np.zeros_like(sole.points_mm)
        below = sole.plantar & (high < 0)
        steps[below, 2] = -high[below]
        if self.blend_mm > 0:
            near = sole.plantar & (high >= 0) & (high < self.blend_mm)
            share = high[near] / self.blend_mm
            steps[near, 2] = self.blend_mm * (share**2 * (2 - share) - share)
        return sole.moved(steps)
