"""UCBL."""

from limbgram.workbench.devices.device import ORTHOSIS, Device
from limbgram.workbench.devices.presets.ankle import UCBL

DEVICE = Device(
    name="ucbl",
    kind="foot",
    order=7,
    en="UCBL",
    de="UCBL-Orthese",
    trim=UCBL,
    wall=ORTHOSIS,
)
