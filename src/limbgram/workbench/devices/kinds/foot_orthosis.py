"""Foot orthosis."""

from limbgram.workbench.devices.device import ORTHOSIS, Device
from limbgram.workbench.devices.presets.ankle import INSOLE
from limbgram.workbench.devices.presets.labels import UNDER_SOLE

DEVICE = Device(
    name="foot-orthosis",
    kind="foot",
    order=8,
    en="Foot orthosis",
    de="Fußorthese (Einlage)",
    trim=INSOLE,
    label=UNDER_SOLE,
    wall=ORTHOSIS,
)
