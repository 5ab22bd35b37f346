"""Thoracolumbosacral orthosis, opening in front."""

from limbgram.workbench.devices.device import ORTHOSIS, Device, Slit
from limbgram.workbench.devices.presets.labels import BESIDE_WAIST
from limbgram.workbench.devices.presets.spine import (
    FRONT_BOTTOM,
    FRONT_TOP,
    GAP,
    THORACOLUMBOSACRAL,
    VENTILATION,
    VENTS,
)
from limbgram.workbench.devices.presets.straps import OPENING_STRAPS, opening_slots

_SLIT = Slit(side="anterior", width_mm=GAP.name)
DEVICE = Device(
    name="tlso-front",
    kind="torso",
    order=10,
    en="Thoracolumbosacral orthosis, opening in front",
    de="Rumpforthese, vorn offen",
    trim=THORACOLUMBOSACRAL,
    label=BESIDE_WAIST,
    wall=ORTHOSIS,
    slots=(*opening_slots(0.0, FRONT_TOP, FRONT_BOTTOM, _SLIT), *VENTS),
    slits=(_SLIT,),
    more=(GAP, *OPENING_STRAPS, *VENTILATION),
)
