"""Expansion: plaster added to the borders of the sole, where flesh spreads under load."""

from typing import Annotated

import numpy as np

from limbgram.core.request_fields import Within
from limbgram.workbench.anatomy.surface_lines import smoothstep
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.sole import SOLE_PLACES, Sole, normalised
from limbgram.workbench.limb import Kind, Limb

_HEEL_AT = 0.18
"""Middle of the heel, as a share of heel to ball."""


@edit(
    group="orthosis",
    order=13,
    effect=Effect(moves_skin=True),
    kinds=("foot",),
    example={"lateral_mm": 4.0, "heel_mm": 3.0},
)
class Expansion(Edit):
    """Expand the lateral border and the heel near the sole, where flesh spreads under load."""

    lateral_mm: Annotated[float, Within(0, 15)] = 4.0
    """Outwards at the lateral border."""
    heel_mm: Annotated[float, Within(0, 15)] = 3.0
    """Outwards round the heel."""
    height_mm: Annotated[float, Within(5, 60)] = 20.0
    """Above the plantar plane at which it has run out."""

    words = spoken(
        en=Words(name="Expansion", title="The expansion"),
        de=Words(
            name="Weichteilzugabe",
            title="Die Weichteilzugabe",
            does="Den lateralen Rand und die Ferse nahe der Sohle aufbauen, wo sich Gewebe unter "
            "Last ausbreitet.",
            labels={"lateral_mm": "Lateral", "heel_mm": "Ferse", "height_mm": "Höhe"},
            help={
                "lateral_mm": "Nach außen am lateralen Rand.",
                "heel_mm": "Nach außen um die Ferse.",
                "height_mm": "Über der Plantarebene, in der sie ausgelaufen ist.",
            },
        ),
    )

    def places_of(self, kind: Kind) -> set[str]:
        return kind.names_in(SOLE_PLACES)

    def apply(self, limb: Limb) -> Limb:
        """Move the borders outwards, level with the sole.

        Raises:
            EditError: a landmark is missing.
        """
        sole = Sole.over_marked_places(limb)
        x, y, z = sole.points_mm.T
        length, edge = sole.length_mm, sole.lateral_mm
        low = 1 - smoothstep(2 * z / self.height_mm - 1)
        side = (
            smoothstep(x / edge)
            * smoothstep(4 * y / length - 0.4)
            * smoothstep((1.1 - y / length) / 0.2)
        )
        middle = _HEEL_AT * length
        away = np.column_stack([x, y - middle])
        reach = np.linalg.norm(away, axis=1)
        back = smoothstep(reach / (0.8 * middle)) * smoothstep((1.5 * middle - y) / middle)
        steps = np.zeros_like(sole.points_mm)
        steps[:, 0] = self.lateral_mm * normalised(side * low)
        outwards = away / np.maximum(reach, 1e-9)[:, None]
        steps[:, :2] += self.heel_mm * normalised(back * low)[:, None] * outwards
        return sole.moved(steps)
