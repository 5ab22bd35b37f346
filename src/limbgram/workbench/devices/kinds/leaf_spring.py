"""Posterior leaf spring."""

from limbgram.workbench.devices.device import ORTHOSIS, Device
from limbgram.workbench.devices.presets.ankle import LEAF_SPRING
from limbgram.workbench.devices.presets.labels import BEHIND_CALF
from limbgram.workbench.devices.presets.straps import CALF_STRAP, calf_slots

DEVICE = Device(
    name="posterior-leaf-spring",
    kind="foot",
    order=2,
    en="Posterior leaf spring",
    de="Dorsale Federorthese",
    trim=LEAF_SPRING,
    label=BEHIND_CALF,
    wall=ORTHOSIS,
    slots=calf_slots(90.0),
    more=CALF_STRAP,
)
