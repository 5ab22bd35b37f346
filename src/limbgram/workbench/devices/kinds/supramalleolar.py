"""Supramalleolar orthosis."""

from limbgram.workbench.devices.device import ORTHOSIS, Device
from limbgram.workbench.devices.presets.ankle import SUPRAMALLEOLAR
from limbgram.workbench.devices.presets.labels import UNDER_SOLE

DEVICE = Device(
    name="smo",
    kind="foot",
    order=6,
    en="Supramalleolar orthosis",
    de="Supramalleoläre Orthese",
    trim=SUPRAMALLEOLAR,
    label=UNDER_SOLE,
    wall=ORTHOSIS,
)
