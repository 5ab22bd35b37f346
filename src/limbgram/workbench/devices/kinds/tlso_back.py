"""Thoracolumbosacral orthosis, opening behind."""

from limbgram.workbench.devices.device import ORTHOSIS, Device, Slit
from limbgram.workbench.devices.presets.labels import BESIDE_WAIST
from limbgram.workbench.devices.presets.spine import (
    BACK_BOTTOM,
    BACK_TOP,
    GAP,
    THORACOLUMBOSACRAL,
    VENTILATION,
    VENTS,
)
from limbgram.workbench.devices.presets.straps import OPENING_STRAPS, opening_slots

_SLIT = Slit(side="posterior", width_mm=GAP.name)
DEVICE = Device(
    name="tlso-back",
    kind="torso",
    order=11,
    en="Thoracolumbosacral orthosis, opening behind",
    de="Rumpforthese, hinten offen",
    trim=THORACOLUMBOSACRAL,
    label=BESIDE_WAIST,
    wall=ORTHOSIS,
    slots=(*opening_slots(180.0, BACK_TOP, BACK_BOTTOM, _SLIT), *VENTS),
    slits=(_SLIT,),
    more=(GAP, *OPENING_STRAPS, *VENTILATION),
)
