"""Solid ankle-foot orthosis."""

from limbgram.workbench.devices.device import ORTHOSIS, Device
from limbgram.workbench.devices.presets.ankle import SOLID
from limbgram.workbench.devices.presets.labels import BEHIND_CALF
from limbgram.workbench.devices.presets.ribs import ANKLE_RIBS, RIB
from limbgram.workbench.devices.presets.straps import CALF_STRAP, calf_slots

DEVICE = Device(
    name="solid-afo",
    kind="foot",
    order=1,
    en="Solid ankle-foot orthosis",
    de="Starre Unterschenkelorthese",
    trim=SOLID,
    label=BEHIND_CALF,
    wall=ORTHOSIS,
    slots=calf_slots(72.0),
    ridges=ANKLE_RIBS,
    more=(*CALF_STRAP, RIB),
)
