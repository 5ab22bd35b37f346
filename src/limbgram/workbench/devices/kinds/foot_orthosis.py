"""Foot orthosis."""

from limbgram.workbench.devices.device import ORTHOSIS, Device
from limbgram.workbench.devices.presets.ankle import INSOLE

DEVICE = Device(
    name="foot-orthosis",
    kind="foot",
    order=8,
    en="Foot orthosis",
    de="Fußorthese (Einlage)",
    trim=INSOLE,
    wall=ORTHOSIS,
)
