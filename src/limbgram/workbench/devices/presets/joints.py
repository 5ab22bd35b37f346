"""Joints at the ankle: a seat on each side, drilled along the axis between the malleoli."""

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


def joint_seats(up_mm: Amount) -> tuple[Seat, ...]:
    """So far over or under both malleoli."""
    return tuple(
        Seat(
            name=f"joint, {side}",
            at=TrimPoint(name=f"joint, {side}", at=f"{side} malleolus", up_mm=up_mm, seen=side),
            axis=("medial malleolus", "lateral malleolus"),
            radius_mm=8.0,
            rise_mm=1.5,
            hole_mm="joint_hole_mm",
        )
        for side in ("lateral", "medial")
    )
