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
STRAP_BACK = Measure(
    name="strap_back_mm",
    usual=15.0,
    within=Within(10, 30),
    en="Slots of the strap, round the calf behind the front edge",
    de="Schlitze des Gurts, um die Wade hinter dem vorderen Rand",
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
        )
        for side, sign in (("lateral", 1.0), ("medial", -1.0))
    )
