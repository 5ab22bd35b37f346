"""Straps: whether their slots lie where something speaks against it.

In      the body of the positive, the slots of straps as they were placed, and the recipe.
Out     a doubt for each strap that runs over a place which bears no pressure, or half into a roll.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from limbgram.findings import Finding, doubt
from limbgram.workbench.devices.body import Body
from limbgram.workbench.devices.device import Slot
from limbgram.workbench.devices.layout import Opening
from limbgram.workbench.devices.trims import amount_of
from limbgram.workbench.edits.regions import height_mm
from limbgram.workbench.edits.roll import Roll
from limbgram.workbench.frame.sensitive import sensitive_place
from limbgram.workbench.recipe.recipe import Recipe


def strap_findings(
    body: Body,
    slots: Sequence[Slot],
    openings: Sequence[Opening],
    values: Mapping[str, float],
    recipe: Recipe,
) -> Iterator[Finding]:
    """What speaks against the place of each strap's slots.

    Args:
        openings: As the slots were placed, in the limb frame.
    """
    rolls = [one.edit for one in recipe.entries if one.on and isinstance(one.edit, Roll)]
    for slot, opening in zip(slots, openings, strict=True):
        wide_mm = amount_of(slot.strap, values)
        if not wide_mm > 0:
            continue
        half_mm = wide_mm / 2
        for mark in body.limb.landmarks:
            found = sensitive_place(mark.name, body.limb.kind)
            off = body.place_mm(mark.name) - opening.middle_mm
            along = float(np.clip(off @ opening.along, -half_mm, half_mm))
            away_mm = float(np.linalg.norm(off - along * opening.along))
            if found is not None and away_mm < found.reach_mm:
                yield doubt(
                    "device.strap.on_place",
                    name=slot.name,
                    place=found.name,
                    away_mm=away_mm,
                    why=found.why,
                )
        high_mm = float(opening.middle_mm[2])
        for roll in rolls:
            off_mm = abs(high_mm - height_mm(body.limb, roll.at_mm, roll.above))
            ends_mm = roll.band_mm
            if ends_mm - half_mm < off_mm < ends_mm + half_mm:
                yield doubt("device.strap.roll", name=slot.name, off_mm=off_mm, band_mm=ends_mm)
