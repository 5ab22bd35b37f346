"""Ribs: strips beside the ankle that stiffen a printed orthosis, from the heel up to the calf."""

from limbgram.core.request_fields import Within
from limbgram.workbench.devices.device import Ridge
from limbgram.workbench.devices.trims import Measure, TrimPoint

RIB = Measure(
    name="rib_mm",
    usual=0.0,
    within=Within(0, 5),
    en="Ribs behind the malleoli, on the wall; 0 for none",
    de="Rippen hinter den Knöcheln, auf der Wand; 0 für keine",
)


def _rib(side: str) -> Ridge:
    return Ridge(
        name=f"rib, {side}",
        through=(
            TrimPoint(
                name="rib, low",
                at=f"{side} malleolus",
                towards="heel",
                share=0.4,
                seen_from="lateral" if side == "lateral" else "medial",
            ),
            TrimPoint(
                name="rib, high",
                at=f"{side} malleolus",
                towards="fibula head",
                share=0.3,
                around_deg=115.0 if side == "lateral" else -115.0,
            ),
        ),
        width_mm=12.0,
        falloff_mm=8.0,
        add_mm="rib_mm",
    )


ANKLE_RIBS = (_rib("lateral"), _rib("medial"))
