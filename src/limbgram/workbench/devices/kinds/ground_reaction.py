"""Ground reaction ankle-foot orthosis."""

from limbgram.workbench.devices.device import ORTHOSIS, Device
from limbgram.workbench.devices.presets.ankle import GROUND_REACTION
from limbgram.workbench.devices.presets.labels import FRONT_OF_SHIN
from limbgram.workbench.devices.presets.ribs import ANKLE_RIBS, RIB

DEVICE = Device(
    name="ground-reaction-afo",
    kind="foot",
    order=5,
    en="Ground reaction ankle-foot orthosis",
    de="Unterschenkelorthese mit ventraler Anlage",
    trim=GROUND_REACTION,
    label=FRONT_OF_SHIN,
    wall=ORTHOSIS,
    ridges=ANKLE_RIBS,
    more=(RIB,),
)
