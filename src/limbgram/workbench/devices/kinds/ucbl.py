"""UCBL."""

from limbgram.workbench.devices.device import ORTHOSIS, Device
from limbgram.workbench.devices.presets.ankle import UCBL
from limbgram.workbench.devices.presets.labels import UNDER_SOLE

DEVICE = Device(
    name="ucbl",
    kind="foot",
    order=7,
    en="UCBL",
    de="UCBL-Orthese",
    trim=UCBL,
    label=UNDER_SOLE,
    wall=ORTHOSIS,
)
