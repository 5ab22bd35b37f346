"""Thoracolumbosacral orthosis, opening in front."""

from limbgram.workbench.devices.device import ORTHOSIS, Device, Slit
from limbgram.workbench.devices.presets.labels import BESIDE_WAIST
from limbgram.workbench.devices.presets.spine import GAP, THORACOLUMBOSACRAL, VENTILATION, VENTS

DEVICE = Device(
    name="tlso-front",
    kind="torso",
    order=10,
    en="Thoracolumbosacral orthosis, opening in front",
    de="Rumpforthese, vorn offen",
    trim=THORACOLUMBOSACRAL,
    label=BESIDE_WAIST,
    wall=ORTHOSIS,
    slots=VENTS,
    slits=(Slit(side="anterior", width_mm="gap_mm"),),
    more=(GAP, *VENTILATION),
)
