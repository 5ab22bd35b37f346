"""Straps: whether their slots lie where something speaks against it.

In      the body of the positive, the slots of straps as they were placed, and the recipe.
Out     a doubt for each strap that runs over a place which bears no pressure, or half into a roll;
        how wide straps above each other may be.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np

from limbgram.findings import Finding, doubt
from limbgram.workbench.devices.body import Body
from limbgram.workbench.devices.device import Slot
from limbgram.workbench.devices.layout import Opening
from limbgram.workbench.devices.trims import amount_of, place_point
from limbgram.workbench.edits.regions import height_mm
from limbgram.workbench.edits.roll import Roll
from limbgram.workbench.frame.sensitive import sensitive_place
from limbgram.workbench.recipe.recipe import Recipe


def straps_told(
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


def widest_straps_mm(
    body: Body, slots: Sequence[Slot], values: Mapping[str, float], bridge_mm: float
) -> float | None:
    """How wide straps above each other may be, all alike, in whole millimetres.

    Heights of slots and their lengths are straight in the straps' width, so two widths tell where a
    bridge is left between each two. It is counted straight up; over the surface it is wider.

    Args:
        bridge_mm: What has to stay between two slots.

    Returns:
        None where there are no two straps, or no width fits.
    """
    by_strap = {slot.strap: slot for slot in slots if isinstance(slot.strap, str)}

    def places_mm(width_mm: float) -> dict[str, tuple[float, float]]:
        """Of each strap: its slot's height and length."""
        wide = {**values, **dict.fromkeys(by_strap, width_mm)}
        return {
            name: (
                float(place_point(body, slot.name, slot.at, wide)[2]),
                amount_of(slot.length_mm, wide),
            )
            for name, slot in by_strap.items()
        }

    least, wider = places_mm(0.0), places_mm(1.0)
    widest: list[float] = []
    for pair in combinations(sorted(by_strap, key=lambda name: least[name][0]), 2):
        at_least, at_wider = (
            places[pair[1]][0]
            - places[pair[0]][0]
            - 0.5 * (places[pair[0]][1] + places[pair[1]][1])
            - bridge_mm
            for places in (least, wider)
        )
        widest.append(at_least / (at_least - at_wider))
    found = math.floor(min(widest, default=0.0))
    return float(found) if found > 0 else None
