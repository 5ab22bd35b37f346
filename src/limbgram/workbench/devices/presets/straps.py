"""Straps: pairs of slots near the front edge of an orthosis of the leg, or a trunk's opening.

Margins go from the edge as it was drawn to the slot's nearest side, over the surface.
"""

from dataclasses import replace

from limbgram.core.request_fields import Within
from limbgram.workbench.devices.device import EdgeMargin, Slit, Slot
from limbgram.workbench.devices.trims import Measure, TrimPoint, terms_in

STRAP_BELOW = Measure(
    name="strap_below_mm",
    usual=20.0,
    within=Within(15, 25),
    en="Slots of the calf strap, below the upper edge",
    de="Schlitze des Wadengurts, unter dem oberen Rand",
)
STRAP = Measure(
    name="strap_mm",
    usual=45.0,
    within=Within(25, 50),
    en="Width of the strap",
    de="Gurtbreite",
)
STRAP_BACK = Measure(
    name="strap_back_mm",
    usual=15.0,
    within=Within(10, 30),
    en="Slots of the calf strap, behind the front edge",
    de="Schlitze des Wadengurts, hinter dem vorderen Rand",
)
CALF_STRAP = (STRAP_BELOW, STRAP, STRAP_BACK)


def calf_slots(front_deg: float) -> tuple[Slot, ...]:
    """Upright slots to both sides, the front corner's fall of the upper edge below it.

    Args:
        front_deg: Where the front edge of the calf stands.
    """
    return tuple(
        Slot(
            name=f"calf strap, {side}",
            at=TrimPoint(
                name=f"calf strap, {side}",
                at="fibula head",
                up_mm=("-below_fibula_mm", -10.0, "-strap_below_mm", "-0.5*strap_mm"),
                around_deg=sign * front_deg,
                round_mm=f"{'-' if sign < 0 else ''}strap_back_mm",
            ),
            length_mm=("strap_mm", 3.0),
            width_mm=5.0,
            strap="strap_mm",
            inside=(
                EdgeMargin(
                    edge="edge",
                    margin_mm="strap_below_mm",
                    away="down",
                    stretch=("top, medial", "top, lateral"),
                ),
                EdgeMargin(
                    edge="edge",
                    margin_mm="strap_back_mm",
                    away="round" if sign > 0 else "back",
                    stretch=("top, lateral", "ankle, lateral")
                    if sign > 0
                    else ("ankle, medial", "top, medial"),
                ),
            ),
        )
        for side, sign in (("lateral", 1.0), ("medial", -1.0))
    )


def _strap(name: str, en: str, de: str) -> Measure:
    return Measure(
        name=f"{name}_strap_mm",
        usual=38.0,
        within=Within(0, 50),
        en=f"Width of the {en} strap, 0 for none",
        de=f"Breite des {de}s, 0 für keinen",
    )


OPENING_STRAPS = (
    _strap("chest", "chest", "Brustgurt"),
    _strap("waist", "waist", "Taillengurt"),
    _strap("pelvis", "pelvic", "Beckengurt"),
    Measure(
        name="chest_strap_below_mm",
        usual=20.0,
        within=Within(10, 80),
        en="Slots of the chest strap, below the upper edge",
        de="Schlitze des Brustgurts, unter dem oberen Rand",
    ),
    Measure(
        name="waist_strap_up_mm",
        usual=0.0,
        within=Within(-40, 40),
        en="Middle of the waist strap, above the waist",
        de="Mitte des Taillengurts, über der Taille",
    ),
    Measure(
        name="pelvis_strap_above_mm",
        usual=20.0,
        within=Within(10, 80),
        en="Slots of the pelvic strap, above the lower edge",
        de="Schlitze des Beckengurts, über dem unteren Rand",
    ),
    Measure(
        name="slots_back_mm",
        usual=20.0,
        within=Within(12, 60),
        en="Slots of the straps, from the opening's edge",
        de="Schlitze der Gurte, vom Rand der Öffnung",
    ),
)


def opening_slots(
    around_deg: float, upper: TrimPoint, lower: TrimPoint, slit: Slit
) -> tuple[Slot, ...]:
    """Upright slots to both sides of a trunk's opening, for three straps.

    Args:
        around_deg: Where the opening is.
        upper: The edge over it, about whose height the chest strap is looked for.
        lower: The edge under it, likewise.
    """

    chest = (*terms_in(upper.up_mm), "-chest_strap_below_mm", "-0.5*chest_strap_mm")
    pelvis = (*terms_in(lower.up_mm), "pelvis_strap_above_mm", "0.5*pelvis_strap_mm")
    waist = TrimPoint(
        name="", at="right waist", towards="left waist", share=0.5, up_mm="waist_strap_up_mm"
    )
    below = EdgeMargin(edge="upper edge", margin_mm="chest_strap_below_mm", away="down")
    above = EdgeMargin(edge="lower edge", margin_mm="pelvis_strap_above_mm", away="up")
    places = (
        ("chest", replace(upper, up_mm=chest), (below,), ""),
        ("waist", waist, (), "waist_strap_up_mm"),
        ("pelvis", replace(lower, up_mm=pelvis), (above,), ""),
    )
    return tuple(
        Slot(
            name=f"{name} strap, {side}",
            at=replace(
                place,
                name=f"{name} strap, {side}",
                around_deg=around_deg,
                round_mm=tuple(
                    f"{sign}{term}"
                    for term in (
                        *(f"0.5*{one}" for one in terms_in(slit.width_mm)),
                        "slots_back_mm",
                    )
                ),
            ),
            length_mm=(f"{name}_strap_mm", 3.0),
            width_mm=5.0,
            strap=f"{name}_strap_mm",
            asked=f"{name}_strap_mm",
            inside=(
                *inside,
                EdgeMargin(
                    edge=slit.name, margin_mm="slots_back_mm", away="back" if sign else "round"
                ),
            ),
            yields=yields,
        )
        for name, place, inside, yields in places
        for side, sign in _SIDES[around_deg > 90]
    )


_SIDES = ((("right", ""), ("left", "-")), (("left", ""), ("right", "-")))
"""Angles grow from the front to the patient's right: behind, onwards to the left."""
