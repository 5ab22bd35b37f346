"""Thoracolumbosacral orthosis, opening behind."""

from limbgram.workbench.devices.device import ORTHOSIS, Device, Slit
from limbgram.workbench.devices.presets.spine import GAP, THORACOLUMBOSACRAL

DEVICE = Device(
    name="tlso-back",
    kind="torso",
    order=11,
    en="Thoracolumbosacral orthosis, opening behind",
    de="Rumpforthese, hinten offen",
    trim=THORACOLUMBOSACRAL,
    wall=ORTHOSIS,
    slits=(Slit(side="posterior", width_mm="gap_mm"),),
    more=(GAP,),
)
