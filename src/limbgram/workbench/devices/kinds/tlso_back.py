"""Thoracolumbosacral orthosis, opening behind."""

from limbgram.workbench.devices.device import ORTHOSIS, Device, Slit
from limbgram.workbench.devices.presets.labels import BESIDE_WAIST
from limbgram.workbench.devices.presets.spine import GAP, THORACOLUMBOSACRAL, VENTILATION, VENTS

DEVICE = Device(
    name="tlso-back",
    kind="torso",
    order=11,
    en="Thoracolumbosacral orthosis, opening behind",
    de="Rumpforthese, hinten offen",
    trim=THORACOLUMBOSACRAL,
    label=BESIDE_WAIST,
    wall=ORTHOSIS,
    slots=VENTS,
    slits=(Slit(side="posterior", width_mm="gap_mm"),),
    more=(GAP, *VENTILATION),
)
