"""Hinged ankle-foot orthosis, calf part."""

from limbgram.workbench.devices.device import ORTHOSIS, Device
from limbgram.workbench.devices.presets.ankle import HINGED_CALF
from limbgram.workbench.devices.presets.joints import (
    JOINT_HOLE,
    STOP_HOLE,
    joint_seats,
    stop_seat,
)
from limbgram.workbench.devices.presets.labels import BEHIND_CALF
from limbgram.workbench.devices.presets.straps import CALF_STRAP, calf_slots

DEVICE = Device(
    name="hinged-afo-calf",
    kind="foot",
    order=3,
    en="Hinged ankle-foot orthosis, calf part",
    de="Unterschenkelorthese mit Gelenk, Wadenteil",
    trim=HINGED_CALF,
    label=BEHIND_CALF,
    wall=ORTHOSIS,
    slots=calf_slots(72.0),
    seats=(*joint_seats(("joint_gap_mm", 14.0)), stop_seat(("above_ankle_mm", 16.0))),
    more=(*CALF_STRAP, JOINT_HOLE, STOP_HOLE),
)
