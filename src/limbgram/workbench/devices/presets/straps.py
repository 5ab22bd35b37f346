"""Straps: pairs of slots near the front edge of an orthosis of the leg."""

from limbgram.core.request_fields import Within
from limbgram.workbench.devices.device import Slot
from limbgram.workbench.devices.trims import Measure, TrimPoint

STRAP_BELOW = Measure(
    name="strap_below_mm",
    usual=20.0,
    within=Within(15, 25),
    en="Calf strap, below the upper edge",
    de="Wadengurt, unter dem oberen Rand",
)
STRAP = Measure(
    name="strap_mm",
    usual=45.0,
    within=Within(25, 50),
    en="Width of the strap",
    de="Gurtbreite",
)
CALF_STRAP = (STRAP_BELOW, STRAP)


def calf_slots(around_deg: float) -> tuple[Slot, ...]:
    """Upright slots to both sides, the front corner's fall of the upper edge below it."""
    return tuple(
        Slot(
            name=f"calf strap, {side}",
            at=TrimPoint(
                name=f"calf strap, {side}",
                at="fibula head",
                up_mm=("-below_fibula_mm", -10.0, "-strap_below_mm", "-0.5*strap_mm"),
                around_deg=sign * around_deg,
            ),
            length_mm=("strap_mm", 3.0),
            width_mm=5.0,
        )
        for side, sign in (("lateral", 1.0), ("medial", -1.0))
    )
