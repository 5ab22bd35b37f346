"""Hinged ankle-foot orthosis, foot part."""

from limbgram.workbench.devices.device import ORTHOSIS, Device
from limbgram.workbench.devices.presets.ankle import HINGED_FOOT
from limbgram.workbench.devices.presets.joints import (
    JOINT_HOLE,
    STOP_HOLE,
    joint_seats,
    stop_seat,
)
from limbgram.workbench.devices.presets.labels import UNDER_SOLE

DEVICE = Device(
    name="hinged-afo-foot",
    kind="foot",
    order=4,
    en="Hinged ankle-foot orthosis, foot part",
    de="Unterschenkelorthese mit Gelenk, Fußteil",
    trim=HINGED_FOOT,
    label=UNDER_SOLE,
    wall=ORTHOSIS,
    seats=(*joint_seats(("-joint_gap_mm", -14.0)), stop_seat(-36.0)),
    more=(JOINT_HOLE, STOP_HOLE),
)
