"""Joints at the ankle: a seat on each side, drilled along the axis between the malleoli; and a seat
behind, for a stop between calf and foot part."""

from limbgram.core.request_fields import Within
from limbgram.workbench.devices.device import Seat
from limbgram.workbench.devices.trims import Amount, Measure, TrimPoint

JOINT_HOLE = Measure(
    name="joint_hole_mm",
    usual=5.0,
    within=Within(3, 8),
    en="Hole for the screw of the joint",
    de="Bohrung für die Gelenkschraube",
)
STOP_HOLE = Measure(
    name="stop_hole_mm",
    usual=0.0,
    within=Within(0, 8),
    en="Hole of a seat behind, for a stop between both parts; 0 for no seat",
    de="Bohrung eines Sitzes hinten, für einen Anschlag zwischen beiden Teilen; 0 für keinen Sitz",
)


def stop_seat(up_mm: Amount) -> Seat:
    """Behind, in the middle, so far over the lateral malleolus."""
    return Seat(
        name="stop",
        at=TrimPoint(name="stop", at="lateral malleolus", up_mm=up_mm, around_deg=180.0),
        axis=("second toe", "heel"),
        radius_mm=8.0,
        rise_mm=1.5,
        hole_mm="stop_hole_mm",
    )


def joint_seats(up_mm: Amount) -> tuple[Seat, ...]:
    """So far over or under both malleoli."""
    return tuple(
        Seat(
            name=f"joint, {side}",
            at=TrimPoint(
                name=f"joint, {side}", at=f"{side} malleolus", up_mm=up_mm, seen_from=side
            ),
            axis=("medial malleolus", "lateral malleolus"),
            radius_mm=8.0,
            rise_mm=1.5,
            hole_mm="joint_hole_mm",
        )
        for side in ("lateral", "medial")
    )
